"""Parts of a drawing: the content of a box; in 3D everything behind a plane, or only the cut by the plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lmgcpy.view.boundary import cut
from lmgcpy.view.drawing import Balls, Drawing, Tubes, in_space
from lmgcpy.view.style import Plane

OTHERS = {0: [1, 2], 1: [0, 2], 2: [0, 1]}
"""Axes that point to the right and up in a view along each axis."""


def coordinate(drawing: Drawing, plane: Plane) -> float:
    """Coordinate of a plane along its axis [m]; by default the middle of the drawing."""
    axis, at = plane
    corners = drawing.bounds()
    return 0.5 * float(corners[0, axis] + corners[-1, axis]) if at is None else at


def clip(drawing: Drawing, plane: Plane, direction: tuple[float, float, float]) -> Drawing:
    """The drawing without the bodies, by their centres, and the tubes, by their middles, that are between the plane and the
    eye, which is in ``direction``. If one looks along the plane, those on its positive side are left out."""
    axis, at = plane[0], coordinate(drawing, plane)
    side = -1.0 if direction[axis] < -1e-9 else 1.0

    def behind(points: np.ndarray) -> np.ndarray:
        return side * (points[:, axis] - at) <= 0.0

    return replace(
        drawing,
        balls=[balls.take(behind(balls.centres if balls.bodies is None else balls.bodies)) for balls in drawing.balls],
        tubes=[
            tubes.take(behind(0.5 * (tubes.starts + tubes.ends) if tubes.bodies is None else tubes.bodies))
            for tubes in drawing.tubes
        ],
    )


def within(drawing: Drawing, region: np.ndarray) -> Drawing:
    """The content of the box from ``region[0]`` to ``region[1]`` [m], (2, 3): balls and tubes that reach into it, and the
    parts of walls and lines inside it."""
    return replace(
        drawing,
        balls=[balls.take(reaching(balls.centres, balls.radii, region)) for balls in drawing.balls],
        tubes=[tubes.take(_passing(tubes, region)) for tubes in drawing.tubes],
        walls=_parts(drawing.walls, region),
        ground=_parts(drawing.ground, region),
        sheets=_parts(drawing.sheets, region),
        solids=_parts(drawing.solids, region),
        lines=_pieces(drawing.lines, region),
        region=region,
    )


def reaching(centres: np.ndarray, radii: np.ndarray, region: np.ndarray) -> np.ndarray:
    """Whether each ball (k, 3) reaches into a box (2, 3) [m], (k,): the point of the box nearest to its centre is in it."""
    return np.linalg.norm(centres - np.clip(centres, *region), axis=1) <= radii


def _passing(tubes: Tubes, region: np.ndarray) -> np.ndarray:
    """Whether the axes of tubes have a piece in the box, (k,)."""
    enter, leave = _inside(tubes.starts, tubes.ends, region)
    return enter <= leave


def _pieces(lines: np.ndarray, region: np.ndarray) -> np.ndarray:
    """Pieces of straight lines (k, 2, 3) in the box [m], (l, 2, 3)."""
    starts, ends = lines[:, 0], lines[:, 1]
    enter, leave = _inside(starts, ends, region)
    kept = enter < leave
    along = (ends - starts)[kept]
    at = np.stack([enter, leave], axis=1)[kept]
    return starts[kept][:, None] + at[:, :, None] * along[:, None]


def _inside(starts: np.ndarray, ends: np.ndarray, region: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of their length at which lines (k, 3) enter and leave the box, (k,) each; enter > leave if a line passes it
    by. A line is between the two planes of an axis from the smaller to the larger of its crossings (Liang and Barsky 1984).
    """
    along = ends - starts
    level = along == 0.0
    steps = np.where(level, 1.0, along)
    crossings = np.sort((region[:, None] - starts) / steps, axis=0)
    between = (region[0] <= starts) & (starts <= region[1])
    first = np.where(level, np.where(between, -np.inf, np.inf), crossings[0])
    last = np.where(level, np.inf, crossings[1])
    return np.maximum(first.max(axis=1), 0.0), np.minimum(last.min(axis=1), 1.0)


