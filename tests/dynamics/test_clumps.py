"""Clumps in space: statics, shocks, spinning, momentum and frames, each against its number from theory."""

from __future__ import annotations

import itertools
import math

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lmgcpy as lm
from lmgcpy.io.run_file.trees import digest

G = 9.81


def block(half=0.05, radius=0.02, density=1000.0):
    """Eight spheres at the corners of a cube; they do not touch each other."""
    corners = list(itertools.product((-half, half), repeat=3))
    return lm.clump([radius] * 8, corners, density=density, separate=True)


def on_incline(angle, friction, *, half=0.05, radius=0.02, turned=0.0, time_step=1e-3, solver=None):
    """A block at rest on the plane z = 0, in a gravity that leans by an angle towards x."""
    scene = lm.Scene(dimension=3, gravity=(G * math.sin(angle), 0, -G * math.cos(angle)))
    body = scene.add(block(half, radius).at((0, 0, half + radius), rotation=Rotation.from_euler("z", turned)))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=time_step, solver=solver), body


@pytest.mark.default_parameters("0.001-0.3-0.1")
@pytest.mark.parametrize("friction", [0.1, 0.5])
@pytest.mark.parametrize("turned", [0.0, 0.3])
@pytest.mark.parametrize("time_step", [1e-4, 1e-3, 5e-3])
def test_a_block_slides_from_the_angle_of_friction_on(friction, turned, time_step):
    stays, body = on_incline(math.atan(friction) - 0.01, friction, turned=turned, time_step=time_step)
    stays.run(steps=200)
    assert np.abs(body.velocity).max() < 1e-6
    slides, body = on_incline(math.atan(friction) + 0.1, friction, turned=turned, time_step=time_step)
    slides.run(steps=200)
    angle = math.atan(friction) + 0.1
    fast = G * (math.sin(angle) - friction * math.cos(angle)) * slides.time
    assert body.velocity == pytest.approx((fast, 0, 0), abs=1e-4 * fast)  # the solver's tolerance


@pytest.mark.default_parameters("0.001")
@pytest.mark.parametrize("time_step", [1e-4, 1e-3, 4e-3])
def test_a_block_tips_over_its_lower_edge(time_step):
    """Where the weight points beyond the contact: tan = half / (half + radius)."""
    limit = math.atan(0.05 / 0.07)
    for angle, tips in ((limit - 0.02, False), (limit + 0.02, True)):
        sim, body = on_incline(angle, 5.0, time_step=time_step)
        sim.run(duration=0.3)
        assert (body.spin[1] > 0.01) == tips
        assert np.abs(body.spin[[0, 2]]).max() < 1e-3  # the solver's tolerance


@pytest.mark.default_parameters("solver0-0.0-0.0", "solver0-0.4-1.0", "solver1-1.2-0.0")
@pytest.mark.parametrize("restitution", [0.0, 1.0])
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2])
@pytest.mark.parametrize("solver", [lm.GaussSeidel(tolerance=1e-12), lm.Newton(tolerance=1e-12)])
def test_a_rod_strikes_with_one_end(restitution, angle, solver):
    """Impulse (1 + e) v / (1/m + l^2 cos^2 / I) of the end sphere, l its distance from the centre."""
    reach, inertia = 0.1, np.array([1e-4, 4e-3, 4e-3])
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    ends = [(lm.SphereContactor(0.01), (sign * reach, 0, 0)) for sign in (1, -1)]
    turn = Rotation.from_euler("yz", [angle, 0.7])
    down = -float(turn.apply((reach, 0, 0))[2])
    scene.add(
        lm.RigidBody(
            ends, mass=1.0, inertia=inertia, position=(0, 0, abs(down) + 0.01 + 1e-5), velocity=(0, 0, -2.0), rotation=turn,
            color="GRAIN",
        )
    )
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=restitution, friction=0.0))
    sim = lm.Simulation(scene, time_step=1e-4, solver=solver)
    while not np.abs(sim.interactions.impulse).any():
        sim.step()
    contacts = 2 if angle == 0.0 else 1
    lever = 0.0 if contacts == 2 else reach * math.cos(angle)
    given = (1.0 + restitution) * 2.0 / (1.0 + lever**2 / inertia[1])
    assert sim.interactions.impulse[:, 0].sum() == pytest.approx(given, rel=1e-4)  # of the gap that closes in the step
    if restitution == 1.0:
        assert sim.energy.kinetic == pytest.approx(2.0, rel=1e-9)


