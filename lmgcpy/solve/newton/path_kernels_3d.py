"""Compiled parts of following a path in space: impulses, the next wall, and the change of the matrix there; see
``path_3d``."""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.rows import LINK, OPEN, SLIDE, STICK
from lmgcpy.solve.problems.problem import BOTH, CONTACT


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
            # the limit is zero when a contact closes, and turning infinite: the bound keeps the matrix finite
            turning[i] = min(max(size / max(limit, 1e-300) - 1.0, 0.0), 1e12)
            for k in range(2):
                direction[i, k] = a[i, 1 + k] / size
                r[i, 1 + k] = limit * direction[i, k]


@kernel
def next_wall(a, along, kind, direction, mu, cones):
    """(interaction that meets its wall first; whether this wall is the one between sticking and sliding, not ``a_n = 0``;
    its distance; distance within which a sliding direction turns by 1), distances in parts of ``along`` (m, 3)."""
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
        # least positive root, by the form without cancellation
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
    beside ``jump wall^T`` the derivative changes by ``turned across^T``, (3,) both, as the direction of sliding does not
    turn any more."""
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
