"""Spheres, planes and cylinders in 3D against analytic answers and conservation laws."""

import numpy as np
import pytest

import lmgcpy as lm

G = 9.81


def rotation(seed):
    """A random rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0.0 else -q


def on_a_plane(
    *, gravity, normal=(0.0, 0.0, 1.0), friction=0.5, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0), radius=0.1
):
    """A sphere that touches a plane through the origin."""
    scene = lm.Scene(dimension=3, gravity=gravity)
    n = np.array(normal)
    ball = scene.add(lm.sphere(radius=radius, position=radius * n, mass=2.0, velocity=velocity, spin=spin))
    scene.add(lm.wall(point=(0, 0, 0), normal=n))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return scene, ball


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("seed", [None, 0, 1])
@pytest.mark.parametrize(("slope", "friction"), [(0.2, 0.5), (0.6, 0.5), (1.2, 0.3)])
def test_a_sphere_on_an_incline_rolls_or_slips(slope, friction, seed):
    """It rolls with 5/7 g sin(a) where mu >= 2/7 tan(a); else it slips with g (sin a - mu cos a); any orientation."""
    turn = np.eye(3) if seed is None else rotation(seed)
    down = turn @ [np.sin(slope), 0.0, -np.cos(slope)]
    scene, _ = on_a_plane(gravity=G * down, normal=turn @ [0.0, 0.0, 1.0], friction=friction)
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=100)
    along = turn @ [1.0, 0.0, 0.0]
    rolls = friction >= 2.0 / 7.0 * np.tan(slope)
    acceleration = 5.0 / 7.0 * G * np.sin(slope) if rolls else G * (np.sin(slope) - friction * np.cos(slope))
    assert sim.velocities[0] == pytest.approx(0.1 * acceleration * along, abs=1e-11)  # round-off of the gap / h
    axis = turn @ [0.0, 1.0, 0.0]
    torque = 2.5 * friction * np.cos(slope) * G / 0.1  # spin-up of a slipping sphere: mu N R / (2/5 m R^2)
    spin = 0.1 * acceleration / 0.1 if rolls else 0.1 * torque
    assert sim.spins[0] == pytest.approx(spin * axis, abs=1e-10)


@pytest.mark.default_parameters("v01-w01")
@pytest.mark.parametrize(("v0", "w0"), [((1.0, 0.0), (0.0, 0.0)), ((0.8, -0.3), (4.0, 2.0)), ((0.0, 0.0), (-9.0, 5.0))])
def test_sliding_turns_into_rolling(v0, w0):
    """The velocity over the ground becomes (5 v0 + 2 R w0 x n)/7 whatever the friction, as long as it has time."""
    radius = 0.1
    spin = np.array([*w0, 3.0])
    scene, ball = on_a_plane(gravity=(0, 0, -G), velocity=(*v0, 0.0), spin=spin, radius=radius)
    lm.Simulation(scene, time_step=1e-3).run(steps=400)
    rim = np.cross(spin, [0.0, 0.0, radius])  # velocity of rolling with this spin
    assert ball.velocity == pytest.approx((5.0 * np.array([*v0, 0.0]) + 2.0 * rim) / 7.0, abs=1e-9)
    assert ball.velocity == pytest.approx(np.cross(ball.spin, [0.0, 0.0, radius]), abs=1e-9)
    assert ball.spin[2] == pytest.approx(3.0, abs=1e-12)  # nothing resists spin about the normal


@pytest.mark.long
def test_a_loose_heap_in_a_cylinder_keeps_the_weight():
    """Spheres come to rest in a cylinder: floor and wall carry their weight."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=3, gravity=(0, 0, -G))
    for i in range(40):
        place = 0.12 * np.array([i % 3 - 1, i // 3 % 3 - 1, i // 9 + 0.5]) + rng.uniform(-0.01, 0.01, 3)
        scene.add(lm.sphere(radius=0.05, position=place, mass=1.0))
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=0.25))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    for one, other in (("GRAIN", "GRAIN"), ("GRAIN", "WALL")):
        scene.see(one, other, lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=2e-3, solver=lm.AcceleratedGaussSeidel(tolerance=1e-5))
    sim.on_unconverged = "ignore"
    sim.run(steps=1500)  # the last sphere stops rolling after 1150
    net = sim.interactions
    force = np.einsum("mk,mkd->md", net.force, net.frame)
    walls = net.antagonist >= 40
    assert force[walls].sum(axis=0) == pytest.approx([0.0, 0.0, 40.0 * G], rel=1e-5, abs=4e-3)  # the residual, 1e-5
    assert np.hypot(*sim.positions[:40, :2].T).max() <= 0.2 + 2e-4
    assert (
        net.gap.min() > -2e-4
    )  # a normal is that of the detection: a way w along a curved wall ends w^2/2R in it, and stays