@pytest.mark.default_parameters("0.001")
@pytest.mark.parametrize("time_step", [1e-4, 1e-3, 4e-3])
def test_a_block_that_spins_on_a_plane_comes_to_rest(time_step):
    """Four contacts at the distance rho from the axis: I w' = -mu m g rho."""
    sim, body = on_incline(0.0, 0.4, time_step=time_step)
    body.velocity[:] = 0.0
    sim.state.velocities[body.id, 5] = 20.0
    slowing = 0.4 * body.mass * G * math.hypot(0.05, 0.05) / body.inertia[2]
    sim.run(duration=0.1)
    assert body.spin == pytest.approx((0, 0, 20.0 - slowing * sim.time), abs=1e-3 * 20.0)
    sim.run(duration=20.0 / slowing)
    assert np.abs(body.spin).max() < 1e-6
    assert np.abs(body.velocity).max() < 1e-6


MIRROR = np.array([1.0, -1.0, 1.0])


def crowd(count=12, *, seed=0, law=None, rotation=None, order=None, mirrored=False):
    """Peanuts of unlike spheres that fly into each other, in a frame that is turned by a ``rotation``, or in a mirror."""
    rng = np.random.default_rng(seed)
    offsets = np.array([(0, 0, 0), (0.025, 0, 0), (0.0, 0.02, 0.01)])
    shape = lm.clump([0.02, 0.015, 0.01], offsets * MIRROR if mirrored else offsets, density=2000.0)
    places = 0.08 * np.array(list(itertools.product(range(-1, 2), repeat=3)), dtype=float)[:count]
    places += rng.normal(scale=0.003, size=places.shape)
    turns, spins = Rotation.random(count, random_state=seed), rng.normal(scale=3.0, size=(count, 3))
    velocities = -10.0 * places + rng.normal(scale=0.1, size=places.shape)
    frame = Rotation.identity() if rotation is None else rotation
    if mirrored:  # spins are axial vectors
        places, velocities, spins = places * MIRROR, velocities * MIRROR, -spins * MIRROR
        turns = Rotation.from_matrix(MIRROR[:, None] * turns.as_matrix() * MIRROR)
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    rows = np.arange(count) if order is None else order
    moving = {"velocities": frame.apply(velocities)[rows], "spins": frame.apply(spins)[rows]}
    scene.add_clumps(shape, frame.apply(places)[rows], rotations=(frame * turns)[rows], **moving)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5) if law is None else law)
    return scene


def total_momentum(sim):
    """Momentum, and angular momentum about the origin."""
    bodies = sim.scene.bodies
    linear = np.array([body.mass for body in bodies])[:, None] * sim.velocities
    own = np.array([body.rotation.apply(body.inertia * body.rotation.inv().apply(body.spin)) for body in bodies])
    return np.concatenate([linear.sum(axis=0), (own + np.cross(sim.positions, linear)).sum(axis=0)])


LAWS = {
    "coulomb": lm.Coulomb(friction=0.5),
    "restitution": lm.Restitution(restitution=0.8, friction=0.3),
    "rolling": lm.RollingCoulomb(friction=0.5, rolling_friction=0.1, torsion_friction=0.05),
}


