"""Compiled parts of a Newton step for scenes with rolling contacts; for all others see ``rows``.

A contact that is closed holds its impulse in a product of disks: friction, rolling, and torsion in 3D (one of one dimension
is an interval). Each sticks or slides on its own, as friction alone does; the number of the status is :data:`CLOSED` and
a bit for each disk that slides.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.newton.rows import LINK, OPEN
from lmgcpy.solve.problems.problem import BOTH, CONTACT, PULL

CLOSED = 4
"""Status of a contact all of whose disks stick; plus 1 if friction slides, 2 if it rolls, 4 if it twists."""


def disk_columns(g, d):
    """First column of disk ``g`` and the one after its last, in dimension d."""
    if g == 0:
        return 1, d
    if g == 1:
        return d, 2 * d - 1
    return 2 * d - 1, 2 * d


@kernel
def rolling_natural_map(u, r, w, shares, compliance, geometric, cones, d, error, kind, direction, turning):
    """As ``rows.natural_map``; ``shares`` (m, disks): radii of the disks over r_n; ``turning`` (m, disks)."""
    for i in range(r.shape[0]):
        # normal part of react(w I, -w a) at a = r - u / w
        a_n = r[i, 0] - u[i, 0] / w[i]
        pressed = cones[i] == CONTACT and a_n > 0.0
        taut = cones[i] == BOTH or (cones[i] == PULL and a_n < 0.0)
        normal = 0.0
        kind[i] = OPEN
        if pressed:
            normal = a_n
            kind[i] = CLOSED
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
            slides = limit > 0.0 and size > limit
            turning[i, g] = size / limit - 1.0 if slides else 0.0
            if slides:
                kind[i] += 1 << g
            for k in range(first, end):
                a_k = direction[i, k - 1]
                direction[i, k - 1] = a_k / size if slides else 0.0
                if slides:
                    a_k = limit * direction[i, k - 1]
                elif g == 0 and geometric[i] > 0.0:  # across a link with geometric stiffness
                    a_k = a_k * geometric[i] * w[i] / (1.0 + geometric[i] * w[i])
                elif limit == 0.0:
                    a_k = 0.0
                error[i, k] = w[i] * (r[i, k] - a_k)


@kernel
def rolling_local_maps(kind, direction, turning, shares, geometric, d, free, E, S, across):
    """As ``rows.local_maps``; ``across`` (m, D - 1): ``turning`` of the rows after the first, zero if a row does not
    turn."""
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
            if not (kind[i] - CLOSED) >> g & 1:
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
