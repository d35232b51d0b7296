"""Surfaces of many features: how faces, edges and corners of a mesh, lines and tips of a polyline, are met.

A surface is a mesh of triangles, in the plane a polyline, with a radius r >= 0: the points within r of it. Each feature is
a contactor of its own: in space ``face``, ``edge`` and ``corner``, in the plane ``line`` and ``tip``. A ball meets one of
them if its centre lies in the normal cone of the feature, in which the feature has the nearest point of the surface, and is
:data:`APART` from it otherwise. With y from a corner of the feature to the centre these cones are

* of a face ``m . y < 0`` for its three edges, m the outward vectors in its plane;
* of an edge from p_0 to p_1 along e ``e . (x - p_0) > 0``, ``e . (x - p_1) < 0``, and ``m . y >= 0`` for the m of both of
  its faces;
* of a corner ``e . y <= 0`` for the directions e to all corners next to it. These are enough: a triangle lies between two
  of them, so that this is the polar cone of the surface near the corner.

They fill the space around the surface and overlap only in hollow corners. So a ball has one contact on a flat mesh or over
a convex edge, and two or three in a hollow corner. The two sides of a boundary are one number compared in two ways: all
features of a surface are seen from the same point, the position of their contactors, and share their vectors. So rounding
leaves no gap; only beside a corner of the boundary, by 1e-12 of the size of the surface, there may be more contacts of one
normal. Flat edges have no contactor; the faces beside one share the vector m, up to its sign. Around a
flat corner exactly one face is met if the boundaries are moved a little in a direction that is parallel to none of them
(:data:`ASIDE`): they are still boundaries of one partition of the plane.

**One side.** If a solid lies behind the surface, a hollow edge has no contactor, a corner has none unless its cone is
outside, and the normal of a face points outward even if the centre is behind it. Behind the surface the faces beside an
edge part in the plane that bisects the angle theta of the solid: ``m . y + depth cot(theta/2) < 0``. A centre is
met no deeper than its radius, and no deeper than half-way to the next face behind.

Corners are seen from the position of the contactors, along the axes of the body.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import Kernel
from lmgcpy.contact.contactor_pairs import APART, OF_SURFACES, disk_wall, register_pair, sphere_cylinder, sphere_plane
from lmgcpy.contact.frames import cross, tangent_of
from lmgcpy.contact.positions import rotated, turned_back

to_space: Callable[..., Any] = Slot("to_space")
"""``(position, v)``: a vector along the axes of space, from its components along the axes of the body at a position."""
to_body: Callable[..., Any] = Slot("to_body")
"""The way back."""

FLAT = 1e-6
"""Angle below which the two faces of an edge lie in one plane [rad]; coordinates of a file have seven digits."""
ASIDE = 1e-12
"""By how much boundaries between faces in one plane are moved, in parts of the size of the surface."""
GENERIC = np.array([0.5377, 0.8339, 0.1247])
"""A direction that is parallel to no edge but by chance."""
SLACK = 1e-9
"""Sine of the angle by which a normal between two surfaces may lie beside a cone: bodies that rest on flat sides."""
ROUNDED = 2.0**-49
"""Part of the coordinates of a centre by which its place in the cone of a corner may be rounded, eight roundings."""
DEEP = 1e60
"""A depth that no body reaches [m]."""
SIZES = {"face": 30, "edge": 16, "line": 17}
"""How many numbers shapes have. The number for a corner or a tip depends on its directions."""


def dot(u, v):
    """``u . v`` in space."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def less(u, v):
    """``u - v`` in space."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def beyond_side(x, shape, at):
    """Distance of the foot of a point beyond a side of a face, ``m . y``; its numbers begin ``at``: q, m, cot(theta/2),
    bound."""
    y = (x[0] - shape[at], x[1] - shape[at + 1], x[2] - shape[at + 2])
    return dot((shape[at + 3], shape[at + 4], shape[at + 5]), y)


def ball_face(centre, radius, position_a, shape_a):
    """A ball and a face. ``shape_a``: radius, 0 for both sides or 1 for one, greatest depth, outward normal, and for each
    edge a corner of it, the outward vector in the plane, cot(theta/2), and the bound of the test."""
    x = to_body(position_a, less(centre, position_a))
    n = (shape_a[3], shape_a[4], shape_a[5])
    z = dot(n, less(x, (shape_a[6], shape_a[7], shape_a[8])))
    depth = max(0.0, -z) if shape_a[1] > 0.0 else 0.0
    one = beyond_side(x, shape_a, 6)
    other = beyond_side(x, shape_a, 14)
    third = beyond_side(x, shape_a, 22)
    inside = one + shape_a[12] * depth < shape_a[13] and other + shape_a[20] * depth < shape_a[21]
    if not (inside and third + shape_a[28] * depth < shape_a[29]):
        return APART
    if too_deep(depth, max(one, other, third), radius, shape_a):
        return APART
    if shape_a[1] == 0.0 and z < 0.0:
        z = -z
        n = (-n[0], -n[1], -n[2])
    return gap_below(centre, radius, z, to_space(position_a, n), shape_a[0])


def too_deep(depth, beyond, radius, shape_a):
    """Whether a centre behind a facet is farther from it than the radii of both, or than half-way to the next facet."""
    far = max(0.0, beyond)
    within = radius + shape_a[0]
    return depth > 0.0 and (depth > shape_a[2] or depth * depth + far * far > within * within)


def gap_below(centre, radius, distance, n, radius_a):
    """(gap, normal, middle of the gap) of a ball at a distance from a foot, n the normal from there to its centre."""
    gap = distance - radius - radius_a
    reach = radius + 0.5 * gap
    return gap, n, (centre[0] - reach * n[0], centre[1] - reach * n[1], centre[2] - reach * n[2])


def sideways(shape):
    """A unit normal of an edge between the outward vectors of its faces, for a centre that lies on it."""
    n = (shape[10] + shape[13], shape[11] + shape[14], shape[12] + shape[15])
    length = math.sqrt(dot(n, n))
    if length > 1e-3:
        return n[0] / length, n[1] / length, n[2] / length
    return tangent_of(shape[7], shape[8], shape[9])


def beside_faces(d, shape, slack):
    """Whether a vector from an edge points away from both of its faces."""
    least = -slack
    return dot((shape[10], shape[11], shape[12]), d) >= least and dot((shape[13], shape[14], shape[15]), d) >= least


def ball_edge(centre, radius, position_a, shape_a, slack):
    """A ball and an edge. ``shape_a``: radius, both corners, the unit vector from the first to the second, and the outward
    vectors of its two faces in their planes, zero if it has none."""
    x = to_body(position_a, less(centre, position_a))
    y = less(x, (shape_a[1], shape_a[2], shape_a[3]))
    e = (shape_a[7], shape_a[8], shape_a[9])
    s = dot(e, y)
    if not (s > 0.0 and dot(e, less(x, (shape_a[4], shape_a[5], shape_a[6]))) < 0.0):
        return APART
    d = (y[0] - s * e[0], y[1] - s * e[1], y[2] - s * e[2])
    distance = math.sqrt(dot(d, d))
    if not beside_faces(y, shape_a, slack * distance):
        return APART
    n = sideways(shape_a)
    if distance > 0.0:
        n = (d[0] / distance, d[1] / distance, d[2] / distance)
    return gap_below(centre, radius, distance, to_space(position_a, n), shape_a[0])


def in_cone(y, shape, slack):
    """Whether a vector from a corner points away from all corners next to it."""
    farthest = 0.0
    for k in range(4, len(shape), 3):
        farthest = max(farthest, y[0] * shape[k] + y[1] * shape[k + 1] + y[2] * shape[k + 2])
    return farthest <= slack


def ball_corner(centre, radius, position_a, shape_a, slack):
    """A ball and a corner. ``shape_a``: radius, the corner, and unit vectors to the corners next to it, or zeros."""
    x = to_body(position_a, less(centre, position_a))
    y = less(x, (shape_a[1], shape_a[2], shape_a[3]))
    distance = math.sqrt(dot(y, y))
    if not in_cone(y, shape_a, slack * distance + ROUNDED * (abs(x[0]) + abs(x[1]) + abs(x[2]))):
        return APART
    n = (0.0, 0.0, 1.0)
    if distance > 0.0:
        n = to_space(position_a, (y[0] / distance, y[1] / distance, y[2] / distance))
    return gap_below(centre, radius, distance, n, shape_a[0])


def corner_at(position, shape):
    """The place of a corner."""
    p = to_space(position, (shape[1], shape[2], shape[3]))
    return position[0] + p[0], position[1] + p[1], position[2] + p[2]


def faces_corner(n, position, shape):
    """Whether a normal from another surface to a corner is in its cone."""
    return in_cone(to_body(position, (-n[0], -n[1], -n[2])), shape, SLACK)


def sphere_face(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` and a face, see :func:`ball_face`."""
    return ball_face((position_c[0], position_c[1], position_c[2]), shape_c[0], position_a, shape_a)


