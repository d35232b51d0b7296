"""Directions and tensions of links against sums that are known."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from lmgcpy.experiment.biaxial import Frame
from lmgcpy.experiment.texsol.conclusions import cone_ratio, extended_cone, link_directions

WALLS = np.array([0.0, 1.0, 0.0, 1.0])


def frame(angles, forces, length=0.02):
    """Links of a chain of beads at these angles, one a step, with these forces (compression positive)."""
    links = length * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    beads = np.vstack([np.zeros(2), np.cumsum(links, axis=0)])
    acting = np.asarray(forces) != 0.0
    lines = np.stack([beads[:-1], beads[1:]], axis=1)[acting]
    return Frame(0.1, 1.0, beads, WALLS, lines, np.asarray(forces, float)[acting], np.ones(int(acting.sum()), bool))


@pytest.mark.parametrize("degrees", [10.0, 30.0, 45.0, 60.0, 90.0])
def test_equal_tensions_within_a_cone_leave_the_ratio_of_the_formula(degrees):
    """1e4 directions, evenly spaced: the mid-point rule is exact to 1e-8 for these smooth integrands."""
    bound = math.radians(degrees)
    angles = bound * (2.0 * (np.arange(10_000) + 0.5) / 10_000 - 1.0)
    found = link_directions([frame(angles, np.full(10_000, -3.0))], [np.arange(10_001)])
    assert found.equal == pytest.approx(cone_ratio(bound), abs=1e-7)


def test_the_ratio_of_45_degrees_is_that_of_the_integral():
    assert cone_ratio(math.pi / 4) == pytest.approx((math.pi / 2 - 1) / (math.pi / 2 + 1), rel=1e-14)  # 0.2220
    assert cone_ratio(math.pi / 2) == pytest.approx(1.0, rel=1e-14)
    assert cone_ratio(0.0) == 0.0


def test_pulled_pushed_and_slack_links_are_counted_by_angle():
    """Angles in any quadrant count by their distance to x; a link without a force is one, but not taut."""
    degrees = np.array([5.0, 175.0, -85.0, 45.0, 225.0])
    found = link_directions([frame(np.radians(degrees), [-2.0, 0.0, 4.0, -1.0, 0.0])], [np.arange(6)], bins=3)
    assert found.links.tolist() == [2, 2, 1]
    assert found.taut.tolist() == [1, 1, 0]
    assert found.taut_share.tolist() == [0.5, 0.5, 0.0]
    np.testing.assert_allclose(found.pulled, [0.04, 0.02, 0.0], rtol=1e-12)
    np.testing.assert_allclose(found.pushed, [0.0, 0.0, 0.08], rtol=1e-12)


def test_two_frames_are_added_and_no_tension_leaves_no_ratio():
    one = frame(np.zeros(3), [0.0, 0.0, 1.0])
    found = link_directions([one, one], [np.arange(4)])
    assert found.links.sum() == 6
    assert math.isnan(found.equal)
    assert math.isnan(found.taut_share[-1])


def test_directions_that_are_extended():
    """At constant area the bound is that of no extension, where (l cos a)^2 + (sin a / l)^2 = 1: tan a = l."""
    stretch = 1.07
    record = SimpleNamespace(strain=np.array([0.0, 0.05, 0.1]), size=np.array([[2, 2], [1, 1], [stretch, 1 / stretch]]))
    assert math.tan(extended_cone(record, 0.05)) == pytest.approx(stretch, rel=1e-12)
    squeezed = SimpleNamespace(strain=np.array([0.0, 0.1]), size=np.array([[1.0, 1.0], [0.9, 0.9]]))
    assert extended_cone(squeezed, 0.0) == 0.0