def cluster(seed=0, **options):
    """Spheres flying into each other, chained in part, without gravity."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=3, **options)
    balls = []
    for i in range(27):
        place = 0.25 * np.array([i % 3, i // 3 % 3, i // 9]) + rng.uniform(-0.02, 0.02, 3)
        start = {"velocity": rng.normal(0.0, 1.0, 3) - 4.0 * (place - 0.25), "spin": rng.normal(0.0, 5.0, 3)}
        balls.append(
            scene.add(lm.sphere(radius=rng.uniform(0.06, 0.1), position=place, mass=rng.uniform(0.5, 2.0), **start))
        )
    return scene, balls


def test_momentum_and_angular_momentum_are_kept():
    """Through collisions with friction and pulls of a wire, to round-off."""
    scene, balls = cluster()
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.chain(balls[::5], lm.RigidWire())
    mass = np.array([ball.mass for ball in balls])[:, None]
    inertia = np.array([ball.inertia for ball in balls])[:, None]
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-6))

    def momenta():
        angular = mass * np.cross(sim.positions, sim.velocities) + inertia * sim.spins
        return (mass * sim.velocities).sum(axis=0), angular.sum(axis=0)

    acted = 0
    for _ in range(200):
        before = momenta()
        sim.step()
        after = momenta()
        assert after[0] == pytest.approx(before[0], abs=1e-12)
        assert after[1] == pytest.approx(before[1], abs=1e-12)
        acted += int(np.any(sim.interactions.impulse != 0.0))
        assert abs(sim.energy.defect) < 1e-11
    assert acted > 50


@pytest.mark.parametrize("seed", range(2))
def test_a_turned_scene_gives_the_turned_motion(seed):
    """The friction cone is round: no direction is special. Before chaos makes round-off visible."""
    turn = rotation(seed)

    def run(q):
        scene, balls = cluster(gravity=q @ np.array([0.5, -1.0, 9.81]))
        for ball in balls:
            ball.position[:] = q @ ball.position
            ball.velocity[:] = q @ ball.velocity
            ball.spin[:] = q @ ball.spin
        scene.add(lm.wall(point=q @ np.array([0.0, 0.0, -0.15]), normal=q @ np.array([0.0, 0.0, 1.0])))
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
        scene.see("GRAIN", "WALL", lm.Restitution(friction=0.4, restitution=0.3))
        scene.chain(balls[::5], lm.ElasticWire(stiffness=1e4))
        return lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=60)

    straight, turned = run(np.eye(3)), run(turn)
    assert turned.positions == pytest.approx(straight.positions @ turn.T, abs=1e-9)
    assert turned.spins == pytest.approx(straight.spins @ turn.T, abs=1e-7)


def test_a_planar_scene_is_the_same_in_both_dimensions():
    """Disks in 2D and spheres in the plane x y of 3D, with the same masses and inertias."""

    def run(dimension):
        rng = np.random.default_rng(3)
        flat = dimension == 2
        scene = lm.Scene(dimension=dimension, gravity=(1.0, -G) if flat else (1.0, -G, 0.0))
        bodies = []
        for i in range(16):
            place = 0.25 * np.array([i % 4, i // 4]) + 0.12 + rng.uniform(-0.01, 0.01, 2)
            start = {"velocity": rng.normal(0.0, 1.0, 2), "mass": rng.uniform(0.5, 2.0), "inertia": rng.uniform(1e-3, 5e-3)}
            spin = rng.normal(0.0, 3.0)
            radius = rng.uniform(0.08, 0.1)
            if flat:
                body = lm.disk(radius=radius, position=place, spin=spin, **start)
            else:
                start["velocity"] = (*start["velocity"], 0.0)
                body = lm.sphere(radius=radius, position=(*place, 0.0), spin=(0.0, 0.0, spin), **start)
            bodies.append(scene.add(body))
        for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((1, 0), (-1, 0))):
            scene.add(lm.wall(point=point if flat else (*point, 0), normal=normal if flat else (*normal, 0)))
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
        scene.see("GRAIN", "WALL", lm.Restitution(friction=0.3, restitution=0.5))
        scene.chain(bodies[::3], lm.RigidWire(), block_spin=True)
        solver = lm.AcceleratedGaussSeidel(tolerance=1e-10, max_iterations=30_000)
        return lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=80)

    plane, space = run(2), run(3)
    assert np.abs(space.positions[:, 2]).max() == 0.0
    assert space.positions[:, :2] == pytest.approx(plane.positions, abs=1e-10)
    assert space.spins[:, 2] == pytest.approx(plane.spins, abs=1e-8)
    assert space.energy.kinetic == pytest.approx(plane.energy.kinetic, rel=1e-9)


def test_a_sliding_platform_of_spheres_does_not_lift():
    """Sliding does not dilate: spheres with blocked spin, driven over a plane together, stay on it."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, -G))
    for i in range(9):
        ball = scene.add(
            lm.sphere(radius=0.1, position=(0.3 * (i % 3), 0.3 * (i // 3), 0.1), mass=1.0, velocity=(2.0, 1.0, 0.0))
        )
        ball.fix("spin_x", "spin_y", "spin_z")
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.8))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=100)
    assert np.abs(sim.positions[:9, 2] - 0.1).max() < 1e-15
    speed = np.hypot(2.0, 1.0) - 0.1 * 0.8 * G
    assert np.linalg.norm(sim.velocities[:9], axis=1) == pytest.approx(speed, rel=1e-12)


