"""Compiled parts of a Newton step: the natural map with the statuses it shows, the rows of the sparse matrix,
its right-hand side, and impulses by its unknowns.

A contact that is closed holds its impulse in a product of disks: friction, and if contacts roll, rolling, and torsion in 3D
(a disk of one dimension is an interval). Each disk sticks or slides on its own.

Written with sparse products and masks they would take as long as the factorisation between them: measured a step, 4700
interactions in 2D, 5.4 ms for the matrix and 1.8 ms for the maps, against 0.8 ms and 0.3 ms here, and 8 ms.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.problems.problem import BOTH, CONTACT, PULL

OPEN, LINK, STICK = range(3)
"""Statuses. That of a closed contact is STICK, plus 1 if friction slides, 2 if it rolls, 4 if it twists."""
SLIDE = STICK + 1


def slides(kind, g):
    """Whether disk ``g`` of a contact with this status slides."""
    return kind >= STICK and ((kind - STICK) >> g & 1) == 1


def disk_columns(g, d):
    """First column of disk ``g`` and the one after its last, in dimension d."""
    if g == 0:
        return 1, d
    if g == 1:
        return d, 2 * d - 1
    return 2 * d - 1, 2 * d


@kernel
def natural_map(u, r, w, shares, compliance, geometric, cones, d, error, kind, direction, turning):
    """Fill ``error`` (m, D) with ``w (r - react(w I, u - w r))`` and the rest with the status of every interaction;
    ``shares`` (m, disks): radii of the disks over r_n."""
    for i in range(r.shape[0]):
        # normal part of react(w I, -w a) at a = r - u / w
        a_n = r[i, 0] - u[i, 0] / w[i]
        pressed = cones[i] == CONTACT and a_n > 0.0
        taut = cones[i] == BOTH or (cones[i] == PULL and a_n < 0.0)
        normal = 0.0
        kind[i] = OPEN
        if pressed:
            normal = a_n
            kind[i] = STICK
        elif taut:
            normal = w[i] * a_n / (w[i] + compliance[i])
            kind[i] = LINK
        error[i, 0] = w[i] * (r[i, 0] - normal)
        for g in range(shares.shape[1]):
            first, end = disk_columns(g, d)
            # projection of a on the disk of radius c a_n
            size = 0.0
            for k in range(first, end):
                direction[i, k - 1] = r[i, k] - u[i, k] / w[i]
                size += direction[i, k - 1] ** 2
            size = np.sqrt(size)
            limit = shares[i, g] * a_n if pressed else 0.0
            beyond = limit > 0.0 and size > limit
            # |a_g| / (c a_n) - 1: resistance of a sliding direction to turning, in parts of w
            turning[i, g] = size / limit - 1.0 if beyond else 0.0
            if beyond:
                kind[i] += 1 << g
            for k in range(first, end):
                a_k = direction[i, k - 1]
                direction[i, k - 1] = a_k / size if beyond else 0.0
                if beyond:
                    a_k = limit * direction[i, k - 1]
                elif g == 0 and geometric[i] > 0.0:  # across a link with geometric stiffness
                    a_k = a_k * geometric[i] * w[i] / (1.0 + geometric[i] * w[i])
                elif limit == 0.0:
                    a_k = 0.0
                error[i, k] = w[i] * (r[i, k] - a_k)


@kernel
def local_maps(kind, direction, turning, shares, geometric, d, free, E, S, across):
    """Fill ``free`` (m,) with the number of free impulses of every interaction, E (m, D, D) with its impulses by these, in
    columns, and S (m, D, D) with the velocities that are given, in rows; ``across`` (m, D - 1) with ``turning`` of the rows
    after the first, zero if a row does not turn."""
    E[:, :, :] = 0.0
    S[:, :, :] = 0.0
    across[:, :] = 0.0
    for i in range(kind.shape[0]):
        free[i] = 0
        if geometric[i] > 0.0:  # a link has its rows across it always, the row along it only if it is taut
            first = 0 if kind[i] == LINK else 1
            free[i] = d - first
            for k in range(free[i]):
                E[i, first + k, k] = 1.0
                S[i, k, first + k] = 1.0
            continue
        if kind[i] == OPEN:
            continue
        # closed: r_n is free and u_n is given
        free[i] = 1
        E[i, 0, 0] = 1.0
        S[i, 0, 0] = 1.0
        if kind[i] == LINK:
            continue
        for g in range(shares.shape[1]):
            if shares[i, g] == 0.0:
                continue
            first, end = disk_columns(g, d)
            # sticking: all of the disk's r is free, all of its u is given
            if not slides(kind[i], g):
                for k in range(first, end):
                    E[i, k, free[i]] = 1.0
                    S[i, free[i], k] = 1.0
                    free[i] += 1
                continue
            # sliding: r = c r_n tau; in a disk of two dimensions the part across tau is free as well
            for k in range(first, end):
                E[i, k, 0] = shares[i, g] * direction[i, k - 1]
            if end - first == 2:
                E[i, first, free[i]] = S[i, free[i], first] = -direction[i, first]
                E[i, first + 1, free[i]] = S[i, free[i], first + 1] = direction[i, first - 1]
                across[i, free[i] - 1] = turning[i, g]
                free[i] += 1


@kernel
def newton_rows(first, column, block, order, unknown, free, E, S, diagonal, pointer, index, entry):
    """Rows of ``S W E + diagonal``, the interactions in ``order`` (k,); returns the number of entries.

    ``first``, ``column``, ``block``: W by block rows; ``unknown``: the first unknown of every interaction; ``diagonal``
    (m, d), of which the first ``free`` count. Entries that are exactly zero are left out, but for the diagonal.
    """
    d = block.shape[1]
    given = np.zeros(d)
    row = 0
    count = 0
    pointer[0] = 0
    for i in order:
        for a in range(free[i]):
            at = count  # the diagonal comes first, for where W has no block there
            index[at] = row
            entry[at] = diagonal[i, a]
            count += 1
            for k in range(first[i], first[i + 1]):
                j = column[k]
                if free[j] == 0:
                    continue
                # row a of S_i W_ij
                for c in range(d):
                    given[c] = 0.0
                    for b in range(d):
                        given[c] += S[i, a, b] * block[k, b, c]
                # times E_j
                for b in range(free[j]):
                    value = 0.0
                    for c in range(d):
                        value += given[c] * E[j, c, b]
                    if i == j and a == b:
                        entry[at] += value
                    elif value != 0.0:
                        index[count] = unknown[j] + b
                        entry[count] = value
                        count += 1
            row += 1
            pointer[row] = count
    return count


@kernel
def velocities_given(u, order, S, free, right):
    """Fill ``right`` (n,) with ``S u`` of the interactions in ``order`` (k,), S (k, d, d) with ``free`` (k,) rows.

    The entries behind them, of a periodic cell, are not changed.
    """
    d = u.shape[1]
    row = 0
    for k in range(order.shape[0]):
        for a in range(free[k]):
            value = 0.0
            for b in range(d):
                value += S[k, a, b] * u[order[k], b]
            right[row] = value
            row += 1


@kernel
def impulses_by(x, order, E, free, r):
    """Fill ``r`` (m, d) with ``E x`` of the interactions in ``order`` (k,), E (k, d, d) with ``free`` (k,) columns.

    The entries of ``x`` behind them, of a periodic cell, are not read.
    """
    d = r.shape[1]
    first = 0
    for k in range(order.shape[0]):
        for a in range(d):
            value = 0.0
            for b in range(free[k]):
                value += E[k, a, b] * x[first + b]
            r[order[k], a] = value
        first += free[k]


@kernel
def parity(order):
    """1.0 for an even permutation (n,) of 0, 1, ..., -1.0 for an odd one."""
    # a cycle of k places is k - 1 transpositions
    seen = np.zeros(order.shape[0], np.bool_)
    sign = 1.0
    for i in range(order.shape[0]):
        j = order[i]
        while not seen[j]:
            seen[j] = True
            j = order[j]
            if not seen[j]:
                sign = -sign
    return sign
