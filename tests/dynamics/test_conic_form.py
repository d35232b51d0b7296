"""The conic form of a step: of laws that are not registered, that have none, and whose own fails."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def hanging(law, solver, links=40):
    """A chain with a heavy tip, which sweeps link by link do not solve."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(links + 1):
        scene.add(lm.disk(radius=0.01, position=(0.1 * i, 0.0), mass=1e3 if i == links else 1.0))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, law)
    return lm.Simulation(scene, time_step=1e-3, solver=solver)


def needing_newton():
    """Link by link, so that Newton steps are asked for."""
    return lm.Newton(tolerance=1e-10, wire_blocks=False)


class Unregistered(lm.RigidWire):
    """Never registered: a law of a script."""

    NAME = "test-unregistered"


def test_a_law_that_is_not_registered_takes_newton_steps():
    """It ran on sweeps and died of LookupError where Newton steps were asked for. A rod of the same form is the measure."""
    sim = hanging(Unregistered(), needing_newton())
    known = hanging(lm.RigidWire(), needing_newton())
    for _ in range(20):
        assert sim.step().solved
        known.step()
    assert sim.report.factorisations > 0
    np.testing.assert_array_equal(sim.positions, known.positions)


def test_its_step_is_a_problem_that_can_be_solved_and_written(tmp_path):
    sim = hanging(Unregistered(), lm.Auto(tolerance=1e-10), links=2).run(steps=3)
    problem = sim.problem()
    assert problem.cones.tolist() == [1, 1]
    solution = lm.solve(problem, solver=lm.Newton(tolerance=1e-10))
    np.testing.assert_allclose(solution.impulses[:, 0], sim.interactions.impulse[:, 0], rtol=1e-8)
    lm.io.fclib.write(problem, tmp_path / "problem.h5")
    assert lm.io.fclib.read(tmp_path / "problem.h5").laws == ("rigid-wire", "rigid-wire")


class Broken(lm.RigidWire):
    """Its conic form has a fault of its author's, which is a TypeError, as that of a law without one is."""

    NAME = "test-broken-conic"

    @staticmethod
    def conic(prepared):
        return prepared[0] + None, 0.0, 0.0


def law_of(name):
    """A law without a conic form."""
    return type("Without", (lm.RigidWire,), {"NAME": name, "conic": None})()


@pytest.mark.parametrize("solver", [lm.Newton, lm.Auto])
def test_a_fault_in_conic_is_told_with_the_laws_name(solver):
    """It came out as "budget spent"."""
    sim = hanging(Broken(), solver(tolerance=1e-12, wire_blocks=False))
    with pytest.raises(RuntimeError, match=r"In the step from t = .* conic of law 'test-broken-conic' raised TypeError"):
        sim.run(steps=200)


def test_a_law_without_one_is_swept_by_auto_and_refused_by_newton():
    hanging(law_of("test-without"), lm.Auto(tolerance=1e-9)).run(steps=3)
    with pytest.raises(TypeError, match="Law 'test-without' has no conic form"):
        hanging(law_of("test-without"), needing_newton()).run(steps=200)


@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e5)])
@pytest.mark.parametrize("drawn", [0.0, 1e-15])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_link_between_held_bodies_is_left_out(dimension, drawn, law):
    """Its impulse moves nothing: W = 0. In Newton steps ``u / W`` was no number, so that they ended as if all were solved,
    and sweeps went on alone: in a net with a fixed rim, in a chain with two held beads next to each other. Beside it stands
    a tower of disks of 1 and 101 kg, which takes thousands of sweeps."""
    scene = lm.Scene(dimension=dimension, gravity=(0.0, -9.81, 0.0)[:dimension])
    grain, zero = (lm.disk if dimension == 2 else lm.sphere), (0.0,) * (dimension - 2)
    floor = scene.add(lm.wall(point=(0.0, 0.0, *zero), normal=(0.0, 1.0, *zero)))
    for i in range(20):
        scene.add(grain(radius=0.01, position=(0.0, 0.01 + 0.02 * i, *zero), mass=1.0 + 100.0 * (i % 2)))
    for other in (floor.color, "GRAIN"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    posts = [scene.add(grain(radius=0.01, position=(1.0 + 0.1 * i, 1.0, *zero), mass=1.0, color="POST")) for i in (0, 1)]
    for post in posts:
        post.fix()
    scene.chain(posts, law, reference_gap=0.08 - drawn)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Newton(tolerance=1e-9))
    report = sim.step()
    assert report.solved
    assert report.iterations == 100
    assert report.factorisations > 0
    assert len(sim.problem().mu) == 20
