"""Moreau-Jean time stepping (theta-method) of a compiled scene."""

from __future__ import annotations

import logging
import os
import time as clock
import warnings
from collections.abc import Callable, Mapping
from copy import copy, deepcopy
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from lmgcpy.contact.detector import Detector
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.dynamics.as_problem import as_problem, conic_form
from lmgcpy.dynamics.assembly import StepProblem, assemble
from lmgcpy.dynamics.checkpoint import Checkpoint, check
from lmgcpy.dynamics.diagnosis import LawFault, fault_of_solve
from lmgcpy.dynamics.energy import Energy, kinetic_energy
from lmgcpy.dynamics.far_away import check_places
from lmgcpy.dynamics.far_moves import FarMoves, Ways, worse
from lmgcpy.dynamics.geometric_stiffness import LinkStiffness, solve_stiffened
from lmgcpy.dynamics.interactions import InteractionView
from lmgcpy.dynamics.interrupt import between_steps
from lmgcpy.dynamics.model import Drive, Model, State
from lmgcpy.dynamics.not_finite import POSITION, VELOCITY, check_bodies, check_detection, check_impulses
from lmgcpy.dynamics.overlaps import overlaps_at_start
from lmgcpy.dynamics.turning_stretch import TurningStretch
from lmgcpy.dynamics.watch import Watch
from lmgcpy.errors import flag, named_arguments, number, one_of, place, shown, whole
from lmgcpy.solve.newton.alternating import Auto
from lmgcpy.solve.problem import Problem
from lmgcpy.solve.report import NOT_FINITE, STATUS, Report
from lmgcpy.solve.solver import Outcome, Solver, check_solver

log = logging.getLogger("lmgcpy")
REACTIONS = ("warn", "stop", "ignore")
"""What may be done about steps that were not solved, and about bodies that overlap at the start."""


class Recorder(Protocol):
    """What keeps a run, for example in a file: told of every step, between steps."""

    def start(self, sim: Simulation) -> None:
        """A run begins."""

    def enter(self, sim: Simulation) -> None:
        """A step was made."""

    def finish(self, sim: Simulation) -> None:
        """The run ends between two steps."""

    def abandon(self) -> None:
        """A step failed, and was not made."""

    def how_to_go_on(self) -> str:
        """A sentence for who was interrupted."""
        ...


Tried = tuple[Interactions, StepProblem, StepProblem]
"""What was detected, the problem as assembled, and as solved."""


