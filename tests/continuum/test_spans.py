"""Spans of wire that share one tension."""

import numpy as np
import pytest
from scipy.optimize import minimize

from lmgcpy.continuum import Directions, Spans, WireNetwork, mandel, spans_of

L_SHAPE = np.array([[1.0, 0.0]] * 4 + [[0.0, 1.0]] * 4)
"""Eight links of 1 m, four along x and four along y."""


def test_spans_of_one_link_are_its_direction():
    rng = np.random.default_rng(0)
    units, lengths = rng.normal(size=(20, 3)), rng.uniform(0.5, 1.5, 20)
    short = spans_of(units, lengths, 0.0)
    local = Directions(units, lengths)
    np.testing.assert_allclose(short.products, local.products, rtol=0, atol=1e-14)  # sums of 20 terms of size 1
    np.testing.assert_allclose(short.weights, local.weights)


def test_spans_around_a_corner():
    """A span of 4 m around the middle of the third link has 2 + 0.5 m along x behind and ahead, and 0.5 m along y."""
    found = spans_of(L_SHAPE, np.ones(8), 4.0)
    np.testing.assert_allclose(found.products[2], [3.5 / 4, 0.5 / 4, 0.0], atol=1e-14)
    np.testing.assert_allclose(found.products[0], [1.0, 0.0, 0.0], atol=1e-14)  # at the end it lies to one side
    np.testing.assert_allclose(found.products[3], [2.5 / 4, 1.5 / 4, 0.0], atol=1e-14)


def test_spans_as_long_as_the_wire_are_its_fabric_and_do_not_leave_it():
    for width in (8.0, 100.0):
        np.testing.assert_allclose(spans_of(L_SHAPE, np.ones(8), width).products, [[0.5, 0.5, 0.0]] * 8, atol=1e-14)
    two = spans_of(L_SHAPE, np.ones(8), 100.0, chain=[0] * 4 + [1] * 4)
    np.testing.assert_allclose(two.products, [[1.0, 0.0, 0.0]] * 4 + [[0.0, 1.0, 0.0]] * 4, atol=1e-14)


def test_what_is_shortened_gives_way_to_what_is_lengthened():
    """Pure shear of a wire with as much along x as along y: locally a half of it pulls, as a whole it is not stretched."""
    shear = mandel(np.diag([0.01, -0.01]))
    whole = WireNetwork(8.0, 100.0, spans_of(L_SHAPE, np.ones(8), 8.0))
    local = WireNetwork(8.0, 100.0, spans_of(L_SHAPE, np.ones(8), 0.0))
    assert np.abs(whole.stress(shear)).max() < 1e-12 * 8.0 * 100.0 * 0.01
    np.testing.assert_allclose(local.stress(shear), [0.5 * 8.0 * 100.0 * 0.01, 0.0, 0.0], rtol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_a_span_has_the_energy_of_a_wire_that_slips_freely_between_its_ends(seed):
    """The least over the slips u of the joints of 12 links, zero at both ends; without slip it is the local model."""
    rng = np.random.default_rng(seed)
    units, lengths, strain = rng.normal(size=(12, 3)), rng.uniform(0.5, 1.5, 12), 0.1 * rng.normal(size=6)
    local = Directions(units, lengths)
    affine = local.products @ strain

    def energy(slip):
        stretch = affine + np.diff(slip, prepend=0.0, append=0.0) / lengths
        return 0.5 * float(lengths @ np.maximum(stretch, 0.0) ** 2)

    least = minimize(energy, np.zeros(11), tol=1e-12).fun
    whole = WireNetwork(lengths.sum(), 1.0, spans_of(units, lengths, 1e3)).energy(strain)
    assert whole == pytest.approx(least, rel=1e-6, abs=1e-9 * energy(np.zeros(11)))  # gradients are differences
    assert whole <= WireNetwork(lengths.sum(), 1.0, local).energy(strain)


def test_the_energy_is_convex_and_its_gradient_the_stress():
    rng = np.random.default_rng(1)
    units = np.cumsum(rng.normal(size=(60, 3)), axis=0)
    net = WireNetwork(10.0, 3.0, spans_of(units, np.ones(60), 7.0), slack=0.01)
    for _ in range(50):
        a, b = 0.1 * rng.normal(size=(2, 6))
        assert net.energy(0.5 * (a + b)) <= 0.5 * (net.energy(a) + net.energy(b)) + 1e-15
    step = 1e-6
    slope = [(net.energy(a + step * e) - net.energy(a - step * e)) / (2 * step) for e in np.eye(6)]
    np.testing.assert_allclose(slope, net.stress(a), atol=1e-7 * np.abs(net.stress(a)).max())  # second order of the step
    tangent = net.tangent(a)
    np.testing.assert_allclose(tangent, tangent.T, atol=1e-13 * np.abs(tangent).max())
    assert np.linalg.eigvalsh(tangent).min() >= -1e-12 * np.abs(tangent).max()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: spans_of([[1.0, 0.0]], [0.0], 1.0), "lengths must be 1 numbers above zero"),
        (lambda: spans_of([[0.0, 0.0]], [1.0], 1.0), "has no direction"),
        (lambda: spans_of([[1.0, 0.0]], [1.0], -1.0), "span"),
        (lambda: spans_of([[1.0, 0.0]], [1.0], 1.0, chain=[0, 1]), "chain must be one number"),
        (lambda: Spans([[1.0, 1.0, 0.0]], [1.0]), "trace 1"),
        (lambda: Spans([[1.0, 0.0, 0.0]], [-1.0]), "weights"),
        (lambda: WireNetwork(1.0, 1.0, "x"), "or Spans"),
    ],
)
def test_mistakes_get_sentences(call, words):
    with pytest.raises((TypeError, ValueError), match=words):
        call()