def test_an_anisotropic_body_has_full_blocks():
    """A sphere held along x on an incline that looks askew: the contact's W is full, and the answer that of a bead on the
    line of the incline without x."""
    normal = np.array([0.6, 0.48, 0.64])
    scene, ball = on_a_plane(gravity=(0, 0, -G), normal=normal, friction=0.0)
    ball.fix("x")
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=100)
    along = np.array([0.0, normal[2], -normal[1]]) / np.hypot(normal[1], normal[2])
    acceleration = -G * along[2] * along
    assert sim.velocities[0] == pytest.approx(0.1 * acceleration, abs=1e-11)  # round-off of the gap / h


@pytest.mark.parametrize(
    ("axis", "spins"),
    [
        ((0, 0, 1), {"spin_x": 1.0}),
        ((0, 0, 1), {"spin_z": 1.0, "spin_y": 0.1}),
        ((0, 0, 1), {"spin_x": np.sin}),
        ((0, 1, 1), {"spin_z": 1.0}),
        ((0, 1, 1), {"spin_z": np.sin}),
    ],
)
def test_a_hollow_cylinder_is_not_driven_through_itself(axis, spins):
    """Its surface is where the axis is: a spin across it would drag bodies through a wall that stands still."""
    drum = lm.Scene(dimension=3).add(lm.cylinder_wall(point=(0, 0, 0), axis=axis, radius=0.1))
    with pytest.raises(ValueError, match="turns about its own axis only"):
        drum.impose_velocity(**spins)


def test_a_hollow_cylinder_turns_about_an_axis_that_leans():
    drum = lm.Scene(dimension=3).add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 1, 1), radius=0.1))
    drum.impose_velocity(spin_y=2.0, spin_z=2.0, x=0.1)
