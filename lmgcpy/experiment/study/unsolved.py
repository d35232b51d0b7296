"""Sentences of a report on the steps that were not solved to the tolerance, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Protocol

import numpy as np

from lmgcpy.solve.problems.report import SOLVED

CAUSES = {
    "budget spent": "ran out of sweeps",
    "stagnated": "stagnated, as further sweeps brought them no nearer",
    "locked": "are locked, as no motion is compatible with their constraints",
    "not finite": "broke off at numbers that are not finite",
}
"""Ends of a solve in words."""


class SolvedRun(Protocol):
    """The record of a run of s steps."""

    @property
    def status(self) -> list[str]:
        """Status of the solver after each step."""
        ...

    @property
    def residual(self) -> np.ndarray:
        """Residual of the solver, (s,)."""
        ...


def unsolved_words(runs: Mapping[str, SolvedRun], *, tolerance: float, max_iterations: int) -> str:
    """Sentences on the unsolved steps of runs by name, their causes and their residuals; empty if all steps were solved.

    ``tolerance`` and ``max_iterations``: of the solver of the runs.
    """
    counts, causes, residuals = [], Counter[str](), []
    for name, run in runs.items():
        unsolved = np.array([word not in SOLVED for word in run.status], dtype=bool)
        if unsolved.any():
            counts.append(f"{name} {int(unsolved.sum())} of {len(unsolved)}")
            causes.update(word for word in run.status if word not in SOLVED)
            residuals.append(run.residual[unsolved])
    if not counts:
        return ""
    left = np.concatenate(residuals)
    why = ", ".join(f"{count} {CAUSES[word]}" for word, count in causes.most_common())
    remedy = ""
    if causes["budget spent"]:
        remedy = f" The solver has {max_iterations} sweeps for a step; with a larger max_iterations it solves more of them."
    within = int((left <= tolerance).sum())
    forces = f" {within} of them keep it, and miss the bound of forces or of displacements." if within else ""
    return (
        f"Steps that were not solved to the tolerance: {'; '.join(counts)}. Of these {why}. Half of them are left with a "
        f"residual of at most {np.median(left):.1e}, the worst with {left.max():.1e}; the tolerance is {tolerance:.0e}."
        f"{forces}{remedy}"
    )
