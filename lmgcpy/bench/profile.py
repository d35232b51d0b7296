"""Performance profiles (Dolan, More 2002, Math. Program. 91): on how many problems a solver is how near to the fastest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lmgcpy.bench.frontier import Judged

SMALLEST = 20
"""Problems with fewer interactions tell the time of a function call, and are left out."""

OVERHEAD = 1e-3
"""Times count as this at least [s]: what is less is mostly that of calling a solver from Python."""


@dataclass(frozen=True)
class Profile:
    """Ratios of time to a true error, by solver."""

    target: float
    """Error that had to be reached."""
    ratios: dict[str, np.ndarray]
    """Of each solver, time over that of the fastest, (problems,) ascending; infinite where the error was not reached."""
    unsolved: int
    """Problems left out because no solver got there."""

    @property
    def problems(self) -> int:
        return len(next(iter(self.ratios.values()))) if self.ratios else 0

    def failures(self, solver: str) -> int:
        """Problems on which a solver did not reach the error, and another one did."""
        return int(np.isinf(self.ratios[solver]).sum())

    def share(self, solver: str, ratio: float) -> float:
        """Part of the problems on which a solver takes at most ``ratio`` times the time of the fastest."""
        return float(np.searchsorted(self.ratios[solver], ratio, side="right")) / max(self.problems, 1)


def profile(judged: Sequence[Judged], solvers: Sequence[str], target: float) -> Profile:
    """The profile over the problems of :data:`SMALLEST` interactions or more whose references tell such an error."""
    rows, unsolved = [], 0
    for problem in judged:
        if problem.interactions < SMALLEST or problem.reference.floor > target:
            continue
        best = [problem.best(solver, target) for solver in solvers]
        times = np.array([np.inf if run is None else max(run.seconds, OVERHEAD) for run in best])
        if np.isinf(times).all():
            unsolved += 1
        else:
            rows.append(times / times.min())
    table = np.array(rows).reshape(-1, len(solvers))
    return Profile(target, {solver: np.sort(table[:, k]) for k, solver in enumerate(solvers)}, unsolved)
