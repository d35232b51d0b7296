"""Following the path to the solution of a proximal problem in space, where Newton steps do not find its statuses.

The path is that of ``path``, but sliding contacts turn on the way, so that it is curved between its bends. It is followed
in a model, whose directions of sliding turn as they began to when its matrix was factorised: there it is a chain of
straight lines, and a bend costs a solution or two, as in the plane. When the model has gone astray by :data:`OFF` of what
is left of F, or after as many bends as in the plane, the matrix is made anew, and what F has become takes the place of
F(start). Whether ``rest`` falls or grows, the sign of the determinant tells: it falls where that is the sign at the start
(Allgower, Georg 1990, Numerical Continuation Methods).

A path may lead back to its start, as the problem that this solves may have other solutions: an interaction that changes
its status for the :data:`ROUNDS`-th time is taken for the sign of it. Or it may go to infinity, while F grows without end,
by a part of itself from piece to piece: past :data:`FAR` it is taken for such.

The end is near the solution: Newton steps from its statuses do the rest.
"""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.active_set import ActiveSet, Status
from lmgcpy.solve.newton.path import RENEW, Derivative, cell_of
from lmgcpy.solve.newton.rows import LINK, OPEN, SLIDE, STICK
from lmgcpy.solve.problem import BOTH, CONTACT

ANGLE = 0.3
"""Largest turn of a sliding direction from bend to bend [rad]: 1 - cos(ANGLE) is 4 %."""
OFF = 0.1
"""Error of the model, in parts of what is left of F, from which the matrix is made anew. (With 0.03 or
0.3 no more steps of compactions are solved, and in no fewer Newton steps.)"""
ROUNDS = 10
"""Changes of status of one interaction after which a path is given up. (Of 21 paths that came to an end, in
steps of triaxial tests and of a compaction, 20 had less.)"""
FAR = 1e6
"""Growth of F past which a path is given up. (On paths that came to an end, in steps of triaxial tests, it grew by 200
at most, of 132; on such as went to infinity, in a published problem of 24 contacts, by 1e160.)"""
STEPS = 8
"""Number of straight pieces that cost as much as a factorisation: measured, 5 with 1900 interactions and 10 with 4400."""


class Curve(NamedTuple):
    """End of a path."""

    status: Status | None
    """Statuses near the solution of the proximal problem, or None where the path was given up."""
    bends: int
    cost: int
    """Cost in factorisations."""


def follow_curve(active: ActiveSet, start: np.ndarray, epsilon: float, centre: np.ndarray, most: int) -> Curve:
    """Come near the solution of the proximal problem by a path from ``a = start`` (m, 3) that costs as much as ``most``
    factorisations."""
    w, mu, compliance, _, cones = active.laws
    a, kind = start.copy(), cell_of(active, start)[1].kind
    push, status = map_of(active, a, kind, epsilon, centre)
    size = float(np.linalg.norm(push))
    far = FAR * size
    wall, jump, across, turned = np.zeros((4, 3))
    changes = np.zeros(len(a), np.int64)
    orientation = 0.0
    bends = 0
    cost = 0.0
    try:
        while cost + 1.0 < most:
            matrix = Derivative(active, status, epsilon)
            cost += 1.0
            model = Status(kind.copy(), status.direction.copy(), status.turning.copy())
            # rest falls where the determinant has the sign of the start
            orientation = orientation or -matrix.sign
            rest, growth = 1.0, orientation * matrix.sign
            along = growth * matrix.step(push)
            fresh, off = True, 0.0
            while off <= OFF * rest * size and matrix.passed < RENEW and cost + 1.0 / STEPS <= most:
                cost += 1.0 / STEPS
                passed, between, reach, turn = next_wall(a, along, kind, status.direction, mu, cones)
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
                    pass_wall(passed, between, a, *model, w, mu, compliance, cones, wall, jump, across, turned)
                    kind[passed] = model.kind[passed]
                    for its_wall, its_jump in ((across, turned), (wall, jump)):
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
    w, mu, compliance, geometric, _ = active.laws
    r, status = np.zeros_like(a), Status(kind, np.zeros_like(a[:, 1:]), np.zeros(len(a)))
    impulses_of(a, *status, w, mu, compliance, geometric, r)
    return active.velocities(r, epsilon, centre) - w[:, None] * (r - a), status


@kernel
def impulses_of(a, kind, direction, turning, w, mu, compliance, geometric, r):
    """Fill ``r`` (m, 3) with the impulses of ``a`` in the cell of the kinds, ``direction`` (m, 2) and ``turning`` (m,)."""
    for i in range(a.shape[0]):
        size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
        if kind[i] == LINK:
            r[i, 0] = a[i, 0] * w[i] / (w[i] + compliance[i])
        if geometric[i] > 0.0:
            for k in range(1, 3):
                r[i, k] = a[i, k] * geometric[i] * w[i] / (1.0 + geometric[i] * w[i])
        elif kind[i] == STICK:
            r[i, 0] = a[i, 0]
            if mu[i] > 0.0:
                r[i, 1] = a[i, 1]
                r[i, 2] = a[i, 2]
        elif kind[i] == SLIDE:
            r[i, 0] = a[i, 0]
            limit = mu[i] * a[i, 0]
            # the limit is zero where a contact closes: turning, infinite there, is what still leaves a matrix
            turning[i] = min(max(size / max(limit, 1e-300) - 1.0, 0.0), 1e12)
            for k in range(2):
                direction[i, k] = a[i, 1 + k] / size
                r[i, 1 + k] = limit * direction[i, k]


