"""Solid fraction in a window, from the exact areas of disks cut by a rectangle, or volumes of spheres cut by a box.

The area of overlapping disks follows from Green's theorem on the boundary of the covered area, ``A = 1/2 sum of the
integrals of x dy - y dx``: the arcs of each circle that lie in no other disk and within the rectangle, and the parts of the
rectangle's sides in a disk. An arc of radius r around c from the angle a to b gives
``r/2 (r (b - a) + c_x (sin b - sin a) - c_y (cos b - cos a))``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, numbers, shown, warn


@named_arguments
def density(positions: Any, radii: Any, window: Any) -> float:
    """Solid fraction [-] in a window: the area of the disks inside the rectangle over its own area; in 3D the volumes.

    If disks overlap by more than a hundredth of the smaller radius, as in clusters, their shared area counts once. The
    shared area of smaller overlaps counts twice, and so does the shared volume of spheres; if spheres overlap by more than
    3.5 %, the function warns. The volumes of clumps and capsules, with overlaps once, are in
    ``particle_stress(sim).volume``.

    ``positions`` [m], shape (n, d); ``radii`` [m], shape (n,); ``window`` the corners ((x0, y0), (x1, y1)) [m], lower
    left and upper right, in 3D ((x0, y0, z0), (x1, y1, z1)).

    The function raises ValueError if shapes do not match, a radius is negative or the window is empty; TypeError if an
    argument does not consist of numbers.

    A disk in a square, a quarter of which it fills:

    >>> import lmgcpy as lm
    >>> round(lm.measure.density([(1.0, 1.0)], [0.5], ((0.0, 0.0), (2.0, 2.0))), 6)
    0.19635
    """
    centres = numbers(positions, "positions")
    sizes = numbers(radii, "radii")
    corners = numbers(window, "window")
    if corners.shape not in ((2, 2), (2, 3)):
        raise ValueError(
            f"window must be two corners ((x0, y0), (x1, y1)) [m], got {shown(window)}; of three coordinates each in 3D."
        )
    dimension = corners.shape[1]
    if centres.size == 0:
        centres = centres.reshape(0, dimension)
    if centres.ndim != 2 or centres.shape[1] != dimension or sizes.shape != (len(centres),):
        raise ValueError(
            f"density takes {'disks' if dimension == 2 else 'spheres'} in a window of {dimension} coordinates: positions "
            f"must have shape (n, {dimension}) and radii (n,), got {centres.shape} and {sizes.shape}."
        )
    if (sizes < 0.0).any():
        where = int(np.argmax(sizes < 0.0))
        raise ValueError(f"radii must not be negative, but number {where} is {sizes[where]:g} m.")
    low, high = corners
    size = float(np.prod(high - low))
    if not ((low < high).all() and size > 0.0):
        raise ValueError(f"window must go from its lower left to its upper right corner, got {shown(window)}.")
    overlapping = _overlapping(centres, sizes, OVERLAP[dimension])
    if dimension == 3:
        if overlapping:
            warn(
                "Spheres overlap by more than 3.5 % of a radius: the volume that they share counts twice in this density. "
                "lmgcpy.measure.particle_stress(sim).volume has volumes of clumps."
            )
        return float(sphere_volume_in_box(centres, sizes, low, high).sum() / size)
    if overlapping:
        return disk_union(centres, sizes, low, high) / size
    return float(disk_area_in_rectangle(centres, sizes, *low, *high).sum() / size)


OVERLAP = {2: 1e-2, 3: 3.5e-2}
"""Overlap in parts of the smaller radius r, by dimension, below which the shared part counts twice.

Two equal disks share the part 4/(3 pi) (overlap/r)^(3/2) of a disk, two equal spheres 3/8 (overlap/r)^2: both 5e-4 here.
"""


def _overlapping(centres: np.ndarray, radii: np.ndarray, share: float) -> bool:
    """Whether two of the disks or spheres overlap by more than ``share`` of the smaller radius."""
    from scipy.spatial import cKDTree  # takes as long to import as the rest of lmgcpy

    there = radii > 0.0
    if there.sum() < 2:
        return False
    x, r = centres[there], radii[there]
    pairs = cKDTree(x).query_pairs(2.0 * r.max(), output_type="ndarray")
    depth = r[pairs].sum(axis=1) - np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
    return bool((depth > share * r[pairs].min(axis=1)).any())


def disk_area_in_rectangle(
    centres: np.ndarray, radii: np.ndarray, x0: float, y0: float, x1: float, y1: float
) -> np.ndarray:
    """Area of each disk inside the rectangle [m²], shape (n,): Q(x1, y1) - Q(x0, y1) - Q(x1, y0) + Q(x0, y0).

    Q(x, y) is the disk's area left of x and below y. Exact to round-off, some 1e-16 of the disk's own area.
    """
    unit = np.where(radii > 0.0, radii, 1.0)
    with np.errstate(over="ignore"):  # disks of almost no radius
        left, right = (x0 - centres[:, 0]) / unit, (x1 - centres[:, 0]) / unit
        below, above = (y0 - centres[:, 1]) / unit, (y1 - centres[:, 1]) / unit
    area = _quadrant(right, above) - _quadrant(left, above) - _quadrant(right, below) + _quadrant(left, below)
    return radii**2 * np.maximum(area, 0.0)


def _quadrant(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Area of the unit disk where x < a and y < b.

    With the corner (a, b) inside the disk the area is ab + (a sqrt(1-a²) + b sqrt(1-b²) + asin a + asin b)/2 + pi/4: the
    integral of b + sqrt(1-x²) from -sqrt(1-b²) to a, and the cap left of it. With the corner outside, the area is the
    disk less the caps beyond a and b, a cap alone, or zero.
    """
    a, b = np.clip(a, -1.0, 1.0), np.clip(b, -1.0, 1.0)
    # Area below a chord at height a, without its constant part pi/2.
    chord_a, chord_b = a * np.sqrt(1.0 - a * a) + np.arcsin(a), b * np.sqrt(1.0 - b * b) + np.arcsin(b)
    inside = a * b + 0.5 * (chord_a + chord_b) + 0.25 * np.pi
    outside = np.where(
        a > 0.0,
        np.where(b > 0.0, chord_a + chord_b, 0.5 * np.pi + chord_b),
        np.where(b > 0.0, 0.5 * np.pi + chord_a, 0.0),
    )
    return np.where(a * a + b * b < 1.0, inside, outside)


