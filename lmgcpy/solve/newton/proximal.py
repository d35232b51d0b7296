"""The proximal point method with semi-smooth Newton steps: for the last digits, and for modes that sweeps hardly move.

The problem is solved as a sequence of proximal problems (see ``active_set``), each centred at the solution of the one
before (Rockafellar 1976, SIAM J. Control Optim. 14). With a small ``epsilon`` the sequence converges fast, also along
directions in which W is singular or nearly so, as the self-stresses of a jammed sample or of rods are. But the smaller it
is, the more statuses change from one solution to the next, and Newton steps converge only if few do. So ``epsilon`` is
controlled like the radius of a trust region: it falls after a success, by a larger factor after fewer steps, and rises
after a failure. Afterwards it halves its distance to the value that failed (on a logarithmic scale).

A Newton step is not damped: with the statuses of the solution it is exact from any start, and statuses that change wildly
are the sign of an ``epsilon`` that is too small. A proximal problem need not be solved well: an error of
:data:`LOOSE` times the error of the problem itself is enough. If the steps fail because a few statuses come and go, the
last iterate may be nearer the solution of the problem itself than the centre is; then it becomes the next centre.

If Newton steps fail, the path to the solution of the proximal problem is followed (see ``path`` and ``path_3d``):
through statuses that come and go, and past points from which the residual grows in every direction.

Friction that is not associated makes the problem non-monotone; then convergence is not proved. Measurements on hard
problems: docs/solvers.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.solve.newton.active_set import ActiveSet, Status
from lmgcpy.solve.newton.path import follow_path
from lmgcpy.solve.newton.path_3d import follow_curve

FIRST = 1e-2
"""epsilon to start with. (With 1e-4 and 0.1 ``Auto`` is within 1.3 times the fastest solver less often on the steps of
``benchmarks/auto_choice.py``: 87 and 88 % against 93 to 96 %, and on another sample 84 % against 87 %.)"""
FALL = (10.0, 4.0, 4.0, 2.0, 2.0, 2.0)
"""epsilon is divided by this after a success that took 1, 2, 3 ... Newton steps; a proximal problem gets no more steps."""
RISE = 10.0
LEAST, MOST = 1e-14, 1.0
LOOSE = 0.3
"""A proximal problem is solved if its error is at most this share of the error of the problem itself."""
WORSE = 3.0
"""Largest ratio of the residual of a proximal solution to the residual of its centre: on the way to the solution of a
locked sample the residual does not fall in every step."""
WILD = 100
"""Changes of status after a first Newton step from which no second is tried."""
PATIENCE = 30
"""Factorisations within which the residual must halve, as a rule."""
BENDS = 150
"""Bends after which a path is given up. Most paths have less than 50; paths with more than this often have thousands."""
PATH_FALL = ((30, 10.0), (100, 4.0), (np.inf, 2.0))
"""Pairs (number of bends, factor): after a path with at most this number of bends epsilon is divided by the factor."""
MOST_IN_SPACE = 60
"""Factorisations that a path in space may cost."""
COST = 6
"""Number of bends that count as a factorisation; the two ends of a path count as two more. (Ten cost as
much, with 970 interactions. With ten, paths are tried for longer, and on the steps of ``benchmarks/auto_choice.py``
``Auto`` does not reach three of 108 errors instead of none.)"""


class Attempt(NamedTuple):
    """The best impulses found (m, d), their residual, the last impulses (m, d), and the number of factorisations."""

    impulses: np.ndarray
    residual: float
    last: np.ndarray
    factorisations: int


def proximal_newton(active: ActiveSet, start: np.ndarray, tolerance: float, most: int, patience: int = PATIENCE) -> Attempt:
    """Go on from the impulses ``start`` (m, d) until the residual is at most ``tolerance``, ``most`` matrices have been
    factorised, or ``patience`` factorisations have not halved the residual; the half is counted from the highest residual
    since it last halved."""
    r = best = start
    residual = least = active.residual(r)
    epsilon, failed = FIRST, 0.0
    done = milestone_at = 0
    milestone = least
    while least > tolerance and done < most and done - milestone_at < patience:
        found, solves, steps = proximal_solution(active, r, epsilon, tolerance, most - done)
        done += steps
        fall = FALL[steps - 1]
        reached = np.inf if found is None or active.lost(found) else active.residual(found)
        success = solves and reached < WORSE * residual
        if not success:
            by_path, cost, its_fall = solution_by_path(active, r, epsilon, tolerance, most - done)
            done += cost
            if by_path is not None and not active.lost(by_path):
                found, success, reached, fall = by_path, True, active.residual(by_path), its_fall
        if found is not None and (success or reached < residual):
            r, residual = found, reached
            if residual < least:
                best, least = r, residual
            milestone = max(
                milestone, residual
            )  # the residual may have to grow first; gains are measured from its largest value
            if residual < 0.5 * milestone:
                milestone, milestone_at = residual, done
        # control of epsilon, as of a trust region
        if success:
            lower = epsilon / fall
            if 0.0 < failed < epsilon:
                lower = max(lower, float(np.sqrt(epsilon * failed)))
            failed *= 0.5
            epsilon = max(lower, LEAST)
        elif epsilon >= MOST:
            break
        else:
            failed, epsilon = epsilon, min(RISE * epsilon, MOST)
    return Attempt(best, least, r, done)


def proximal_solution(
    active: ActiveSet, centre: np.ndarray, epsilon: float, tolerance: float, most: int, status: Status | None = None
) -> tuple[np.ndarray | None, bool, int]:
    """Newton steps on the proximal problem. Returns the impulses (m, d), or None if a matrix was singular; whether they
    solve the proximal problem; the number of factorisations.

    ``status``: statuses to start from, by default the statuses of the centre.
    """
    if status is None:
        _, status = active.error(centre, epsilon, centre)
    fewest = np.inf
    r = None
    steps = min(len(FALL), most)
    for step in range(1, steps + 1):
        try:
            r = active.newton(status, epsilon, centre)
        except RuntimeError:  # singular to round-off
            return None, False, step
        error, there = active.error(r, epsilon, centre)
        enough = max(LOOSE * active.residual(r), 0.1 * tolerance) * active.nothing
        if np.linalg.norm(error) <= enough:
            return r, True, step
        # Newton steps converge if few statuses change
        changes = status.changes(there)
        if changes > 2 * fewest + 3 or (step == 1 and changes > WILD):
            break
        fewest, status = min(fewest, changes), there
    return r, False, step


def solution_by_path(
    active: ActiveSet, centre: np.ndarray, epsilon: float, tolerance: float, most: int
) -> tuple[np.ndarray | None, int, float]:
    """Follows the path to the proximal solution. Returns the impulses (m, d), or None without success; the cost in
    factorisations; the factor by which epsilon may fall."""
    start = centre - active.velocities(centre) / active.weight[:, None]
    if active.dimension == 2:
        bends = min(BENDS, COST * (most - 2))
        if bends < 0:
            return None, 0, 1.0
        path = follow_path(active, start, epsilon, centre, bends)
        return path.impulses, 2 + path.bends // COST, fall_after(path.bends)
    within = min(MOST_IN_SPACE, most - len(FALL) - 1)
    if within < 1:
        return None, 0, 1.0
    curve = follow_curve(active, start, epsilon, centre, within)
    if curve.status is None:
        return None, curve.cost, 1.0
    found, solves, newton = proximal_solution(active, centre, epsilon, tolerance, len(FALL), curve.status)
    return found if solves else None, curve.cost + newton, fall_after(curve.bends)


def fall_after(bends: int) -> float:
    """Factor by which epsilon falls after a path with this number of bends."""
    return next(by for most, by in PATH_FALL if bends <= most)
