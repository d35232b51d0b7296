"""Directions of a wire network: quadratures of distributions on circle and sphere, and the links of a run.

A direction n and its opposite are the same. A rule is directions n_k and weights w_k with sum 1, so that the mean of a
function f over the distribution is ``sum_k w_k f(n_k)``. Rings of equal elevation about an axis are a product rule: equal
angles in the ring, and Gauss points of the distribution of the elevation. It is exact for polynomials of n up to a degree
of about ``2 sqrt(count)``. The positive part of ``n . eps . n`` has a kink, at which all rules are of lower order: see
:func:`quadrature_error`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eigh_tridiagonal

from lmgcpy.continuum.tensors import SIZE, check_dimension, dyads
from lmgcpy.errors import AXES, named_arguments, number, numbers, one_of, shown, whole

ISOTROPIC = 1.0 / math.sqrt(3.0)
"""Spread of directions that are isotropic in space."""
FLAT = 1e-6
"""Spread below which a layer is a plane."""
FINER = 8
"""Ratio of the numbers of directions of the finer rule and of the rule whose error is estimated."""
SEED = 7
"""Seed of the strains with which errors are estimated."""


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Directions:
    """Directions and the part of the wire's length that has each.

    ``units``: directions (k, d), taken to length 1; ``weights``: (k,), taken to sum 1. Raises TypeError or ValueError for
    other shapes, a direction of length zero, negative weights, or weights that are all zero.
    """

    units: np.ndarray
    weights: np.ndarray

    def __post_init__(self) -> None:
        units = numbers(self.units, "units", "directions (k, d)")
        weights = numbers(self.weights, "weights", "one number for each direction")
        if units.ndim != 2 or units.shape[1] not in SIZE or not len(units):
            raise ValueError(f"units must be directions of shape (k, 2) or (k, 3), got shape {units.shape}.")
        if weights.shape != (len(units),):
            raise ValueError(f"weights must be one number for each of the {len(units)} directions, got {weights.shape}.")
        if (weights < 0.0).any() or not weights.sum() > 0.0:
            raise ValueError(f"weights must be at least zero and not all zero, got {shown(self.weights)}.")
        lengths = np.linalg.norm(units, axis=1)
        if not lengths.min() > 0.0:
            raise ValueError(f"units must not be zero, but number {int(np.argmin(lengths))} is: it has no direction.")
        object.__setattr__(self, "units", units / lengths[:, None])
        object.__setattr__(self, "weights", weights / weights.sum())

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.units.shape[1]

    @property
    def products(self) -> np.ndarray:
        """Vectors of n (x) n in Mandel's notation, (k, m)."""
        return dyads(self.units)

    @property
    def fabric(self) -> np.ndarray:
        """Mean of n (x) n, (d, d); its trace is 1."""
        return (self.units * self.weights[:, None]).T @ self.units

    def __len__(self) -> int:
        return len(self.weights)

    def __repr__(self) -> str:
        parts = ", ".join(f"{value:.3g}" for value in np.diagonal(self.fabric))
        return f"<Directions: {len(self)} in {self.dimension}D, mean squares of the components {parts}>"


@named_arguments
def isotropic(dimension: int, count: int = 200) -> Directions:
    """All directions of the plane (2D) or of space (3D) alike, by about ``count`` directions."""
    if check_dimension(dimension) == 2:
        count = whole(count, "count", minimum=3, maximum=10**7)
        angles = np.pi * (np.arange(count) + 0.5) / count
        return Directions(np.stack([np.cos(angles), np.sin(angles)], axis=1), np.ones(count))
    return layers("z", ISOTROPIC, count)


@named_arguments
def in_plane(axis: str, count: int = 200) -> Directions:
    """All directions of the plane across ``axis`` alike, in 3D: layers without a spread."""
    return layers(axis, 0.0, count)


