"""Volumes of spheres cut by a box with faces along the axes: a sum over octants, each by the divergence theorem."""

from __future__ import annotations

import numpy as np


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
