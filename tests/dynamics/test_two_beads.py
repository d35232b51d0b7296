"""Two beads on a rigid wire: slack, taut, and the snap between the two."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

MASS = np.array([1.0, 2.5])
R = 0.05


def thrown_apart(law, *, theta, slack=0.2, gravity=(0.0, 0.0), spins=(3.0, -1.0)):
    """Two beads a metre apart on an oblique line, thrown apart and aside; ``slack`` of the wire between them."""
    scene = lm.Scene(dimension=2, gravity=gravity)
    a = scene.add(lm.disk(radius=R, position=(0.3, -0.2), mass=MASS[0], velocity=(-1.0, 0.7), spin=spins[0]))
    b = scene.add(lm.disk(radius=R, position=(0.9, 0.6), mass=MASS[1], velocity=(2.0, 0.4), spin=spins[1]))
    scene.chain([a, b], law, reference_gap=1.0 - 2 * R + slack)
    return lm.Simulation(scene, time_step=1e-3, theta=theta, solver=lm.GaussSeidel(tolerance=1e-12))


def momenta(sim):
    x, y = sim.positions.T
    v_x, v_y = sim.velocities.T
    spin = (0.5 * MASS * R**2) @ sim.spins
    return np.array([MASS @ v_x, MASS @ v_y, MASS @ (x * v_y - y * v_x) + spin])


@pytest.mark.default_parameters("0.7")
@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
def test_momentum_through_the_snap(theta):
    """Linear and angular momentum, in every step: r acts along the line of the centres at the detection configuration.

    There the change of m q x v is q_m x r, opposite for the two; and q - q_m is along v. Round-off of ten operations on
    numbers below 10, over 500 steps: 500 * 10 * 10 * 1.1e-16 = 6e-12.
    """
    sim = thrown_apart(lm.RigidWire(), theta=theta)
    before = momenta(sim)
    tensions = []
    for _ in range(500):
        sim.step()
        tensions.append(-sim.interactions.impulse[0, 0])
        assert momenta(sim) == pytest.approx(before, abs=6e-12)
    tensions = np.array(tensions)
    drawn = int(np.argmax(tensions > 0.0))
    assert drawn > 50
    # a blow, in one step or two, then the pull of the turning
    assert tensions[drawn : drawn + 2].max() > 10.0 * tensions[drawn + 3 :].max()


def test_the_wire_is_slack_until_its_reference_gap():
    """The step before the snap is free flight; the step of the snap ends with a predicted gap at the reference."""
    sim = thrown_apart(lm.RigidWire(), theta=0.5, slack=0.2)
    start = sim.velocities.copy()
    while sim.interactions.impulse.sum() == 0.0:
        before = sim.velocities.copy()
        sim.step()
    assert np.array_equal(before, start)
    view = sim.interactions
    u_n = (sim.velocities[1] - sim.velocities[0]) @ view.normal[0]
    assert view.gap[0] + 1e-3 * u_n == pytest.approx(1.2 - 2 * R, abs=1e-15)


def test_the_impulse_of_the_snap():
    """p = (u_n + (g_m - g_ref)/h) / (1/m_1 + 1/m_2), along the wire, in tension; spins are not touched."""
    sim = thrown_apart(lm.RigidWire(), theta=0.5, slack=0.0)
    relative = sim.velocities[1] - sim.velocities[0]
    sim.step()
    view = sim.interactions
    p = (relative @ view.normal[0] + (view.gap[0] - 0.9) / 1e-3) / (1.0 / MASS).sum()
    assert p > 0.0
    assert view.impulse[0] == pytest.approx([-p, 0.0], rel=1e-12)
    assert sim.spins.tolist() == [3.0, -1.0]


def test_a_wire_does_not_push():
    """Thrown towards each other on a wire the beads meet it as slack, on a rod they cannot."""
    for law, free in [(lm.RigidWire(), True), (lm.RigidRod(), False)]:
        scene = lm.Scene(dimension=2)
        a = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0, velocity=(1.0, 0.0)))
        b = scene.add(lm.disk(radius=R, position=(1.0, 0.0), mass=1.0, velocity=(-1.0, 0.0)))
        scene.chain([a, b], law)
        sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=10)
        assert sim.velocities[:, 0] == pytest.approx([1.0, -1.0] if free else [0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e4)])
def test_a_blocked_spin_takes_no_part(law):
    """block_spin holds the spin of every bead of the chain, whatever its link does."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    a = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix("x", "y")
    b = scene.add(lm.disk(radius=R, position=(0.6, 0.0), mass=1.0, spin=5.0))
    scene.chain([a, b], law, block_spin=True)
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=50)
    assert sim.spins.tolist() == [0.0, 0.0]
    assert sim.velocities[1, 1] < -0.1


def test_a_wire_of_stiff_relaxation_is_drawn_in_over_its_time():
    """A wire 20 % too long with relaxation 0.1 s: its reference falls linearly, so it shortens at 2 m/s, no blow.

    The reference gap is that of the start of the step: the wire lags by one step.
    """
    scene = lm.Scene(dimension=2)
    a = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    b = scene.add(lm.disk(radius=R, position=(1.2, 0.0), mass=1.0))
    scene.chain([a, b], lm.RigidRod(), reference_gap=1.0 - 2 * R, relaxation=0.1)
    sim = lm.Simulation(scene, time_step=1e-3, theta=1.0, solver=lm.GaussSeidel(tolerance=1e-12))
    fastest = 0.0
    for k in range(150):
        assert sim.positions[1, 0] == pytest.approx(1.2 - 2.0 * min(max(k - 1, 0) * 1e-3, 0.1), abs=1e-12)
        sim.step()
        fastest = max(fastest, abs(sim.velocities[1, 0]))
    assert fastest == pytest.approx(2.0, rel=1e-9)
