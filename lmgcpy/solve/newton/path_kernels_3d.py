"""Compiled parts of following a path in space: impulses, the next wall, and the change of the matrix there; see
``path_3d``. The direction in a disk of one dimension, torsion, does not turn."""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.path_kernels import meets_open
from lmgcpy.solve.newton.rows import LINK, OPEN, STICK, disk_columns, slides
from lmgcpy.solve.problems.problem import BOTH, CONTACT


@kernel
def impulses_of(a, kind, direction, turning, w, shares, compliance, geometric, r):
    """Fill ``r`` (m, D) with the impulses of ``a`` in the cell of the kinds, ``direction`` (m, D - 1) and ``turning``
    (m, disks)."""
    for i in range(a.shape[0]):
        # a taut link: r_n = w a_n / (w + C), and kappa w a_t / (1 + kappa w) across it
        if kind[i] == LINK:
            r[i, 0] = a[i, 0] * w[i] / (w[i] + compliance[i])
        if geometric[i] > 0.0:
            for k in range(1, 3):
                r[i, k] = a[i, k] * geometric[i] * w[i] / (1.0 + geometric[i] * w[i])
        if kind[i] < STICK:
            continue
        r[i, 0] = a[i, 0]
        for g in range(shares.shape[1]):
            first, end = disk_columns(g, 3)
            # sticking: r_g = a_g
            if not slides(kind[i], g):
                if shares[i, g] > 0.0:
                    for k in range(first, end):
                        r[i, k] = a[i, k]
                continue
            # sliding: r_g = c a_n a_g / |a_g|
            size = size_in(a, i, first, end)
            limit = shares[i, g] * a[i, 0]
            # the limit is zero when a contact closes, and turning infinite: the bound keeps the matrix finite
            turning[i, g] = min(max(size / max(limit, 1e-300) - 1.0, 0.0), 1e12)
            for k in range(first, end):
                direction[i, k - 1] = a[i, k] / size
                r[i, k] = limit * direction[i, k - 1]


def size_in(a, i, first, end):
    """Length of the part of row ``i`` between two columns."""
    square = 0.0
    for k in range(first, end):
        square += a[i, k] ** 2
    return np.sqrt(square)


@kernel
def next_wall(a, along, kind, direction, shares, cones):
    """(interaction that meets its wall first; the disk whose wall between sticking and sliding it is, -1 at ``a_n = 0``;
    its distance; distance within which a sliding direction turns by 1), distances in parts of ``along`` (m, D)."""
    nearest = np.inf
    turn = np.inf
    where = -1
    disk = -1
    for i in range(a.shape[0]):
        if cones[i] == BOTH:
            continue
        if meets_open(i, kind, shares):
            inward = -1.0 if (kind[i] == OPEN) == (cones[i] == CONTACT) else 1.0
            speed = -inward * along[i, 0]
            if speed > 0.0 and max(inward * a[i, 0], 0.0) < nearest * speed:
                nearest, where, disk = max(inward * a[i, 0], 0.0) / speed, i, -1
        if kind[i] < STICK:
            continue
        for g in range(shares.shape[1]):
            share = shares[i, g]
            if share == 0.0:
                continue
            first, end = disk_columns(g, 3)
            inward = 1.0 if slides(kind[i], g) else -1.0
            # |a_g|^2 - (c a_n)^2 = c0 + 2 c1 x + c2 x^2 at the distance x, positive where it slides
            c0 = c1 = c2 = 0.0
            for k in range(first, end):
                c0 += a[i, k] ** 2
                c1 += a[i, k] * along[i, k]
                c2 += along[i, k] ** 2
            c0 -= (share * a[i, 0]) ** 2
            c1 -= share**2 * a[i, 0] * along[i, 0]
            c2 -= (share * along[i, 0]) ** 2
            distance = least_root(inward * c0, inward * c1, inward * c2)
            if distance < nearest:
                nearest, where, disk = distance, i, g
            # |tau x along_g| / |a_g|: rate at which the sliding direction turns
            if inward > 0.0 and end - first == 2:
                size = size_in(a, i, first, end)
                across = abs(direction[i, first - 1] * along[i, first + 1] - direction[i, first] * along[i, first])
                if size < turn * across:
                    turn = size / across
    return where, disk, nearest, turn


def least_root(c0, c1, c2):
    """Least positive root of ``c0 + 2 c1 x + c2 x^2`` at which the polynomial falls, by the form without cancellation;
    infinite if there is none."""
    if c0 <= 0.0:
        if c1 < 0.0:
            return 0.0
        return -2.0 * c1 / c2 if c2 < 0.0 else np.inf
    if c1**2 - c2 * c0 >= 0.0:
        root = np.sqrt(c1**2 - c2 * c0)
        if c1 < 0.0:
            return c0 / (root - c1)
        if c2 < 0.0:
            return -(c1 + root) / c2
    return np.inf


@kernel
def pass_wall(i, disk, a, kind, direction, turning, w, shares, compliance, cones, wall, jump, across, turned):
    """Give interaction ``i`` its status behind the wall. Fill ``wall`` (D,), which grows into that cell, and ``jump`` (D,);
    beside ``jump wall^T`` the derivative changes by ``turned across^T`` of each disk that turns, (1, D) or (2, D) both, as
    the direction of sliding does not turn any more."""
    wall[:] = 0.0
    jump[:] = 0.0
    across[:, :] = 0.0
    turned[:, :] = 0.0
    # sliding has kappa across across^T in the derivative, kappa = c a_n / |a_g|; sticking has 1 for kappa, open has 0
    for g in range(across.shape[0]):
        if slides(kind[i], g) and (disk < 0 or disk == g):
            first, _ = disk_columns(g, 3)
            across[g, first], across[g, first + 1] = -direction[i, first], direction[i, first - 1]
            kappa = 1.0 / (1.0 + turning[i, g])
            for k in range(first, first + 2):
                turned[g, k] = ((1.0 if disk == g else 0.0) - kappa) * across[g, k]
    if cones[i] != CONTACT:
        wall[0] = -1.0 if kind[i] == OPEN else 1.0
        jump[0] = -w[i] / (w[i] + compliance[i])
        kind[i] = LINK if kind[i] == OPEN else OPEN
    # c a_n = |a_g|: the part of a_g along tau comes free, or is bound to r_n
    elif disk >= 0:
        first, end = disk_columns(disk, 3)
        size = size_in(a, i, first, end)
        inward = 1.0 if slides(kind[i], disk) else -1.0
        wall[0] = inward * shares[i, disk]
        for k in range(first, end):
            wall[k] = -inward * a[i, k] / size
            jump[k] = -a[i, k] / size
            direction[i, k - 1] = a[i, k] / size
        turning[i, disk] = 0.0
        kind[i] += -(1 << disk) if inward > 0.0 else 1 << disk
    # a_n = 0: r_n comes free, with r_g = c r_n tau in every disk
    else:
        closes = kind[i] == OPEN
        wall[0] = 1.0 if closes else -1.0
        jump[0] = 1.0
        kind[i] = STICK if closes else OPEN
        for g in range(shares.shape[1]):
            if shares[i, g] == 0.0:
                continue
            first, end = disk_columns(g, 3)
            size = size_in(a, i, first, end)
            for k in range(first, end):
                if closes:
                    direction[i, k - 1] = a[i, k] / size
                jump[k] = shares[i, g] * direction[i, k - 1]
            turning[i, g] = 1e12
            if closes:
                kind[i] += 1 << g
