"""The wire in 2D: its links, its room, its evenness."""

import numpy as np
import pytest

from lmgcpy.sample import wire_2d

PAPER = {"box": (0.67, 0.67), "bead_radius": 0.0075, "interstice": 0.021, "bead_count": 300}


def anisotropy(wire):
    """|mean exp(2i theta)| of the links: the deviator of their fabric, 0 for isotropic, 1 for parallel."""
    x, y = np.diff(wire.positions, axis=0).T
    return abs(np.mean(np.exp(2j * np.arctan2(y, x))))


def cells(wire, count, lengths=(0.67, 0.67)):
    """Beads in the cells of a coarse grid, relative to their mean."""
    number, _, _ = np.histogram2d(*wire.positions.T, bins=count, range=[[0.0, length] for length in lengths])
    return number / number.mean()


@pytest.mark.parametrize("clearance", [0.0, 0.004])
@pytest.mark.parametrize("seed", [0, 1])
def test_links_and_room(seed, clearance):
    wire = wire_2d(**PAPER, clearance=clearance, seed=seed)
    assert not wire.cut
    assert wire.bead_count == 300
    assert wire.positions.shape == (300, 2)
    assert (wire.radii == 0.0075).all()
    links = np.linalg.norm(np.diff(wire.positions, axis=0), axis=1)
    # round-off of positions of 0.67 m
    np.testing.assert_allclose(links, 0.036, atol=1e-15)
    assert wire.length == pytest.approx(299 * 0.036)
    assert wire.positions.min() >= 0.0075
    assert wire.positions.max() <= 0.67 - 0.0075
    distance = np.linalg.norm(wire.positions[:, None] - wire.positions, axis=2)
    distance[np.abs(np.subtract.outer(range(300), range(300))) < 2] = np.inf
    assert distance.min() >= 0.015 + clearance
    assert "300 beads" in str(wire)
    assert "cut" not in str(wire)


def test_turns():
    """theta_n - theta_(n-1) is within theta_max, but at rebounds, which are rare: a tenth of the links here.

    A wire of 10.8 m crosses a box of 0.67 m some 16 times and so meets a wall about every 19 links.
    """
    wire = wire_2d(**PAPER, theta_max=0.5, seed=2)
    x, y = np.diff(wire.positions, axis=0).T
    direction = np.arctan2(y, x)
    turn = np.abs((np.diff(direction) + np.pi) % (2.0 * np.pi) - np.pi)
    assert turn.max() <= 2.0 * np.pi / 3.0 + 1e-12
    assert np.mean(turn > 0.5 + 1e-12) < 0.1


def test_even_and_isotropic():
    """Over 20 seeds; measured over 80: see the docstring of wire_2d. Beads at random would give a variance of 1."""
    wires = [wire_2d(**PAPER, seed=seed) for seed in range(20)]
    filling = np.array([cells(wire, 4) for wire in wires])
    mean = 300 / 16
    assert filling.min() > 0.0
    assert np.mean([cell.min() for cell in filling]) > 0.55
    assert np.mean(filling.var(axis=(1, 2))) * mean < 1.1
    # no place is preferred: the mean over seeds of every cell, its standard error being some 0.05
    assert np.abs(filling.mean(axis=0) - 1.0).max() < 0.25
    assert np.mean([anisotropy(wire) for wire in wires]) < 0.06
    assert max(anisotropy(wire) for wire in wires) < 0.15


def test_no_preferred_direction():
    """The fabric tensor over 20 seeds is I/2: horizontal and vertical links are as many, and so are diagonals."""
    links = np.vstack([np.diff(wire_2d(**PAPER, seed=seed).positions, axis=0) for seed in range(20)]) / 0.036
    np.testing.assert_allclose(links.T @ links / len(links), 0.5 * np.eye(2), atol=0.02)


def test_plain_walk():
    """choices=1 is the walk of the paper; it is uneven, which is why it is not the default."""
    wires = [wire_2d(**PAPER, choices=1, seed=seed) for seed in range(10)]
    assert not any(wire.cut for wire in wires)
    assert np.mean([cells(wire, 4).var() for wire in wires]) * 300 / 16 > 2.0


def test_start_seed_and_single_bead():
    wire = wire_2d(**PAPER, start=(0.1, 0.2), seed=4)
    np.testing.assert_array_equal(wire.positions[0], (0.1, 0.2))
    np.testing.assert_array_equal(wire.positions, wire_2d(**PAPER, start=(0.1, 0.2), seed=4).positions)
    assert (wire.positions[1:] != wire_2d(**PAPER, start=(0.1, 0.2), seed=5).positions[1:]).any()
    single = wire_2d(**(PAPER | {"bead_count": 1}))
    assert single.positions.shape == (1, 2)
    assert single.length == 0.0


def test_cut():
    """Beads that touch make a fence: the wire shuts itself in, and says so."""
    wire = wire_2d(box=(0.2, 0.2), bead_radius=0.0075, interstice=0.0, bead_count=300, seed=0)
    assert wire.cut
    assert 20 < wire.bead_count < 300
    assert wire.length == pytest.approx((wire.bead_count - 1) * 0.015)
    assert f"bead {wire.bead_count + 1} of 300" in str(wire)
    distance = np.linalg.norm(wire.positions[:, None] - wire.positions, axis=2)[np.triu_indices(wire.bead_count, 1)]
    assert distance.min() >= 0.015 * (1.0 - 1e-12)


def test_cut_at_once():
    """Where no second bead has room, one is laid."""
    wire = wire_2d(box=(0.02, 0.02), bead_radius=0.0075, interstice=0.021, bead_count=3)
    assert wire.bead_count == 1
    assert wire.cut
