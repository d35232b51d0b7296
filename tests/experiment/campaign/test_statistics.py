"""Means and their intervals against what is known of them, and groups of cases."""

import math

import numpy as np
import pytest
from made_up import case, to_come
from scipy import stats

from lmgcpy.experiment.campaign.cases import FAILED, CampaignResults
from lmgcpy.experiment.campaign.statistics import (
    groups,
    mean_and_band,
    mean_and_interval,
    mean_curves,
    mean_of_runs,
    resampled_means,
)

nan, inf = math.nan, math.inf


def normal(shape, seed):
    return np.random.default_rng(seed).normal(size=shape)


def test_mean_and_standard_error():
    """Of 1, 2, 3, 4: s² = 5/3, so that the error is sqrt(5/12)."""
    found = mean_and_interval([1, 2, 3, 4])
    assert (found.mean, found.count) == (2.5, 4)
    assert found.error == pytest.approx(math.sqrt(5 / 12), rel=1e-14)
    assert 1.0 <= found.low < 2.5 < found.high <= 4.0


@pytest.mark.parametrize("count", [5, 10, 30])
def test_the_spread_of_resamples_is_the_standard_error(count):
    """Their variance is (n - 1)/n of s²/n. That of 100000 resamples is found to 1/sqrt(200000) = 0.2 %; 1 % is far off."""
    values = normal(count, seed=count)
    spread = resampled_means(values[:, None], 0, 100_000).std()
    expected = mean_and_interval(values).error * math.sqrt((count - 1) / count)
    assert spread == pytest.approx(expected, rel=0.01)


def test_the_interval_of_many_values_is_that_of_the_normal_law():
    """Of 400 values: mean ± 1.96 standard errors. The quantiles of 5000 resamples scatter by sqrt(0.025 0.975 / 5000) /
    0.058 = 0.038 errors (0.058 is the normal density at 1.96); 0.12 is three times that."""
    values = 3.0 + normal(400, seed=1)
    found = mean_and_interval(values, resamples=5000)
    z = stats.norm.ppf(0.975)
    assert (found.low - found.mean) / found.error == pytest.approx(-z, abs=0.12)
    assert (found.high - found.mean) / found.error == pytest.approx(z, abs=0.12)


@pytest.mark.parametrize(("count", "measured"), [(3, 0.753), (5, 0.836), (10, 0.900), (30, 0.936)])
def test_coverage_is_what_the_docstring_says(count, measured):
    """Of 4000 samples, a part p scatters by sqrt(p (1 - p) / 4000) < 0.007: 0.02 is three times that. Student's t says
    nearly the same; resamples of 5 values have few different means, hence 0.025."""
    band = mean_and_band(normal((count, 4000), seed=[count, 2]), resamples=1000)
    held = np.mean((band.low <= 0.0) & (band.high >= 0.0))
    t = stats.norm.ppf(0.975) * math.sqrt((count - 1) / count)
    assert held == pytest.approx(measured, abs=0.02)
    assert held == pytest.approx(1.0 - 2.0 * stats.t.sf(t, count - 1), abs=0.025)


def test_the_same_seed_gives_the_same_interval():
    values = normal(7, seed=3)
    assert mean_and_interval(values) == mean_and_interval(values)
    assert mean_and_interval(values, seed=1) != mean_and_interval(values)


def test_a_band_is_the_intervals_of_its_places():
    rows = normal((6, 4), seed=5)
    band = mean_and_band(rows, seed=9)
    for k in range(4):
        found = mean_and_interval(rows[:, k], seed=9)
        for name in ("mean", "error", "low", "high"):  # sums of 6 products in another order
            assert getattr(band, name)[k] == pytest.approx(getattr(found, name), rel=1e-12, abs=1e-13)


