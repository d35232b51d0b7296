"""Bodies that turn freely in space, against Jacobi's elliptic functions, invariants and a heavy top."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import lmgcpy as lm
from lmgcpy.dynamics.rotation import TURN, turn_freely

INERTIA = np.array([1.0, 2.0, 3.0])


def spinning(spin, *, inertia=INERTIA, rotation=None, time_step=0.01, theta=0.5):
    """A free body with a spin along its own axes."""
    rotation = Rotation.identity() if rotation is None else rotation
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    pair = [(lm.SphereContactor(0.1), (0.2, 0, 0)), (lm.SphereContactor(0.1), (-0.2, 0, 0))]
    start = {"position": (0, 0, 0), "color": "A", "rotation": rotation, "spin": rotation.apply(spin)}
    body = scene.add(lm.RigidBody(pair, mass=1.0, inertia=inertia, **start))
    return lm.Simulation(scene, time_step=time_step, theta=theta), body


def own_spin(body):
    return body.rotation.inv().apply(body.spin)


def momentum(body, inertia=INERTIA):
    """Angular momentum along the axes of space."""
    return body.rotation.apply(np.asarray(inertia) * own_spin(body))


def turned(spin, time_step, steps, rotation=None):
    """Quaternion and own spin of a free body after some steps of the kernel alone, each in two parts."""
    mass = np.concatenate([np.ones(3), INERTIA])[None]
    start = Rotation.identity() if rotation is None else rotation
    positions = np.concatenate([np.zeros(3), start.as_quat()])[None]
    velocities, rows = np.concatenate([np.zeros(3), spin])[None], np.zeros(1, np.int64)
    for _ in range(2 * steps):
        turn_freely(rows, 0.5 * time_step, positions, velocities, mass, 1.0 / mass)
    return positions[0, 3:], velocities[0, 3:]


def jacobi(start, time):
    """Spin of a free body with the inertias 1, 2, 3 at a time, for a start (a, 0, c) with 2 E I_2 < L^2 (Landau and
    Lifshitz, Mechanics, section 37)."""
    energy, square = 0.5 * INERTIA @ start**2, (INERTIA**2) @ start**2
    i_1, i_2, i_3 = INERTIA
    assert square > 2.0 * energy * i_2
    rate = math.sqrt((i_3 - i_2) * (square - 2 * energy * i_1) / (i_1 * i_2 * i_3))
    modulus = (i_2 - i_1) * (2 * energy * i_3 - square) / ((i_3 - i_2) * (square - 2 * energy * i_1))
    sn, cn, dn, _ = ellipj(rate * time, modulus)
    a = math.sqrt((2 * energy * i_3 - square) / (i_1 * (i_3 - i_1)))
    b = math.sqrt((2 * energy * i_3 - square) / (i_2 * (i_3 - i_2)))
    c = math.sqrt((square - 2 * energy * i_1) / (i_3 * (i_3 - i_1)))
    return np.array([a * cn, b * sn, c * dn]), ellipk(modulus) / rate


def test_a_free_body_follows_the_elliptic_functions():
    """Over 1e4 steps, in which it turns 112 times. Half the step, a quarter of the error."""
    start = np.array([0.5, 0.0, 0.8])
    errors = [
        np.abs(turned(start, time_step, steps)[1] - jacobi(start, time_step * steps)[0]).max()
        for time_step, steps in ((0.08, 10_000), (0.04, 20_000), (0.02, 40_000))
    ]
    assert errors[0] < 0.1  # 800 s at an error of (h w)^2 / 48 in the phase
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


@pytest.mark.default_parameters(theta=(0.5,), spin=((0.5, 0.0, 0.8), (10.0, 20.0, -30.0)))
@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("spin", [(0.5, 0.0, 0.8), (1e-3, 1.0, 1e-3), (0.3, 0.2, 0.1), (10.0, 20.0, -30.0)])
def test_energy_and_angular_momentum_stay(spin, theta):
    """To round-off, whatever theta is and however far the body turns in a step (37 rad in the last case)."""
    sim, body = spinning(spin, time_step=0.1, theta=theta, rotation=Rotation.random(random_state=3))
    energy, before = sim.energy.kinetic, momentum(body)
    steps = 300
    for _ in range(steps):
        sim.step()
    # a body that turns far makes parts of 0.1 rad, each rounded
    parts = steps * max(1.0, 10.0 * 0.1 * float(np.linalg.norm(spin)))
    few = 8.0 * np.finfo(float).eps * math.sqrt(parts)
    assert abs(0.5 * INERTIA @ own_spin(body) ** 2 - energy) < few * energy
    assert np.abs(momentum(body) - before).max() < few * np.linalg.norm(before)


def test_invariants_do_not_drift():
    """Over 1e5 steps: a random walk of roundings, not 1e5 of them."""
    spin, start = np.array([0.4, 0.5, 0.6]), Rotation.random(random_state=5)
    quaternion, after = turned(spin, 0.05, 100_000, start)
    few = 8.0 * np.finfo(float).eps * math.sqrt(200_000)
    assert INERTIA @ after**2 == pytest.approx(INERTIA @ spin**2, rel=few)
    before = start.apply(INERTIA * spin)
    assert np.abs(Rotation.from_quat(quaternion).apply(INERTIA * after) - before).max() < few * np.linalg.norm(before)


def test_the_error_of_a_part_is_a_twelfth_of_the_cube_of_its_angle_at_most():
    """What ``rotation.TURN`` says, of spin and rotation, for inertias that bodies can have; 0.057 is the largest."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        squares, spin = rng.random(3) + 1e-3, rng.normal(size=3)
        inertia, angle = squares.sum() - squares, 0.999 * TURN
        mass = np.concatenate([np.ones(3), inertia])[None]
        ends = []
        for parts in (1, 256):
            positions, velocities = np.array([[0.0, 0, 0, 0, 0, 0, 1]]), np.zeros((1, 6))
            velocities[0, 3:] = spin / np.linalg.norm(spin)
            for _ in range(parts):
                turn_freely(np.zeros(1, np.int64), angle / parts, positions, velocities, mass, 1.0 / mass)
            ends.append((velocities[0, 3:], 2.0 * positions[0, 3:]))
        for one, other in zip(*ends, strict=True):
            assert np.linalg.norm(one - other) < angle**3 / 12.0


