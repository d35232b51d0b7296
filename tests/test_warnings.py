"""Warnings name the user's line, from wherever in lmgcpy they come."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest

import lmgcpy as lm
from lmgcpy.errors import warn


def heap(**options):
    """Two disks, one on the other, of which the upper one falls."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for y in (0.1, 0.3):
        scene.add(lm.disk(radius=0.1, position=(0.0, y), mass=1.0, **options))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return scene


def unsolved():
    return lm.Simulation(heap(), time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-14, slip=1e-15, max_iterations=1))


def by_step():
    unsolved().step()


def by_run():
    unsolved().run(steps=2)


def by_a_recorded_run(folder):
    unsolved().run(steps=2, record=folder / "run.h5")


def fast():
    lm.Simulation(heap(velocity=(200.0, 0.0)), time_step=1e-3).run(steps=1)


def overlapping():
    scene = heap()
    scene.add(lm.disk(radius=0.1, position=(0.15, 0.2), mass=1.0))
    lm.Simulation(scene, time_step=1e-3)


@pytest.mark.parametrize("call", [by_step, by_run, fast, overlapping], ids=lambda call: call.__name__)
def test_a_warning_names_the_line_that_called(call):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert caught
    code = call.__code__
    last = max(line for *_, line in code.co_lines() if line is not None)
    for warning in caught:
        assert Path(warning.filename) == Path(__file__)
        assert code.co_firstlineno < warning.lineno <= last


def test_of_a_recorded_run_too(tmp_path):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        by_a_recorded_run(tmp_path)
    assert {Path(warning.filename) for warning in caught} == {Path(__file__)}


def test_without_a_line_of_the_user_it_is_told_all_the_same():
    """As in a thread, whose first function may be lmgcpy's own."""
    with pytest.warns(RuntimeWarning, match="a sentence"):
        warn("a sentence")
