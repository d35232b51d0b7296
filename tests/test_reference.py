"""The reference of the documentation has every public name, and every public name says what it is."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import itertools
import re
import textwrap
from pathlib import Path

import pytest

import lmgcpy as lm
import lmgcpy.continuum
import lmgcpy.testing

PAGES = Path(__file__).parent.parent / "docs" / "reference"
DIRECTIVE = re.compile(r"^\.\. (?:auto(?:class|exception|function|data)|data):: ([\w.]+)", re.M)
FRONT = (lm, lm.laws, lm.sample, lm.measure, lm.io, lm.view, lm.contact, lm.testing, lmgcpy.continuum)
"""The front door and what is behind it; ``lm.io.fclib`` is a module without ``__all__``."""
ELSEWHERE = {"lmgcpy.laws.Law", "lmgcpy.laws.Parameter", "lmgcpy.laws.State"}
"""Second names: they are told of at the front door."""
COMPILED = {"prepare", "react", "slope", "energy", "initial", "commit", "conic", "resisted"}
"""Functions of laws, whose arguments are numbers and tuples of numbers: the page on laws and ``Law`` say which."""


def documented() -> list[str]:
    """Names that the pages of the reference tell of, with their modules."""
    return [name for page in sorted(PAGES.glob("*.rst")) for name in DIRECTIVE.findall(page.read_text())]


def public() -> list[str]:
    """Public names that are no modules, with the module they are reached by."""
    names = [f"{module.__name__}.{name}" for module in FRONT for name in module.__all__]
    names = [name for name in names if not inspect.ismodule(reached(name))]
    return [*names, "lmgcpy.io.fclib.read", "lmgcpy.io.fclib.write"]


def reached(name: str) -> object:
    """The object of a dotted name."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:cut]))
        except ImportError:
            continue
        for part in parts[cut:]:
            found = getattr(found, part)
        return found
    raise ImportError(name)


def test_no_public_name_is_missing_from_the_reference():
    assert set(public()) - set(documented()) - ELSEWHERE == set()


def test_every_name_in_the_reference_is_there_and_once():
    names = documented()
    assert len(names) == len(set(names))
    for name in names:
        reached(name)


def test_every_page_of_the_reference_is_in_its_index():
    listed = re.findall(r"^   (\w+)$", (PAGES / "index.rst").read_text(), re.M)
    assert sorted([*listed, "index"]) == sorted(page.stem for page in PAGES.glob("*.rst"))


def members(kind: type) -> dict[str, object]:
    """Public members that lmgcpy gives a class, by name."""
    ours = [base for base in kind.__mro__ if base.__module__.startswith("lmgcpy")]
    names = {name for base in ours for name in vars(base) if not name.startswith("_")}
    return {name: inspect.getattr_static(kind, name) for name in sorted(names)}


def spoken_for(name: str) -> list[tuple[str, object]]:
    """A public name and, of a class, its methods and properties: what needs a docstring."""
    thing = reached(name)
    if not inspect.isclass(thing):
        return [(name, thing)] if callable(thing) else []
    functions = (staticmethod, classmethod, property)
    return [(name, thing)] + [
        (f"{name}.{word}", member)
        for word, member in members(thing).items()
        if isinstance(member, functions) or inspect.isfunction(member)
    ]


NAMES = sorted(set(documented()) - {"lmgcpy.laws.hook"})  # pluggy's own


@pytest.mark.parametrize("name", NAMES)
def test_docstrings(name):
    for what, member in spoken_for(name):
        word = what.rpartition(".")[2]
        if word in COMPILED and what != name:
            member = getattr(lm.Law, word) or lm.Law  # told of once, in Law
        elif isinstance(member, property) and what != name:
            member = getattr(reached(name), word)
        told = inspect.getdoc(member)
        assert told, f"{what} has no docstring"
        assert not told.startswith(f"{word}("), f"{what} has only the signature that dataclasses give"
        assert told.rstrip()[-1] in ".)]:`" or "\n" in told, f"the docstring of {what} is no sentence: {told}"


def fields_told_of(kind: type) -> set[str]:
    """Fields of a class that have a docstring of their own, or are named in that of the class or of one before it."""
    told: set[str] = set()
    for base in kind.__mro__:
        if not base.__module__.startswith("lmgcpy"):
            continue
        told |= set(re.findall(r"``(\w+)``", base.__doc__ or ""))
        (definition,) = ast.parse(textwrap.dedent(inspect.getsource(base))).body
        for field, next_line in itertools.pairwise(definition.body):
            if isinstance(field, ast.AnnAssign) and isinstance(next_line, ast.Expr):
                told.add(field.target.id)
    return told


PLAIN = {"law", "name", "property"}
"""Fields that say what they are."""


@pytest.mark.parametrize("name", [name for name in NAMES if dataclasses.is_dataclass(reached(name))])
def test_fields(name):
    kind = reached(name)
    names = {field.name for field in dataclasses.fields(kind)}
    assert names - fields_told_of(kind) - PLAIN == set()


@pytest.mark.parametrize("name", NAMES)
def test_type_hints(name):
    for what, member in spoken_for(name):
        word = what.rpartition(".")[2]
        if word in COMPILED and what != name:
            continue
        function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
        if inspect.isclass(function):
            function = inspect.unwrap(function.__init__)
            if not inspect.isfunction(function) or getattr(member, "_is_protocol", False):
                continue
        signature = inspect.signature(inspect.unwrap(function))
        bare = [
            p.name
            for p in signature.parameters.values()
            if p.annotation is p.empty and p.name not in ("self", "cls") and not p.name.startswith("_")
        ]
        assert not bare, f"{what} has no type hint for {', '.join(bare)}"
        constructor = getattr(function, "__name__", "") == "__init__"
        assert constructor or signature.return_annotation is not signature.empty, f"{what} has no type hint for its result"


@pytest.mark.parametrize(
    ("misspelt", "closest"),
    [
        (lambda: lm.Couloumb, "Coulomb"),
        (lambda: lm.io.exportcsv, "export_csv"),
        (lambda: lm.Parameter("m", minimun=0.0), "minimum"),
        (lambda: lm.State("m", txt="length"), "text"),
        (lambda: lm.Simulation(lm.Scene(dimension=2), time_step=1.0).restore(chekpoint=None), "checkpoint"),
        (lambda: lmgcpy.testing.report(lm.Signorini(), skp=["mirror"]), "skip"),
        (lambda: lmgcpy.testing.conformance(lm.Signorini(), skp=["mirror"]), "skip"),
    ],
)
def test_a_misspelt_name_gets_the_closest(misspelt, closest):
    """Beside those of tests/test_bad_arguments.py."""
    with pytest.raises((AttributeError, TypeError), match=f"did you mean '{closest}'\\? Known: "):
        misspelt()
