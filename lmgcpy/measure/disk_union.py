"""Area that disks cover together, within a rectangle if there is one; exact for overlapping disks as well.

Green's theorem on the boundary of the covered area, ``A = 1/2 sum of the integrals of x dy - y dx``: the arcs of each
circle that lie in no other disk and within the rectangle, and the parts of the rectangle's sides in a disk. An arc of
radius r around c from the angle a to b gives ``r/2 (r (b - a) + c_x (sin b - sin a) - c_y (cos b - cos a))``.
"""

from __future__ import annotations

import numpy as np


def disk_union(
    centres: np.ndarray, radii: np.ndarray, low: np.ndarray | None = None, high: np.ndarray | None = None
) -> float:
    """Area [m^2] of the union of disks, ``centres`` (n, 2) and ``radii`` (n,) [m]; between two corners (2,) if given."""
    from scipy.spatial import cKDTree  # takes as long to import as the rest of lmgcpy

    there = np.flatnonzero(radii > 0.0)
    if not len(there):
        return 0.0
    x, r = centres[there], radii[there]
    origin = x.mean(axis=0)
    x = x - origin
    corners = None if low is None or high is None else (low - origin, high - origin)
    near = cKDTree(x).query_ball_point(x, r + r.max())
    total = sum(_arcs(i, x, r, [j for j in near[i] if j != i], corners) for i in range(len(r)))
    return total if corners is None else total + _sides(x, r, *corners)


def _arcs(i: int, x: np.ndarray, r: np.ndarray, others: list[int], corners: tuple[np.ndarray, np.ndarray] | None) -> float:
    """Part of the area from the circle of one disk."""
    hidden: list[tuple[float, float]] = []  # intervals of angles: middle, half of the width
    for j in others:
        dx, dy = x[j] - x[i]
        distance = float(np.hypot(dx, dy))
        if distance >= r[i] + r[j] or distance < r[i] - r[j]:
            continue
        if distance <= r[j] - r[i]:
            if distance < r[j] - r[i] or j < i:  # the first of two equal disks counts
                return 0.0
            continue
        cosine = (distance**2 + r[i] ** 2 - r[j] ** 2) / (2.0 * distance * r[i])
        hidden.append((float(np.arctan2(dy, dx)), float(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    if corners is not None:
        (x0, y0), (x1, y1) = corners - x[i]
        for middle, way in ((0.0, x1), (0.5 * np.pi, y1), (np.pi, -x0), (1.5 * np.pi, -y0)):
            if way <= -r[i]:
                return 0.0
            if way < r[i]:
                hidden.append((middle, float(np.arccos(way / r[i]))))
    turn = 2.0 * np.pi
    cuts = []
    for middle, half in hidden:
        first = (middle - half) % turn
        last = first + 2.0 * half
        cuts += [(first, last)] if last <= turn else [(first, turn), (0.0, last - turn)]
    area, at = 0.0, 0.0
    for first, last in [*sorted(cuts), (turn, turn)]:
        if first > at:
            sine, cosine = np.sin(first) - np.sin(at), np.cos(first) - np.cos(at)
            area += 0.5 * r[i] * (r[i] * (first - at) + x[i, 0] * sine - x[i, 1] * cosine)
        at = max(at, last)
    return float(area)


def _sides(x: np.ndarray, r: np.ndarray, low: np.ndarray, high: np.ndarray) -> float:
    """Part of the area from the sides of the rectangle: half of each side's distance times the length in disks."""
    area = 0.0
    for axis in (0, 1):
        along = 1 - axis
        for level, sign in ((low[axis], -1.0), (high[axis], 1.0)):
            cut = np.abs(x[:, axis] - level) < r
            half = np.sqrt((r[cut] - np.abs(x[cut, axis] - level)) * (r[cut] + np.abs(x[cut, axis] - level)))
            first = np.maximum(x[cut, along] - half, low[along])
            last = np.minimum(x[cut, along] + half, high[along])
            covered, at = 0.0, -np.inf
            for begin, end in sorted(zip(first.tolist(), last.tolist(), strict=True)):
                covered += max(0.0, end - max(begin, at))
                at = max(at, end)
            area += 0.5 * sign * level * covered
    return float(area)
