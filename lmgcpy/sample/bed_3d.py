"""The bodies that lie in a 3D box: spheres in the cells of a grid, a floor, four walls; and the spheres that touch them.

Supports are named as :mod:`lmgcpy.sample.cells` says.

Let one of the supports, the base, be a sphere of radius r0 around p0. For a sphere of radius r around c that touches it
let v = c - p0 and s = r + r0: |v| = s. It touches another support if a gap form, linear in v and s, is zero,

    F(v, s) = e - d . v - rho s,

with d = p - p0, rho = r_p - r0, e = (d² - rho²)/2 for a sphere of radius r_p around p, and with d = -n, rho = 1,
e = r0 + n . p0 - offset for a plane; F > 0 if there is a gap. Two such equations leave v = alpha + beta s + g w, with
a unit vector w normal to both d, and |v| = s gives g(s) = sqrt(s² - |alpha + beta s|²): one branch for each sign of w.
With k = 1 - beta² and h = alpha . beta it is g² = k s² - 2 h s - alpha². As this is not positive at s = 0, g is real in
one interval of s > 0 only, and concave there.

Along the curve any gap form is A + B s + C g(s) (:class:`GapAlong`): convex or concave, with at most two roots.
"""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference
from lmgcpy.sample.cells import BACK, FLOOR, FRONT, LEFT, NONE, RIGHT, cell_of, put

SLIVER = 1e-6
"""Sine of the angle below which two directions count as one: round-off grows as its inverse."""
ROUND_OFF = 1e-12
"""Round-off of a gap form, relative to its terms; about a hundred times the largest that was seen."""


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


class GapForm(NamedTuple):
    """F(v, s) = e - d . v - rho s."""

    d: tuple[float, float, float]
    rho: float
    e: float


class TangentCurve(NamedTuple):
    """v(s) = alpha + beta s + g(s) w."""

    alpha: tuple[float, float, float]
    beta: tuple[float, float, float]
    w: tuple[float, float, float]


class GapAlong(NamedTuple):
    """F(s) = a + b s + c g(s)."""

    a: float
    b: float
    c: float


def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def scaled(a, x):
    """a x."""
    return a * x[0], a * x[1], a * x[2]


def added(x, a, y):
    """x + a y."""
    return x[0] + a * y[0], x[1] + a * y[1], x[2] + a * y[2]


def tangency(support, base, slack, bed: SphereBed):
    """The gap form that is zero where a sphere that touches ``base`` overlaps a support by ``slack`` [m]."""
    centre, r = point_of(base, bed), bed.radius[base]
    if support >= 0:
        d = added(point_of(support, bed), -1.0, centre)
        rho = bed.radius[support] - slack - r
        return GapForm(d, rho, 0.5 * (dot(d, d) - rho * rho))
    normal, offset = plane_of(support, bed)
    return GapForm(scaled(-1.0, normal), 1.0, r + dot(normal, centre) - offset + slack)


def tangent_curve(one: GapForm, other: GapForm):
    """The spheres that touch the base and two supports, w along one.d x other.d: (whether there are any, curve)."""
    w = cross(one.d, other.d)
    square = dot(w, w)
    if square <= SLIVER**2 * dot(one.d, one.d) * dot(other.d, other.d):
        return False, TangentCurve(w, w, w)
    # Dual basis of the two d: alpha and beta solve d . v = e - rho s for both supports.
    a, b = scaled(1.0 / square, cross(other.d, w)), scaled(1.0 / square, cross(w, one.d))
    alpha = added(scaled(one.e, a), other.e, b)
    beta = added(scaled(-one.rho, a), -other.rho, b)
    return True, TangentCurve(alpha, beta, scaled(1.0 / math.sqrt(square), w))


def tangent_ring(one: GapForm):
    """The spheres that touch the base and one support: at each s a circle around alpha + beta s, of radius g(s)."""
    square = dot(one.d, one.d)
    return TangentCurve(scaled(one.e / square, one.d), scaled(-one.rho / square, one.d), (0.0, 0.0, 0.0))


