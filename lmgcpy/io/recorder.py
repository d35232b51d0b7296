"""Recording of a run in its file, step by step."""

from __future__ import annotations

import errno
import json
import os
import shutil
import time as clock
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, is_dataclass, replace
from typing import Any

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import number, shown, system_error
from lmgcpy.io.hdf5 import cut_off, data_sets
from lmgcpy.io.rows import Observations, Observe, Rows
from lmgcpy.io.run import Run
from lmgcpy.io.run_file.commits import Commit, read_commit, write_checkpoint, write_commit
from lmgcpy.io.run_file.creation import check_target, create, mend
from lmgcpy.io.run_file.opening import open_to_append, open_to_read
from lmgcpy.io.run_file.tables import WRONG, sentences_of_damage
from lmgcpy.scene.description import Key, asked_again, describe, functions_of_time
from lmgcpy.version import versions
from lmgcpy.writing import FileLock, replace_file

BUFFER = 1 << 25
"""Size of the buffers in bytes at which they are written, even before ``flush`` seconds have passed."""
COUNTED = {"frames": "frames/index", "interactions": "interactions", "history": "history"}
"""Table that gives each count of a commit."""
LONGEST_NOTES = 100_000
"""Number of characters of notes that a file keeps at the most."""
SPARE = 1 << 20
"""Bytes that must stay free on the disk after a write: HDF5 does not survive a full disk."""


