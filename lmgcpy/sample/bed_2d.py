"""The bodies that lie in a 2D box: disks in the cells of a grid, a floor, two walls.

Supports are named as :mod:`lmgcpy.sample.cells` says.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference
from lmgcpy.sample.cells import FLOOR, LEFT, NONE, RIGHT, cell_of, put


@by_reference
class DiskBed(NamedTuple):
    """Disks placed in a box [0, width] x [0, ...), each entered in every cell that its bounding box touches.

    Cells are as wide as a mean disk, and a search visits the cells of its own bounding box only: that serves gradings
    of any ratio. Disks beyond the last row or column of cells are in the last one.
    """

    x: np.ndarray
    """Centres of obstacles, then of grains [m]; undefined for grains that are not placed yet."""
    y: np.ndarray
    radius: np.ndarray
    width: float
    tolerance: float
    """Overlap [m] below which two disks touch."""
    cell_size: float
    cell_head: np.ndarray
    """Latest entry of each cell, shape (rows, columns), -1 for none; see :mod:`lmgcpy.sample.cells`."""
    entry_disk: np.ndarray
    """Disk of each entry; a disk has an entry in each cell that its bounding box touches."""
    entry_next: np.ndarray
    entry_count: np.ndarray
    """Number of entries in use, shape (1,)."""


def enter(disk, bed):
    """Enter a disk, whose centre and radius are set, into its cells."""
    rows, columns = bed.cell_head.shape
    x, y, r, size = bed.x[disk], bed.y[disk], bed.radius[disk], bed.cell_size
    entry = bed.entry_count[0]
    for row in range(cell_of(y - r, size, rows), cell_of(y + r, size, rows) + 1):
        for column in range(cell_of(x - r, size, columns), cell_of(x + r, size, columns) + 1):
            bed.entry_disk[entry] = disk
            put(bed.cell_head, bed.entry_next, (row, column), entry)
            entry += 1
    bed.entry_count[0] = entry


def overlaps(support, x, y, r, bed):
    """Whether a disk of radius r at (x, y) overlaps a disk of the bed, the floor or a wall."""
    if support >= 0:
        dx, dy = x - bed.x[support], y - bed.y[support]
        distance = bed.radius[support] + r - bed.tolerance
        return dx * dx + dy * dy < distance * distance
    if support == FLOOR:
        return y < r - bed.tolerance
    if support == LEFT:
        return x < r - bed.tolerance
    return x > bed.width - r + bed.tolerance


def blocker(x, y, r, bed):
    """A support that a disk of radius r at (x, y) would overlap, or NONE."""
    for support in (FLOOR, LEFT, RIGHT):
        if overlaps(support, x, y, r, bed):
            return support
    rows, columns = bed.cell_head.shape
    size = bed.cell_size
    for row in range(cell_of(y - r, size, rows), cell_of(y + r, size, rows) + 1):
        for column in range(cell_of(x - r, size, columns), cell_of(x + r, size, columns) + 1):
            entry = bed.cell_head[row, column]
            while entry >= 0:
                if overlaps(bed.entry_disk[entry], x, y, r, bed):
                    return bed.entry_disk[entry]
                entry = bed.entry_next[entry]
    return NONE
