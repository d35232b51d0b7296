"""The input of the detection: contactors, rows of the visibility table, chains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lmgcpy.contact.elements import CORNERS, Crossed, ElementTable, SkinTable
from lmgcpy.contact.positions import axes_of, in_plane, in_space
from lmgcpy.laws import Law

FEATURES = tuple(CORNERS)
"""Kinds of the features of surfaces, see :mod:`lmgcpy.contact.features`."""


@dataclass(frozen=True)
class ContactorTable:
    """All contactors of a scene; k of them."""

    body: np.ndarray
    """Row of the body, ascending, (k,) int64."""
    offset: np.ndarray
    """Position in the frame of the body [m], (k, d)."""
    kind: list[str]
    color: list[str]
    shape: np.ndarray
    """Numbers of the shapes, (k, widest)."""
    shape_size: dict[str, int]
    """How many of them a kind has."""
    bounding_radius: np.ndarray
    """Of a circle or sphere around each contactor [m], infinite where unbounded, (k,)."""
    turns: np.ndarray | None = None
    """Whether the body of each contactor keeps a rotation in space, (k,) bool; None in 2D, and if none does: then positions
    have no rotations, and no contact may have the form "lever"."""
    middle: np.ndarray | None = None
    """Centres of these circles or spheres seen from the contactors, along the axes of the bodies [m], (k, d); None if all
    are the positions of the contactors."""
    half_box: np.ndarray | None = None
    """Half sides of boxes along the axes of the bodies that contain the contactors, around the same centres [m], (k, d);
    None if there are no features."""
    sizes: np.ndarray | None = None
    """Lengths with which displacements and overlaps are compared [m], (k,), infinite for walls; None for the bounding
    radii."""
    elements: ElementTable | None = None
    """Those that lie on several bodies; ``body`` of these is the body at one of their corners. None if there are none."""

    def with_elements(
        self, surfaces: Sequence[SkinTable], points: np.ndarray, bodies: int, crossed: Crossed = None
    ) -> ContactorTable:
        """The table with the elements of some surfaces, for bodies at ``points`` (n, d); ``bodies``: number of bodies to
        whose contactors they come next. Bodies that are added later come after them. ``crossed``: ways across a periodic
        cell, None without a cell."""
        first = int(np.searchsorted(self.body, bodies))
        table = ElementTable.of(first, len(self.body), surfaces)
        count, radius = len(table), table.bounds(points, crossed)[1]
        nothing = np.zeros((count, self.offset.shape[1]))
        size = self.shape_size | table.shape_size(points)
        shape = np.insert(widened(self.shape, max(size.values())), first, np.zeros((count, 1)), axis=0)
        return replace(
            self,
            body=np.insert(self.body, first, table.own[:, 1]),
            offset=np.insert(self.offset, first, nothing, axis=0),
            kind=[*self.kind[:first], *table.kind, *self.kind[first:]],
            color=[*self.color[:first], *table.color, *self.color[first:]],
            shape=table.enter(shape, points, crossed),
            shape_size=size,
            bounding_radius=np.insert(self.bounding_radius, first, radius),
            middle=None if self.middle is None else np.insert(self.middle, first, nothing, axis=0),
            half_box=None if self.half_box is None else np.insert(self.half_box, first, nothing, axis=0),
            sizes=np.insert(self.size, first, table.radius),
            turns=None if self.turns is None else np.insert(self.turns, first, np.zeros(count, dtype=bool)),
            elements=table,
        )

    @cached_property
    def rods(self) -> np.ndarray:
        """Whether a contactor is a rod, (k,) bool."""
        return np.array([kind == "rod" for kind in self.kind], dtype=bool)

    @cached_property
    def features(self) -> np.ndarray:
        """Whether a contactor is a feature of a surface, (k,) bool."""
        return np.array([kind in FEATURES for kind in self.kind], dtype=bool)

    @cached_property
    def radius(self) -> np.ndarray:
        """Radius of the surface that others meet [m], (k,): the size, but of a rod its own."""
        return np.where(self.rods, self.shape[:, 0], self.size) if self.rods.any() else self.size

    @cached_property
    def thickness(self) -> np.ndarray:
        """Radius with which the axis, or the plane, of each contactor is surrounded [m], (k,): of round ones their own."""
        return np.where(self.rods | self.features, self.shape[:, 0], self.bounding_radius)

    @property
    def size(self) -> np.ndarray:
        """Lengths with which displacements and overlaps are compared [m], (k,)."""
        return self.bounding_radius if self.sizes is None else self.sizes

    @property
    def swing(self) -> np.ndarray:
        """Vectors from the centres of the bodies to the centres of the bounding spheres, along their axes [m], (k, d)."""
        return self.offset if self.middle is None else self.offset + self.middle

    def centres(self, placed: np.ndarray) -> np.ndarray:
        """Positions (k, w) of the contactors with the centres of their bounding spheres in place of their own; further
        rows are left as they are."""
        if self.middle is None:
            return placed
        centres, (k, d) = placed.copy(), self.middle.shape
        if d == 2:
            centres[:k, :2] += in_plane(placed[:k, 2], self.middle)
        else:
            centres[:k, :3] += in_space(placed[:k, 3:], self.middle) if placed.shape[1] == 7 else self.middle
        return centres

    def boxes(self, placed: np.ndarray) -> np.ndarray | None:
        """Half sides of boxes along the axes of space around the centres of the bounding spheres that contain the
        contactors at these positions (k, w) [m], (k, d); None without features."""
        if self.half_box is None:
            return None
        k, d = self.half_box.shape
        if d == 2:
            axes = in_plane(placed[:k, 2, None], np.eye(2)).transpose(0, 2, 1)
        else:
            axes = axes_of(placed[:k])
        return np.where(self.features[:, None], np.einsum("kij,kj->ki", np.abs(axes), self.half_box), self.half_box)

    @property
    def width(self) -> int:
        """Length of a position: 3, or 7 in scenes with bodies that keep a rotation in space."""
        return 3 if self.turns is None else 7


def widened(table: np.ndarray, width: int) -> np.ndarray:
    """A table with columns of zeros behind it, up to a width."""
    return np.pad(table, ((0, 0), (0, max(0, width - table.shape[1]))))


@dataclass(frozen=True)
class VisibilityRow:
    """Who sees whom, under which law, up to which gap [m]."""

    candidate: str
    antagonist: str
    law: Law
    alert: float
    adaptive: bool = False
    """Whether the alert distance grows with the speed of the bodies."""
    reach: float = 0.0
    """Greatest gap at which the law acts [m]."""

    @cached_property
    def parameters(self) -> np.ndarray:
        """Parameters of the law, the same for all, (1, k)."""
        return np.ascontiguousarray(self.law.table(np.zeros(1)), dtype=float)


@dataclass(frozen=True)
class Points:
    """Points of k bodies at which links act."""

    offset: np.ndarray
    """From the centres of the bodies, along their axes [m], (k, d)."""
    turns: np.ndarray
    """Whether a point is off the centre and turns with its body, (k,) bool. In space walls never turn."""


@dataclass(frozen=True)
class ChainTable:
    """Links of one chain: link i joins ``bodies[i]``, antagonist, and ``bodies[i + 1]``, candidate."""

    bodies: np.ndarray
    """Rows of the bodies, (links + 1,) int64; of a closed chain the last is the first."""
    laws: list[Law]
    """Either a law for each link, all of one class, or a single law that all links share."""
    radius_sum: np.ndarray
    """Sum of the two radii [m], (links,)."""
    reference_gap: np.ndarray
    """[m], (links,)."""
    start_gap: np.ndarray
    """Gap from which a link is drawn to its reference [m], (links,)."""
    relaxation: float
    """Time that this takes [s]; 0 for none."""
    function: Callable[[float], np.ndarray] | None = None
    """Reference gaps [m], (links,), at a time [s], if they are a function of it: the steps :meth:`draw` them."""
    points: Points | None = None
    """The points of the bodies that it links; None if all are centres."""

    @property
    def law(self) -> Law:
        """The law, with the parameters of the first link."""
        return self.laws[0]

    @property
    def link_count(self) -> int:
        """How many links."""
        return len(self.radius_sum)

    @property
    def closed(self) -> bool:
        """Whether the last body is the first."""
        return bool(self.bodies[0] == self.bodies[-1])

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Places in ``bodies`` of the antagonist and of the candidate of each link, (links,)."""
        return np.arange(self.link_count), np.arange(1, self.link_count + 1)

    @cached_property
    def parameters(self) -> np.ndarray:
        """Parameters of the law, one row a link, (links, k)."""
        length = self.radius_sum + self.reference_gap
        if len(self.laws) == 1:
            return np.ascontiguousarray(self.law.table(length), dtype=float)
        tables = [law.table(length[i : i + 1]) for i, law in enumerate(self.laws)]
        return np.ascontiguousarray(np.concatenate(tables), dtype=float)

    def draw(self, time: float) -> None:
        """Give the links the reference gaps that the function has at a time [s]."""
        assert self.function is not None
        self.reference_gap[:] = self.function(time)
        vars(self).pop("parameters", None)  # some are made from the lengths

    def reference_gap_at(self, time: float) -> np.ndarray:
        """Reference gaps at a time [m], (links,)."""
        if time >= self.relaxation:
            return self.reference_gap
        return self.start_gap + (self.reference_gap - self.start_gap) * (time / self.relaxation)

    @property
    def form(self) -> str:
        """Name of the form of the rows of H."""
        return "central" if self.points is None or not self.points.turns.any() else "lever"


@dataclass(frozen=True)
class JointTable(ChainTable):
    """Joints of one law: joint j ties a point of ``bodies[2 j]``, antagonist, to a point of ``bodies[2 j + 1]``, candidate.

    It has a link along each axis of space, with the component of the vector between the points as its gap. These d links
    stand one after another.
    """

    @property
    def closed(self) -> bool:
        """False: joints are no chain."""
        return False

    @property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        antagonist = np.repeat(np.arange(0, len(self.bodies), 2), 2 * self.link_count // len(self.bodies))
        return antagonist, antagonist + 1
