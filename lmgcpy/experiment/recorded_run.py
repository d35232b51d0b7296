"""A test step by step: observed, ended by its rule, recorded in a run file, from which it goes on."""

from __future__ import annotations

import os
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from lmgcpy.io.recorder import RunRecorder
from lmgcpy.io.rows import Observe
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.take_up import take_up
from lmgcpy.simulation import Simulation

FLUSH = 2.0
"""Greatest age of data that are not yet in the file [s]."""
NO_FLUSH = 1e9
"""Greatest age for a temporary file [s]: it is written only at the end, as no test goes on from it."""

Rule = Callable[[Mapping[str, np.ndarray]], bool]
"""Function that returns whether a test is over, from the last rows of its observations and of the solver's "status", a
word; the newest row is the last one."""


class TemporaryRun(Run):
    """A run in a file of a temporary directory, which is deleted when the run is closed."""

    def __init__(self, path: str, directory: tempfile.TemporaryDirectory):
        self._directory: tempfile.TemporaryDirectory | None = None
        super().__init__(path)
        self._directory = directory

    def close(self) -> None:
        """Close and delete the file; arrays that were read stay."""
        super().close()
        if self._directory is not None:
            self._directory.cleanup()
            self._directory = None


def carry_out(
    sim: Simulation,
    *,
    steps: int,
    observe: Observe,
    every: int,
    notes: Mapping[str, Any],
    rule: Rule | None = None,
    window: int = 0,
    file: str | os.PathLike | None = None,
    on_step: Callable[[int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Run:
    """Make ``steps`` steps, fewer if the ``rule`` ends the test, and return the run, which the caller closes.

    The rule is called after every step with the last ``window`` rows of the results of the functions ``observe``, and of
    the solver's "status", a word. The run is recorded in the ``file``. If the file exists, the simulation, which is at its
    start, goes on from where the file ends, and a test that is over is only read. Without a ``file`` the run is recorded in
    a temporary file, which is deleted when the run is closed. ``notes``: data that identify a test beside its scene and its
    options. A frame is recorded every ``every`` steps; ``on_step`` is called with the number of steps done.

    Raises KeyboardInterrupt if ``interrupted`` ends the test between two steps; the file is then complete up to there.
    Raises ValueError if the file belongs to another test.
    """
    with _run_file(file) as (path, directory):
        recent: dict[str, deque] = {name: deque(maxlen=window) for name in (*observe, "status")}
        if not os.path.exists(path):
            flush = FLUSH if directory is None else NO_FLUSH
            sim.recorder = RunRecorder(path, every=every, flush=flush, observe=observe, notes=notes)
        else:
            take_up(sim, path, observe=observe, notes=notes)
            _cut_to_the_checkpoint(sim, path)
            with open_run(path) as run:
                first = max(0, sim.steps - window)
                for name, rows in recent.items():
                    rows.extend(run.status[first:] if name == "status" else run.observed[name][first:])
            if on_step:
                on_step(sim.steps)
        recorder = sim.recorder
        assert isinstance(recorder, RunRecorder)

        def stopped() -> bool:
            return interrupted is not None and interrupted()

        def over() -> bool:
            if sim.steps >= steps or rule is None:
                return sim.steps >= steps
            return rule({name: np.array(rows) for name, rows in recent.items()})

        def ended(sim: Simulation) -> bool:
            for name, value in recorder.latest.items():
                recent[name].append(value)
            recent["status"].append(sim.report.status)
            if on_step:
                on_step(sim.steps)
            return over() or stopped()

        if not (over() or stopped()):
            sim.run(steps - sim.steps, until=ended)
        sim.recorder = None
        if not over():
            raise KeyboardInterrupt(recorder.how_to_go_on())
        return open_run(path) if directory is None else TemporaryRun(path, directory)


@contextmanager
def _run_file(file: str | os.PathLike | None) -> Iterator[tuple[str, tempfile.TemporaryDirectory | None]]:
    """The path of the run file; if there is no ``file``, a path in a temporary directory.

    The directory is deleted if the block fails.
    """
    if file is not None:
        yield os.fspath(file), None
        return
    directory = tempfile.TemporaryDirectory(prefix="lmgcpy-", ignore_cleanup_errors=True)
    try:
        yield os.path.join(directory.name, "run.h5"), directory
    except BaseException as error:
        directory.cleanup()
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt("Interrupted; there is no file to go on from.") from None
        raise


def _cut_to_the_checkpoint(sim: Simulation, file: str) -> None:
    """Forget the rows of steps that a killed run made after its last checkpoint: they are made again."""
    with open_run(file) as run:
        if run.closed:
            return
    sim.run(0)