def test_a_turn_about_a_principal_axis_is_exact():
    for axis in range(3):
        spin = np.zeros(3)
        spin[axis] = 7.0
        sim, body = spinning(spin, time_step=0.05, rotation=Rotation.random(random_state=axis))
        start = body.rotation
        for _ in range(200):
            sim.step()
        turned = (start * Rotation.from_rotvec(spin * sim.time)).inv() * body.rotation
        assert turned.magnitude() < 1e-13 * 200  # each step is rounded


@pytest.mark.long
def test_the_intermediate_axis_flips_at_its_period():
    """Dzhanibekov: half turns of the axis a time of 2 K / rate apart, K the complete elliptic integral."""
    start = np.array([0.0, 1.0, 0.02])
    sim, body = spinning(start, time_step=0.02)
    flips, before = [], 1.0
    while len(flips) < 3:
        sim.step()
        now = own_spin(body)[1]
        if before > 0.0 >= now or before < 0.0 <= now:
            flips.append(sim.time - sim.time_step * now / (now - before))
        before = now
    # the phase at the start is elsewhere, the distance of zeros of sn is two quarter periods
    energy, square = 0.5 * INERTIA @ start**2, (INERTIA**2) @ start**2
    high = np.array([math.sqrt((2 * energy * 3 - square) / 2), 0.0, math.sqrt((square - 2 * energy) / 6)])
    quarter = jacobi(high, 0.0)[1]
    assert np.diff(flips) == pytest.approx(2.0 * quarter, rel=2e-4)  # (h w)^2 / 12 = 3e-5, and the log of the start


@pytest.mark.parametrize("rate", [0.5, 1.0, 3.0])
def test_a_spin_far_beyond_the_step(rate):
    """At ``rate`` radians a step the body makes parts of 0.1 rad, and its spin after 50 steps is right to a percent."""
    start = np.array([0.5, 0.0, 0.8]) / math.hypot(0.5, 0.8)
    sim, body = spinning(start, time_step=rate)
    for _ in range(50):
        sim.step()
    assert np.abs(own_spin(body) - jacobi(start, sim.time)[0]).max() < 0.05


