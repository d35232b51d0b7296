"""The calls of the design's public face, as written there, as far as scenes and simulations go."""

from __future__ import annotations

import numpy as np

import lmgcpy as lm


def test_the_calls_work_as_written():
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    sand = lm.Material("sand", density=2600.0)
    a = scene.add(lm.disk(radius=0.01, position=(0.0, 0.5), material=sand, color="GRAIN"))
    b = scene.add(lm.disk(radius=0.01, position=(0.0, 0.47), material=sand, color="GRAIN", velocity=(0.0, 0.0), spin=0.0))
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="WALL", mass=10.0))

    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3), alert=None)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
    scene.chain([a, b], lm.RigidWire(), reference_gap=0.01)

    a.fix()
    floor.impose_velocity(y=-0.01)
    floor.impose_force(x=1.0)

    sim = lm.Simulation(scene, time_step=1e-3, theta=0.5, solver=lm.GaussSeidel(tolerance=1e-6))
    sim.run(steps=100)
    assert sim.time == np.float64(0.1) or abs(sim.time - 0.1) < 1e-12
    assert sim.positions.shape == sim.velocities.shape == (3, 2)
    assert sim.spins.shape == (3,)
    assert (a.position == sim.positions[a.id]).all()
    assert (b.velocity == sim.velocities[1]).all()
    net = sim.interactions
    assert net.law.tolist() == ["rigid-wire"]
    assert (net.candidate.tolist(), net.antagonist.tolist()) == ([1], [0])
    assert net.gap.shape == (1,)
    assert net.normal.shape == net.impulse.shape == net.force.shape == (1, 2)
    assert net.frame.shape == (1, 2, 2)
    # b hangs on a: the wire carries its weight
    assert np.allclose(net.force[0], [-b.mass * 9.81, 0.0], rtol=1e-9, atol=1e-9)
    # the floor has gone down and, pushed with 1 N, to the right
    assert np.allclose(floor.position, [0.5 * 1.0 / 10.0 * 0.1**2, -0.001])
    assert sim.report.status == "converged"
    assert sim.report.seconds <= sim.report.step_seconds
    assert sim.energy.kinetic > 0.0


def test_a_law_from_a_script(monkeypatch):
    """lm.laws.register, and a simulation with it: a contact that repels at a distance, say."""

    class Cushion(lm.Law):
        """r_n = h F where the gap is within reach, none beyond."""

        NAME = "test-cushion"
        APPLIES_TO = "contact"
        PREPARED = ("impulse",)
        TRAITS = frozenset({"push"})

        force = lm.Parameter("N", "what it pushes with", minimum=0.0)
        reach = lm.Parameter("m", "up to which gap", above=0.0)

        @staticmethod
        def prepare(gap, reference_gap, velocity, time_step, parameters, state):
            force, reach = parameters
            return (time_step * force if gap < reach else 0.0,)

        @staticmethod
        def react(W, u, prepared):
            return (prepared[0],)

    monkeypatch.setattr(lm.laws.registry, "_laws", dict(lm.laws.registry._laws))  # forgotten again afterwards
    assert lm.laws.register(Cushion) is Cushion
    assert "test-cushion" in lm.laws.names()
    assert lm.laws.get("test-cushion") is Cushion
    scene = lm.Scene(dimension=2)
    for x in (0.0, 1.05):
        scene.add(lm.disk(radius=0.5, position=(x, 0.0), mass=2.0))
    scene.see("GRAIN", "GRAIN", Cushion(force=3.0, reach=0.1), alert=0.2)
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=10)
    assert np.allclose(sim.velocities[:, 0], [-3.0 / 2.0 * 0.01, 3.0 / 2.0 * 0.01])
    assert sim.interactions.law.tolist() == ["test-cushion"]


def test_every_public_name_is_there_and_listed():
    for name in lm.__all__:
        assert hasattr(lm, name)
    assert len(set(lm.__all__)) == len(lm.__all__)
