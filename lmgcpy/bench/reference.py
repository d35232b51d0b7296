"""References for solvers: two solutions of a problem by different methods, and their distance.

In hyperstatic packings impulses are not unique, while velocities are unique in practice. So an error is measured on the
relative velocities, ``|u - u_ref| / |q - u_ref|``; like the residual it is relative to the error of doing nothing. The
distance of the two references limits the accuracy: only errors above :data:`MARGIN` times this distance are judged.

With friction a problem may have several solutions with different velocities. Any impulses with a residual of at most
:data:`ENOUGH` are a solution, whichever solver found them. If there are several solutions, an error is the distance to the
nearest of them, and only errors above :data:`MARGIN` times :data:`APART` are judged.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lmgcpy.bench.cases import Case
from lmgcpy.solve.newton.alternating import Auto, Newton
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.problems.residual import residual
from lmgcpy.solve.standalone import solve
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.gauss_seidel import GaussSeidel

MARGIN = 10.0
LOOSEST, TIGHTEST = 1e-6, 1e-13
"""First and last tolerance in the descent to a reference."""
ENOUGH = 1e-9
"""Largest residual of a reference; if it is missed, other methods are tried."""
APART = 1e-5
"""Least distance of two different solutions. A residual of :data:`ENOUGH`, amplified by the slowest mode, gives less."""
UPDATES = 2e8
"""Number of updates of interactions that sweeps may take for a reference."""
LARGE, LARGE_UPDATES = 20_000, 5e8
"""Number of interactions in 3D above which no Newton steps are made: a factorisation would take seconds to minutes and
much memory. There both references come from sweeps with more updates (ten minutes for 50 000 spheres, with all runs)."""


@dataclass(frozen=True)
class Reference:
    """The references of a problem, and the methods that found them."""

    solutions: tuple[np.ndarray, ...]
    """Relative velocities of the first reference, and of every other solution that was found [m/s], (m, d)."""
    scale: float
    """``|q - u|`` of the first reference [m/s], the change of velocity by the impulses."""
    methods: tuple[str, str]
    """Methods of the two references."""
    residuals: tuple[float, float]
    """Residuals of the two references, in the ``natural`` measure."""
    distance: float
    """Distance of the velocities of the two references, relative to the scale."""

    @property
    def floor(self) -> float:
        """Smallest error that is judged."""
        return MARGIN * (APART if len(self.solutions) > 1 else self.distance)

    def error(self, velocities: np.ndarray) -> float:
        """Error of relative velocities (m, d), divided by the error of doing nothing."""
        return min(float(np.linalg.norm(velocities - solution)) for solution in self.solutions) / self.scale

    def with_solutions(self, found: Iterable[np.ndarray]) -> Reference:
        """The reference with further solutions, (m, d) each, that differ from its own.

        It is returned unchanged if its first reference is no solution itself.
        """
        if self.residuals[0] > ENOUGH:
            return self
        several = list(self.solutions)
        for solution in found:
            if min(float(np.linalg.norm(solution - known)) for known in several) > APART * self.scale:
                several.append(solution)
        return replace(self, solutions=tuple(several))


def make_reference(case: Case) -> Reference | None:
    """Two references; None if no impulse of the solution changes a velocity, because then no error is defined.

    Sweeps and Newton's method come first. If one of them misses a residual of :data:`ENOUGH`, Newton's method is tried from
    the result of the sweeps and from another start, and so is ``Auto``; also if both are the same to the last bit, as one
    method may end on the way of another. The two different results with the least residuals are the references; the others
    may be further solutions. A solution in extended precision is always the first reference. For a
    :data:`LARGE` problem the two methods are sweeps with momentum and without.
    """
    problem = case.problem
    found = {"sweeps": by_sweeps(problem)}
    if is_large(problem):
        plain = GaussSeidel(tolerance=TIGHTEST, max_iterations=sweep_budget(problem, LARGE_UPDATES))
        found["plain sweeps"] = solve(problem, solver=plain).impulses
    else:
        found["Newton"] = descent(problem, Newton(), problem.guess)
    residuals = {method: residual(problem, impulses) for method, impulses in found.items()}
    doubtful = max(residuals.values()) > ENOUGH or len(different(found)) < 2
    if doubtful and case.exact is None and not is_large(problem):
        found["Newton after sweeps"] = descent(problem, Newton(), found["sweeps"])
        found["Newton from another start"] = descent(problem, Newton(), another_start(found["Newton"]))
        found["Auto"] = descent(problem, Auto(), problem.guess)
        residuals = {method: residual(problem, impulses) for method, impulses in found.items()}
    independent = different(found)
    one, other = sorted(independent if len(independent) > 1 else found, key=lambda method: residuals[method])[:2]
    if case.exact is not None:
        one, other = "extended precision", one
        found[one], residuals[one] = case.exact, residual(problem, case.exact)
    velocities, others = problem.velocities(found[one]), problem.velocities(found[other])
    scale = float(np.linalg.norm(problem.q.reshape(velocities.shape) - velocities))
    if scale == 0.0:
        return None
    distance = float(np.linalg.norm(velocities - others)) / scale
    reference = Reference((velocities,), scale, (one, other), (residuals[one], residuals[other]), distance)
    return reference.with_solutions(problem.velocities(found[method]) for method in found if residuals[method] <= ENOUGH)


def different(found: dict[str, np.ndarray]) -> list[str]:
    """The methods, without those that found the same as one before them, to the last bit."""
    methods = list(found)
    return [
        method for k, method in enumerate(methods) if not any(np.array_equal(found[method], found[m]) for m in methods[:k])
    ]


def by_sweeps(problem: Problem) -> np.ndarray:
    """Impulses after accelerated sweeps within their number of updates, (m, d)."""
    most = sweep_budget(problem, LARGE_UPDATES if is_large(problem) else UPDATES)
    return solve(problem, solver=AcceleratedGaussSeidel(tolerance=TIGHTEST, max_iterations=most)).impulses


def descent(problem: Problem, solver: Newton | Auto, start: np.ndarray) -> np.ndarray:
    """Impulses of a solver with the least residual that it reaches, (m, d).

    The tolerance starts at :data:`LOOSEST` and falls by ten in each solve. With the least tolerance at once, the solver
    would search for a residual that round-off may not allow.
    """
    best, least = start, np.inf
    solver = replace(solver, tolerance=LOOSEST, max_iterations=20_000, max_factorisations=1000)
    while True:
        solution = solve(problem, solver=solver, guess=best)
        if solution.residual < least:
            best, least = solution.impulses, solution.residual
        tolerance = 0.1 * min(solver.tolerance, solution.residual)
        if solution.status != "converged" or tolerance < TIGHTEST:  # the status "round-off" ends the descent too
            return best
        solver = replace(solver, tolerance=tolerance, max_iterations=4000, max_factorisations=1000)


def another_start(impulses: np.ndarray) -> np.ndarray:
    """Random impulses of the same mean size, (m, d)."""
    size = float(np.sqrt(np.mean(impulses**2)))
    return np.random.default_rng(0).normal(0.0, size, impulses.shape)


def is_large(problem: Problem) -> bool:
    """Whether the problem is too large for Newton steps."""
    return problem.dimension == 3 and len(problem.mu) > LARGE


def sweep_budget(problem: Problem, updates: float) -> int:
    """Number of sweeps that make ``updates`` updates of interactions, between 1000 and 50 000."""
    return int(np.clip(updates / max(len(problem.mu), 1), 1000, 50_000))
