"""Geometric deposit of spheres: one after the other, each to the lowest pocket that takes it."""

import math

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.sample.bed_3d import SphereBed, enter
from lmgcpy.sample.cells import TOLERANCE
from lmgcpy.sample.pocket_3d import new_near, open_pockets
from lmgcpy.sample.shelves_3d import lowest_rest, new_pockets, new_shelves


def deposit_3d(
    radii: np.ndarray,
    order: np.ndarray,
    width: float,
    depth: float,
    height: float,
    obstacle_positions: np.ndarray,
    obstacle_radii: np.ndarray,
) -> tuple[np.ndarray, int]:
    """Positions [m], shape (n, 3), of grains placed in the ``order`` given, and the number of grains placed.

    The ``height`` of the box may be infinite. If a grain fits nowhere, it and all grains after it stay at the origin.
    """
    top = expected_top(radii, width * depth)
    bed = empty_bed(radii[order], width, depth, top, obstacle_positions, obstacle_radii)
    obstacle_count = len(obstacle_radii)
    # Shelves are thin, so that grains of one size see few pockets besides the lowest, but no more than there are bodies.
    shelf_height = max(0.1 * float(radii.mean()), top / (len(bed.radius) + 64.0))
    placed = fill(bed, obstacle_count, height, int(top / shelf_height) + 1, shelf_height)
    positions = np.zeros((len(radii), 3))
    positions[order[:placed]] = bed.centre[obstacle_count : obstacle_count + placed]
    return positions, placed


def expected_top(radii: np.ndarray, area: float) -> float:
    """Height [m] that grains on an area hardly exceed. If they do, around many obstacles, the deposit takes longer."""
    return 4.0 / 3.0 * math.pi * float(np.sum(radii**3)) / (0.5 * area) + 6.0 * float(radii.max())


def empty_bed(
    radii: np.ndarray,
    width: float,
    depth: float,
    top: float,
    obstacle_positions: np.ndarray,
    obstacle_radii: np.ndarray,
) -> SphereBed:
    """A bed for obstacles and grains, none of which is in its cells yet; cells reach up to ``top`` [m]."""
    radius = np.concatenate((obstacle_radii, radii))
    # At most about eight cells for each sphere, however narrow or wide the box is.
    size = max(2.0 * float(radii.mean()), math.cbrt(width * depth * top / (8.0 * len(radius) + 64.0)))
    return SphereBed(
        centre=np.concatenate((obstacle_positions, np.empty((len(radii), 3)))),
        radius=radius,
        width=width,
        depth=depth,
        # The tolerance is not below round-off of the positions, some units in the last place.
        tolerance=max(TOLERANCE * float(radii.min()), 1e-15 * (width + depth + top)),
        coarsest=float(radius.max()),
        cell_size=size,
        cell_head=np.full([int(length / size) + 1 for length in (top, depth, width)], -1, np.int64),
        next_sphere=np.empty(len(radius), np.int64),
    )


@kernel
def fill(bed: SphereBed, obstacle_count, height, shelf_count, shelf_height):
    """Enter the obstacles, then place the grains in their order; returns the number placed and sets ``bed.centre``."""
    finest, coarsest = bed.radius[obstacle_count:].min(), bed.radius[obstacle_count:].max()
    pockets, shelves = new_pockets(1024), new_shelves(shelf_count, shelf_height, finest, coarsest)
    near = new_near(len(bed.radius) + 5)
    for sphere in range(len(bed.radius)):
        if sphere >= obstacle_count:
            r = bed.radius[sphere]
            (x, y, z), pockets = lowest_rest(r, bed, pockets, shelves)
            if z == math.inf or z + r > height + bed.tolerance:
                return sphere - obstacle_count
            bed.centre[sphere, 0], bed.centre[sphere, 1], bed.centre[sphere, 2] = x, y, z
        enter(sphere, bed)
        pockets = open_pockets(sphere, finest, coarsest, bed, near, pockets, shelves)
    return len(bed.radius) - obstacle_count
