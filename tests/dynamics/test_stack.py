"""A stack at rest: who carries what, and how fast the solver knows it again."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

COUNT, R, M, G, H = 10, 0.05, 3.0, 9.81, 1e-3


def build(tolerance):
    """Ten disks on each other on a floor; returns (simulation, floor)."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(COUNT):
        scene.add(lm.disk(radius=R, position=(0.0, R + 2.0 * R * i), mass=M))
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=H, solver=lm.GaussSeidel(tolerance=tolerance)), floor


@pytest.fixture(scope="module")
def stack():
    """After 20 steps, solved to round-off."""
    sim, floor = build(1e-13)
    return sim.run(steps=20), floor


def test_every_contact_carries_what_stands_on_it(stack):
    """(COUNT - i) m g on the foot of disk i. The gaps are right to 1e-16 m, over h 1e-13 m/s, and the W of a column of
    ten amplifies that by at most ten, beside g h = 1e-2 m/s: 1e-10, with another digit for the solver's.
    """
    sim, floor = stack
    view = sim.interactions
    by_disk = {}
    for candidate, antagonist, force in zip(view.candidate, view.antagonist, view.force, strict=True):
        by_disk[floor.id if antagonist == floor.id else max(candidate, antagonist)] = force
    assert len(by_disk) == COUNT
    assert by_disk[floor.id] == pytest.approx([COUNT * M * G, 0.0], rel=1e-9, abs=1e-9)
    for i in range(1, COUNT):
        assert by_disk[i] == pytest.approx([(COUNT - i) * M * G, 0.0], rel=1e-9, abs=1e-9)


def test_it_stays_where_it_is(stack):
    sim, _ = stack
    assert sim.positions[:COUNT, 1] == pytest.approx(R + 2.0 * R * np.arange(COUNT), abs=1e-14)
    assert np.abs(sim.velocities).max() < 1e-11


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_second_step_starts_from_the_first(tolerance):
    """Cold it takes hundreds of sweeps, as the error of a column of ten falls by about (pi/10)^2 a sweep.

    Warm the first guess misses the tolerance only by the gaps that the first step has left open, which close within a
    few steps: at most a twentieth of the sweeps, and then the one that every step takes.
    """
    sim, _ = build(tolerance)
    sweeps = [sim.step().iterations for _ in range(12)]
    assert sweeps[0] > 300
    assert max(sweeps[1:]) <= sweeps[0] // 20
    assert sweeps[6:] == [1] * 6
