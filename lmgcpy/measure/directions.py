"""Bins of directions by their angle to an axis, and means in them of what follows each other along wires."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, one_of, shown, vector, whole


@dataclass(frozen=True)
class DirectionBins:
    """Bins of the angle between a direction and an axis, from 0 to 90 degrees; a direction and its opposite count as one.

    In 2D the angle is divided evenly, in 3D its cosine, so that each bin has the same solid angle: isotropic directions
    fill all bins alike.
    """

    axis: np.ndarray
    """Unit vector, (d,)."""
    edges: np.ndarray
    """Bounds of the bins, ascending [degrees], (b + 1,)."""

    @classmethod
    def along(cls, axis: Any, bins: Any, dimension: int) -> DirectionBins:
        """So many ``bins`` of the angle to an ``axis``: "x", "y", "z" or a vector (d,), by default upward."""
        count = whole(bins, "bins", minimum=1, maximum=10_000)
        names = AXES[:dimension]
        if axis is None or isinstance(axis, str):
            unit = np.eye(dimension)[names.index(one_of(names[-1] if axis is None else axis, "axis", names))]
        else:
            given = vector(axis, "axis", dimension)
            size = float(np.linalg.norm(given))
            if size == 0.0:
                raise ValueError(f"axis must have a direction, got {shown(axis)}.")
            unit = given / size
        part = np.linspace(0.0, 1.0, count + 1)
        edges = 90.0 * part if dimension == 2 else np.degrees(np.arccos(1.0 - part))
        return cls(unit, edges)

    @property
    def count(self) -> int:
        """Number of bins b."""
        return len(self.edges) - 1

    def of(self, directions: np.ndarray) -> np.ndarray:
        """The bin of each unit vector (m, d): (m,)."""
        cosine = np.minimum(np.abs(directions @ self.axis), 1.0)
        part = np.arccos(cosine) / (0.5 * np.pi) if directions.shape[1] == 2 else 1.0 - cosine
        return np.minimum((part * self.count).astype(np.int64), self.count - 1)


def means_along(
    values: np.ndarray, bins: np.ndarray, count: int, chain: np.ndarray, reach: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of the values (m,) in each of ``count`` bins and its standard error, (count,) each; NaN in empty bins.

    Values that follow each other along a wire are not independent. The variance of the mean is the estimate of Newey and
    West (Econometrica 55, 1987): with r the values less their mean, over pairs of one bin and one chain,

        n^2 var = sum r_i^2 + 2 sum_k (1 - k/(K + 1)) sum_i r_i r_{i+k},    k = 1 ... K,

    times n/(n - 1), as the mean is taken from the same values. K is ``reach``, by default ``4 (m/100)^(2/9)`` (their rule
    of 1994), at most m - 1. If the correlation reaches beyond K, the variance is somewhat too small.
    """
    size = np.bincount(bins, minlength=count).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.bincount(bins, weights=values, minlength=count) / size
        rest = values - mean[bins]
        variance: np.ndarray = np.bincount(bins, weights=rest * rest, minlength=count)
        last = int(4.0 * (len(values) / 100.0) ** (2.0 / 9.0)) if reach is None else reach
        last = min(last, len(values) - 1)
        for k in range(1, last + 1):
            same = (bins[k:] == bins[:-k]) & (chain[k:] == chain[:-k])
            product = (rest[k:] * rest[:-k])[same]
            sums = np.bincount(bins[k:][same], weights=product, minlength=count)
            variance = variance + 2.0 * (1.0 - k / (last + 1)) * sums
        error = np.sqrt(np.maximum(variance, 0.0) * size / (size - 1.0)) / size
    return mean, np.where(size > 1, error, np.nan)
