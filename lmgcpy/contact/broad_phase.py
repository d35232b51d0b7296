"""Broad phase: which bounded contactors come near each other, in O(n) with a grid of cells."""

from __future__ import annotations

import numpy as np

from lmgcpy.jit import kernel


@kernel
def _bin(positions, origin, cell, shape, order, first):
    """Counting sort of the points into cells: ``order`` lists them cell by cell, ``first`` tells where a cell begins."""
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
        order[place[home[i]]] = i
        place[home[i]] += 1


@kernel
def _near_pairs(positions, radius, reach, origin, cell, shape, order, first, pairs):
    """Write the pairs whose surfaces are within ``reach``; returns how many there are, more than fit included."""
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
                    j = order[k]
                    if j <= i:
                        continue
                    d_x = positions[i, 0] - positions[j, 0]
                    d_y = positions[i, 1] - positions[j, 1]
                    d_z = positions[i, 2] - positions[j, 2]
                    d = radius[i] + radius[j] + reach
                    if d_x * d_x + d_y * d_y + d_z * d_z <= d * d:
                        if found < capacity:
                            pairs[found, 0] = i
                            pairs[found, 1] = j
                        found += 1
    return found


def near_pairs(positions: np.ndarray, radius: np.ndarray, reach: float) -> np.ndarray:
    """Pairs (i < j) of circles or spheres whose surfaces are within ``reach`` [m], shape (p, 2), sorted.

    ``positions``: (n, d), d the dimension.

    The cells are as wide as the largest circle and the reach; a wide spread of radii in a dense sample makes them
    crowded, a sparse scene makes them wider, never more of them than there are circles.
    """
    count = len(positions)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int64)
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
    order = np.empty(count, np.int64)
    first = np.empty(int(np.prod(shape)) + 1, np.int64)
    _bin(centres, origin, cell, shape, order, first)
    pairs = np.empty((12 * count, 2), np.int64)
    while True:
        found = _near_pairs(centres, radius, reach, origin, cell, shape, order, first, pairs)
        if found <= len(pairs):
            pairs = pairs[:found]
            return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
        pairs = np.empty((found, 2), np.int64)
