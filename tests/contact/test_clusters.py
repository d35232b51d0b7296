"""Bodies of several contactors: a dumbbell of two disks."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

MASSES, INERTIAS = (1.5, 0.7), (0.2, 0.15)


def dumbbell(position, color, *, left=0.4, right=0.6, mass=1.5, inertia=0.2, **start):
    """Disks of radius 0.2 m at ``left`` and ``right`` of the centre of mass."""
    contactors = [(lm.DiskContactor(0.2), (-left, 0.0)), (lm.DiskContactor(0.2), (right, 0.0))]
    return lm.RigidBody(contactors, mass=mass, inertia=inertia, position=position, color=color, **start)


def momentum(sim):
    """Linear and angular momentum about the origin."""
    m, inertia = np.array(MASSES), np.array(INERTIAS)
    p = m[:, None] * sim.velocities
    x, y = sim.positions.T
    return np.array([*p.sum(axis=0), (x * p[:, 1] - y * p[:, 0] + inertia * sim.spins).sum()])


@pytest.mark.default_parameters(angle=(1.6,), theta=(0.5,))
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("angle", [0.0, 0.7, 1.6, 2.9])
@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_a_collision_keeps_linear_and_angular_momentum(theta, angle, friction):
    """Two spinning dumbbells, thrown at each other from 1 m apart at any angle, for 0.5 s and dozens of impulses.

    r and -r act at one point, so each step keeps both momenta to round-off: the terms are below 20 in SI units, a step
    rounds some ten operations on them, 500 steps drift less than 500 * 10 * 20 * 1.1e-16 = 1e-11 (as a random walk
    far less).
    """
    scene = lm.Scene(dimension=2)
    scene.add(dumbbell((-0.9, 0.1), "RED", rotation=angle, velocity=(2.0, 0.3), spin=3.0))
    scene.add(dumbbell((0.9, -0.1), "RED", rotation=-0.4, velocity=(-2.5, 0.2), spin=-1.0, mass=0.7, inertia=0.15))
    scene.see("RED", "RED", lm.Coulomb(friction=friction))
    sim = lm.Simulation(scene, time_step=1e-3, theta=theta, solver=lm.GaussSeidel(tolerance=1e-10))
    before, speed = momentum(sim), sim.velocities.copy()
    sim.run(steps=500)
    assert np.abs(sim.velocities - speed).max() > 0.5  # they have met
    assert momentum(sim) == pytest.approx(before, abs=1e-11)


def test_a_resting_dumbbell_loads_its_feet_by_the_lever_law():
    """Feet at 0.4 m and 0.6 m: forces m g 0.6 and m g 0.4. Two contacts without friction and two equations: unique."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(dumbbell((0.0, 0.2), "RED", spin=0.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("RED", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=20)
    # the rounding of a position, 3e-17 m, over h is 3e-14 m/s, beside g h = 1e-2 m/s
    assert sim.interactions.force[:, 0] == pytest.approx([9.0, 6.0], rel=1e-10)
    assert abs(sim.spins[0]) < 1e-12


def test_contactors_follow_the_rotation_of_their_body():
    """A dumbbell turned upright has one foot 0.4 m below its centre and the other 0.6 m above: gaps 0.2 and 1.2 m."""
    scene = lm.Scene(dimension=2)
    scene.add(dumbbell((3.0, 0.8), "RED", rotation=np.pi / 2))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("RED", "WALL", lm.Signorini(), alert=10.0)
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    view = sim.interactions
    assert view.gap == pytest.approx([0.2, 1.2], abs=1e-15)
    # the contact point, in the middle of the gap, seen from the centre of the body
    assert view.lever[:, 0] == pytest.approx(np.array([[0.0, -0.7], [0.0, -0.2]]), abs=1e-15)


def test_the_disks_of_one_body_do_not_meet():
    """Overlapping disks of one body are one body."""
    scene = lm.Scene(dimension=2)
    scene.add(dumbbell((0.0, 0.0), "RED", left=0.1, right=0.1))
    scene.see("RED", "RED", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    assert len(sim.interactions) == 0
