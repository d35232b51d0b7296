"""Drawings as arrays: balls, tubes, walls and lines in space, each with its paint; and the colours that have a meaning.

A flat drawing has its coordinates in the plane z = 0; items of a higher ``level`` cover those of a lower level.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from lmgcpy.view.quantities import Limits, Quantity

SAND, BEAD, WIRE = "#d9cba3", "#9ab7dd", "#1b4f9c"
"""Grains; beads; wires and links in tension."""
CONTACT, PUSHING, COHESION = "#b2182b", "#e08214", "#35978f"
"""Contact reactions, links in compression, contacts in tension."""
WRONG = "#ff0000"
"""Overlaps and links that are too long."""
EDGE, GROUND = "#404040", "#eeeeee"
"""Edges of walls, and floors."""
GROUPS = ["#d9cba3", "#8da0cb", "#fc8d62", "#66c2a5", "#e78ac3", "#a6d854", "#b3b3b3"]
"""Colours of the visibility table, in the order in which they occur."""
CURVES = {
    "none": "#8c6d31",
    "rigid-wire": "#1b4f9c",
    "rigid-rod": "#b2182b",
    "elastic-wire": "#35978f",
    "elastic-rod": "#762a83",
}
"""Colours of the curves of tests, by the law of the wire."""


@dataclass(frozen=True)
class Paint:
    """Paint of k items: one colour for all, a colour for each, or values of a quantity."""

    color: str = ""
    """One colour for all items, as '#rrggbb'."""
    values: np.ndarray | None = None
    """Values of the quantity, (k,), or RGB, (k, 3) uint8."""
    quantity: Quantity | None = None

    def take(self, chosen: np.ndarray) -> Paint:
        """The paint of some of the items."""
        return self if self.values is None else replace(self, values=self.values[chosen])

    def rgb(self, count: int, limits: dict[Quantity, Limits]) -> np.ndarray:
        """Colours, (count, 3) uint8."""
        if self.values is None:
            return np.tile(rgb(self.color), (count, 1))
        if self.quantity is None:
            return self.values
        return self.quantity.colors(self.values, limits[self.quantity])


def rgb(color: str) -> np.ndarray:
    """Red, green and blue of '#rrggbb' as three bytes."""
    return np.frombuffer(bytes.fromhex(color[1:]), dtype=np.uint8)


@dataclass(frozen=True)
class Balls:
    """Spheres, in a flat drawing disks; k of them."""

    centres: np.ndarray
    """[m], (k, 3)."""
    radii: np.ndarray
    """[m], (k,)."""
    paint: Paint
    opacity: float = 1.0
    rim: bool = False
    """Whether disks have a darker edge."""
    level: int = 0
    bodies: np.ndarray | None = None
    """Centres of their bodies [m], (k, 3), by which a clip takes bodies whole; None: their own."""

    def take(self, chosen: np.ndarray) -> Balls:
        """Some of the balls."""
        return replace(
            self,
            centres=self.centres[chosen],
            radii=self.radii[chosen],
            paint=self.paint.take(chosen),
            bodies=None if self.bodies is None else self.bodies[chosen],
        )


@dataclass(frozen=True)
class Tubes:
    """Straight pieces with round ends; k of them."""

    starts: np.ndarray
    ends: np.ndarray
    """[m], (k, 3)."""
    radii: np.ndarray
    """Radii [m], (k,), or forces [N] that a scale turns into radii."""
    paint: Paint
    by_force: bool = False
    level: int = 1
    opacity: float = 1.0
    """In space; in a flat drawing tubes are opaque."""
    bodies: np.ndarray | None = None
    """Centres of their bodies [m], (k, 3), if they are parts of bodies; None of wires and forces."""

    def take(self, chosen: np.ndarray) -> Tubes:
        """Some of the tubes."""
        return replace(
            self,
            starts=self.starts[chosen],
            ends=self.ends[chosen],
            radii=self.radii[chosen],
            paint=self.paint.take(chosen),
            bodies=None if self.bodies is None else self.bodies[chosen],
        )


@dataclass(frozen=True)
class Drawing:
    """Everything that one panel shows."""

    flat: bool
    balls: list[Balls]
    tubes: list[Tubes]
    walls: list[np.ndarray]
    """Polygons [m], (v, 3) each; pieces of line, v = 2, in a flat drawing."""
    lines: np.ndarray
    """Thin lines: edges of walls [m], (k, 2, 3)."""
    grain: float
    """Mean radius of the grains [m]."""
    ground: list[np.ndarray] = field(default_factory=list)
    """Filled polygons: walls on which bodies lie [m], (v, 3) each."""
    sheets: list[np.ndarray] = field(default_factory=list)
    """Facets of walls, that let through what is behind them [m], (v, 3) each."""
    solids: list[np.ndarray] = field(default_factory=list)
    """Facets of bodies [m], (v, 3) each."""
    time: float | None = None
    """Time [s]; None for a scene."""
    legend: list[tuple[str, str]] = field(default_factory=list)
    """Meaning of the plain colours: label and colour."""
    region: np.ndarray | None = None
    """Low and high corner of the visible region [m], (2, 3); None if everything is visible."""

    escaped: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    """Ids of the bodies that are left out because they are far from all others."""

    def bounds(self) -> np.ndarray:
        """Corners of the region, or of a box that holds everything [m], (k, 3)."""
        if self.region is not None:
            return corners(*self.region)
        points = [np.zeros((0, 3)), *self.walls, self.lines.reshape(-1, 3)]
        for balls in self.balls:
            points += [balls.centres - balls.radii[:, None], balls.centres + balls.radii[:, None]]
        for tubes in self.tubes:
            reach = 0.0 if tubes.bodies is None else tubes.radii[:, None]
            points += [end + side * reach for end in (tubes.starts, tubes.ends) for side in (-1.0, 1.0)]
        cloud = np.concatenate(points)
        if not len(cloud):
            return np.zeros((1, 3))
        return corners(cloud.min(axis=0), cloud.max(axis=0))

    @property
    def empty(self) -> bool:
        """Whether there is nothing to be seen."""
        things = [balls.centres for balls in self.balls] + [tubes.starts for tubes in self.tubes]
        return not (self.walls or self.ground or len(self.lines) or any(map(len, things)))

    def paints(self) -> list[Paint]:
        """Paints of all balls and tubes."""
        return [*(balls.paint for balls in self.balls), *(tubes.paint for tubes in self.tubes)]

    def forces(self) -> np.ndarray:
        """Absolute values of the forces that are drawn [N]."""
        return np.abs(np.concatenate([np.zeros(0), *(tubes.radii for tubes in self.tubes if tubes.by_force)]))


def corners(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Corners of the box from ``low`` (3,) to ``high`` (3,) [m], (8, 3); the first is ``low``, the last ``high``."""
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def in_space(points: np.ndarray) -> np.ndarray:
    """Points (..., d) with a third coordinate, zero in 2D."""
    points = np.asarray(points, dtype=float)
    if points.shape[-1] == 3:
        return points
    return np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
