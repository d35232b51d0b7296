"""A test step by step: observed, ended by its rule, kept in memory or in a run file from which it goes on."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from lmgcpy.io.kept import KeptRun
from lmgcpy.io.observations import Observe
from lmgcpy.io.recorder import RunRecorder
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.take_up import take_up
from lmgcpy.simulation import Simulation

FLUSH = 2.0
"""How old what is not yet in the file may become [s]."""

Rule = Callable[[Mapping[str, np.ndarray]], bool]
"""Whether a test is over, from the last rows of its observations, the newest last."""


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
) -> KeptRun | Run:
    """Make ``steps`` steps, fewer where the ``rule`` ends the test, and give them back as a run, to be closed.

    The rule is asked after every step, with the last ``window`` rows of what the functions ``observe`` say. With a
    ``file`` the run is kept in it; if it is there already, the simulation, which is at its start, goes on from where the
    file ends, and a test that was over is only read. ``notes``: what makes a test the same beside its scene and
    options. A frame is kept ``every`` so many steps; ``on_step`` is told how many steps are done.

    Raises KeyboardInterrupt where ``interrupted`` ends the test between two steps, with a good file; ValueError where the
    file is that of another test.
    """
    recent: dict[str, deque] = {name: deque(maxlen=window) for name in observe}
    if file is None:
        sim.recorder = KeptRun(every=every, observe=observe)
    elif not os.path.exists(file):
        sim.recorder = RunRecorder(file, every=every, flush=FLUSH, observe=observe, notes=notes)
    else:
        take_up(sim, file, observe=observe, notes=notes)
        _cut_to_the_checkpoint(sim, file)
        with open_run(file) as run:
            for name, rows in recent.items():
                rows.extend(run.observed[name][max(0, sim.steps - window) :])
        if on_step:
            on_step(sim.steps)
    recorder = sim.recorder
    assert isinstance(recorder, (KeptRun, RunRecorder))

    def stopped() -> bool:
        return interrupted is not None and interrupted()

    def over() -> bool:
        return sim.steps >= steps or (rule is not None and rule({name: np.array(rows) for name, rows in recent.items()}))

    def ended(sim: Simulation) -> bool:
        for name, value in recorder.latest.items():
            recent[name].append(value)
        if on_step:
            on_step(sim.steps)
        return over() or stopped()

    if not (over() or stopped()):
        sim.run(steps - sim.steps, until=ended)
    sim.recorder = None
    if not over():
        raise KeyboardInterrupt(recorder.how_to_go_on())
    return recorder if isinstance(recorder, KeptRun) else open_run(recorder.path)


def _cut_to_the_checkpoint(sim: Simulation, file: str | os.PathLike) -> None:
    """Of a killed run: forget the rows of steps that will be made again."""
    with open_run(file) as run:
        if run.closed:
            return
    sim.run(0)
