"""Broad phase: which bounded contactors come near each other, in O(n) with a grid of cells."""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel


@kernel
def _bin(positions, radius, origin, cell, shape, order, first, ordered):
    """Counting sort of the points into cells: ``order`` lists them cell by cell, ``first`` holds the start of each
    cell in it, ``ordered`` has (x, y, z, radius) in that order."""
    count = positions.shape[0]
    home = np.empty(count, np.int64)
    first[:] = 0
    for i in range(count):
        x = int((positions[i, 0] - origin[0]) / cell)
        y = int((positions[i, 1] - origin[1]) / cell)
        z = int((positions[i, 2] - origin[2]) / cell)
        home[i] = (z * shape[1] + y) * shape[0] + x
        first[home[i] + 1] += 1
    # counts become the first index of each cell
    for k in range(1, first.shape[0]):
        first[k] += first[k - 1]
    # where in the order the next point of each cell goes
    next_free = first[:-1].copy()
    for i in range(count):
        k = next_free[home[i]]
        next_free[home[i]] += 1
        order[k] = i
        for column in range(3):
            ordered[k, column] = positions[i, column]
        ordered[k, 3] = radius[i]


@kernel
def _near_pairs(reach, origin, cell, shape, order, first, ordered, pairs):
    """Write the pairs (lower, higher) whose surfaces are within ``reach``, cell by cell. Returns their number, with those
    that do not fit into ``pairs``. Each point is compared with the points after it in its own cell, and with the points
    of the neighbouring cells that come later: half of them."""
    found = 0
    capacity = pairs.shape[0]
    for i in range(order.shape[0]):
        p_x = ordered[i, 0]
        p_y = ordered[i, 1]
        p_z = ordered[i, 2]
        x = int((p_x - origin[0]) / cell)
        y = int((p_y - origin[1]) / cell)
        z = int((p_z - origin[2]) / cell)
        left = max(x - 1, 0)
        right = min(x + 2, shape[0])
        for cz in range(z, min(z + 2, shape[2])):
            for cy in range(y if cz == z else max(y - 1, 0), min(y + 2, shape[1])):
                row = (cz * shape[1] + cy) * shape[0]
                # cells side by side are one piece of the order
                begin = i + 1 if cz == z and cy == y else first[row + left]
                for k in range(begin, first[row + right]):
                    d_x = p_x - ordered[k, 0]
                    d_y = p_y - ordered[k, 1]
                    d_z = p_z - ordered[k, 2]
                    # squared distance of the centres against the sum of radii and reach
                    d = ordered[i, 3] + ordered[k, 3] + reach
                    if d_x * d_x + d_y * d_y + d_z * d_z <= d * d:
                        if found < capacity:
                            pairs[found, 0] = min(order[i], order[k])
                            pairs[found, 1] = max(order[i], order[k])
                        found += 1
    return found


@kernel
def _sort_by(column, pairs, first, result):
    """Counting sort of pairs by the contactor in ``column``; pairs with the same one keep their order. ``first``: scratch,
    one number more than there are contactors."""
    first[:] = 0
    for p in range(pairs.shape[0]):
        first[pairs[p, column] + 1] += 1
    for k in range(1, first.shape[0]):
        first[k] += first[k - 1]
    for p in range(pairs.shape[0]):
        k = first[pairs[p, column]]
        first[pairs[p, column]] += 1
        result[k, 0] = pairs[p, 0]
        result[k, 1] = pairs[p, 1]


def by_first(pairs: np.ndarray, count: int) -> np.ndarray:
    """Pairs (p, 2) of ``count`` contactors sorted by the first of the two, otherwise in the order in which they come."""
    result = np.empty_like(pairs)
    _sort_by(0, pairs, np.empty(count + 1, np.int64), result)
    return result


def sorted_pairs(pairs: np.ndarray, count: int) -> np.ndarray:
    """Pairs (p, 2) of ``count`` contactors sorted by the first, then by the second; ``pairs`` is used as scratch."""
    first, result = np.empty(count + 1, np.int64), np.empty_like(pairs)
    _sort_by(1, pairs, first, result)
    _sort_by(0, result, first, pairs)
    return pairs


def near_pairs(positions: np.ndarray, radius: np.ndarray, reach: float) -> np.ndarray:
    """Pairs (i < j) of circles or spheres whose surfaces are within ``reach`` [m], (p, 2) int32, sorted.

    ``positions``: (n, d), d the dimension.

    The cells are as wide as the largest diameter plus the reach. A wide spread of radii in a dense sample makes them
    crowded. In a sparse scene they are wider, so that there are no more cells than circles.
    """
    count = len(positions)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int32)
    d = positions.shape[1]
    centres = np.zeros((count, 3))
    centres[:, :d] = positions
    # along one axis after the other: numpy takes fifty times as long over the rows
    origin = np.array([along.min() for along in centres.T])
    extent = np.array([along.max() for along in centres.T]) - origin
    cell = 2.0 * float(radius.max()) + reach
    # about as many cells as circles at most: a sparse scene gets wider cells
    sides = np.sort(extent)[::-1][:d]
    for k in range(d):  # of a line, a sheet, a block
        cell = max(cell, float(np.prod(sides[: k + 1]) / count) ** (1.0 / (k + 1)))
    shape = (extent / cell).astype(np.int64) + 1
    order = np.empty(count, np.int32)
    first = np.empty(int(np.prod(shape)) + 1, np.int64)
    ordered = np.empty((count, 4))
    _bin(centres, radius, origin, cell, shape, order, first, ordered)
    pairs = np.empty((12 * count, 2), np.int32)  # memory that is not touched costs nothing
    while True:
        found = _near_pairs(reach, origin, cell, shape, order, first, ordered, pairs)
        if found <= len(pairs):
            return sorted_pairs(pairs[:found].copy(), count)
        pairs = np.empty((found, 2), np.int32)