def across(curve: TangentCurve, s):
    """g(s), zero outside its interval."""
    u = added(curve.alpha, s, curve.beta)
    return math.sqrt(max(s * s - dot(u, u), 0.0))


def centre_at(curve: TangentCurve, s):
    """v(s)."""
    return added(added(curve.alpha, s, curve.beta), across(curve, s), curve.w)


def coefficients(curve: TangentCurve):
    """k, h and alpha² in g² = k s² - 2 h s - alpha²."""
    return 1.0 - dot(curve.beta, curve.beta), dot(curve.alpha, curve.beta), dot(curve.alpha, curve.alpha)


def real_interval(curve: TangentCurve):
    """The interval of s > 0 in which g is real, up to round-off; the first end is above the last if there is none."""
    # Roots of k s² - 2 h s - alpha² = 0: one without cancellation, the other from the product -alpha²/k.
    k, h, square = coefficients(curve)
    root = h * h + k * square
    if root < 0.0:
        return math.inf, 0.0
    t = h + math.copysign(math.sqrt(root), h)
    if t == 0.0:
        return (0.0, math.inf) if k >= 0.0 and square == 0.0 else (math.inf, 0.0)
    one, other = t / k, -square / t
    if k >= 0.0:  # the lower root is negative, or infinite
        return max(one, other) * (1.0 - ROUND_OFF), math.inf
    return min(one, other) * (1.0 - ROUND_OFF), max(one, other) * (1.0 + ROUND_OFF)


def along(form: GapForm, curve: TangentCurve):
    """A gap form along a curve."""
    return GapAlong(
        form.e - dot(form.d, curve.alpha), -dot(form.d, curve.beta) - form.rho, -dot(form.d, curve.w)
    )  # fmt: skip


def largest_on(form: GapForm, one: GapForm, ring: TangentCurve):
    """The largest value of a gap form on the ring of another one, at each s."""
    a, b, _ = along(form, ring)
    # Part of d across the axis of the ring; on the ring -d . v varies by g times its length.
    across_axis = added(form.d, -dot(form.d, one.d) / dot(one.d, one.d), one.d)
    return GapAlong(a, b, math.sqrt(dot(across_axis, across_axis)))


def negative(form: GapAlong, curve: TangentCurve, s):
    """Whether F(s) < 0 beyond round-off, which must not take one side of a root for the other."""
    return form.a + form.b * s + form.c * across(curve, s) < -ROUND_OFF * (abs(form.a) + abs(form.b * s))


def between_roots(form: GapAlong, curve: TangentCurve, s):
    """Ends of the interval around s in which F has no root; an end is infinite if there is no root on its side.

    A + B s = -C g, squared, is (B² - C² k) s² + 2 (A B + C² h) s + A² + C² alpha² = 0. Its discriminant has a factor C²,
    which is taken out by hand because of round-off. Roots of A + B s = +C g are left out; in doubt they count as ends.
    """
    a, b, c = form
    k, h, square = coefficients(curve)
    below, above = -math.inf, math.inf
    root = k * a * a + 2.0 * a * b * h - b * b * square + c * c * (h * h + k * square)
    if root >= 0.0:
        half = a * b + c * c * h
        # Two roots without cancellation; a root counts if A + B s has the sign of -C.
        t = -(half + math.copysign(abs(c) * math.sqrt(root), half))
        for end in (t / (b * b - c * c * k), (a * a + c * c * square) / t):
            if (a + b * end) * math.copysign(1.0, c) <= ROUND_OFF * (abs(a) + abs(b * end)):
                if end < s:
                    below = max(below, end)
                elif end > s:
                    above = min(above, end)
    return below, above


def clipped(form: GapAlong, curve: TangentCurve, first, last):
    """Cut an interval of s at its ends where a gap form is negative; first > last if nothing is left."""
    if negative(form, curve, last):
        last = min(last, between_roots(form, curve, last)[0])
    if first <= last and negative(form, curve, first):
        first = max(first, between_roots(form, curve, first)[1])
    return first, last
