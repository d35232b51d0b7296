"""The cause of a step without a finite result: the interaction, its law, and the arguments that the law was given."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lmgcpy.contact.detector import Group
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.errors import told
from lmgcpy.solve.kernels.system import System


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