def test_scale_and_shift():
    values = normal(8, seed=4)
    one, other = mean_and_interval(values), mean_and_interval(1e6 - 3.0 * values)
    # shift by 1e6: round-off 1e-10; the quantiles at 2.5 % and 97.5 % are symmetric, and so are the resamples' ranks
    assert other.mean == pytest.approx(1e6 - 3.0 * one.mean, abs=1e-8)
    assert other.error == pytest.approx(3.0 * one.error, rel=1e-8)
    assert (other.low, other.high) == pytest.approx((1e6 - 3.0 * one.high, 1e6 - 3.0 * one.low), abs=1e-8)


def test_one_value_has_no_interval():
    found = mean_and_interval([0.1])
    assert (found.mean, found.count) == (0.1, 1)
    assert all(math.isnan(value) for value in (found.error, found.low, found.high))


@pytest.mark.parametrize("value", [0.1, 0.0, -1e60, 1 / 3])
def test_equal_values_have_no_spread(value):
    """Exactly: not even that of round-off."""
    found = mean_and_interval([value] * 7)
    assert (found.mean, found.error, found.low, found.high) == (value, 0.0, value, value)


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({"values": [1.0, nan]}, ValueError, "values must be finite"),
        ({"values": [1.0, inf]}, ValueError, "values must be finite"),
        ({"values": []}, ValueError, "no mean of no values"),
        ({"values": 3.0}, ValueError, "values must be a list of numbers"),
        ({"values": ["a"]}, TypeError, "values must be numbers"),
        ({"values": [1.0], "level": 1.0}, ValueError, "level must be below 1"),
        ({"values": [1.0], "level": 0.0}, ValueError, "level must be above 0"),
        ({"values": [1.0], "resamples": 0}, ValueError, "resamples must be at least 1"),
        ({"values": [1.0], "seed": -1}, ValueError, "seed must be at least 0"),
    ],
)
def test_wrong_arguments(given, kind, words):
    with pytest.raises(kind, match=words):
        mean_and_interval(**given)


# ---------------------------------------------------------------------------------------------------------------- groups


def test_groups_are_of_finished_cases_and_differ_by_more_than_the_seed():
    cases = [case({"n": n, "axes": ("x",), "seed": seed}) for n in (200, 100) for seed in range(3)]
    cases[1] = to_come(cases[1].parameters)
    cases[5] = case(cases[5].parameters, status=FAILED)
    found = groups(CampaignResults("", cases))
    assert [group.parameters for group in found] == [{"n": 200, "axes": ("x",)}, {"n": 100, "axes": ("x",)}]
    assert [[each.parameters["seed"] for each in group.cases] for group in found] == [[0, 2], [0, 1]]


def test_groups_over_other_seeds():
    cases = [case({"n": n, "seed": seed, "noise": noise}) for n in (1, 2) for seed in (0, 1) for noise in (0, 1)]
    results = CampaignResults("", cases)
    assert len(groups(results)) == 4
    assert [len(group.cases) for group in groups(results, over_seeds=("seed", "noise"))] == [4, 4]
    assert [len(group.cases) for group in groups(results, over_seeds=("n", "seed", "noise"))] == [8]
    assert len(groups(results, over_seeds=())) == 8


def test_values_that_python_takes_for_equal_are_told_apart():
    values = [1, True, "1", 1.0, (1,), None, "None"]
    found = groups(CampaignResults("", [case({"n": value, "seed": k}) for k, value in enumerate(values)]))
    # 1, 1.0 and (1,) read alike, as in the names of cases
    assert [len(group.cases) for group in found] == [3, 1, 1, 1, 1]


# ----------------------------------------------------------------------------------------------------------- mean curves


