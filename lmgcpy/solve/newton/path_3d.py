"""Following the path to the solution of a proximal problem in space, if Newton steps do not find its statuses.

The path is defined as in ``path``, but sliding contacts turn on the way, so that it is curved between its bends. It is
followed in a model, in which the directions of sliding turn as they began to when the matrix was factorised. In the model
the path is a chain of straight lines, and a bend costs a solution or two, as in the plane. When the error of the model
exceeds :data:`OFF` of the F that is left, or after as many bends as in the plane, the matrix is factorised anew, and the
present F replaces F(start). ``rest`` falls if the determinant has the same sign as at the start, and else grows (Allgower,
Georg 1990, Numerical Continuation Methods).

A path may lead back to its start, as the start problem may have other solutions: this is assumed if an interaction changes
its status for the :data:`ROUNDS`-th time. Or the path may go to infinity, while F grows without end, in each piece by a
share of itself: this is assumed past :data:`FAR`.

The end is near the solution: Newton steps from its statuses do the rest.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from lmgcpy.solve.newton.active_set import ActiveSet, Status
from lmgcpy.solve.newton.path import RENEW, Derivative, cell_of

ANGLE = 0.3
"""Largest turn of a sliding direction from bend to bend [rad]: 1 - cos(ANGLE) is 4 %."""
OFF = 0.1
"""Error of the model, in parts of the F that is left, beyond which the matrix is factorised anew. (With 0.03 or
0.3 no more steps of compactions are solved, and in no fewer Newton steps. With correction steps that keep the error within
0.01, 71 of 378 paths came to an end, instead of 265 of 420: a path that strays ends sooner.)"""
ROUNDS = 10
"""Changes of status of one interaction after which a path is given up. (Of 21 paths that came to an end, in
steps of triaxial tests and of a compaction, 20 had less.)"""
FAR = 1e6
"""Growth of F past which a path is given up. (On paths that came to an end, in steps of triaxial tests, it grew by 200
at most, of 132; on paths that went to infinity, in a published problem of 24 contacts, by 1e160.)"""
STEPS = 8
"""Number of straight pieces that cost as much as a factorisation: measured, 5 with 1900 interactions and 10 with 4400."""


class Curve(NamedTuple):
    """End of a path."""

    status: Status | None
    """Statuses near the solution of the proximal problem, or None if the path was given up."""
    bends: int
    cost: int
    """Cost in factorisations."""


def follow_curve(active: ActiveSet, start: np.ndarray, epsilon: float, centre: np.ndarray, most: int) -> Curve:
    """Come near the solution of the proximal problem by a path from ``a = start`` (m, 3) that costs as much as ``most``
    factorisations."""
    a, kind = start.copy(), cell_of(active, start)[1].kind
    push, status = map_of(active, a, kind, epsilon, centre)
    size = float(np.linalg.norm(push))
    if not size < np.inf:  # impulses that have run away are no start
        return Curve(None, 0, 1)
    far = FAR * size
    wall, jump = np.zeros((2, active.width))
    across, turned = np.zeros((2, active.turning_disks, active.width))
    changes = np.zeros(len(a), np.int64)
    orientation = 0.0
    bends = 0
    cost = 0.0
    try:
        while cost + 1.0 < most:
            matrix = Derivative(active, status, epsilon)
            cost += 1.0
            model = type(status)(kind.copy(), status.direction.copy(), status.turning.copy())
            # rest falls if the determinant has the same sign as at the start
            orientation = orientation or -matrix.sign
            rest, growth = 1.0, orientation * matrix.sign
            along = growth * matrix.step(push)
            fresh, off = True, 0.0
            while off <= OFF * rest * size and matrix.passed < RENEW and cost + 1.0 / STEPS <= most:
                cost += 1.0 / STEPS
                passed, disk, reach, turn = active.next_wall(a, along, kind, status.direction)
                length = min(reach, ANGLE * turn, rest if growth < 0.0 else np.inf)
                if not (rest + length * growth) * size <= far:  # without a wall ahead the length is infinite
                    return Curve(None, bends, ceil(cost))
                # predictor along the line; a fresh model that goes astray halves its length
                while True:
                    ahead, its_rest = a + length * along, rest + length * growth
                    value, status = map_of(active, ahead, kind, epsilon, centre)
                    off = float(np.linalg.norm(value - its_rest * push))
                    if off <= OFF * rest * size or length == 0.0 or not fresh:
                        break
                    length *= 0.5
                if its_rest == 0.0 and off <= OFF * rest * size:
                    return Curve(cell_of(active, ahead)[1], bends, ceil(cost))
                a, rest, fresh = ahead, its_rest, False
                if length == reach:
                    bends += 1
                    changes[passed] += 1
                    if changes[passed] == ROUNDS:
                        return Curve(None, bends, ceil(cost))
                    active.pass_wall(passed, disk, a, model, wall, jump, across, turned)
                    kind[passed] = model.kind[passed]
                    for its_wall, its_jump in (*zip(across, turned, strict=True), (wall, jump)):
                        if its_jump.any():
                            along, back = matrix.bend(passed, its_wall, its_jump, along)
                            if back:  # the determinant changes its sign
                                growth, along = -growth, -along
                    value, status = map_of(active, a, kind, epsilon, centre)
            push, size = value, float(np.linalg.norm(value))
    except RuntimeError:  # singular to round-off
        pass
    return Curve(None, bends, ceil(cost))


def map_of(
    active: ActiveSet, a: np.ndarray, kind: np.ndarray, epsilon: float, centre: np.ndarray
) -> tuple[np.ndarray, Status]:
    """F(a) (m, 3) with these kinds of statuses (m,), and the statuses with their directions and turning."""
    r, status = active.impulses_of(a, kind)
    return active.velocities(r, epsilon, centre) - active.weight[:, None] * (r - a), status
