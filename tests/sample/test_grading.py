"""Gradings against their distributions."""

import numpy as np
import pytest

from lmgcpy.sample import grading


def passing(radii, size, dimension):
    """Fraction by mass of the grains finer than a diameter."""
    mass = radii**dimension
    return np.array([mass[2.0 * radii <= diameter].sum() for diameter in size]) / mass.sum()


def test_uniform_by_diameter():
    """The draw is stratified: n grains follow the straight cumulated number to 1/n."""
    n = 500
    radii = np.sort(grading(n, minimum=0.005, maximum=0.010, by="diameter", seed=3))
    assert radii[0] >= 0.005
    assert radii[-1] <= 0.010
    expected = 0.005 + 0.005 * (np.arange(n) + 0.5) / n
    np.testing.assert_allclose(radii, expected, atol=0.005 / n)


@pytest.mark.parametrize("dimension", [2, 3])
def test_uniform_by_mass(dimension):
    """The mass finer than D is (D - Dmin)/(Dmax - Dmin).

    In 3D with ratio 10 the coarsest of 2000 grains holds some 1 % of the mass, which bounds what any sample can do.
    """
    radii = grading(2000, minimum=0.001, maximum=0.010, by="mass", dimension=dimension, seed=1)
    size = np.linspace(0.002, 0.020, 10)
    np.testing.assert_allclose(passing(radii, size, dimension), np.linspace(0.0, 1.0, 10), atol=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
def test_size_curve(dimension):
    """A gap-graded curve: nothing between 4 and 6 mm, and the masses of the others as given."""
    curve = np.array([[0.002, 0.0], [0.004, 0.4], [0.006, 0.4], [0.008, 0.7], [0.010, 1.0], [0.012, 1.0]])
    radii = grading(3000, by=curve, dimension=dimension, seed=5)
    assert not ((radii > 0.00201) & (radii < 0.00299)).any()
    assert radii.max() <= 0.005
    # 3000 grains: one of the coarsest holds less than 0.3 % of the mass
    np.testing.assert_allclose(passing(radii, curve[:, 0] + 1e-12, dimension), curve[:, 1], atol=0.005)


def test_equal_sizes_and_seed():
    assert (grading(5, minimum=0.01, maximum=0.01, by="mass") == 0.01).all()
    a, b, c = (grading(50, minimum=0.005, maximum=0.010, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_order_is_random():
    """The radii come shuffled: no trend along the array (0.1 is 4.5 standard deviations of n = 2000)."""
    radii = grading(2000, minimum=0.005, maximum=0.010, seed=0)
    assert abs(np.corrcoef(np.arange(2000), radii)[0, 1]) < 0.1