@pytest.mark.default_parameters("solver0-coulomb")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("solver", [lm.GaussSeidel(), lm.AcceleratedGaussSeidel(), lm.Auto(), lm.Newton()])
def test_momentum_and_angular_momentum_of_a_crowd_stay(law, solver):
    """To round-off, whatever the solver leaves: impulses act on both bodies at one point, and bodies turn freely."""
    sim = lm.Simulation(crowd(law=LAWS[law]), time_step=5e-4, solver=solver, on_unconverged="ignore")
    before = total_momentum(sim)
    touched = 0
    for _ in range(240):
        sim.step()
        touched += int(np.count_nonzero(sim.interactions.impulse[:, 0]))
        assert abs(sim.energy.defect) < 1e-13 * sim.energy.kinetic
    assert touched > 30
    assert total_momentum(sim) == pytest.approx(before, abs=1e-13)


@pytest.mark.parametrize("what", ["turned", "permuted", "mirrored"])
def test_a_crowd_in_another_frame_or_order_does_the_same(what):
    """Until shocks have made much of round-off."""
    rotation = Rotation.random(random_state=7) if what == "turned" else Rotation.identity()
    order = np.random.default_rng(1).permutation(12) if what == "permuted" else np.arange(12)
    solver = lm.GaussSeidel(tolerance=1e-14, max_iterations=20_000)
    states = []
    for scene in (crowd(), crowd(rotation=rotation, order=order, mirrored=what == "mirrored")):
        sim = lm.Simulation(scene, time_step=2e-3, solver=solver, on_unconverged="ignore")
        touched = 0
        for _ in range(20):
            sim.step()
            touched += np.count_nonzero(sim.interactions.impulse[:, 0])
        states.append((sim.positions.copy(), sim.velocities.copy(), sim.spins.copy()))
        assert touched > 5
    signs = (MIRROR, MIRROR, -MIRROR) if what == "mirrored" else (1.0, 1.0, 1.0)
    for mine, other, sign in zip(*states, signs, strict=True):
        scale = np.abs(mine).max()
        np.testing.assert_allclose(rotation.apply(mine * sign)[order], other, rtol=0.0, atol=1e-7 * scale)


def test_a_clump_of_one_sphere_is_a_sphere():
    """Rolling down an incline, bit by bit but for the order of sums."""
    ends = []
    for clumped in (False, True):
        scene = lm.Scene(dimension=3, gravity=(3.0, 1.0, -G))
        if clumped:
            scene.add(lm.clump([0.1], [(0.3, 0.0, 0.0)], density=1000.0).at((0, 0, 0.1)))
        else:
            scene.add(lm.sphere(radius=0.1, position=(0, 0, 0.1), material=lm.Material("stone", 1000.0)))
        scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
        sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
        sim.run(steps=300)
        ends.append(np.concatenate([sim.positions[0], sim.velocities[0], sim.spins[0]]))
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-12)


def test_a_run_of_clumps_goes_on_bit_for_bit(tmp_path):
    path = tmp_path / "clumps.h5"
    one = lm.Simulation(crowd(), time_step=2e-3)
    one.run(steps=40)
    other = lm.Simulation(crowd(), time_step=2e-3)
    other.run(steps=25, record=path)
    again = lm.resume(path)
    again.run(steps=15)
    for name in ("positions", "velocities"):
        np.testing.assert_array_equal(getattr(one.state, name), getattr(again.state, name))
    with lm.io.open_run(path) as run:
        assert run.rotations.shape[1:] == (12, 4)
        np.testing.assert_array_equal(run.spins[-1], one.spins)
        np.testing.assert_array_equal(run.rotations[-1], one.rotations)
    scene = lm.Scene.from_run(path)
    np.testing.assert_array_equal([body._quaternion for body in scene.bodies], one.rotations)
    np.testing.assert_allclose([body.spin for body in scene.bodies], one.spins, rtol=1e-14)
    np.testing.assert_allclose(lm.Simulation(scene, time_step=2e-3).spins, one.spins, rtol=1e-13)


