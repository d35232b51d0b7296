"""Following the path to the solution of a proximal problem in the plane, where Newton steps do not find its statuses.

In the plane the map

    F(a) = W r(a) + q + epsilon w (r(a) - centre) - w (r(a) - a),      r(a) = react(w I, -w a),

which is zero at the solution (``a = r - u / w``), is linear in every cell of statuses. Any ``a`` is the solution of a
problem, that whose q is less by F(a); so from any start q can be led back to what it is. The path ``F(a) = rest
F(start)`` is a chain of straight lines, from ``rest`` = 1 to ``rest`` = 0. It bends where one interaction changes its
status; there the matrix changes by rank one, which costs one solution with the factors at hand (Sherman, Morrison). They
are made anew every :data:`RENEW` bends.

Friction is not associated, and ``rest`` may have to grow on the way: where a solution ceases to exist the path turns back
and comes to another, that is some way off. Sweeps and Newton steps go to that place for ever. The path goes on across a
wall into the cell behind it, whichever way ``rest`` changes there.

As ``epsilon > 0``, the only solution with q = 0 is zero: a path cannot go to infinity at a bounded ``rest``. It may come
back to a large ``rest``, and it may be very long. So it is given up after some bends; with a larger ``epsilon`` it is
shorter.

Sources: the map, Robinson (1992) Math. Oper. Res. 17; paths of piecewise linear equations, Katzenelson (1965) Bell Syst.
Tech. J. 44, Eaves (1976) SIAM-AMS Proc. 9; friction in the plane as a linear complementarity problem, and Lemke's path to
its solution, Klarbring, Bjorkman (1988) Comput. Struct. 30, Stewart, Trinkle (1996) Int. J. Numer. Meth. Eng. 39.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.solve.active_set import ActiveSet, Factors, Status
from lmgcpy.solve.path_kernels import change_of_matrix, next_bend, pass_bend, pass_earlier

RENEW = 50
"""Bends that are passed with one factorisation."""
GAIN = 0.1
"""What is left of the error of the start at the end of a path that round-off has not spoilt is less than this part."""


class Path(NamedTuple):
    """Where a path ended."""

    impulses: np.ndarray | None
    """Solution of the proximal problem (m, 2), or None where the path was given up."""
    bends: int


def follow_path(active: ActiveSet, start: np.ndarray, epsilon: float, centre: np.ndarray, most: int) -> Path:
    """Solve the proximal problem by a path from ``a = start`` (m, 2) that may bend ``most`` times."""
    w, mu, compliance, cones = active.laws
    count, d = start.shape
    push, status = map_at(active, start, epsilon, centre)
    given = active.q - epsilon * w[:, None] * centre
    at = np.zeros(RENEW, np.int64)
    walls, jump, changes = np.zeros((RENEW, d)), np.zeros(d), np.zeros((RENEW, count, d))
    rest, way = 1.0, -1.0
    bends = 0
    try:
        while True:
            factors = active.factors(status, epsilon)
            a = map_step(active, factors, epsilon, rest * push - given)
            along = way * map_step(active, factors, epsilon, push)
            for k in range(RENEW):
                i, side, distance = next_bend(a, along, status.kind, status.direction, mu, cones)
                if rest + way * distance <= 0.0:
                    r = active.newton(status, epsilon, centre)
                    left = np.linalg.norm(active.error(r, epsilon, centre)[0])
                    sound = left <= GAIN * np.linalg.norm(push)
                    return Path(r if sound else None, bends)
                if bends == most or i < 0:
                    return Path(None, bends)
                bends += 1
                a += distance * along
                rest += distance * way
                pass_bend(i, side, a, status.kind, status.direction, w, mu, compliance, cones, walls[k], jump)
                at[k] = i
                change_of_matrix(i, jump, epsilon, *active.columns, w, changes[k])
                changes[k] = map_step(active, factors, epsilon, changes[k])
                pass_earlier(k, at, walls, changes, changes[k])
                turn = 1.0 + walls[k] @ changes[k, i]
                changes[k] /= turn
                along -= (walls[k] @ along[i]) * changes[k]
                if turn < 0.0:  # else it would go back into the old cell
                    way, along = -way, -along
    except RuntimeError:  # singular to round-off
        return Path(None, bends)


def map_at(active: ActiveSet, a: np.ndarray, epsilon: float, centre: np.ndarray):
    """F(a) (m, 2), and the statuses there."""
    w = active.weight[:, None]
    r, status = cell_of(active, a)
    status.turning[:] = 0.0  # it has no meaning in the plane
    return active.velocities(r, epsilon, centre) - w * (r - a), status


def cell_of(active: ActiveSet, a: np.ndarray) -> tuple[np.ndarray, Status]:
    """r(a) (m, d), and the statuses of the cell: the natural map at u = -w a, r = 0 is -w r(a)."""
    w = active.weight[:, None]
    error, status = active.natural(-w * a, np.zeros_like(a))
    return -error / w, status


def map_step(active: ActiveSet, factors: Factors, epsilon: float, given: np.ndarray) -> np.ndarray:
    """The change of ``a`` (m, 2) that changes F by ``given``, in the cell of the factors."""
    r = factors.impulses(given)
    w = active.weight[:, None]
    return r + (given - (active.problem.W @ r.ravel()).reshape(r.shape) - epsilon * w * r) / w
