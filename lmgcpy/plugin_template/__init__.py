"""A template of a plug-in: the files of a distribution with one law."""

from __future__ import annotations

import keyword
import re
import shutil
from importlib.resources import files
from pathlib import Path
from string import Template

import lmgcpy
from lmgcpy import laws
from lmgcpy.writing import make_folder, write_text

KINDS = ("contact", "link")


def write_plugin(name: str, folder: Path, *, kind: str = "contact") -> list[Path]:
    """Write the distribution ``lmgcpy-law-<name>`` into ``folder``; returns its files.

    ``name`` is the name of the law: words of small letters and digits joined by hyphens. ``kind`` says whether the law
    applies to a contact or a link. The distribution can be installed and passes its own tests; its law is an example to be
    replaced. Raises ValueError for a name that is invalid or taken, and FileExistsError if the folder exists.
    """
    if kind not in KINDS:
        raise ValueError(f"kind must be {' or '.join(KINDS)}, got {kind!r}.")
    package = f"lmgcpy_law_{name.replace('-', '_')}"
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) or keyword.iskeyword(name):
        raise ValueError(f"A law's name is words of small letters and digits joined by hyphens, got {name!r}.")
    if name in laws.names():
        owner = laws.registrations()[name].distribution
        raise ValueError(f"There is a law '{name}' already, from {owner}: give yours another name.")
    target = folder / f"lmgcpy-law-{name}"
    if target.exists():
        raise FileExistsError(f"'{target}' exists: give another name, or another folder by --into.")
    if not folder.is_dir():
        raise FileNotFoundError(f"There is no folder '{folder}' to write '{target.name}' into: make it first.")
    words = {
        "name": name,
        "distribution": target.name,
        "package": package,
        "Class": "".join(word.capitalize() for word in name.split("-")),
        "version": ".".join(lmgcpy.__version__.split(".")[:2]),
    }
    written = []
    for source, where in (
        ("pyproject.txt", "pyproject.toml"),
        (f"readme_{kind}.txt", "README.md"),
        (f"law_{kind}.txt", f"src/{package}/__init__.py"),
        (f"test_{kind}.txt", f"tests/test_{name.replace('-', '_')}.py"),
    ):
        text = (files(__package__) / source).read_text(encoding="utf-8")
        path = target / where
        try:
            make_folder(path.parent)
            write_text(path, Template(text).substitute(words))
        except OSError:
            shutil.rmtree(target, ignore_errors=True)  # an incomplete folder would block the next try
            raise
        written.append(path)
    return written
