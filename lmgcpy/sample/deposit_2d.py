"""Geometric deposit of disks: one after the other, each to the lowest pocket that takes it.

A pocket is a pair of supports, the left one and the right one. A disk of radius r in it has its centre c at r + r_i
from the centre of each disk it rests on, r above the floor, r beside a wall. With contact normals n_i and n_j towards
c, it is stable without friction if the vertical is a n_i + b n_j with a, b >= 0: c lies horizontally between the
two supports and above the line that joins them. There dc . n_i = dc . n_j = dr, so that dy/dr = a + b > 0: a coarser
disk rests higher.

A pocket keeps the interval of radii that it may host. If a radius fails, the interval is shortened from an end that fails
for the same reason, provided that all radii in between fail too. An empty interval closes the pocket. The reasons are:

* c lies on the left of both supports. It is above the left support at a single radius, so that a half-line of radii
  fails. The same holds on the right.
* A third support is in the way. At most two circles touch all three supports. If the third support blocks two radii, it
  blocks all radii in between, unless both circles lie between them: see :func:`free_between`.
"""

import math
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.sample.bed_2d import DiskBed, blocker, enter, overlaps, tangent_radii
from lmgcpy.sample.cells import FLOOR, LEFT, NONE, RIGHT, TOLERANCE, cell_of

# Reasons why a pocket does not host a radius, besides a support that blocks it; all are below NONE.
TOO_LEFT = -11
TOO_RIGHT = -12
APART = -13


class DiskPockets(NamedTuple):
    """Open pockets. The arrays are longer than the number of pockets."""

    left: np.ndarray
    right: np.ndarray
    finest: np.ndarray
    """Smallest radius [m] that a pocket may host."""
    coarsest: np.ndarray
    """Largest radius [m] that a pocket may host."""
    lowest: np.ndarray
    """Lower bound of the height [m] at which the centre of a hosted disk is stable."""


def new_pockets(size):
    """Arrays for ``size`` pockets."""
    return DiskPockets(
        np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size), np.empty(size), np.empty(size)
    )  # fmt: skip


def copy_pocket(source, n, target, m):
    """Copy pocket n of ``source`` to pocket m of ``target``."""
    target.left[m], target.right[m] = source.left[n], source.right[n]
    target.finest[m], target.coarsest[m] = source.finest[n], source.coarsest[n]
    target.lowest[m] = source.lowest[n]


def enlarged(pockets):
    """Copy of the pockets in arrays twice as long."""
    size = len(pockets.left)
    larger = new_pockets(2 * size)
    for n in range(size):
        copy_pocket(pockets, n, larger, n)
    return larger


def rest(left, right, r, bed: DiskBed):
    """Centre of a disk of radius r in a pocket: (NONE or the reason why it is not stable, x, y)."""
    x, y, radius, tolerance = bed.x, bed.y, bed.radius, bed.tolerance
    if left >= 0 and right >= 0:
        dx, dy = x[right] - x[left], y[right] - y[left]
        distance = math.hypot(dx, dy)
        if distance == 0.0:
            return APART, 0.0, 0.0
        reach_left, reach_right = radius[left] + r, radius[right] + r
        # Law of cosines: foot of the centre on the line of the two disks, measured from the left one.
        along = 0.5 * (distance + (reach_left - reach_right) * (reach_left + reach_right) / distance)
        # Pythagoras: distance of the centre from that line; the upper intersection of the two circles is taken.
        across = other_leg(reach_left, along, tolerance)
        if across < 0.0:
            return APART, 0.0, 0.0
        cx = x[left] + (along * dx - across * dy) / distance
        cy = y[left] + (along * dy + across * dx) / distance
        # Stability: the centre lies horizontally between its supports.
        if cx < x[left] - tolerance:
            return TOO_LEFT, cx, cy
        if cx > x[right] + tolerance:
            return TOO_RIGHT, cx, cy
        return NONE, cx, cy
    if left == LEFT or right == RIGHT:
        # Contact with a wall sets x; contact with the disk or the floor sets y.
        cx = r if left == LEFT else bed.width - r
        disk = right if left == LEFT else left
        if disk == FLOOR:
            return NONE, cx, r
        across = other_leg(radius[disk] + r, x[disk] - cx, tolerance)
        if across < 0.0:
            return APART, 0.0, 0.0
        cy = y[disk] + across
        if left == LEFT and cx > x[disk] + tolerance:
            return TOO_RIGHT, cx, cy
        if right == RIGHT and cx < x[disk] - tolerance:
            return TOO_LEFT, cx, cy
        return NONE, cx, cy
    # Contact with the floor sets y = r; contact with the disk sets x, on the side of the floor.
    disk = max(left, right)
    across = other_leg(radius[disk] + r, y[disk] - r, tolerance)
    if across < 0.0:
        return APART, 0.0, 0.0
    return NONE, (x[disk] - across if left == FLOOR else x[disk] + across), r


