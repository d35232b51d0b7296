"""Calls of a simulation inside the functions that its run calls: the file is what happened."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def scene():
    made = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(3):
        made.add(lm.disk(radius=0.1, position=(0.25 * i, 0.5), mass=1.0))
    made.add(lm.wall(point=(0, 0), normal=(0, 1)))
    made.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return made


def restore(sim):
    sim.restore(sim.checkpoint())


def lift_the_guard(sim):
    sim.recorder = None


CALLS = {
    "step": (lambda sim: sim.step(), "step cannot be called in {} of a run that is recorded"),
    "restore": (restore, "restore cannot be called in {} of a run that is recorded"),
    "run": (lambda sim: sim.run(steps=2), "run cannot be called inside a run"),
    "run into another file": (lambda sim: sim.run(steps=2, record="other.h5"), "run cannot be called inside a run"),
    "add": (lambda sim: sim.scene.add(lm.disk(radius=0.1, position=(5, 5), mass=1.0)), "number of bodies cannot change"),
    "recorder": (lift_the_guard, "recorder cannot change in a run"),
    "time step": (lambda sim: setattr(sim, "time_step", 5e-3), "time_step cannot change"),
}


@pytest.mark.default_parameters(what=("run",), asked=("observe",))
@pytest.mark.parametrize("asked", ["on_step", "until", "observe"])
@pytest.mark.parametrize("what", CALLS)
def test_a_call_inside_a_recorded_run_leaves_no_hole_in_its_file(what, asked, tmp_path, monkeypatch):
    """Refused with a sentence; the file holds steps 1 to 8 and their times, and goes on to the bits of a run without."""
    monkeypatch.chdir(tmp_path)
    call, words = CALLS[what]
    refused = []

    def attempt(sim):
        if sim.steps == 3:
            with pytest.raises(RuntimeError, match=words.format(asked)):
                call(sim)
            refused.append(sim.steps)
        return asked == "observe" and 1.0

    sim = lm.Simulation(scene(), time_step=1e-3)
    asks = {"observe": {"x": attempt}} if asked == "observe" else {asked: attempt}
    sim.run(steps=8, record="run.h5", every=1, **asks)
    assert refused
    with lm.io.open_run("run.h5") as run:
        assert run.history[:]["step"].tolist() == list(range(1, 9))
        assert run.history[:]["time"] == pytest.approx(1e-3 * np.arange(1, 9), rel=1e-12)
        assert np.asarray(run.steps).tolist() == list(range(9))
    again = lm.resume("run.h5", **({"observe": {"x": attempt}} if asked == "observe" else {})).run(steps=4)
    assert np.array_equal(again.state.positions, lm.Simulation(scene(), time_step=1e-3).run(steps=12).state.positions)


def test_steps_inside_a_run_without_a_file_are_steps():
    sim = lm.Simulation(scene(), time_step=1e-3)
    sim.run(steps=5, on_step=lambda sim: sim.step())
    assert sim.steps == 10
    assert np.array_equal(sim.state.positions, lm.Simulation(scene(), time_step=1e-3).run(steps=10).state.positions)


def test_a_run_inside_a_run_is_refused_and_the_run_can_be_called_again():
    sim = lm.Simulation(scene(), time_step=1e-3)
    with pytest.raises(RuntimeError, match="inside a run"):
        sim.run(steps=5, on_step=lambda sim: sim.run(steps=1))
    assert sim.run(steps=5).steps == 6


@pytest.mark.parametrize("call", ["step", "run", "restore", "checkpoint"])
def test_a_function_of_time_cannot_make_steps(call):
    """It is called in the middle of one, which is not made."""
    made, tried = scene(), []

    def load(time):
        if not tried and time > 2e-3:
            tried.append(time)
            calls[call]()
        return 0.0

    made.bodies[0].impose_force(x=load)
    sim = lm.Simulation(made, time_step=1e-3)
    kept = sim.checkpoint()
    calls = {"step": sim.step, "run": lambda: sim.run(steps=1), "restore": lambda: sim.restore(kept)}
    calls["checkpoint"] = sim.checkpoint
    sim.run(steps=2)
    before = sim.state.positions.copy()
    with pytest.raises(RuntimeError, match="A step is under way"):
        sim.step()
    assert np.array_equal(sim.state.positions, before)
    untried = lm.Simulation(scene(), time_step=1e-3).run(steps=5)
    assert np.array_equal(sim.run(steps=3).state.positions, untried.state.positions)
