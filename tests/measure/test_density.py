"""Areas of disks cut by a rectangle."""

import numpy as np
import pytest

from lmgcpy.measure.density import density, disk_area_in_rectangle


@pytest.mark.parametrize(
    ("centre", "radius", "window", "area"),
    [
        ((0.5, 0.5), 0.25, ((0, 0), (1, 1)), np.pi / 16),  # inside
        ((0.0, 0.5), 0.25, ((0, 0), (1, 1)), np.pi / 32),  # half of it
        ((1.0, 1.0), 0.25, ((0, 0), (1, 1)), np.pi / 64),  # a quarter
        ((0.5, 0.5), 2.0, ((0, 0), (1, 1)), 1.0),  # it covers the window
        ((2.0, 0.5), 0.5, ((0, 0), (1, 1)), 0.0),  # outside
        ((1.2, 1.2), 0.25, ((0, 0), (1, 1)), 0.0),  # its bounding box meets the window, the disk does not
        ((0.5, -0.5), 1.0, ((-2, 0), (2, 2)), np.pi / 3 - np.sqrt(3) / 4),  # a cap of half height
        ((0.0, 0.0), 1.0, ((-0.5, -2), (0.5, 2)), np.pi / 3 + np.sqrt(3) / 2),  # a band: disk less two caps
        ((0.0, 0.0), 1.0, ((-0.1, -0.1), (0.1, 0.1)), 0.04),  # the window lies inside
        ((0.5, 0.5), 0.0, ((0, 0), (1, 1)), 0.0),  # no disk
    ],
)
def test_simple_areas(centre, radius, window, area):
    (x0, y0), (x1, y1) = window
    fraction = density([centre], [radius], window)
    # a few roundings of numbers of order one
    assert fraction * (x1 - x0) * (y1 - y0) == pytest.approx(area, abs=1e-14)


def test_windows_add_up():
    """Cut into windows, a disk loses nothing."""
    rng = np.random.default_rng(0)
    centres, radii = rng.uniform(-1.0, 1.0, (200, 2)), rng.uniform(0.01, 1.0, 200)
    x, y = np.array([-3.0, -0.4, 0.1, 3.0]), np.array([-3.0, -0.2, 0.7, 3.0])
    parts = [disk_area_in_rectangle(centres, radii, x[i], y[j], x[i + 1], y[j + 1]) for i in range(3) for j in range(3)]
    np.testing.assert_allclose(np.sum(parts, axis=0), np.pi * radii**2, rtol=1e-12)
    assert np.min(parts) >= 0.0


def test_monte_carlo():
    """400 000 points: the standard error of an area fraction is below 0.5/sqrt(4e5) = 8e-4; asked are five."""
    rng = np.random.default_rng(1)
    points = rng.uniform((0.2, 0.1), (1.0, 0.6), (400_000, 2))
    for centre, radius in [((0.3, 0.2), 0.15), ((0.9, 0.7), 0.3), ((0.6, 0.3), 0.38), ((0.1, 0.0), 0.5)]:
        fraction = np.mean(np.hypot(*(points - centre).T) < radius)
        assert density([centre], [radius], ((0.2, 0.1), (1.0, 0.6))) == pytest.approx(fraction, abs=4e-3)


def test_lattice():
    """A triangular lattice of touching disks has pi/(2 sqrt 3) in any window of whole periods."""
    i, j = np.meshgrid(np.arange(-5, 25), np.arange(-5, 25))
    centres = np.column_stack(((i + 0.5 * (j % 2)).ravel(), (np.sqrt(3) / 2 * j).ravel()))
    window = ((0.37, 0.21), (8.37, 0.21 + 4 * np.sqrt(3)))
    assert density(centres, np.full(900, 0.5), window) == pytest.approx(np.pi / (2 * np.sqrt(3)), rel=1e-13)


def test_nothing():
    assert density([], [], ((0, 0), (1, 1))) == 0.0


def lens(radius, half):
    """Area that two disks of this radius share, their centres 2 ``half`` apart."""
    return 2.0 * radius**2 * np.arccos(half / radius) - 2.0 * half * np.sqrt(radius**2 - half**2)


def test_what_clusters_share_counts_once():
    """Two disks, three through one point, one in another, and the same twice; cut by a window as well."""
    window, r = ((0.0, 0.0), (1.0, 1.0)), 0.1
    pair = [(0.45, 0.5), (0.55, 0.5)]
    assert density(pair, [r, r], window) == pytest.approx(2.0 * np.pi * r**2 - lens(r, 0.05), rel=1e-13)
    # the right half of the pair
    half = density(pair, [r, r], ((0.5, 0.0), (1.0, 1.0))) * 0.5
    assert half == pytest.approx(np.pi * r**2 - 0.5 * lens(r, 0.05), rel=1e-13)
    around = 0.5 + r * np.array([(np.cos(a), np.sin(a)) for a in 2.0 * np.pi * np.arange(3) / 3.0])
    # each pair shares a lens of centres r sqrt(3) apart; all three share the one point
    three = 3.0 * np.pi * r**2 - 3.0 * lens(r, 0.5 * np.sqrt(3.0) * r)
    assert density(around, [r] * 3, window) == pytest.approx(three, rel=1e-12)
    nested = density([(0.5, 0.5), (0.52, 0.5), (0.52, 0.5)], [0.2, 0.1, 0.1], window)
    assert nested == pytest.approx(np.pi * 0.04, rel=1e-13)


@pytest.mark.default_parameters("0")
@pytest.mark.parametrize("seed", range(3))
def test_unions_by_points(seed):
    """400 000 points: the standard error of an area fraction is below 8e-4; asked are five."""
    rng = np.random.default_rng(seed)
    centres, radii, window = rng.random((30, 2)), 0.02 + 0.15 * rng.random(30), ((0.2, 0.1), (0.8, 1.05))
    points = rng.uniform(*window, (400_000, 2))
    covered = np.zeros(len(points), dtype=bool)
    for centre, radius in zip(centres, radii, strict=True):
        covered |= ((points - centre) ** 2).sum(axis=1) < radius**2
    assert density(centres, radii, window) == pytest.approx(covered.mean(), abs=4e-3)


def test_spheres_that_share_much_are_told():
    """From 3.5 % of the smaller radius on, where two spheres share 5e-4 of one."""
    density([(0.4, 0.5, 0.5), (0.5966, 0.5, 0.5)], [0.1, 0.1], ((0, 0, 0), (1, 1, 1)))
    with pytest.warns(RuntimeWarning, match="that they share counts twice"):
        density([(0.4, 0.5, 0.5), (0.5964, 0.5, 0.5)], [0.1, 0.1], ((0, 0, 0), (1, 1, 1)))
    with pytest.warns(RuntimeWarning, match="that they share counts twice"):
        density([(0.4, 0.5, 0.5), (0.5, 0.5, 0.5)], [0.1, 0.1], ((0, 0, 0), (1, 1, 1)))
