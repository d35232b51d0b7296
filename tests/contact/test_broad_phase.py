"""The grid of cells against all pairs."""

from __future__ import annotations

import numpy as np
import pytest

from lmgcpy.contact.broad_phase import Grid, near_pairs


def all_pairs(positions, radius, reach):
    """The pairs within reach, by looking at every pair."""
    i, j = np.triu_indices(len(positions), 1)
    distance = np.linalg.norm(positions[i] - positions[j], axis=1)
    near = distance <= radius[i] + radius[j] + reach
    return np.stack([i[near], j[near]], axis=1)


def check(positions, radius, reach):
    expected = all_pairs(positions, radius, reach)
    found = near_pairs(positions, radius, reach)
    assert found.tolist() == expected.tolist()
    return len(expected)


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0, 100.0])
@pytest.mark.parametrize("density", [0.001, 0.5, 20.0])
@pytest.mark.parametrize("seed", range(3))
def test_random_disks(ratio, density, seed):
    """Radii over a ratio of 1 to 100; discs covering a thousandth to twenty times the area (all overlapping)."""
    rng = np.random.default_rng(seed)
    count = 200
    radius = np.exp(rng.uniform(0.0, np.log(ratio), count)) if ratio > 1.0 else np.ones(count)
    side = np.sqrt(np.pi * (radius**2).sum() / density)
    positions = rng.uniform(-0.5, 0.5, (count, 2)) * side + rng.uniform(-5.0, 5.0, 2) * side
    for reach in (0.0, 0.1, 0.1 * side):
        found = check(positions, radius, reach)
    assert found > 0


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.6, -0.8)])
def test_collinear_disks(direction):
    """On a line the bounding box has no area, or one that says nothing of the spacing."""
    rng = np.random.default_rng(0)
    along = rng.permutation(300) * 2.05
    positions = along[:, None] * np.array(direction) + 1e3
    assert check(positions, np.ones(300), 0.1) == 299


def test_one_far_away():
    """A body that has left for 1e9 radii makes the cells wide, not the grid large."""
    rng = np.random.default_rng(0)
    positions = np.vstack([rng.uniform(0.0, 20.0, (100, 2)), [[1e9, -1e9]]])
    assert check(positions, np.ones(101), 0.2) > 50


def test_coincident_disks():
    """All at one point: every pair, more than fit into the first array of pairs (12 a disk)."""
    assert check(np.full((40, 2), 0.3), np.full(40, 0.1), 0.0) == 40 * 39 // 2


def test_touching_counts():
    """The bound is inclusive: binary fractions make the distance exact."""
    positions = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.25]])
    assert check(positions, np.ones(3), 0.25) == 2
    assert check(positions, np.ones(3), 0.2499) == 1


@pytest.mark.parametrize("count", [0, 1])
def test_nothing_to_pair(count):
    assert near_pairs(np.zeros((count, 2)), np.ones(count), 1.0).shape == (0, 2)


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("flat", [(), (2,), (0, 1)])
@pytest.mark.parametrize("seed", range(3))
def test_random_spheres(seed, flat):
    """In space, in a plane, and on a line along z: the box has no volume in the last two."""
    rng = np.random.default_rng(seed)
    positions = rng.uniform(-4.0, 4.0, (300, 3)) * (8.0 if len(flat) == 2 else 1.0)
    positions[:, list(flat)] = 0.5
    for reach in (0.0, 0.1, 3.0):
        assert check(positions, rng.uniform(0.1, 0.6, 300), reach) > 20


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("ratio", [4.0, 1000.0])
@pytest.mark.parametrize("seed", range(2))
def test_classes_of_sizes_boxes_and_held_circles(dimension, ratio, seed):
    """Few large circles among many small ones, each in a flat box: the pairs whose boxes are within reach too, and that are
    not both held."""
    rng = np.random.default_rng(seed)
    radius = np.where(rng.random(300) < 0.05, ratio, 1.0) * rng.uniform(0.5, 1.0, 300)
    positions = rng.uniform(0.0, 2.0 * 300 ** (1.0 / dimension), (300, dimension)) + 1e3
    box = radius[:, None] * rng.uniform(0.0, 1.0, (300, dimension))
    held = rng.random(300) < 0.4
    for reach in (0.0, 0.3):
        expected = check(positions, radius, reach)
        assert expected > 100
        i, j = all_pairs(positions, radius, reach).T
        meet = (np.abs(positions[i] - positions[j]) <= box[i] + box[j] + reach).all(axis=1)
        assert near_pairs(positions, radius, reach, box).tolist() == np.stack([i, j], axis=1)[meet].tolist()
        meet &= ~(held[i] & held[j])
        assert near_pairs(positions, radius, reach, box, held).tolist() == np.stack([i, j], axis=1)[meet].tolist()


def test_one_boulder_looks_at_few_cells():
    """Of 20 000 small disks the grid has as many cells as without the boulder, not one cell for all."""
    rng = np.random.default_rng(0)
    positions = np.vstack([rng.uniform(0.0, 200.0, (20_000, 2)), [[100.0, 300.0]]])
    radius = np.append(np.full(20_000, 0.5), 99.0)
    pairs = near_pairs(positions, radius, 0.1)
    alone = near_pairs(positions[:-1], radius[:-1], 0.1)
    assert pairs[pairs[:, 1] < 20_000].tolist() == alone.tolist()
    small = Grid(np.arange(20_000), np.column_stack([positions, 0.0 * radius]), radius, np.zeros((0, 3)), 0.1, 2)
    assert small.cell < 2.0
