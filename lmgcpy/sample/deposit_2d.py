"""Geometric deposit of disks: one after the other, each to the lowest pocket that takes it."""

import math

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.sample.bed_2d import DiskBed, enter
from lmgcpy.sample.cells import FLOOR, LEFT, RIGHT, TOLERANCE, cell_of
from lmgcpy.sample.pocket_2d import DiskPockets, lowest_rest, new_pockets, open_pocket


def deposit_2d(
    radii: np.ndarray,
    order: np.ndarray,
    width: float,
    height: float,
    obstacle_positions: np.ndarray,
    obstacle_radii: np.ndarray,
) -> tuple[np.ndarray, int]:
    """Positions [m], shape (n, 2), of grains placed in the ``order`` given, and the number of grains placed.

    The ``height`` of the box may be infinite. If a grain fits nowhere, it and all grains after it stay at the origin.
    """
    bed = empty_bed(radii[order], width, obstacle_positions, obstacle_radii)
    placed = fill(bed, len(obstacle_radii), height)
    positions = np.zeros((len(radii), 2))
    grains = slice(len(obstacle_radii), len(obstacle_radii) + placed)
    positions[order[:placed]] = np.column_stack((bed.x[grains], bed.y[grains]))
    return positions, placed


def empty_bed(radii: np.ndarray, width: float, obstacle_positions: np.ndarray, obstacle_radii: np.ndarray) -> DiskBed:
    """A bed for obstacles and grains, none of which is in its cells yet."""
    radius = np.concatenate((obstacle_radii, radii))
    x = np.concatenate((obstacle_positions[:, 0], np.empty(len(radii))))
    y = np.concatenate((obstacle_positions[:, 1], np.empty(len(radii))))
    area = math.pi * float(np.sum(radius**2))
    top = area / (0.7 * width) + 6.0 * float(radii.max())
    # At most about eight cells for each disk, however narrow or wide the box is.
    size = max(2.0 * float(radii.mean()), math.sqrt(width * top / (8.0 * len(radius) + 64.0)))
    columns, rows = int(width / size) + 1, int(top / size) + 1
    entry_count = int(np.sum((np.floor(2.0 * radius / size) + 2.0) ** 2))
    return DiskBed(
        x=x,
        y=y,
        radius=radius,
        width=width,
        tolerance=TOLERANCE * float(radii.min()),
        cell_size=size,
        cell_head=np.full((rows, columns), -1, np.int64),
        entry_disk=np.empty(entry_count, np.int64),
        entry_next=np.empty(entry_count, np.int64),
        entry_count=np.zeros(1, np.int64),
    )


@kernel
def fill(bed: DiskBed, obstacle_count, height):
    """Enter the obstacles, then place the grains in their order; returns the number placed and sets ``bed.x``, ``bed.y``.

    Open pockets lie at the surface and in the holes below it; there are about as many as grains in a row. To search all of
    them for every grain costs less than to keep them sorted.
    """
    finest, coarsest = bed.radius[obstacle_count:].min(), bed.radius[obstacle_count:].max()
    pockets = new_pockets(1024)
    met = np.full(len(bed.x), -1, np.int64)
    pockets, count = open_pocket(LEFT, FLOOR, finest, coarsest, bed, pockets, 0)
    pockets, count = open_pocket(FLOOR, RIGHT, finest, coarsest, bed, pockets, count)
    for disk in range(obstacle_count):
        enter(disk, bed)
        pockets, count = open_around(disk, finest, coarsest, bed, pockets, count, met)
    for disk in range(obstacle_count, len(bed.x)):
        r = bed.radius[disk]
        x, y, count = lowest_rest(r, bed, pockets, count)
        if y == np.inf or y + r > height + bed.tolerance:  # infinite if no pocket is left
            return disk - obstacle_count
        bed.x[disk], bed.y[disk] = x, y
        enter(disk, bed)
        pockets, count = open_around(disk, finest, coarsest, bed, pockets, count, met)
    return len(bed.x) - obstacle_count


def open_around(disk, finest, coarsest, bed: DiskBed, pockets: DiskPockets, count, met):
    """Open the pockets between a disk and all supports near it: (pockets, count). ``met`` marks disks that were seen."""
    for left, right in ((LEFT, disk), (disk, RIGHT), (FLOOR, disk), (disk, FLOOR)):
        pockets, count = open_pocket(left, right, finest, coarsest, bed, pockets, count)
    rows, columns = bed.cell_head.shape
    x, y, size = bed.x[disk], bed.y[disk], bed.cell_size
    reach = bed.radius[disk] + 2.0 * coarsest
    met[disk] = disk
    for row in range(cell_of(y - reach, size, rows), cell_of(y + reach, size, rows) + 1):
        for column in range(cell_of(x - reach, size, columns), cell_of(x + reach, size, columns) + 1):
            entry = bed.cell_head[row, column]
            while entry >= 0:
                other = bed.entry_disk[entry]
                if met[other] != disk:
                    met[other] = disk
                    left, right = (other, disk) if bed.x[other] < x else (disk, other)
                    pockets, count = open_pocket(left, right, finest, coarsest, bed, pockets, count)
                entry = bed.entry_next[entry]
    return pockets, count
