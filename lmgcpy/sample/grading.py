"""Gradings: the radii of a sample drawn from a distribution of sizes."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy import errors
from lmgcpy.sample import arguments

WAYS = ("diameter", "mass")


@errors.named_arguments
def grading(
    grain_count: int,
    *,
    minimum: float | None = None,
    maximum: float | None = None,
    by: Any = "diameter",
    dimension: int = 2,
    seed: Any = 0,
) -> np.ndarray:
    """Radii of a graded sample [m], shape (grain_count,), in random order.

    ``by="diameter"``
        every diameter between 2 ``minimum`` and 2 ``maximum`` is equally frequent by number.
    ``by="mass"``
        every interval of diameters of the same width holds the same mass: the frequency by number goes as 1/D^d, with
        d = ``dimension`` (in 2D mass is area).
    ``by=curve``
        a size curve, array (rows, 2) of diameter [m] and fraction by mass that passes a sieve of this diameter, from 0
        in the first row to 1 in the last, straight in between. It brings its own sizes: leave ``minimum`` and
        ``maximum`` out.

    The draw is stratified: one radius from each of ``grain_count`` slices of equal probability, so that a sample of a
    few hundred grains follows its distribution far closer than independent draws would.

    ``minimum`` and ``maximum`` are radii [m]. ``seed``: whatever ``numpy.random.default_rng`` takes.

    Raises ValueError or TypeError where an argument makes no sense.
    """
    grain_count = errors.whole(grain_count, "grain_count", minimum=1)
    dimension = errors.whole(dimension, "dimension", minimum=2, maximum=3)
    rng = arguments.generator(seed)
    probability = rng.permutation((np.arange(grain_count) + rng.random(grain_count)) / grain_count)
    if isinstance(by, (list, tuple, np.ndarray)):
        if minimum is not None or maximum is not None:
            raise ValueError("a size curve brings its own sizes: leave minimum and maximum out.")
        diameters, passing = _size_curve(by)
        return 0.5 * _by_mass(probability, diameters, passing, dimension)
    by = errors.one_of(by, "by", WAYS)
    if minimum is None or maximum is None:
        raise ValueError(f"grading by {by} needs minimum and maximum, the smallest and the largest radius [m].")
    minimum = errors.number(minimum, "minimum", above=0.0, unit="m")
    maximum = errors.number(maximum, "maximum", above=0.0, unit="m")
    if minimum > maximum:
        raise ValueError(f"minimum must not exceed maximum, got {minimum:g} m and {maximum:g} m.")
    if minimum == maximum:
        return np.full(grain_count, minimum)
    if by == "diameter":
        radii = minimum + probability * (maximum - minimum)
    else:
        radii = _by_mass(probability, np.array([minimum, maximum]), np.array([0.0, 1.0]), dimension)
    return np.clip(radii, minimum, maximum)


def _size_curve(rows: Any) -> tuple[np.ndarray, np.ndarray]:
    """Diameters [m] and passing fractions of a size curve, checked."""
    curve = errors.numbers(rows, "the size curve")
    if curve.ndim != 2 or curve.shape[1] != 2 or len(curve) < 2:
        raise ValueError(
            f"a size curve must have two or more rows (diameter [m], passing fraction), got shape {curve.shape}."
        )
    diameters, passing = curve.T
    if diameters[0] <= 0.0 or (np.diff(diameters) <= 0.0).any():
        raise ValueError("the diameters of a size curve must be above zero and increase from row to row.")
    if (np.diff(passing) < 0.0).any():
        raise ValueError("the passing fractions of a size curve must not decrease from row to row.")
    if passing[0] != 0.0 or passing[-1] != 1.0:
        raise ValueError(
            "the passing fractions of a size curve must go from 0 (nothing is finer than the first diameter) to 1, "
            f"got {passing[0]:g} to {passing[-1]:g}; percentages are to be divided by 100."
        )
    return diameters, passing


def _by_mass(probability: np.ndarray, size: np.ndarray, passing: np.ndarray, dimension: int) -> np.ndarray:
    """Sizes of given cumulated probability by number, if the cumulated mass is linear between the knots.

    In an interval of slope m = d(passing)/dD the number of grains per size is m / D^d, its integral from D0 to D is
    m (D0^-e - D^-e) / e with e = d - 1, which is solved for D.
    """
    exponent = dimension - 1
    unit = size[-1]
    power = (size / unit) ** (-exponent)
    slope = np.diff(passing) / np.diff(size / unit)
    filled = slope > 0.0
    slope, start, end = slope[filled], power[:-1][filled], power[1:][filled]
    cumulated = np.concatenate(([0.0], np.cumsum(slope * (start - end))))
    target = probability * cumulated[-1]
    interval = np.clip(np.searchsorted(cumulated, target, side="right") - 1, 0, len(slope) - 1)
    inverse = start[interval] - (target - cumulated[interval]) / slope[interval]
    return unit * inverse ** (-1.0 / exponent)