@kernel
def next_wall(a, along, kind, direction, mu, cones):
    """(interaction, between sticking and sliding rather than open and not, distance of its wall, distance within which a
    sliding direction turns by 1), distances in parts of ``along`` (m, 3)."""
    nearest = np.inf
    turn = np.inf
    where = -1
    between = False
    for i in range(a.shape[0]):
        if cones[i] == BOTH:
            continue
        # wall a_n = 0 of open contacts and slack wires
        inward = -1.0 if (kind[i] == OPEN) == (cones[i] == CONTACT) else 1.0
        speed = -inward * along[i, 0]
        if speed > 0.0 and max(inward * a[i, 0], 0.0) < nearest * speed and (kind[i] != STICK or mu[i] == 0.0):
            nearest, where, between = max(inward * a[i, 0], 0.0) / speed, i, False
        if mu[i] == 0.0 or (kind[i] != STICK and kind[i] != SLIDE):
            continue
        inward = 1.0 if kind[i] == SLIDE else -1.0
        # |a_t|^2 - (mu a_n)^2 = c0 + 2 c1 x + c2 x^2 at the distance x, positive where it slides
        c0 = inward * (a[i, 1] ** 2 + a[i, 2] ** 2 - (mu[i] * a[i, 0]) ** 2)
        c1 = inward * (a[i, 1] * along[i, 1] + a[i, 2] * along[i, 2] - mu[i] ** 2 * a[i, 0] * along[i, 0])
        c2 = inward * (along[i, 1] ** 2 + along[i, 2] ** 2 - (mu[i] * along[i, 0]) ** 2)
        # least positive root, by the form that does not cancel
        distance = np.inf
        if c0 <= 0.0:
            if c1 < 0.0:
                distance = 0.0
            elif c2 < 0.0:
                distance = -2.0 * c1 / c2
        elif c1**2 - c2 * c0 >= 0.0:
            root = np.sqrt(c1**2 - c2 * c0)
            if c1 < 0.0:
                distance = c0 / (root - c1)
            elif c2 < 0.0:
                distance = -(c1 + root) / c2
        if distance < nearest:
            nearest, where, between = distance, i, True
        # |tau x along_t| / |a_t|: rate at which the sliding direction turns
        if kind[i] == SLIDE:
            size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
            across = abs(direction[i, 0] * along[i, 2] - direction[i, 1] * along[i, 1])
            if size < turn * across:
                turn = size / across
    return where, between, nearest, turn


@kernel
def pass_wall(i, between, a, kind, direction, turning, w, mu, compliance, cones, wall, jump, across, turned):
    """Give interaction ``i`` its status behind the wall. Fill ``wall`` (3,), which grows into that cell, and ``jump`` (3,);
    ``across`` and ``turned`` (3,): what the derivative changes by beside ``jump wall^T``, as the direction of sliding does
    not turn any more."""
    wall[:] = 0.0
    jump[:] = 0.0
    across[:] = 0.0
    turned[:] = 0.0
    size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
    # sliding has kappa across across^T in the derivative, kappa = mu a_n / |a_t|; sticking has 1 for kappa, open has 0
    if kind[i] == SLIDE:
        across[1], across[2] = -direction[i, 1], direction[i, 0]
        kappa = 1.0 / (1.0 + turning[i])
        for k in range(1, 3):
            turned[k] = ((1.0 if between else 0.0) - kappa) * across[k]
    if cones[i] != CONTACT:
        wall[0] = -1.0 if kind[i] == OPEN else 1.0
        jump[0] = -w[i] / (w[i] + compliance[i])
        kind[i] = LINK if kind[i] == OPEN else OPEN
    # mu a_n = |a_t|: the part of a_t along tau comes free, or is bound to r_n
    elif between:
        inward = 1.0 if kind[i] == SLIDE else -1.0
        wall[0] = inward * mu[i]
        for k in range(1, 3):
            wall[k] = -inward * a[i, k] / size
            jump[k] = -a[i, k] / size
            direction[i, k - 1] = a[i, k] / size
        turning[i] = 0.0
        kind[i] = STICK if kind[i] == SLIDE else SLIDE
    # a_n = 0: r_n comes free, with r_t = mu r_n tau
    else:
        closes = kind[i] == OPEN
        wall[0] = 1.0 if closes else -1.0
        jump[0] = 1.0
        if mu[i] > 0.0:
            for k in range(1, 3):
                if closes:
                    direction[i, k - 1] = a[i, k] / size
                jump[k] = mu[i] * direction[i, k - 1]
        turning[i] = 1e12
        kind[i] = OPEN if not closes else SLIDE if mu[i] > 0.0 else STICK
