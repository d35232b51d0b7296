"""Volumes of spheres cut by boxes, and the solid fraction in 3D."""

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

from lmgcpy.measure.density import density, disk_area_in_rectangle, sphere_volume_in_box

BALL = 4.0 / 3.0 * np.pi


def volume(centre, radius, low, high):
    return sphere_volume_in_box(np.array([centre], float), np.array([radius]), np.array(low), np.array(high))[0]


@pytest.mark.parametrize(
    ("centre", "radius", "window", "expected"),
    [
        ((0.5, 0.5, 0.5), 0.25, ((0, 0, 0), (1, 1, 1)), BALL / 64),  # inside
        ((0.0, 0.5, 0.5), 0.25, ((0, 0, 0), (1, 1, 1)), BALL / 128),  # half of it
        ((1.0, 0.0, 0.5), 0.25, ((0, 0, 0), (1, 1, 1)), BALL / 256),  # a quarter
        ((1.0, 1.0, 0.0), 0.25, ((0, 0, 0), (1, 1, 1)), BALL / 512),  # an eighth
        ((0.5, 0.5, 0.5), 2.0, ((0, 0, 0), (1, 1, 1)), 1.0),  # it covers the window
        ((2.0, 0.5, 0.5), 0.5, ((0, 0, 0), (1, 1, 1)), 0.0),  # outside
        ((1.2, 1.2, 0.5), 0.25, ((0, 0, 0), (1, 1, 1)), 0.0),  # its bounding box meets the window, the sphere does not
        ((0.5, 0.5, 0.5), 0.0, ((0, 0, 0), (1, 1, 1)), 0.0),  # no sphere
        # a cap of height h has the volume pi h² (1 - h/3)
        ((0.0, 0.0, -0.7), 1.0, ((-2, -2, 0), (2, 2, 2)), np.pi * 0.09 * 0.9),
        ((0.0, 0.0, 0.7), 1.0, ((-2, -2, 0), (2, 2, 2)), BALL - np.pi * 0.09 * 0.9),
        # a band: the sphere less two caps of height 1/2
        ((0.0, 0.0, 0.0), 1.0, ((-0.5, -2, -2), (0.5, 2, 2)), BALL - 2 * np.pi * 0.25 * 5 / 6),
        # a square hole through the sphere is all but four caps, as far as these do not meet: beyond sqrt(1/2)
        ((0.0, 0.0, 0.0), 1.0, ((-0.8, -0.8, -2), (0.8, 0.8, 2)), BALL - 4 * np.pi * 0.04 * 2.8 / 3),
    ],
)
def test_simple_volumes(centre, radius, window, expected):
    low, high = np.array(window, float)
    fraction = density([centre], [radius], window)
    # a few dozen roundings of numbers of order ten
    assert fraction * np.prod(high - low) == pytest.approx(expected, abs=1e-13)


@pytest.mark.long
def test_slices():
    """The volume is the integral of the area of the disk at height z in the rectangle, over z, by quadrature between the
    heights at which the disk meets a side or a corner; it is good to some 1e-12."""
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(100):
        centre, radius = rng.uniform(-1.0, 1.0, 3), rng.uniform(0.05, 1.2)
        low = rng.uniform(-1.0, 0.3, 3)
        high = low + rng.uniform(0.05, 1.2, 3)

        def area(z, centre=centre, radius=radius, low=low, high=high):
            square = max(radius**2 - (z - centre[2]) ** 2, 0.0)
            return disk_area_in_rectangle(centre[None, :2], np.array([np.sqrt(square)]), *low[:2], *high[:2])[0]

        bottom, top = max(low[2], centre[2] - radius), min(high[2], centre[2] + radius)
        sides = (np.array([low, high]) - centre)[:, :2] ** 2
        squares = np.concatenate((sides.ravel(), np.add.outer(sides[:, 0], sides[:, 1]).ravel()))
        meets = np.sqrt(radius**2 - squares[squares < radius**2])
        heights = np.unique(np.clip([bottom, *(centre[2] - meets), *(centre[2] + meets), top], bottom, max(bottom, top)))
        expected = sum(quad(area, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in itertools.pairwise(heights))
        worst = max(worst, abs(volume(centre, radius, low, high) - expected))
    assert worst < 1e-11


def test_windows_add_up():
    """Cut into 27 windows, a sphere loses nothing."""
    rng = np.random.default_rng(0)
    centres, radii = rng.uniform(-1.0, 1.0, (300, 3)), rng.uniform(0.01, 1.0, 300)
    cuts = np.array([[-3.0, -0.4, 0.1, 3.0], [-3.0, -0.2, 0.7, 3.0], [-3.0, 0.0, 0.05, 3.0]])
    axes = np.arange(3)
    parts = [
        sphere_volume_in_box(centres, radii, cuts[axes, index], cuts[axes, np.array(index) + 1])
        for index in np.ndindex(3, 3, 3)
    ]
    # each part is exact to some 1e-15 of the sphere's volume
    np.testing.assert_allclose(np.sum(parts, axis=0), BALL * radii**3, rtol=1e-13)
    assert np.min(parts) >= 0.0


def test_monte_carlo():
    """400 000 points: the standard error of a fraction is below 0.5/sqrt(4e5) = 8e-4; asked are five."""
    rng = np.random.default_rng(1)
    window = ((0.2, 0.1, 0.3), (1.0, 0.6, 0.9))
    points = rng.uniform(*window, (400_000, 3))
    for centre, radius in [((0.3, 0.2, 0.4), 0.15), ((0.9, 0.7, 0.8), 0.3), ((0.6, 0.3, 0.5), 0.38), ((0.1, 0, 0.2), 0.5)]:
        fraction = np.mean(((points - centre) ** 2).sum(axis=1) < radius**2)
        assert density([centre], [radius], window) == pytest.approx(fraction, abs=4e-3)


def test_lattice():
    """Touching spheres on a face-centred cubic lattice fill pi/sqrt(18) of any window of whole periods."""
    steps = np.stack(np.meshgrid(*[np.arange(-6, 14)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    centres = steps[steps.sum(axis=1) % 2 == 0].astype(float)
    window = np.array([[0.37, 0.21, -0.4], [4.37, 6.21, 1.6]])
    radii = np.full(len(centres), np.sqrt(0.5))
    assert density(centres, radii, window) == pytest.approx(np.pi / np.sqrt(18.0), rel=1e-13)


def test_nothing():
    assert density([], [], ((0, 0, 0), (1, 1, 1))) == 0.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"positions": [[0.0, 0.0]]}, r"density takes spheres in a window of 3 coordinates.*got \(1, 2\) and \(1,\)"),
        ({"window": ((0, 0, 0, 0), (1, 1, 1, 1))}, "two corners .* three coordinates each in 3D"),
        ({"window": ((0, 0, 1), (1, 1, 1))}, "from its lower left to its upper right corner"),
    ],
)
def test_wrong_input(wrong, words):
    with pytest.raises(ValueError, match=words):
        density(**{"positions": [[0.0, 0.0, 0.0]], "radii": [1.0], "window": ((0, 0, 0), (1, 1, 1)), **wrong})
