"""Surfaces between points: segments and triangles with a radius, whose corners are the centres of bodies.

Such a surface has the features of :mod:`lmgcpy.contact.features`, each a contactor: an element. An element lies on
several bodies. With the weights w_k of the foot x of a contact on the axis, ``x = sum w_k x_k``, and rho the distance of
the contact point from x, the point of the surface is ``p = x + rho m``, m the unit vector from x to p. The bodies at the
corners have the velocities v_k. As the element moves, m stays at right angles to it:

    dp/dt = sum w_k v_k + rho dm/dt,      dm/dt = -sum (m . v_k) grad w_k,

for a segment from node 1 to node 2, of length L along e, ``grad w_2 = e / L = -grad w_1``. A segment in space has no spin
about itself: bodies at its corners are points, and it is held against torsion. A node between two segments turns as the
mean of the segments beside it, ``dm/dt = omega x m`` with ``omega = e x (v_2 - v_1) / L`` of each of them, which is the
same formula with a further term,

    dm/dt = sum [(G_k . m) v_k - (m . v_k) G_k],      G_k = grad w_k, or half of it for each of two segments.

For a segment and for a triangle ``G_k . m = 0``. A node of more than two segments does not turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference
from lmgcpy.contact.broad_phase import ExcludedPairs
from lmgcpy.contact.contactor_pairs import OF_NODES, known_pairs, register_pair
from lmgcpy.contact.features import (
    IN_PLANE,
    IN_SPACE,
    Corners,
    Topology,
    beside_nodes,
    corner_shapes,
    edge_shapes,
    facet_shapes,
    places_of,
    ridges_of,
)
from lmgcpy.contact.folds import FOLDS

Crossed = Callable[[np.ndarray], np.ndarray] | None
"""Ways across a periodic cell, see :func:`~lmgcpy.contact.features.places_of`: elements lie between nearest images."""
CORNERS = {"face": 3, "edge": 2, "corner": 3, "line": 2, "tip": 3}
"""On how many bodies an element lies: a corner on the node and on those beside it."""


def corners_of(kind: str) -> int:
    """On how many bodies a contactor of a kind lies: on one unless it is an element."""
    return CORNERS[kind.removeprefix(OF_NODES)] if kind.startswith(OF_NODES) else 1


def elements_form(candidate: int, antagonist: int) -> str:
    """Name of the form of the rows of H of two sides that lie on so many bodies, of which at least one is an element."""
    return f"elements {candidate}:{antagonist}"


@dataclass(frozen=True)
class SkinTable:
    """A thread, a net, or a membrane: cells between nodes; V nodes."""

    nodes: np.ndarray
    """Rows of the bodies, (V,) int64."""
    net: Topology
    """Segments or triangles between these nodes."""
    radius: float
    """[m]."""
    color: str

    @cached_property
    def sorts(self) -> list[tuple[str, np.ndarray]]:
        """Names of the features that it has, each with the corners of all of them, (e, 3), as indices of ``nodes``: the
        last one is repeated if there are two; of a corner, the node before, the node, and the node after, or only the
        node, if there are other than two beside it."""
        net, count = self.net, len(self.nodes)
        two = net.edges[:, [0, 1, 1]]
        flat = net.dimension == 2
        found = [("line", two)] if flat else [("face", net.facets), ("edge", two)]
        here = np.arange(count)
        beside = np.where(net.spokes < 0, here[:, None], net.edges[net.spokes].sum(axis=2) - here[:, None])
        lone = (net.spokes >= 0).sum(axis=1) > 2
        first, last = beside[:, 0], beside[:, min(1, beside.shape[1] - 1)]
        if beside.shape[1] == 1:
            last = here
        around = np.where(lone[:, None], here[:, None], np.column_stack([first, here, last]))
        found.append(("tip" if flat else "corner", around))
        return [(name, corners) for name, corners in found if len(corners)]

    def shapes(self, points: np.ndarray, crossed: Crossed = None) -> list[np.ndarray]:
        """Shapes of its features in the order of :attr:`sorts`, for nodes at ``points`` (V, d)."""
        at = Corners(beside_nodes(Corners(points, self.net, crossed)), self.net, crossed)
        ridges = ridges_of(at)
        found = [facet_shapes(at, self.radius, ridges=ridges)] if len(self.net.facets) else []
        if self.net.dimension == 3:
            edges = edge_shapes(at, self.radius, ridges=ridges)
            edges[ridges.flat, 4:7] = edges[ridges.flat, 1:4]  # faces in one plane meet all: no place is between two ends
            found.append(edges)
        return [*found, corner_shapes(at, self.radius)]


@by_reference
class Elements(NamedTuple):
    """The elements at the positions of a detection, as narrow phases read them; e elements."""

    row: np.ndarray
    """Row here of each contactor that is an element, (k,) int64; in a periodic cell the images have rows of their own."""
    corner: np.ndarray
    """Rows of the bodies at the corners, (e, 3) int64."""
    place: np.ndarray
    """Their places [m], (e, 3 d)."""
    middle: np.ndarray
    """Middle of the axis [m], (e, d)."""
    weight: np.ndarray
    """Weights of the corners there, (e, 3)."""
    slope: np.ndarray
    """1 if the weights change along the element, 0 for corners, (e,)."""
    gradient: np.ndarray
    """G_k of the three corners [1/m], (e, 3 d)."""

    def with_images(self, contactor: np.ndarray, between: int, shift: np.ndarray) -> Elements:
        """The elements with the images of some contactors (g,), which are the last ones, after ``between`` others;
        ``shift``: where they are from the contactors [m], (g, d)."""
        own = np.flatnonzero(self.row[contactor] >= 0)
        which, shift = self.row[contactor[own]], shift[own]
        of_images = np.full(between + len(contactor), -1)
        of_images[between + own] = len(self.middle) + np.arange(len(own))
        return Elements(
            np.concatenate([self.row, of_images]),
            np.concatenate([self.corner, self.corner[which]]),
            np.concatenate([self.place, self.place[which] + np.tile(shift, 3)]),
            np.concatenate([self.middle, self.middle[which] + shift]),
            *(np.concatenate([of_all, of_all[which]]) for of_all in (self.weight, self.slope, self.gradient)),
        )


@dataclass(frozen=True)
class ElementTable:
    """The elements of a scene, in the order of their contactors, which stand one after another; e of them."""

    first: int
    """Row of the first one among the contactors."""
    contactors: int
    """Number of contactors."""
    surfaces: Sequence[SkinTable]
    kind: list[str]
    """Kinds of the contactors, (e,)."""
    color: list[str]
    corner: np.ndarray
    """Rows of the bodies at the corners, (e, 3), see :attr:`SkinTable.sorts`."""
    count: np.ndarray
    """Number of corners of a segment or triangle, 0 of a node, (e,)."""

    @classmethod
    def of(cls, first: int, others: int, surfaces: Sequence[SkinTable]) -> ElementTable:
        """The elements of some surfaces, beside so many other contactors."""
        kind, color, corner, count = [], [], [np.zeros((0, 3), np.int64)], []
        for surface in surfaces:
            for name, corners in surface.sorts:
                kind += [OF_NODES + name] * len(corners)
                color += [surface.color] * len(corners)
                corner.append(surface.nodes[corners])
                count += [0 if name in ("corner", "tip") else CORNERS[name]] * len(corners)
        table = first, others + len(count), surfaces, kind, color
        return cls(*table, np.concatenate(corner), np.array(count, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.count)

    @property
    def rows(self) -> slice:
        """Their rows among the contactors."""
        return slice(self.first, self.first + len(self))

    @cached_property
    def own(self) -> np.ndarray:
        """The bodies between which the axis of an element lies, of a corner its node alone, (e, 3)."""
        return np.where((self.count == 0)[:, None], self.corner[:, 1:2], self.corner)

    def strangers(self, pairs: np.ndarray, body: np.ndarray, excluded: ExcludedPairs) -> np.ndarray:
        """The pairs of contactors (p, 2) that have no body in common, and no two bodies that never meet; ``body``: body of
        each contactor, (k,)."""
        corners = np.repeat(body[:, None], 3, axis=1)
        corners[self.rows] = self.own
        c, a = corners[pairs[:, 0], :, None], corners[pairs[:, 1], None, :]
        return pairs[((c != a) & ~excluded.contain(c, a)).all(axis=(1, 2))]

    def shapes(self, points: np.ndarray, crossed: Crossed = None) -> list[np.ndarray]:
        """Shapes of the elements, piece by piece, for bodies at ``points`` (n, d)."""
        return [shape for surface in self.surfaces for shape in surface.shapes(points[surface.nodes], crossed)]

    def shape_size(self, points: np.ndarray) -> dict[str, int]:
        """How many numbers the shapes of each kind have, at the most."""
        found: dict[str, int] = {}
        kinds = [OF_NODES + name for surface in self.surfaces for name, _ in surface.sorts]
        for kind, shape in zip(kinds, self.shapes(points), strict=True):
            found[kind] = max(found.get(kind, 0), shape.shape[1])
        return found

    def enter(self, table: np.ndarray, points: np.ndarray, crossed: Crossed = None) -> np.ndarray:
        """Enter these shapes into the table of all contactors (k, w), and return it."""
        first = self.first
        for piece in self.shapes(points, crossed):
            table[first : first + len(piece), : piece.shape[1]] = piece
            first += len(piece)
        return table

    def bounds(self, points: np.ndarray, crossed: Crossed = None) -> tuple[np.ndarray, np.ndarray]:
        """Middles of the axes (e, d) and radii of spheres around them that contain the elements (e,) [m]."""
        places = places_of(points, self.own, crossed)
        middle = places[:, 1].copy()
        for count in (2, 3):
            here = self.count == count
            middle[here] = places[here, :count].mean(axis=1)
        away = np.sqrt(((places - middle[:, None]) ** 2).sum(axis=2)).max(axis=1, initial=0.0)
        return middle, away + self.radius

    @cached_property
    def skin(self) -> np.ndarray:
        """Number of the surface of each element, (e,)."""
        counts = [sum(len(at) for _, at in surface.sorts) for surface in self.surfaces]
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def radius(self) -> np.ndarray:
        """Radii of the surfaces [m], (e,)."""
        return np.array([surface.radius for surface in self.surfaces])[self.skin]

    def at(self, points: np.ndarray, middle: np.ndarray, crossed: Crossed = None) -> Elements:
        """The elements as narrow phases read them, for bodies at ``points`` (n, d) and the middles that :meth:`bounds`
        gives."""
        places, (count, d) = places_of(points, self.corner, crossed), middle.shape
        weight, gradient = np.zeros((count, 3)), np.zeros((count, 3, d))
        here = self.count == 2
        along = places[here, 1] - places[here, 0]
        gradient[here, 1] = along / square_of(along)[:, None]
        gradient[here, 0] = -gradient[here, 1]
        weight[here, :2] = 0.5
        here = self.count == 3
        weight[here] = 1.0 / 3.0
        if here.any():
            # grad w_k = a x e_k / |a|^2, e_k the edge across from corner k, a twice the area along the normal
            across = np.roll(places[here], -2, axis=1) - np.roll(places[here], -1, axis=1)
            doubled = np.cross(across[:, 0], across[:, 1])
            gradient[here] = np.cross(doubled[:, None], across) / square_of(doubled)[:, None, None]
        here = self.count == 0
        weight[here, 1] = 1.0
        for side in (0, 2):
            there = here & (self.corner[:, side] != self.corner[:, 1])
            both = (self.corner[:, 2 - side] != self.corner[:, 1])[there]
            along = places[there, side] - places[there, 1]
            half = np.where(both, 0.5, 1.0)[:, None] * along / square_of(along)[:, None]
            gradient[there, side] = half
            gradient[there, 1] -= half
        row = np.full(self.contactors, -1)
        row[self.rows] = np.arange(count)
        slope, places = np.where(here, 0.0, 1.0), places.reshape(count, 3 * d)
        return Elements(row, self.corner, places, middle, weight, slope, gradient.reshape(count, 3 * d))


def square_of(vectors: np.ndarray) -> np.ndarray:
    """Squares of the lengths of vectors (m, d), 1 for zeros: nodes coincide only in scenes that are not run."""
    squares = (vectors * vectors).sum(axis=1)
    return np.where(squares > 0.0, squares, 1.0)


def _register() -> None:
    """The narrow phases of features meet elements as well."""
    for (one, other), narrow in (IN_SPACE | IN_PLANE).items():
        pairs = {(one, other)}
        if one in CORNERS:
            pairs |= {(OF_NODES + one, other)}
        if other in CORNERS:
            pairs |= {(c, OF_NODES + other) for c, _ in pairs}
        for pair in pairs - {(one, other)}:
            if pair not in known_pairs():
                both = all(kind.startswith(OF_NODES) for kind in pair)
                register_pair(*pair, FOLDS.get((one, other), narrow) if both else narrow, form="elements")


_register()
