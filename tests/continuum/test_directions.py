"""Quadratures of directions against means that are known, and tensors as vectors."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lmgcpy.continuum import (
    Directions,
    choose_count,
    in_plane,
    isotropic,
    layers,
    mandel,
    of_links,
    quadrature_error,
    tensor_of,
    turn,
)
from lmgcpy.continuum.tensors import dyads


def rotation(rng, dimension):
    """A random rotation."""
    q, _ = np.linalg.qr(rng.standard_normal((dimension, dimension)))
    return q * np.sign(np.linalg.det(q))


@pytest.mark.parametrize("dimension", [2, 3])
def test_vectors_keep_products_and_turn_with_space(dimension):
    rng = np.random.default_rng(0)
    a, b = (m + np.swapaxes(m, 1, 2) for m in rng.standard_normal((2, 5, dimension, dimension)))
    np.testing.assert_allclose(tensor_of(mandel(a)), a, rtol=1e-14)
    np.testing.assert_allclose((mandel(a) * mandel(b)).sum(axis=1), (a * b).sum(axis=(1, 2)), rtol=1e-12, atol=1e-13)
    R = rotation(rng, dimension)
    np.testing.assert_allclose(mandel(a) @ turn(R).T, mandel(R @ a @ R.T), atol=1e-13)
    np.testing.assert_allclose(turn(R) @ turn(R).T, np.eye(dimension * (dimension + 1) // 2), atol=1e-14)


def test_a_dyad_measures_the_strain_of_its_direction():
    rng = np.random.default_rng(1)
    n, strain = rng.standard_normal((4, 3)), rng.standard_normal((3, 3))
    strain += strain.T
    np.testing.assert_allclose(dyads(n) @ mandel(strain), np.einsum("ki,ij,kj->k", n, strain, n), rtol=1e-12)


@pytest.mark.parametrize("count", [3, 8, 50])
def test_isotropy_in_the_plane_to_the_degree_of_the_rule(count):
    """Polynomials of n below degree 2 count are exact: <x^2> = 1/2, <x^4> = 3/8."""
    rule = isotropic(2, count)
    np.testing.assert_allclose(rule.fabric, np.eye(2) / 2, atol=1e-15)
    assert rule.weights @ rule.units[:, 0] ** 4 == pytest.approx(3 / 8, rel=1e-14)


@pytest.mark.parametrize("count", [32, 200, 1000])
def test_isotropy_in_space_to_the_fourth_moment(count):
    """<z^2> = 1/3, <z^4> = 1/5, <x^2 y^2> = 1/15; about so many directions."""
    rule = isotropic(3, count)
    assert len(rule) == pytest.approx(count, rel=0.15)
    np.testing.assert_allclose(rule.fabric, np.eye(3) / 3, atol=1e-14)
    for axis in range(3):
        assert rule.weights @ rule.units[:, axis] ** 4 == pytest.approx(1 / 5, rel=1e-12)
    assert rule.weights @ (rule.units[:, 0] * rule.units[:, 1]) ** 2 == pytest.approx(1 / 15, rel=1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("spread", [0.0, 0.01, 0.1, 0.4, 1 / math.sqrt(2), 0.9])
def test_layers_have_the_spread_that_was_asked_for(axis, spread):
    """<z^2> = spread^2 and, from the density cos^k, <z^4> = 3 s^4 / (1 + 2 s^2): by parts in the mean of z^2 (1 - z^2)."""
    rule = layers(axis, spread, 300)
    along = rule.units[:, "xyz".index(axis)]
    expected = (1.0 - spread**2) / 2.0 * np.ones(3)
    expected["xyz".index(axis)] = spread**2
    np.testing.assert_allclose(rule.fabric, np.diag(expected), atol=1e-13)
    if len(np.unique(np.round(along, 9))) > 1:
        assert rule.weights @ along**4 == pytest.approx(3 * spread**4 / (1 + 2 * spread**2), rel=1e-10)


def test_layers_join_the_plane_and_isotropy():
    np.testing.assert_allclose(layers("y", 1 / math.sqrt(3), 200).units, np.roll(isotropic(3, 200).units, 2, axis=1))
    assert not in_plane("y", 40).units[:, 1].any()
    assert len(in_plane("y", 40)) == 40


def test_a_small_spread_is_a_gaussian_of_the_elevation():
    """The fourth moment of a Gaussian is 3 s^4; cos^k has 3 s^4 / (1 + 2 s^2)."""
    rule = layers("z", 0.05, 2000)
    assert rule.weights @ rule.units[:, 2] ** 4 == pytest.approx(3 * 0.05**4, rel=3 * 0.05**2)


@pytest.mark.parametrize(
    ("make", "order"),
    [(lambda n: isotropic(2, n), 2.0), (lambda n: in_plane("x", n), 2.0), (lambda n: isotropic(3, n), 1.0)],
)
def test_the_error_of_the_stress_falls_with_the_square_of_the_distance_of_directions(make, order):
    """The stress has a kink, so an error of the distance squared: ~ 1/count^2 on the circle, ~ 1/count on the sphere."""
    counts = np.array([50, 100, 200, 400, 800])
    errors = [quadrature_error(make, int(count)) for count in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-order, abs=0.35)
    assert errors[2] < 4e-3


def test_the_estimated_error_is_that_against_a_much_finer_rule():
    def make(count):
        return layers("z", 0.2, count)

    assert quadrature_error(make, 200) == pytest.approx(quadrature_error(make, 200, finer=100), rel=0.3)


def test_a_count_for_an_error():
    def make(count):
        return isotropic(2, count)

    count = choose_count(make, 1e-4)
    assert quadrature_error(make, count) <= 1e-4 < quadrature_error(make, count // 2)
    with pytest.raises(ValueError, match="takes more than 100 directions: ask for a larger error"):
        choose_count(make, 1e-9, most=100)


def test_links_count_by_their_length():
    rule = of_links([[3.0, 0.0], [0.0, -1.0]])
    np.testing.assert_allclose(rule.weights, [0.75, 0.25])
    np.testing.assert_allclose(rule.fabric, np.diag([0.75, 0.25]))
    assert repr(rule) == "<Directions: 2 in 2D, mean squares of the components 0.75, 0.25>"


@given(st.integers(8, 3000), st.floats(0.0, 0.99))
def test_weights_are_a_distribution_and_units_have_length_one(count, spread):
    rule = layers("x", spread, count)
    assert rule.weights.min() >= 0.0
    assert rule.weights.sum() == pytest.approx(1.0, abs=1e-13)
    np.testing.assert_allclose(np.linalg.norm(rule.units, axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(rule.weights @ rule.units[:, 1] * 0.0, 0.0)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: Directions([[1.0, 0.0], [0.0, 0.0]], [1.0, 1.0]), "units must not be zero, but number 1 is"),
        (lambda: Directions([[1.0, 0.0]], [-1.0]), "weights must be at least zero"),
        (lambda: Directions([[1.0, 0.0]], [1.0, 1.0]), "one number for each of the 1 directions"),
        (lambda: Directions([1.0, 0.0], [1.0]), "directions of shape"),
        (lambda: layers("a", 0.1), "axis cannot be 'a'"),
        (lambda: layers("z", 1.0), "spread must be below 1"),
        (lambda: isotropic(4), "dimension must be at most 3"),
        (lambda: isotropic(2, 2), "count must be at least 3"),
        (lambda: of_links([1.0, 2.0]), "links must be vectors"),
        (lambda: of_links([[0.0, 0.0]]), "weights must be at least zero and not all zero"),
        (lambda: mandel([[0.0, 1.0], [0.0, 0.0]]), "tensor must be symmetric"),
        (lambda: mandel([1.0]), "tensor must be of shape"),
        (lambda: tensor_of([1.0, 2.0]), "3 components in 2D and 6 in 3D, got 2"),
    ],
)
def test_bad_arguments_are_sentences(call, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence) as caught:
        call()
    assert str(caught.value).endswith(".")
