"""Examples: short scripts that print what they find beside what is known beforehand.

Each is a script of this folder, which a user may copy: it needs nothing but ``import lmgcpy``. The first line of its
docstring says what it is, and the others where the known value comes from.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

from lmgcpy.errors import closest
from lmgcpy.writing import make_folder, write_text

SIZE = (400, 340)
"""Greatest width and height of a picture [pixels]."""


@dataclass(frozen=True)
class Example:
    """A script by its ``name`` of words joined by hyphens; ``picture``: options of ``lmgcpy.view.render``, or None if the
    script leaves nothing to draw."""

    name: str
    picture: Mapping[str, Any] | None = field(default_factory=dict)

    @property
    def file(self) -> str:
        """Name of the script."""
        return f"{self.name.replace('-', '_')}.py"

    @property
    def script(self) -> str:
        """Text of the script."""
        return (files(__package__) / self.file).read_text(encoding="utf-8")

    @property
    def line(self) -> str:
        """What the example is, in one line."""
        return (ast.get_docstring(ast.parse(self.script)) or "").splitlines()[0]


GROUPS: dict[str, tuple[Example, ...]] = {
    "Geotechnical tests": (
        Example("oedometer", {"what": "forces", "force": 500.0}),
        Example("direct-shear", {"what": "forces"}),
        Example("simple-shear"),
        Example("pull-out", {"what": "forces"}),
        Example("triaxial", {"grains": "plain"}),
        Example("biaxial", {"what": "forces"}),
        Example("latex", {"grains": "plain"}),
        Example("angle-of-repose"),
        Example("silo", {"what": "forces"}),
    ),
    "Machines and flows": (
        Example("drum"),
        Example("blades"),
        Example("hopper"),
        Example("hourglass"),
    ),
    "Threads, nets and membranes": (
        Example("thread", {"what": "forces"}),
        Example("geogrid", {"what": "forces"}),
        Example("capstan", {"what": "forces", "force": 50.0}),
        Example("helix", {"what": "forces", "force": 50.0, "region": ((-0.15, -0.15, -0.05), (0.15, 0.15, 0.4))}),
        Example("sag", None),
        Example("net", {"grains": "plain", "wires": "tension"}),
        Example("rockfall", None),
        Example("membrane", {"grains": "hidden"}),
    ),
    "Samples and cells": (
        Example("pressure", {"what": "forces"}),
        Example("cell", {"what": "forces"}),
        Example("clusters"),
        Example("again"),
        Example("sweep", None),
    ),
    "Contactors, laws and programs of your own": (
        Example("plank", {"grains": "plain"}),
        Example("weakening", None),
        Example("controller", None),
    ),
}
"""All examples, in the order in which they are listed."""

EXAMPLES = {example.name: example for group in GROUPS.values() for example in group}


def named(name: str) -> Example:
    """The example of that name; raises LookupError with the known ones."""
    if name not in EXAMPLES:
        raise LookupError(f"There is no example '{name}'{closest(name, EXAMPLES)}")
    return EXAMPLES[name]


def run(example: Example, folder: Path) -> Path | None:
    """Run an example in a folder of its own, which it makes: its script, the files that it writes, and its picture.

    Returns the path of the picture, or None if there is nothing to draw. Raises FileExistsError if the folder exists, and
    ImportError, after the script has run, if pyvista is missing.
    """
    if folder.exists():
        raise FileExistsError(f"'{folder}' exists: remove it, or name another folder by --out.")
    script = make_folder(folder).resolve() / example.file
    write_text(script, example.script)
    left: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    with contextlib.chdir(folder):
        exec(compile(example.script, str(script), "exec"), left)
    if example.picture is None:
        return None
    from lmgcpy.view import render

    return render(left["sim"], script.with_suffix(".png"), size=SIZE, **example.picture)
