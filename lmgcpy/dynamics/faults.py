"""What broke in a step that could not be made: numbers that are not finite, and the law or the body at fault.

The errors name the body or the interaction, and the time; for a law also the arguments that it was given.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.detector import Group
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.errors import LARGEST, shown, told
from lmgcpy.laws.pair import takes_pair
from lmgcpy.solve.kernels.law_kernels import known_pair
from lmgcpy.solve.kernels.system import System

POSITION = {2: ("x [m]", "y [m]", "rotation [rad]"), 3: ("x [m]", "y [m]", "z [m]", *(f"rotation (q_{k})" for k in "xyzw"))}
"""Columns of the positions in words, by dimension."""
VELOCITY = {
    2: ("velocity along x [m/s]", "velocity along y [m/s]", "spin [rad/s]"),
    3: tuple(f"{what} {k} [{unit}]" for what, unit in (("velocity along", "m/s"), ("spin about", "rad/s")) for k in "xyz"),
}
"""Columns of the velocities."""
FINITE = sys.float_info.max
"""Largest number that is finite."""


@kernel
def within(one, bound_of_one, other, bound_of_other):
    """Whether no number of two flat arrays is larger than its bound, or NaN."""
    beyond = 0
    for i in range(one.shape[0]):
        beyond += not abs(one[i]) <= bound_of_one
    for i in range(other.shape[0]):
        beyond += not abs(other[i]) <= bound_of_other
    return beyond == 0


def fault_of_flight(
    free_velocity: np.ndarray, positions: np.ndarray, dimension: int, time: float
) -> FloatingPointError:
    """The error for a velocity without impulses (n, k), or else a position in the middle of the step (n, w), that is not
    finite, or too large to be squared."""
    if (np.abs(free_velocity) <= LARGEST).all():
        return fault_of_bodies(positions, POSITION[dimension], "in its middle", time)
    return fault_of_bodies(free_velocity, VELOCITY[dimension], "without impulses", time)


def fault_of_bodies(values: np.ndarray, names: tuple[str, ...], when: str, time: float) -> FloatingPointError:
    """The error for the first of the values (n, k) of the bodies that is not finite, or too large to be squared."""
    body, component = np.argwhere(~(np.abs(values) <= LARGEST))[0]
    return FloatingPointError(
        f"In the step from t = {time:g} s a number stopped being finite: {names[component]} of body {body} is "
        f"{values[body, component]:g} {when}. Look at what drives, loads and links this body."
    )


def check_detection(groups: list[Group], found: Interactions, time: float) -> None:
    """FloatingPointError if the narrow phase of two contactors gave a number that is not finite."""
    if within(found.gap, FINITE, found.delassus.reshape(-1), FINITE):
        return
    finite = np.isfinite(found.gap)
    what = "normal or contact point" if finite.all() else "gap"
    row = int(np.argmin(np.isfinite(found.delassus).all(axis=1) if finite.all() else finite))
    law = next(group.law.NAME for group in groups if group.start <= row < group.stop)
    raise FloatingPointError(
        f"In the step from t = {time:g} s a number stopped being finite: the {what} of law '{law}' between bodies "
        f"{found.candidate[row]} and {found.antagonist[row]}. Look at the narrow phase of their contactors."
    )


def check_solution(problem: StepProblem, solver: object) -> None:
    """FloatingPointError if a solver reports success and an impulse is not finite, or a velocity too large."""
    impulse, velocity, time = problem.system.impulse, problem.system.velocity, problem.data.time
    if within(impulse.reshape(-1), FINITE, velocity.reshape(-1), LARGEST):
        return
    finite = np.isfinite(impulse).all(axis=1)
    if not finite.all():
        row = int(np.argmin(finite))
        group = problem.group_of(row)
        raise FloatingPointError(
            f"In the step from t = {time:g} s a number stopped being finite: {type(solver).__name__} gave the "
            f"impulse {shown(impulse[row].tolist())} to {interaction(problem, group, row)}. Take another solver."
        )
    raise fault_of_bodies(velocity, VELOCITY[problem.dimension], "at its end", time)


def check_energy(problem: StepProblem, group: Group, energy: float) -> None:
    """FloatingPointError if the energy stored in a group is not finite; the law is asked again to find the interaction."""
    if math.isfinite(energy):
        return
    data, law = problem.data, group.law
    assert law.energy is not None
    row: int = group.start
    given: Any = energy  # in Python the law may raise if compiled code gave NaN
    for row in range(group.start, group.stop):
        gap = float(data.gap[row] + data.time_step * data.after[row, 0])
        parameters = tuple(group.parameters[row - group.start if len(group.parameters) > 1 else 0].tolist())
        state = tuple(data.state[row, : len(law.states())].tolist())
        try:
            known = known_pair(row, data) if takes_pair(law.energy) else ()
            given = law.energy(gap, float(data.reference_gap[row]), parameters, state, *known)
        except (ArithmeticError, ValueError) as error:
            given = error
        if isinstance(given, Exception) or not math.isfinite(given):
            break
    raise FloatingPointError(
        f"In the step from t = {data.time:g} s a number stopped being finite: energy of {interaction(problem, group, row)} "
        f"returned {shown(given)}."
    )


class LawFault(Exception):
    """Carries the sentence about a law's fault, and as its cause the exception that the law raised."""


