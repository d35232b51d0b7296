"""Every Python block of the documentation runs as it stands, and says what the page says it says."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

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


@pytest.mark.parametrize("block", BLOCKS)
def test_block_runs(block, tmp_path):
    done = subprocess.run([sys.executable, "-W", "error", "-c", block], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_ball_of_the_laws_page_hangs():
    block = next(b.values[0] for b in BLOCKS if "Adhesive" in b.values[0])
    done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True)
    assert float(done.stdout) == pytest.approx(-0.1, abs=1e-12)


def test_links_between_pages_lead_somewhere():
    for page in [*DOCS.glob("*.md"), DOCS.parent / "README.md"]:
        for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"
