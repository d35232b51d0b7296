"""Friction brings bodies to rest at the right place."""

from __future__ import annotations

import pytest

import lmgcpy as lm

R, G = 0.1, 9.81


def slide(speed, friction, *, h=1e-3, held=True, duration=None, mass=2.0):
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    disk = scene.add(lm.disk(radius=R, position=(0.0, R), mass=mass, velocity=(speed, 0.0)))
    if held:
        disk.fix("spin")
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    sim = lm.Simulation(scene, time_step=h, solver=lm.GaussSeidel(tolerance=1e-13))
    return sim.run(duration=1.2 * abs(speed) / (friction * G) if duration is None else duration)


@pytest.mark.default_parameters("0.2-1.0", "0.7--1.7")
@pytest.mark.parametrize("speed", [1.0, -1.7])
@pytest.mark.parametrize("friction", [0.2, 0.7])
def test_the_sliding_distance(speed, friction):
    """v^2/(2 mu g). Every step takes mu g h off the speed, exactly; only the last, in which a speed w < mu g h ends, goes
    w h/2 where w^2/(2 mu g) were right: too far by at most mu g h^2/8 (at w = mu g h/2), never too short.
    """
    h = 1e-3
    sim = slide(speed, friction, h=h)
    error = abs(sim.positions[0, 0]) - speed**2 / (2.0 * friction * G)
    assert -1e-11 <= error <= friction * G * h**2 / 8.0 + 1e-11
    assert sim.positions[0, 0] * speed > 0.0
    assert sim.velocities[0] == pytest.approx([0.0, 0.0], abs=1e-11)


def test_the_heat_of_sliding_is_the_kinetic_energy():
    sim = slide(1.0, 0.3)
    assert sim.energy.total_interactions["coulomb"] == pytest.approx(-0.5 * 2.0 * 1.0**2, rel=1e-10)
    assert sim.energy.kinetic == pytest.approx(0.0, abs=1e-20)


def test_a_disk_free_to_spin_slides_into_rolling():
    """It keeps 2/3 of its speed (angular momentum about the line of contact: m v R = 3/2 m v' R) and then rolls on.

    The change from sliding to rolling falls inside a step, which changes neither.
    """
    sim = slide(3.0, 0.5, held=False, duration=1.0)
    assert sim.velocities[0, 0] == pytest.approx(2.0, rel=1e-9)
    assert sim.spins[0] == pytest.approx(-2.0 / R, rel=1e-9)


def test_a_conveyor_carries_a_block():
    """A wall that moves at 0.5 m/s drags a disk at mu g until it has its speed: after v/(mu g) = 0.17 s."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=R, position=(0.0, R), mass=2.0)).fix("spin")
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(x=0.5)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=100)
    assert sim.velocities[0, 0] == pytest.approx(0.3 * G * 0.1, rel=1e-9)
    # the belt works with the friction at its own speed
    assert sim.energy.total_drives == pytest.approx(0.3 * 2.0 * G * 0.5 * 0.1, rel=1e-9)
    sim.run(steps=100)
    assert sim.velocities[0, 0] == pytest.approx(0.5, rel=1e-9)
    assert sim.interactions.force[0] == pytest.approx([2.0 * G, 0.0], abs=1e-8)
