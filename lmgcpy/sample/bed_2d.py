"""The bodies that lie in a 2D box: disks in the cells of a grid, a floor, two walls; and the circles that touch them.

Supports are named as :mod:`lmgcpy.sample.cells` says.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
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


def tangent_radii(first, second, third, bed: DiskBed):
    """Radii [m] of the two circles that touch three supports, the smaller one first; NaN if there are none.

    With v = c - p0 from the centre of one of the disks and s = r + r0, the circle's equation |v| = s makes the equations
    of the other supports linear: d . v + (rq - r0) s = (d² - (rq - r0)²)/2 for a disk at p0 + d, n . v - s = const for a
    line. They give v = alpha + beta s, and |v| = s is a quadratic for s. Two radii on one side of two of the supports
    need that quadratic: if the centres are in line, or all supports are lines, there is only one radius, and the answer
    is NaN.
    """
    base = max(first, second, third)
    if base < 0:
        return math.nan, math.nan
    if base == first:
        first = third
    elif base == second:
        second = third
    # Linear equations of the two other supports: a_x v_x + a_y v_y + a s = e.
    ax, ay, a, e = tangency(first, base, bed)
    bx, by, b, f = tangency(second, base, bed)
    determinant = ax * by - ay * bx
    if abs(determinant) <= 1e-14 * math.hypot(ax, ay) * math.hypot(bx, by):
        return math.nan, math.nan
    # Cramer's rule: v = alpha + beta s.
    alpha_x, alpha_y = (e * by - f * ay) / determinant, (f * ax - e * bx) / determinant
    beta_x, beta_y = (b * ay - a * by) / determinant, (a * bx - b * ax) / determinant
    # Quadratic |alpha + beta s| = s; the root of larger size without cancellation, the other one from the product.
    square = beta_x**2 + beta_y**2 - 1.0
    half = alpha_x * beta_x + alpha_y * beta_y
    root = half**2 - square * (alpha_x**2 + alpha_y**2)
    if root < 0.0:
        return math.nan, math.nan
    sum_of_terms = -(half + math.copysign(math.sqrt(root), half))
    one = sum_of_terms / square - bed.radius[base]
    other = (alpha_x**2 + alpha_y**2) / sum_of_terms - bed.radius[base]
    return min(one, other), max(one, other)


def tangency(support, base, bed: DiskBed):
    """Coefficients (x, y, s, right side) of the linear equation of a circle that touches ``base`` and a support."""
    x0, y0, r0 = bed.x[base], bed.y[base], bed.radius[base]
    if support >= 0:
        dx, dy, dr = bed.x[support] - x0, bed.y[support] - y0, bed.radius[support] - r0
        return dx, dy, dr, 0.5 * (dx * dx + dy * dy - dr * dr)
    if support == FLOOR:
        return 0.0, 1.0, -1.0, -r0 - y0
    if support == LEFT:
        return 1.0, 0.0, -1.0, -r0 - x0
    return -1.0, 0.0, -1.0, x0 - bed.width - r0