class RunRecorder:
    """Records a run in an HDF5 file: a frame every ``every`` steps, the history of every step, and checkpoints.

    The file is open during ``Simulation.run`` only. Unwritten steps are at most ``flush`` [s] old. ``observe`` gives
    functions of the simulation by name, called after every step. ``notes`` are further data for the file, any JSON.
    """

    def __init__(
        self,
        path: str | os.PathLike,
        *,
        every: int = 10,
        flush: float = 2.0,
        force: bool = False,
        observe: Observe | None = None,
        notes: Mapping[str, Any] | None = None,
    ):
        self.path = os.fspath(path)
        self.flush_seconds = number(flush, "flush", minimum=0.0, unit="s")
        self._rows = Rows(every, Observations({} if observe is None else observe))
        self._notes = checked_notes(notes or {})
        self._force = force
        self._begun = False
        self._steps = -1
        self._functions: list[Key] = []
        self._file: Any = None
        self._held: list[Any] = []
        self._sound = True  # no write is incomplete
        self._lock: FileLock | None = None
        self._commit = Commit()
        self._provisional: Any = None
        """The last frame of the file if it is there only because its run has ended."""
        self._clear()

    @classmethod
    def going_on(cls, run: Run, steps: int, observations: Observations) -> RunRecorder:
        """The recorder of an existing file, whose last checkpoint is at step ``steps``; ValueError if it has no frame."""
        if not len(run.steps):
            raise ValueError("it has no frame")
        recorder = cls(run.path, every=run.options["every"], flush=run.options["flush"])
        recorder._rows.observations = observations
        recorder._rows.begin(run.laws, run.dimension, run.moments)
        recorder._rows.last_frame = min(int(run.steps[-1]), steps)  # later ones are made again
        recorder._begun = True
        recorder._steps = steps
        recorder._functions = functions_of_time(run.scene)
        return recorder

    @property
    def latest(self) -> dict[str, np.ndarray]:
        """Observations after the last step, by name."""
        return self._rows.latest

    def writes(self, path: str | os.PathLike) -> bool:
        """Whether this recorder has begun the file at ``path``."""
        return self._begun and os.path.abspath(path) == os.path.abspath(self.path)

    def how_to_go_on(self) -> str:
        """A sentence with the command that continues the run."""
        command = f"lmgcpy resume {self.path} --steps N"
        functions = asked_again(self._functions)
        observe = ", ".join(f'"{name}": f' for name in self._rows.observations)
        again = {"functions": functions, "observe": observe}
        if functions or observe:
            given = ", ".join(f"{what}={{{those}}}" for what, those in again.items() if those)
            command = f"lmgcpy.resume({self.path!r}, {given}).run(steps=N)"
        return f"Interrupted after step {self._steps}; go on with: {command}"

    # ------------------------------------------------------------------------------------------------------- the run

    def start(self, sim: Stepper) -> None:
        """Make the file, or open it again to continue its run; raises built-in errors with a sentence."""
        self._clear()
        if self._begun:
            if sim.steps != self._steps:
                raise RuntimeError(
                    f"'{self.path}' ends with step {self._steps}, the simulation is at step {sim.steps}: the steps between "
                    "are in no file. Record into another one."
                )
            self._reopen()
            return
        check_target(self.path, self._force)
        description = describe(sim.scene)
        if not sim.scene.bodies:
            raise ValueError("A scene without bodies has nothing to record.")
        self._functions = functions_of_time(description)
        observations = self._rows.observations
        observations.probe(sim)
        about: dict[str, Any] = {
            "created": clock.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "laws": list(dict.fromkeys(law["name"] for law in description["laws"])),
            "options": {**options(sim), "every": self._rows.every, "flush": self.flush_seconds},
            "observed": list(observations),
            "columns": observations.columns,
            "notes": self._notes,
            "versions": versions(),
        }
        self._rows.begin(about["laws"], sim.model.dimension, sim.interactions.moment.shape[1])
        # the file has another name until it holds its first frame and checkpoint, so that every run file can be continued
        unfinished = f"{self.path}.new"
        try:
            create(unfinished, about, description, sim.checkpoint(), observations.types)
            self._lock = FileLock(unfinished, self.path)
            self._open(unfinished)
            self._rows.frame(sim)
            self._put(sim, closed=False)
            replace_file(unfinished, self.path)
        except (OSError, RuntimeError) as error:
            self._release()
            with suppress(OSError):
                os.remove(unfinished)
            raise self._sentence(error, "made") from error
        self._begun = True

    def _reopen(self) -> None:
        with open_to_read(self.path) as file, sentences_of_damage(self.path):
            commit = read_commit(file)
        self._lock = FileLock(self.path)
        try:
            try:
                if not commit.closed:
                    raise OSError("its writer did not close it")
                self._open(self.path)
            except OSError:
                self._release()
                self._mend()
                self._open(self.path)
            self._commit = read_commit(self._file)
            self._clear()
            last = self._file["frames/index"][self._commit.frames - 1]
            self._provisional = last if last["step"] % self._rows.every and last["step"] == self._steps else None
            self._advance_commit(closed=False)
            self._sound = False
            self._end()
        except WRONG as error:
            self._release()
            raise self._sentence(error, "gone on with") from error
        except BaseException:
            self._release()
            raise

    def _mend(self) -> None:
        try:
            self._lock = mend(self.path, self._rows.laws)
        except WRONG as error:
            raise self._sentence(error, "mended") from error

    def enter(self, sim: Stepper) -> None:
        """Record a completed step; OSError with a sentence if the file cannot grow. The simulation does not change."""
        if self._provisional is not None:  # a run that goes on has the frames of one that was never interrupted
            first = int(self._provisional["first"])
            self._commit = replace(self._commit, frames=self._commit.frames - 1, interactions=first)
            self._rows.clear(first)
            self._provisional = None
        try:
            self._rows.enter(sim)
        except BaseException:  # a user's function failed
            self.abandon()
            raise
        self._steps = sim.steps
        if self._rows.bytes > BUFFER or clock.perf_counter() - self._flushed >= self.flush_seconds:
            self._write(sim)

    def finish(self, sim: Stepper) -> None:
        """Write the remaining rows, a frame of the last step, and a checkpoint, and close the file."""
        self._rows.end(sim)
        self._write(sim, closed=True)
        self._release()

    def abandon(self) -> None:
        """Write the rows of completed steps and close the file; the last checkpoint stays."""
        with suppress(OSError, RuntimeError):
            self._sound = False
            self._append()
            self._file.flush()
            self._advance_commit(closed=False)
            self._end()
        self._release()
        self._steps = -1

    # ------------------------------------------------------------------------------------------------------- writing

    def _clear(self) -> None:
        self._rows.clear(self._commit.interactions)
        self._pending: Commit | None = None
        self._flushed = clock.perf_counter()

    def _append(self) -> None:
        """Append the buffers to the tables; the rows become valid with the next commit."""
        counts, tables = self._commit, self._rows.tables()
        for name, rows in tables.items():
            if len(rows):
                table, first = self._file[name], counts.rows(name)
                table.resize(first + len(rows), axis=0)
                table[first:] = np.asarray(rows)
        new = {name: len(tables[table]) for name, table in COUNTED.items()}
        self._pending = replace(counts, **{name: getattr(counts, name) + count for name, count in new.items()})

    def _advance_commit(self, *, closed: bool) -> None:
        self._commit = replace(self._pending or self._commit, sequence=self._commit.sequence + 1, closed=closed)
        self._pending = None

    def _write(self, sim: Stepper, *, closed: bool = False) -> None:
        """Write the buffers, then a checkpoint, then the commit that makes both valid."""
        try:
            self._put(sim, closed=closed)
        except WRONG as error:
            self._release()
            self._steps = -1
            raise self._sentence(error, "written on") from error

    def _put(self, sim: Stepper, *, closed: bool) -> None:
        self._need(self._rows.bytes + 4 * sim.state.positions.nbytes + SPARE)
        self._sound = False
        self._append()
        self._file.flush()
        self._advance_commit(closed=closed)
        write_checkpoint(self._file, sim.checkpoint(), self._commit, self._rows.laws)
        self._end()
        self._steps = sim.steps
        self._clear()

    def _end(self) -> None:
        """Write the commit, which makes the new rows valid."""
        write_commit(self._file, self._commit)
        self._file.flush()
        self._sound = True

    def _need(self, size: int) -> None:
        free = shutil.disk_usage(os.path.dirname(os.path.abspath(self.path))).free
        if free < size:
            raise OSError(errno.ENOSPC, f"{free} bytes are left on the disk, {size} are needed")

    def _sentence(self, error: Exception, what: str) -> Exception:
        if isinstance(error, (FileExistsError, FileNotFoundError, PermissionError, IsADirectoryError, BlockingIOError)):
            return error
        if str(error).startswith((f"'{self.path}'", "The run file")):  # it is a sentence already
            return error
        remedy = "The simulation stands at the end of its last step: make room, or record into another file."
        return system_error(f"The run file '{self.path}' could not be {what}", error, remedy)

    def _open(self, path: str) -> None:
        self._file = open_to_append(path)
        self._held = data_sets(self._file)
        self._sound = True

    def _release(self) -> None:
        if self._file is not None:
            if not self._sound:
                cut_off(self._file)
            self._held = []
            with suppress(OSError, RuntimeError):
                self._file.close()
            self._file = None
        if self._lock is not None:
            self._lock.release()
            self._lock = None