@pytest.mark.long
def test_a_wheel_of_spheres_rolls_down_at_the_speed_of_a_rimless_wheel():
    """McGeer's wheel (1990, Int. J. Robotics Research 9) with feet of radius r. A shock keeps the angular momentum about
    the next foot, w+ = eta w-, and between shocks the wheel gains the energy of its way down."""
    count, ring, foot, lean, mass, inertia = 8, 0.1, 0.02, 0.2, 1.0, 0.008
    angles = 2.0 * math.pi * np.arange(count) / count
    feet = [(lm.SphereContactor(foot), (ring * math.sin(a), 0.0, -ring * math.cos(a))) for a in angles]
    half, height = ring * math.sin(math.pi / count), ring * math.cos(math.pi / count) + foot
    about_foot = inertia + mass * (height**2 + half**2)
    eta = (inertia + mass * (height**2 - half**2)) / about_foot
    way = 2.0 * half + 2.0 * math.pi / count * foot  # from shock to shock: a chord, and what a foot rolls
    steady = math.sqrt(2.0 * mass * G * way * math.sin(lean) / (about_foot * (1.0 - eta**2)))
    scene = lm.Scene(dimension=3, gravity=(G * math.sin(lean), 0, -G * math.cos(lean)))
    start = {"position": (0, 0, ring + foot), "spin": (0, steady, 0), "velocity": (steady * (ring + foot), 0, 0)}
    wheel = scene.add(lm.RigidBody(feet, mass=mass, inertia=(0.005, inertia, 0.005), color="GRAIN", **start))
    wheel.fix("y", "spin_x", "spin_z")
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=1.0))
    sim = lm.Simulation(scene, time_step=5e-4, solver=lm.GaussSeidel(tolerance=1e-10))
    shocks, before, high = [], steady, None
    while len(shocks) < 12:
        sim.step()
        now = wheel.spin[1]
        if now < 0.99 * before:  # a shock takes two steps: the first one closes the gap
            high = before if high is None else high
        elif high is not None:
            shocks.append((high, before))
            high = None
        before = now
    shocks = np.array(shocks[6:])  # the start is forgotten: eta^12
    np.testing.assert_allclose(shocks[:, 1] / shocks[:, 0], eta, rtol=2e-2)  # a step of free fall more or less
    np.testing.assert_allclose(shocks[:, 0], steady, rtol=2e-2)


@pytest.mark.default_parameters("rotation-value0-must be a quaternion of length one")
@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("rotation", np.zeros((12, 4)), "must be a quaternion of length one"),
        ("rotation", np.zeros((12, 3)), "the fields of bodies that turn do not fit together"),
        ("inertia", -np.ones((12, 3)), "must be a number above 0|must be above 0|must be numbers above 0"),
        ("inertia", np.tile([1.0, 1.0, 3.0], (12, 1)), "which no body has"),
    ],
)
def test_a_damaged_table_of_bodies_that_turn_is_no_scene(tmp_path, name, value, sentence):
    """With the right digest."""
    path = tmp_path / "clumps.h5"
    lm.Simulation(crowd(), time_step=2e-3).run(steps=2, record=path)
    with h5py.File(path, "r+", locking=False) as file:
        del file["scene/turning"][name]
        file["scene/turning"].create_dataset(name, data=value)
        file["scene"].attrs["digest"] = digest(file["scene"])
    with pytest.raises(ValueError, match=sentence):
        lm.resume(path)


