"""Steps that the solver leaves unsolved: what a loop on ``step`` says of them, and that ``run`` says it in its own way.

The scene is a column of ten grains that two sweeps a step cannot solve to 1e-12.
"""

import warnings

import pytest
from columns import unsolved

import lmgcpy as lm
from lmgcpy.experiment.compaction import DampedSimulation

ONCE = r"^Step 1, to t = 0.002 s, did not reach the solver's tolerance: budget spent.*on_unconverged='ignore'"
AT_THE_END = r"^\d+ of 5 steps did not reach the solver's tolerance"


def column(kind=lm.Simulation, **options):
    return unsolved(10, radius=0.1, kind=kind, **options)


def test_a_loop_on_step_tells_of_the_first_unsolved_step_only():
    sim = column()
    with pytest.warns(RuntimeWarning, match=ONCE) as told:
        reports = [sim.step() for _ in range(5)]
    assert not any(report.solved for report in reports)
    assert len(told) == 1
    assert told[0].filename == __file__
    assert sim.unconverged_steps == 5


def test_run_says_it_at_its_end_and_not_twice():
    """Neither in its own steps nor for those of a loop before; and a loop after it has its own word."""
    sim = column()
    with pytest.warns(RuntimeWarning) as told:
        sim.run(steps=5)
    assert len(told) == 1
    told[0].message.args[0].index("5 of 5 steps")
    with pytest.warns(RuntimeWarning, match="^Step 6, "):
        sim.step()
    with pytest.warns(RuntimeWarning, match=AT_THE_END) as told:
        sim.run(steps=5)
    assert len(told) == 1
    sim.step()


def test_a_run_that_failed_leaves_the_word_to_the_loop_again():
    sim = column()
    with pytest.raises(ZeroDivisionError):
        sim.run(steps=5, until=lambda sim: 1 // 0)
    with pytest.warns(RuntimeWarning, match="^Step 2, "):
        sim.step()


def test_who_ignores_unsolved_steps_hears_nothing():
    sim = column(on_unconverged="ignore")
    for _ in range(5):
        sim.step()
    assert sim.unconverged_steps == 5


@pytest.mark.parametrize("kind", ["plain", "damped"])
@pytest.mark.parametrize("reaction", ["warn", "stop"])
def test_the_step_is_made_where_its_word_is_an_error(kind, reaction):
    """Where warnings are errors, and where unsolved steps are to stop: the state is that after the step."""
    make = {
        "plain": lambda **options: column(**options),
        "damped": lambda **options: column(DampedSimulation, drag_time=0.1, **options),
    }[kind]
    expected = make(on_unconverged="ignore")
    expected.run(steps=3)
    sim = make(on_unconverged=reaction)
    words = {"warn": (RuntimeWarning, "did not reach"), "stop": (RuntimeError, "^Step 1, to t = 0.002 s, was not solved")}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(words[reaction][0], match=words[reaction][1]):
            sim.step()
    assert sim.steps == sim.unconverged_steps == 1
    sim.on_unconverged = "ignore"
    sim.run(steps=2)
    assert (sim.positions == expected.positions).all()
    assert (sim.velocities == expected.velocities).all()
    assert sim.time == expected.time


def test_every_unsolved_step_stops_who_asked_for_it():
    sim = column(on_unconverged="stop")
    for step in (1, 2):
        with pytest.raises(RuntimeError, match=f"^Step {step}, "):
            sim.step()
