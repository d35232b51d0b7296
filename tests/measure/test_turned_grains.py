"""Clumps and capsules in measures: stress, volumes, angular momentum, long axes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lmgcpy as lm

SIDE = 0.05
LOAD = 50.0


def pressed_box():
    """Clumps and capsules in a box without friction at its walls, its top pressed down, until nothing moves."""
    scene = lm.Scene(dimension=3)
    shape = lm.clump([0.012, 0.01, 0.009], [(0, 0, 0), (0.01, 0, 0), (0, 0.008, 0.006)], density=2600.0)
    places = (np.array(list(np.ndindex(2, 2, 2))) + 0.5) * SIDE / 2
    clumped = np.arange(8) % 3 > 0
    turns = Rotation.random(8, random_state=1)
    scene.add_clumps(shape, places[clumped], rotations=turns[clumped], scales=0.7)
    for k in np.flatnonzero(~clumped):
        scene.add(lm.capsule(radius=0.005, length=0.015, position=places[k], rotation=turns[k], mass=0.004))
    for axis in np.eye(3):
        scene.add(lm.wall(point=(0, 0, 0), normal=axis))
        top = scene.add(lm.wall(point=SIDE * axis, normal=-axis, mass=1.0))
    top.impose_force(z=-LOAD)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.0))
    return lm.Simulation(scene, time_step=2e-4, solver=lm.Auto(tolerance=1e-5)), top


@pytest.mark.long
def test_stress_of_a_box_is_the_pressure_on_its_walls():
    """V sigma = sum f (x) x over the walls, of bodies at rest: the load over the area of the top, where walls have no
    friction, and sigma is symmetric, as no moment acts. Levers are from centres of mass that lie in no sphere's centre."""
    sim, top = pressed_box()
    sim.run(steps=700)
    sigma = lm.measure.stress(sim)["total"]
    pressure = LOAD / SIDE**2
    height = top.position[2]
    assert height < 0.5 * SIDE
    assert -sigma[2, 2] == pytest.approx(pressure, rel=1e-4)  # what still moves
    net = sim.interactions
    for axis in range(2):  # walls 8 to 13: two an axis
        wall = 8 + 2 * axis
        force = net.force[(net.candidate == wall) | (net.antagonist == wall), 0].sum()
        assert -sigma[axis, axis] == pytest.approx(force / (SIDE * height), rel=1e-4)
    assert np.abs(sigma - sigma.T).max() < 1e-5 * pressure
    particles = lm.measure.particle_stress(sim)
    np.testing.assert_allclose(particles.moment.sum(axis=0) / (SIDE**2 * height), sigma, atol=1e-9 * pressure)


def test_volumes_of_unions():
    """A lens of two spheres of radius r, d apart, is pi/12 (4 r + d) (2 r - d)^2; a capsule is pi r^2 l + 4/3 pi r^3."""
    scene = lm.Scene(dimension=3)
    r, d = 0.01, 0.012
    peanut = lm.clump([r, r], [(0, 0, 0), (d, 0, 0)], density=2600.0)
    scales = np.array([1.0, 2.0, 0.7])
    scene.add_clumps(peanut, np.eye(3), scales=scales, rotations=Rotation.random(3, random_state=0))
    scene.add(lm.capsule(radius=r, length=d, position=(2, 0, 0), mass=1.0))
    scene.add(lm.sphere(radius=r, position=(3, 0, 0), mass=1.0))
    ends = [(lm.SphereContactor(1.5 * r), (0, 0, sign * d)) for sign in (1, -1)]
    start = {"mass": 1.0, "inertia": (1.0, 1.0, 0.5), "color": "GRAIN"}
    scene.add(lm.RigidBody([lm.RodContactor(r, (0, 0, d)), *ends], position=(5, 0, 0), **start))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    ball = 4.0 / 3.0 * math.pi * r**3
    union = 2.0 * ball - math.pi / 12.0 * (4.0 * r + d) * (2.0 * r - d) ** 2
    expected = [*(union * scales**3), math.pi * r**2 * d + ball, ball, math.nan]
    np.testing.assert_allclose(lm.measure.particle_stress(sim).volume, expected, rtol=1e-10)


