"""Motion without interactions: what the theta-method does by itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm


def fly(time_step, theta, *, duration=1.0, gravity=(0.0, 0.0), load=None, velocity=(0.0, 0.0), spin=0.0):
    scene = lm.Scene(dimension=2, gravity=gravity)
    body = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=2.0, velocity=velocity, spin=spin))
    if load is not None:
        body.impose_force(x=load)
    return lm.Simulation(scene, time_step=time_step, theta=theta).run(duration=duration)


def test_under_constant_gravity_it_is_exact_at_one_half():
    """The parabola x = v t, y = v t - g t^2/2, and a spin that stays: midpoint and trapezium are exact for constant g.

    1000 steps, of a rounding of 1e-16 of numbers below 10 each: 1e-12.
    """
    sim = fly(1e-3, 0.5, gravity=(0.0, -9.81), velocity=(3.0, 4.0), spin=2.5)
    assert sim.positions[0] == pytest.approx([3.0, 4.0 - 0.5 * 9.81], abs=1e-12)
    assert sim.velocities[0] == pytest.approx([3.0, 4.0 - 9.81], abs=1e-12)
    assert sim.spins[0] == 2.5
    assert sim.rotations[0] == pytest.approx(2.5, abs=1e-12)


@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_under_constant_gravity_the_error_is_known(theta):
    """Each step adds g h^2 (1/2 - theta) to the parabola: after T the position is off by g h T (1/2 - theta)."""
    sim = fly(1e-2, theta, gravity=(0.0, -9.81))
    assert sim.positions[0, 1] == pytest.approx(-0.5 * 9.81 + 9.81 * 1e-2 * (0.5 - theta), abs=1e-12)


@pytest.mark.parametrize(("theta", "order"), [(0.5, 2), (1.0, 1)])
def test_order_under_a_load_that_varies_in_time(theta, order):
    """m x'' = F cos(w t), x = F/(m w^2) (1 - cos(w t)): slope of log(error) over log(h) for five halvings of h.

    The next term of the error is smaller by h w or its square, at most 0.1 in the coarsest step; it shifts the fit by
    a few hundredths. The cap at the finest step is the leading term with a margin of two: w^2 h^2 / 12 of the amplitude
    at theta = 1/2, h/2 times the velocity, below 1 m/s, at theta = 1.
    """
    w, force = 3.0, 7.0
    steps = [0.04 / 2**k for k in range(5)]
    exact = force / (2.0 * w**2) * (1.0 - math.cos(w))
    errors = [abs(fly(h, theta, load=lambda t: force * math.cos(w * t)).positions[0, 0] - exact) for h in steps]
    fitted = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert fitted == pytest.approx(order, abs=0.05)
    cap = 2.0 * (w * steps[-1]) ** 2 / 12.0 * exact if order == 2 else steps[-1]
    assert errors[-1] < cap


def test_the_free_energy_balance_of_gravity():
    """At theta = 1/2 the work of the loads is m g times the fall, to round-off, and it is the kinetic energy."""
    sim = fly(1e-3, 0.5, gravity=(0.0, -9.81))
    assert sim.energy.total_loads == pytest.approx(2.0 * 9.81 * 0.5 * 9.81, rel=1e-12)
    assert sim.energy.kinetic == pytest.approx(sim.energy.total_loads, rel=1e-12)


def test_duration_and_steps_say_the_same():
    by_steps, by_duration = (
        lm.Simulation(scene, time_step=1e-3) for scene in (lm.Scene(dimension=2), lm.Scene(dimension=2))
    )
    assert by_steps.run(steps=37).steps == by_duration.run(duration=0.037).steps == 37
    assert by_steps.time == by_duration.time == pytest.approx(0.037, abs=1e-15)
