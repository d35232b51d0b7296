"""Search for the facets that rays and edges meet; with it, the test whether a surface crosses itself and so has no
inside."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from lmgcpy.contact.features import Corners, facet_normals, outward_vectors, ridges_of

TOGETHER = 20_000
"""How many rays or boxes go down a tree together."""
NEAR = 1e-9
"""A ray from a facet meets other facets that are farther than this part of the size of the surface."""
TOUCHES = 1e-6
"""Facets touch if they are nearer to each other than this part of the size of the surface, or cross by less: coordinates of
a file have seven digits."""
PLACES = ((0.5377, 0.3012, 0.1611), (0.1193, 0.5839, 0.2968), (0.2751, 0.1347, 0.5902))
"""Weights of the corners at places in a facet from which a ray goes through no edge but by chance."""


class BoxTree:
    """A binary tree. Each node halves its items, by their middles along the axis on which they spread most, down to one.

    ``low`` and ``high``: corners of the boxes of the items [m], (m, d).
    """

    def __init__(self, low: np.ndarray, high: np.ndarray):
        depth = max(0, len(low) - 1).bit_length()
        # the last item again and again, up to a power of two
        self.order = np.minimum(np.arange(1 << depth), len(low) - 1)
        middle = 0.5 * (low + high)
        for level in range(depth):
            parts = self.order.reshape(1 << level, -1)
            axis = np.ptp(middle[parts], axis=1).argmax(axis=1)
            along = np.take_along_axis(middle[parts], axis[:, None, None], axis=2)[..., 0]
            self.order = np.take_along_axis(parts, np.argsort(along, axis=1, kind="stable"), axis=1).ravel()
        self.levels = [(low[self.order], high[self.order])]
        for _ in range(depth):
            low, high = self.levels[0]
            self.levels.insert(0, (np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])))

    def pairs(
        self, count: int, meet: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Rows (p,) of ``count`` rays or boxes and the items (p,) that they may meet, part by part; a pair may come twice.

        ``meet(rows, low, high)``: whether rows meet boxes, (p,) bool.
        """
        for first in range(0, count, TOGETHER):
            rows = np.arange(first, min(count, first + TOGETHER))
            node = np.zeros(len(rows), dtype=np.int64)
            for level, (low, high) in enumerate(self.levels):
                if level:
                    rows, node = np.repeat(rows, 2), (2 * node[:, None] + (0, 1)).ravel()
                kept = meet(rows, low[node], high[node])
                rows, node = rows[kept], node[kept]
            yield rows, self.order[node]


