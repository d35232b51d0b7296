"""Following the path to the solution of a proximal problem in space, where Newton steps do not find its statuses.

The path is that of ``path``, but sliding contacts turn on the way, so that it is curved between its bends. It is followed
along its tangent, at most until a sliding direction turns by :data:`ANGLE`, and brought back by Newton steps across the
tangent (Allgower, Georg 1990, Numerical Continuation Methods). A bend changes the matrix by rank one here as well, but all
that slide change it a little: it is factorised at every step. So paths are given up sooner than in the plane.

The end is near the solution: Newton steps from its statuses do the rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.jit import kernel
from lmgcpy.solve.active_set import ActiveSet, Status
from lmgcpy.solve.newton_kernels import LINK, OPEN, SLIDE, STICK
from lmgcpy.solve.path import cell_of, map_step
from lmgcpy.solve.problem import BOTH, CONTACT

ANGLE = 0.3
"""By which a sliding direction may turn in a step [rad]."""
NEAR = 0.02
"""Distance from the path, in parts of what is left of the error at its start, from which it is brought back."""
LEAST_REST = 0.02
"""What is left counts as this much at least."""
CORRECTIONS = 4
"""Newton steps with one factorisation, at most."""
CLOSER = 0.7
"""One that leaves more than this part of the distance is not made."""
FAR = 30.0
"""A path is given up where ``rest`` has grown to this."""


class Curve(NamedTuple):
    """Where a path ended."""

    status: Status | None
    """Statuses near the solution of the proximal problem, or None where the path was given up."""
    bends: int
    factorisations: int


def follow_curve(active: ActiveSet, start: np.ndarray, epsilon: float, centre: np.ndarray, most: int) -> Curve:
    """Come near the solution of the proximal problem by a path from ``a = start`` (m, 3), in ``most`` steps."""
    _, mu, _, cones = active.laws
    a = start.copy()
    kind = cell_of(active, a)[1].kind
    push, status = map_of(active, a, kind, epsilon, centre)
    value = push
    size = float(np.linalg.norm(push))
    rest, way = 1.0, -1.0
    wall, before = np.zeros(3), (np.zeros_like(a), way)
    passed = -1
    bends = factorisations = 0
    try:
        for _ in range(most):
            factors = active.factors(status, epsilon)
            factorisations += 1
            along = way * map_step(active, factors, epsilon, push)
            away = value - rest * push
            enough = NEAR * max(abs(rest), LEAST_REST) * size
            distance = float(np.linalg.norm(away))
            if distance > enough:
                square = float(np.vdot(along, along)) + 1.0
                for _ in range(CORRECTIONS):
                    back = -map_step(active, factors, epsilon, away)
                    share = -float(np.vdot(back, along)) / square
                    nearer, its_rest = a + back + share * along, rest + share * way
                    value, there = map_of(active, nearer, kind, epsilon, centre)
                    away = value - its_rest * push
                    left = float(np.linalg.norm(away))
                    if not left < CLOSER * distance:
                        break
                    a, rest, status, distance = nearer, its_rest, there, left
                    if distance <= enough:
                        break
                factors = active.factors(status, epsilon)
                factorisations += 1
                along = way * map_step(active, factors, epsilon, push)
            ahead = wall @ along[passed] if passed >= 0 else np.vdot(before[0], along) + before[1] * way
            if ahead < 0.0:
                way, along = -way, -along
            before = along, way
            passed, between, reach, turn = next_wall(a, along, kind, status.direction, mu, cones)
            to_end = rest if way < 0.0 else np.inf
            length = min(reach, turn * ANGLE, to_end)
            if not np.isfinite(length) or abs(rest) > FAR:
                break
            a, rest = a + length * along, rest + length * way
            if length == to_end:
                return Curve(cell_of(active, a)[1], bends, factorisations)
            if length == reach:
                bends += 1
                pass_wall(passed, between, a, kind, mu, cones, wall)
            else:
                passed = -1
            value, status = map_of(active, a, kind, epsilon, centre)
    except RuntimeError:  # singular to round-off
        pass
    return Curve(None, bends, factorisations)


def map_of(
    active: ActiveSet, a: np.ndarray, kind: np.ndarray, epsilon: float, centre: np.ndarray
) -> tuple[np.ndarray, Status]:
    """F(a) (m, 3) with these kinds of statuses (m,), and the statuses with their directions and turning."""
    w, mu, compliance, _ = active.laws
    r, status = np.zeros_like(a), Status(kind, np.zeros_like(a[:, 1:]), np.zeros(len(a)))
    impulses_of(a, *status, w, mu, compliance, r)
    return active.velocities(r, epsilon, centre) - w[:, None] * (r - a), status


@kernel
def impulses_of(a, kind, direction, turning, w, mu, compliance, r):
    """Fill ``r`` (m, 3) with the impulses of ``a`` in the cell of the kinds, ``direction`` (m, 2) and ``turning`` (m,)."""
    for i in range(a.shape[0]):
        size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
        if kind[i] == LINK:
            r[i, 0] = a[i, 0] * w[i] / (w[i] + compliance[i])
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
        if kind[i] == SLIDE:
            size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
            across = abs(direction[i, 0] * along[i, 2] - direction[i, 1] * along[i, 1])
            if size < turn * across:
                turn = size / across
    return where, between, nearest, turn


@kernel
def pass_wall(i, between, a, kind, mu, cones, wall):
    """Give interaction ``i`` its kind behind the wall, and fill ``wall`` (3,), which grows into that cell."""
    wall[:] = 0.0
    if between:
        size = np.sqrt(a[i, 1] ** 2 + a[i, 2] ** 2)
        inward = 1.0 if kind[i] == SLIDE else -1.0
        wall[0] = inward * mu[i]
        for k in range(2):
            wall[1 + k] = -inward * a[i, 1 + k] / size
        kind[i] = STICK if kind[i] == SLIDE else SLIDE
    elif cones[i] == CONTACT:
        wall[0] = 1.0 if kind[i] == OPEN else -1.0
        kind[i] = OPEN if kind[i] != OPEN else SLIDE if mu[i] > 0.0 else STICK
    else:
        wall[0] = -1.0 if kind[i] == OPEN else 1.0
        kind[i] = LINK if kind[i] == OPEN else OPEN
