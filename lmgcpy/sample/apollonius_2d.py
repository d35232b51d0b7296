"""The circles that touch three supports from outside (problem of Apollonius); a support is a disk, the floor or a wall."""

import math

from lmgcpy.sample.bed_2d import DiskBed
from lmgcpy.sample.cells import FLOOR, LEFT


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
