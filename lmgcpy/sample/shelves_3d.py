"""The open pockets of a bed of spheres, and the search for the lowest pocket that hosts a grain.

Pockets are sorted into racks by the coarsest radius that they may host. In a rack they are sorted into shelves by the
lowest bottom of any sphere that they may host. A grain searches the low shelves of the racks for its size. In a wide
grading the pockets that host only the finest grains are as many as the grains, and coarse grains need not search them.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
from typing import NamedTuple

import numpy as np

from lmgcpy.sample.bed_3d import (
    SphereBed,
    TangentCurve,
    added,
    along,
    between_roots,
    blocker,
    centre_at,
    negative,
    point_of,
    tangency,
)
from lmgcpy.sample.cells import NONE

RACKS = 8
"""Number of racks, for grains of several sizes."""


class SpherePockets(NamedTuple):
    """Pockets, open or free to be used again. The arrays are longer than the number of pockets."""

    supports: np.ndarray
    """Supports of each pocket, the base first, shape (n, 3)."""
    curve: np.ndarray
    """alpha, beta and w of the curve of each pocket, shape (n, 3, 3)."""
    first: np.ndarray
    """Ends of the interval of s [m] that a pocket may host."""
    last: np.ndarray
    following: np.ndarray
    """The next pocket on the same shelf or in another list, -1 for none."""
    met: np.ndarray
    """The support that the last grain tried in the pocket would have overlapped, or NONE."""


class Shelves(NamedTuple):
    """The open pockets, in a linked list for each shelf."""

    head: np.ndarray
    """First pocket on each shelf, -1 for none; shape (racks, shelves)."""
    lowest: np.ndarray
    """Lowest shelf of each rack that may hold a pocket; the shelves below it are empty."""
    height: float
    """Height of a shelf [m]."""
    finest: float
    """Radius of the finest grain [m]."""
    coarsest: float
    """Radius of the coarsest grain [m]."""
    store: np.ndarray
    """The number of pockets ever made, and the first free one, -1 for none."""


def new_pockets(size):
    """Arrays for ``size`` pockets."""
    return SpherePockets(
        np.empty((size, 3), np.int64), np.empty((size, 3, 3)), np.empty(size), np.empty(size), np.empty(size, np.int64),
        np.empty(size, np.int64),
    )  # fmt: skip


def new_shelves(shelf_count, height, finest, coarsest):
    """Empty shelves."""
    rack_count = RACKS if finest < coarsest else 1
    head = np.full((rack_count, shelf_count), -1, np.int64)
    return Shelves(head, np.full(rack_count, shelf_count), height, finest, coarsest, np.array([0, -1]))


def enlarged(pockets: SpherePockets):
    """Copy of the pockets in arrays twice as long."""
    size = len(pockets.first)
    larger = new_pockets(2 * size)
    larger.supports[:size], larger.curve[:size] = pockets.supports, pockets.curve
    larger.first[:size], larger.last[:size] = pockets.first, pockets.last
    larger.following[:size], larger.met[:size] = pockets.following, pockets.met
    return larger


def curve_of(n, pockets: SpherePockets):
    """The curve of a pocket."""
    c = pockets.curve
    return TangentCurve(
        (c[n, 0, 0], c[n, 0, 1], c[n, 0, 2]), (c[n, 1, 0], c[n, 1, 1], c[n, 1, 2]), (c[n, 2, 0], c[n, 2, 1], c[n, 2, 2])
    )  # fmt: skip


def add(supports, curve: TangentCurve, first, last, bed: SphereBed, pockets: SpherePockets, shelves: Shelves):
    """The pockets with one more, put on its shelf."""
    n = shelves.store[1]
    if n >= 0:
        shelves.store[1] = pockets.following[n]
    else:
        n = shelves.store[0]
        shelves.store[0] += 1
        if n == len(pockets.first):
            pockets = enlarged(pockets)
    for i in range(3):
        pockets.supports[n, i] = supports[i]
        pockets.curve[n, 0, i], pockets.curve[n, 1, i], pockets.curve[n, 2, i] = curve.alpha[i], curve.beta[i], curve.w[i]
    pockets.first[n], pockets.last[n] = first, last
    # Bottom z - r of the pocket: z is concave along the curve and dz/dr >= 1, so that z - r is least at the first end.
    r = bed.radius[supports[0]]
    bottom = bed.centre[supports[0], 2] + centre_at(curve, first)[2] - (first - r)
    shelf = min(max(int(min(bottom / shelves.height, 1e9)), 0), shelves.head.shape[1] - 1)
    rack = rack_of(last - r, shelves)
    pockets.following[n] = shelves.head[rack, shelf]
    shelves.head[rack, shelf] = n
    shelves.lowest[rack] = min(shelves.lowest[rack], shelf)
    return pockets


def rack_of(r, shelves: Shelves):
    """The rack of the pockets that host no grain above a radius [m]."""
    rack_count = len(shelves.lowest)
    if rack_count == 1:
        return 0
    part = (r - shelves.finest) / (shelves.coarsest - shelves.finest)
    return min(max(int(part * rack_count), 0), rack_count - 1)


def lowest_rest(r, bed: SphereBed, pockets: SpherePockets, shelves: Shelves):
    """Lowest centre at which a sphere of radius r rests: (centre, pockets); z is infinite if there is none.

    Pockets that fail on the way lose the interval of s that fails.
    """
    # The four corners of the floor are lower than any pocket.
    for corner in ((r, r, r), (bed.width - r, r, r), (r, bed.depth - r, r), (bed.width - r, bed.depth - r, r)):
        if blocker(corner, r, bed) == NONE:
            return corner, pockets
    best, failed = (0.0, 0.0, math.inf), -1
    rack_count, shelf_count = shelves.head.shape
    # Pockets of the surface host almost any grain and come first. Round-off of a radius must not hide a rack.
    for rack in range(rack_count - 1, rack_of(r * (1.0 - 1e-12), shelves) - 1, -1):
        shelf = shelves.lowest[rack]
        while shelf < shelf_count and shelves.head[rack, shelf] < 0:
            shelf += 1
        shelves.lowest[rack] = shelf
        while shelf < shelf_count and shelf * shelves.height + r < best[2]:
            if shelves.head[rack, shelf] >= 0:
                best, failed = lowest_on_shelf(rack, shelf, r, best, failed, bed, pockets, shelves)
            shelf += 1
    # Pockets that failed lose what failed, after the search.
    while failed >= 0:
        following = pockets.following[failed]
        pockets = without(r, failed, bed, pockets, shelves)
        failed = following
    return best, pockets


def lowest_on_shelf(rack, shelf, r, best, failed, bed: SphereBed, pockets: SpherePockets, shelves: Shelves):
    """The lowest of the centre ``best`` and the centres on a shelf: (centre, first of the failed pockets, which leave the
    shelf).

    ``pockets`` is not returned: returning the arrays for every shelf took most of the time.
    """
    before, n = -1, shelves.head[rack, shelf]
    while n >= 0:
        following = pockets.following[n]
        base = pockets.supports[n, 0]
        s = r + bed.radius[base]
        pockets.met[n] = NONE
        # The centre that touches the three supports, c = p0 + v(s).
        if pockets.first[n] <= s <= pockets.last[n]:
            centre = added(point_of(base, bed), 1.0, centre_at(curve_of(n, pockets), s))
            if centre[2] < best[2]:
                pockets.met[n] = blocker(centre, r, bed)
                if pockets.met[n] == NONE:
                    best = centre
        if pockets.met[n] == NONE:
            before = n
        else:
            if before >= 0:
                pockets.following[before] = following
            else:
                shelves.head[rack, shelf] = following
            pockets.following[n] = failed
            failed = n
        n = following
    return best, failed


def without(r, n, bed: SphereBed, pockets: SpherePockets, shelves: Shelves):
    """The pockets after a sphere of radius r met a support in pocket n, of which no, one or two intervals are left."""
    curve, first, last = curve_of(n, pockets), pockets.first[n], pockets.last[n]
    supports = pockets.supports[n, 0], pockets.supports[n, 1], pockets.supports[n, 2]
    s, hit = r + bed.radius[supports[0]], pockets.met[n]
    pockets.following[n] = shelves.store[1]
    shelves.store[1] = n
    below, above = s, s
    # Interval around s in which the gap to the support is negative.
    form = along(tangency(hit, supports[0], bed.tolerance, bed), curve)
    if negative(form, curve, s):
        below, above = between_roots(form, curve, s)
    # The factors step over s itself.
    below, above = min(below, s * (1.0 - 1e-15)), max(above, s * (1.0 + 1e-15))
    if first <= below:
        pockets = add(supports, curve, first, below, bed, pockets, shelves)
    if above <= last:
        pockets = add(supports, curve, above, last, bed, pockets, shelves)
    return pockets
