"""Slabs across a periodic axis: a ring of an even number of slabs, however the cell leans."""

import numpy as np
import pytest

from lmgcpy.contact.lattice import Lattice
from lmgcpy.contact.slabs import LEAST_SLABS, cut_ring, partition


def leaning(dimension, axes, lean=0.45, seed=0):
    """A lattice with its edges (p, d), each with components up to ``lean`` of its length along all other axes."""
    edges = np.random.default_rng(seed).uniform(-lean, lean, (len(axes), dimension))
    edges[np.arange(len(axes)), axes] = np.linspace(1.0, 1.3, len(axes))
    return Lattice(np.arange(len(axes)), np.array(axes), dimension), edges


CELLS = [(2, (0, 1)), (2, (0,)), (3, (0, 1, 2)), (3, (0, 1)), (3, (1,))]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("dimension", "axes"), CELLS)
def test_coordinates_across_the_faces_differ_by_no_more_than_points_do(dimension, axes, seed):
    """|dy_a| <= |dx| up to the period, with equality at right angles to a face; images have the same coordinates."""
    lattice, edges = leaning(dimension, axes, seed=seed)
    rng = np.random.default_rng(seed)
    points = rng.uniform(-3.0, 3.0, (500, dimension))
    ways = rng.normal(0.0, 0.1, points.shape)
    shifts = rng.integers(-2, 3, (len(points), len(axes)))
    (here, period), (there, _) = (lattice.across(x, edges) for x in (points, points + ways + shifts @ edges))
    assert period[list(axes)] == pytest.approx(lattice.widths(edges))
    assert np.isinf(np.delete(period, axes)).all()
    apart = np.abs(there - here)
    apart = np.minimum(apart, np.abs(np.where(np.isfinite(period), period, 0.0) - apart))
    assert (apart <= np.linalg.norm(ways, axis=1)[:, None] + 1e-12).all()
    assert ((here[:, list(axes)] >= 0.0) & (here[:, list(axes)] <= period[list(axes)])).all()
    inverse = np.linalg.inv(lattice.basis(edges))
    normals = 0.01 * inverse / np.linalg.norm(inverse, axis=1)[:, None]
    inner = np.full((1, dimension), 0.5) @ lattice.basis(edges).T
    moved = lattice.across(inner + normals, edges)[0] - lattice.across(inner, edges)[0]
    assert np.diag(moved) == pytest.approx(np.full(dimension, 0.01))


def test_rings_are_even_of_about_equal_numbers_and_wide_enough():
    rng = np.random.default_rng(0)
    along = rng.beta(2.0, 3.0, 20_000)
    count, slab = cut_ring(along, 0.03, 1.0)
    assert count == 16  # one for 1250 points
    assert (np.diff(slab[np.argsort(along)]) >= 0).all()
    assert set(slab.tolist()) == set(range(count))
    starts = np.array([along[slab == s].min() for s in range(count)])
    assert np.diff(starts).min() > 0.03 - 2.0 / 1024
    assert 1.0 - starts[-1] > 0.03 - 1.0 / 1024
    assert np.bincount(slab).max() < 1.1 * 20_000 / count
    assert cut_ring(along[:5000], 0.03, 1.0)[0] == LEAST_SLABS


@pytest.mark.parametrize(("width", "count"), [(0.124, 8), (0.126, 6), (0.2, 4), (0.24, 4), (0.26, 1), (0.4, 1)])
def test_a_narrow_ring_has_fewer_slabs(width, count):
    """The greatest even number that fits; below four, one slab: each would lie on both sides of the other."""
    assert cut_ring((np.arange(4096) + 0.5) / 4096, width, 1.0)[0] == count


def test_points_in_few_places_leave_fewer_slabs():
    """All points in one place, or in two: no slab may be narrower than asked, and none may be empty."""
    assert cut_ring(np.full(100, 0.3), 0.01, 1.0)[0] == 1
    for along in (np.repeat([0.1, 0.6], 50), np.repeat([0.0, 1.0], 50), np.concatenate([np.zeros(99), [0.9]])):
        count, slab = cut_ring(along, 0.01, 1.0)
        assert count in (1, 4, 6, 8)
        assert slab.max() < count


@pytest.mark.parametrize(("dimension", "axes"), CELLS)
def test_near_points_are_in_one_slab_or_in_neighbours_on_the_ring(dimension, axes):
    """Points up to the width apart, across faces too. Slabs across an axis without an edge are no ring."""
    lattice, edges = leaning(dimension, axes, lean=0.3, seed=1)
    points = np.random.default_rng(2).uniform(-2.0, 2.0, (1500, dimension))
    width = 0.08
    at, period = lattice.across(points, edges)
    count, ring, slab, place = partition(at, width + 1.0 / 512, period)  # slabs end at the border of a bin
    assert count >= 4
    assert count % 2 == 0 or not ring
    assert sorted(place) == list(range(len(points)))
    assert (np.diff(slab[np.argsort(place)]) >= 0).all()
    one, other = np.triu_indices(len(points), 1)
    between = lattice.shortened(points[one] - points[other], edges)
    near = np.linalg.norm(between, axis=1) <= width
    assert near.sum() > 100
    apart = np.abs(slab[one[near]] - slab[other[near]])
    assert set(apart.tolist()) == ({0, 1, count - 1} if ring else {0, 1})
