"""Differences of curves and their noise: how often nothing is taken for something, and something for nothing."""

import math

import numpy as np
import pytest

from lmgcpy.experiment.study.resolved import LateDifference, difference, noise


def curves(count, length, memory, seed):
    """Noise of unit deviation that forgets in ``memory`` steps, (count, length)."""
    rng = np.random.default_rng(seed)
    keep = math.exp(-1.0 / memory)
    found = np.empty((count, length))
    found[:, 0] = rng.normal(size=count)
    for k in range(1, length):
        found[:, k] = keep * found[:, k - 1] + math.sqrt(1.0 - keep**2) * rng.normal(size=count)
    return found


@pytest.mark.parametrize(("memory", "most"), [(1, 0.065), (4, 0.10), (8, 0.17)])
def test_noise_is_resolved_in_one_of_twenty_cases(memory, most):
    """Windows of 80 steps, a fifth of a test. Deviators of tests remember two to six steps; the longer, the more often a
    bound is too small, as pieces of 16 steps remember each other."""
    one, other = curves(4000, 80, memory, 1), curves(4000, 80, memory, 2)
    told = np.mean([difference(a, b).resolved for a, b in zip(one, other, strict=True)])
    assert 0.03 < told < most


def test_a_difference_of_some_noise_is_resolved():
    one, other = curves(1000, 80, 4, 1), curves(1000, 80, 4, 2) + 2.0
    assert np.mean([difference(a, b).resolved for a, b in zip(one, other, strict=True)]) > 0.97


def test_a_trend_is_no_noise():
    assert noise(np.linspace(0.0, 1.0, 100)) < 1e-15
    assert noise(np.ones(9)) == math.inf


def test_a_change_that_is_known_bounds_as_well():
    flat = np.ones(50)
    assert difference(flat + 0.1, flat, 0.2) == LateDifference(pytest.approx(0.1), 0.2)
    assert not difference(flat + 0.1, flat, 0.2).resolved


def test_words_say_what_is_not_resolved():
    assert LateDifference(3100.0, 1200.0).words(1e3) == "+3.1 ± 1.2"
    assert LateDifference(-300.0, 1200.0).words(1e3) == "-0.3 ± 1.2, not resolved"
    assert LateDifference(3.0, 4.0).minus(LateDifference(1.0, 3.0)) == LateDifference(2.0, 5.0)
