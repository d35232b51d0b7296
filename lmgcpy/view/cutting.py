"""Part of a drawing in 3D: all that is behind a plane, or only what the plane cuts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lmgcpy.view.drawing import Drawing, in_space
from lmgcpy.view.style import Plane

OTHERS = {0: [1, 2], 1: [0, 2], 2: [0, 1]}
"""Axes that point to the right and up in a view along each axis."""


def coordinate(drawing: Drawing, plane: Plane) -> float:
    """Coordinate of a plane along its axis [m]; by default the middle of the drawing."""
    axis, at = plane
    corners = drawing.bounds()
    return 0.5 * float(corners[0, axis] + corners[-1, axis]) if at is None else at


def clip(drawing: Drawing, plane: Plane, direction: tuple[float, float, float]) -> Drawing:
    """The drawing without the balls and tubes whose middle is between the plane and the eye, which is in ``direction``. If
    one looks along the plane, those on its positive side are left out."""
    axis, at = plane[0], coordinate(drawing, plane)
    side = -1.0 if direction[axis] < -1e-9 else 1.0

    def behind(points: np.ndarray) -> np.ndarray:
        return side * (points[:, axis] - at) <= 0.0

    return replace(
        drawing,
        balls=[balls.take(behind(balls.centres)) for balls in drawing.balls],
        tubes=[tubes.take(behind(0.5 * (tubes.starts + tubes.ends))) for tubes in drawing.tubes],
    )


def section(drawing: Drawing, plane: Plane) -> Drawing:
    """What the plane cuts, flat: balls as the disks that are cut out of them, tubes that keep within a mean radius of the
    plane, walls as lines."""
    axis, at = plane[0], coordinate(drawing, plane)

    def flattened(points: np.ndarray) -> np.ndarray:
        return in_space(points[..., OTHERS[axis]])

    balls = []
    for piece in drawing.balls:
        half = piece.radii**2 - (piece.centres[:, axis] - at) ** 2
        hit = half > 0.0
        shown = piece.take(hit)
        balls.append(replace(shown, centres=flattened(shown.centres), radii=np.sqrt(half[hit]), rim=True))
    tubes = []
    for tube in drawing.tubes:
        near = np.maximum(np.abs(tube.starts[:, axis] - at), np.abs(tube.ends[:, axis] - at)) <= drawing.grain
        within = tube.take(near)
        tubes.append(replace(within, starts=flattened(within.starts), ends=flattened(within.ends)))
    lines = [flattened(line) for line in (_crossing(polygon, axis, at) for polygon in drawing.walls) if len(line)]
    thin = np.array(lines).reshape(-1, 2, 3)
    return replace(drawing, flat=True, balls=balls, tubes=tubes, walls=lines, lines=thin, ground=[])


def _crossing(polygon: np.ndarray, axis: int, at: float) -> np.ndarray:
    """Line along which a plane cuts a convex polygon [m], (2, 3), or (0, 3) if it does not."""
    ahead = polygon[:, axis] - at
    points = []
    for i in range(len(polygon)):
        j = (i + 1) % len(polygon)
        if (ahead[i] >= 0.0) != (ahead[j] >= 0.0):
            points.append(polygon[i] + ahead[i] / (ahead[i] - ahead[j]) * (polygon[j] - polygon[i]))
    return np.array(points[:2]).reshape(-1, 3) if len(points) >= 2 else np.zeros((0, 3))
