"""Compiled parts of following a path for scenes with rolling contacts; for all others see ``path_kernels``.

Each disk of a contact has its wall, ``|a_t| = mu a_n``, ``|a_r| = mu_r a_n`` and in 3D ``|a_z| = mu_z a_n``; the last wall
is ``a_n = 0``. The direction in a disk of one dimension (all disks in 2D, torsion in 3D) does not turn.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.rolling_rows import CLOSED, disk_columns
from lmgcpy.solve.newton.rows import LINK, OPEN
from lmgcpy.solve.problems.problem import BOTH, CONTACT


def slides(kind, g):
    """Whether disk ``g`` of a contact with this status slides."""
    return kind >= CLOSED and ((kind - CLOSED) >> g & 1) == 1


def meets_open(i, kind, shares):
    """Whether the way of interaction ``i`` may end at ``a_n = 0``. If a disk of a contact sticks, it may not, as the wall
    of that disk comes first."""
    if kind[i] >= CLOSED:
        for g in range(shares.shape[1]):
            if shares[i, g] > 0.0 and not slides(kind[i], g):
                return False
    return True


# ------------------------------------------------------------------------------------------------------- in the plane


@kernel
def next_rolling_bend(a, along, kind, direction, shares, cones):
    """As ``path_kernels.next_bend``. ``side``: ``tau (1 + g)``, tau of the sliding on one side of the wall, g the number of
    the disk; 0 at the wall ``a_n = 0``."""
    nearest = np.inf
    where = -1
    side = 0.0
    for i in range(a.shape[0]):
        if cones[i] == BOTH:
            continue
        # wall a_n = 0 of open contacts and slack wires, and of contacts all of whose disks slide
        if meets_open(i, kind, shares):
            inward = -1.0 if (kind[i] == OPEN) == (cones[i] == CONTACT) else 1.0
            speed = -inward * along[i, 0]
            if speed > 0.0 and max(inward * a[i, 0], 0.0) < nearest * speed:
                nearest, where, side = max(inward * a[i, 0], 0.0) / speed, i, 0.0
        if kind[i] < CLOSED:
            continue
        for g in range(shares.shape[1]):
            share = shares[i, g]
            if share == 0.0:
                continue
            # walls tau a_g = c a_n between sticking and sliding to tau
            inward = -1.0 if slides(kind[i], g) else 1.0
            for tau in (-1.0, 1.0):
                if inward < 0.0 and tau != direction[i, g]:
                    continue
                depth = inward * (share * a[i, 0] - tau * a[i, 1 + g])
                speed = inward * (tau * along[i, 1 + g] - share * along[i, 0])
                if speed > 0.0 and max(depth, 0.0) < nearest * speed:
                    nearest, where, side = max(depth, 0.0) / speed, i, tau * (1.0 + g)
    return where, side, nearest


@kernel
def pass_rolling_bend(i, side, a, kind, direction, w, shares, compliance, cones, wall, jump):
    """As ``path_kernels.pass_bend``."""
    wall[:] = 0.0
    jump[:] = 0.0
    # gradient of the wall, and r_behind - r_before = jump (wall . a)
    if cones[i] != CONTACT:
        wall[0] = -1.0 if kind[i] == OPEN else 1.0
        jump[0] = -w[i] / (w[i] + compliance[i])
        kind[i] = LINK if kind[i] == OPEN else OPEN
    # tau a_g = c a_n: r_g comes free, or is bound to r_n
    elif side != 0.0:
        g = int(abs(side)) - 1
        tau = 1.0 if side > 0.0 else -1.0
        inward = 1.0 if slides(kind[i], g) else -1.0  # into the cell where it sticks
        wall[0] = inward * shares[i, g]
        wall[1 + g] = -inward * tau
        jump[1 + g] = -tau
        kind[i] += -(1 << g) if inward > 0.0 else 1 << g
        direction[i, g] = 0.0 if inward > 0.0 else tau
    # a_n = 0: r_n comes free, with r_g = c r_n tau in every disk
    else:
        closes = kind[i] == OPEN
        wall[0] = 1.0 if closes else -1.0
        jump[0] = 1.0
        kind[i] = CLOSED if closes else OPEN
        for g in range(shares.shape[1]):
            if shares[i, g] > 0.0:
                if closes:
                    direction[i, g] = 1.0 if a[i, 1 + g] > 0.0 else -1.0
                    kind[i] += 1 << g
                jump[1 + g] = shares[i, g] * direction[i, g]
            if not closes:
                direction[i, g] = 0.0


# ----------------------------------------------------------------------------------------------------------- in space


@kernel
def rolling_impulses_of(a, kind, direction, turning, w, shares, compliance, geometric, r):
    """As ``path_kernels_3d.impulses_of``; a, r (m, 6), ``direction`` (m, 5), ``turning`` (m, 3)."""
    for i in range(a.shape[0]):
        # a taut link: r_n = w a_n / (w + C), and kappa w a_t / (1 + kappa w) across it
        if kind[i] == LINK:
            r[i, 0] = a[i, 0] * w[i] / (w[i] + compliance[i])
        if geometric[i] > 0.0:
            for k in range(1, 3):
                r[i, k] = a[i, k] * geometric[i] * w[i] / (1.0 + geometric[i] * w[i])
        if kind[i] < CLOSED:
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
def next_rolling_wall(a, along, kind, direction, shares, cones):
    """As ``path_kernels_3d.next_wall``; the number of the disk replaces ``between``, -1 for the wall ``a_n = 0``."""
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
        if kind[i] < CLOSED:
            continue
        for g in range(shares.shape[1]):
            share = shares[i, g]
            if share == 0.0:
                continue
            first, end = disk_columns(g, 3)
            inward = 1.0 if slides(kind[i], g) else -1.0
            # |a_g|^2 - (c a_n)^2 = c0 + 2 c1 x + c2 x^2 at the distance x, positive where it slides
            c0 = -((share * a[i, 0]) ** 2)
            c1 = -(share**2) * a[i, 0] * along[i, 0]
            c2 = -((share * along[i, 0]) ** 2)
            for k in range(first, end):
                c0 += a[i, k] ** 2
                c1 += a[i, k] * along[i, k]
                c2 += along[i, k] ** 2
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
def pass_rolling_wall(i, disk, a, kind, direction, turning, w, shares, compliance, cones, wall, jump, across, turned):
    """As ``path_kernels_3d.pass_wall``; ``across`` and ``turned`` (2, 6), one row for each disk that turns."""
    wall[:] = 0.0
    jump[:] = 0.0
    across[:, :] = 0.0
    turned[:, :] = 0.0
    # sliding has kappa across across^T in the derivative, kappa = c a_n / |a_g|; sticking has 1 for kappa, open has 0
    for g in range(2):
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
        kind[i] = CLOSED if closes else OPEN
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
