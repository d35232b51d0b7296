"""Pockets: the places where a disk rests on two supports, and the list of those that may still take a grain.

A pocket is a pair of supports, the left one and the right one. A disk of radius r in it has its centre c at r + r_i
from the centre of each disk it rests on, r above the floor, r beside a wall. With contact normals n_i and n_j towards
c, it is stable without friction where the vertical is a n_i + b n_j with a, b >= 0: c lies horizontally between the
two supports and above the line that joins them. There dc . n_i = dc . n_j = dr, so that dy/dr = a + b > 0: a coarser
disk rests higher.

All bookkeeping rests on intervals. A pocket keeps the interval of radii it may host. A radius that fails in it shortens
the interval from an end that fails for the same reason, provided that all radii in between fail too, and an empty
interval closes the pocket. Provided for are:

* c on the left of both supports: it is above the left one at a single radius, so that a half-line of radii fails; the
  same on the right;
* a third support in the way: the circles that touch all three are two at most. Where it blocks two radii it blocks
  those in between, unless both circles are there: see :func:`free_between`.
"""

import math
from typing import NamedTuple

import numpy as np

from lmgcpy.sample.apollonius_2d import tangent_radii
from lmgcpy.sample.bed_2d import FLOOR, LEFT, NONE, RIGHT, Bed, blocker, overlaps

# why a pocket does not host a radius, besides a support that blocks it
TOO_LEFT = -11
TOO_RIGHT = -12
APART = -13


class Pockets(NamedTuple):
    """Open pockets; the arrays are longer than the list."""

    left: np.ndarray
    right: np.ndarray
    finest: np.ndarray
    """Smallest and largest radius [m] that a pocket may host."""
    coarsest: np.ndarray
    lowest: np.ndarray
    """No disk that the pocket may host is stable with its centre below this height [m]."""


def new_pockets(size):
    """Room for ``size`` pockets."""
    return Pockets(
        np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size), np.empty(size), np.empty(size)
    )  # fmt: skip


def copy_pocket(source, n, target, m):
    """Make pocket m of ``target`` pocket n of ``source``."""
    target.left[m], target.right[m] = source.left[n], source.right[n]
    target.finest[m], target.coarsest[m] = source.finest[n], source.coarsest[n]
    target.lowest[m] = source.lowest[n]


def enlarged(pockets):
    """The same pockets with twice the room."""
    size = len(pockets.left)
    larger = new_pockets(2 * size)
    for n in range(size):
        copy_pocket(pockets, n, larger, n)
    return larger


def rest(left, right, r, bed: Bed):
    """Centre of a disk of radius r in a pocket: (NONE or why it is not stable, x, y)."""
    x, y, radius, tolerance = bed.x, bed.y, bed.radius, bed.tolerance
    if left >= 0 and right >= 0:
        dx, dy = x[right] - x[left], y[right] - y[left]
        distance = math.hypot(dx, dy)
        if distance == 0.0:
            return APART, 0.0, 0.0
        reach_left, reach_right = radius[left] + r, radius[right] + r
        along = 0.5 * (distance + (reach_left - reach_right) * (reach_left + reach_right) / distance)
        across = other_leg(reach_left, along, tolerance)
        if across < 0.0:
            return APART, 0.0, 0.0
        cx = x[left] + (along * dx - across * dy) / distance
        cy = y[left] + (along * dy + across * dx) / distance
        if cx < x[left] - tolerance:
            return TOO_LEFT, cx, cy
        if cx > x[right] + tolerance:
            return TOO_RIGHT, cx, cy
        return NONE, cx, cy
    if left == LEFT or right == RIGHT:
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
    disk = max(left, right)
    across = other_leg(radius[disk] + r, y[disk] - r, tolerance)
    if across < 0.0:
        return APART, 0.0, 0.0
    return NONE, (x[disk] - across if left == FLOOR else x[disk] + across), r


def other_leg(hypotenuse, leg, tolerance):
    """The other leg of a right triangle, or -1 where the hypotenuse is too short by more than ``tolerance``."""
    if hypotenuse < abs(leg):
        return 0.0 if hypotenuse >= abs(leg) - tolerance else -1.0
    return math.sqrt((hypotenuse - leg) * (hypotenuse + leg))


def fails_alike(reason, left, right, r, bed: Bed):
    """Whether radius r fails in a pocket for a given reason: a support that blocks it, or its place."""
    state, x, y = rest(left, right, r, bed)
    if state == APART or reason < NONE:
        return state == reason
    return overlaps(reason, x, y, r, bed)


def free_between(reason, left, right, a, b, bed: Bed):
    """Whether a pocket may host a radius between two, a < b, that fail for the same reason.

    A support that blocks both lets something through in between only as the disk passes above it and, grown, touches
    it again on the other side of a small support: at the two radii of Apollonius.
    """
    if reason < NONE:
        return False
    one, other = tangent_radii(left, right, reason, bed)
    return a < one and other < b


def all_fail(reason, left, right, other, a, b, bed: Bed):
    """Whether all radii from a to b fail for a reason that holds at one of the two, ``other`` being the other one."""
    return fails_alike(reason, left, right, other, bed) and not free_between(reason, left, right, a, b, bed)


def clearance(left, right, bed: Bed):
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


def open_pocket(left, right, finest, coarsest, bed: Bed, pockets: Pockets, count):
    """Append a pocket, unless no radius between ``finest`` and ``coarsest`` can rest in it: (pockets, count)."""
    finest = max(finest, 0.5 * clearance(left, right, bed))
    if finest > coarsest:
        return pockets, count
    lowest = 0.0
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


def lowest_place(r, bed: Bed, pockets: Pockets, count):
    """Lowest place for a disk of radius r: (x, y, open pockets left); y is infinite where there is none.

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
            # the factors step over r itself
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
