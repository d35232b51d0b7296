"""Performance profiles (Dolan, More 2002, Math. Program. 91): shares of problems by the time relative to the fastest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lmgcpy.bench.frontier import Judged

SMALLEST = 20
"""Smallest number of interactions of a problem; on smaller ones the time of the function call dominates."""

OVERHEAD = 1e-3
"""Smallest time that counts [s]; shorter times are mostly the time of a call from Python."""


@dataclass(frozen=True)
class Profile:
    """Ratios of time to a true error, by solver."""

    target: float
    """Error to be reached."""
    ratios: dict[str, np.ndarray]
    """For each solver its time divided by the fastest time, (problems,) ascending; infinite if it missed the error."""
    unsolved: int
    """Number of problems that no solver solved to the error; they are left out."""

    @property
    def problems(self) -> int:
        return len(next(iter(self.ratios.values()))) if self.ratios else 0

    def failures(self, solver: str) -> int:
        """Number of problems on which a solver did not reach the error but another one did."""
        return int(np.isinf(self.ratios[solver]).sum())

    def share(self, solver: str, ratio: float) -> float:
        """Share of the problems on which a solver takes at most ``ratio`` times the time of the fastest."""
        return float(np.searchsorted(self.ratios[solver], ratio, side="right")) / max(self.problems, 1)


def profile(judged: Sequence[Judged], solvers: Sequence[str], target: float) -> Profile:
    """The profile over the problems with :data:`SMALLEST` interactions or more whose references can judge the error."""
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
