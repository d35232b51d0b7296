"""Walls with ends: balls roll over their joints, rest in their corners, and are pushed, carried and turned by them."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
import suites

import lmgcpy as lm

G = 9.81
R = 0.1


def sheet(n, m=None, side=1.0):
    """Corners and triangles of a sheet of n x m squares."""
    m = n if m is None else m
    x, y = (along.ravel() * side for along in np.meshgrid(range(n + 1), range(m + 1), indexing="ij"))
    square = [(m + 1) * i + j for i, j in product(range(n), range(m))]
    triangles = [t for a in square for t in ((a, a + m + 1, a + m + 2), (a, a + m + 2, a + 1))]
    return np.column_stack([x, y, 0.0 * x]), np.array(triangles)


def box_triangles():
    """A cube of side one around the origin, its triangles facing outward."""
    points = np.array(list(product((-0.5, 0.5), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def world(wall, position, velocity=None, *, law=None, time_step=2e-3, gravity=G, spin=None):
    """A simulation of a ball and a wall, and the ball."""
    d = len(position)
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-gravity,))
    make = lm.disk if d == 2 else lm.sphere
    given = {} if spin is None else {"spin": spin}
    ball = scene.add(make(radius=R, position=position, velocity=velocity or (0.0,) * d, mass=1.0, **given))
    scene.add(wall)
    scene.see("GRAIN", "WALL", lm.Signorini() if law is None else law)
    return lm.Simulation(scene, time_step=time_step), ball


WAYS = {"along a diagonal": (10.0, 10.0), "along an edge": (10.0, 0.0), "anywhere": (7.0, 9.3)}


LONG = pytest.mark.long


@pytest.mark.scaled
@pytest.mark.parametrize("way", [way if "diagonal" in way else pytest.param(way, marks=LONG) for way in WAYS])
@pytest.mark.parametrize("turned", [False, pytest.param(True, marks=LONG)])
def test_a_ball_that_slides_over_a_flat_mesh_keeps_its_velocity(way, turned):
    """968 triangles of a plane: one contact in every step, through edges and corners exactly, and no bump. Turned by an
    angle, coordinates are rounded: each step may turn the velocity by 1e-16."""
    points, triangles = sheet(22)
    turn = np.eye(3)
    if turned:
        from scipy.spatial.transform import Rotation

        turn = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()
    wall = lm.mesh(points @ turn.T, triangles)
    velocity = turn @ (*WAYS[way], 0.0)
    start = turn @ (1.0, 1.0, R)
    scene = lm.Scene(dimension=3, gravity=turn @ (0.0, 0.0, -G))
    ball = scene.add(lm.sphere(radius=R, position=start, velocity=velocity, mass=1.0))
    scene.add(wall)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=2e-3)
    for _ in range(suites.size(300, long=900)):
        sim.step()
        assert len(sim.interactions) == 1
        assert np.abs(ball.velocity - velocity).max() < 1e-12
    assert sim.positions.shape[1] == 3
    assert sim.state.positions.shape[1] == 3  # a wall that does not turn keeps no rotation


def test_a_disk_that_slides_along_a_polyline_keeps_its_velocity():
    sim, ball = world(lm.wall_segment(*[(0.05 * k, 0.0) for k in range(1001)]), (0.5, R), (10.0, 0.0))
    for _ in range(500):
        sim.step()
        assert len(sim.interactions) == 1
        assert ball.velocity == pytest.approx((10.0, 0.0), abs=1e-12)


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rolling_ball_rolls_over_joints_as_over_a_plane(dimension):
    """With friction: the same motion as on a wall without ends, to rounding. Its impulse goes on with it."""
    points, triangles = sheet(30, 2, 0.1)
    ends = lm.wall_segment(*[(0.1 * k, 0.0) for k in range(31)]) if dimension == 2 else lm.mesh(points, triangles)
    d = dimension
    endless = lm.wall(point=(0.0,) * d, normal=(0.0,) * (d - 1) + (1.0,))
    start = (0.3, R) if d == 2 else (0.3, 0.1, R)
    paths = []
    for wall in (ends, endless):
        sim, _ = world(wall, start, (3.0,) + (0.0,) * (d - 1), law=lm.Coulomb(friction=0.2))
        path = []
        for _ in range(350):
            sim.step()
            path.append((*sim.positions[0], *np.atleast_1d(sim.spins[0])))
        paths.append(path)
    assert np.array(paths[0]) == pytest.approx(np.array(paths[1]), abs=1e-12)


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=LONG)])
def test_a_ball_over_a_convex_edge_turns_about_it(dimension):
    """A ball that slides off the edge of a table, slowly, without friction: it tips over about the edge, held by it, as
    v^2 = v_0^2 + 2 g R (1 - cos), until it leaves. Gap and normal are continuous: no step changes the speed by more than
    gravity does."""
    table = [(-1.0, -1.0), (0.0, -1.0), (0.0, 0.0), (-1.0, 0.0)]
    wall = lm.wall_segment(*table, closed=True, sides="outside")
    start, velocity = (-0.05, R), (0.3, 0.0)
    if dimension == 3:
        points, triangles = box_triangles()
        wall = lm.mesh(points - (0.5, 0.0, 0.5), triangles, sides="outside")
        start, velocity = (-0.05, 0.013, R), (0.3, 0.0, 0.0)
    h = 2e-4
    sim, ball = world(wall, start, velocity, time_step=h)
    speeds = []
    for _ in range(2000):
        before = ball.velocity.copy()
        sim.step()
        assert np.linalg.norm(ball.velocity - before) < 1.5 * G * h
        assert len(sim.interactions) <= 1
        if ball.position[0] > 0.0 and sim.interactions.force.any():
            fall = R - ball.position[-1]
            speeds.append(ball.velocity @ ball.velocity / (0.3**2 + 2.0 * G * fall))
    assert len(speeds) > 100
    assert np.array(speeds) == pytest.approx(1.0, abs=4e-3)  # of the order of the step


@pytest.mark.parametrize("rolls", [False, True])
@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=LONG)])
def test_friction_goes_on_over_a_convex_edge(dimension, rolls):
    """From a face over an edge, with the angle a of the centre about the edge and N = m g cos a - m v^2/R.

    A ball that slides has d(v^2)/da = 2 g R (sin a - mu cos a) + 2 mu v^2, so that v^2 = C e^(2 mu a) + A sin a + B cos a
    with A (1 + 4 mu^2) = -6 mu g R and B (1 + 4 mu^2) = -2 (1 - 2 mu^2) g R, and its friction spins it. A ball that rolls
    has v^2 = v_0^2 + 2 g R (1 - cos a) / (1 + I/(m R^2)), and the spin v/R. Errors are of second order in the step.
    """
    mu, h, d = (1.0 if rolls else 0.05), 5e-4, dimension
    inertia = 0.5 if d == 2 else 0.4
    table = [(-1.0, -1.0), (0.0, -1.0), (0.0, 0.0), (-1.0, 0.0)]
    wall, start = lm.wall_segment(table, closed=True, sides="outside"), (-0.02, R)
    if d == 3:
        points, triangles = box_triangles()
        wall, start = lm.mesh(points - (0.5, 0.0, 0.5), triangles, sides="outside"), (-0.02, 0.013, R)
    begin = 3.0 if rolls else 0.0
    spin = -begin if d == 2 else (0.0, begin, 0.0)
    sim, ball = world(wall, start, (0.3,) + (0.0,) * (d - 1), law=lm.Coulomb(friction=mu), time_step=h, spin=spin)
    rows = []
    for _ in range(500):
        sim.step()
        net, turning = sim.interactions, -ball.spin if d == 2 else ball.spin[1]
        assert len(net) <= 1
        if len(net) and ball.position[0] > 0.0 and net.force[0, 0] > 0.0:
            angle, speed = math.atan2(*ball.position[[0, -1]]), math.hypot(*ball.velocity)
            rows.append((angle, speed, turning, net.force[0, 0], math.hypot(*net.force[0, 1:])))
    angle, v, turning, normal, friction = np.array(rows[2:-20]).T
    assert len(angle) > 200
    if rolls:
        square = 0.3**2 + 2.0 * G * R * (1.0 - np.cos(angle)) / (1.0 + inertia)
        held = angle < 0.5  # then the friction that rolling takes is too much for its normal force
        assert turning[held] * R == pytest.approx(v[held], abs=1e-5)
    else:
        part = 1.0 + 4.0 * mu**2
        A, B = -6.0 * mu * G * R / part, -2.0 * (1.0 - 2.0 * mu**2) * G * R / part
        first = v[0] ** 2 - A * np.sin(angle[0]) - B * np.cos(angle[0])
        square = first * np.exp(2.0 * mu * (angle - angle[0])) + A * np.sin(angle) + B * np.cos(angle)
        held = angle < 10.0
        assert friction == pytest.approx(mu * normal, rel=1e-6)
        # its friction spins it; the lever ends in the middle of a gap of up to 5e-6 R
        assert np.diff(turning) * R * inertia == pytest.approx(h * friction[1:], rel=1e-5)
    assert v[held] == pytest.approx(np.sqrt(square[held]), abs=4e-5)
    # a normal force is the mean of a step, half a step before its speed and angle
    assert normal[held] == pytest.approx(G * np.cos(angle[held]) - v[held] ** 2 / R, abs=0.01 * G)


def test_a_disk_in_a_corner_has_two_contacts():
    """In a right angle that opens upward, turned by 30 degrees: the walls bear the weight by the angles of a corner."""
    angle = math.radians(30.0)
    one, other = (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
    centre = R * (np.array(one) + other)
    wall = lm.wall_segment(np.array(other), (0.0, 0.0), np.array(one))
    sim, _ = world(wall, tuple(centre))
    sim.run(steps=50)
    net = sim.interactions
    assert len(net) == 2
    assert sorted(net.force[:, 0]) == pytest.approx(sorted([G * math.sin(angle), G * math.cos(angle)]), rel=1e-6)


@pytest.mark.long
def test_a_ball_in_a_box_of_six_plates_comes_to_rest_in_a_corner():
    """Tilted gravity takes it into a corner, where three plates bear the components of its weight. The energy only
    falls."""
    points, triangles = box_triangles()
    scene = lm.Scene(dimension=3, gravity=(-2.0, -3.0, -5.0))
    ball = scene.add(lm.sphere(radius=R, position=(0.1, 0.0, 0.1), velocity=(1.0, -2.0, 0.5), mass=1.0))
    faces = triangles.reshape(-1, 2, 3)
    for one, other in faces:
        scene.add(lm.plate(points[[one[0], one[1], one[2], other[2]]]))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3)
    energy = []
    for _ in range(2500):
        sim.step()
        moving = 0.5 * ball.velocity @ ball.velocity + 0.2 * R**2 * ball.spin @ ball.spin
        energy.append(moving + ball.position @ (2.0, 3.0, 5.0))
    assert np.diff(energy).max() < 1e-8 * energy[0]
    assert ball.position == pytest.approx([-0.4] * 3, abs=1e-6)
    net = sim.interactions
    assert len(net) == 3
    assert sorted(net.force[:, 0]) == pytest.approx([2.0, 3.0, 5.0], rel=1e-4)


@pytest.mark.parametrize("depth", [0.5, 1.0, 1.5, 1.9])
def test_a_ball_deep_in_a_solid_is_pushed_out(depth):
    """Its centre is behind the face: it is driven upward until the overlap is gone, as the contact is pressed."""
    points, triangles = box_triangles()
    block = lm.mesh(points, triangles, sides="outside")
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, 0.0))
    ball = scene.add(lm.sphere(radius=R, position=(0.07, 0.03, 0.5 + R - depth * R), mass=1.0))
    scene.add(block)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, overlap="ignore").run(steps=1)
    net = sim.interactions
    assert len(net) == 1
    assert net.normal[0] * (1 if net.candidate[0] == ball.id else -1) == pytest.approx((0.0, 0.0, 1.0))
    assert net.gap[0] == pytest.approx(-depth * R)


def tube(n, radius=0.5):
    """A tube of n plates around the y axis, one of them at the bottom."""
    angle = 2.0 * np.pi * (np.arange(n) + 0.5) / n - 0.5 * np.pi
    ring = radius * np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])
    k = np.arange(n)
    j = (k + 1) % n
    triangles = np.concatenate([np.column_stack([k, j, j + n]), np.column_stack([k, j + n, k + n])])
    return np.concatenate([ring - (0, 0.3, 0), ring - (0, -0.3, 0)]), triangles


@LONG
def test_a_drum_of_plates_carries_a_ball_as_a_cylinder_does():
    """A drum with friction turns about its axis and takes a ball up. The mean error of the height falls as n^-2, with n the
    number of plates: as R (1 - cos(pi/n)). The error along the wall falls as 1/n: a shock at each edge takes n^-2 of the
    energy, and n of them are met in a turn."""

    def path(drum, height):
        drum.impose_velocity(spin_y=1.0)
        sim, ball = world(drum, (0.0, 0.0, R - height), law=lm.Coulomb(friction=0.5), time_step=1e-3)
        found = []
        for _ in range(600):
            sim.step()
            found.append(ball.position.copy())
        assert sim.state.positions.shape[1] == (7 if isinstance(drum, lm.Surface) else 3)
        return np.array(found)

    cylinder = path(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 1, 0), radius=0.5), 0.5)
    errors = [np.abs(path(lm.mesh(*tube(n)), 0.5 * math.cos(math.pi / n)) - cylinder).mean(axis=0) for n in (12, 24, 48)]
    errors = np.array(errors)[:, [0, 2]]
    order = np.log2(errors[:-1] / errors[1:])
    assert order[:, 1] == pytest.approx(2.0, abs=0.3)
    assert order[:, 0].min() > 0.8


def test_a_press_comes_down_on_a_ball():
    """A plate with a mass is held but for the component that is loaded."""
    press = lm.plate([(-1, -1, 0.5), (1, -1, 0.5), (1, 1, 0.5), (-1, 1, 0.5)], mass=2.0)
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    ball = scene.add(lm.sphere(radius=R, position=(0.2, 0.1, R), mass=1.0))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(press).impose_force(z=-30.0)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=500)
    assert press.position == pytest.approx((0.0, 0.0, 2.0 * R), abs=1e-3)
    net = sim.interactions
    assert sorted(net.force[:, 0]) == pytest.approx([30.0, 30.0 + G], rel=1e-6)
    assert ball.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


@pytest.mark.long
def test_a_free_cube_falls_on_a_plate_and_lies_flat():
    """A cube of a material, with the mass and inertia of its volume; it rests on its corners."""
    points, triangles = box_triangles()
    cube = lm.mesh(0.2 * points + (0.0, 0.0, 0.3), triangles, material=lm.Material("oak", 700.0), color="CUBE")
    assert cube.mass == pytest.approx(700.0 * 0.2**3)
    assert np.broadcast_to(cube.inertia, 3) == pytest.approx([cube.mass * 0.2**2 / 6.0] * 3)
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    scene.add(cube)
    scene.add(lm.plate([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], radius=0.01))
    scene.see("CUBE", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=800)
    assert cube.position[2] == pytest.approx(0.11, abs=1e-6)
    assert np.abs(cube.velocity).max() < 1e-9
    assert sim.interactions.force[:, 0].sum() == pytest.approx(cube.mass * G, rel=1e-6)
