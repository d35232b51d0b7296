"""Broad phase: which bounded contactors come near each other, in O(n) with grids of cells, one for each class of sizes.

Linked neighbours whose link leaves no gap never meet, whatever the visibility table says. They are left out of the lists of
neighbours when these are made, so that a step pays nothing for them.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel

CLASS = 3.0
"""Ratio of the largest to the smallest size in a grid."""


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


def boxes_meet(box, i, others, k, d_x, d_y, d_z, reach):
    """Whether two boxes are within reach, whose centres are apart by these distances; without boxes they are."""
    if box.shape[0] == 0:
        return True
    return (
        abs(d_x) <= box[i, 0] + others[k, 0] + reach
        and abs(d_y) <= box[i, 1] + others[k, 1] + reach
        and abs(d_z) <= box[i, 2] + others[k, 2] + reach
    )


@kernel
def _near_pairs(reach, origin, cell, shape, order, first, ordered, box, pairs, found):
    """Write the pairs (lower, higher) whose surfaces are within ``reach``, cell by cell, behind the ``found`` that there
    are. Returns their number, with those that do not fit into ``pairs``. Each point is compared with the points after it
    in its own cell, and with the points of the neighbouring cells that come later: half of them."""
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
                    if d_x * d_x + d_y * d_y + d_z * d_z <= d * d and boxes_meet(box, i, box, k, d_x, d_y, d_z, reach):
                        if found < capacity:
                            pairs[found, 0] = min(order[i], order[k])
                            pairs[found, 1] = max(order[i], order[k])
                        found += 1
    return found


@kernel
def _across(reach, own, at, own_box, largest, widest, origin, cell, shape, order, first, ordered, box, pairs, found):
    """Write the pairs of larger circles, ``own`` their rows and ``at`` (x, y, z, radius), with those in a grid, whose
    ``largest`` radius [m] and ``widest`` half box [m] are given; as :func:`_near_pairs`."""
    capacity = pairs.shape[0]
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    for i in range(own.shape[0]):
        # the cells that it reaches, a millionth farther than it does
        for axis in range(3):
            far = at[i, 3] + largest + reach
            if own_box.shape[0] > 0:
                far = min(far, own_box[i, axis] + widest[axis] + reach)
            far *= 1.000001
            from_origin = at[i, axis] - origin[axis]
            low[axis] = int(min(np.floor(max(from_origin - far, 0.0) / cell), float(shape[axis])))
            high[axis] = -1
            if from_origin + far >= 0.0:
                high[axis] = int(min(np.floor((from_origin + far) / cell), shape[axis] - 1.0))
        for cz in range(low[2], high[2] + 1):
            for cy in range(low[1], high[1] + 1):
                row = (cz * shape[1] + cy) * shape[0]
                if low[0] > high[0]:
                    continue
                for k in range(first[row + low[0]], first[row + high[0] + 1]):
                    d_x = at[i, 0] - ordered[k, 0]
                    d_y = at[i, 1] - ordered[k, 1]
                    d_z = at[i, 2] - ordered[k, 2]
                    d = at[i, 3] + ordered[k, 3] + reach
                    if d_x * d_x + d_y * d_y + d_z * d_z <= d * d and boxes_meet(own_box, i, box, k, d_x, d_y, d_z, reach):
                        if found < capacity:
                            pairs[found, 0] = min(own[i], order[k])
                            pairs[found, 1] = max(own[i], order[k])
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


class Grid:
    """Circles or spheres of one class of sizes in a grid of cells; n of them.

    The cells are as wide as the largest diameter plus the reach. In a sparse scene they are wider, so that there are no
    more cells than circles.
    """

    def __init__(self, ids: np.ndarray, centres: np.ndarray, radius: np.ndarray, box: np.ndarray, reach: float, d: int):
        """``ids`` (n,): rows of the circles in ``centres`` (m, 3), ``radius`` (m,) and ``box`` (m or 0, 3); ``d``: the
        dimension."""
        whole = len(ids) == len(centres)
        if not whole:
            centres, radius, box = centres[ids], radius[ids], box[ids] if len(box) else box
        self.count, self.largest = len(ids), float(radius.max())
        # along one axis after the other: numpy takes fifty times as long over the rows
        self.origin = np.array([along.min() for along in centres.T])
        extent = np.array([along.max() for along in centres.T]) - self.origin
        cell = 2.0 * self.largest + reach
        # about as many cells as circles at most: a sparse scene gets wider cells
        sides = np.sort(extent)[::-1][:d]
        for k in range(d):  # of a line, a sheet, a block
            cell = max(cell, float(np.prod(sides[: k + 1]) / self.count) ** (1.0 / (k + 1)))
        self.cell, self.shape = cell, (extent / cell).astype(np.int64) + 1
        self.order = np.empty(self.count, np.int32)
        self.first = np.empty(int(np.prod(self.shape)) + 1, np.int64)
        self.ordered = np.empty((self.count, 4))
        _bin(centres, radius, self.origin, cell, self.shape, self.order, self.first, self.ordered)
        self.box = box.take(self.order, axis=0) if len(box) else box
        self.widest = box.max(axis=0) if len(box) else np.full(3, self.largest)
        if not whole:
            self.order = ids.astype(np.int32)[self.order]

    @property
    def cells(self) -> tuple:
        """The arguments of kernels that look into the grid."""
        return self.origin, self.cell, self.shape, self.order, self.first, self.ordered, self.box


def near_pairs(
    positions: np.ndarray,
    radius: np.ndarray,
    reach: float,
    box: np.ndarray | None = None,
    held: np.ndarray | None = None,
) -> np.ndarray:
    """Pairs (i < j) of circles or spheres whose surfaces are within ``reach`` [m], (p, 2) int32, sorted.

    ``positions``: (n, d), d the dimension; ``box``: half sides of boxes along the axes around the same centres, (n, d),
    that must be within reach too [m]. ``held`` (n,) bool: circles that make no pairs among each other.

    Circles within a factor of :data:`CLASS` in size share a grid (:class:`Grid`). Of two grids the circles that are fewer
    look into the cells of the others that they reach: one boulder among small grains costs as much as there are grains
    around it.
    """
    count = len(positions)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int32)
    d = positions.shape[1]
    centres = np.zeros((count, 3))
    centres[:, :d] = positions
    boxes = np.zeros((0, 3))
    if box is not None:
        boxes = np.zeros((count, 3))
        boxes[:, :d] = box
    size = radius + 0.5 * reach
    # size 0 is the smallest there is: a point
    classes = (np.log(size.max() / np.maximum(size, 1e-30 * size.max())) / np.log(CLASS)).astype(np.int64)
    most = int(classes.max()) + 1
    kinds = classes if held is None else np.where(held, most + classes, classes)
    occurring = np.flatnonzero(np.bincount(kinds))
    grids = [Grid(np.flatnonzero(kinds == k), centres, radius, boxes, reach, d) for k in occurring.tolist()]
    free = grids[: int((occurring < most).sum())]
    pairs = np.empty((12 * count, 2), np.int32)  # memory that is not touched costs nothing
    while True:
        found = 0
        for k, grid in enumerate(free):
            found = _near_pairs(reach, *grid.cells, pairs, found)
            for other in grids[k + 1 :]:
                seeks, sought = (grid, other) if grid.count <= other.count else (other, grid)
                own = seeks.order, seeks.ordered, seeks.box
                found = _across(reach, *own, sought.largest, sought.widest, *sought.cells, pairs, found)
        if found <= len(pairs):
            return sorted_pairs(pairs[:found].copy(), count)
        pairs = np.empty((found, 2), np.int32)


@kernel
def _keep(pairs, body, first, others, left):
    """Write the pairs of contactors whose bodies may meet, in their order; returns their number."""
    count = 0
    for p in range(pairs.shape[0]):
        lower = min(body[pairs[p, 0]], body[pairs[p, 1]])
        higher = max(body[pairs[p, 0]], body[pairs[p, 1]])
        meet = True
        for k in range(first[lower], first[lower + 1]):
            meet = meet and others[k] != higher
        if meet:
            left[count, 0] = pairs[p, 0]
            left[count, 1] = pairs[p, 1]
            count += 1
    return count


class ExcludedPairs:
    """Pairs of bodies that never meet: for each body the bodies of a higher row that it never meets."""

    def __init__(self, pairs: np.ndarray, body_count: int):
        """``pairs``: rows of the bodies, (p, 2), the lower first, sorted."""
        self._others = np.ascontiguousarray(pairs[:, 1])
        self._first = np.searchsorted(pairs[:, 0], np.arange(body_count + 1))
        self._count = body_count
        self._keys = self._key(pairs[:, 0], pairs[:, 1])

    def _key(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.minimum(one, other).astype(np.int64) * self._count + np.maximum(one, other)

    def contain(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Whether bodies never meet others, of the shape to which both are broadcast."""
        return np.isin(self._key(one, other), self._keys)

    def left_out_of(self, pairs: np.ndarray, body: np.ndarray) -> np.ndarray:
        """The pairs of contactors (p, 2) whose bodies may meet, in their order; ``body``: body of each contactor, (k,)."""
        if not len(self._others) or not len(pairs):
            return pairs
        left = np.empty_like(pairs)
        return left[: _keep(pairs, body, self._first, self._others, left)]
