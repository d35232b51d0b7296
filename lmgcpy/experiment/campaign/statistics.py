"""Means over seeds with their uncertainty, and the groups of cases that differ by their seed only.

The interval is the percentile interval of the bootstrap (B. Efron and R. J. Tibshirani, An Introduction to the Bootstrap,
Chapman & Hall 1993, chapters 6 and 13). A resample draws n values from the n values, with replacement; the interval lies
between quantiles of the means of many resamples.

The mean of a resample has the variance ``sum((x - mean)²) / n²`` exactly, which is ``(n - 1) / n`` of the squared standard
error ``s² / n``. So for large n the interval is the one of a normal law with this variance, and for small n it is too
narrow. It holds the true mean of normal values with about the probability ``P(|t| < 1.96 sqrt((n - 1) / n))`` of Student's
t with n - 1 degrees of freedom. Measured over 20000 samples, intervals of 95 % hold it in 75 % for n = 3, in 84 % for n =
5, in 90 % for n = 10 and in 94 % for n = 30; the formula gives 75, 85, 90 and 94 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import number, numbers, whole
from lmgcpy.experiment.campaign.results import CampaignResults, CaseResult
from lmgcpy.experiment.campaign.words import in_words


@dataclass(frozen=True)
class Estimate:
    """A mean and its uncertainty."""

    mean: float
    error: float
    """Standard error of the mean, ``s / sqrt(n)``; NaN of one value."""
    low: float
    high: float
    """Ends of the interval; NaN of one value."""
    count: int
    """Number of values."""


@dataclass(frozen=True)
class Band:
    """Means and their uncertainty at m places of a curve, each of shape (m,); see :class:`Estimate`."""

    mean: np.ndarray
    error: np.ndarray
    low: np.ndarray
    high: np.ndarray
    count: int
    """Number of curves."""


@dataclass(frozen=True)
class CaseGroup:
    """Finished cases that differ by their seed only."""

    parameters: dict[str, Any]
    """The parameters that they have in common."""
    cases: list[CaseResult]


def mean_and_interval(values: Any, seed: int = 0, resamples: int = 2000, level: float = 0.95) -> Estimate:
    """The mean of n values, its standard error, and its percentile bootstrap interval; the same for the same ``seed``.

    Intervals of few values are too narrow: an interval of 95 % from 5 normal values holds the true mean in 84 % of all
    samples, see the head of this module. A single value has neither an error nor an interval (NaN). TypeError and
    ValueError are raised for no values and for NaN.
    """
    column = numbers(values, "values", "numbers of which there is a mean")
    if column.ndim != 1:
        raise ValueError(f"values must be a list of numbers, got an array of shape {column.shape}.")
    band = mean_and_band(column[:, None], seed, resamples, level)
    return Estimate(float(band.mean[0]), float(band.error[0]), float(band.low[0]), float(band.high[0]), band.count)


def mean_and_band(curves: np.ndarray, seed: int = 0, resamples: int = 2000, level: float = 0.95) -> Band:
    """Mean, standard error and interval at every place of n curves, shape (n, m).

    A resample draws whole curves. The interval holds at each place for itself, not for all places at once.
    """
    rows = numbers(curves, "curves", "an array of n curves at m places")
    seed, resamples = whole(seed, "seed"), whole(resamples, "resamples", minimum=1)
    level = number(level, "level", above=0.0)
    if level >= 1.0:
        raise ValueError(f"level must be below 1, got {level:g}.")
    if rows.ndim != 2 or not len(rows):
        raise ValueError(f"There is no mean of no values: got an array of shape {rows.shape}.")
    first, deviations = rows[0], rows - rows[0]  # so equal values have exactly their value as their mean
    mean = first + deviations.mean(axis=0)
    if len(rows) == 1:
        none = np.full(rows.shape[1], np.nan)
        return Band(mean, none, none, none, 1)
    error = deviations.std(axis=0, ddof=1) / np.sqrt(len(rows))
    ends = (0.5 - 0.5 * level, 0.5 + 0.5 * level)
    low, high = first + np.quantile(resampled_means(deviations, seed, resamples), ends, axis=0)
    return Band(mean, error, low, high, len(rows))


def resampled_means(rows: np.ndarray, seed: int, resamples: int) -> np.ndarray:
    """Means of resamples of n rows, shape (resamples, m) from (n, m)."""
    count = len(rows)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), size=resamples)
    return drawn @ rows / count


def groups(results: CampaignResults, over_seeds: Sequence[str] = ("seed",)) -> list[CaseGroup]:
    """The finished cases by all their parameters but ``over_seeds``, in the order of their first cases."""
    found: dict[tuple, CaseGroup] = {}
    for case in results.finished:
        common = {name: value for name, value in case.parameters.items() if name not in over_seeds}
        # type and words, as 1 and True are equal in Python
        key = tuple(sorted((name, isinstance(value, str), in_words(value)) for name, value in common.items()))
        found.setdefault(key, CaseGroup(common, [])).cases.append(case)
    return list(found.values())
