"""A pendulum on a rigid link: the length does not drift.

The law drives the linearised gap at the next detection to the reference, so that at every detection the length is off
only by the second-order stretch of the last step, L (h omega)^2/2 with omega the rate at which the link turns, however
many steps there were. With u_n = 0 alone those stretches would add up: a third of the length in 1e5 steps.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import suites

import lmgcpy as lm

L, G, R = 1.0, 9.81, 0.05
RELEASE = math.radians(60.0)
FASTEST = math.sqrt(2.0 * G / L * (1.0 - math.cos(RELEASE)))
"""Greatest angular velocity [rad/s], 3.13 rad/s."""


def pendulum(law, time_step, theta=0.5):
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    pivot = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    bob = scene.add(lm.disk(radius=R, position=(L * math.sin(RELEASE), -L * math.cos(RELEASE)), mass=2.0))
    scene.chain([pivot, bob], law)
    return lm.Simulation(scene, time_step=time_step, theta=theta, solver=lm.GaussSeidel(tolerance=1e-12))


def length_errors(sim, steps):
    """Relative error of the length at the detection and at the end of each step, (steps, 2)."""
    rest = (1.0 - sim.theta) * sim.time_step
    position, velocity = sim.positions[1], sim.velocities[1]
    found = np.empty((steps, 2))
    for k in range(steps):
        (x, y), (v_x, v_y) = position.tolist(), velocity.tolist()
        found[k, 0] = math.hypot(x + rest * v_x, y + rest * v_y)
        sim.step()
        found[k, 1] = math.hypot(*position.tolist())
    return found / L - 1.0


def check_length(errors, h):
    """Never shorter, never longer than (h omega)^2/2 of the fastest swing, and no drift.

    At the end of a step (theta = 1/2) half of the last stretch is taken back already: less on both sides.
    The next order is smaller by h omega; 1e-12 is the rounding of the position over many steps.
    """
    bound = 0.5 * (h * FASTEST) ** 2 * (1.0 + 2.0 * h * FASTEST)
    at_detection, at_end = errors.T
    assert at_detection.max() < bound
    assert at_detection.min() > -1e-12
    assert np.abs(at_end).max() < bound
    assert at_detection.max() > 0.5 * bound  # the bound is what it is for


@pytest.mark.default_parameters("0.001-1.0")
@pytest.mark.scaled
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("h", [1e-3, 5e-3])
def test_the_length_error_is_bounded(h, theta):
    sim = pendulum(lm.RigidRod(), h, theta)
    check_length(length_errors(sim, suites.size(1000, long=5000)), h)


@pytest.mark.long
@pytest.mark.scaled
def test_the_length_error_is_of_second_order():
    """Largest over a second, or four, for h halved three times: slope of the logarithms; the next term is of order h."""
    steps = [8e-3, 4e-3, 2e-3, 1e-3]
    worst = [length_errors(pendulum(lm.RigidRod(), h), round(suites.size(1, long=4) / h))[:, 0].max() for h in steps]
    assert np.polyfit(np.log(steps), np.log(worst), 1)[0] == pytest.approx(2.0, abs=0.02)


@pytest.mark.long
def test_the_length_over_a_hundred_thousand_steps():
    """100 s, fifty swings of the pendulum: the error of the last tenth is that of the first, and the swing is kept.

    The impulse along the link gives back the second-order stretch, so the energy is not conserved exactly; at theta = 1/2
    it must show no upward trend: the highest point of the last swings is not above the release.
    """
    h = 1e-3
    sim = pendulum(lm.RigidRod(), h)
    errors = length_errors(sim, 90_000)
    last = length_errors(sim, 10_000)
    check_length(np.vstack([errors, last]), h)
    assert last[:, 0].max() == pytest.approx(errors[:10_000, 0].max(), rel=0.05)
    assert sim.steps == 100_000
    assert sim.energy.kinetic + 2.0 * G * (sim.positions[1, 1] + L * math.cos(RELEASE)) < 1e-3


@pytest.mark.long
def test_the_period_of_small_swings():
    """2 pi sqrt(L/g) (1 + a^2/16) at an amplitude of 0.05 rad; the step's own error is (h omega)^2/24, 4e-7."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    pivot = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    a = 0.05
    bob = scene.add(lm.disk(radius=R, position=(L * math.sin(a), -L * math.cos(a)), mass=2.0))
    scene.chain([pivot, bob], lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    crossings = []
    x = sim.positions[1, 0]
    for _ in range(4200):
        sim.step()
        if sim.positions[1, 0] * x < 0.0:  # linear interpolation of the zero
            crossings.append(sim.time - 1e-3 * abs(sim.positions[1, 0]) / (abs(sim.positions[1, 0]) + abs(x)))
        x = sim.positions[1, 0]
    period = crossings[2] - crossings[0]
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(L / G) * (1.0 + a**2 / 16.0), rel=2e-6)
