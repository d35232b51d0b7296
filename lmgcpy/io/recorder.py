"""Writes a run into its file while it is made."""

from __future__ import annotations

import errno
import os
import platform
import shutil
import sys
import time as clock
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np

from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.errors import number, whole
from lmgcpy.io import run_format as form
from lmgcpy.io.hdf5 import h5py
from lmgcpy.scene.description import describe, functions_of_time
from lmgcpy.solve.report import STATUS

BUFFER = 1 << 25
"""Bytes that are written out at once, however little time has passed."""
SPARE = 1 << 20
"""Bytes that must be left on the disk beyond what is written: HDF5 does not survive a disk that is full."""


class RunRecorder:
    """Keeps a run in an HDF5 file: a frame ``every`` so many steps, the history of every step, checkpoints.

    The file is open during ``Simulation.run`` only. ``flush`` [s]: how old what is not yet in it may become.
    """

    def __init__(self, path: str | os.PathLike, *, every: int = 10, flush: float = 2.0, force: bool = False):
        self.path = os.fspath(path)
        self.every = whole(every, "every", minimum=1)
        self.flush_seconds = number(flush, "flush", minimum=0.0, unit="s")
        self._force = force
        self._begun = False
        self._steps = -1
        self._laws: list[str] = []
        self._functions: list[tuple[int, str]] = []
        self._dimension = 2
        self._file: Any = None
        self._lock: form.Lock | None = None
        self._commit = form.Commit()
        self._clear()
        form.check_target(path, force)

    @classmethod
    def going_on(
        cls, path: str | os.PathLike, about: dict[str, Any], description: dict[str, Any], steps: int
    ) -> RunRecorder:
        """The recorder of a file that is there, whose last checkpoint is at so many steps."""
        recorder = cls.__new__(cls)
        recorder.path = os.fspath(path)
        recorder.every = int(about["options"]["every"])
        recorder.flush_seconds = float(about["options"]["flush"])
        recorder._force = False
        recorder._begun = True
        recorder._steps = steps
        recorder._laws = list(about["laws"])
        recorder._functions = functions_of_time(description)
        recorder._dimension = int(description["dimension"])
        recorder._file = recorder._lock = None
        recorder._commit = form.Commit()
        recorder._clear()
        return recorder

    def writes(self, path: str | os.PathLike) -> bool:
        """Whether that is the file this recorder has begun."""
        return self._begun and os.path.abspath(path) == os.path.abspath(self.path)

    def how_to_go_on(self) -> str:
        way = f"lmgcpy resume {self.path} --steps N"
        if self._functions:
            again = ", ".join(f'({body}, "{name}"): f' for body, name in self._functions)
            way = f"lmgcpy.resume({self.path!r}, functions={{{again}}}).run(steps=N)"
        return f"Interrupted after step {self._steps}; go on with: {way}"

    # ------------------------------------------------------------------------------------------------------- the run

    def start(self, sim: Simulation) -> None:
        """Make the file, or open it again where a run went on; raises built-in errors with a sentence."""
        self._clear()
        if self._begun:
            if sim.steps != self._steps:
                raise RuntimeError(
                    f"'{self.path}' ends with step {self._steps}, the simulation is at step {sim.steps}: the steps between "
                    "are in no file. Record into another one."
                )
            self._reopen()
            return
        description = describe(sim.scene)
        if not sim.scene.bodies:
            raise ValueError("A scene without bodies has nothing to record.")
        self._dimension = sim.model.dimension
        self._functions = functions_of_time(description)
        self._laws = list(dict.fromkeys(law["name"] for law in description["laws"]))
        about = {
            "created": clock.strftime("%Y-%m-%dT%H:%M:%S%z"),
            "laws": self._laws,
            "options": {
                "time_step": sim.time_step,
                "theta": sim.theta,
                "on_unconverged": sim.on_unconverged,
                "solver": type(sim.solver).__name__,
                "solver_fields": asdict(sim.solver) if is_dataclass(sim.solver) else None,
                "every": self.every,
                "flush": self.flush_seconds,
            },
            "versions": versions(),
        }
        # under another name until it holds its first frame and checkpoint: what has the name is a run to go on with
        beside = f"{self.path}.new"
        try:
            form.create(beside, about, description, sim.checkpoint())
            self._lock = form.Lock(beside, self.path)
            self._file = form.open_to_append(beside)
            self._frame(sim)
            self._write(sim)
            os.replace(beside, self.path)
        except (OSError, RuntimeError) as error:
            self._release()
            with suppress(OSError):
                os.remove(beside)
            raise self._sentence(error, "made") from error
        self._begun = True

    def _reopen(self) -> None:
        with form.open_to_read(self.path) as file, form.sentences_of_damage(self.path):
            commit = form.read_commit(file)
        self._lock = form.Lock(self.path)
        try:
            try:
                if not commit.closed:
                    raise OSError("its writer did not close it")
                self._file = form.open_to_append(self.path)
            except OSError:
                self._release()
                with form.sentences_of_damage(self.path):
                    self._lock = form.mend(self.path, self._laws)
                self._file = form.open_to_append(self.path)
            self._commit = form.read_commit(self._file)
            self._advance_commit(closed=False)
            form.write_commit(self._file, self._commit)
            self._file.flush()
        except BaseException:
            self._release()
            raise

    def enter(self, sim: Simulation) -> None:
        """A step was made; OSError with a sentence where the file cannot grow, with the simulation as it is."""
        report, energy = sim.report, sim.energy
        row: tuple[Any, ...] = (
            *(sim.steps, sim.time, report.iterations, report.residual, STATUS.index(report.status), report.interactions),
            *(report.seconds, report.step_seconds, energy.kinetic, energy.loads, energy.drives, energy.defect),
        )
        if self._laws:
            work, stored = energy.interactions, energy.stored
            row += ([work.get(law, 0.0) for law in self._laws], [stored.get(law, 0.0) for law in self._laws])
        self._history.append(row)
        self._bytes += 200
        self._steps = sim.steps
        if sim.steps % self.every == 0:
            self._frame(sim)
        if self._bytes > BUFFER or clock.perf_counter() - self._flushed >= self.flush_seconds:
            self._write(sim)

    def finish(self, sim: Simulation) -> None:
        """Write the rest and a checkpoint, and close."""
        self._write(sim, closed=True)
        self._release()

    def abandon(self) -> None:
        """Write what is known of whole steps and close; the last checkpoint stands."""
        with suppress(OSError, RuntimeError):
            self._append()
            self._file.flush()
            self._advance_commit(closed=False)
            form.write_commit(self._file, self._commit)
            self._file.flush()
        self._release()
        self._steps = -1

    # ------------------------------------------------------------------------------------------------------- writing

    def _clear(self) -> None:
        self._history: list[tuple] = []
        self._index: list[tuple] = []
        self._positions: list[np.ndarray] = []
        self._velocities: list[np.ndarray] = []
        self._interactions: list[np.ndarray] = []
        self._pending: form.Commit | None = None
        self._bytes = 0
        self._flushed = clock.perf_counter()

    def _frame(self, sim: Simulation) -> None:
        net = self._net(sim)
        first = self._commit.interactions + sum(len(part) for part in self._interactions)
        self._index.append((sim.time, sim.steps, first, len(net)))
        self._positions.append(sim.state.positions.copy())
        self._velocities.append(sim.state.velocities.copy())
        self._interactions.append(net)
        self._bytes += 2 * self._positions[-1].nbytes + net.nbytes

    def _net(self, sim: Simulation) -> np.ndarray:
        if sim._last is None:
            return np.zeros(0, dtype=form.interaction_type(self._dimension))
        problem, interactions = sim._last
        net = np.zeros(len(interactions.gap), dtype=form.interaction_type(self._dimension))
        net["candidate"], net["antagonist"] = interactions.candidate, interactions.antagonist
        for group in problem.groups:
            net["law"][group.start : group.stop] = self._laws.index(group.law.NAME)
        net["gap"], net["normal"] = interactions.gap, interactions.normal
        net["impulse"] = problem.system.impulse
        return net

    def _append(self) -> None:
        """Enter the buffers into the tables; they count from the next commit on."""
        counts = self._commit
        history = np.array(self._history, dtype=form.history_type(len(self._laws)))
        index = np.array(self._index, dtype=form.INDEX)
        net = np.concatenate(self._interactions or [np.zeros(0, dtype=form.interaction_type(self._dimension))])
        frames = {"frames/index": index, "frames/positions": self._positions, "frames/velocities": self._velocities}
        tables: dict[str, Any] = {**frames, "interactions": net, "history": history}
        for name, rows in tables.items():
            if len(rows):
                table, first = self._file[name], counts.rows[name]
                table.resize(first + len(rows), axis=0)
                table[first:] = np.asarray(rows)
        self._pending = form.Commit(
            counts.sequence, counts.frames + len(index), counts.interactions + len(net), counts.history + len(history)
        )

    def _advance_commit(self, *, closed: bool) -> None:
        pending = self._pending or self._commit
        self._commit = form.Commit(self._commit.sequence + 1, pending.frames, pending.interactions, pending.history, closed)
        self._pending = None

    def _write(self, sim: Simulation, *, closed: bool = False) -> None:
        """The buffers, then, when these are in the file, a checkpoint and the commit that makes them count."""
        try:
            self._need(self._bytes + 4 * sim.state.positions.nbytes + SPARE)
            self._append()
            self._file.flush()
            self._advance_commit(closed=closed)
            form.write_checkpoint(self._file, sim.checkpoint(), self._commit, self._laws)
            form.write_commit(self._file, self._commit)
            self._file.flush()
        except (OSError, RuntimeError) as error:
            self._release()
            self._steps = -1
            raise self._sentence(error, "written on") from error
        self._steps = sim.steps
        self._clear()

    def _need(self, size: int) -> None:
        free = shutil.disk_usage(os.path.dirname(os.path.abspath(self.path))).free
        if free < size:
            raise OSError(errno.ENOSPC, f"{free} bytes are left on the disk, {size} are needed")

    def _sentence(self, error: Exception, what: str) -> Exception:
        if isinstance(error, (FileExistsError, FileNotFoundError, PermissionError, IsADirectoryError, BlockingIOError)):
            return error
        return OSError(
            getattr(error, "errno", None) or errno.EIO,
            f"The run file could not be {what}: {getattr(error, 'strerror', None) or error}. The simulation is as it was "
            "after its last step: make room and record into another file",
            self.path,
        )

    def _release(self) -> None:
        if self._file is not None:
            with suppress(OSError, RuntimeError):
                self._file.close()
            self._file = None
        if self._lock is not None:
            self._lock.release()
            self._lock = None


def versions() -> dict[str, str]:
    """Versions of all that the numbers depend on."""
    import numba

    import lmgcpy

    h5 = h5py()
    return {
        "lmgcpy": lmgcpy.__version__,
        "numpy": np.__version__,
        "numba": numba.__version__,
        "h5py": h5.__version__,
        "hdf5": h5.version.hdf5_version,
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "machine": platform.machine(),
    }
