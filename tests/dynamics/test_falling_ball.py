"""A ball on a floor: without rebound, and with Newton's."""

from __future__ import annotations

import math

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


@pytest.mark.default_parameters("law0-0.5", "law1-1.0")
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


@pytest.mark.default_parameters("0.5-0.5181-0.002")
@pytest.mark.parametrize("h", [2e-3, 1e-3, 2.5e-4])
@pytest.mark.parametrize("height", [0.47, 0.5, 0.5181])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 1.0])
def test_the_height_of_the_rebound(e, height, h):
    """e^2 H up to O(h). The ball turns in step k, the first with g_m = H - g h^2 k (k + 1)/2 <= 0, and then has a speed
    of e g k h exactly and a height of g_m + e g k h^2/2. From there on it flies freely, to

        top = e^2 H + (1 - e^2) g_m + e (1 - e) v h/2,    -v h < g_m <= 0,    v = g k h <= sqrt(2 g H),

    which is never off by more than v h; the steps sample the parabola and miss its top by at most g h^2/8.
    """
    k = math.ceil(0.5 * (math.sqrt(1.0 + 8.0 * height / (G * h**2)) - 1.0))
    sim = drop(lm.Restitution(restitution=e), height=height, time_step=h, steps=k)
    assert sim.velocities[0, 1] == pytest.approx(-G * k * h, rel=1e-12)
    sim.step()
    assert sim.velocities[0, 1] == pytest.approx(e * G * k * h, rel=1e-12)
    top = sim.positions[0, 1] - R
    for _ in range(math.ceil(e * k) + 1):
        sim.step()
        top = max(top, sim.positions[0, 1] - R)
    v = G * k * h
    predicted_gap = height - 0.5 * G * h**2 * k * (k + 1)
    exact = e**2 * height + (1.0 - e**2) * predicted_gap + 0.5 * e * (1.0 - e) * v * h
    assert exact - G * h**2 / 8.0 - 1e-12 <= top <= exact + 1e-12
    assert abs(top - e**2 * height) <= v * h


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


@pytest.mark.long
def test_an_elastic_ball_keeps_its_energy():
    """e = 1 turns the velocity round at a mean velocity of zero, so the ball ends that step where it began it.

    Neither gravity nor contact does any work there, and at theta = 1/2 gravity's is exact elsewhere: over ten bounces,
    6400 steps, the energy of 10 J stays to round-off, 6400 * 1e-15 * 10.
    """
    sim = drop(lm.Restitution(restitution=1.0), height=0.5, time_step=1e-3)
    bounces = 0
    for _ in range(6400):
        falling = sim.velocities[0, 1] < 0.0
        sim.step()
        bounces += falling and sim.velocities[0, 1] > 0.0
        total = sim.energy.kinetic + M * G * (sim.positions[0, 1] - R)
        assert total == pytest.approx(M * G * 0.5, abs=6e-11)
    assert bounces == 10


def test_a_fast_ball_does_not_enter_the_floor():
    """At 20 m/s and 2 ms a step it goes 40 mm a step and is seen at 30 mm before the floor, or not at all.

    The least alert distance, 20 mm, would not do: it grows with the speed.
    """
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(0.0, 1.03), mass=M, velocity=(0.0, -20.0)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=2e-3)
    for _ in range(100):
        sim.step()
        assert sim.positions[0, 1] >= R - 1e-15
    assert sim.positions[0, 1] == pytest.approx(R, abs=1e-15)
