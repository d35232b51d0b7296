"""Distributions as Python sees them after an installation, without one: a folder on the path with metadata and modules."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def install(folder: Path, name: str, module: str, text: str | None = None, *, version: str = "1.2") -> Path:
    """Metadata of a distribution whose entry point is ``module``, and that module if its ``text`` is given."""
    about = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (about / "entry_points.txt").write_text(f"[lmgcpy]\n{name} = {module}\n")
    if text is not None:
        (folder / f"{module}.py").write_text(text)
    return folder


def environment(*folders: Path) -> dict[str, str]:
    """Of a child process that sees these folders as it sees site-packages."""
    path = os.pathsep.join([*map(str, folders), *(entry for entry in sys.path if entry)])
    return {**os.environ, "PYTHONPATH": path}
