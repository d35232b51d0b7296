"""Run-out and height of a heap against clouds of grains whose answer is known."""

import numpy as np
import pytest

from lmgcpy.experiment.column.course import dry_run_out, front, holding


def disk(radius, count=20_000):
    """Distances from the axis of points that fill a disk evenly: equal areas, equal numbers."""
    return radius * np.sqrt((np.arange(count) + 0.5) / count)


def test_of_a_disk_the_radius_holding_a_share_goes_as_its_root():
    distance = disk(3.0)
    for share in (0.5, 0.95, 0.99):
        # to the spacing of 20 000 points: 1/(2 n) of the radius
        assert holding(share, distance, np.ones(20_000)) == pytest.approx(3.0 * np.sqrt(share), rel=1e-4)


def test_of_a_square_half_is_within_its_diagonal_s_share():
    """Within a circle of radius r < a of a square of side 2 a lies pi r^2 / 4 a^2 of it."""
    x = (np.arange(400) + 0.5) / 400 - 0.5
    distance = np.hypot(*np.meshgrid(2.0 * x, 2.0 * x)).ravel()
    # a lattice of 400 points a side: 1/400 of the half side
    assert holding(0.5, distance, np.ones(160_000)) == pytest.approx(np.sqrt(2.0 / np.pi), abs=2.5e-3)


def test_of_a_cone_99_percent_lie_below_four_fifths_of_its_height():
    """Above z lies (1 - z/h)^3 of a cone; 1 % above 1 - 0.01^(1/3) = 0.785."""
    count = 100_000
    height = 2.0 * (1.0 - (1.0 - (np.arange(count) + 0.5) / count) ** (1.0 / 3.0))
    assert holding(0.99, height, np.ones(count)) == pytest.approx(2.0 * (1.0 - 0.01 ** (1.0 / 3.0)), rel=1e-4)


def test_mass_counts_and_not_number():
    distance, mass = np.array([3.0, 1.0, 2.0]), np.array([1.0, 98.0, 1.0])
    assert holding(0.98, distance, mass) == 1.0
    assert holding(0.985, distance, mass) == 2.0
    assert holding(1.0, distance, mass) == 3.0


def test_all_is_held_though_the_sum_is_rounded():
    mass = np.full(1000, 0.1)  # their sum depends on its order
    assert holding(1.0, np.arange(1000.0), mass) == 999.0


def test_the_front_is_where_a_layer_ends():
    """Grains of section s, evenly over a disk: their cover is n s / (pi R^2), here 0.8 of a layer, and two layers."""
    count = 20_000
    for cover in (0.8, 2.0):
        radii = np.full(count, 5.0 * np.sqrt(cover / count))
        assert front(disk(5.0, count), radii, 0.5) == pytest.approx(5.0, abs=0.15)  # of rings 0.5 wide


def test_the_front_lies_between_rings_by_their_covers():
    """Ring 0 is full, ring 1, three times its area, by 1/4: half is reached at 2/3 of the way between their middles."""
    radii = np.sqrt([1.0, 0.75])
    assert front(np.array([0.5, 1.5]), radii, 1.0) == pytest.approx(0.5 + 2.0 / 3.0)


def test_grains_that_ran_ahead_do_not_move_the_front():
    near, radii = disk(5.0, 5000), np.full(5000, 5.0 * np.sqrt(1.0 / 5000))
    alone = front(near, radii, 0.5)
    ahead = front(np.append(near, [9.0, 30.0]), np.append(radii, [0.2, 0.2]), 0.5)
    assert ahead == alone


def test_bare_ground_in_the_middle_has_no_front():
    assert front(np.array([7.0]), np.array([0.1]), 0.5) == 0.0


def test_the_law_of_dry_run_out():
    """1.24 a and 1.6 sqrt(a), which meet within 2 % where one gives way to the other."""
    assert dry_run_out(1.0) == pytest.approx(1.24)
    assert dry_run_out(4.0) == pytest.approx(3.2)
    assert dry_run_out(1.7 - 1e-9) == pytest.approx(dry_run_out(1.7), rel=0.02)
