"""Lengths of any size: round-off is looked for in velocities, not in spins; and positions that are too far are refused."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def heap(scale, steps=40):
    """Spinning disks that fall on each other and on a floor, ``scale`` times as large; positions, velocities and spins in
    those units.

    Lengths times s, times and velocities times sqrt(s) under the same gravity, masses times s^2, is the same motion
    (Froude).
    """
    rng = np.random.default_rng(4)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    sand = lm.Material("sand", density=2600.0)
    for i in range(12):
        position = scale * np.array([0.9 * (i % 4) + 0.02 * rng.random(), 0.46 + 0.93 * (i // 4)])
        spin = 4.0 * rng.standard_normal() / np.sqrt(scale)
        scene.add(lm.disk(radius=0.45 * scale, position=position, material=sand, spin=spin))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=5e-3 * np.sqrt(scale), solver=lm.Auto(tolerance=1e-12)).run(steps=steps)
    return sim.positions / scale, sim.velocities / np.sqrt(scale), sim.spins * np.sqrt(scale)


@pytest.mark.parametrize("scale", [1e3, 1e-3, 1e-6, 1e-9, 1e-12, 1e-16])
def test_the_same_motion_at_any_size(scale):
    """To 1e-9: a residual of 1e-12 with what the slowest modes make of it. At 1e-16 m spins are 4e8 rad/s and velocities
    1e-8 m/s; taken together in one unit, all contacts would be round-off, and the disks would fall through the floor."""
    for here, there in zip(heap(scale), heap(1.0), strict=True):
        assert here == pytest.approx(there, abs=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("radius", [1e-6, 0.01, 1.0])
def test_positions_too_coarse_for_a_body_are_refused(dimension, radius):
    """Positions are rounded by eps |x|: a thousandth of the radius at |x| = 1e-3 R 2^52."""
    make = lm.disk if dimension == 2 else lm.sphere
    limit = 1e-3 * radius * 2.0**52
    for far, sound in ((0.9 * limit, True), (1.1 * limit, False), (-1.1 * limit, False)):
        scene = lm.Scene(dimension=dimension)
        scene.add(lm.wall(point=np.zeros(dimension), normal=np.eye(dimension)[-1]))
        scene.add(make(radius=radius, position=far * np.eye(dimension)[0], mass=1.0))
        if sound:
            lm.Simulation(scene, time_step=1e-3).step()
        else:
            with pytest.raises(ValueError, match=r"^Body 1 is .* m from the origin"):
                lm.Simulation(scene, time_step=1e-3)
