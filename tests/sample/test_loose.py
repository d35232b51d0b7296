"""The loose grid: no overlap, obstacles skipped, in 2D and 3D."""

import numpy as np

from lmgcpy.sample import grading, grid_positions, wire_2d


def least_gap(positions, radii):
    """Smallest gap between two bodies."""
    distance = np.linalg.norm(positions[:, None] - positions, axis=2)
    return (distance - np.add.outer(radii, radii))[np.triu_indices(len(radii), 1)].min()


def test_around_a_wire():
    radii = grading(400, minimum=0.005, maximum=0.010, seed=0)
    wire = wire_2d(box=(0.3, 0.3), bead_radius=0.0075, interstice=0.021, bead_count=60, seed=0)
    grains = grid_positions(radii, box=(0.3, None), obstacles=(wire.positions, wire.radii), seed=0)
    assert least_gap(np.vstack((grains, wire.positions)), np.concatenate((radii, wire.radii))) >= 0.0
    assert (grains >= radii[:, None]).all()
    assert (grains[:, 0] <= 0.3 - radii).all()
    # some grains lie below the wire, and not all above
    assert (grains[:, 1] < 0.3).sum() > 20


def test_spheres():
    radii = grading(300, minimum=0.005, maximum=0.010, by="mass", dimension=3, seed=0)
    bead = (np.array([[0.05, 0.05, 0.05]]), np.array([0.02]))
    grains = grid_positions(radii, box=(0.1, 0.12, None), obstacles=bead, seed=0)
    assert grains.shape == (300, 3)
    assert least_gap(np.vstack((grains, bead[0])), np.append(radii, bead[1])) >= 0.0
    assert (grains >= radii[:, None]).all()
    assert (grains[:, :2] <= np.array([0.1, 0.12]) - radii[:, None]).all()


def test_equal_grains_fill_whole_cells():
    """spacing=1: a box of 5 x 4 diameters takes twenty grains."""
    positions = grid_positions(np.full(20, 0.01), box=(0.1, 0.08), spacing=1.0)
    assert np.unique(np.round(positions, 9), axis=0).shape == (20, 2)


def test_seed_and_order():
    radii = grading(50, minimum=0.005, maximum=0.010)
    first, same, other = (grid_positions(radii, box=(0.1, None), seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    assert (first != other).any()
    given = grid_positions(radii, box=(0.1, None), order="given")
    assert given[:4, 1].max() < 0.0211