def hits_behind(at: Corners, start: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Other facets that rays meet which go from a place in each facet, ``start`` (F, d), straight back: facets of the rays,
    facets that they meet, and the ways [m], (p,) each, part by part; a hit may come twice."""
    corners, normal = at.of_facets, facet_normals(at)
    base, sides = corners[:, 0], corners[:, 1:] - corners[:, :1]
    near = NEAR * float(np.ptp(at.points, axis=0).max())
    with np.errstate(divide="ignore"):
        inverse = -1.0 / normal

    def meet(ray: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Whether a ray is in all slabs of a box for some t > 0; in a slab along the ray t is infinite, or not a number."""
        with np.errstate(invalid="ignore"):
            one, other = (low - near - start[ray]) * inverse[ray], (high + near - start[ray]) * inverse[ray]
        first, last = np.fmin(one, other), np.fmax(one, other)
        return np.fmin.reduce(last, axis=1) >= np.maximum(np.fmax.reduce(first, axis=1), 0.0)

    for ray, facet in BoxTree(corners.min(axis=1), corners.max(axis=1)).pairs(len(corners), meet):
        # t n + sum of parts of the sides = start - base: Cramer's rule, t back from the facet
        n, away = normal[ray], start[ray] - base[facet]
        if at.net.dimension == 2:
            side = sides[facet, 0]
            across = n[:, 0] * side[:, 1] - n[:, 1] * side[:, 0]
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (away[:, 0] * side[:, 1] - away[:, 1] * side[:, 0]) / across
                part = (n[:, 0] * away[:, 1] - n[:, 1] * away[:, 0]) / across
                hit = (part >= -1e-9) & (part <= 1.0 + 1e-9)
        else:
            u, v = sides[facet, 0], sides[facet, 1]
            area, turned = np.cross(u, v), np.cross(n, away)
            across = (n * area).sum(axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):
                t = (away * area).sum(axis=1) / across
                one, other = (turned * v).sum(axis=1) / across, (turned * u).sum(axis=1) / -across
                hit = (one >= -1e-9) & (other >= -1e-9) & (one + other <= 1.0 + 1e-9)
        hit &= (t > near) & (facet != ray)
        yield ray[hit], facet[hit], t[hit]


def solids_behind(at: Corners) -> np.ndarray:
    """How many solids lie on top of each other behind each facet of a closed surface, (F,): 1 if it has an inside.

    A ray that goes back from the facet leaves a solid at each facet that it meets from behind, and enters one at each that
    it meets from before; at its end it is outside of all. If a ray does not find 1, two others from elsewhere are asked,
    as a ray may go through an edge: the number nearest to 1 counts.
    """
    normal, corners, near = facet_normals(at), at.of_facets, TOUCHES * float(np.ptp(at.points, axis=0).max())
    found = np.zeros(len(corners), dtype=np.int64)
    for weights in PLACES:
        number = np.zeros(len(corners), dtype=np.int64)
        w = np.array(weights[: corners.shape[1]])
        for ray, facet, way in hits_behind(at, np.einsum("k,fkd->fd", w / w.sum(), corners)):
            once = np.unique((ray * len(corners) + facet)[way > near])
            ray, facet = np.divmod(once, len(corners))
            np.add.at(number, ray, np.where((normal[ray] * normal[facet]).sum(axis=1) < 0.0, 1, -1))
        found = number if weights is PLACES[0] else np.where(np.abs(number - 1) < np.abs(found - 1), number, found)
        if (found == 1).all():
            break
    return found


def is_thin(at: Corners, k: int) -> bool:
    """Whether the back of another facet is close behind facet ``k``, or on it, as on a spike."""
    normal, near = facet_normals(at), TOUCHES * float(np.ptp(at.points, axis=0).max())
    for ray, facet, way in hits_behind(at, at.of_facets.mean(axis=1) + near * normal):
        if ((ray == k) & (way <= 2.0 * near) & (normal[facet] @ normal[k] < 0.0)).any():
            return True
    return False


def first_crossing(at: Corners) -> tuple[int, int, np.ndarray] | None:
    """A facet of a surface, another one with an edge that goes through it, in the plane a segment, and the place (d,) [m],
    or None.

    Two triangles cross if and only if an edge of the one goes through the other: if the ends p and q of the edge lie on
    different sides of the plane of a triangle, and its point in the plane is within all sides. A point on a side counts as
    within if the facet beyond it lies in the same plane. Surfaces that only touch do not cross: an end of the edge is in
    the plane then, or its point is on a side.
    """
    net, edges, corners = at.net, at.of_edges, at.of_facets
    n, m, on_sides = facet_normals(at), outward_vectors(at), at.of_sides
    near = TOUCHES * float(np.ptp(at.points, axis=0).max())
    reach = np.where(ridges_of(at).flat[net.sides], near, -near)
    below, above = edges.min(axis=1) - near, edges.max(axis=1) + near

    def meet(edge: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        return ((below[edge] <= high) & (low <= above[edge])).all(axis=1)

    for edge, facet in BoxTree(corners.min(axis=1), corners.max(axis=1)).pairs(len(edges), meet):
        p, q = edges[edge, 0], edges[edge, 1]
        over, under = (np.einsum("pd,pd->p", n[facet], end - corners[facet, 0]) for end in (p, q))
        through = (over * under < 0.0) & (np.abs(over) > near) & (np.abs(under) > near)
        edge, facet, over, under = edge[through], facet[through], over[through], under[through]
        x = edges[edge, 0] + (over / (over - under))[:, None] * (edges[edge, 1] - edges[edge, 0])
        beyond = np.einsum("pkd,pkd->pk", m[facet], x[:, None] - on_sides[facet])
        crossed = np.flatnonzero((beyond < reach[facet]).all(axis=1))
        if len(crossed):
            k = int(crossed[0])
            of_edge = np.isin(net.facets, net.edges[edge[k]]).sum(axis=1) == 2
            return int(facet[k]), int(np.argmax(of_edge)), x[k]
    return None