def test_curves_are_interpolated_where_all_have_values():
    """Straight lines are interpolated without error: the mean of x and 3x is 2x, from the last begin to the first end."""
    runs = [(x, slope * x) for slope, x in ((1.0, np.linspace(0.1, 1.0, 11)), (3.0, np.linspace(0.0, 0.8, 23)))]
    x, band = mean_of_runs(runs)
    assert (x[0], x[-1], len(x), band.count) == (0.1, 0.8, 23, 2)
    np.testing.assert_allclose(band.mean, 2.0 * x, rtol=1e-13)
    np.testing.assert_allclose(band.error, x, rtol=1e-12)  # s = 2x / sqrt(2)
    np.testing.assert_allclose(band.high, 3.0 * x, rtol=1e-12)  # a quarter of the resamples holds the greater curve twice


def test_falling_abscissas_and_gaps():
    x = np.linspace(1.0, 0.0, 11)
    y = np.where(np.isclose(x, 0.5), nan, x)
    common, band = mean_of_runs([(x, y), (np.linspace(0.0, 1.0, 11), np.linspace(0.0, 1.0, 11))])
    assert (common[0], common[-1]) == (0.0, 1.0)
    assert np.isnan(band.mean[5])
    assert np.isfinite(band.mean[[0, 3, 7, 10]]).all()
    np.testing.assert_allclose(band.mean[7:], common[7:], rtol=1e-13)


def test_a_cycle_that_all_runs_share_keeps_its_course():
    x = np.array([0.0, 1.0, 0.5, 2.0])
    common, band = mean_of_runs([(x, x), (x, 3.0 * x)])
    assert (common == x).all()
    assert (band.mean == 2.0 * x).all()


def test_long_curves_are_thinned():
    x = np.arange(100_001.0)
    common, band = mean_of_runs([(x, x), (x, x)])
    assert (len(common), common[0], common[-1]) == (400, 0.0, 100_000.0)
    assert (band.mean == common).all()


@pytest.mark.parametrize(
    ("runs", "words"),
    [
        ([([0.0, 1.0], [0.0, 1.0]), ([2.0, 3.0], [0.0, 1.0])], "no part of the abscissa in common"),
        ([([0.0, 2.0, 1.0], [0.0, 1.0, 1.0]), ([2.0, 3.0], [0.0, 1.0])], "go to and fro"),
        ([([], []), ([], [])], "no place at which all runs have values"),
        ([([], []), ([1.0], [1.0])], "a run has no values"),
        ([([0.0, 1.0], [nan, 1.0]), ([0.0, 1.0], [1.0, nan])], "no place at which all runs have values"),
    ],
)
def test_curves_without_a_mean(runs, words):
    with pytest.raises(ValueError, match=words):
        mean_of_runs([(np.array(x), np.array(y)) for x, y in runs])


def test_mean_curves_by_group_and_test():
    x = np.linspace(0.0, 1.0, 5)

    def curves(slope):
        return {"a": {"strain": x, "q [Pa]": slope * x}, "b": {"time [s]": x, "q [Pa]": x, "v": x}}

    cases = [case({"n": n, "seed": seed}, curves=curves(n * seed)) for n in (1, 2) for seed in (1, 3)]
    del cases[0].curves["b"]
    found = {(of.abscissa, of.column): of for of in mean_curves(CampaignResults("", cases))}
    assert list(found) == [("strain", "q [Pa]"), ("time [s]", "q [Pa]"), ("time [s]", "v")]
    of_strain, of_time = found["strain", "q [Pa]"].curves, found["time [s]", "v"].curves
    assert [curve.labels for curve in of_strain] == [{"n": "1", "kind of test": "a"}, {"n": "2", "kind of test": "a"}]
    np.testing.assert_allclose(of_strain[1].band.mean, 4.0 * x, rtol=1e-13)
    assert [curve.band.count for curve in of_time] == [1, 2]


def test_groups_whose_curves_have_no_mean_are_named():
    cases = [case({"n": 1, "seed": k}, curves={"": {"x": np.array([k, k + 0.5]), "y": np.zeros(2)}}) for k in (0, 1)]
    (found,) = mean_curves(CampaignResults("", cases))
    assert found.curves == []
    assert found.left_out == ["y over x, n 1: the runs have no part of the abscissa in common."]