def other_leg(hypotenuse, leg, tolerance):
    """The other leg of a right triangle, or -1 if the hypotenuse is too short by more than ``tolerance``."""
    if hypotenuse < abs(leg):
        return 0.0 if hypotenuse >= abs(leg) - tolerance else -1.0
    return math.sqrt((hypotenuse - leg) * (hypotenuse + leg))


def fails_alike(reason, left, right, r, bed: DiskBed):
    """Whether radius r fails in a pocket for a given reason: a support that blocks it, or its own position."""
    found, x, y = rest(left, right, r, bed)
    if found == APART or reason < NONE:
        return found == reason
    return overlaps(reason, x, y, r, bed)


def free_between(reason, left, right, a, b, bed: DiskBed):
    """Whether a pocket may host a radius between two radii a < b that fail for the same reason.

    A support that blocks both is clear of the disk in between only if the disk passes above it and, grown, touches it
    again on the other side: at the two radii of Apollonius.
    """
    if reason < NONE:
        return False
    one, other = tangent_radii(left, right, reason, bed)
    return a < one and other < b


def all_fail(reason, left, right, other, a, b, bed: DiskBed):
    """Whether all radii from a to b fail for a reason that holds at one end of the interval; ``other`` is the other end."""
    return fails_alike(reason, left, right, other, bed) and not free_between(reason, left, right, a, b, bed)


def clearance(left, right, bed: DiskBed):
    """Width of the gap [m] between the supports of a pocket."""
    x, y, radius = bed.x, bed.y, bed.radius
    if left >= 0 and right >= 0:
        return math.hypot(x[right] - x[left], y[right] - y[left]) - radius[left] - radius[right]
    disk = max(left, right)
    if disk < 0:
        return 0.0
    if left == LEFT:
        return x[disk] - radius[disk]
    if right == RIGHT:
        return bed.width - x[disk] - radius[disk]
    return y[disk] - radius[disk]


def open_pocket(left, right, finest, coarsest, bed: DiskBed, pockets: DiskPockets, count):
    """Append a pocket, unless no radius between ``finest`` and ``coarsest`` can rest in it: (pockets, count)."""
    # A disk thinner than the clearance falls through between the supports.
    finest = max(finest, 0.5 * clearance(left, right, bed))
    if finest > coarsest:
        return pockets, count
    lowest = 0.0
    # Both ends of the interval are tried. The finer disk rests lower, so that its height is the bound (dy/dr > 0).
    for r, other in ((coarsest, finest), (finest, coarsest)):
        reason, x, y = rest(left, right, r, bed)
        lowest = y if reason == NONE else 0.0
        if reason == NONE:
            reason = blocker(x, y, r, bed)
        if reason != NONE and all_fail(reason, left, right, other, finest, coarsest, bed):
            return pockets, count
    if count == len(pockets.left):
        pockets = enlarged(pockets)
    pockets.left[count], pockets.right[count] = left, right
    pockets.finest[count], pockets.coarsest[count], pockets.lowest[count] = finest, coarsest, lowest
    return pockets, count + 1


def lowest_rest(r, bed: DiskBed, pockets: DiskPockets, count):
    """Lowest centre at which a disk of radius r rests: (x, y, number of open pockets); y is infinite if there is none.

    Pockets that fail on the way are shortened or closed.
    """
    best_x, best_y = 0.0, math.inf
    n = 0
    while n < count:
        if r < pockets.finest[n] or r > pockets.coarsest[n] or pockets.lowest[n] >= best_y:
            n += 1
            continue
        left, right = pockets.left[n], pockets.right[n]
        reason, x, y = rest(left, right, r, bed)
        if reason == NONE:
            if y >= best_y:
                n += 1
                continue
            reason = blocker(x, y, r, bed)
        if reason == NONE:
            best_x, best_y = x, y
        else:
            # The interval of radii is shortened from its ends; the factors step over r itself.
            finest, coarsest = pockets.finest[n], pockets.coarsest[n]
            if all_fail(reason, left, right, finest, finest, r, bed):
                pockets.finest[n] = r * (1.0 + 1e-15)
            if all_fail(reason, left, right, coarsest, r, coarsest, bed):
                pockets.coarsest[n] = r * (1.0 - 1e-15)
            if pockets.finest[n] > pockets.coarsest[n]:
                count -= 1
                copy_pocket(pockets, count, pockets, n)
                continue
        n += 1
    return best_x, best_y, count


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
