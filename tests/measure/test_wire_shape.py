"""Persistence length and anisotropy of wires, against walks whose values are known."""

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.measure import wire_shape

STEP = 0.03


def walk(turns, start=0.3):
    """A chain in the plane whose links turn by these angles."""
    angles = start + np.concatenate([[0.0], np.cumsum(turns)])
    links = STEP * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.vstack([np.zeros(2), np.cumsum(links, axis=0)])


@pytest.mark.parametrize("greatest", [0.1, 0.6, 1.2, 2.0])
def test_a_free_walk_has_the_persistence_of_its_turns(greatest):
    """Turns uniform in [-a, a] have the mean cosine sin a / a; 2e5 turns know it to some 2e-3 of 1 - c."""
    rng = np.random.default_rng(1)
    shape = wire_shape(walk(rng.uniform(-greatest, greatest, 200_000)))
    assert shape.persistence_length == pytest.approx(-STEP / math.log(math.sin(greatest) / greatest), rel=0.02)


def test_a_straight_wire_and_one_that_folds_back():
    straight = wire_shape(np.outer(np.arange(5), [3.0, 0.0, 4.0]))
    assert straight.persistence_length > 1e12 * STEP  # infinite, but for rounding
    assert straight.anisotropy == pytest.approx(1.0, abs=1e-15)
    folded = wire_shape(walk(np.full(9, math.pi)))
    assert folded.persistence_length == 0.0
    assert folded.anisotropy == pytest.approx(1.0, abs=1e-12)


def test_anisotropy_is_the_mean_of_the_doubled_angle_in_2d():
    rng = np.random.default_rng(2)
    angles = rng.uniform(-0.7, 1.1, 40)
    points = np.vstack([np.zeros(2), np.cumsum(np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)])
    assert wire_shape(points).anisotropy == pytest.approx(abs(np.exp(2j * angles).mean()), rel=1e-12)


def test_several_wires_are_measured_together_but_not_from_end_to_start():
    """A quarter turn in a square, and no turn in a straight one; beads in any order."""
    square, straight = walk(np.full(3, math.pi / 2)), walk(np.zeros(3))
    points = np.vstack([square, straight + 7.0])[::-1]
    shape = wire_shape(points, [np.arange(9, 4, -1), np.arange(4, -1, -1)])
    assert shape.persistence_length == pytest.approx(STEP / math.log(2.0), rel=1e-12)  # c = (3 x 0 + 3 x 1) / 6
    assert shape.anisotropy == pytest.approx(0.5, rel=1e-12)


def test_the_laid_wire_of_a_study_has_no_preferred_direction():
    from lmgcpy.experiment import lay_sample

    sample = lay_sample(280, 60, seed=3)
    assert wire_shape(sample.positions, sample.chains).anisotropy < 0.1
    assert "persistence length" in repr(lm.measure.wire_shape(sample.positions, sample.chains))


def test_what_is_no_wire_is_refused():
    with pytest.raises(ValueError, match="no wire of these positions and chains has"):
        wire_shape(np.zeros((2, 2)))
    with pytest.raises(ValueError, match="no wire of these positions and chains has"):
        wire_shape(np.zeros((9, 2)), [])
    with pytest.raises(ValueError, match="are the same: their link"):
        wire_shape(np.zeros((3, 2)))
    with pytest.raises(ValueError, match=r"positions must be an array \(n, d\)"):
        wire_shape(np.zeros(3))
