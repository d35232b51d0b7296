"""Continuing a run in its file, bit for bit."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import named_arguments, shown
from lmgcpy.io.compare import first_difference
from lmgcpy.io.recorder import RunRecorder, options
from lmgcpy.io.rows import Observations, Observe
from lmgcpy.io.run import Run
from lmgcpy.io.run_file.tables import sentences_of_damage
from lmgcpy.scene.description import describe
from lmgcpy.writing import FileLock


@named_arguments
def take_up(
    sim: Stepper, path: str | os.PathLike, *, observe: Observe | None = None, notes: Mapping[str, Any] | None = None
) -> None:
    """Bring a new simulation of the scene of a run file to the end of the file; its runs continue in the file.

    It serves programs that build their scene at every start: functions of time need no names. ``observe`` and ``notes``
    must be those with which the file was made. Raises the errors of :func:`~lmgcpy.resume`, and ValueError if the file has
    another scene, other options or other notes; the sentence names the difference.
    """
    if not isinstance(sim, Stepper):
        raise TypeError(f"sim must be a simulation that is at its start, got {shown(sim)}.")
    with run_to_go_on(path) as run:
        if not run.options["geometric_stiffness"]:  # older files have none: their run continues without it
            sim.geometric_stiffness = False
        there = {"notes": run.notes, "scene": run.scene}
        here = {"notes": json.loads(json.dumps(dict(notes or {}))), "scene": describe(sim.scene)}
        other = other_options(sim, run) or first_difference(there, here)
        if other:
            raise ValueError(f"'{path}' is the file of another run: {other}. Name another file, or take that one away.")
        go_on(sim, run, observe)


def other_options(sim: Stepper, run: Run) -> str:
    """The first option in which a simulation differs from a run, as a clause; empty if there is none."""
    here = options(sim)
    there = {name: run.options[name] for name in here}
    if there["solver_fields"]:  # older files hold no slip and no force
        there["solver_fields"] = {"slip": None, "force": None, **there["solver_fields"]}
    return first_difference(there, here, sides=("in the file", "here"))


def run_to_go_on(path: str | os.PathLike) -> Run:
    """The run of a file that may be written; it raises a sentence if the file is read-only or being written."""
    run = Run(path)
    try:
        if not os.access(path, os.W_OK):
            raise PermissionError(f"The file '{path}' is read-only: change its permissions, or copy it, to go on with it.")
        FileLock(path).release()
    except BaseException:
        run.close()
        raise
    return run


def go_on(sim: Any, run: Run, observe: Observe | None) -> None:
    """Restore the last checkpoint, and record the next steps in the file."""
    columns = run.observed
    observations = Observations(observe or {}, {name: np.dtype((c.dtype, c.shape[1:])) for name, c in columns.items()})
    _same_names(run.path, list(columns), list(observations))
    with sentences_of_damage(run.path):
        sim.restore(run.checkpoint())
        sim.recorder = RunRecorder.going_on(run, sim.steps, observations)


def go_on_elsewhere(sim: Any, run: Run, record: str, observe: Observe | None) -> None:
    """Restore the last checkpoint, and record the next steps in another file."""
    with sentences_of_damage(run.path):
        sim.restore(run.checkpoint())
    every, flush = run.options["every"], run.options["flush"]
    sim.recorder = RunRecorder(record, every=every, flush=flush, observe=observe, notes=run.notes)


def _same_names(path: str, there: list[str], here: list[str]) -> None:
    missing, strange = [n for n in there if n not in here], [n for n in here if n not in there]
    if missing:
        again = ", ".join(f'"{name}": f' for name in there)
        raise ValueError(
            f"'{path}' observes {', '.join(missing)} by functions of the simulation, which no file can hold. Give them "
            f"again, from Python: lmgcpy.resume(path, observe={{{again}}})."
        )
    if strange:
        raise ValueError(
            f"observe names {', '.join(strange)}, which '{path}' does not observe; observations cannot be added to a file. "
            f"It observes {', '.join(there) or 'nothing'}."
        )
