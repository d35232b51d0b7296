"""Segments, the axes of rods: their nearest points and distances."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.positions import in_own_axes, in_plane, in_space


def feet(points: np.ndarray, middle: np.ndarray, half: np.ndarray) -> np.ndarray:
    """The points of segments from ``middle - half`` to ``middle + half`` (m, d) that are nearest to some points (m, d)."""
    square = (half * half).sum(axis=1)
    part = ((points - middle) * half).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    return middle + np.clip(part, -1.0, 1.0)[:, None] * half


def facet_distances(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distances of points (p, d) from triangles, in the plane from segments, with these corners (p, d, d) [m], (p,)."""
    d = corners.shape[1]
    sides = [(corners[:, k], corners[:, (k + 1) % d]) for k in range(1 if d == 2 else 3)]
    away = [np.linalg.norm(points - feet(points, 0.5 * (p + q), 0.5 * (q - p)), axis=1) for p, q in sides]
    if d == 3:
        away.append(foot_distances(points, corners))
    least: np.ndarray = np.min(away, axis=0)
    return least


def foot_distances(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distances of points (p, 3) from the planes of triangles (p, 3, 3) [m], (p,), infinite if the foot is outside."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    y = points - a
    uu, uv, vv, uy, vy = ((s * t).sum(axis=1) for s, t in ((u, u), (u, v), (v, v), (u, y), (v, y)))
    area = uu * vv - uv * uv
    one, other = (vv * uy - uv * vy) / area, (uu * vy - uv * uy) / area
    inside = (one >= 0.0) & (other >= 0.0) & (one + other <= 1.0)
    return np.where(inside, np.linalg.norm(y - one[:, None] * u - other[:, None] * v, axis=1), np.inf)


def segment_distances(a: np.ndarray, half_a: np.ndarray, b: np.ndarray, half_b: np.ndarray) -> np.ndarray:
    """Distances of segments ``a - half_a`` to ``a + half_a`` from segments ``b - half_b`` to ``b + half_b`` [m], (p,).

    The points that are nearest to each other are inside both segments, or one is an end: the least of five distances.
    """
    apart, dots = a - b, (half_a * half_b).sum(axis=1)
    square_a, square_b = (half_a * half_a).sum(axis=1), (half_b * half_b).sum(axis=1)
    found = []
    for one, own, other, its in ((a, half_a, b, half_b), (b, half_b, a, half_a)):
        found += [np.linalg.norm(end - feet(end, other, its), axis=1) for end in (one - own, one + own)]
    # (apart + s half_a - t half_b) is normal to both; parallel segments have an end that is nearest
    determinant = square_a * square_b - dots * dots
    with np.errstate(divide="ignore", invalid="ignore"):
        on_a, on_b = (apart * half_a).sum(axis=1), (apart * half_b).sum(axis=1)
        s = (dots * on_b - square_b * on_a) / determinant
        t = (square_a * on_b - dots * on_a) / determinant
        inside = (np.abs(s) <= 1.0) & (np.abs(t) <= 1.0)
        across = np.linalg.norm(apart + s[:, None] * half_a - t[:, None] * half_b, axis=1)
    found.append(np.where(inside, across, np.inf))
    return np.min(found, axis=0)


LONG = ("rod", "edge", "face", "line")
"""Kinds of contactors that are much smaller than the spheres around them."""
MEASURED = (*LONG, "sphere", "disk", "corner", "tip")
AT_ONCE = 200_000
"""How many pairs are measured together; more would take gigabytes."""


def are_long(one: str, other: str) -> bool:
    """Whether the distances of contactors of two kinds can be measured here, and are more than those of the spheres around
    them."""
    return one in MEASURED and other in MEASURED and (one in LONG or other in LONG)


def within_reach(pairs: np.ndarray, contactors: ContactorTable, placed: np.ndarray, reach: float) -> np.ndarray:
    """The pairs (p, 2) of contactors of two kinds, see :func:`are_long`, whose surfaces are within ``reach`` [m];
    ``placed``: positions of the contactors, (k, w).

    Pairs come from spheres around them, which are much larger. A rod or a surface moves no farther than the spheres at the
    ends of the rod, or the corners of the surface, so that a list of these pairs holds as long as one of spheres.
    """
    if len(pairs) > AT_ONCE:
        pieces = np.array_split(pairs, len(pairs) // AT_ONCE + 1)
        return np.concatenate([within_reach(piece, contactors, placed, reach) for piece in pieces])
    if not len(pairs):
        return pairs
    centre, faces = contactors.centres(placed), [contactors.kind[k] == "face" for k in pairs[0]]
    near = contactors.thickness[pairs].sum(axis=1) + reach
    d = contactors.offset.shape[1]
    if any(faces):
        face, other = (pairs[:, 0], pairs[:, 1]) if faces[0] else (pairs[:, 1], pairs[:, 0])
        return pairs[face_distances(centre[other, :3], contactors, placed, face) <= near]
    half = [half_lengths(contactors, placed, pairs[:, side]) for side in (0, 1)]
    middle = [centre[pairs[:, side], :d] for side in (0, 1)]
    return pairs[segment_distances(middle[0], half[0], middle[1], half[1]) <= near]


def half_lengths(contactors: ContactorTable, placed: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Vectors from the middles of rods, edges and lines to their ends [m], (p, d); zero for others. All are of one kind."""
    kind, shape, d = contactors.kind[which[0]], contactors.shape[which], contactors.offset.shape[1]
    if kind == "line":
        return in_plane(placed[which, 2], 0.5 * (shape[:, 11:13] - shape[:, 5:7]))
    if kind not in ("rod", "edge"):
        return np.zeros((len(which), d))
    half = shape[:, 1:4] if kind == "rod" else 0.5 * (shape[:, 4:7] - shape[:, 1:4])
    return in_space(placed[which, 3:], half) if placed.shape[1] == 7 else half


def face_distances(points: np.ndarray, contactors: ContactorTable, placed: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Distances of points (p, 3) from the triangles of faces [m], (p,), or less near their corners: the root of the squares
    of the distances from the plane and, in it, from the farthest side."""
    x, shape = points - placed[which, :3], contactors.shape[which]
    if placed.shape[1] == 7:
        x = in_own_axes(placed[which, 3:], x)
    z = ((x - shape[:, 6:9]) * shape[:, 3:6]).sum(axis=1)
    beyond = [((x - shape[:, at : at + 3]) * shape[:, at + 3 : at + 6]).sum(axis=1) for at in (6, 14, 22)]
    return np.hypot(z, np.maximum(0.0, np.max(beyond, axis=0)))