def sphere_volume_in_box(centres: np.ndarray, radii: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Volume of each sphere inside the box between two corners [m³], shape (n,).

    The alternating sum, over the corners of the box, of the sphere's volume in the octant beyond each. Exact to
    round-off, some 1e-15 of the sphere's own volume.

    ``centres`` [m], shape (n, 3); ``radii`` [m], shape (n,); ``low`` and ``high`` [m], shape (3,).
    """
    below, above = centres - radii[:, None], centres + radii[:, None]
    whole = (below >= low).all(axis=1) & (above <= high).all(axis=1)
    cut = ~whole & (above > low).all(axis=1) & (below < high).all(axis=1)
    volume = np.where(whole, 4.0 / 3.0 * np.pi * radii**3, 0.0)
    r, middle = radii[cut], centres[cut]
    with np.errstate(over="ignore"):  # spheres of almost no radius
        ends = (low - middle) / r[:, None], (high - middle) / r[:, None]
    part = np.zeros(len(r))
    for i, j, k in np.ndindex(2, 2, 2):
        part += (-1) ** (i + j + k) * _octant(ends[i][:, 0], ends[j][:, 1], ends[k][:, 2])
    volume[cut] = r**3 * np.maximum(part, 0.0)
    return volume


def _octant(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Volume of the unit ball where x > a, y > b and z > c.

    With the corner (a, b, c) inside the ball the octant is bounded by a spherical triangle and by pieces of the planes, at
    distances a, b, c from the ball's centre: V = (solid angle - a A_a - b A_b - c A_c)/3. With the corner outside, the
    volume is zero if a, b, c >= 0; otherwise the part beyond a < 0 is the whole less the mirror image of that beyond -a.
    """
    a, b, c = (np.clip(one, -1.0, 1.0) for one in (a, b, c))
    # Half chords of the ball along the three edges of the octant.
    along_x, along_y, along_z = _leg(b, c), _leg(c, a), _leg(a, b)
    total = np.full_like(a, -np.pi)
    for p, q, s, along_p, along_q, along_s in (
        (a, b, c, along_x, along_y, along_z),
        (b, c, a, along_y, along_z, along_x),
        (c, a, b, along_z, along_x, along_y),
    ):
        # Arc of the triangle at p. Gauss-Bonnet: solid angle = sum of the angles - pi - sum of p times arc.
        arc = np.arctan2(along_s, q) - np.arctan2(s, along_q)
        piece = 0.5 * ((1.0 - p * p) * arc - q * (along_s - s) - s * (along_q - q))
        total += np.arctan2(along_p, q * s) - p * arc - p * piece
    over_x = np.where(a < 0.0, _wedge(b, c), 0.0)
    over_y = np.where(b < 0.0, _wedge(np.abs(a), c), 0.0)
    over_z = np.where(c < 0.0, _wedge(np.abs(a), np.abs(b)), 0.0)
    outside = over_x + np.where(a < 0.0, -1.0, 1.0) * (over_y + np.where(b < 0.0, -1.0, 1.0) * over_z)
    return np.where(a * a + b * b + c * c < 1.0, total / 3.0, outside)


def _wedge(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Volume of the unit ball where x > a and y > b, by the same theorem."""
    along = _leg(a, b)
    total = 2.0 * np.arctan2(along, a * b)
    for p, q in ((a, b), (b, a)):
        arc = 2.0 * np.arctan2(along, q)
        total -= p * arc + p * (0.5 * (1.0 - p * p) * arc - q * along)
    outside = np.where(a < 0.0, _cap(b), 0.0) + np.where(a < 0.0, -1.0, 1.0) * np.where(b < 0.0, _cap(np.abs(a)), 0.0)
    return np.where(a * a + b * b < 1.0, total / 3.0, outside)


def _cap(a: np.ndarray) -> np.ndarray:
    """Volume of the unit ball where x > a."""
    return np.pi / 3.0 * (1.0 - a) ** 2 * (2.0 + a)


def _leg(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Half the chord of the unit ball at (a, b)."""
    return np.sqrt(np.maximum(1.0 - a * a - b * b, 0.0))


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