def options(sim: Stepper) -> dict[str, Any]:
    """Options of a simulation, as JSON."""
    return {
        "time_step": sim.time_step,
        "theta": sim.theta,
        "on_unconverged": sim.on_unconverged,
        "geometric_stiffness": sim.geometric_stiffness,
        "solver": type(sim.solver).__name__,
        "solver_fields": asdict(sim.solver) if is_dataclass(sim.solver) else None,
    }


def checked_notes(notes: Any) -> dict[str, Any]:
    """Notes as they come back from a file; TypeError or ValueError with a sentence where a file cannot hold them."""
    if not isinstance(notes, Mapping) or not all(isinstance(name, str) and name for name in notes):
        raise TypeError(f"notes are words and numbers by name, as {{'sample': 'loose', 'batch': 3}}, got {shown(notes)}.")
    try:
        text = json.dumps({name: as_plain(value) for name, value in notes.items()}, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"notes must be words, numbers, and lists or dictionaries of these, got {shown(dict(notes))}: {error}."
        ) from error
    if len(text) > LONGEST_NOTES:
        raise ValueError(f"notes are {len(text)} characters long, at most {LONGEST_NOTES} are kept: put data into files.")
    return json.loads(text)


def as_plain(value: Any) -> Any:
    """Numbers and arrays of numpy as numbers and lists of Python; other values unchanged."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value
