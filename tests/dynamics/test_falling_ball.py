"""A ball on a floor: without rebound, and with Newton's."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

R, M, G = 0.1, 2.0, 9.81


def drop(law, *, height, time_step, steps=0, theta=0.5, floor_mass=None):
    """A ball whose lowest point is at ``height`` over a floor."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=R, position=(0.0, R + height), mass=M))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", law)
    return lm.Simulation(scene, time_step=time_step, theta=theta, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=steps)


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("law", [lm.Signorini(), lm.Coulomb(friction=0.4)])
def test_without_rebound_it_comes_to_rest_on_the_floor(law, theta):
    """The step in which the gap would close ends with the predicted gap at zero; one step later the ball is at rest.

    So it neither rebounds nor hovers nor sinks: its gap is zero to the rounding of a position (1e-16 m).
    """
    sim = drop(law, height=0.5, time_step=1e-3, steps=400, theta=theta)
    assert sim.positions[0, 1] - R == pytest.approx(0.0, abs=1e-15)
    # the rounding of the gap over h: 1e-13 m/s
    assert sim.velocities[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert sim.interactions.force[0, 0] == pytest.approx(M * G, rel=1e-9)


def test_the_energy_of_a_ball_without_rebound():
    """What gravity has put in, m g H, the contact has taken out: the sums of the balance over the run."""
    sim = drop(lm.Signorini(), height=0.5, time_step=1e-3, steps=400)
    assert sim.energy.total_loads == pytest.approx(M * G * 0.5, rel=1e-12)
    assert sim.energy.total_interactions["signorini"] == pytest.approx(-M * G * 0.5, rel=1e-12)


@pytest.mark.parametrize("h", [1e-3, 2.5e-4])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 1.0])
def test_the_height_of_the_rebound(e, h):
    """e^2 H up to O(h): the ball is v h deep at most when it is turned, and up to g h faster than at the surface.

    With y the depth at which it turns, 0 <= y <= v h, its speed is sqrt(2 g (H + y)), and the top of the rebound is at
    e^2 (H + y) - y: between e^2 H - (1 - e^2) v h and e^2 H. The speed changes by g h a step, which at the turning step
    is half a step out, once, on either side: g h/2 of speed, 1.1 v h/2 e^2 of height, and e v h/2 for the half step
    in which position and velocity do not belong together.
    """
    height = 0.5
    v = math.sqrt(2.0 * G * height)
    sim = drop(lm.Restitution(restitution=e), height=height, time_step=h)
    top, struck = 0.0, False
    for _ in range(round((1.0 + 1.2 * e) * v / G / h)):
        sim.step()
        struck = struck or sim.energy.interactions.get("restitution", 0.0) != 0.0
        if sim.velocities[0, 1] > 0.0:
            top = max(top, sim.positions[0, 1] - R)
    error = top - e**2 * height
    if e == 0.0:
        assert top == 0.0
        assert struck
    else:
        assert -(1.0 - e**2) * v * h - (e + e**2) * v * h <= error <= (e + e**2) * v * h


def test_the_height_of_the_rebound_converges_to_the_right_one():
    """The error of the test above, averaged over the position of the impact within a step, falls as h."""
    mean = []
    for h in (2e-3, 1e-3, 5e-4):
        errors = []
        for height in np.linspace(0.45, 0.55, 15):
            sim = drop(lm.Restitution(restitution=0.8), height=height, time_step=h)
            top = 0.0
            for _ in range(round(0.64 / h)):
                sim.step()
                if sim.velocities[0, 1] > 0.0:
                    top = max(top, sim.positions[0, 1] - R)
            errors.append(abs(top - 0.64 * height))
        mean.append(np.mean(errors))
    order = np.polyfit(np.log([2e-3, 1e-3, 5e-4]), np.log(mean), 1)[0]
    assert order == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_newtons_law_between_two_disks(e):
    """u_n^+ = -e u_n^-, exactly, in the step in which they overlap; the momentum stays: masses 1 and 3, at 4 m/s.

    v_1 = (m_1 - e m_2)/(m_1 + m_2) v, v_2 = (1 + e) m_1/(m_1 + m_2) v.
    """
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(-0.2015, 0.0), mass=1.0, velocity=(4.0, 0.0)))
    scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=3.0))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=e))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=5)
    assert sim.velocities[:, 0] == pytest.approx([(1.0 - 3.0 * e), (1.0 + e)], abs=1e-13)


def test_an_elastic_ball_keeps_its_energy():
    """e = 1: over ten bounces the energy at the top stays within what a turning inside the floor can do, 2 m g v h."""
    h = 5e-4
    sim = drop(lm.Restitution(restitution=1.0), height=0.5, time_step=h)
    v = math.sqrt(2.0 * G * 0.5)
    deviation = 0.0
    for _ in range(round(10 * 2.0 * v / G / h)):
        sim.step()
        total = sim.energy.kinetic + M * G * (sim.positions[0, 1] - R)
        deviation = max(deviation, abs(total - M * G * 0.5))
    assert deviation < 10 * 2.0 * M * G * v * h
    assert abs(sim.energy.total_interactions["restitution"]) < 10 * 2.0 * M * G * v * h


def test_a_fast_ball_does_not_enter_the_floor():
    """From 20 m/s at 2 ms a step a ball goes 40 mm a step, twice the least alert distance: the alert grows with it."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(0.0, 1.013), mass=M, velocity=(0.0, -20.0)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=2e-3)
    for _ in range(100):
        sim.step()
        assert sim.positions[0, 1] >= R - 1e-15
    assert sim.positions[0, 1] == pytest.approx(R, abs=1e-15)
