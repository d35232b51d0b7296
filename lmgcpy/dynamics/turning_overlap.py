"""Overlap of contacts that turning made, taken back without energy if light bodies under heavy loads would make some.

Laws of contacts take back what turning closed in the last step (``laws/signorini.py``), with the work ``r (e' - e)/(2 h)``.
In a steady motion this work is zero. But if a heavy body comes down on a light one that went fast along a curved path, r
bears the heavy body while e is still due to the motion of the light one. Then the step is solved a second time, for the
velocities, as if nothing had turned, and bodies move by the first solve, as for links
(:mod:`lmgcpy.dynamics.turning_stretch`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lmgcpy.dynamics.step_problem import StepProblem

MADE = 0.01
"""Part of the kinetic energy, and of what loads give from rest, that contacts may make in a step by taking back overlap."""


def take_back(
    given: StepProblem, solved: StepProblem, before: np.ndarray, solve: Callable[[StepProblem], StepProblem]
) -> tuple[StepProblem, np.ndarray | None]:
    """The problem that gives the velocities of the step; and the impulses of the first solve minus the impulses of the
    second (m, d), or None if the step was solved once.

    ``given``: the problem as it was assembled; ``before``: velocities at the start of the step (n, k); ``solved`` and the
    problem that ``solve`` returns have the velocities ``after``.
    """
    data = solved.data
    turned = (data.gap < data.reference_gap) & given.keeps_gap
    work = 0.5 * float((solved.system.impulse[:, 0] * (data.before[:, 0] + data.after[:, 0])).sum(where=turned))
    if work <= 0.0:
        return solved, None
    loads, free = given.free_velocity - before, given.inverse_mass > 0.0
    doubled = np.divide(before * before + loads * loads, given.inverse_mass, out=np.zeros_like(before), where=free)
    if work <= MADE * 0.5 * float(doubled.sum()):
        return solved, None
    first = solved.system.impulse.copy()
    reference = np.where(turned, given.data.gap, given.data.reference_gap)
    again = replace(given, data=given.data._replace(reference_gap=reference))
    again.prepare()
    solved = solve(again)
    return solved, first - solved.system.impulse
