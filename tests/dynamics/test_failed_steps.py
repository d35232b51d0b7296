"""A step in which a number stops being finite, or an imposed function fails, is not made: the simulation is as it was."""

from __future__ import annotations

import math

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.contact.contactor_pairs import _pairs

nan, inf = math.nan, math.inf


class Switch:
    """A function of time that gives what it should, or what it is set to."""

    def __init__(self, sound):
        self.sound, self.fault = sound, None

    def __call__(self, time):
        return self.sound(time) if self.fault is None else self.fault(time)


class Solver(lm.GaussSeidel):
    """A solver from elsewhere that may hand out what is no number, and say that all is well."""

    fault = False

    def solve(self, step):
        result = super().solve(step)
        if Solver.fault:
            step.system.impulse[-1] = nan
        return result


@pytest.fixture
def switches(monkeypatch):
    monkeypatch.setattr(Solver, "fault", False)
    return {"load": Switch(lambda t: 3.0 * math.sin(50.0 * t)), "drive": Switch(lambda t: 0.2 * math.cos(70.0 * t))}


def pile(switches):
    """Grains thrown together over a floor that shakes, two of them linked; fast enough for new lists of neighbours."""
    rng = np.random.default_rng(1)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    grains = []
    for i in range(16):
        start = {"position": (0.21 * (i % 4), 0.11 + 0.2 * (i // 4)), "velocity": rng.normal(0.0, 2.0, 2)}
        grains.append(scene.add(lm.disk(radius=0.1, mass=1.0, spin=rng.normal(), **start)))
    grains[3].impose_force(x=switches["load"])
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(y=switches["drive"])
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.4))
    scene.chain(grains[8:11], lm.ElasticWire(stiffness=1e4))
    return lm.Simulation(scene, time_step=5e-3, solver=Solver(tolerance=1e-3))


def same(a, b):
    """Two checkpoints, to the last bit."""
    for name in ("positions", "velocities", "time", "steps", "unconverged_steps", "worst_residual", "energy"):
        np.testing.assert_equal(getattr(a, name), getattr(b, name), err_msg=name)
    for name in ("identity", "impulse", "state", "listed", "listed_at", "reach", "rebuilds"):
        np.testing.assert_equal(getattr(a.memory, name), getattr(b.memory, name), err_msg=name)


def set_load(value):
    return lambda sim, switches: setattr(switches["load"], "fault", lambda t: value)


def set_drive(function):
    return lambda sim, switches: setattr(switches["drive"], "fault", function)


FAULTS = {
    "load NaN": (set_load(nan), FloatingPointError,
        "imposed on component x of body 3 at t = 0.0525 s must be finite, got nan"),
    "load infinite": (set_load(inf), FloatingPointError,
        "component x of body 3 at t = 0.0525 s must be finite, got inf"),
    "load beyond all": (set_load(-1e200), FloatingPointError,
        "body 3 at t = 0.0525 s must be at most 1e+70 in size, got -1e+200"),
    "load in words": (set_load("3 N"), TypeError,
        "on component x of body 3 at t = 0.0525 s must be a number, got '3 N'"),
    "load of nothing": (set_load(None), TypeError,
        "on component x of body 3 at t = 0.0525 s must be a number, got None"),
    "load of many": (set_load([1.0, 2.0]), TypeError, "body 3 at t = 0.0525 s must be a number, got [1.0, 2.0]"),
    "load too large for its body": (set_load(9e69), FloatingPointError,
        "In the step from t = 0.05 s a number stopped being finite", "velocity along x [m/s] of body 3 is"),
    "drive NaN": (set_drive(lambda t: nan), FloatingPointError,
        "component y of body 16 at t = 0.055 s must be finite, got nan"),
    "drive that fails": (set_drive(lambda t: 1 // 0), RuntimeError,
        "function of time imposed on component y of body 16 at t = 0.055 s failed with ZeroDivisionError"),
    "drive of no argument": (set_drive(lambda: 1.0), RuntimeError,
        "component y of body 16 at t = 0.055 s failed with TypeError"),
    "solver": (lambda sim, switches: setattr(Solver, "fault", True), FloatingPointError,
        "In the step from t = 0.05 s a number stopped", "Solver gave the impulse [nan,", "to law 'coulomb' between"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_failed_step_leaves_all_as_it_was(fault, switches):
    """Twenty steps with a failed one among them are twenty steps, bit for bit."""
    spoil, kind, *words = FAULTS[fault]
    whole = pile(switches).run(steps=20)
    sim = pile(switches).run(steps=10)
    before, energy = sim.checkpoint(), sim.energy
    if fault == "load too large for its body":
        sim.model.inverse_mass[3, 0] = 1e4  # a body of a tenth of a gram: 9e69 N in 5 ms make 4.5e71 m/s
    spoil(sim, switches)
    for _ in range(2):
        with pytest.raises(kind) as caught:
            sim.step()
        for word in words:
            assert word in str(caught.value)
        same(before, sim.checkpoint())
        assert sim.energy is energy
        assert len(sim.interactions) == 0
        with pytest.raises(RuntimeError, match="no step yet"):
            sim.problem()
    sim.model.inverse_mass[3, 0] = 1.0
    switches["load"].fault = switches["drive"].fault = None
    Solver.fault = False
    same(whole.checkpoint(), sim.run(steps=10).checkpoint())
    assert len(sim.interactions) > 0


def test_a_failed_step_that_made_a_new_list_of_neighbours_keeps_what_is_remembered(switches):
    """Every step fails once. Some of them have made a new list, whose order is another one."""
    sim, listed = pile(switches), 0
    for _ in range(30):
        before = sim.checkpoint()
        Solver.fault = True
        with pytest.raises(FloatingPointError):
            sim.step()
        Solver.fault = False
        same(before, sim.checkpoint())
        sim.step()
        listed += sim.checkpoint().memory.rebuilds - before.memory.rebuilds
    assert listed > 10
    same(pile(switches).run(steps=30).checkpoint(), sim.checkpoint())


def test_what_is_written_into_the_state_is_checked(switches):
    """Live views may be written to; a number that is none is found before detection, which it would send astray."""
    for name, index, value, words in (
        ("velocities", (2, 0), nan, "velocity along x [m/s] of body 2 is nan without impulses"),
        ("positions", (4, 1), inf, "y [m] of body 4 is inf in its middle"),
        ("spins", 5, 1e300, "spin [rad/s] of body 5 is 1e+300 without impulses"),
    ):
        sim = pile(switches).run(steps=1)
        getattr(sim, name)[index] = value
        with pytest.raises(FloatingPointError, match=r"In the step from t = 0\.005 s a number stopped") as caught:
            sim.step()
        assert words in str(caught.value)


def test_a_body_that_flies_off_is_named():
    """In its second step of 1 s it is beyond what can be squared; detection copes with the first."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=1.0, position=(5.0, 0.0), mass=1.0))
    scene.add(lm.disk(radius=1.0, position=(0.0, 0.0), mass=1.0)).impose_velocity(x=9e69)
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1.0)
    with pytest.warns(RuntimeWarning, match="more than half its radius"):
        sim.step()
    words = r"In the step from t = 1 s a number stopped being finite: x \[m\] of body 1 is 1\.35e\+70 in its middle"
    with pytest.raises(FloatingPointError, match=words):
        sim.step()
    assert sim.positions[1, 0] == 9e69


class Sleeve(lm.Contactor):
    KIND = "test-sleeve"
    shape, bounding_radius, area, second_moment = (0.1,), 0.1, 0.03, 1e-4


def narrow(position_c, shape_c, position_a, shape_a):
    """A disk on a wall whose contact point, or gap, gets lost near the wall."""
    height = position_c[1] - position_a[1] - shape_c[0]
    lost = math.sqrt(height - 0.05) * 0.0
    if shape_c[0] > 0.15:
        return height + lost, (0.0, 1.0), (position_c[0], position_c[1])
    return height, (0.0, 1.0), (position_c[0] + lost, position_c[1])


@pytest.mark.long
@pytest.mark.parametrize(
    ("radius", "what"), [(0.1, "returned a contact point nan m"), (0.2, r"raised ValueError\('math domain error'\)")]
)
def test_a_narrow_phase_that_loses_itself_is_named(radius, what, monkeypatch):
    monkeypatch.setitem(_pairs, ("test-sleeve", "wall"), None)
    lm.contact.register_pair("test-sleeve", "wall", narrow)
    sleeve = type("Sleeve", (Sleeve,), {"shape": (radius,), "bounding_radius": radius})()
    scene = lm.Scene(dimension=2)
    body = lm.RigidBody([sleeve], mass=1.0, inertia=1.0, position=(0.0, radius + 0.06), color="SLEEVE", velocity=(0, -1))
    scene.add(body)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("SLEEVE", "WALL", lm.Coulomb(friction=0.1), alert=1.0)
    sim = lm.Simulation(scene, time_step=1e-3)
    words = rf"In the step from t = 0\.01 s the narrow phase test-sleeve-wall .* between bodies 0 and 1 {what}"
    with pytest.raises(RuntimeError, match=words):
        sim.run(steps=20)
    assert sim.steps == 10


class Tired(lm.RigidWire):
    """A wire whose stored energy gets lost beyond a gap of 0.945 m."""

    NAME = "test-tired"

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        return math.sqrt(0.945 - gap)


def test_an_energy_that_gets_lost_is_named():
    """The third gap grows from 0.9 m by 0.01 m a step, and the energy is that of the gap at the end of the step."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.05, position=(float(i), 0.0), mass=1.0)) for i in range(4)]
    for bead in beads[:3]:
        bead.fix()
    beads[3].impose_velocity(x=0.1)
    scene.chain(beads, Tired(), reference_gap=2.0)
    sim = lm.Simulation(scene, time_step=0.1)
    sim.run(steps=4)
    before = sim.checkpoint()
    with pytest.raises(FloatingPointError, match="energy of law 'test-tired' between bodies 3 and 2 returned") as caught:
        sim.run(steps=2)
    same(before, sim.checkpoint())
    assert f"In the step from t = {sim.time:g} s a number stopped being finite" in str(caught.value)


# ----------------------------------------------------------------------------------------------------------- run files


def test_the_file_of_a_run_that_halts_stays_good(switches, tmp_path):
    """It opens, tells of all whole steps, and leads on to what a run without a fault gives."""
    path = tmp_path / "run.h5"
    whole = pile(switches).run(steps=30)

    class Failing(Solver):
        def solve(self, step):
            Solver.fault = sim.steps == 20
            return super().solve(step)

    sim = pile(switches)
    sim.solver = Failing(tolerance=1e-3)
    with pytest.raises(FloatingPointError, match=r"In the step from t = 0\.1 s"):
        sim.run(steps=30, record=path, every=5)
    with lm.io.open_run(path) as run:
        assert len(run.history) == 20
        assert run.steps.tolist() == [0, 5, 10, 15, 20]
        assert np.isfinite(run.positions[:]).all()
    told = CliRunner().invoke(main, ["info", str(path)])
    assert told.exit_code == 0, told.output
    functions = {(3, "x"): switches["load"], (16, "y"): switches["drive"]}
    Solver.fault = False
    again = lm.resume(path, functions=functions, solver=Solver(tolerance=1e-3))
    assert again.steps <= 20
    again.run(steps=30 - again.steps)
    same(whole.checkpoint(), again.checkpoint())
    sim.solver = Solver(tolerance=1e-3)
    same(whole.checkpoint(), sim.run(steps=10).checkpoint())


class Huge(lm.Signorini):
    """A law whose bias no step can have."""

    NAME = "test-huge"

    @staticmethod
    def conic(prepared):
        return (prepared[0] + 1e80, 0.0, 0.0)


def test_numbers_that_grew_without_bound_are_an_error_of_the_step():
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", Huge())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)  # sweeps ask no conic form
    with pytest.raises(FloatingPointError, match="In the step from t = 0 s numbers grew without bound: q of a problem"):
        sim.problem()
