"""Every Python block of the documentation runs as it stands, and says what the page says it says."""

import inspect
import re
import textwrap
from itertools import takewhile
from pathlib import Path

import pytest
from forks import forked

import lmgcpy as lm

DOCS = Path(__file__).parent.parent / "docs"


def scripts(page):
    """The Python blocks of a page, each a script of its own unless the page says that they are one."""
    text = page.read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    return ["\n".join(blocks)] if "<!-- one script -->" in text else blocks


BLOCKS = [
    pytest.param(block, id=f"{page.stem}-{number}")
    for page in sorted(DOCS.glob("*.md"))
    for number, block in enumerate(scripts(page))
]


@pytest.mark.default_parameters("formats-0", "index-0", "laws-0")
@pytest.mark.parametrize("block", BLOCKS)
def test_block_runs(block, tmp_path):
    forked(block, folder=tmp_path)


def test_the_ball_of_the_laws_page_hangs():
    block = next(b.values[0] for b in BLOCKS if "Adhesive" in b.values[0])
    assert float(forked(block).stdout) == pytest.approx(-0.1, abs=1e-12)


def test_links_between_pages_lead_somewhere():
    for page in [*DOCS.glob("*.md"), DOCS.parent / "README.md"]:
        for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_every_file_that_a_page_names_is_there():
    """By its path, or by its name alone where the text says in which folder it is."""
    root = DOCS.parent
    folders = [root / name for name in ("lmgcpy", "tests", "benchmarks", "tutorials")]
    known = {path.name for folder in folders for path in folder.rglob("*.py")}
    for page in [*DOCS.glob("*.md"), root / "README.md"]:
        for name in set(re.findall(r"`([\w/]+\.py)`", page.read_text())):
            there = name in known or any((root / start / name).exists() for start in ("", "lmgcpy"))
            if name.startswith("src/"):  # of the plug-in that a page begins
                continue
            assert there, f"{page.name} names {name}"


def test_every_name_that_a_page_gives_is_there():
    """As ``lm.measure.stress`` in the text; what belongs to objects, as ``sim.report``, is in the blocks that run."""
    for page in [*DOCS.glob("*.md"), DOCS.parent / "README.md"]:
        for name in set(re.findall(r"\blm((?:\.\w+)+)", page.read_text())):
            found = lm
            for part in name[1:].split("."):
                assert hasattr(found, part), f"{page.name}: lm{name}"
                found = getattr(found, part)


def test_every_page_is_in_the_index():
    """In its text, for who reads it where it lies, and in the contents of the site."""
    index = (DOCS / "index.md").read_text()
    trees = index + (DOCS / "tutorials.md").read_text()
    contents = re.findall(r"^([\w/]+)$", "".join(re.findall(r"```{toctree}\n(.*?)```", trees, re.S)), re.M)
    pages = sorted(page.stem for page in DOCS.glob("*.md") if page.stem != "index")
    assert sorted(contents) == sorted([*pages, "reference/index"])
    for page in pages:
        assert f"]({page}.md)" in index, f"{page}.md"


def test_no_cell_of_a_table_is_cut_by_a_bar():
    """A bar ends a cell, in code as well: formulas of complementarity have the sign for perpendicular."""
    rows = [
        (page.name, row) for page in DOCS.glob("*.md") for row in page.read_text("utf-8").splitlines() if row[:1] == "|"
    ]
    assert [(name, code) for name, row in rows for code in row.split("`")[1::2] if "|" in code.replace("\\|", "")] == []


WIDEST = 88
"""Columns of code on a page of the site, beyond which a reader has to scroll."""


def code(text):
    """Fenced and indented lines of a page; formulas are typeset, and not shown as they stand."""
    inside = False
    for line in re.sub(r"```math\n.*?```", "", text, flags=re.S).splitlines():
        if line.lstrip().startswith("```"):
            inside = not inside
        elif inside or line.startswith("    "):
            yield line


def test_code_fits_on_a_page():
    pages = [*DOCS.glob("*.md"), DOCS.parent / "README.md"]
    shown = [(page.name, line) for page in pages for line in code(page.read_text("utf-8"))]
    scripts = [*(DOCS.parent / "tutorials").glob("*.py"), *(DOCS.parent / "lmgcpy" / "examples").glob("[!_]*.py")]
    shown += [(path.name, line) for path in scripts for line in path.read_text("utf-8").splitlines()]
    assert len(shown) > 1000
    assert [(name, line) for name, line in shown if len(line) > WIDEST] == []


SIGNATURE = 80
"""Columns of code in a docstring, which stands further in on its page of the reference."""


def literal_blocks(docstring):
    """Lines of the blocks after "::" in a docstring, without what they are indented by."""
    lines, blocks = inspect.cleandoc(docstring).splitlines(), []
    for at, line in enumerate(lines):
        if line.rstrip().endswith("::"):
            edge = len(line) - len(line.lstrip())
            inside = takewhile(lambda text, edge=edge: not text or text[: edge + 1].isspace(), lines[at + 1 :])
            blocks += textwrap.dedent("\n".join(inside)).splitlines()
    return blocks


def test_code_in_docstrings_fits_on_a_page():
    sources = {path.name: path.read_text("utf-8") for path in (DOCS.parent / "lmgcpy").rglob("*.py")}
    strings = [(name, text) for name, source in sources.items() for text in re.findall(r'"""(.*?)"""', source, re.S)]
    shown = [(name, line) for name, text in strings for line in literal_blocks(text)]
    assert len(shown) > 40
    assert [(name, line) for name, line in shown if len(line) > SIGNATURE] == []
