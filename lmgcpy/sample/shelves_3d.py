"""The open pockets of a bed of spheres, and the search for the lowest among them that takes a grain.

Pockets stand in racks by the coarsest radius that they may host, and there on shelves by the lowest bottom of any sphere
in them: a grain looks at the low shelves of the racks for its size. Of a wide grading the holes in the bed that take only
the finest grains are as many as the grains, and coarse ones need not go through them.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
from typing import NamedTuple

import numpy as np

from lmgcpy.sample.apollonius_3d import Curve, added, along, between_roots, negative, place, tangency
from lmgcpy.sample.bed_3d import NONE, Bed, blocker, point_of

RACKS = 8


class Pockets(NamedTuple):
    """Pockets, open or free to be used again; the arrays are longer than they are many."""

    supports: np.ndarray
    """Shape (n, 3), the base first."""
    curve: np.ndarray
    """alpha, beta, w: shape (n, 3, 3)."""
    first: np.ndarray
    """Ends of the interval of s [m] that a pocket may host."""
    last: np.ndarray
    following: np.ndarray
    """The next pocket on the same shelf or in another list, -1 for none."""
    met: np.ndarray
    """The support that the last grain to try it would have overlapped, or NONE."""


class Shelves(NamedTuple):
    """Where the open pockets are, as linked lists."""

    head: np.ndarray
    """First pocket on each shelf, -1 for none; shape (racks, shelves)."""
    lowest: np.ndarray
    """In each rack the shelves below this one are empty."""
    height: float
    """Of each shelf [m]."""
    finest: float
    """Radius [m] of the finest and the coarsest grain."""
    coarsest: float
    store: np.ndarray
    """The number of pockets ever made, and the first free one, -1 for none."""


def new_pockets(size):
    """Room for ``size`` pockets."""
    return Pockets(
        np.empty((size, 3), np.int64), np.empty((size, 3, 3)), np.empty(size), np.empty(size), np.empty(size, np.int64),
        np.empty(size, np.int64),
    )  # fmt: skip


def new_shelves(shelf_count, height, finest, coarsest):
    """Empty shelves."""
    rack_count = RACKS if finest < coarsest else 1
    head = np.full((rack_count, shelf_count), -1, np.int64)
    return Shelves(head, np.full(rack_count, shelf_count), height, finest, coarsest, np.array([0, -1]))


def enlarged(pockets: Pockets):
    """The same pockets with twice the room."""
    size = len(pockets.first)
    larger = new_pockets(2 * size)
    larger.supports[:size], larger.curve[:size] = pockets.supports, pockets.curve
    larger.first[:size], larger.last[:size] = pockets.first, pockets.last
    larger.following[:size], larger.met[:size] = pockets.following, pockets.met
    return larger


def curve_of(n, pockets: Pockets):
    """The curve of a pocket."""
    c = pockets.curve
    return Curve(
        (c[n, 0, 0], c[n, 0, 1], c[n, 0, 2]), (c[n, 1, 0], c[n, 1, 1], c[n, 1, 2]), (c[n, 2, 0], c[n, 2, 1], c[n, 2, 2])
    )  # fmt: skip


def add(supports, curve: Curve, first, last, bed: Bed, pockets: Pockets, shelves: Shelves):
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
    # z is concave along the curve, so that z - r is least at the first end, if ever it is stable with dz/dr >= 1
    r = bed.radius[supports[0]]
    bottom = bed.centre[supports[0], 2] + place(curve, first)[2] - (first - r)
    shelf = min(max(int(min(bottom / shelves.height, 1e9)), 0), shelves.head.shape[1] - 1)
    rack = rack_of(last - r, shelves)
    pockets.following[n] = shelves.head[rack, shelf]
    shelves.head[rack, shelf] = n
    shelves.lowest[rack] = min(shelves.lowest[rack], shelf)
    return pockets


def rack_of(r, shelves: Shelves):
    """The rack of the pockets that take no grains above a radius [m]."""
    rack_count = len(shelves.lowest)
    if rack_count == 1:
        return 0
    part = (r - shelves.finest) / (shelves.coarsest - shelves.finest)
    return min(max(int(part * rack_count), 0), rack_count - 1)


def lowest_place(r, bed: Bed, pockets: Pockets, shelves: Shelves):
    """Lowest place for a sphere of radius r: (centre, pockets); z is infinite where there is none.

    Pockets that fail on the way lose what fails with them.
    """
    for corner in ((r, r, r), (bed.width - r, r, r), (r, bed.depth - r, r), (bed.width - r, bed.depth - r, r)):
        if blocker(corner, r, bed) == NONE:
            return corner, pockets
    best, failed = (0.0, 0.0, math.inf), -1
    rack_count, shelf_count = shelves.head.shape
    # the pockets of the surface, which take almost any grain, first; round-off of a radius must not hide a rack
    for rack in range(rack_count - 1, rack_of(r * (1.0 - 1e-12), shelves) - 1, -1):
        shelf = shelves.lowest[rack]
        while shelf < shelf_count and shelves.head[rack, shelf] < 0:
            shelf += 1
        shelves.lowest[rack] = shelf
        while shelf < shelf_count and shelf * shelves.height + r < best[2]:
            if shelves.head[rack, shelf] >= 0:
                best, failed = lowest_on_shelf(rack, shelf, r, best, failed, bed, pockets, shelves)
            shelf += 1
    while failed >= 0:
        following = pockets.following[failed]
        pockets = without(r, failed, bed, pockets, shelves)
        failed = following
    return best, pockets


def lowest_on_shelf(rack, shelf, r, best, failed, bed: Bed, pockets: Pockets, shelves: Shelves):
    """The lowest of a place and those on a shelf: (centre, first of the failed pockets, which go off the shelf).

    Not a word of ``pockets`` goes out: handing the arrays on for every shelf took most of the time.
    """
    before, n = -1, shelves.head[rack, shelf]
    while n >= 0:
        following = pockets.following[n]
        base = pockets.supports[n, 0]
        s = r + bed.radius[base]
        pockets.met[n] = NONE
        if pockets.first[n] <= s <= pockets.last[n]:
            centre = added(point_of(base, bed), 1.0, place(curve_of(n, pockets), s))
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


def without(r, n, bed: Bed, pockets: Pockets, shelves: Shelves):
    """The pockets after a sphere of radius r met a support in one of them: none, one or two pieces of it are left."""
    curve, first, last = curve_of(n, pockets), pockets.first[n], pockets.last[n]
    supports = pockets.supports[n, 0], pockets.supports[n, 1], pockets.supports[n, 2]
    s, hit = r + bed.radius[supports[0]], pockets.met[n]
    pockets.following[n] = shelves.store[1]
    shelves.store[1] = n
    below, above = s, s
    form = along(tangency(hit, supports[0], bed.tolerance, bed), curve)
    if negative(form, curve, s):
        below, above = between_roots(form, curve, s)
    # the factors step over s itself
    below, above = min(below, s * (1.0 - 1e-15)), max(above, s * (1.0 + 1e-15))
    if first <= below:
        pockets = add(supports, curve, first, below, bed, pockets, shelves)
    if above <= last:
        pockets = add(supports, curve, above, last, bed, pockets, shelves)
    return pockets