def axis_of_top(inertia, mass, lever, start, spin, time, gravity=9.81):
    """Axis of a heavy top at a time: Euler's equations for quaternion and spin, by an integrator of order 8."""

    def rate(_, state):
        turn, w = Rotation.from_quat(state[:4]), state[4:]
        moment = np.cross((0.0, 0.0, lever), turn.inv().apply((0.0, 0.0, -mass * gravity)))
        axis, last = state[:3], state[3]
        quaternion = 0.5 * np.array([*(last * w + np.cross(axis, w)), -axis @ w])
        return np.concatenate([quaternion, (moment - np.cross(w, inertia * w)) / inertia])

    found = solve_ivp(rate, (0.0, time), [*start.as_quat(), 0.0, 0.0, spin], method="DOP853", rtol=1e-11, atol=1e-12)
    return Rotation.from_quat(found.y[:4, -1]).apply((0.0, 0.0, 1.0))


def heavy_top(time_step, duration=0.5):
    """A top whose centre is held, and whose weight is a moment: error of its axis after some time."""
    inertia, mass, lever = np.array([0.02, 0.02, 0.01]), 1.0, 0.1
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    lean = Rotation.from_euler("y", 0.5)
    start = {"position": (0, 0, 0), "color": "A", "rotation": lean, "spin": lean.apply((0, 0, 40.0))}
    body = scene.add(lm.RigidBody([lm.SphereContactor(0.05)], mass=mass, inertia=inertia, **start))
    body.fix("x", "y", "z")
    sim = lm.Simulation(scene, time_step=time_step)
    while sim.time < duration - 0.5 * time_step:
        # the moment of the weight at the middle of the step, to which the body turns freely
        middle = body.rotation * Rotation.from_rotvec(0.5 * time_step * own_spin(body))
        moment = np.cross((0, 0, lever), middle.inv().apply((0, 0, -mass * 9.81)))
        body.impose_force(**dict(zip(("spin_x", "spin_y", "spin_z"), moment, strict=True)))
        sim.step()
    exact = axis_of_top(inertia, mass, lever, lean, 40.0, duration)
    return float(np.abs(body.rotation.apply((0, 0, 1)) - exact).max())


@pytest.mark.long
def test_a_heavy_top_precesses_and_nods():
    """Against Euler's equations by an integrator of order 8: second order in the step."""
    errors = [heavy_top(h) for h in (4e-3, 2e-3)]
    assert errors[1] < 8e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.3)


def test_the_drive_of_a_part_of_the_spins_works():
    """With one spin driven the others exchange energy with the drive; the balance holds over every step, with the kinetic
    energy of the free components."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    body = lm.RigidBody([lm.SphereContactor(0.1)], mass=1.0, inertia=(1.0, 2.0, 2.5), position=(0, 0, 0), color="A",
                        spin=(3.0, 0.5, 0.5))  # fmt: skip
    scene.add(body).impose_velocity(spin_x=3.0)
    sim = lm.Simulation(scene, time_step=0.01)
    start, moved = sim.energy.kinetic, 0.0
    for _ in range(200):
        before = sim.energy.kinetic
        sim.step()
        own = own_spin(body)
        moved += abs(sim.energy.drives)
        assert sim.energy.kinetic == pytest.approx(0.5 * (2.0 * own[1] ** 2 + 2.5 * own[2] ** 2), rel=1e-13)
        assert sim.energy.kinetic - before == pytest.approx(sim.energy.drives, abs=1e-14)
        assert own[0] == pytest.approx(3.0, rel=1e-14)
    assert moved > 0.1
    assert sim.energy.kinetic - start == pytest.approx(sim.energy.total_drives, rel=1e-12)
    # I_2 w_2' = (I_3 - I_1) w_3 w_1 and I_3 w_3' = (I_1 - I_2) w_1 w_2: an oscillation
    rate = 3.0 * math.sqrt(abs((2.5 - 1.0) * (1.0 - 2.0) / (2.0 * 2.5)))
    swing = np.array([math.cos(rate * sim.time), math.sin(rate * sim.time)])
    exact = 0.5 * swing[0] + 0.5 * math.sqrt(2.5 / 2.0 * 1.5 / 1.0) * swing[1]
    assert abs(own_spin(body)[1]) == pytest.approx(abs(exact), abs=5e-3)
