"""Solving to a tolerance in any measure of the error. Solvers themselves stop by the natural one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.problems.residual import residual
from lmgcpy.solve.solvers import AnySolver
from lmgcpy.solve.standalone import solve

ROUNDS = 12
"""Solves in a row at the most; each asks for a natural residual at least three times smaller than the one before."""

LOOSER = 0.5
"""Both measures are errors of the same kind over different scales, ``|e(0)|`` and ``|q|``. So their quotient is, near a
solution, about the other measure of r = 0 (within 30 % on published problems, with values of 1 to 1/260), and the natural
tolerance that is tried first is the one asked for divided by it, times this."""


@dataclass(frozen=True)
class Solved:
    """The impulses of the last of some solves in a row, and the cost of all of them."""

    impulses: np.ndarray
    """[N s], (m, d)."""
    status: str
    error: float
    """Error in the given measure."""
    iterations: int
    factorisations: int
    seconds: float


def solve_to_measure(problem: Problem, solver: AnySolver, *, measure: str = "natural") -> Solved:
    """Solve until ``residual(problem, impulses, measure=measure) <= solver.tolerance``.

    As long as the measure asked for is not within tolerance the solve goes on from its impulses, with a smaller natural
    tolerance. The status is "converged" if the measure asked for is within tolerance, whatever the solver says of its own
    measure, and "round-off" if it is not and nothing better can be had.
    """
    guess = problem.guess
    tolerance = solver.tolerance
    if measure != "natural":
        of_nothing = residual(problem, np.zeros_like(guess), measure=measure)
        tolerance = min(LOOSER * tolerance / of_nothing, 1.0) if of_nothing > 0.0 else 1.0
    sweeps = factorisations = 0
    seconds = 0.0
    for _ in range(ROUNDS):
        solution = solve(problem, solver=replace(solver, tolerance=tolerance), guess=guess)
        sweeps += solution.iterations
        factorisations += solution.factorisations
        seconds += solution.seconds
        guess, status = solution.impulses, solution.status
        error = residual(problem, guess, measure=measure)
        if error <= solver.tolerance:
            status = "converged"
        if error <= solver.tolerance or status != "converged":
            break
        tolerance = solution.residual * min(0.3, 0.5 * solver.tolerance / error)
        status = "budget spent"
        if not tolerance > 0.0:
            break
    return Solved(guess, status, error, sweeps, factorisations, seconds)
