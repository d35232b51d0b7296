"""Segments, the axes of rods: their nearest points and distances."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.positions import in_space


def feet(points: np.ndarray, middle: np.ndarray, half: np.ndarray) -> np.ndarray:
    """The points of segments from ``middle - half`` to ``middle + half`` (m, d) that are nearest to some points (m, d)."""
    square = (half * half).sum(axis=1)
    part = ((points - middle) * half).sum(axis=1) / np.where(square > 0.0, square, 1.0)
    return middle + np.clip(part, -1.0, 1.0)[:, None] * half


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


def within_reach(pairs: np.ndarray, contactors: ContactorTable, placed: np.ndarray, reach: float) -> np.ndarray:
    """The pairs (p, 2) of rods, or of a rod and a sphere, whose surfaces are within ``reach`` [m]; ``placed``: positions of
    the contactors, (k, 7).

    Pairs come from spheres around the rods, which are much larger. A rod moves no farther than the spheres at its ends, so
    that a list of these pairs holds as long as one of spheres.
    """
    half = [half_lengths(contactors, placed, pairs[:, side]) for side in (0, 1)]
    centre = [placed[pairs[:, side], :3] for side in (0, 1)]
    return pairs[segment_distances(centre[0], half[0], centre[1], half[1]) <= contactors.radius[pairs].sum(axis=1) + reach]


def half_lengths(contactors: ContactorTable, placed: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Vectors from the middles of rods to their ends [m], (p, 3); zero for spheres."""
    return np.where(contactors.rods[which, None], in_space(placed[which, 3:], contactors.shape[which, 1:4]), 0.0)
