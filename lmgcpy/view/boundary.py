"""Walls, which have no end, as the polygons and lines that bound what is drawn."""

from __future__ import annotations

import numpy as np

from lmgcpy.view.drawing import in_space
from lmgcpy.view.snapshot import Snapshot

MARGIN = 0.06
"""Length by which a wall that no other wall ends reaches beyond the sample, as part of the sample's diagonal."""
FAR = 1.0
"""Distance beyond which a wall is not drawn, in diagonals of the sample."""
FACETS = 72
"""Number of facets of a cylinder."""


def drawn_box(snap: Snapshot) -> np.ndarray:
    """Low and high corner of the box around all bodies with bounds, the walls near them, and a margin [m], (2, d)."""
    rounds, rods = snap.rounds, snap.rods
    lines = [line for _, line in (*snap.outlines, *snap.facets)]
    nodes = [snap.positions[skin["bodies"]] for skin in snap.skins]
    lines += [points + snap.into_cell(points) for points in nodes]
    if not len(snap.drawn) and not lines:
        walls = snap.walls.position
        middle = walls.mean(axis=0) if len(walls) else np.zeros(snap.dimension)
        return np.stack([middle - 1.0, middle + 1.0])
    radius = rounds.shape[:, :1]
    centres, middles, reach = snap.placed(rounds), snap.placed(rods), np.abs(rods.shape[:, 1:]) + rods.shape[:, :1]
    ends = [centres - radius, centres + radius, middles - reach, middles + reach]
    points = np.concatenate([*ends, *lines])
    box = np.stack([points.min(axis=0), points.max(axis=0)])
    diagonal = float(np.linalg.norm(box[1] - box[0]))
    reached = box.copy()
    for point, normal in zip(snap.walls.position, snap.walls.shape, strict=True):
        nearest = np.where(normal > 0.0, box[0], box[1])
        away = float((nearest - point) @ normal)
        if 0.0 < away <= FAR * diagonal:
            foot = nearest - away * normal
            reached = np.stack([np.minimum(reached[0], foot), np.maximum(reached[1], foot)])
    return reached + MARGIN * diagonal * np.array([[-1.0], [1.0]])


def wall_polygons(snap: Snapshot) -> list[np.ndarray]:
    """The part of each line or plane that bounds the sample [m]: (2, 3) in 2D, (v, 3) in 3D.

    A large piece of the wall is cut by the box around the sample and by every other wall.
    """
    low, high = drawn_box(snap)
    points, normals = snap.walls.position, snap.walls.shape
    axes = np.eye(snap.dimension)
    limits = [(axes[k], low) for k in range(len(axes))] + [(-axes[k], high) for k in range(len(axes))]
    size = float(np.linalg.norm(high - low))
    found = []
    for i, (point, normal) in enumerate(zip(points, normals, strict=True)):
        foot = 0.5 * (low + high)
        foot = foot - ((foot - point) @ normal) * normal
        if snap.dimension == 2:
            along = np.array([-normal[1], normal[0]])
            piece = np.stack([foot - size * along, foot + size * along])
        else:
            one, other = across(normal)
            piece = foot + size * np.array([one + other, other - one, -one - other, one - other])
        others = [(normals[k], points[k]) for k in range(len(normals)) if k != i and abs(normals[k] @ normal) < 1.0 - 1e-9]
        for direction, through in (*limits, *others):
            piece = cut(piece, direction, through)
        if len(piece) >= snap.dimension:
            found.append(in_space(piece))
        else:
            found.append(np.zeros((0, 3)))
    return found


def cell_outline(snap: Snapshot) -> np.ndarray:
    """Edges of a periodic cell, as thin lines [m], (k, 2, 3); along an axis without one as long as the sample, in 2D
    without ends."""
    lattice, d = snap.lattice, snap.dimension
    if lattice is None:
        return np.zeros((0, 2, 3))
    origin, basis = np.zeros(d), lattice.basis(snap.edges)
    drawn = range(d)
    if len(lattice.axes) < d:
        box = drawn_box(snap)
        for k in set(range(d)) - set(lattice.axes.tolist()):
            origin[k] = box[0, k]
            basis[:, k] *= box[1, k] - box[0, k]
            drawn = range(k, k + 1) if d == 2 else drawn
    ends = np.array(list(np.ndindex(*(2,) * d)))
    lines = [
        np.stack([origin + basis @ one, origin + basis @ other])
        for i, one in enumerate(ends)
        for other in ends[i + 1 :]
        if np.abs(other - one).sum() == 1 and np.abs(other - one).argmax() in drawn
    ]
    return in_space(np.array(lines))


def cylinder_polygons(snap: Snapshot) -> list[np.ndarray]:
    """Facets of the hollow cylinders, as long as the sample [m], (4, 3) each."""
    if not len(snap.cylinders.body):
        return []
    low, high = drawn_box(snap)
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[-1], high[-1])])
    angle = np.linspace(0.0, 2.0 * np.pi, FACETS + 1)
    found = []
    for point, shape in zip(snap.cylinders.position, snap.cylinders.shape, strict=True):
        axis, radius = shape[:3], shape[3]
        one, other = across(axis)
        ring = point + radius * (np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * other)
        reach = (corners - point) @ axis
        below, above = reach.min(), reach.max()
        for wall, normal in zip(snap.walls.position, snap.walls.shape, strict=True):
            if normal @ axis > 1.0 - 1e-9:
                below = max(below, (wall - point) @ axis)
            elif normal @ axis < -1.0 + 1e-9:
                above = min(above, (wall - point) @ axis)
        bottom, top = ring + below * axis, ring + above * axis
        found += list(np.stack([bottom[:-1], bottom[1:], top[1:], top[:-1]], axis=1))
    return found


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors at right angles to a unit vector and to each other, (3,) each."""
    least = np.eye(3)[int(np.argmin(np.abs(axis)))]
    one = np.cross(axis, least)
    one /= np.linalg.norm(one)
    return one, np.cross(axis, one)


def cut(piece: np.ndarray, direction: np.ndarray, through: np.ndarray) -> np.ndarray:
    """The part of a convex polygon (v, d), or of a line (2, d), on the side of ``through`` where ``direction`` points."""
    if not len(piece):
        return piece
    ahead = (piece - through) @ direction
    size = float(np.abs(piece - through).max()) or 1.0
    ahead[np.abs(ahead) < 1e-12 * size] = 0.0
    kept = []
    closed = len(piece) > 2
    for i in range(len(piece) if closed else len(piece) - 1):
        j = (i + 1) % len(piece)
        if ahead[i] >= 0.0:
            kept.append(piece[i])
        if ahead[i] * ahead[j] < 0.0:
            kept.append(piece[i] + ahead[i] / (ahead[i] - ahead[j]) * (piece[j] - piece[i]))
    if not closed and ahead[-1] >= 0.0:
        kept.append(piece[-1])
    return np.array(kept).reshape(-1, piece.shape[1])


def polylines(lines: list[np.ndarray]) -> np.ndarray:
    """Pieces of polylines (v, d) [m], (k, 2, 3)."""
    pieces = [in_space(np.stack([line[:-1], line[1:]], axis=1)) for line in lines]
    return np.concatenate([np.zeros((0, 2, 3)), *pieces])


def edges(polygons: list[np.ndarray]) -> np.ndarray:
    """Edges of polygons, and lines unchanged [m], (k, 2, 3)."""
    pieces = [np.zeros((0, 2, 3))]
    for polygon in polygons:
        if len(polygon) == 2:
            pieces.append(polygon[None])
        elif len(polygon):
            pieces.append(np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1))
    return np.concatenate(pieces)