@pytest.mark.default_parameters("0.1", "2.872727272727273")
@pytest.mark.parametrize("angle", np.linspace(0.1, 6.2, 12).tolist())
def test_a_hinge_is_not_turned_by_a_push_through_its_axis(angle):
    """What rounding makes of W_nn is no mobility: spins of 1e15 rad/s came of it."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    turn = Rotation.from_rotvec([0.0, 0.0, angle])
    ball = (lm.SphereContactor(0.1), (0.3 * math.cos(0.7), 0.3 * math.sin(0.7), 0.0))
    start = {"position": (0, 0, 0), "color": "GRAIN", "rotation": turn}
    hinge = scene.add(lm.RigidBody([ball], mass=1.0, inertia=(0.1, 0.1, 0.1), **start))
    hinge.fix("x", "y", "z", "spin_x", "spin_y")
    to = turn.apply(ball[1]) / 0.3
    wall = scene.add(lm.wall(point=0.401 * to, normal=-to))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    wall.impose_velocity(**dict(zip("xyz", -1e-2 * to, strict=True)))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=150)
    assert np.abs(hinge.spin).max() < 1e-9


def test_what_is_added_turns_at_once():
    """Spins are along the axes of space before the next step as well."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    scene.add(lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0, spin=(1, 2, 3)))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=2)
    body = scene.add(lm.capsule(radius=0.1, length=0.2, position=(1, 0, 0), axis=(1, 0, 0), mass=1.0, spin=(0, 0, 5)))
    assert sim.spins == pytest.approx(np.array([[1, 2, 3], [0, 0, 5]]), abs=1e-12)
    assert sim.rotations[1] == pytest.approx(body.rotation.as_quat())
    assert sim.run(steps=1).spins[1] == pytest.approx((0, 0, 5), abs=1e-12)


def test_bodies_that_never_turn_take_no_rotation():
    scene = lm.Scene(dimension=3)
    with pytest.raises(ValueError, match="cannot take a rotation: it never turns"):
        scene.add(lm.Wall(point=(0, 0, 0), normal=(0, 0, 1), color="W", rotation=(0.5, 0.5, 0.5, 0.5)))


@pytest.mark.default_parameters("0.5-0.7", "2.0-0.0")
@pytest.mark.parametrize("heading", [0.0, 0.7])
@pytest.mark.parametrize("friction", [0.5, 2.0])
def test_painleves_rod_does_in_space_what_it_does_in_the_plane(friction, heading):
    """A rod that is pushed over rough ground with its end ahead: with a friction of 2 at 45 degrees,
    ``1/m + l^2/I cos (cos - mu sin)`` is negative, sliding has no solution, and the end jams by an impulse."""
    reach, lean, speed, inertia, radius = 0.1, 0.25 * math.pi, 3.0, 0.01 / 3.0, 0.01
    height = reach * math.sin(lean) + radius
    turn = Rotation.from_euler("yz", [lean, heading])  # the end along x of the body is ahead and low
    ends = {}
    for dimension in (2, 3):
        down = (0.0, -G) if dimension == 2 else (0.0, 0.0, -G)
        scene = lm.Scene(dimension=dimension, gravity=down)
        if dimension == 2:
            pair = [(lm.DiskContactor(radius), (sign * reach, 0.0)) for sign in (1, -1)]
            start = {"position": (0.0, height), "velocity": (speed, 0.0), "rotation": -lean, "inertia": inertia}
            scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
        else:
            pair = [(lm.SphereContactor(radius), (sign * reach, 0.0, 0.0)) for sign in (1, -1)]
            ahead = Rotation.from_euler("z", heading).apply((speed, 0.0, 0.0))
            start = {"position": (0, 0, height), "velocity": ahead, "rotation": turn, "inertia": (1e-4, inertia, inertia)}
            scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
        body = scene.add(lm.RigidBody(pair, mass=1.0, color="GRAIN", **start))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
        sim = lm.Simulation(scene, time_step=1e-4, solver=lm.GaussSeidel(tolerance=1e-12))
        energy = [sim.energy.kinetic + G * body.position[-1]]
        path = []
        for _ in range(150):
            sim.step()
            energy.append(sim.energy.kinetic + G * body.position[-1])
            path.append([*body.position, *body.velocity])
        assert sim.unconverged_steps == 0
        assert np.diff(energy).max() < 1e-5 * energy[0]  # the scheme's, second order in the step
        ends[dimension] = np.array(path)
    back = Rotation.from_euler("z", -heading)
    space = np.hstack([back.apply(ends[3][:, :3])[:, [0, 2]], back.apply(ends[3][:, 3:])[:, [0, 2]]])
    np.testing.assert_allclose(space, ends[2], rtol=0.0, atol=1e-6)
    assert (ends[2][0, 2] < 0.5 * speed) == (friction == 2.0)  # it jams in the first step
