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

from lmgcpy.compiled.kernel import kernel
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
    of_contacts = data.gap, data.reference_gap, given.keeps_gap, solved.system.impulse, data.before, data.after
    if not makes_energy(*of_contacts, given.free_velocity, before, given.inverse_mass):
        return solved, None
    first = solved.system.impulse.copy()
    turned = (data.gap < data.reference_gap) & given.keeps_gap
    reference = np.where(turned, given.data.gap, given.data.reference_gap)
    again = replace(given, data=given.data._replace(reference_gap=reference))
    again.prepare()
    solved = solve(again)
    return solved, first - solved.system.impulse


@kernel
def makes_energy(gap, reference_gap, keeps_gap, impulse, before, after, free_velocity, velocity, inverse_mass):
    """Whether contacts that take back what turning closed make more than :data:`MADE` of the kinetic energy and of what
    loads give from rest. ``before``, ``after``: relative velocities (m, d); ``free_velocity``, ``velocity``: of the bodies
    without impulses and before the step (n, k)."""
    work = 0.0
    for i in range(gap.shape[0]):
        if keeps_gap[i] and gap[i] < reference_gap[i]:
            work += 0.5 * impulse[i, 0] * (before[i, 0] + after[i, 0])
    if work <= 0.0:
        return False
    energy = 0.0
    for b in range(velocity.shape[0]):
        for k in range(velocity.shape[1]):
            if inverse_mass[b, k] > 0.0:
                loads = free_velocity[b, k] - velocity[b, k]
                energy += 0.5 * (velocity[b, k] * velocity[b, k] + loads * loads) / inverse_mass[b, k]
    return work > MADE * energy
