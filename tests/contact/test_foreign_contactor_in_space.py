"""Contactors of somebody else's in space, whose contact points lie anywhere and whose shapes turn with their bodies."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lmgcpy as lm
from lmgcpy.contact import register_pair
from lmgcpy.contact.contactor_pairs import sphere_sphere
from lmgcpy.contact.positions import rotated


class Pole(lm.Contactor):
    """An endless cylinder around the z axis of its body."""

    KIND = "test-pole"
    area = second_moment = 0.0
    bounding_radius = math.inf

    def __init__(self, radius):
        self.shape = (radius,)

    shape = ()


class Fin(lm.Contactor):
    """The half-space ``z < 0`` of its body, within a ball."""

    KIND = "test-fin"
    area = second_moment = 0.0
    bounding_radius = 1.0
    shape = (1.0,)


def sphere_pole(position_c, shape_c, position_a, shape_a):
    e = rotated((position_a[3], position_a[4], position_a[5], position_a[6]), (0.0, 0.0, 1.0))
    d = (position_c[0] - position_a[0], position_c[1] - position_a[1], position_c[2] - position_a[2])
    along = d[0] * e[0] + d[1] * e[1] + d[2] * e[2]
    d = (d[0] - along * e[0], d[1] - along * e[1], d[2] - along * e[2])
    distance = math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    n = (d[0] / distance, d[1] / distance, d[2] / distance)
    gap = distance - shape_c[0] - shape_a[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1], position_c[2] - reach * n[2])


def sphere_fin(position_c, shape_c, position_a, shape_a):
    n = rotated((position_a[3], position_a[4], position_a[5], position_a[6]), (0.0, 0.0, 1.0))
    height = 0.0
    for k in range(3):
        height += n[k] * (position_c[k] - position_a[k])
    gap = height - shape_c[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1], position_c[2] - reach * n[2])


register_pair("sphere", "test-pole", sphere_pole)
register_pair("sphere", "test-fin", sphere_fin)


@pytest.mark.long
def test_a_driven_pole_turns_a_sphere():
    """Without sliding the surfaces have one velocity, wherever the axis points."""
    turn = Rotation.from_euler("xyz", [0.4, 1.0, 0.2])
    scene = lm.Scene(dimension=3, gravity=tuple(turn.apply((0.0, -10.0, 0.0))))
    ball = scene.add(lm.sphere(radius=0.1, position=turn.apply((0.0, 0.5, 0.3)), mass=1.0))
    pole = lm.RigidBody([Pole(0.4)], mass=1.0, inertia=(1.0, 1.0, 1.0), position=(0, 0, 0), rotation=turn, color="POLE")
    scene.add(pole).fix("x", "y", "z")
    pole.impose_velocity(spin_x=0.0, spin_y=0.0, spin_z=2.0)  # about its own axes
    ball.fix("x")
    scene.see("GRAIN", "POLE", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=100)
    assert pole.spin == pytest.approx(turn.apply((0, 0, 2.0)), abs=1e-12)
    turned = (turn.inv() * pole.rotation).as_rotvec()
    assert turned == pytest.approx((0, 0, 2.0 * sim.time), abs=1e-12)
    # velocities of both surfaces at the point that they share
    lever_c, lever_a = sim.interactions.lever[0]
    surface = ball.velocity + np.cross(ball.spin, lever_c) - np.cross(pole.spin, lever_a)
    assert np.abs(surface).max() < 1e-3


def test_a_lever_far_from_the_centre_turns_a_free_body():
    """A ball strikes a plate beside its centre: the impulse is that of the lever, (1 + e) v / (1/m + 1/M + l^2/I)."""
    turn = Rotation.from_euler("xyz", [0.3, -0.8, 1.1])
    inertia, off = np.array([0.2, 0.3, 0.4]), np.array([0.3, -0.2, 0.0])
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    plate = scene.add(lm.RigidBody([Fin()], mass=2.0, inertia=inertia, position=(1, 2, 3), rotation=turn, color="FIN"))
    start = turn.apply([*off[:2], 0.1 + 1e-5]) + np.array([1, 2, 3])
    scene.add(lm.sphere(radius=0.1, position=start, mass=1.0, velocity=turn.apply((0, 0, -1.0))))
    scene.see("GRAIN", "FIN", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-4, solver=lm.GaussSeidel(tolerance=1e-12))
    while not np.abs(sim.interactions.impulse).any():
        sim.step()
    moment = np.cross(off, (0, 0, 1.0))
    given = 1.0 / (1.0 + 0.5 + (moment**2 / inertia).sum())
    assert sim.interactions.impulse[0, 0] == pytest.approx(given, rel=1e-4)  # the gap that closes in the step, 1e-5 m
    r = sim.interactions.impulse[0, 0]
    assert plate.spin == pytest.approx(turn.apply(-moment * r / inertia), rel=1e-3, abs=1e-6)
    assert plate.velocity == pytest.approx(turn.apply((0, 0, -0.5 * r)), rel=1e-3, abs=1e-6)


def test_a_normal_that_points_inward_is_found_before_the_first_step():
    def inward(position_c, shape_c, position_a, shape_a):
        gap, n, p = sphere_fin(position_c, shape_c, position_a, shape_a)
        return gap, (-n[0], -n[1], -n[2]), p

    class Wrong(Fin):
        KIND = "test-inward-fin"

    register_pair("sphere", "test-inward-fin", inward)
    scene = lm.Scene(dimension=3)
    scene.add(lm.sphere(radius=0.1, position=(0, 0, 1), mass=1.0))
    scene.add(lm.RigidBody([Wrong()], mass=1.0, inertia=1.0, position=(0, 0, 0), color="FIN"))
    scene.see("GRAIN", "FIN", lm.Signorini())
    with pytest.raises(ValueError, match="normal that points inward"):
        lm.Simulation(scene, time_step=1e-3).step()


def test_a_pair_with_levers_where_no_body_turns_is_refused():
    class Ball(lm.SphereContactor):
        KIND = "test-ball"

    def ball_ball(position_c, shape_c, position_a, shape_a):
        return sphere_sphere(position_c, shape_c, position_a, shape_a)

    class Other(lm.Sphere):
        @property
        def contactors(self):
            return [(Ball(self.radius), (0.0, 0.0, 0.0))]

    register_pair("test-ball", "test-ball", ball_ball)
    scene = lm.Scene(dimension=3)
    for x in (0.0, 0.3):
        scene.add(Other(radius=0.1, position=(x, 0, 0), mass=1.0, color="OWN"))
    scene.see("OWN", "OWN", lm.Signorini())
    with pytest.raises(ValueError, match="none of this scene keeps a rotation: give register_pair central=True"):
        lm.Simulation(scene, time_step=1e-3)


def test_a_scene_with_a_body_class_of_ones_own_comes_back_from_its_file(tmp_path):
    class Plate(lm.Body):
        dimension = 3
        mass, inertia = 2.0, (0.2, 0.3, 0.4)

        @property
        def contactors(self):
            return [(Fin(), (0.0, 0.0, 0.0))]

    def drop():
        scene = lm.Scene(dimension=3, gravity=(0, 0, -9.81))
        scene.add(Plate(position=(0, 0, 0), color="FIN", spin=(0.1, 0.2, 0.3))).fix("x", "y", "z")
        scene.add(lm.sphere(radius=0.1, position=(0.3, 0.2, 0.12), mass=1.0))
        scene.see("GRAIN", "FIN", lm.Coulomb(friction=0.3))
        return lm.Simulation(scene, time_step=1e-3)

    path, whole = tmp_path / "plate.h5", drop().run(steps=100)
    drop().run(steps=60, record=path)
    again = lm.resume(path).run(steps=40)
    np.testing.assert_array_equal(again.state.positions, whole.state.positions)