@named_arguments
def layers(axis: str, spread: float, count: int = 200) -> Directions:
    """Layers across ``axis`` ("x", "y" or "z"), in 3D, by about ``count`` directions.

    The density per solid angle is ``p(n) ~ cos(phi)^k``, phi the elevation of n above the layer. ``spread`` is the root
    mean square of sin(phi), the component of n along the axis; it gives ``k = 1/spread^2 - 3``. This family is taken, not
    a Gaussian of phi, because one number, a measured mean, determines it, and because it contains isotropy (spread
    1/sqrt3, k = 0) and the plane (spread 0); for a small spread the two agree. Between 1/sqrt3 and 1 directions gather
    about the axis (k < 0). Raises TypeError or ValueError with a sentence.
    """
    upright = AXES.index(one_of(axis, "axis", AXES))
    spread = number(spread, "spread", minimum=0.0)
    if spread >= 1.0:
        raise ValueError(f"spread must be below 1, where all directions lie along the axis, got {spread:g}.")
    count = whole(count, "count", minimum=8, maximum=10**7)
    # number of rings: their distance equals the distance of the directions in a ring
    rings = max(1, round(math.sqrt(0.25 * count * min(spread / ISOTROPIC, 1.0))))
    spread = spread if spread > FLAT else 0.0
    heights, shares = _elevations(spread, rings) if spread > 0.0 else (np.zeros(1), np.ones(1))
    # a direction and its opposite are the same: half a circle is enough
    around = 4 * max(2, round((count if spread > 0.0 else 2 * count) / (4 * len(heights))))
    ring = np.arange(len(heights))[:, None]
    # every second ring is turned by half a step; all keep the symmetry of reflections on the axes
    angles = 2.0 * np.pi * (np.arange(around)[None, :] + 0.5 * (ring % 2) + 0.5) / around
    flat = np.sqrt(1.0 - heights**2)[:, None]
    along = np.broadcast_to(heights[:, None], angles.shape)
    units = np.stack([flat * np.cos(angles), flat * np.sin(angles), along], axis=-1).reshape(-1, 3)
    if spread == 0.0:
        units = units[: around // 2]
    weights = np.repeat(shares, len(units) // len(shares))
    return Directions(np.roll(units, upright - 2, axis=1), weights)


def _elevations(spread: float, rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points z = sin(phi) > 0 and weights of the density ``(1 - z^2)^(k/2)`` (Golub and Welsch 1969).

    They are the positive half of a rule of 2 ``rings`` points, as the mean around the axis is even in z.
    """
    order = 0.5 * (1.0 / spread**2 - 2.0)  # of the Gegenbauer polynomials: (k + 1)/2
    n = np.arange(1, 2 * rings)
    with np.errstate(invalid="ignore", divide="ignore"):
        squares = n * (n + 2.0 * order - 1.0) / (4.0 * (n + order) * (n + order - 1.0))
    squares[0] = 0.5 / (1.0 + order)  # the formula at n = 1, also for order 0
    points, vectors = eigh_tridiagonal(np.zeros(2 * rings), np.sqrt(squares))
    return np.clip(points[rings:], 0.0, 1.0), vectors[0, rings:] ** 2


@named_arguments
def of_links(links: Any) -> Directions:
    """The directions of links of a run, given as vectors (k, d) [m]: each has its length over the sum of all as weight.

    Raises TypeError or ValueError for other shapes, or if a link has no length.
    """
    given = numbers(links, "links", "vectors (k, d) [m]")
    if given.ndim != 2:
        raise ValueError(f"links must be vectors of shape (k, 2) or (k, 3) [m], got shape {given.shape}.")
    return Directions(given, np.linalg.norm(given, axis=1))


def _means(rule: Directions, strains: np.ndarray) -> np.ndarray:
    """Mean of ``<n.eps.n>_+ n (x) n`` for strains (s, m), shape (s, m): the stress of the wire over L EA."""
    products = dyads(rule.units)
    return (np.maximum(strains @ products.T, 0.0) * rule.weights) @ products


@named_arguments
def quadrature_error(make: Callable[[int], Directions], count: int, finer: int = FINER) -> float:
    """Largest relative error of the wire's stress with ``make(count)``, against ``finer`` times as many directions.

    ``make`` gives a rule of about ``count`` directions, such as ``lambda count: layers("z", 0.1, count)``. The strains are
    compression and shear along the axes, and 20 strains without a symmetry. The error is the greatest length of a
    difference of the stresses, over the greatest length of all these stresses. Slack is zero.
    """
    count, finer = whole(count, "count", minimum=8), whole(finer, "finer", minimum=2)
    coarse, fine = make(count), make(count * finer)
    size = SIZE[coarse.dimension]
    rng = np.random.default_rng(SEED)
    strains = np.vstack([np.eye(size), -np.eye(size), rng.standard_normal((20, size))])
    strains /= np.linalg.norm(strains, axis=1)[:, None]
    reference = _means(fine, strains)
    difference = np.linalg.norm(_means(coarse, strains) - reference, axis=1)
    return float(difference.max() / np.linalg.norm(reference, axis=1).max())


@named_arguments
def choose_count(make: Callable[[int], Directions], error: float, most: int = 20_000) -> int:
    """Least of the counts 16, 32, 64 ... whose :func:`quadrature_error` is at most ``error``.

    Raises ValueError if that takes more than ``most`` directions.
    """
    error, count = number(error, "error", above=0.0), 16
    while quadrature_error(make, count) > error:
        count *= 2
        if count > most:
            raise ValueError(f"An error of {error:g} takes more than {most} directions: ask for a larger error.")
    return count
