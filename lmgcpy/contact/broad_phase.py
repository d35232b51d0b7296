"""Broad phase: which bounded contactors come near each other, in O(n) with a grid of cells."""

from __future__ import annotations

import numpy as np

from lmgcpy.jit import kernel


@kernel
def _bin(positions, radius, origin, cell, shape, order, first, ordered):
    """Counting sort of the points into cells: ``order`` lists them cell by cell, ``first`` tells where a cell begins,
    ``ordered`` has (x, y, z, radius) in that order."""
    count = positions.shape[0]
    home = np.empty(count, np.int64)
    first[:] = 0
    for i in range(count):
        x = int((positions[i, 0] - origin[0]) / cell)
        y = int((positions[i, 1] - origin[1]) / cell)
        z = int((positions[i, 2] - origin[2]) / cell)
        home[i] = (z * shape[1] + y) * shape[0] + x
        first[home[i] + 1] += 1
    for k in range(1, first.shape[0]):
        first[k] += first[k - 1]
    place = first[:-1].copy()
    for i in range(count):
        k = place[home[i]]
        place[home[i]] += 1
        order[k] = i
        for column in range(3):
            ordered[k, column] = positions[i, column]
        ordered[k, 3] = radius[i]


@kernel
def _near_pairs(positions, radius, reach, origin, cell, shape, order, first, ordered, pairs):
    """Write the pairs (lower, higher) whose surfaces are within ``reach``, by the higher; returns how many there are, more
    than fit included."""
    found = 0
    capacity = pairs.shape[0]
    for i in range(positions.shape[0]):
        x = int((positions[i, 0] - origin[0]) / cell)
        y = int((positions[i, 1] - origin[1]) / cell)
        z = int((positions[i, 2] - origin[2]) / cell)
        for cz in range(max(z - 1, 0), min(z + 2, shape[2])):
            for cy in range(max(y - 1, 0), min(y + 2, shape[1])):
                row = (cz * shape[1] + cy) * shape[0]
                # cells side by side are one piece of the order
                for k in range(first[row + max(x - 1, 0)], first[row + min(x + 2, shape[0])]):
                    if order[k] >= i:
                        continue
                    d_x = positions[i, 0] - ordered[k, 0]
                    d_y = positions[i, 1] - ordered[k, 1]
                    d_z = positions[i, 2] - ordered[k, 2]
                    d = radius[i] + ordered[k, 3] + reach
                    if d_x * d_x + d_y * d_y + d_z * d_z <= d * d:
                        if found < capacity:
                            pairs[found, 0] = order[k]
                            pairs[found, 1] = i
                        found += 1
    return found


@kernel
def _by_first(pairs, first, result):
    """Counting sort of pairs by the first of the two, those of one first in the order in which they come; ``first``: room
    for one number more than there are contactors."""
    first[:] = 0
    for p in range(pairs.shape[0]):
        first[pairs[p, 0] + 1] += 1
    for k in range(1, first.shape[0]):
        first[k] += first[k - 1]
    for p in range(pairs.shape[0]):
        place = first[pairs[p, 0]]
        first[pairs[p, 0]] += 1
        result[place, 0] = pairs[p, 0]
        result[place, 1] = pairs[p, 1]


def by_first(pairs: np.ndarray, count: int) -> np.ndarray:
    """Pairs (p, 2) of ``count`` contactors sorted by the first of the two, otherwise in the order in which they come."""
    result = np.empty_like(pairs)
    _by_first(pairs, np.empty(count + 1, np.int64), result)
    return result


def near_pairs(positions: np.ndarray, radius: np.ndarray, reach: float) -> np.ndarray:
    """Pairs (i < j) of circles or spheres whose surfaces are within ``reach`` [m], (p, 2) int32, sorted.

    ``positions``: (n, d), d the dimension.

    The cells are as wide as the largest circle and the reach; a wide spread of radii in a dense sample makes them
    crowded, a sparse scene makes them wider, never more of them than there are circles.
    """
    count = len(positions)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int32)
    d = positions.shape[1]
    centres = np.zeros((count, 3))
    centres[:, :d] = positions
    origin = centres.min(axis=0)
    extent = centres.max(axis=0) - origin
    cell = 2.0 * float(radius.max()) + reach
    # no more cells than circles, about: wider cells where the scene is sparse
    sides = np.sort(extent)[::-1][:d]
    for k in range(d):  # of a line, a sheet, a block
        cell = max(cell, float(np.prod(sides[: k + 1]) / count) ** (1.0 / (k + 1)))
    shape = (extent / cell).astype(np.int64) + 1
    order = np.empty(count, np.int32)
    first = np.empty(int(np.prod(shape)) + 1, np.int64)
    ordered = np.empty((count, 4))
    _bin(centres, radius, origin, cell, shape, order, first, ordered)
    pairs = np.empty((12 * count, 2), np.int32)  # room that is not used costs nothing
    while True:
        found = _near_pairs(centres, radius, reach, origin, cell, shape, order, first, ordered, pairs)
        if found <= len(pairs):
            return by_first(pairs[:found], count)
        pairs = np.empty((found, 2), np.int32)
