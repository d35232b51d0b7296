"""Runs of a simulation: many steps, with run file, progress bar, observations, stop condition, and Ctrl-C between steps."""

from __future__ import annotations

import logging
import os
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import file_path, flag, named_arguments, number, shown, warn, whole
from lmgcpy.io.rows import Observe
from lmgcpy.writing import in_notebook

log = logging.getLogger("lmgcpy")


class Recorder(Protocol):
    """Records a run, for example in a file. Its methods are called between steps."""

    def start(self, sim: Stepper) -> None:
        """A run begins."""

    def enter(self, sim: Stepper) -> None:
        """A step is complete."""

    def finish(self, sim: Stepper) -> None:
        """The run ends between two steps."""

    def abandon(self) -> None:
        """A step failed; the simulation stands at the end of the step before."""

    def how_to_go_on(self) -> str:
        """A sentence for a user who interrupted the run."""
        ...


class Simulation(Stepper):
    """Steps a scene through time.

    ``time_step`` is h [s]. ``theta`` in [0.5, 1] is the parameter of the time stepping; 0.5 is of second order in free
    motion and keeps the energy. ``solver`` solves the problem of each step; the default is ``Auto()``. The scene is
    compiled and can no longer be edited; afterwards ``body.position`` and other attributes show the simulation's state.

    ``on_unconverged`` says what happens after a step that the solver did not solve to its tolerance: "warn" gives one
    RuntimeWarning at the end of a ``run``, or at the first such step in a loop on ``step``; "stop" raises RuntimeError
    after the step; "ignore" does nothing. In all cases ``unconverged_steps`` counts these steps, and ``worst_residual``
    and ``worst_slip`` hold their largest residual and slip, since the start or the last restore.

    ``overlap`` says what happens if bodies that see each other overlap at the start by more than 5 % of the smaller
    radius: "warn" gives one RuntimeWarning with their number and the worst overlap, and raises ValueError if the worst is
    more than the smaller radius; "stop" raises ValueError; "ignore" does nothing. Contact laws leave an old penetration
    alone, so that such a start is legal, but it is rarely intended. The overlaps that solvers leave in a sample at rest are
    smaller and cause no warning.

    A body so far from the origin that rounding moves it by more than a thousandth of its radius is refused (ValueError).

    ``threads`` is the number of threads that may share the solver's sweeps on a large scene; ``sim.threads = 2`` changes it
    between steps. The results have the same bits for any number.

    ``geometric_stiffness=False`` leaves out the corrections for links that turn by more than the step resolves
    (``lmgcpy/dynamics/geometric_stiffness.py``, ``turning_stretch.py``, ``whipping_links.py``), to show their effect: beads
    may then zigzag and gain energy, and rods round light bodies become too long.

    Further attributes are ``steps``, the number of completed steps; ``report`` and ``energy`` of the last step, a
    :class:`Report <lmgcpy.solve.problems.report.Report>` and an :class:`Energy <lmgcpy.dynamics.energy.Energy>`; and
    ``scene``.

    The formulas of a step are in the class that makes it, :class:`Stepper <lmgcpy.dynamics.stepper.Stepper>`.

    A ball falls and comes to rest on a floor, which bears its weight:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.2), mass=1.0))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Signorini())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    >>> ball.position.round(9), sim.interactions.force[0]
    (array([0. , 0.1]), array([10.,  0.]))
    >>> sim.energy.kinetic, sim.unconverged_steps
    (0.0, 0)
    """

    _recorder: Recorder | None = None

    @property
    def recorder(self) -> Recorder | None:
        """Records every run that names no file of its own; ``lmgcpy.resume`` sets it."""
        return self._recorder

    @recorder.setter
    def recorder(self, recorder: Recorder | None) -> None:
        if self._running:
            raise RuntimeError("The recorder cannot change in a run: set it between two runs.")
        self._recorder = recorder
        self.state.recorded = recorder is not None

    def _reaction_of(self, body: int) -> Any:
        from lmgcpy.measure.reaction import reaction  # not needed by who asks for none

        return reaction(self, body)

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
        observe: Observe | None = None,
        notes: Mapping[str, Any] | None = None,
        until: Callable[[Simulation], bool] | None = None,
        on_step: Callable[[Simulation], Any] | None = None,
    ) -> Simulation:
        """Make ``steps`` steps, or as many as ``duration`` [s] takes; returns the simulation itself.

        ``progress`` shows a bar if standard error is a terminal, and in a notebook. ``record`` is the path of a run file
        (HDF5). The file gets a frame every ``every`` steps and one at the end of the run, and the history of every step;
        unwritten steps are at most ``flush`` [s] of clock time old. An existing file is replaced only with ``force``.
        Ctrl-C ends a recorded run between two steps, with a complete file.

        ``observe`` gives functions of the simulation by name, called before the first step and after every step. Each
        returns a number or an array of the same shape at every step; the run file keeps the values. Tables of the run have
        names and units of the values if ``observe`` gives these with the function: ``{"height": (f, "m")}``, or of an array
        ``{"tension": (f, ["mean tension [N]", "greatest tension [N]"])}``. ``notes`` are your own words and numbers by
        name, kept in the run file and shown by ``lmgcpy info``. ``until`` is a function of the simulation, called after
        every step; the run ends early when it returns True.

        ``on_step`` is a function of the simulation, called after every step and before the step is recorded: it may look,
        and make statements for the next steps (``sim.scene.bodies[3].hide()``), but neither ``run``, nor in a recorded run
        ``step`` or ``restore`` (RuntimeError). A run that goes on from its file goes through the statements that it has
        made; give ``on_step`` again for the statements to come. If it raises, the run ends, its file complete up to the
        step before.
        """
        if self._running:
            raise RuntimeError("run cannot be called inside a run, as by its on_step or until: call it after the run.")
        if (steps is None) == (duration is None):
            raise TypeError("run takes either steps or duration [s], one of the two.")
        if duration is not None:
            steps = round(number(duration, "duration", minimum=0.0, unit="s") / self.time_step)
        turns: Any = range(whole(steps, "steps"))
        flag(progress, "progress")
        if until is not None and not callable(until):
            raise TypeError(f"until must be a function of the simulation, got {shown(until)}.")
        if on_step is not None and not callable(on_step):
            raise TypeError(f"on_step must be a function of the simulation, got {shown(on_step)}.")
        recorder = self.recorder
        if record is not None:
            from lmgcpy.io.recorder import RunRecorder  # h5py takes as long to import as all the rest

            record = file_path(record, "record")
            if not (isinstance(recorder, RunRecorder) and recorder.writes(record)):
                recorder = RunRecorder(record, every=every, flush=flush, force=force, observe=observe, notes=notes)
                observe = notes = None
        if observe is not None:
            raise TypeError(
                "observe is kept in the run file that record= begins"
                + (": name one." if recorder is None else "; for a run that continues, give it to lmgcpy.resume.")
            )
        if notes is not None:
            raise TypeError("notes are kept in the run file that record= begins: name one, or leave them out.")
        begin, already, unconverged = clock.perf_counter(), self.steps, self.unconverged_steps
        if recorder is not None:
            recorder.start(self)
        if progress:
            from tqdm import tqdm

            # None: only on a terminal
            turns = tqdm(turns, desc="lmgcpy", unit="step", disable=False if in_notebook() else None)
        state, recorded_before = self.state, self._recorder is not None
        try:
            self._running, state.recorded = True, recorder is not None
            if recorder is None:
                for _ in turns:
                    self.step()
                    self._ask("on_step", on_step)
                    if self._over(until):
                        break
            else:
                self._run_recorded(turns, recorder, until, on_step)
        finally:  # nothing here calls a function, in which a second signal might end it
            self.__dict__["_running"], state.recorded = False, recorded_before
        log.info("%s", _Summary(self, self.steps - already, clock.perf_counter() - begin))
        unconverged = self.unconverged_steps - unconverged
        if unconverged and self.on_unconverged == "warn":
            warn(
                f"{unconverged} of {self.steps - already} steps did not reach the solver's tolerance; the worst "
                f"residual so far is {self.worst_residual:.2e}, the worst slip {self.worst_slip:.2e} of a radius. Raise "
                "max_iterations, relax tolerance or slip, or give on_unconverged='ignore'."
            )
        return self

    def _run_recorded(
        self,
        turns: Any,
        recorder: Recorder,
        until: Callable[[Simulation], bool] | None,
        on_step: Callable[[Simulation], Any] | None,
    ) -> None:
        """The steps of a run with a recorder; Ctrl-C ends it between steps."""
        with between_steps() as interrupted:
            for _ in turns:
                try:
                    self.step()
                    self._ask("on_step", on_step)
                except BaseException:
                    recorder.abandon()
                    raise
                self._ask("observe", recorder.enter)
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
        """Whether the run ends after this step; RuntimeError after an unsolved step if on_unconverged is "stop"."""
        if self.on_unconverged == "stop" and not self.report.solved:
            raise self._unsolved()
        return bool(self._ask("until", until))

    def _ask(self, what: str, function: Callable[[Simulation], Any] | None) -> Any:
        """The value of a user's function of the simulation, or None without a function."""
        if function is None:
            return None
        self._asked = what
        try:
            return function(self)
        finally:
            self.__dict__["_asked"] = ""  # no call of a function, in which a second signal might end it


class _Summary:
    """A line about a run; the text is made only if it is logged."""

    def __init__(self, sim: Simulation, steps: int, seconds: float):
        self.sim, self.steps, self.seconds = sim, steps, seconds

    def __str__(self) -> str:
        sim = self.sim
        return (
            f"{self.steps} steps to t = {sim.time:g} s in {self.seconds:.2f} s; {len(sim.positions)} bodies, "
            f"{sim.report.interactions} interactions; {sim.unconverged_steps} steps not converged so far"
            + (f", worst residual {sim.worst_residual:.2e}" if sim.unconverged_steps else "")
        )


@contextmanager
def between_steps() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed; a second Ctrl-C raises KeyboardInterrupt at once.

    Nothing changes outside the main thread, or if another handler of the signal is installed.
    """
    pressed = False

    def note(number, stack_frame) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

    usual = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if usual:
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        if usual:
            signal.signal(signal.SIGINT, signal.default_int_handler)
