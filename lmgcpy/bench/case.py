"""What is solved: problems with a name and a family, read from folders or made on the spot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lmgcpy.io import fclib
from lmgcpy.solve.problem import Problem


@dataclass(frozen=True)
class Case:
    """A problem to be solved by every solver."""

    name: str
    family: str
    problem: Problem
    exact: np.ndarray | None = None
    """Impulses (m, d) [N s] by arithmetic of extended precision, where there are any."""

    @property
    def interactions(self) -> int:
        return len(self.problem.mu)


def from_folder(folder: Path) -> Iterator[Case]:
    """The FCLIB problems of a folder and of the folders in it, in alphabetic order; the family is the folder's name.

    Raises FileNotFoundError where there is no such folder or no problem in it, and what ``lmgcpy.io.fclib.read`` raises.
    """
    if not folder.is_dir():
        raise FileNotFoundError(f"There is no folder '{folder}' with problems to solve.")
    files = sorted(path for kind in ("*.h5", "*.hdf5") for path in folder.rglob(kind))
    if not files:
        raise FileNotFoundError(f"There is no problem in the folder '{folder}': no file ends in .h5 or .hdf5.")
    for file in files:
        yield Case(file.stem, file.parent.resolve().name, fclib.read(file))
