"""Mean curves over the seeds: the curves of the cases of a group, brought to a common abscissa."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lmgcpy.experiment.campaign.results import CampaignResults
from lmgcpy.experiment.campaign.statistics import Band, CaseGroup, groups, mean_and_band
from lmgcpy.experiment.campaign.tables import all_keys
from lmgcpy.experiment.campaign.words import in_words

PLACES = 400
"""Most places of a mean curve: two or three a pixel."""
TEST = "kind of test"
"""Name of the test beside the parameters. No parameter has it, as theirs hold no blank."""


@dataclass(frozen=True)
class MeanCurve:
    """The mean of a column over the seeds of a group."""

    labels: dict[str, str]
    """The parameters of the group in words, and the test if it has a name."""
    abscissa: np.ndarray
    band: Band


@dataclass(frozen=True)
class MeanCurves:
    """All mean curves of a column."""

    abscissa: str
    """Its name, with the unit in brackets."""
    column: str
    curves: list[MeanCurve]
    left_out: list[str]
    """Sentences on the groups that have no mean curve."""


def mean_curves(results: CampaignResults) -> list[MeanCurves]:
    """Mean curves by abscissa and column, of all groups and tests that have them."""
    found: dict[tuple[str, str], MeanCurves] = {}
    for group in groups(results):
        for test in all_keys(case.curves for case in group.cases):
            labels = {name: in_words(value) for name, value in group.parameters.items()} | ({TEST: test} if test else {})
            for (abscissa, column), runs in _runs(group, test).items():
                of_column = found.setdefault((abscissa, column), MeanCurves(abscissa, column, [], []))
                try:
                    of_column.curves.append(MeanCurve(labels, *mean_of_runs(runs)))
                except ValueError as error:
                    which = ", ".join(f"{name} {word}" for name, word in labels.items()) or "all cases"
                    of_column.left_out.append(f"{column} over {abscissa}, {which}: {error}")
    return list(found.values())


def _runs(group: CaseGroup, test: str) -> dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray]]]:
    """Abscissas and values of the cases that have a column, by the names of the abscissa and of the column."""
    runs: dict[tuple[str, str], list[tuple[np.ndarray, np.ndarray]]] = {}
    for case in group.cases:
        curve = case.curves.get(test, {})
        abscissa, *columns = curve or [""]
        for column in columns:
            runs.setdefault((abscissa, column), []).append((curve[abscissa], curve[column]))
    return runs


def mean_of_runs(runs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, Band]:
    """Abscissa and mean of curves (abscissa, values) over the range that all of them have; NaN at places at which one has
    no value.

    Curves with different abscissas are interpolated, from the greatest beginning to the least end. ValueError is raised
    with a sentence if that cannot be done.
    """
    x, y = _on_common_abscissa(runs)
    there = np.isfinite(y).all(axis=0)
    if not there.any():
        raise ValueError("there is no place at which all runs have values.")
    found = mean_and_band(y[:, there])
    full = np.full((4, len(x)), np.nan)
    full[:, there] = found.mean, found.error, found.low, found.high
    mean, error, low, high = full
    return x, Band(mean, error, low, high, found.count)


def _on_common_abscissa(runs: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Abscissa (m,) and values (n, m) of n curves."""
    first = np.asarray(runs[0][0], dtype=float)
    if all(np.array_equal(first, x) for x, _ in runs):  # a cycle as well, whose abscissa goes back
        kept = np.unique(np.linspace(0, len(first) - 1, min(PLACES, len(first))).round().astype(int))
        return first[kept], np.array([np.asarray(y, dtype=float)[kept] for _, y in runs])
    rising = [_rising(np.asarray(x, dtype=float), np.asarray(y, dtype=float)) for x, y in runs]
    begin, end = max(x[0] for x, _ in rising), min(x[-1] for x, _ in rising)
    if begin > end:
        raise ValueError("the runs have no part of the abscissa in common.")
    places = min(PLACES, max(len(x) for x, _ in rising))
    common = np.linspace(begin, end, places if end > begin else 1)
    return common, np.array([np.interp(common, x, y) for x, y in rising])


def _rising(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve with a rising abscissa, without the places at which that is NaN."""
    there = np.isfinite(x)
    x, y = x[there], y[there]
    if not len(x):
        raise ValueError("a run has no values.")
    if x[0] > x[-1]:
        x, y = x[::-1], y[::-1]
    if (np.diff(x) < 0.0).any():
        raise ValueError("the abscissas of the runs differ and go to and fro, so that there is no mean.")
    return x, y
