"""``lmgcpy.solve``: a problem that stands alone is solved, without a simulation."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from lmgcpy.errors import LARGEST, named_arguments, numbers
from lmgcpy.solve.kernels.law_kernels import LawKernels
from lmgcpy.solve.kernels.matrix_system import DRIVER, assemble_problem
from lmgcpy.solve.newton.alternating import Auto
from lmgcpy.solve.problems.delassus import unsolvable
from lmgcpy.solve.problems.problem import Problem, check_problem
from lmgcpy.solve.problems.report import SOLVED_CODES, STATUS
from lmgcpy.solve.problems.residual import residual
from lmgcpy.solve.sweeps.solver import Solver, check_solver
from lmgcpy.solve.sweeps.step import Step


@dataclass(frozen=True)
class Solution:
    """The answer of a solver to a problem."""

    impulses: np.ndarray
    """[N s], (m, D)."""
    velocities: np.ndarray
    """[m/s], (m, D)."""
    residual: float
    """``natural``, computed from the problem as it stands."""
    status: str
    """"converged", "budget spent", "stagnated", "not finite" or "round-off"."""
    iterations: int
    """Sweeps."""
    factorisations: int
    """Newton steps."""
    seconds: float
    """Time of the clock that the solver took [s]."""

    def __repr__(self) -> str:
        newton = f" and {self.factorisations} Newton steps" if self.factorisations else ""
        return (
            f"<Solution of {len(self.impulses)} interactions: {self.status} after {self.iterations} sweeps{newton} at a "
            f"residual of {self.residual:.2e} in {self.seconds:.4f} s>"
        )


@dataclass(kw_only=True, eq=False, repr=False)
class StepOfProblem(Step):
    """A problem that stands alone, as solvers get it."""

    problem: Problem
    kernels: list[LawKernels]
    """``groups`` holds their addresses, which end with them."""

    DRIVER: ClassVar[Mapping[str, Any]] = DRIVER
    law_without_conic = None

    def conic(self) -> tuple[Problem, np.ndarray]:
        return self.problem, np.ones(len(self.problem.mu), dtype=bool)

    def components(self) -> np.ndarray:
        return self.problem.rows


@named_arguments
def solve(problem: Problem, *, solver: Solver | None = None, guess: Any = None) -> Solution:
    """Solve a problem, from ``guess`` (m, D) or the problem's own; D is the problem's ``width``.

    ``solver``: such as ``lmgcpy.Newton(tolerance=1e-10)``; ``lmgcpy.Auto()`` if none is given. Raises ValueError if the
    problem was not solved and W is not positive semidefinite, FloatingPointError if the impulses grow without bound.
    """
    check_problem(problem, "solve")
    solver = Auto() if solver is None else solver
    check_solver(solver)
    start = problem.guess if guess is None else numbers(guess, "guess")
    if start.shape != problem.guess.shape:
        raise ValueError(f"guess must have shape {problem.guess.shape}, got {start.shape}.")
    start = np.where(problem.rows, start, 0.0)
    groups, system, kernels = assemble_problem(problem, solver.wire_blocks)
    free = problem.q.reshape(-1, problem.width).copy()
    step = StepOfProblem(groups=groups, system=system, free_velocity=free, guess=start, problem=problem, kernels=kernels)
    begin = clock.perf_counter()
    with np.errstate(all="ignore"):  # the result is checked below
        outcome = solver.solve(step)
    seconds = clock.perf_counter() - begin
    impulses = system.impulse
    error = residual(problem, impulses) if (np.abs(impulses) <= LARGEST).all() else np.inf
    if error > 1.0 or outcome.status not in SOLVED_CODES:
        unsolvable(problem.W, finite=error < np.inf)
    return Solution(
        impulses=impulses,
        velocities=problem.velocities(impulses),
        residual=error,
        status=STATUS[outcome.status],
        iterations=outcome.iterations,
        factorisations=outcome.factorisations,
        seconds=seconds,
    )
