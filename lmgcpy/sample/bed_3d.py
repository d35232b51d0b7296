"""The bodies that lie in a 3D box: spheres in the cells of a grid, a floor, four walls.

Supports are named as :mod:`lmgcpy.sample.cells` says.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference
from lmgcpy.sample.cells import BACK, FLOOR, FRONT, LEFT, NONE, RIGHT, cell_of, put


@by_reference
class SphereBed(NamedTuple):
    """Spheres placed in a box [0, width] x [0, depth] x [0, ...), each entered in the cell of its centre.

    Cells are about as wide as a mean sphere. Spheres beyond the last cell, in any direction, are in the last one.
    """

    centre: np.ndarray
    """Centres of obstacles, then of grains [m], shape (n, 3); undefined for grains that are not placed yet."""
    radius: np.ndarray
    width: float
    depth: float
    tolerance: float
    """Overlap [m] below which two spheres touch."""
    coarsest: float
    """Radius [m] of the coarsest sphere, grain or obstacle. A search reaches as far."""
    cell_size: float
    cell_head: np.ndarray
    """Latest sphere of each cell, shape (layers, rows, columns), -1 for none; see :mod:`lmgcpy.sample.cells`."""
    next_sphere: np.ndarray
    """Next sphere in the cell of each, -1 for none."""


def point_of(sphere, bed):
    """Centre of a sphere [m] as three numbers."""
    return bed.centre[sphere, 0], bed.centre[sphere, 1], bed.centre[sphere, 2]


def enter(sphere, bed):
    """Enter a sphere, whose centre and radius are set, into its cell."""
    layers, rows, columns = bed.cell_head.shape
    x, y, z = point_of(sphere, bed)
    size = bed.cell_size
    cell = cell_of(z, size, layers), cell_of(y, size, rows), cell_of(x, size, columns)
    put(bed.cell_head, bed.next_sphere, cell, sphere)


def plane_of(support, bed):
    """Normal n into the box and offset of the floor or a wall: its points have n . x = offset."""
    if support == FLOOR:
        return (0.0, 0.0, 1.0), 0.0
    if support == LEFT:
        return (1.0, 0.0, 0.0), 0.0
    if support == RIGHT:
        return (-1.0, 0.0, 0.0), -bed.width
    if support == FRONT:
        return (0.0, 1.0, 0.0), 0.0
    return (0.0, -1.0, 0.0), -bed.depth


def gap_to_plane(support, centre, r, bed):
    """Gap [m] between a sphere and the floor or a wall."""
    normal, offset = plane_of(support, bed)
    return normal[0] * centre[0] + normal[1] * centre[1] + normal[2] * centre[2] - offset - r


def blocker(centre, r, bed):
    """A support that a sphere of radius r would overlap, or NONE."""
    for support in (FLOOR, LEFT, RIGHT, FRONT, BACK):
        if gap_to_plane(support, centre, r, bed) < -bed.tolerance:
            return support
    layers, rows, columns = bed.cell_head.shape
    size, reach = bed.cell_size, r + bed.coarsest
    x, y, z = centre
    for layer in range(cell_of(z - reach, size, layers), cell_of(z + reach, size, layers) + 1):
        for row in range(cell_of(y - reach, size, rows), cell_of(y + reach, size, rows) + 1):
            for column in range(cell_of(x - reach, size, columns), cell_of(x + reach, size, columns) + 1):
                sphere = bed.cell_head[layer, row, column]
                while sphere >= 0:
                    dx, dy, dz = x - bed.centre[sphere, 0], y - bed.centre[sphere, 1], z - bed.centre[sphere, 2]
                    distance = bed.radius[sphere] + r - bed.tolerance
                    if dx * dx + dy * dy + dz * dz < distance * distance:
                        return sphere
                    sphere = bed.next_sphere[sphere]
    return NONE


def supports_near(base, reach, bed, found):
    """Write into ``found`` all supports with a gap to a sphere of at most ``reach`` [m], the floor first: their number."""
    count = 0
    centre, r = point_of(base, bed), bed.radius[base]
    # planes: gap n . x - offset - r
    for support in (FLOOR, LEFT, RIGHT, FRONT, BACK):
        if gap_to_plane(support, centre, r, bed) <= reach:
            found[count] = support
            count += 1
    layers, rows, columns = bed.cell_head.shape
    # cells within r + reach + the largest radius
    size, far = bed.cell_size, r + reach + bed.coarsest
    x, y, z = centre
    for layer in range(cell_of(z - far, size, layers), cell_of(z + far, size, layers) + 1):
        for row in range(cell_of(y - far, size, rows), cell_of(y + far, size, rows) + 1):
            for column in range(cell_of(x - far, size, columns), cell_of(x + far, size, columns) + 1):
                sphere = bed.cell_head[layer, row, column]
                while sphere >= 0:
                    # gap |dx| - r - r_sphere <= reach, without the root
                    dx, dy, dz = bed.centre[sphere, 0] - x, bed.centre[sphere, 1] - y, bed.centre[sphere, 2] - z
                    square, distance = dx * dx + dy * dy + dz * dz, r + bed.radius[sphere] + reach
                    if square <= distance * distance and sphere != base:
                        found[count] = sphere
                        count += 1
                    sphere = bed.next_sphere[sphere]
    return count
