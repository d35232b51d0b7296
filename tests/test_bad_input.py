"""Wrong input: for every row an exception of a built-in kind, with a sentence that says what, where, and what to do.

The rows are in ``bad_input``, by subject: ``name: (call, kind, words that the sentence holds ...)``; ``w`` is the world
that the call acts on. What every sentence must be is asked of every row alike. The command line has a table of its own in
``test_bad_command_line.py``, and ``test_bad_arguments.py`` puts wrong values into every argument.
"""

from __future__ import annotations

import errno
import traceback
from pathlib import Path

import pytest
from bad_input import files, samples, scenes, simulations
from bad_input.world import World

import lmgcpy as lm

ROOT = Path(lm.__file__).parent
TABLES = (scenes.ROWS, simulations.ROWS, samples.ROWS, files.ROWS)
ROWS = {name: row for table in TABLES for name, row in table.items()}


@pytest.fixture
def w(tmp_path, monkeypatch):
    with World(tmp_path, monkeypatch) as world:
        yield world


SLOW = {"sample of a long wire"}
"""Rows of work that fails late."""


@pytest.mark.parametrize("mistake", [pytest.param(row, marks=[pytest.mark.long] * (row in SLOW)) for row in ROWS])
def test_a_mistake_gets_a_sentence(mistake, w):
    call, kind, *words = ROWS[mistake]
    with pytest.raises(kind) as caught:
        call(w)
    assert_sentence(caught.value, kind, words)
    assert {path.name for path in w.folder.iterdir()} <= {"run.h5"}  # which the world makes; nothing half-made beside it


def assert_sentence(error, kind, words):
    """What is asked of every error: its kind, that lmgcpy says it, and what a sentence is."""
    told = str(error)
    assert type(error) is kind, f"{type(error).__name__}: {told}"
    assert Path(traceback.extract_tb(error.__traceback__)[-1].filename).is_relative_to(ROOT)
    for word in words:
        assert word in told, told
    assert told[-1] in ".?", told
    assert len(told) <= 400, told
    assert "at 0x" not in told, told
    assert "\n" not in told, told


def test_the_table_is_long_enough_and_says_something_of_every_mistake():
    assert len(ROWS) == sum(map(len, TABLES)) >= 300
    assert all(len(row) >= 3 and all(row[2:]) for row in ROWS.values())


def test_a_full_disk_has_its_number(w):
    with pytest.raises(OSError, match="make room") as caught:
        w.full_disk().start().run(steps=1, record=w.path())
    assert caught.value.errno == errno.ENOSPC
    assert not list(w.folder.iterdir())


# ------------------------------------------------------------------------------------------- what a mistake leaves behind


def test_a_refused_option_does_not_use_the_scene_up(w):
    """The scene is handed over only once all is well."""
    w.beads[1].impose_velocity(y=lambda t: "fast")
    for options, words in (({"theta": 2.0}, "theta"), ({"solver": 3}, "solver"), ({}, "imposed on component y of body 1")):
        with pytest.raises((ValueError, TypeError), match=words):
            w.start(**options)
    w.beads[1]._velocities.clear()
    with pytest.raises(ValueError, match="overlap"):
        w.overlapping(overlap="stop")
    w.start(overlap="ignore").run(steps=1)


def test_a_refused_chain_leaves_the_scene_as_it_was(w):
    with pytest.raises(ValueError, match="blow"):
        w.scene.chain(w.beads, lm.RigidRod(), reference_gap=0.02, block_spin=True)
    assert w.scene.chains == []
    w.beads[0].impose_force(spin=1.0)  # so the spin was not fixed
