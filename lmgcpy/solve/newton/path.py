"""Following the path to the solution of a proximal problem in the plane, if Newton steps do not find its statuses.

In the plane the map

    F(a) = W r(a) + q + epsilon w (r(a) - centre) - w (r(a) - a),      r(a) = react(w I, -w a),

which is zero at the solution (``a = r - u / w``), is linear in every cell of statuses. Any ``a`` is the solution of a
problem, the one with ``q - F(a)`` in place of q; so from any start this q can be led back to the given q. The path
``F(a) = rest F(start)`` is a chain of straight lines, from ``rest`` = 1 to ``rest`` = 0. It bends where one interaction
changes its status; there the matrix changes by rank one, which costs one solution with the factors at hand (Sherman,
Morrison). The matrix is factorised anew every :data:`RENEW` bends.

Friction is not associated, and ``rest`` may have to grow in between: where a solution ceases to exist, the path turns
back and leads to another solution at some distance, while sweeps and Newton steps return to the same impulses again and
again. The path crosses a wall into the cell behind it, whether ``rest`` falls or grows there.

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

from lmgcpy.solve.newton.active_set import ActiveSet, Status
from lmgcpy.solve.newton.path_kernels import change_of_a, change_of_matrix

RENEW = 50
"""Bends that are passed with one factorisation."""
GAIN = 0.1
"""A path ends at a solution where less than this part of the error of its start is left; else round-off has spoilt it."""


class Path(NamedTuple):
    """End of a path."""

    impulses: np.ndarray | None
    """Solution of the proximal problem (m, 2), or None if the path was given up."""
    bends: int


class Derivative:
    """The derivative of F in a cell, factorised, and the bends passed since, :data:`RENEW` at most.

    Raises RuntimeError if it is singular to round-off.
    """

    def __init__(self, active: ActiveSet, status: Status, epsilon: float):
        count, d = active.q.shape
        self.passed = 0
        self._active, self._epsilon = active, epsilon
        self._factors = active.factors(status, epsilon)
        most = RENEW + d - 2  # the last bend in space may change the matrix twice
        self._at, self._walls = np.zeros(most, np.int64), np.zeros((most, d))
        self._changes = np.zeros((most, count, d))

    @property
    def sign(self) -> float:
        """Sign of the determinant before any bend."""
        return self._factors.sign

    def step(self, given: np.ndarray) -> np.ndarray:
        """The change of ``a`` (m, d) that changes F by ``given``, in the cell behind the last bend."""
        r, y = self._factors.impulses(given), np.empty(given.shape)
        Wr, w = self._active.problem.times(r.ravel()), self._active.weight
        change_of_a(r, given, Wr, self._epsilon, w, self.passed, self._at, self._walls, self._changes, y)
        return y

    def bend(self, i: int, wall: np.ndarray, jump: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, bool]:
        """Add ``jump wall^T``, (d,) both, to the derivative of the impulses of interaction ``i`` by its ``a``. Returns the
        step ``along`` (m, d) behind the bend, and whether the determinant changes its sign. Raises RuntimeError if the
        determinant behind the bend is zero: there the path has no direction."""
        change = self._changes[self.passed]
        # Sherman-Morrison: A^-1 g / (1 + wall . A^-1 g)
        change_of_matrix(i, jump, self._epsilon, *self._active.columns, self._active.weight, change)
        given = change.copy()
        change[:] = self.step(given)
        turn = 1.0 + wall @ change[i]
        if turn == 0.0:
            raise RuntimeError("The matrix behind the bend is singular.")
        change /= turn
        self._at[self.passed], self._walls[self.passed] = i, wall
        self.passed += 1
        return along - (wall @ along[i]) * change, turn < 0.0


def follow_path(active: ActiveSet, start: np.ndarray, epsilon: float, centre: np.ndarray, most: int) -> Path:
    """Solve the proximal problem by a path from ``a = start`` (m, D) that may bend ``most`` times."""
    push, status = map_at(active, start, epsilon, centre)
    given = active.q - epsilon * active.weight[:, None] * centre
    wall, jump = np.zeros((2, active.width))
    rest, growth = 1.0, -1.0  # rest changes by growth times the distance
    bends = 0
    try:
        while True:
            matrix = Derivative(active, status, epsilon)
            a = matrix.step(rest * push - given)
            along = growth * matrix.step(push)
            while matrix.passed < RENEW:
                i, side, distance = active.next_bend(a, along, status)
                if rest + growth * distance <= 0.0:  # the solution lies before the next bend: one Newton step is exact
                    r = active.newton(status, epsilon, centre)
                    left = np.linalg.norm(active.error(r, epsilon, centre)[0])
                    sound = left <= GAIN * np.linalg.norm(push)
                    return Path(r if sound else None, bends)
                if bends == most or i < 0:
                    return Path(None, bends)
                bends += 1
                a += distance * along
                rest += growth * distance
                active.pass_bend(i, side, a, status, wall, jump)
                along, back = matrix.bend(i, wall, jump, along)
                if back:  # the determinant changes its sign: without a turn the path would go back into the old cell
                    growth, along = -growth, -along
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
