"""What solvers are judged by: two solutions of a problem by different ways, and how far they are apart.

Impulses are not unique where contacts are hyperstatic, velocities are in practice: errors are those of the relative
velocities, ``|u - u_ref| / |q - u_ref|``, relative to the error of doing nothing, as the residual is. The distance of the
two references bounds what can be said: an error is judged where it is more than :data:`MARGIN` times as large.

With friction a problem may have several solutions, different in velocity. Whatever solves it to a residual of
:data:`ENOUGH` is one, by whichever solver it was found; where there are several, an error is the distance to the nearest
of them, and what is judged is above :data:`MARGIN` times :data:`APART`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from lmgcpy.bench.case import Case
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel
from lmgcpy.solve.newton.alternating import Auto, Newton
from lmgcpy.solve.problem import Problem
from lmgcpy.solve.residual import residual
from lmgcpy.solve.standalone import solve

MARGIN = 10.0
LOOSEST, TIGHTEST = 1e-6, 1e-13
"""Residual that a reference is first asked for, and the least one."""
ENOUGH = 1e-9
"""Residual of a reference; where it is missed other ways are tried."""
APART = 1e-5
"""Distance of two solutions that differ: a residual of :data:`ENOUGH` times what the slowest mode makes of it is less."""
UPDATES = 2e8
"""Updates of interactions that sweeps get to make a reference."""
LARGE, LARGE_UPDATES = 20_000, 5e8
"""In space, above so many interactions a factorisation takes seconds to minutes, and soon more memory than there is: no
Newton steps are made there, and both references come from sweeps, which get more updates (of 50 000 spheres, with all
runs, ten minutes)."""


@dataclass(frozen=True)
class Reference:
    """What a problem's solvers are judged by, and how it was found."""

    solutions: tuple[np.ndarray, ...]
    """Relative velocities of the first reference, and of every other solution that was found [m/s], (m, d)."""
    scale: float
    """``|q - u|`` of the first reference [m/s]: what the impulses change."""
    ways: tuple[str, str]
    residuals: tuple[float, float]
    """Of the two references, ``natural``."""
    distance: float
    """Of the two in velocity, relative to the scale."""

    @property
    def floor(self) -> float:
        """Errors below it are not judged."""
        return MARGIN * (APART if len(self.solutions) > 1 else self.distance)

    def error(self, velocities: np.ndarray) -> float:
        """Error of relative velocities (m, d), relative to that of doing nothing."""
        return min(float(np.linalg.norm(velocities - solution)) for solution in self.solutions) / self.scale

    def with_solutions(self, found: Iterable[np.ndarray]) -> Reference:
        """The same with those of the solutions found, (m, d) each, that are none of its own; if the first is one itself."""
        if self.residuals[0] > ENOUGH:
            return self
        several = list(self.solutions)
        for solution in found:
            if min(float(np.linalg.norm(solution - known)) for known in several) > APART * self.scale:
                several.append(solution)
        return replace(self, solutions=tuple(several))


def make_reference(case: Case) -> Reference | None:
    """Two references; None where in the solution no impulse changes anything, so that there is no error to tell.

    Sweeps and Newton's method first; where one of them does not come to a residual of :data:`ENOUGH`, Newton's method from
    where the sweeps ended and from another start, and ``Auto``, are tried as well, and the two with the least residuals
    stand; the others are further solutions, if they are solutions. Extended precision stands before all. A problem that is
    :data:`LARGE` has sweeps with momentum and without.
    """
    problem = case.problem
    found = {"sweeps": by_sweeps(problem)}
    if is_large(problem):
        plain = GaussSeidel(tolerance=TIGHTEST, max_iterations=sweep_budget(problem, LARGE_UPDATES))
        found["plain sweeps"] = solve(problem, solver=plain).impulses
    else:
        found["Newton"] = descent(problem, Newton(), problem.guess)
    residuals = {way: residual(problem, impulses) for way, impulses in found.items()}
    if max(residuals.values()) > ENOUGH and case.exact is None and not is_large(problem):
        found["Newton after sweeps"] = descent(problem, Newton(), found["sweeps"])
        found["Newton from another start"] = descent(problem, Newton(), another_start(found["Newton"]))
        found["Auto"] = descent(problem, Auto(), problem.guess)
        residuals = {way: residual(problem, impulses) for way, impulses in found.items()}
    one, other = sorted(found, key=lambda way: residuals[way])[:2]
    if case.exact is not None:
        one, other = "extended precision", one
        found[one], residuals[one] = case.exact, residual(problem, case.exact)
    velocities, others = problem.velocities(found[one]), problem.velocities(found[other])
    scale = float(np.linalg.norm(problem.q.reshape(velocities.shape) - velocities))
    if scale == 0.0:
        return None
    distance = float(np.linalg.norm(velocities - others)) / scale
    reference = Reference((velocities,), scale, (one, other), (residuals[one], residuals[other]), distance)
    return reference.with_solutions(problem.velocities(found[way]) for way in found if residuals[way] <= ENOUGH)


def by_sweeps(problem: Problem) -> np.ndarray:
    """Impulses of accelerated sweeps, as far as they get within their updates, (m, d)."""
    most = sweep_budget(problem, LARGE_UPDATES if is_large(problem) else UPDATES)
    return solve(problem, solver=AcceleratedGaussSeidel(tolerance=TIGHTEST, max_iterations=most)).impulses


def descent(problem: Problem, solver: Newton | Auto, start: np.ndarray) -> np.ndarray:
    """Impulses of a solver: to a residual of :data:`LOOSEST`, then a tenth of it, and so on as far as it gets, (m, d).

    Asked for the least residual at once it would look for what round-off may not allow.
    """
    best, least = start, np.inf
    solver = replace(solver, tolerance=LOOSEST, max_iterations=20_000, max_factorisations=1000)
    while True:
        solution = solve(problem, solver=solver, guess=best)
        if solution.residual < least:
            best, least = solution.impulses, solution.residual
        tolerance = 0.1 * min(solver.tolerance, solution.residual)
        if solution.status != "converged" or tolerance < TIGHTEST:  # round-off, too, is as far as it gets
            return best
        solver = replace(solver, tolerance=tolerance, max_iterations=4000, max_factorisations=1000)


def another_start(impulses: np.ndarray) -> np.ndarray:
    """Random impulses of the mean size of those given, (m, d)."""
    size = float(np.sqrt(np.mean(impulses**2)))
    return np.random.default_rng(0).normal(0.0, size, impulses.shape)


def is_large(problem: Problem) -> bool:
    """Whether Newton steps are out of reach."""
    return problem.dimension == 3 and len(problem.mu) > LARGE


def sweep_budget(problem: Problem, updates: float) -> int:
    """Sweeps that make so many updates of interactions, within 1000 and 50 000."""
    return int(np.clip(updates / max(len(problem.mu), 1), 1000, 50_000))