@named_arguments
class Simulation:
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

    ``threads``: how many may share the solver's work on a scene of 10 000 bodies or more; ``sim.threads = 2`` changes it
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

    def __init__(
        self,
        scene: Any,
        *,
        time_step: float,
        theta: float = 0.5,
        solver: Solver | None = None,
        on_unconverged: str = "warn",
        overlap: str = "warn",
        threads: int = 1,
        geometric_stiffness: bool = True,
    ):
        self.time_step = number(time_step, "time_step", above=0.0, unit="s")
        self.theta = number(theta, "theta", minimum=0.5, maximum=1.0)
        self.solver: Solver = Auto() if solver is None else solver
        check_solver(self.solver)
        self.on_unconverged = one_of(on_unconverged, "on_unconverged", REACTIONS)
        one_of(overlap, "overlap", REACTIONS)
        self.threads = threads
        self.geometric_stiffness = flag(geometric_stiffness, "geometric_stiffness")
        if isinstance(scene, type) or not hasattr(scene, "compile") or not hasattr(scene, "hand_over"):
            raise TypeError(f"Simulation takes a scene, which lmgcpy.Scene(dimension=2) makes, got {shown(scene)}.")
        self.scene = scene
        self.model: Model = scene.compile()
        check_places(self.model)
        overlaps = None if overlap == "ignore" else overlaps_at_start(self.model)
        if overlaps and overlap == "stop":
            raise ValueError(overlaps)
        if overlaps:
            warnings.warn(overlaps, RuntimeWarning, stacklevel=3)
        self.state: State = self.model.start
        self.steps = 0
        self.report = Report()
        model = self.model
        self.energy = Energy(kinetic=kinetic_energy(model.mass, model.inverse_mass, self.state.velocities))
        tables = model.contactors, model.rows, model.chains
        self._detector = Detector(*tables, model.inverse_mass, model.dimension, model.apart)
        self._size = model.size
        self._links = LinkStiffness.of(model.chains, model.inverse_mass, model.dimension)
        self._last: tuple[StepProblem, Interactions] | None = None
        self.unconverged_steps = 0
        self.worst_residual = 0.0
        self.worst_slip = 0.0
        self._running = False  # run has its own word about unsolved steps
        self._told_unsolved = False
        self.recorder: Recorder | None = None
        """Keeps every run that names no file of its own; set by ``lmgcpy.resume``."""
        self._far_moves = FarMoves(model)
        self._watch = Watch(model)
        self._turning_stretch = TurningStretch(model)
        scene.hand_over(self.state)  # last: a scene that was refused can be mended

    # ---------------------------------------------------------------------------------------------------- the loop

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
            from lmgcpy.io.recorder import RunRecorder  # files are above dynamics

            record = place(record, "record")
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

    def _unsolved(self) -> RuntimeError:
        """What to raise where the last step was not solved."""
        return RuntimeError(f"Step {self.steps}, to t = {self.time:g} s, was not solved: {self.report}.")

    def step(self) -> Report:
        """Make one step, or none; returns how it was solved.

        The first step that the solver did not solve to its tolerance is told (RuntimeWarning), or every one raises
        RuntimeError, as ``on_unconverged`` says; such a step is made.

        Raises FloatingPointError where a number stops being finite, with the body or the interaction, its law and bodies,
        and the time; RuntimeError or TypeError where an imposed function of time fails. Then no step was made: positions,
        velocities, time, energy, and what is remembered of interactions are those after the last whole step, and with the
        cause removed the simulation goes on as if nothing had been. Only ``interactions`` are empty until then.
        """
        begin = clock.perf_counter()
        h, d, state = self.time_step, self.model.dimension, self.state
        # the detector makes its lists anew, never in place, and remembers last of all
        before, start, detector = state.velocities, state.positions.copy(), copy(self._detector)
        self._last = None  # the arrays of the step before make room
        try:
            state.positions += (1.0 - self.theta) * h * before[:, :3]
            loads = [(load, load.at(state.time + 0.5 * h)) for load in self.model.forces]
            free_velocity = before + h * self.model.inverse_mass * self.model.force(loads)
            for drive in self.model.velocities:
                free_velocity[drive.body, drive.component] = drive.at(state.time + h)
            check_bodies(free_velocity, VELOCITY[d], "without impulses", state.time)
            check_bodies(state.positions, POSITION[d], "in its middle", state.time)
            ways = self._far_moves.measure(before, h)
            interactions, given, first = self._interact(before, free_velocity, ways)
            after = self._far_moves.measure(first.system.velocity, h)
            if self._far_moves.unseen(ways, after, self._detector.widest):
                interactions, given, first = self._interact(before, free_velocity, worse(ways, after))
                after = self._far_moves.measure(first.system.velocity, h)
            way = h * first.system.velocity[:, :3]
            problem, pushed = self._take_back(given, first, before)
            problem.commit()
            state.positions += way - (1.0 - self.theta) * h * problem.system.velocity[:, :3]
            self.energy.advance(problem, self.model, loads, before, pushed)
        except BaseException:
            state.positions[:], self._detector = start, detector
            raise
        sentences = [
            *self._far_moves.far(worse(ways, after), before, problem.system.velocity, state.time + h, h),
            *self._watch.links(first, self._unresolved(first)),
            *self._watch.energy(self.energy, lambda: self._thrust(loads), state.time + h, h),
        ]
        state.velocities[:] = problem.system.velocity
        self._detector.remember(interactions, problem.system.impulse, problem.data.state)
        self._turning_stretch.remember(problem)
        state.time += h
        self.steps += 1
        self._last = problem, interactions
        self.report = replace(self.report, stretch=self._watch.stretch, step_seconds=clock.perf_counter() - begin)
        if not self.report.solved:
            self.unconverged_steps += 1
            self.worst_residual = max(self.worst_residual, self.report.residual)
            self.worst_slip = max(self.worst_slip, self.report.slip)
            sentences += self._first_unsolved()
        for sentence in sentences:  # last: where warnings are errors, the step is made all the same
            warnings.warn(sentence, RuntimeWarning, stacklevel=2)
        if self.on_unconverged == "stop" and not self.report.solved and not self._running:
            raise self._unsolved()
        return self.report

    def _first_unsolved(self) -> list[str]:
        """A sentence at the first step that a loop on ``step`` leaves unsolved; ``run`` has its own at its end."""
        if self._running or self._told_unsolved or self.on_unconverged != "warn":
            return []
        self._told_unsolved = True
        return [
            f"Step {self.steps}, to t = {self.time:g} s, did not reach the solver's tolerance: {self.report}. Later ones "
            "are not told; unconverged_steps counts them. Raise max_iterations, relax tolerance or slip, or say "
            "on_unconverged='ignore'."
        ]

    def _interact(self, before: np.ndarray, free_velocity: np.ndarray, ways: Ways) -> Tried:
        """Detect at the middle of the step what ``ways`` may bring into contact; the problem as assembled and solved."""
        state, h, detector = self.state, self.time_step, self._detector
        interactions = detector.detect(state.positions, ways.travel, ways.closing)
        check_detection(detector.groups, interactions, state.time)
        given = assemble(
            detector.groups,
            interactions,
            time=state.time,
            time_step=h,
            before=before,
            free_velocity=free_velocity,
            inverse_mass=self.model.inverse_mass,
            size=self._size,
            guess=detector.recall(interactions),
            state=detector.recall_state(interactions),
            wire_blocks=self.solver.wire_blocks,
        )
        return interactions, given, self._solve(given)

    def _take_back(
        self, given: StepProblem, solved: StepProblem, before: np.ndarray
    ) -> tuple[StepProblem, np.ndarray | None]:
        """The problem that gives the velocities of the step, and the impulses (m, d) that gave only positions, if any."""
        if not (self.geometric_stiffness and self._links.count):
            return solved, None
        earlier = self.report

        def solve(problem: StepProblem) -> StepProblem:
            nonlocal earlier
            solved = self._solve(problem)
            self.report = earlier = self.report.following(earlier)
            return solved

        return self._turning_stretch.take_back(given, solved, before, solve)

    def _thrust(self, loads: list[tuple[Drive, float]]) -> float:
        """Kinetic energy that a step's loads would give to the bodies from rest [J]."""
        return 0.5 * float((self.model.inverse_mass * (self.time_step * self.model.force(loads)) ** 2).sum())

    def _unresolved(self, problem: StepProblem) -> np.ndarray:
        """``4 h^2 T/(m l)`` of the links, (L,), where nothing keeps their beads from zigzagging; else none."""
        if self.geometric_stiffness:
            return np.zeros(0)
        return self._links.resolution(problem.system.impulse, problem.data.gap, self.time_step)

    def _solve(self, problem: StepProblem) -> StepProblem:
        """Solve from the guess; returns the problem with the stiffness of its links and the velocities at its end."""
        start, solves = clock.perf_counter(), 1
        if self.geometric_stiffness and self._links.count:
            problem, outcome, solves = solve_stiffened(self._links, problem, self.solver.wire_blocks, self._call_solver)
        else:
            outcome = self._call_solver(problem)
        self.report = Report(
            iterations=outcome.iterations,
            factorisations=outcome.factorisations,
            residual=outcome.residual,
            slip=outcome.slip,
            status=STATUS[outcome.status],
            worst=problem.worst(),
            interactions=len(problem.system.impulse),
            seconds=clock.perf_counter() - start,
            solves=solves,
        )
        if outcome.status == NOT_FINITE:
            raise self._fault(problem)
        check_impulses(problem, self.solver)
        check_bodies(problem.system.velocity, VELOCITY[self.model.dimension], "at its end", self.state.time)
        return problem.ended()

    def _call_solver(self, problem: StepProblem) -> Outcome:
        options = {"conic": conic_form(problem), "threads": self.threads, **problem.space.driver}
        place, system, free_velocity, guess = self._detector.place, problem.system, problem.free_velocity, problem.guess
        if place is None:
            return self.solver.solve(problem.table, system, free_velocity, guess, **options)
        outcome = self.solver.solve(problem.table, *system.moved(place, free_velocity), guess, **options)
        system.velocity[:] = system.velocity.take(place, axis=0)
        return outcome

    def _fault(self, problem: StepProblem) -> Exception:
        """What to raise where a step has no finite result."""
        when = f"In the step from t = {self.state.time:g} s"
        try:
            what = fault_of_solve(problem, self.solver)
        except LawFault as fault:
            error = RuntimeError(f"{when} {fault}.")
            error.__cause__ = fault.__cause__
            return error
        return FloatingPointError(f"{when} a number stopped being finite: {what}.")

    # -------------------------------------------------------------------------------------------------- checkpoints

    def checkpoint(self) -> Checkpoint:
        """All that the next step depends on, copied."""
        return Checkpoint(
            positions=self.state.positions.copy(),
            velocities=self.state.velocities.copy(),
            time=self.state.time,
            steps=self.steps,
            unconverged_steps=self.unconverged_steps,
            worst_residual=self.worst_residual,
            energy=deepcopy(self.energy),
            memory=self._detector.give_memory(),
            predicted=self._turning_stretch.predicted.copy(),
        )

    @named_arguments
    def restore(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint of this scene, bit for bit; ``interactions`` are empty until the next step."""
        if not isinstance(checkpoint, Checkpoint):
            raise TypeError(f"restore takes what Simulation.checkpoint() gave, got {shown(checkpoint)}.")
        check(checkpoint, self.checkpoint())
        detector = copy(self._detector)
        detector.take_memory(checkpoint.memory)  # which refuses that of another scene
        self._detector = detector
        self.state.positions[:] = checkpoint.positions
        self.state.velocities[:] = checkpoint.velocities
        self.state.time = checkpoint.time
        self.steps = checkpoint.steps
        self.unconverged_steps = checkpoint.unconverged_steps
        self.worst_residual = checkpoint.worst_residual
        self.worst_slip = 0.0  # no checkpoint holds it
        self.energy = deepcopy(checkpoint.energy)
        self._turning_stretch.restore(checkpoint.predicted)
        self._last = None
        self.report = Report()

    # ------------------------------------------------------------------------------------------------------ results

    @property
    def threads(self) -> int:
        """How many threads may share the solver's work on a large scene."""
        return self._threads

    @threads.setter
    def threads(self, threads: int) -> None:
        self._threads = whole(threads, "threads", minimum=1)

    @property
    def time(self) -> float:
        """Time [s]."""
        return self.state.time

    @property
    def positions(self) -> np.ndarray:
        """Positions of the bodies, walls included, in the order of ``scene.add`` [m], (n, d), a view of the state."""
        return self.state.positions[:, : self.model.dimension]

    @property
    def velocities(self) -> np.ndarray:
        """Velocities [m/s], (n, d), a view of the state."""
        return self.state.velocities[:, : self.model.dimension]

    @property
    def spins(self) -> np.ndarray:
        """Angular velocities [rad/s], (n,) in 2D, (n, 3) in 3D, a view of the state."""
        return self.state.velocities[:, 2 if self.model.dimension == 2 else slice(3, 6)]

    @property
    def rotations(self) -> np.ndarray:
        """Angles turned [rad], (n,), a view of the state; in 3D none are kept (AttributeError)."""
        if self.model.dimension == 3:
            raise AttributeError("In 3D no rotations are kept: spheres look alike from all sides.")
        return self.state.positions[:, 2]

    @property
    def interactions(self) -> InteractionView:
        """Links and all candidates within alert of the last step, copied; none before it and after a step that failed."""
        if self._last is None:
            return InteractionView.empty(self.model.dimension, self._detector.state_names)
        problem, interactions = self._last
        return InteractionView.of(problem, interactions, self._detector.state_names)

    def problem(self) -> Problem:
        """The last step as a problem of its own: to solve otherwise, to measure, to write out.

        Raises RuntimeError before the first step and TypeError where a law has no conic form.
        """
        if self._last is None:
            raise RuntimeError("There is no step yet to make a problem of: call step() or run() first.")
        return as_problem(self._last[0]).problem

    def __repr__(self) -> str:
        return (
            f"<Simulation of {len(self.positions)} bodies at t = {self.time:g} s, step {self.steps}, "
            f"h = {self.time_step:g} s; {f'last step {self.report.status}' if self.steps else 'no step yet'}>"
        )


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
