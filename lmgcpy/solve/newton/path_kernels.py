"""Compiled parts of following a path in the plane: the next bend, the change of the matrix there, and steps
behind it.

Between two bends a path is a straight line in ``a = r - u / w``, in a cell that belongs to the statuses: open contacts
``a_n < 0``; sticking ``|a_t| < mu a_n``; sliding to ``tau``, ``tau a_t > mu a_n > 0``; taut wires ``a_n < 0``. Each
disk of a contact has its wall between sticking and sliding. The maps
from a to impulses in two cells that touch agree on the wall between them, so that they differ by ``jump wall^T``, with
``wall`` the gradient of the function that is zero on the wall.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.rows import LINK, OPEN, STICK, slides
from lmgcpy.solve.problems.problem import BOTH, CONTACT


def meets_open(i, kind, shares):
    """Whether the way of interaction ``i`` may end at ``a_n = 0``. If a disk of a contact sticks, it may not, as the wall
    of that disk comes first."""
    if kind[i] >= STICK:
        for g in range(shares.shape[1]):
            if shares[i, g] > 0.0 and not slides(kind[i], g):
                return False
    return True


@kernel
def next_bend(a, along, kind, direction, shares, cones):
    """(interaction, side, distance) of the first bend on the way from ``a`` along ``along``, both (m, D).

    ``side``: ``tau (1 + g)``, tau of the sliding on one side of the wall, g the number of the disk; 0 at the wall
    ``a_n = 0``. The distance is in parts of ``along``, infinite if the path does not bend any more.
    """
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
        if kind[i] < STICK:
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
def pass_bend(i, side, a, kind, direction, w, shares, compliance, cones, wall, jump):
    """Give interaction ``i`` its status beyond the bend; fill ``wall`` (D,), which grows into the new cell, and ``jump``
    (D,)."""
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
        kind[i] = STICK if closes else OPEN
        for g in range(shares.shape[1]):
            if shares[i, g] > 0.0:
                if closes:
                    direction[i, g] = 1.0 if a[i, 1 + g] > 0.0 else -1.0
                    kind[i] += 1 << g
                jump[1 + g] = shares[i, g] * direction[i, g]
            if not closes:
                direction[i, g] = 0.0


@kernel
def change_of_matrix(i, jump, epsilon, first, row, block, w, g):
    """Fill ``g`` (m, d) with ``(W + epsilon w - w) jump``, ``jump`` in interaction ``i``: ``g wall^T`` is what the bend
    adds to the matrix. ``first``, ``row``, ``block``: the transpose of W by block rows."""
    d = g.shape[1]
    g[:, :] = 0.0
    # block column of W times jump
    for k in range(first[i], first[i + 1]):
        j = row[k]
        for c in range(d):
            for b in range(d):
                g[j, c] += block[k, b, c] * jump[b]
    # the dashpot epsilon w, less the w of F's last term
    for c in range(d):
        g[i, c] += (epsilon - 1.0) * w[i] * jump[c]


@kernel
def change_of_a(r, given, Wr, epsilon, w, count, at, walls, changes, y):
    """Fill ``y`` (m, d) with the change of ``a`` that changes F by ``given`` (m, d).

    ``r`` (m, d) and ``Wr`` (m d,): changes of impulses and velocities by ``given`` with the matrix that was factorised;
    ``epsilon``, ``w`` (m,): its dashpots. ``at`` (count,), ``walls`` (count, d) and ``changes`` (count, m, d): interaction,
    wall and ``A^-1 g / (1 + wall . A^-1 g)`` of every bend since, A the matrix before the bend. They turn the solution with
    the factorised matrix into the solution with the present matrix.
    """
    m, d = y.shape
    # F = W r + q + epsilon w (r - centre) - w (r - a)
    for j in range(m):
        for c in range(d):
            y[j, c] = r[j, c] + (given[j, c] - Wr[j * d + c] - epsilon * w[j] * r[j, c]) / w[j]
    flat = y.reshape(m * d)  # the compiler vectorises one loop over all components
    for k in range(count):
        # Sherman-Morrison: y <- y - (wall . y) A^-1 g / (1 + wall . A^-1 g)
        part = 0.0
        for c in range(d):
            part += walls[k, c] * y[at[k], c]
        if part != 0.0:
            change = changes[k].reshape(m * d)
            for j in range(m * d):
                flat[j] -= part * change[j]