def fault_of_solve(problem: StepProblem, solve: Callable[[StepProblem], object]) -> str:
    """A sentence on the first thing that went wrong in the solve of a step; the solve is made again, watched."""
    system = problem.system._replace(prepared=np.append(problem.system.prepared, [0.0, -1.0]))
    solve(replace(problem.on(system, watched=True), row=None, threads=1))
    start = int(system.prepared[-1])
    if start < 0:
        return "no law was asked: velocities, gaps or masses are too large for numbers of double precision"
    g = int(np.searchsorted(problem.offset, start, side="right")) - 1
    group = problem.by_law[g]
    width = len(group.law.PREPARED)
    row = group.start + (start - int(problem.offset[g])) // max(width, 1)
    return asked(replace(problem, system=system), group, row, tuple(system.prepared[start : start + width].tolist()))


def asked(problem: StepProblem, group: Group, row: int, prepared: tuple[float, ...]) -> str:
    """A sentence with the results of ``react`` and ``slope``, interpreted, at the present velocities.

    Raises LawFault if one of them raises.
    """
    system = problem.system
    velocity = problem.relative_velocities(system.velocity)
    size = group.law.rows(problem.dimension)
    W = local_block(system, row, diagonal=group.diagonal or size == 1)[:size, :size]
    free = velocity[row, :size] - W @ system.impulse[row, :size]
    arguments = tuple(map(tuple, W.tolist())), tuple(free.tolist()), prepared
    said = []
    for name in ("react", "slope"):
        function: Callable | None = getattr(group.law, name)
        if function is not None:
            try:
                said.append(f"{name} returned {function(*arguments)}")
            except Exception as error:
                raise LawFault(f"{name} of {interaction(problem, group, row)} raised {told(error)}") from error
    return (
        f"{interaction(problem, group, row)}: {' and '.join(said)} at W = {arguments[0]} 1/kg, u = {arguments[1]} m/s, "
        f"prepared {dict(zip(group.law.PREPARED, prepared, strict=True))}"
    )


def local_block(system: System, row: int, *, diagonal: bool) -> np.ndarray:
    """The local block of W of an interaction, (d, d)."""
    W = np.diag(system.delassus[row])
    if not diagonal:
        W[0, 1] = W[1, 0] = system.coupling[row]
        if len(system.shear):
            W[0, 2] = W[2, 0] = system.shear[row, 0]
            W[1, 2] = W[2, 1] = system.shear[row, 1]
    return W


def interaction(problem: StepProblem, group: Group, row: int) -> str:
    """The law and the bodies of an interaction."""
    c, a = problem.system.candidate[row], problem.system.antagonist[row]
    return f"law '{group.law.NAME}' between bodies {c} and {a}"