def test_angular_momentum_of_bodies_with_axes():
    """R I R^T w of a body that turns, m x cross v, and 2/5 m r^2 w of a sphere; and about another point."""
    scene = lm.Scene(dimension=3)
    turn, inertia = Rotation.from_euler("zyx", [0.4, -0.9, 2.0]), np.array([1.0, 2.0, 2.5])
    start = {"mass": 2.0, "inertia": inertia, "color": "GRAIN", "rotation": turn}
    scene.add(lm.RigidBody([lm.SphereContactor(0.1)], position=(1, 0, 0), spin=(0.3, 0.1, -2), velocity=(0, 3, 0), **start))
    scene.add(lm.sphere(radius=0.5, position=(0, 0, 4), mass=3.0, spin=(0, 0, 7)))
    scene.add(lm.wall(point=(0, 0, -9), normal=(0, 0, 1)))
    sim = lm.Simulation(scene, time_step=1e-3)
    own = turn.apply(inertia * turn.inv().apply((0.3, 0.1, -2))) + np.array([0, 0, 0.4 * 3.0 * 0.25 * 7])
    about_origin = own + np.array([0, 0, 2.0 * 3.0])
    np.testing.assert_allclose(lm.measure.angular_momentum(sim, about=(0, 0, 0)), about_origin, rtol=1e-14)
    centre, momentum = np.array([2.0, 0.0, 12.0]) / 5.0, np.array([0.0, 6.0, 0.0])
    np.testing.assert_allclose(
        lm.measure.angular_momentum(sim), about_origin - np.cross(centre, momentum), rtol=1e-14, atol=1e-14
    )


def test_a_shock_of_clumps_keeps_angular_momentum(tmp_path):
    """Both levers go to one point, so that a shock keeps it to round-off; free motion as well. A run file has the same."""
    scene = lm.Scene(dimension=3)
    shape = lm.clump([0.1, 0.08], [(0, 0, 0), (0.1, 0, 0)], density=1000.0)
    turns = Rotation.random(2, random_state=4)
    one = scene.add(shape.at((0, 0, 0), rotation=turns[0], velocity=(1, 0, 0), spin=(3, -5, 2)))
    scene.add(shape.at((0.25, 0.05, 0.02), rotation=turns[1], spin=(1, 1, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3)
    before, spin = lm.measure.angular_momentum(sim, about=(0, 0, 0)), one.spin.copy()
    sim.run(steps=150, record=tmp_path / "a.h5", every=50)
    assert np.abs(one.spin - spin).max() > 0.5
    after = lm.measure.angular_momentum(sim, about=(0, 0, 0))
    np.testing.assert_allclose(after, before, atol=1e-12 * np.abs(before).max())
    with lm.io.open_run(tmp_path / "a.h5") as run:
        np.testing.assert_array_equal(lm.measure.angular_momentum(run, about=(0, 0, 0)), after)
        np.testing.assert_allclose(lm.measure.angular_momentum(run, about=(0, 0, 0), frame=0), before, rtol=1e-14)


def test_angular_momentum_in_the_plane_and_in_a_cell():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(2, 1), mass=3.0, inertia=0.5, velocity=(1, 4), spin=-2.0))
    found = lm.measure.angular_momentum(lm.Simulation(scene, time_step=1e-3), about=(0, 0))
    assert found == pytest.approx(3.0 * (2.0 * 4.0 - 1.0 * 1.0) - 0.5 * 2.0, rel=1e-15)
    scene = lm.Scene(dimension=2)
    scene.periodic(x=1.0, y=1.0)
    with pytest.raises(ValueError, match="In a periodic cell angular momentum depends"):
        lm.measure.angular_momentum(lm.Simulation(scene, time_step=1e-3))


def test_fabric_of_long_axes():
    """Capsules along two directions beside bodies that have no long axis: a sphere, a plate and a cube of spheres."""
    scene = lm.Scene(dimension=3)
    axes = np.array([(0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
    for k, axis in enumerate(axes):
        scene.add(lm.capsule(radius=0.1, length=0.5, position=(0, 0, 2 * k), axis=axis, mass=1.0))
    square = [(x, y, 0) for x in (0, 0.1) for y in (0, 0.1)]
    scene.add(lm.clump([0.1] * 4, square, density=1.0).at((2, 0, 0)))
    scene.add(lm.clump([0.1] * 8, [(x, y, z) for x, y, _ in square for z in (0, 0.1)], density=1.0).at((4, 0, 0)))
    peanut = lm.clump([0.1, 0.1], [(0, 0, 0), (0, 0.15, 0)], density=1.0)
    scene.add(peanut.at((6, 0, 0), rotation=Rotation.from_euler("z", 90, degrees=True)))
    scene.add(lm.sphere(radius=0.1, position=(8, 0, 0), mass=1.0))
    sim = lm.Simulation(scene, time_step=1e-3)
    found = lm.measure.long_axes(sim)
    assert found.body.tolist() == [0, 1, 2, 5]
    directions = [*axes, (1.0, 0.0, 0.0)]
    np.testing.assert_allclose(np.abs((found.direction * directions).sum(axis=1)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(found.fabric, np.mean([np.outer(t, t) for t in directions], axis=0), atol=1e-12)
    flat = lm.Simulation(lm.Scene(dimension=2), time_step=1e-3)
    with pytest.raises(ValueError, match="long_axes is for scenes in 3D"):
        lm.measure.long_axes(flat)