def _parts(polygons: list[np.ndarray], region: np.ndarray) -> list[np.ndarray]:
    """Parts of convex polygons (v, 3), or of lines (2, 3), in the box [m]."""
    found = []
    for polygon in polygons:
        piece = polygon
        for axis in np.flatnonzero(region[0] < region[1]):  # a flat drawing has two
            for side, through in zip((1.0, -1.0), region, strict=True):
                piece = cut(piece, side * np.eye(3)[axis], through)
        if len(piece) >= min(len(polygon), 3):
            found.append(piece)
    return found


def section(drawing: Drawing, plane: Plane) -> Drawing:
    """The flat drawing of a cut: the disks in which the plane cuts balls and rods, wires and forces that stay within a mean
    radius of the plane, walls as lines."""
    axis, at = plane[0], coordinate(drawing, plane)

    def flattened(points: np.ndarray) -> np.ndarray:
        return in_space(points[..., OTHERS[axis]])

    balls = []
    for piece in [*drawing.balls, *(balls_along(rods, axis, at) for rods in drawing.tubes if rods.bodies is not None)]:
        half = piece.radii**2 - (piece.centres[:, axis] - at) ** 2
        hit = half > 0.0
        shown = piece.take(hit)
        centres = flattened(shown.centres)
        balls.append(replace(shown, centres=centres, radii=np.sqrt(half[hit]), rim=True, bodies=None))
    tubes = []
    for tube in drawing.tubes:
        if tube.bodies is not None:
            continue
        near = np.maximum(np.abs(tube.starts[:, axis] - at), np.abs(tube.ends[:, axis] - at)) <= drawing.grain
        within = tube.take(near)
        tubes.append(replace(within, starts=flattened(within.starts), ends=flattened(within.ends)))
    lines = [flattened(line) for line in (_crossing(polygon, axis, at) for polygon in drawing.walls) if len(line)]
    thin = np.array(lines).reshape(-1, 2, 3)
    region = None if drawing.region is None else flattened(drawing.region)
    drawing = replace(drawing, flat=True, balls=balls, tubes=tubes, walls=lines, lines=thin, region=region)
    return replace(drawing, ground=[], sheets=[], solids=[])


STEP = 0.2
"""Distance of the balls that make up a rod, in its radii: the outline of a cut is then off by 1/200 of a radius."""


def balls_along(rods: Tubes, axis: int, at: float) -> Balls:
    """Balls along rods, a :data:`STEP` from each other, that reach the plane at a coordinate ``at`` [m] of an ``axis``."""
    along = rods.ends - rods.starts
    count = np.ceil(np.linalg.norm(along, axis=1) / (STEP * rods.radii)).astype(np.int64) + 1
    near = np.abs(0.5 * (rods.starts + rods.ends)[:, axis] - at) < 0.5 * np.abs(along[:, axis]) + rods.radii
    own = np.repeat(np.flatnonzero(near), count[near])
    number = np.arange(len(own)) - np.repeat(np.cumsum(count[near]) - count[near], count[near])
    part = number / np.maximum(count[own] - 1, 1)
    centres = rods.starts[own] + part[:, None] * along[own]
    return Balls(centres, rods.radii[own], rods.paint.take(own), rods.opacity)


def _crossing(polygon: np.ndarray, axis: int, at: float) -> np.ndarray:
    """Line along which a plane cuts a convex polygon [m], (2, 3), or (0, 3) if it does not."""
    ahead = polygon[:, axis] - at
    points = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if (ahead[i] >= 0.0) != (ahead[j] >= 0.0):
            points.append(polygon[i] + ahead[i] / (ahead[i] - ahead[j]) * (polygon[j] - polygon[i]))
    return np.array(points[:2]).reshape(-1, 3) if len(points) >= 2 else np.zeros((0, 3))
