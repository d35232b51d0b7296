"""Geometric deposit of spheres: one after the other, each to the lowest pocket that takes it.

A pocket is a triple of supports; the first of them, its base, is a sphere. The spheres that touch all three lie on a
curve: see :mod:`lmgcpy.sample.bed_3d`. Such a sphere is stable without friction if the vertical is a combination
of the contact normals with coefficients a, b, c >= 0. With the floor among the supports it is stable everywhere. Otherwise
it is stable if its centre is above the plane of the supports' centres and, seen from above, between them; the centre of
a wall is at infinity behind it. As dv . n = dr for each of the normals, dz/dr = a + b + c >= 1: in one pocket a coarser
sphere does not reach lower than a finer one.

A pocket keeps an interval of s, the sum of the radii of the sphere and of the base. Each further support and each limit of
stability is a gap form that must not be negative. If a gap form is negative for one s, it is negative in an interval around
s. The ends of that interval are known, and it is taken away from the pocket. Nothing else closes a pocket, so that no
position is missed.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.sample.bed_3d import (
    SLIVER,
    GapForm,
    SphereBed,
    along,
    clipped,
    enter,
    gap_to_plane,
    largest_on,
    point_of,
    real_interval,
    supports_near,
    tangency,
    tangent_curve,
    tangent_ring,
)
from lmgcpy.sample.cells import FLOOR, TOLERANCE
from lmgcpy.sample.shelves_3d import Shelves, SpherePockets, add, lowest_rest, new_pockets, new_shelves


class NearSupports(NamedTuple):
    """The supports near a new sphere, the base. The arrays are longer than the number of supports."""

    support: np.ndarray
    d: np.ndarray
    """Gap forms of spheres that must not overlap a support by more than the tolerance: d, shape (n, 3), rho, e."""
    rho: np.ndarray
    e: np.ndarray
    first: np.ndarray
    """Ends of the interval of s of spheres that touch the base and this support."""
    last: np.ndarray


def new_near(size):
    """Arrays for ``size`` supports."""
    return NearSupports(
        np.empty(size, np.int64), np.empty((size, 3)), np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    )  # fmt: skip


def form_of(i, near: NearSupports):
    """Gap form of a sphere that must not overlap a support near the base."""
    return GapForm((near.d[i, 0], near.d[i, 1], near.d[i, 2]), near.rho[i], near.e[i])


def open_pockets(base, finest, coarsest, bed: SphereBed, near: NearSupports, pockets: SpherePockets, shelves: Shelves):
    """The pockets, with the new ones between a new sphere, the base, and two supports near it that can host grains."""
    r, reach = bed.radius[base], 2.0 * coarsest
    count = supports_near(base, reach, bed, near.support)
    # Gap forms of all supports near the base.
    for i in range(count):
        form = tangency(near.support[i], base, bed.tolerance, bed)
        near.d[i, 0], near.d[i, 1], near.d[i, 2] = form.d
        near.rho[i], near.e[i] = form.rho, form.e
    for i in range(count):
        one = tangency(near.support[i], base, 0.0, bed)
        # Interval of s that the base and this support leave, before a third support is chosen.
        first, last = hosted_by_two(i, one, finest + r, coarsest + r, near, count)
        near.first[i], near.last[i] = first, last
        for j in range(i):
            least, most = max(first, near.first[j]), min(last, near.last[j])
            if least > most or not within(near.support[i], near.support[j], reach, bed):
                continue
            other = tangency(near.support[j], base, 0.0, bed)
            # The upper branch of the curve is the stable one. With the floor, which comes first, both are stable.
            with_floor = near.support[j] == FLOOR
            for a, b, k, m in ((one, other, i, j), (other, one, j, i)):
                if with_floor or a.d[0] * b.d[1] - a.d[1] * b.d[0] > 0.0:
                    curve, begin, end = hosted_by_three(k, m, a, b, least, most, bed.tolerance, near, count)
                    if begin <= end:
                        triple = base, near.support[k], near.support[m]
                        pockets = add(triple, curve, begin, end, bed, pockets, shelves)
    return pockets


def hosted_by_two(i, one: GapForm, first, last, near: NearSupports, count):
    """The open part of an interval of s for spheres that touch the base and a support near it.

    Nothing is left if the other supports cover the whole ring of these spheres at each s. Most supports near a sphere lie
    behind others: leaving them out here saves two thirds of the time for a wide grading.
    """
    ring = tangent_ring(one)
    # The ring exists if its radius g(s) is real.
    least, most = real_interval(ring)
    first, last = max(first, least), min(last, most)
    for k in range(count):
        if first > last:
            break
        # A support closes s if even the largest gap on the ring is negative.
        if k != i:
            first, last = clipped(largest_on(form_of(k, near), one, ring), ring, first, last)
    return first, last


def hosted_by_three(i, j, one: GapForm, other: GapForm, first, last, tolerance, near: NearSupports, count):
    """The open part of an interval of s in a pocket, on the branch one.d x other.d: (curve, first, last)."""
    found, curve = tangent_curve(one, other)
    with_floor = near.support[i] == FLOOR or near.support[j] == FLOOR
    # A branch that does not lead upward is not stable.
    if not found or (curve.w[2] < SLIVER and not with_floor):
        return curve, math.inf, 0.0
    # The curve exists where g(s) is real.
    least, most = real_interval(curve)
    first, last = max(first, least), min(last, most)
    # Stability: the three coefficients of the vertical are not negative.
    if not with_floor:
        for form in stability(one, other, near.support[i] >= 0, near.support[j] >= 0, tolerance):
            if first <= last:
                first, last = clipped(along(form, curve), curve, first, last)
    # Clearance: the gap to every other support is not negative.
    for k in range(count):
        if first > last:
            break
        if k != i and k != j:
            first, last = clipped(along(form_of(k, near), curve), curve, first, last)
    return curve, first, last


def within(one, other, reach, bed: SphereBed):
    """Whether the gap between two supports, the second one a plane if one is, is at most ``reach`` [m]."""
    if one < 0:
        return True
    x, y, z = point_of(one, bed)
    if other < 0:
        return gap_to_plane(other, (x, y, z), bed.radius[one], bed) <= reach
    dx, dy, dz = x - bed.centre[other, 0], y - bed.centre[other, 1], z - bed.centre[other, 2]
    distance = bed.radius[one] + bed.radius[other] + reach
    return dx * dx + dy * dy + dz * dz <= distance * distance


def stability(one: GapForm, other: GapForm, one_is_sphere, other_is_sphere, slack):
    """Three gap forms that are not negative if a sphere on the base and two supports is stable, up to ``slack`` [m].

    The coefficients a, b, c are proportional to the areas, seen from above, spanned by two of the contact vectors each: v
    for the base, v - d for a sphere and -d for a wall. ``one`` and ``other`` are ordered so that one.d x other.d points
    upward.
    """
    ax, ay, bx, by = one.d[0], one.d[1], other.d[0], other.d[1]
    # Side of the triangle that does not meet the base: from sphere to sphere, or along a wall.
    ux, uy = 0.0, 0.0
    if one_is_sphere:
        ux, uy = ux + bx, uy + by
    if other_is_sphere:
        ux, uy = ux - ax, uy - ay
    return (
        GapForm((ay, -ax, 0.0), 0.0, slack * math.hypot(ax, ay)),
        GapForm((-by, bx, 0.0), 0.0, slack * math.hypot(bx, by)),
        GapForm((uy, -ux, 0.0), 0.0, ax * by - ay * bx + slack * math.hypot(ux, uy)),
    )


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
