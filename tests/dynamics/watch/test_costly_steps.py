"""A step that costs fifty times the median of the run is reported once, with its worst interaction."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.watch import Said
from lmgcpy.dynamics.watch.costly_steps import CostlySteps
from lmgcpy.solve.problems.report import Report, Worst

WORST = Worst("coulomb", 3, 7, 0.01)


def of_sweeps(sweeps, interactions=100_000, newton=0):
    return Report(
        iterations=sweeps,
        factorisations=newton,
        interactions=interactions,
        worst=WORST,
        status="stagnated",
        step_seconds=2.0,
    )


def test_the_median_is_known_to_a_quarter_octave():
    watch, rng = CostlySteps(Said()), np.random.default_rng(0)
    sweeps = rng.lognormal(3.0, 1.5, 1001).astype(int) + 1
    for k, count in enumerate(sweeps):
        watch.after_step(of_sweeps(int(count), interactions=1), k, 0.0)
    assert 1.0 <= watch._median() / np.median(sweeps) <= 2.0**0.25


def test_it_is_said_once_with_the_worst_interaction():
    watch = CostlySteps(Said())
    for k in range(20):
        assert watch.after_step(of_sweeps(10), k, 0.0) == []
    assert watch.after_step(of_sweeps(500), 20, 0.02) == []  # 50 times the median, but not of the upper end of its class
    (sentence,) = watch.after_step(of_sweeps(1000), 21, 0.021)
    assert sentence.startswith("Step 21, to t = 0.021 s, took 1000 sweeps over 100000 interactions in 2 s, some 88 times")
    assert "ended 'stagnated'. The worst interaction: coulomb between bodies 3 and 7, off by 1.00e-02 m/s" in sentence
    assert watch.after_step(of_sweeps(5000), 22, 0.022) == []


@pytest.mark.parametrize(
    ("usual", "last"),
    [
        ([10] * 19, of_sweeps(4000)),  # too early to know what is usual
        ([10] * 40, of_sweeps(4000, interactions=100)),  # a small scene: nobody waits for it
        ([0] * 40, of_sweeps(4000)),  # bodies flew, and now meet
        ([100] * 40, of_sweeps(4000)),  # usual
    ],
)
def test_what_is_not_said(usual, last):
    watch = CostlySteps(Said())
    for k, sweeps in enumerate(usual):
        watch.after_step(of_sweeps(sweeps), k, 0.0)
    assert watch.after_step(last, len(usual), 0.0) == []


def test_newton_steps_count():
    watch = CostlySteps(Said())
    for k in range(30):
        watch.after_step(of_sweeps(2), k, 0.0)
    (sentence,) = watch.after_step(of_sweeps(100, newton=20), 30, 0.0)
    assert "100 sweeps and 20 Newton steps" in sentence


@pytest.mark.parametrize("answer", ["warn", "ignore"])
def test_a_lid_that_jams_into_a_pile(answer, monkeypatch):
    """A lid stands still for 29 steps, then crushes a column that cannot yield: the step costs thousands of sweeps.

    The least work is that of a large scene."""
    monkeypatch.setattr("lmgcpy.dynamics.watch.costly_steps.LEAST", 1e4)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(10):
        scene.add(lm.disk(radius=0.1, position=(0.0, 0.2 * i + 0.1), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    lid = scene.add(lm.wall(point=(0.0, 2.0), normal=(0.0, -1.0)))
    lid.impose_velocity(y=lambda t: 0.0 if t < 0.0295 else -1.0)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    solver = lm.GaussSeidel(tolerance=1e-6, max_iterations=5000)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged=answer)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(33):
            sim.step()
    said = [str(warning.message) for warning in caught if "times the work" in str(warning.message)]
    assert len(said) == (1 if answer == "warn" else 0)
    if said:
        assert said[0].startswith("Step 30, to t = 0.03 s, took ")
        assert "The worst interaction: coulomb between bodies" in said[0]