def sphere_edge(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` and an edge, see :func:`ball_edge`."""
    return ball_edge((position_c[0], position_c[1], position_c[2]), shape_c[0], position_a, shape_a, 0.0)


def sphere_corner(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` and a corner, see :func:`ball_corner`."""
    return ball_corner((position_c[0], position_c[1], position_c[2]), shape_c[0], position_a, shape_a, 0.0)


def corner_face(position_c, shape_c, position_a, shape_a):
    """A corner and a face: the ball around the corner meets it."""
    return ball_face(corner_at(position_c, shape_c), shape_c[0], position_a, shape_a)


def corner_edge(position_c, shape_c, position_a, shape_a):
    """A corner and an edge, the normal in both cones."""
    answer = ball_edge(corner_at(position_c, shape_c), shape_c[0], position_a, shape_a, SLACK)
    return answer if faces_corner(answer[1], position_c, shape_c) else APART


def corner_corner(position_c, shape_c, position_a, shape_a):
    """Two corners, the normal in both cones."""
    answer = ball_corner(corner_at(position_c, shape_c), shape_c[0], position_a, shape_a, SLACK)
    return answer if faces_corner(answer[1], position_c, shape_c) else APART


def corner_plane(position_c, shape_c, position_a, shape_a):
    """A corner and the half-space of a wall."""
    return sphere_plane(corner_at(position_c, shape_c), shape_c, position_a, shape_a)


def corner_cylinder(position_c, shape_c, position_a, shape_a):
    """A corner in a hollow cylinder."""
    return sphere_cylinder(corner_at(position_c, shape_c), shape_c, position_a, shape_a)


def axes_cross(c, h, a, k):
    """The nearest points ``c + s h`` and ``a + t k`` of two axes: s, t, and the way from the second to the first. If the
    axes are parallel s is infinite."""
    x = less(c, a)
    hh = dot(h, h)
    kk = dot(k, k)
    hk = dot(h, k)
    xh = dot(x, h)
    xk = dot(x, k)
    area = hh * kk - hk * hk
    if not area > 0.0:
        return math.inf, 0.0, x
    s = (hk * xk - kk * xh) / area
    t = (hh * xk - hk * xh) / area
    return s, t, (x[0] + s * h[0] - t * k[0], x[1] + s * h[1] - t * k[1], x[2] + s * h[2] - t * k[2])


def between(a, k, t, d, others, fallback, radius_c, radius_a):
    """(gap, normal, point) of two balls on axes, the second at ``a + t k``, the first at ``d`` from it. ``fallback``: the
    normal if the axes cut each other, turned to the side to which ``others`` points."""
    distance = math.sqrt(dot(d, d))
    gap = distance - radius_c - radius_a
    if distance > 0.0:
        n = (d[0] / distance, d[1] / distance, d[2] / distance)
    else:
        length = math.sqrt(dot(fallback, fallback))
        turn = -length if dot(fallback, others) < 0.0 else length
        n = (fallback[0] / turn, fallback[1] / turn, fallback[2] / turn)
    reach = radius_a + 0.5 * gap
    return gap, n, (a[0] + t * k[0] + reach * n[0], a[1] + t * k[1] + reach * n[1], a[2] + t * k[2] + reach * n[2])


def edge_axis(position, shape):
    """An edge as its first corner and the way to the second, along the axes of space."""
    p = to_space(position, (shape[1], shape[2], shape[3]))
    way = to_space(position, less((shape[4], shape[5], shape[6]), (shape[1], shape[2], shape[3])))
    return (position[0] + p[0], position[1] + p[1], position[2] + p[2]), way


def rod_edge(position_c, shape_c, position_a, shape_a):
    """A rod, see :func:`~lmgcpy.contact.contactor_pairs.sphere_rod`, and an edge that cross between their ends."""
    h = to_space(position_c, (shape_c[1], shape_c[2], shape_c[3]))
    a, k = edge_axis(position_a, shape_a)
    s, t, d = axes_cross((position_c[0], position_c[1], position_c[2]), h, a, k)
    if not (-1.0 < s < 1.0 and 0.0 < t < 1.0):
        return APART
    if not beside_faces(to_body(position_a, d), shape_a, SLACK * math.sqrt(dot(d, d))):
        return APART
    return between(a, k, t, d, to_space(position_a, sideways(shape_a)), cross(h, k), shape_c[0], shape_a[0])


def edge_edge(position_c, shape_c, position_a, shape_a):
    """Two edges that cross between their corners, the normal in both cones."""
    c, h = edge_axis(position_c, shape_c)
    a, k = edge_axis(position_a, shape_a)
    s, t, d = axes_cross(c, h, a, k)
    if not (0.0 < s < 1.0 and 0.0 < t < 1.0):
        return APART
    slack = SLACK * math.sqrt(dot(d, d))
    if not beside_faces(to_body(position_a, d), shape_a, slack):
        return APART
    if not beside_faces(to_body(position_c, (-d[0], -d[1], -d[2])), shape_c, slack):
        return APART
    return between(a, k, t, d, to_space(position_a, sideways(shape_a)), cross(h, k), shape_c[0], shape_a[0])


def rod_corner(position_c, shape_c, position_a, shape_a):
    """A rod and a corner that is met between its ends."""
    h = to_space(position_c, (shape_c[1], shape_c[2], shape_c[3]))
    a = corner_at(position_a, shape_a)
    x = less(a, (position_c[0], position_c[1], position_c[2]))
    s = dot(x, h) / dot(h, h)
    if not -1.0 < s < 1.0:
        return APART
    foot = (position_c[0] + s * h[0], position_c[1] + s * h[1], position_c[2] + s * h[2])
    return ball_corner(foot, shape_c[0], position_a, shape_a, SLACK)


# ------------------------------------------------------------------------------------------------------- in the plane

APART_2D = math.inf, (0.0, 1.0), (0.0, 0.0)


def beyond_end(x, shape, at):
    """Distance of the foot of a point beyond an end of a line, whose numbers begin ``at``: q, m, cot(theta/2), bound."""
    return shape[at + 2] * (x[0] - shape[at]) + shape[at + 3] * (x[1] - shape[at + 1])


def ball_line(centre, radius, position_a, shape_a):
    """A disk and a line. ``shape_a``: radius, 0 for both sides or 1 for one, greatest depth, outward normal, and for each
    end the point, the outward direction, cot(theta/2), and the bound of the test."""
    x = to_body(position_a, (centre[0] - position_a[0], centre[1] - position_a[1]))
    n = (shape_a[3], shape_a[4])
    z = n[0] * (x[0] - shape_a[5]) + n[1] * (x[1] - shape_a[6])
    depth = max(0.0, -z) if shape_a[1] > 0.0 else 0.0
    one = beyond_end(x, shape_a, 5)
    other = beyond_end(x, shape_a, 11)
    if not (one + shape_a[9] * depth < shape_a[10] and other + shape_a[15] * depth < shape_a[16]):
        return APART_2D
    if too_deep(depth, max(one, other), radius, shape_a):
        return APART_2D
    if shape_a[1] == 0.0 and z < 0.0:
        z = -z
        n = (-n[0], -n[1])
    n = to_space(position_a, n)
    gap = z - radius - shape_a[0]
    reach = radius + 0.5 * gap
    return gap, n, (centre[0] - reach * n[0], centre[1] - reach * n[1])


def ball_tip(centre, radius, position_a, shape_a, slack):
    """A disk and a tip. ``shape_a``: radius, the point, and unit vectors to the points next to it, or zeros."""
    x = to_body(position_a, (centre[0] - position_a[0], centre[1] - position_a[1]))
    y = (x[0] - shape_a[1], x[1] - shape_a[2])
    distance = math.sqrt(y[0] * y[0] + y[1] * y[1])
    if not in_plane_cone(y, shape_a, slack * distance + ROUNDED * (abs(x[0]) + abs(x[1]))):
        return APART_2D
    n = (0.0, 1.0)
    if distance > 0.0:
        n = to_space(position_a, (y[0] / distance, y[1] / distance))
    gap = distance - radius - shape_a[0]
    reach = radius + 0.5 * gap
    return gap, n, (centre[0] - reach * n[0], centre[1] - reach * n[1])


def in_plane_cone(y, shape, slack):
    """Whether a vector from a tip points away from the points next to it."""
    farthest = 0.0
    for k in range(3, len(shape), 2):
        farthest = max(farthest, y[0] * shape[k] + y[1] * shape[k + 1])
    return farthest <= slack


def tip_at(position, shape):
    """The place of a tip."""
    p = to_space(position, (shape[1], shape[2]))
    return position[0] + p[0], position[1] + p[1]


def disk_line(position_c, shape_c, position_a, shape_a):
    """A disk of radius ``shape_c[0]`` and a line, see :func:`ball_line`."""
    return ball_line((position_c[0], position_c[1]), shape_c[0], position_a, shape_a)


def disk_tip(position_c, shape_c, position_a, shape_a):
    """A disk of radius ``shape_c[0]`` and a tip, see :func:`ball_tip`."""
    return ball_tip((position_c[0], position_c[1]), shape_c[0], position_a, shape_a, 0.0)


def tip_line(position_c, shape_c, position_a, shape_a):
    """A tip and a line: the disk around the tip meets it."""
    return ball_line(tip_at(position_c, shape_c), shape_c[0], position_a, shape_a)


def tip_tip(position_c, shape_c, position_a, shape_a):
    """Two tips, the normal in both cones."""
    answer = ball_tip(tip_at(position_c, shape_c), shape_c[0], position_a, shape_a, SLACK)
    n = answer[1]
    return answer if in_plane_cone(to_body(position_c, (-n[0], -n[1])), shape_c, SLACK) else APART_2D


def tip_wall(position_c, shape_c, position_a, shape_a):
    """A tip and the half-space of a wall."""
    return disk_wall(tip_at(position_c, shape_c), shape_c, position_a, shape_a)


# -------------------------------------------------------------------------------------------------- axes of the bodies


def _unturned(position, v):
    return v


def _out_of_body(position, v):
    return rotated((position[3], position[4], position[5], position[6]), v)


def _into_body(position, v):
    return turned_back((position[3], position[4], position[5], position[6]), v)


def _out_of_body_in_plane(position, v):
    cosine = math.cos(position[2])
    sine = math.sin(position[2])
    return cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]


def _into_body_in_plane(position, v):
    cosine = math.cos(position[2])
    sine = math.sin(position[2])
    return cosine * v[0] + sine * v[1], cosine * v[1] - sine * v[0]


IN_SPACE = {
    ("sphere", "face"): sphere_face,
    ("sphere", "edge"): sphere_edge,
    ("sphere", "corner"): sphere_corner,
    ("rod", "edge"): rod_edge,
    ("rod", "corner"): rod_corner,
    ("corner", "face"): corner_face,
    ("corner", "edge"): corner_edge,
    ("corner", "corner"): corner_corner,
    ("edge", "edge"): edge_edge,
    ("corner", "plane"): corner_plane,
    ("corner", "cylinder"): corner_cylinder,
}
IN_PLANE = {
    ("disk", "line"): disk_line,
    ("disk", "tip"): disk_tip,
    ("tip", "line"): tip_line,
    ("tip", "tip"): tip_tip,
    ("tip", "wall"): tip_wall,
}
for _kinds, _narrow in (IN_SPACE | IN_PLANE).items():
    register_pair(*_kinds, _narrow)


@cache
def oriented(narrow: Callable, width: int) -> Callable:
    """A narrow phase for positions of a length; one of a surface gets the way to the axes of a body and back."""
    if narrow in IN_PLANE.values():
        return Kernel(narrow, {"to_space": _out_of_body_in_plane, "to_body": _into_body_in_plane})
    if narrow.__module__ not in OF_SURFACES:
        return narrow
    out_of_body, into_body = (_unturned, _unturned) if width == 3 else (_out_of_body, _into_body)
    return Kernel(narrow, {"to_space": out_of_body, "to_body": into_body})


# --------------------------------------------------------------------------------------------------- shapes from points


@dataclass(frozen=True)
class Topology:
    """The corners of the facets of a surface, triangles in space or segments in the plane; or of the segments of a net in
    space, without facets. V corners."""

    facets: np.ndarray
    """Corners of the facets, (F, d)."""
    ridges: np.ndarray
    """Corners of the ridges between facets, (R, d - 1), ascending: edges in space, corners in the plane."""
    sides: np.ndarray
    """Ridge opposite to each corner of each facet, (F, d)."""
    facets_of: np.ndarray
    """The two facets of each ridge, -1 for none, (R, 2)."""
    places: np.ndarray
    """The place of each ridge among the sides of its two facets, (R, 2)."""
    edges: np.ndarray
    """Corners of the segments and of the edges of triangles, (E, 2)."""
    spokes: np.ndarray
    """Edges at each corner, (V, K), -1 for none; K a power of two."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.ridges.shape[1] + 1

    @cached_property
    def first_of_side(self) -> np.ndarray:
        """Which corner of a facet is the first one of each of its sides, (F, d)."""
        first = self.ridges[self.sides][..., 0]
        return (self.facets[:, None] == first[..., None]).argmax(axis=2)


@dataclass(frozen=True)
class Corners:
    """The corners of a surface at their places, in a periodic cell those of a facet or edge as the images that are nearest
    to its second one."""

    points: np.ndarray
    """[m], (V, d)."""
    net: Topology
    crossed: Callable[[np.ndarray], np.ndarray] | None = None
    """See :func:`places_of`."""

    @cached_property
    def of_facets(self) -> np.ndarray:
        """(F, d, d)."""
        return places_of(self.points, self.net.facets, self.crossed)

    @cached_property
    def of_edges(self) -> np.ndarray:
        """(E, 2, d)."""
        return places_of(self.points, self.net.edges, self.crossed)

    @cached_property
    def directions(self) -> np.ndarray:
        """Unit vectors of the edges from the first corner to the second, (E, d)."""
        return unit(self.of_edges[:, 1] - self.of_edges[:, 0])

    @cached_property
    def of_sides(self) -> np.ndarray:
        """The first corner of each side of the facets, (F, d, d)."""
        return np.take_along_axis(self.of_facets, self.net.first_of_side[..., None], axis=1)


def places_of(
    points: np.ndarray, rows: np.ndarray, crossed: Callable[[np.ndarray], np.ndarray] | None = None
) -> np.ndarray:
    """The places of some corners (m, c) among points (V, d) [m], (m, c, d).

    ``crossed`` gives the ways across a periodic cell that are in differences (m, d), None without a cell: there the corners
    are the images that are nearest to the second one.
    """
    places = points[rows]
    if crossed is None or not len(rows):
        return places
    away = places - places[:, 1:2]
    return places - crossed(away.reshape(-1, points.shape[1])).reshape(places.shape)


def topology(cells: np.ndarray, count: int, *, dimension: int = 3) -> Topology:
    """The topology of triangles (m, 3), or of segments (m, 2), between ``count`` corners.

    ValueError if more than two triangles share an edge, or more than two segments of the plane a point.
    """
    cells = np.asarray(cells, dtype=np.int64)
    if cells.shape[1] < dimension:  # a net in space
        facets, ridges = np.zeros((0, 3), np.int64), np.sort(cells, axis=1)
        sides, facets_of = np.zeros((0, 3), np.int64), np.full((len(cells), 2), -1)
        return Topology(facets, ridges, sides, facets_of, np.zeros_like(facets_of), ridges, _spokes(ridges, count))
    d, m = dimension, len(cells)
    # opposite to corner k of a facet: its other corners
    opposite = np.sort(np.stack([np.delete(cells, k, axis=1) for k in range(d)], axis=1), axis=2).reshape(m * d, d - 1)
    ridges, which, uses = unique_rows(opposite, count)
    if len(uses) and uses.max() > 2:
        r, kind, place = int(uses.argmax()), *(("triangles", "the edge") if d == 3 else ("segments", "the point"))
        rows = ", ".join(map(str, (np.flatnonzero(which == r) // d).tolist()))
        raise ValueError(
            f"{uses[r]} {kind} of a surface, {rows}, meet at {place} of its corners {ridges[r].tolist()}, and two are the "
            "most: make surfaces of its parts."
        )
    order = np.argsort(which, kind="stable")
    facets_of, places = np.full((len(ridges), 2), -1), np.zeros((len(ridges), 2), np.int64)
    first = np.cumsum(uses) - uses
    turn = np.arange(m * d) - first[which[order]]
    facets_of[which[order], turn], places[which[order], turn] = order // d, order % d
    edges = ridges if d == 3 else cells
    return Topology(cells, ridges, which.reshape(m, d), facets_of, places, edges, _spokes(edges, count))


def unique_rows(rows: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The different rows of one or two numbers below ``count``, (u, w), sorted; which of them each row is (m,); and how
    often each occurs (u,)."""
    key = rows[:, 0] if rows.shape[1] == 1 else rows[:, 0] * count + rows[:, 1]  # numpy takes ten times as long over rows
    keys, which, uses = np.unique(key, return_inverse=True, return_counts=True)
    found = keys[:, None] if rows.shape[1] == 1 else np.column_stack(np.divmod(keys, count))
    return found, which.ravel(), uses


def _spokes(edges: np.ndarray, count: int) -> np.ndarray:
    ends, which = edges.T.ravel(), np.tile(np.arange(len(edges)), 2)
    order = np.argsort(ends, kind="stable")
    number = np.bincount(ends, minlength=count)
    most = 1 << max(0, int(number.max(initial=1)) - 1).bit_length()
    spokes = np.full((count, most), -1)
    spokes[ends[order], np.arange(len(ends)) - (np.cumsum(number) - number)[ends[order]]] = which[order]
    return spokes


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., d) divided by their lengths; zeros stay zeros."""
    length = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    return vectors / np.where(length > 0.0, length, 1.0)


def facet_normals(at: Corners) -> np.ndarray:
    """Unit normals of the facets, (F, d): of triangles by the right-hand rule, of segments to the left."""
    corners = at.of_facets
    if at.net.dimension == 2:
        way = corners[:, 1] - corners[:, 0]
        return unit(np.column_stack([-way[:, 1], way[:, 0]]))
    return unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def outward_vectors(at: Corners) -> np.ndarray:
    """Unit vectors in the facets, normal to their sides and outward, (F, d, d)."""
    along = at.directions
    if at.net.dimension == 2:  # the other end lies behind
        return np.stack([along, -along], axis=1)
    e = along[at.net.sides]
    inward = at.of_facets - at.of_sides
    return unit((inward * e).sum(axis=-1, keepdims=True) * e - inward)


@dataclass(frozen=True)
class Ridges:
    """The ridges of a surface, and how its facets meet there."""

    outward: np.ndarray
    """Outward vectors of the two facets of each ridge, zero for none, (R, 2, d)."""
    flat: np.ndarray
    """Whether both facets lie in one plane, (R,) bool."""
    convex: np.ndarray
    """Whether the side to which the normals point is the convex one, (R,) bool; True for a ridge of one facet."""
    cotangent: np.ndarray
    """cot(theta/2), theta the angle of the solid behind the facets, (R,); 0 if there is one facet."""


def ridges_of(at: Corners) -> Ridges:
    """How the facets of a surface meet."""
    net, m, n = at.net, outward_vectors(at), facet_normals(at)
    there = net.facets_of >= 0
    outward = np.zeros((*there.shape, net.dimension))
    if len(m):
        outward = np.where(there[:, :, None], m[net.facets_of, net.places], 0.0)
    one, other = outward[:, 0], outward[:, 1]
    together, apart = np.linalg.norm(one + other, axis=1), np.linalg.norm(one - other, axis=1)
    flat = there.all(axis=1) & (together <= FLAT)
    above = (other * n[net.facets_of[:, 0]]).sum(axis=1) if len(n) else np.zeros(len(there))
    convex = ~there.all(axis=1) | (above > 0.0)
    cotangent = np.where(convex, 1.0, -1.0) * together / np.maximum(apart, 1e-12)
    return Ridges(outward, flat, convex, np.where(flat | ~there.all(axis=1), 0.0, cotangent))


def facet_shapes(
    at: Corners, radius: float, *, one_sided: bool = False, depth: Any = DEEP, ridges: Any = None
) -> np.ndarray:
    """Shapes of the faces (F, 30), or of the lines (F, 17), of a surface.

    ``depth``: how far behind a facet centres are met if it has one side, (F,) or one number [m]. ``ridges``: of
    :func:`ridges_of`, if known.
    """
    found: Ridges = ridges_of(at) if ridges is None else ridges
    net, m = at.net, outward_vectors(at)
    d, count = net.dimension, len(net.facets)
    cotangent = found.cotangent[net.sides] if one_sided else np.zeros((count, d))
    bound = np.zeros((count, d))
    # facets in one plane share the vector of their ridge, and its test: v < s of the one, -v < -s of the other
    flat = np.flatnonzero(found.flat)
    shared = unit(found.outward[flat, 0] - found.outward[flat, 1])
    s = ASIDE * float(np.abs(at.points).max(initial=0.0)) * (shared @ GENERIC[:d])
    for side, sign, limit in ((0, 1.0, np.nextafter(s, np.inf)), (1, -1.0, -s)):
        of = net.facets_of[flat, side], net.places[flat, side]
        m[of], bound[of] = sign * shared, limit
    parts = np.concatenate([at.of_sides, m, cotangent[..., None], bound[..., None]], axis=2).reshape(count, -1)
    first = [np.broadcast_to(value, count) for value in (radius, float(one_sided), np.minimum(depth, DEEP))]
    return np.column_stack([*first, facet_normals(at), parts])


def edge_shapes(at: Corners, radius: float, *, ridges: Any = None) -> np.ndarray:
    """Shapes of the edges of a surface, or of a net, in space, (E, 16); arguments as of :func:`facet_shapes`."""
    found: Ridges = ridges_of(at) if ridges is None else ridges
    ends = at.of_edges.reshape(-1, 6)
    size = np.broadcast_to(radius, len(ends))
    return np.column_stack([size, ends, at.directions, found.outward.reshape(-1, 6)])


def spoke_vectors(at: Corners) -> np.ndarray:
    """Unit vectors from each corner to the corners next to it, zeros for none, (V, K, d)."""
    net = at.net
    along = np.concatenate([at.directions, np.zeros((1, net.dimension))])
    begins = np.concatenate([net.edges[:, 0], [-1]])[net.spokes] == np.arange(len(net.spokes))[:, None]
    return np.where(begins[..., None], along[net.spokes], -along[net.spokes])


def beside_nodes(at: Corners) -> np.ndarray:
    """The corners, (V, d), with those that end a line, or that a line goes straight through, moved along it by
    :data:`ASIDE`. A centre exactly over such a node, as symmetric scenes have it, then meets one feature: over a node in a
    line the node and the lines beside it would share the place up to rounding."""
    spokes = spoke_vectors(at)
    there = at.net.spokes >= 0
    through = there & (there.sum(axis=1) == 1)[:, None]
    for i, j in combinations(range(spokes.shape[1]), 2):
        through[:, i] |= np.einsum("vd,vd->v", spokes[:, i], spokes[:, j]) <= 0.5 * FLAT**2 - 1.0
    along = spokes[np.arange(len(spokes)), through.argmax(axis=1)]
    size = float(np.abs(at.points).max(initial=0.0))
    way = ASIDE * size * (along @ GENERIC[: at.net.dimension])
    return at.points + np.where(through.any(axis=1), way, 0.0)[:, None] * along


def corner_shapes(at: Corners, radius: float) -> np.ndarray:
    """Shapes of the corners (V, 4 + 3 K), or of the tips (V, 3 + 2 K)."""
    count = len(at.points)
    return np.column_stack([np.broadcast_to(radius, count), at.points, spoke_vectors(at).reshape(count, -1) + 0.0])


def kept_edges(ridges: Ridges, *, one_sided: bool = False) -> np.ndarray:
    """Whether the cone of each edge is more than a half-plane, and outside if the surface has one side, (E,) bool."""
    return ~ridges.flat & (ridges.convex if one_sided else True)


def kept_corners(at: Corners, *, one_sided: bool = False) -> np.ndarray:
    """Whether the cone of each corner is more than a line, and outside if the surface has one side, (V,) bool.

    The cone is spanned by products ``e_i x e_j``, and by ``(e_i x e_j) x e_i`` if the directions e lie in a plane.
    """
    if at.net.dimension == 2:
        return _kept_tips(at, one_sided)
    spokes, kept = spoke_vectors(at), np.zeros(len(at.points), dtype=bool)
    degree = (at.net.spokes >= 0).sum(axis=1)
    outside = _corner_normals(at) if one_sided else None
    for k in np.unique(degree[degree > 0]).tolist():
        alike = np.flatnonzero(degree == k)
        for rows in np.array_split(alike, max(1, len(alike) * k**3 // 2_000_000)):
            e = spokes[rows, :k]
            i, j = np.triu_indices(k, 1)
            normal = unit(_without_noise(np.cross(e[:, i], e[:, j])))
            rays = np.concatenate([normal, np.cross(normal, e[:, i]), np.cross(normal, e[:, j])], axis=1)
            rays = np.concatenate([rays, -rays], axis=1)
            inside = (rays @ e.transpose(0, 2, 1) <= FLAT).all(axis=2) & (np.abs(rays).max(axis=2) > 0.0)
            rays = np.where(inside[..., None], rays, 0.0)
            spread = np.linalg.eigvalsh(rays.transpose(0, 2, 1) @ rays)[:, 1] > FLAT**2
            kept[rows] = spread | ~(np.abs(normal).max(axis=2) > 0.0).any(axis=1)  # the directions lie in one line
            if outside is not None:
                kept[rows] &= (rays.sum(axis=1) * outside[rows]).sum(axis=1) > 0.0
    return kept


def _kept_tips(at: Corners, one_sided: bool) -> np.ndarray:
    kept = np.zeros(len(at.points), dtype=bool)
    kept[at.net.ridges[:, 0]] = kept_edges(ridges_of(at), one_sided=one_sided)
    return kept


def _without_noise(vectors: np.ndarray) -> np.ndarray:
    """Vectors, zero if they are nearly so."""
    return np.where(np.linalg.norm(vectors, axis=-1, keepdims=True) > FLAT, vectors, 0.0)


def _corner_normals(at: Corners) -> np.ndarray:
    """Normals of the facets around each corner weighted by their angles there, (V, 3). They tell which side a centre
    nearest to a corner is on (Baerentzen and Aanaes 2005, IEEE Trans. Vis. Comput. Graph. 11, 243)."""
    normals, result = facet_normals(at), np.zeros_like(at.points)
    for k in range(3):
        a, b, c = (at.of_facets[:, (k + step) % 3] for step in range(3))
        angle = np.arccos(np.clip((unit(b - a) * unit(c - a)).sum(axis=1), -1.0, 1.0))
        np.add.at(result, at.net.facets[:, k], angle[:, None] * normals)
    return result


def bounds(places: np.ndarray, radius: Any) -> tuple[np.ndarray, np.ndarray]:
    """Centres (m, d) and radii (m,) of spheres around features with these corners (m, c, d) [m], around the
    middles of their boxes."""
    middle = 0.5 * (places.max(axis=1) + places.min(axis=1))
    return middle, np.linalg.norm(places - middle[:, None], axis=2).max(axis=1) + radius
