"""Runs of a simulation: many steps, with a file, a bar, observations and an end."""

from __future__ import annotations

import logging
import os
import time as clock
import warnings
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import file_path, flag, named_arguments, number, shown, whole
from lmgcpy.simulation.interrupt import between_steps

log = logging.getLogger("lmgcpy")


class Recorder(Protocol):
    """What keeps a run, for example in a file; it is called after every step, between steps."""

    def start(self, sim: Stepper) -> None:
        """A run begins."""

    def enter(self, sim: Stepper) -> None:
        """A step was made."""

    def finish(self, sim: Stepper) -> None:
        """The run ends between two steps."""

    def abandon(self) -> None:
        """A step failed, and was not made."""

    def how_to_go_on(self) -> str:
        """A sentence for a user who interrupted the run."""
        ...


class Simulation(Stepper):
    """Steps a scene through time.

    ``time_step`` h [s]; ``theta`` in [0.5, 1] of the time stepping, 0.5 is of second order in free motion and keeps the
    energy; ``solver``: of the problem of each step, ``Auto()`` if none is given. The scene is compiled
    and cannot be edited any more; its bodies become views of the simulation's state.

    ``on_unconverged``: what is done about steps that the solver did not solve to its tolerance: "warn" (one RuntimeWarning
    at the end of a ``run``, and in a loop on ``step`` one at the first such step), "stop" (RuntimeError after such a step,
    which is made) or "ignore"; ``unconverged_steps`` counts them, ``worst_residual`` keeps their largest residual and
    ``worst_slip`` their largest slip (since the start or the last restore), in any case.

    ``overlap``: what to do where bodies that see each other overlap at the start by more than 5 % of the smaller radius:
    "warn" (one RuntimeWarning with their number and the worst), "stop" (ValueError) or "ignore". Contact laws leave an
    old penetration as it is, so that such a start is legal, but rarely meant; what solvers leave in a sample at rest is
    less, and is not told.

    A body so far from the origin that its position is rounded by more than a thousandth of its radius is refused
    (ValueError).

    ``threads``: how many may share the solver's work on a scene of 5000 bodies or more; ``sim.threads = 2`` changes it
    between steps. Nothing else depends on it: the results have the same bits for any number.

    ``geometric_stiffness``: False leaves out what is done where links turn by more than the step resolves
    (``lmgcpy/dynamics/geometric_stiffness.py``, ``turning_stretch.py``), to see what it does: beads may then zigzag and
    make energy.

    Beside what is below it has ``steps``, made so far; ``report`` and ``energy`` of the last step, a :class:`Report
    <lmgcpy.solve.report.Report>` and an :class:`Energy <lmgcpy.dynamics.energy.Energy>`; and its ``scene``.

    The loop, for velocities v, positions q, external forces F, and impulses r along H::

        q_m    = q + (1 - theta) h v              detection at q_m
        v_free = v + h M^-1 F                     imposed components take their value at the end of the step
        solve  u = H^T v_free + W r and the laws
        v      = v_free + M^-1 H r
        q      = q_m + theta h v

    Where links would make energy as they are pulled back, the positions go another way than the velocities
    (``lmgcpy/dynamics/turning_stretch.py``).
    """

    recorder: Recorder | None = None
    """Keeps every run that names no file of its own; set by ``lmgcpy.resume``."""

    @named_arguments
    def run(
        self,
        steps: int | None = None,
        *,
        duration: float | None = None,
        progress: bool = False,
        record: str | os.PathLike | None = None,
        every: int = 10,
        flush: float = 2.0,
        force: bool = False,
        observe: Mapping[str, Callable[[Simulation], Any]] | None = None,
        until: Callable[[Simulation], bool] | None = None,
    ) -> Simulation:
        """Make so many steps, or as many as the duration [s] takes; returns the simulation itself.

        ``progress``: a bar, where standard error is a terminal. ``record``: a run file to write (HDF5), with a frame
        ``every`` so many steps and the history of every step; what is not yet in it is at most ``flush`` [s] old, in
        time of the clock. A file that is there already is replaced only with ``force``. A recorded run that is
        interrupted (Ctrl-C) ends between steps, with a good file.

        ``observe``: functions of the simulation by name, called after every step; each returns a number or an array of
        the same shape at every step, before the first as well, and the values are kept in the run file. ``until``: called
        after every step with the simulation; the run ends early where it says so.
        """
        if (steps is None) == (duration is None):
            raise TypeError("run takes either steps or duration [s], one of the two.")
        if duration is not None:
            steps = round(number(duration, "duration", minimum=0.0, unit="s") / self.time_step)
        turns: Any = range(whole(steps, "steps"))
        flag(progress, "progress")
        if until is not None and not callable(until):
            raise TypeError(f"until must be a function of the simulation, got {shown(until)}.")
        recorder = self.recorder
        if record is not None:
            from lmgcpy.io.recorder import RunRecorder  # h5py takes as long to import as all the rest

            record = file_path(record, "record")
            if not (isinstance(recorder, RunRecorder) and recorder.writes(record)):
                recorder = RunRecorder(record, every=every, flush=flush, force=force, observe=observe)
                observe = None
        if observe is not None:
            raise TypeError(
                "observe is kept in the run file that record= begins"
                + (": name one." if recorder is None else "; of a run that goes on it is given to lmgcpy.resume.")
            )
        begin, already, unconverged = clock.perf_counter(), self.steps, self.unconverged_steps
        if recorder is not None:
            recorder.start(self)
        if progress:
            from tqdm import tqdm

            turns = tqdm(turns, desc="lmgcpy", unit="step", disable=None)
        self._running = True
        try:
            if recorder is None:
                for _ in turns:
                    self.step()
                    if self._over(until):
                        break
            else:
                self._run_recorded(turns, recorder, until)
        finally:
            self._running = False
        log.info("%s", _Summary(self, self.steps - already, clock.perf_counter() - begin))
        unconverged = self.unconverged_steps - unconverged
        if unconverged and self.on_unconverged == "warn":
            warnings.warn(
                f"{unconverged} of {self.steps - already} steps did not reach the solver's tolerance; the worst "
                f"residual so far is {self.worst_residual:.2e}, the worst slip {self.worst_slip:.2e} of a radius. Raise "
                "max_iterations, relax tolerance or slip, or say on_unconverged='ignore'.",
                RuntimeWarning,
                stacklevel=3,
            )
        return self

    def _run_recorded(self, turns: Any, recorder: Recorder, until: Callable[[Simulation], bool] | None) -> None:
        """The turns of a run with a recorder; Ctrl-C ends it between steps."""
        with between_steps() as interrupted:
            for _ in turns:
                try:
                    self.step()
                except BaseException:
                    recorder.abandon()
                    raise
                recorder.enter(self)
                try:
                    over = self._over(until)
                except BaseException:
                    recorder.finish(self)
                    raise
                if over or interrupted():
                    break
            recorder.finish(self)
            if interrupted():
                raise KeyboardInterrupt(recorder.how_to_go_on())

    def _over(self, until: Callable[[Simulation], bool] | None) -> bool:
        """Whether the run ends after this step; RuntimeError where it must."""
        if self.on_unconverged == "stop" and not self.report.solved:
            raise self._unsolved()
        return until is not None and bool(until(self))


class _Summary:
    """One line about a run, made only if it is logged."""

    def __init__(self, sim: Simulation, steps: int, seconds: float):
        self.sim, self.steps, self.seconds = sim, steps, seconds

    def __str__(self) -> str:
        sim = self.sim
        return (
            f"{self.steps} steps to t = {sim.time:g} s in {self.seconds:.2f} s; {len(sim.positions)} bodies, "
            f"{sim.report.interactions} interactions; {sim.unconverged_steps} steps not converged so far"
            + (f", worst residual {sim.worst_residual:.2e}" if sim.unconverged_steps else "")
        )
