"""Cases of the benchmark: problems with a name and a family."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lmgcpy.io import fclib
from lmgcpy.solve.problems.problem import Problem


@dataclass(frozen=True)
class Case:
    """A problem that every solver is to solve."""

    name: str
    family: str
    problem: Problem
    exact: np.ndarray | None = None
    """Impulses (m, d) [N s] in extended precision; None if they are not known."""

    @property
    def interactions(self) -> int:
        return len(self.problem.mu)


def from_folder(folder: Path) -> Iterator[Case]:
    """The FCLIB problems of a folder and its subfolders in alphabetic order; the name of the folder is the family.

    Raises FileNotFoundError if the folder is missing or has no problem, and the errors of ``lmgcpy.io.fclib.read``.
    """
    if not folder.is_dir():
        raise FileNotFoundError(f"There is no folder '{folder}' with problems to solve.")
    files = sorted(path for kind in ("*.h5", "*.hdf5") for path in folder.rglob(kind))
    if not files:
        raise FileNotFoundError(f"There is no problem in the folder '{folder}': no file ends in .h5 or .hdf5.")
    for file in files:
        yield Case(file.stem, file.parent.resolve().name, fclib.read(file))
