"""Moreau-Jean time stepping (theta-method) of a compiled scene."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from copy import copy, deepcopy
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.ahead import ahead
from lmgcpy.compiled.meanwhile import MOST, meanwhile
from lmgcpy.contact.detection_tables import ChainTable
from lmgcpy.contact.detector import Detector
from lmgcpy.contact.foreign_pairs import NarrowPhaseError
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.contact.positions import in_space
from lmgcpy.dynamics import turning_overlap
from lmgcpy.dynamics.assembly import Assembler
from lmgcpy.dynamics.cell import CellMotion, TurnedOver
from lmgcpy.dynamics.changes import Change, as_rows, from_rows
from lmgcpy.dynamics.checkpoint import Checkpoint, check
from lmgcpy.dynamics.energy import Energy, Flight, dissipated_by_law, given_by_hand, kinetic_energy
from lmgcpy.dynamics.faults import check_detection, fault_of_flight
from lmgcpy.dynamics.geometric_stiffness import TURNS, LinkStiffness, after_turn, enough
from lmgcpy.dynamics.interactions import InteractionView, MadeStep
from lmgcpy.dynamics.journal import Journal
from lmgcpy.dynamics.lever_stiffness import LeverStiffness
from lmgcpy.dynamics.model import BodyState, Drive, Model
from lmgcpy.dynamics.motion import fly, move
from lmgcpy.dynamics.rotation import turn_freely, turn_on, turn_to
from lmgcpy.dynamics.solve_step import solve_step
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.dynamics.straight_spans import StraightSpans
from lmgcpy.dynamics.sweep_mass import ROUNDS, sweep_mass
from lmgcpy.dynamics.torn_links import may_tear, ways_of_whole_links
from lmgcpy.dynamics.turning_stretch import TurningStretch
from lmgcpy.dynamics.watch import Said
from lmgcpy.dynamics.watch.costly_steps import CostlySteps
from lmgcpy.dynamics.watch.damped_waves import DampedWaves
from lmgcpy.dynamics.watch.displacements import Displacements, DisplacementWatch, worse
from lmgcpy.dynamics.watch.driven_overlaps import DrivenOverlaps
from lmgcpy.dynamics.watch.lock import find_lock
from lmgcpy.dynamics.watch.start_overlaps import check_start, overlaps_at_start
from lmgcpy.dynamics.watch.stretch_and_energy import Watch
from lmgcpy.dynamics.whipping_links import WhippingLinks
from lmgcpy.errors import LARGEST, closest, flag, named_arguments, number, one_of, read_only, shown, warn, whole
from lmgcpy.solve.newton.alternating import Auto
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.problems.report import LOCKED, STATUS, Report
from lmgcpy.solve.sweeps.solver import Solver, check_solver
from lmgcpy.solve.sweeps.sweep import only_out_of_balance

REACTIONS = ("warn", "stop", "ignore")
"""Answers to steps that were not solved, and to bodies that overlap at the start."""


class Found(NamedTuple):
    """The impulses of a step, and the problem that they solve."""

    interactions: Interactions
    solved: StepProblem
    """The step as it was solved first."""
    displacement: np.ndarray
    """Displacement of the bodies in the step [m, m, m or rad ...], (n, k): ``h v`` of the first solve, plus the projection
    of links that whip. The rotations of bodies that turn in space are in ``ahead``."""
    ahead: np.ndarray | None
    """Positions at the next detection (n, w), None if no body turns; read for the rotations of bodies in space."""
    problem: StepProblem
    """The step as it was solved last, which gives the velocities and impulses at the end."""
    pushed: np.ndarray | None
    """Impulses that moved only positions (m, d), or None: impulses of the first solve minus impulses of the last, plus the
    impulses that project links that whip."""
    moves: Displacements
    predicted_gap: np.ndarray
    """Gaps of contacts at the next detection, as the first solve predicts them [m], (m,), NaN if the law does not keep
    it."""
    held: tuple[np.ndarray, np.ndarray] | None
    """Stiffness of the levers of links, and the spins that it leaves, (n, k - d); None if none acts."""


CHANGED = (
    *("model", "steps", "report", "energy", "unconverged_steps", "worst_residual", "worst_slip", "_scheme"),
    *("_is_small", "_last", "_left", "_links", "_levers", "_straight_spans", "_displacement_watch"),
)
"""Attributes of a simulation that a step or a restore sets, besides detector and assembler."""

Before = tuple[np.ndarray, np.ndarray, list[tuple[dict[str, Any], dict[str, Any]]]]
"""A simulation before a step: positions, velocities, and for each object its attributes, live and as a copy."""


@named_arguments
class Stepper:
    """Makes the steps of a compiled scene; :class:`lmgcpy.Simulation` is a stepper with runs and says what the options are.

    :meth:`lmgcpy.Simulation.step` has the equations.
    """

    _made = False
    """Whether the simulation has all its attributes."""
    _asked = ""
    """The function of the user that a run is calling, in words."""

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
        self.time_step = time_step
        self.theta = theta
        self.solver = Auto() if solver is None else solver
        self.on_unconverged = on_unconverged
        overlap = one_of(overlap, "overlap", REACTIONS)
        self.threads = threads
        self.geometric_stiffness = geometric_stiffness
        if isinstance(scene, type) or not hasattr(scene, "compile") or not hasattr(scene, "hand_over"):
            raise TypeError(f"Simulation takes a scene, which lmgcpy.Scene(dimension=2) makes, got {shown(scene)}.")
        self.scene = scene
        self.model: Model = scene.compile()
        ahead.would_need(f"from lmgcpy.warmup import solver_kernels; solver_kernels({self.model.dimension})")
        self._is_small = is_small(self.model)
        for sentence in self._meanwhile(lambda: check_start(self.model, overlap), copied=False):
            warn(sentence)
        self.state: BodyState = self.model.start
        self.state.overlap = overlap
        self.steps = 0
        self.report = Report()
        model = self.model
        self.energy = Energy(kinetic=kinetic_energy(model.free_mass, self.state.velocities))
        tables = model.contactors, model.rows, model.links
        self._detector = Detector(*tables, model.inverse_mass, model.dimension, model.apart, model.lattice)
        self._detector.hide(model.hidden)
        self._assembler = Assembler(model)
        self._links = LinkStiffness.of(model.chains, model.inverse_mass, model.dimension)
        self._levers = LeverStiffness.of(model)
        self._straight_spans = StraightSpans.of(model.links, model.inverse_mass, model.dimension)
        self._last: MadeStep | None = None
        self._scheme = self.time_step, self.theta
        """Time step and theta of the step that gave the remembered impulses."""
        self._left = self.state.velocities.copy()
        """Velocities at the end of that step, (n, k): they may have been written since."""
        self.unconverged_steps = 0
        self.worst_residual = 0.0
        self.worst_slip = 0.0
        self._journal: Journal[Before] = Journal()
        self._running = False  # run has its own word about unsolved steps
        self._said = Said()
        self._displacement_watch = DisplacementWatch(model, self._said)
        self._watch = Watch(model, self._said)
        self._driven_overlaps = DrivenOverlaps(model, self.state.positions, self._said)
        self._damped_waves = DampedWaves(model, self._said)
        self._costly_steps = CostlySteps(self._said)
        self._turning_stretch = TurningStretch(model)
        self._whipping_links = WhippingLinks(model)
        self.state.reaction = self._reaction_of
        scene.hand_over(self.state)  # last: a scene that was refused can be mended
        self._made = True

    # ---------------------------------------------------------------------------------------------------- the loop

    def step(self) -> Report:
        """Make one whole step, or none; returns how it was solved.

        For velocities v, positions q, external forces F, and impulses r along H::

            (1)  q_m    = q + (1 - theta) h v    detection at q_m
            (2)  v_free = v + h M^-1 F           imposed components: their value at the end
            (3)  u      = H^T v_free + W r       solved for r and u with the laws
            (4)  v      = v_free + M^-1 H r
            (5)  q      = q_m + theta h v

        In space, bodies that keep a rotation turn freely in (1) and (5), where their spins change with it
        (``lmgcpy/dynamics/rotation.py``); v in (2) is the velocity after (1).

        In (1) bodies whose rigid links velocities given by hand would tear move as one (``lmgcpy/dynamics/torn_links.py``).
        In a periodic cell bodies move with ``v + G q`` instead of v (``lmgcpy/dynamics/cell.py``). If links or contacts
        would make energy as they are pulled back, (4) and (5) take the impulses of two solves
        (``lmgcpy/dynamics/turning_stretch.py``, ``turning_overlap.py``). If light bodies whip, (5) is projected
        (``lmgcpy/dynamics/whipping_links.py``).

        As ``on_unconverged`` says, the first step that the solver did not solve to its tolerance warns (RuntimeWarning), or
        every such step raises RuntimeError; the step is made all the same.

        Raises FloatingPointError if a number stops being finite, with the body or the interaction, its law and bodies, and
        the time; RuntimeError or TypeError if an imposed function of time or a narrow phase fails. Then, or if Ctrl-C or
        another signal ends it at any line, no step was made: everything is as after the last whole step. Once the cause is
        removed, the simulation goes on as if nothing had happened. Only ``interactions`` are empty until then.
        """
        self._refuse_asked("step")
        self._last = None  # frees the arrays of the step before
        sentences = self._meanwhile(self._whole_step, copied=True)
        for sentence in sentences:  # last: if warnings are errors, the step is made all the same
            warn(sentence)
        if self.on_unconverged == "stop" and not self.report.solved and not self._running:
            raise self._unsolved()
        return self.report

    def _meanwhile(self, work: Callable[[], list[str]], copied: bool) -> list[str]:
        """``work()``, as plain Python if its kernels have to be compiled and the scene is small."""
        return meanwhile.do(work, copied) if self._is_small and of_lmgcpy(self.solver) else work()

    def _whole_step(self) -> list[str]:
        """Make a whole step, or none."""
        return self._journal.whole_or_not_at_all(self._all, self._make_step, self._go_back)

    def _make_step(self) -> list[str]:
        """Make a step by the equations of :meth:`step`; returns sentences for the user about it."""
        begin = clock.perf_counter()
        sentences = self._take_statements()
        earlier = self._draw_chains()
        h, theta, state, v = self.time_step, self.theta, self.state, self.state.velocities
        first, whole, written = (1.0 - theta) * h, None, None
        # bytes: ten times as fast as array_equal in small scenes
        if self.steps == 0 or v.tobytes() != self._left.tobytes():  # velocities were given by hand
            whole = self._whole(v)
            written = (first * v if whole is None else whole) - first * self._left
        if whole is None:
            self._move(v, first, v, 0.0, CellMotion.first_move)  # (1)
            driven, driven_last = self._turn(first, v, state.positions), 0.0
        else:
            driven, driven_last = self._move_whole(whole), 0.0
        flight = self._free_flight(v)  # (2)
        found = self._find_impulses(v, flight, earlier, written)  # (3), (4)
        problem = found.problem
        dissipated = dissipated_by_law(problem)
        problem.commit()
        problem.data.state[:, -1] = found.predicted_gap
        # (5) if one solve gives the displacements and the velocities, as it mostly does
        self._move(found.displacement, 1.0, problem.system.velocity, -(1.0 - theta) * h, CellMotion.last_move)
        if self.model.cell is not None:
            self.model.cell.straighten(state.positions)
        after = problem.system.velocity
        if len(self.model.turning):
            after = after.copy()
            if found.pushed is not None and found.ahead is not None:
                turn_to(self.model.turning, found.ahead, self._ahead(after), state.positions)
            driven_last = self._turn(theta * h, after, state.positions)  # (5)
        given = () if earlier is None else given_by_hand(problem, earlier, self._turning_stretch.predicted)
        held = () if found.held is None else self._levers.works(problem, *found.held, v)
        self.energy.advance(problem, self.model, flight, v, found.pushed, dissipated, given, held)
        self.energy.turn(driven, driven_last)
        sentences += self._watched(found, flight.force, v)
        state.velocities[:] = after
        self._left = state.velocities.copy()
        state.time += h
        self.steps += 1
        state.steps = self.steps
        self._detector.remember(found.interactions, problem.system.impulse, problem.data.state)
        self._turning_stretch.remember(problem)
        self._last = MadeStep(problem, found.interactions, self.model, theta)
        self.report = self.report.of_step(self._watch.stretch, clock.perf_counter() - begin)
        if not self.report.solved:
            alone = only_out_of_balance(self.solver.bounds, problem.system.measured)  # all laws hold: nothing is locked
            lock = None if alone else find_lock(problem, self.report, self._straight_spans)
            if lock is not None:
                self.report = replace(self.report, status=STATUS[LOCKED], lock=lock)
                sentences += self._watch.lock(lock, self.time) if self.on_unconverged == "warn" else ()
            sentences += self._count_unsolved()
        if self.on_unconverged != "ignore":
            sentences += self._costly_steps.after_step(self.report, self.steps, state.time)
        return sentences

    def _take_statements(self) -> list[str]:
        """Take over what was said since the last step, of the scene and of the scheme; returns sentences for the user."""
        sentences = self._take_changes() if self.state.stale else []
        if self._scheme != (self.time_step, self.theta):
            self._detector.scale_impulses(self.time_step / self._scheme[0])
            self._turning_stretch.restore(np.zeros(0))
            self.energy.stored = {}  # known at gaps that were predicted for another detection
            self._scheme = self.time_step, self.theta
        return sentences

    def _take_changes(self) -> list[str]:
        """Take over the changes of the scene by the statements since the last step; returns sentences for the user."""
        before, model = len(self.model.mass), self.scene.changed(self.model)
        self._left = np.concatenate([self._left, self.state.velocities[len(self._left) :]])
        sentences: list[str] = []
        if len(model.mass) > before or model.rows is not self.model.rows:
            if len(model.mass) > before and self.state.overlap == "warn":  # with "stop" it was refused as it was added
                sentences += overlaps_at_start(model, before)[0]
            tables = model.contactors, model.rows, model.links
            detector = self._detector.grown(tables, model.inverse_mass, model.hidden, model.apart, self.state.positions)
            self._displacement_watch = DisplacementWatch(model, self._said)
        else:
            detector = copy(self._detector)
            if model.chains is not self.model.chains:
                detector = detector.with_chains(model.links)
            detector.change(model.inverse_mass, model.hidden)
        for row, now in zip(self.model.rows, model.rows, strict=True):
            if row is not now:  # the energy of contacts under other parameters is not known before the step
                self.energy.stored = {name: value for name, value in self.energy.stored.items() if name != row.law.NAME}
        self.model, self._detector, self._assembler = model, detector, Assembler(model)
        self._is_small = is_small(model)
        self._links = LinkStiffness.of(model.chains, model.inverse_mass, model.dimension)
        self._levers = LeverStiffness.of(model)
        self._straight_spans = StraightSpans.of(model.links, model.inverse_mass, model.dimension)
        self._turning_stretch.look_at(model)
        self._watch.follow(model)
        self._driven_overlaps.look_at(model, self.state.positions)
        self._damped_waves.look_at(model)
        self.state.velocities[model.hidden] = 0.0
        self.state.stale = False
        return sentences

    def _draw_chains(self) -> list[ChainTable] | None:
        """Set reference gaps that are functions of time to their values at the next detection, which the step is to reach.
        Returns the chains as they were before, or None if no chain changes."""
        model, time = self.model, self.state.time
        earlier = model.earlier if model.drawn == time else None
        if earlier is None and all(chain.function is None for chain in model.chains):
            return None
        detection = time + (1.0 - self.theta) * self.time_step
        for chain in model.chains:
            if chain.function is not None:
                chain.draw(detection + self.time_step)
        return [
            chain if chain.function is None else replace(chain, reference_gap=chain.function(detection))
            for chain in earlier or model.chains
        ]

    # ------------------------------------------------------------------------------------------- whole or not at all

    def _all(self) -> Before:
        """Everything that a step changes. These objects set attributes and change nothing in place, except the detector."""
        watches = self._said, self._watch, self._driven_overlaps, self._damped_waves, self._costly_steps
        objects = *watches, self._turning_stretch, self.energy, self.state
        kept = [(now, now.copy()) for now in map(vars, objects)]
        own = self.__dict__
        kept.append((own, {name: own[name] for name in CHANGED} | {"_detector": self._detector.__copy__()}))
        return self.state.positions.copy(), self.state.velocities.copy(), kept

    def _go_back(self, before: Before) -> None:
        """Put everything back; may be interrupted and called again."""
        positions, velocities, kept = before
        *others, (of_state, state_then), (own, then) = kept
        if self.state.changes is not state_then["changes"]:  # a restore had the scene go through others
            self.scene.go_through(state_then["changes"])
        self.state.positions[:], self.state.velocities[:] = positions, velocities
        for now, past in (*others, (of_state, state_then)):
            now.update(past)
        own.update(then, _assembler=Assembler(then["model"]))  # its arrays may be half filled

    def _whole(self, velocities: np.ndarray) -> np.ndarray | None:
        """Ways to the detection (n, k) that tear no rigid link, if velocities given by hand would; else None."""
        model, first = self.model, (1.0 - self.theta) * self.time_step
        before = self._left if self.steps else np.zeros_like(velocities)
        if not (first and may_tear(model.links, velocities - before, before)):
            return None
        moves = self._displacement_watch.measure(velocities, self.time_step)
        own = np.zeros(len(velocities), dtype=bool)
        _, problem = self._assemble(velocities, self._free_flight(velocities), moves, None, own)
        return ways_of_whole_links(problem, velocities, before, first, model.mass, model.inverse_mass)

    def _move_whole(self, ways: np.ndarray) -> float:
        """Equation (1) by these ways (n, k); bodies whose ways are replaced do not turn. Returns the work of what drives a
        part of the spins of others [J]."""
        state, first = self.state, (1.0 - self.theta) * self.time_step
        kept = np.flatnonzero((ways != first * state.velocities).any(axis=1))
        rotations, spins = state.positions[kept, 3:], state.velocities[kept].copy()
        self._move(ways, 1.0, ways, 0.0, CellMotion.first_move)
        driven = self._turn(first, state.velocities, state.positions)
        state.positions[kept, 3:], state.velocities[kept] = rotations, spins
        return driven

    def _turn(self, time: float, velocities: np.ndarray, positions: np.ndarray) -> float:
        """Turn the bodies that keep a rotation in space freely for a time [s]: their quaternions among the ``positions``
        (n, 7), in place, and with them their spins among the velocities (n, 6). Returns the work of what drives a part of
        their spins [J]."""
        model = self.model
        if not len(model.turning):
            return 0.0
        return turn_freely(model.turning, time, positions, velocities, model.mass, model.inverse_mass)

    def _move(
        self,
        one: np.ndarray,
        time: float,
        other: np.ndarray,
        earlier: float,
        in_cell: Callable[[CellMotion, np.ndarray, np.ndarray], np.ndarray],
    ) -> None:
        """Move the bodies by ``time one + earlier other``, (n, k) both; ``in_cell``: their move with a periodic cell."""
        cell, positions = self.model.cell, self.state.positions
        if cell is None:
            move(positions, one, time, other, earlier)
            return
        try:
            positions[:, :3] += in_cell(cell, time * one + earlier * other, positions)
        except TurnedOver as fault:
            raise RuntimeError(f"In the step from t = {self.state.time:g} s {fault}") from None

    def _free_flight(self, before: np.ndarray) -> Flight:
        """How bodies would fly in the step without impulses."""
        model, state, h = self.model, self.state, self.time_step
        middle = state.time + 0.5 * h
        loads = [(load, load.at(middle) * self._unit(load)) for load in model.forces]
        force = model.force(loads, state.positions, middle)
        inertial = None if model.cell is None else model.cell.inertial_force(before, model.free_mass, h)
        total = force if inertial is None else force + inertial
        mobility = model.inverse_mass
        start, time = before, h
        if model.drag is not None:
            mobility, start = model.drag.fly(before, total, mobility, h)
            time = 0.0
        imposed, free_velocity = (model.imposed, model.imposed_at(state.time + h)), np.empty_like(before)
        if not fly(start, time, mobility, total, *imposed, state.positions, LARGEST, free_velocity):
            raise fault_of_flight(free_velocity, state.positions, model.dimension, state.time)
        return Flight(force, inertial, mobility, free_velocity)

    def _unit(self, load: Drive) -> float:
        """Factor of a load: the volume of the cell [m^d] if it is a stress, else 1."""
        cell = self.model.cell
        return cell.volume(self.state.positions) if cell is not None and load.body in cell.lattice.rows else 1.0

    def _find_impulses(
        self, before: np.ndarray, flight: Flight, earlier: list[ChainTable] | None, written: np.ndarray | None
    ) -> Found:
        """Detect, assemble and solve; do so a second time if bodies got so fast that contacts were not seen. ``earlier``:
        the chains before they were drawn in or let out, if any was; ``written``: ways on to the detection that bodies got
        by velocities that were written between the steps (n, k), if any was."""
        far, h = self._displacement_watch, self.time_step
        moves = far.measure(before, h)
        interactions, given, solved, held = self._detect_and_solve(before, flight, moves, written)
        after = far.measure(solved.system.velocity, h)
        if far.unseen(moves, after, self._detector.widest):
            report, velocity = self.report, solved.system.velocity.copy()
            again = report.solved and len(given.light.body) > 0  # flung about, they would double the work of many steps
            if again:
                self._detector.begin_again(interactions, solved.system.impulse)
            centre = velocity if again else None
            interactions, given, solved, held = self._detect_and_solve(
                before, flight, worse(moves, after), written, centre
            )
            self.report = self.report.with_work(report, self.report)
            after = far.measure(solved.system.velocity, h)
        if written is not None:
            self._turning_stretch.move_on(given.relative_velocities(written))
        displacement, projected, predicted = h * solved.system.velocity, None, solved.predicted_gaps()
        whipping, turning, here = self._whipping_links, self.model.turning, self.state.positions
        ahead = self._ahead(solved.system.velocity) if whipping.turns or len(turning) else None
        if self.geometric_stiffness and self.model.links:
            inverse_inertia = self.model.inverse_mass[:, self.model.dimension :]
            places = here, here if ahead is None else ahead
            ways, projected = whipping.put_back(solved, displacement, before, places, inverse_inertia)
            if ways is not None:
                displacement += ways
                if ahead is not None:
                    turn_on(turning, ways, ahead)
        problem, pushed = self._take_back(given, solved, before, earlier, held)
        if projected is not None:
            pushed = projected if pushed is None else pushed + projected
        return Found(interactions, solved, displacement, ahead, problem, pushed, worse(moves, after), predicted, held)

    def _ahead(self, velocity: np.ndarray) -> np.ndarray:
        """Positions at the next detection, from those at this one, by velocities (n, k)."""
        positions = self.state.positions.copy()
        positions[:, :3] += self.time_step * velocity[:, :3]
        self._turn(self.time_step, velocity.copy(), positions)
        return positions

    def _detect_and_solve(
        self,
        before: np.ndarray,
        flight: Flight,
        moves: Displacements,
        written: np.ndarray | None,
        centre: np.ndarray | None = None,
    ) -> tuple[Interactions, StepProblem, StepProblem, tuple[np.ndarray, np.ndarray] | None]:
        """Detect what ``moves`` may bring into contact, and solve until the stiffness of the levers of links fits the
        impulses; (interactions, their problem, the problem solved, the stiffness that acts). ``centre``: velocities of the
        bodies that light bodies start from (n, k).

        Light bodies that stay out of balance bear too little to need more than their own mass: with it they are swept anew.
        """
        levers, links, d = self._levers, self._links, self.model.dimension
        flown, carrying = flight, None  # with the stiffness of levers

        def assembled() -> tuple[Interactions, StepProblem]:
            interactions, given = self._assemble(before, flown, moves, written, own)
            if carrying is not None:
                w, carried = carrying
                across = given.relative_velocities(w)[: links.count, 1:d]
                given.carried = np.where(carried[: links.count, None], across, np.nan)
            if centre is not None:
                given.light.centre[:] = centre[given.light.body]
            return interactions, given

        def solve(interactions: Interactions, given: StepProblem) -> tuple[Interactions, StepProblem, StepProblem]:
            solved = self._solve(given)

            def anew(impulse: np.ndarray, velocity: np.ndarray) -> None:
                nonlocal interactions, given, solved, centre
                report, centre = self.report, velocity
                self._detector.begin_again(interactions, impulse)
                interactions, given = assembled()
                solved = self._solve(given)
                self.report = self.report.with_work(report, self.report)

            first = None
            for _ in range(ROUNDS):
                out = len(given.light.body) > 0 and given.light.out.any()
                if not (out and only_out_of_balance(self.solver.bounds, solved.system.measured)):
                    break
                own[given.light.body[given.light.out > 0.0]] = True
                here = solved.system.impulse.copy(), solved.system.velocity.copy()
                first = first or here
                anew(*here)
            if first is not None and not self.report.solved:  # rather only light bodies out of balance
                own[:] = False
                anew(*first)
            return interactions, given, solved

        own = np.zeros(len(before), dtype=bool)
        interactions, given = assembled()
        if not (self.geometric_stiffness and levers.count):
            return *solve(interactions, given), None
        impulse, held, report = given.guess, None, None
        used = levers.stiffness(given, impulse)
        unsolved = 0
        for turn in range(TURNS):
            if used.any():
                of_links = links.stiffness(impulse, given.data.gap, self.time_step, links.pinched(given))
                carrying = levers.carrying(given, impulse, used, of_links, flight.mobility, before)
                held = used, carrying[0][:, d:]
                mobility, free = levers.stiffened(*held, flight.mobility, flight.free_velocity)
                flown = flight._replace(mobility=mobility, free_velocity=free)
                interactions, given = assembled()
            elif held is not None:
                flown, carrying, held = flight, None, None
                interactions, given = assembled()
            interactions, given, solved = solve(interactions, given)
            self.report = self.report if report is None else self.report.with_work(report, self.report)
            report, impulse = self.report, solved.system.impulse
            needed = levers.stiffness(given, impulse)
            unsolved += not report.solved
            if unsolved == 3 or enough(used, needed, levers.share, turn):
                break
            used = after_turn(used, needed, turn)
            self._detector.begin_again(interactions, impulse)
        return interactions, given, solved, held

    def _assemble(
        self, before: np.ndarray, flight: Flight, moves: Displacements, written: np.ndarray | None, own: np.ndarray
    ) -> tuple[Interactions, StepProblem]:
        """Detect what ``moves`` may bring into contact; (interactions, their problem). ``own``: light bodies that are swept
        with their own mass, (n,) bool."""
        state, detector = self.state, self._detector
        mobility = flight.mobility
        try:
            interactions = detector.detect(state.positions, moves.travel, moves.closing, mobility)
        except NarrowPhaseError as error:
            raise RuntimeError(f"In the step from t = {state.time:g} s {error}.") from error.__cause__
        more = sweep_mass(self.model, interactions, self.solver.tolerance, own)
        if more is not None:  # W of the sweep needs its masses
            swept = mobility / more[:, None]
            interactions = detector.detect(state.positions, moves.travel, moves.closing, swept)
        check_detection(detector.groups, interactions, state.time)
        given = self._assembler.assemble(
            detector,
            interactions,
            time=state.time,
            time_step=self.time_step,
            positions=state.positions,
            before=before,
            written=written,
            free_velocity=flight.free_velocity,
            mobility=mobility,
            more=more,
            wire_blocks=self.solver.wire_blocks,
            threads=self.threads,
        )
        self._straight_spans.let_go(given.guess, interactions.normal)
        self._straight_spans.give_way(given)
        return interactions, given

    def _take_back(
        self,
        given: StepProblem,
        solved: StepProblem,
        before: np.ndarray,
        earlier: list[ChainTable] | None,
        held: tuple[np.ndarray, np.ndarray] | None,
    ) -> tuple[StepProblem, np.ndarray | None]:
        """The problem that gives the velocities of the step, and the impulses (m, d) that gave only positions, if any.
        ``held``: as :class:`Found` has it."""
        report = self.report

        def solve(problem: StepProblem) -> StepProblem:
            nonlocal report
            solved = self._solve(problem)
            self.report = report = self.report.following(report)
            return solved

        def moments(problem: StepProblem) -> np.ndarray:
            return np.zeros(len(before)) if held is None else self._levers.work(problem, *held, before).sum(axis=1)

        if self.geometric_stiffness and self.model.links:
            solved, pushed = self._turning_stretch.take_back(given, solved, before, earlier, solve, moments)
            if pushed is not None:
                return solved, pushed
        return turning_overlap.take_back(given, solved, before, solve)

    def _solve(self, problem: StepProblem) -> StepProblem:
        """Solve from the guess; returns the problem with the stiffness of its links and the velocities at its end."""
        links = self._links if self.geometric_stiffness else None
        problem, self.report = solve_step(problem, self.solver, links)
        return problem

    # ---------------------------------------------------------------------------------------------------- warnings

    def _watched(self, found: Found, force: np.ndarray, before: np.ndarray) -> list[str]:
        """Warnings of a step: large displacements, links off their length, energy that links took, energy that was made."""
        h, end = self.time_step, self.state.time + self.time_step

        def thrust() -> float:
            """Kinetic energy [J] that the external forces of a step would give to bodies at rest, plus the energy of
            velocities of eight roundings of a position per step."""
            given = float((self.model.inverse_mass * (h * force) ** 2).sum())
            rounding = 8.0 * np.finfo(float).eps * found.problem.system.farness
            return 0.5 * (given + float(self.model.free_mass[:, 0].dot(rounding**2)))

        def shock() -> float:
            """Kinetic energy [J] that the normal impulses of the step would give to bodies at rest, one by one."""
            system = found.problem.system
            return 0.5 * float((system.impulse[:, 0] ** 2 * system.delassus[:, 0]).sum())

        links, solved = len(self.model.links) > 0, self.report.solved
        sentences = self._displacement_watch.far(found.moves, before, found.problem.system.velocity, end, h)
        if links:
            if solved:  # else: a lock?
                sentences += self._watch.spans(self._straight_spans, found.solved)
            unresolved, first = np.zeros(0), found.solved
            if not self.geometric_stiffness:
                unresolved = self._links.resolution(first.system.impulse, first.data.gap, h)
            sentences += self._watch.links(first, unresolved)
        sentences += self._watch.overlaps(found.solved)
        sentences += self._driven_overlaps.after_step(self.state.positions, end)
        if links:
            sentences += self._damped_waves.after_step(found.problem, self._links, before, end)
            if solved:
                sentences += self._watch.jerk(found.problem, found.solved.data.gap, self.energy, thrust)
        sentences += self._watch.energy(self.energy, thrust, shock, end, h)
        return sentences

    def _count_unsolved(self) -> list[str]:
        """Count a step that was not solved; returns a sentence for the first one outside a run."""
        self.unconverged_steps += 1
        self.worst_residual = max(self.worst_residual, self.report.residual)
        self.worst_slip = max(self.worst_slip, self.report.slip)
        if self._running or self.on_unconverged != "warn" or not self._said.first("unsolved"):
            return []
        return [
            f"Step {self.steps}, to t = {self.time:g} s, did not reach the solver's tolerance: {self.report}. Later ones "
            "give no warning; unconverged_steps counts them. Raise max_iterations, relax tolerance or slip, or say "
            "on_unconverged='ignore'."
        ]

    def _unsolved(self) -> RuntimeError:
        """The error for a last step that was not solved."""
        return RuntimeError(f"Step {self.steps}, to t = {self.time:g} s, was not solved: {self.report}.")

    # -------------------------------------------------------------------------------------------------- checkpoints

    def checkpoint(self) -> Checkpoint:
        """All that the next step depends on, copied."""
        self._journal.settle(self._go_back)
        if self.state.stale or self._scheme != (self.time_step, self.theta):
            for sentence in self._journal.whole_or_not_at_all(self._all, self._take_statements, self._go_back):
                warn(sentence)
        return Checkpoint(
            positions=self.state.positions.copy(),
            velocities=self.state.velocities.copy(),
            left=self._left.copy(),
            time=self.state.time,
            time_step=self.time_step,
            theta=self.theta,
            steps=self.steps,
            unconverged_steps=self.unconverged_steps,
            worst_residual=self.worst_residual,
            energy=deepcopy(self.energy),
            memory=self._detector.give_memory(),
            predicted=self._turning_stretch.predicted.copy(),
            changes=as_rows(self.state.changes),
        )

    @named_arguments
    def restore(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint of this scene, bit for bit; ``interactions`` are empty until the next step.

        If the simulation has another time step than the checkpoint, the next step starts from the same forces.
        """
        self._refuse_asked("restore")
        if not isinstance(checkpoint, Checkpoint):
            raise TypeError(f"restore takes what Simulation.checkpoint() gave, got {shown(checkpoint)}.")
        check(checkpoint, self.checkpoint())
        changes = from_rows(checkpoint.changes, self.scene.counts)
        self._journal.whole_or_not_at_all(self._all, lambda: self._take(checkpoint, changes), self._go_back)

    def _take(self, checkpoint: Checkpoint, changes: list[Change]) -> None:
        """Take the state of a checkpoint; ValueError if it holds interactions of another scene."""
        self._go_through(changes, checkpoint)
        self._detector.take_memory(checkpoint.memory)
        self.state.positions[:] = checkpoint.positions
        self._driven_overlaps.look_at(self.model, self.state.positions)
        self._damped_waves.look_at(self.model)
        self.state.velocities[:] = checkpoint.velocities
        self._left = checkpoint.left.copy()
        self.state.time = checkpoint.time
        self._scheme = checkpoint.time_step, checkpoint.theta
        self.steps = self.state.steps = checkpoint.steps
        self.unconverged_steps = checkpoint.unconverged_steps
        self.worst_residual = checkpoint.worst_residual
        self.worst_slip = 0.0  # no checkpoint holds it
        self.energy = deepcopy(checkpoint.energy)
        self._turning_stretch.restore(checkpoint.predicted)
        self.report = Report()

    def _go_through(self, changes: list[Change], checkpoint: Checkpoint) -> None:
        """Make the scene again from its start with these statements. Statements that were made at the checkpoint give
        energy in the step after it, so the model must know the chains before them."""
        if changes != self.state.changes:
            self.state.time = checkpoint.time
            self.model = replace(self.model, drawn=-np.inf)
            self.scene.go_through([change for change in changes if change.step < checkpoint.steps])
            self._take_changes()  # of bodies that were there before: no sentences
            self.model = replace(self.model, drawn=-np.inf)
            self.scene.go_through(changes)
            self._take_changes()

    # ------------------------------------------------------------------------------------------------------ results

    @property
    def time_step(self) -> float:
        """The time step [s]. It may be changed between steps, but not in a run that is recorded: its file holds one.

        The next step then starts from the forces of the last one, and from the states of its laws.
        """
        return self._time_step

    @time_step.setter
    def time_step(self, time_step: float) -> None:
        self._refuse_recorded("time_step")
        self._time_step = number(time_step, "time_step", above=0.0, unit="s")

    @property
    def theta(self) -> float:
        """theta of the time stepping, in [0.5, 1]. It may be changed between steps, but not in a run that is recorded."""
        return self._theta

    @theta.setter
    def theta(self, theta: float) -> None:
        self._refuse_recorded("theta")
        self._theta = number(theta, "theta", minimum=0.5, maximum=1.0)

    @property
    def on_unconverged(self) -> str:
        """Answer to a step that the solver did not solve: "warn", "stop" or "ignore"."""
        return self._on_unconverged

    @on_unconverged.setter
    def on_unconverged(self, on_unconverged: str) -> None:
        self._on_unconverged = one_of(on_unconverged, "on_unconverged", REACTIONS)

    @property
    def geometric_stiffness(self) -> bool:
        """Whether links that turn by more than a step resolves are corrected. It may be changed between steps, but not in a
        run that is recorded."""
        return self._geometric_stiffness

    @geometric_stiffness.setter
    def geometric_stiffness(self, geometric_stiffness: bool) -> None:
        self._refuse_recorded("geometric_stiffness")
        self._geometric_stiffness = flag(geometric_stiffness, "geometric_stiffness")

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self.__dict__ and self._made and not hasattr(type(self), name) and self._is_own():
            known = ("geometric_stiffness", "on_unconverged", "solver", "theta", "threads", "time_step")
            raise AttributeError(f"A simulation has no '{name}' that could be set{closest(name, known)}")
        super().__setattr__(name, value)

    def _is_own(self) -> bool:
        """Whether the class is one of lmgcpy: a user's own class may have any attribute."""
        return type(self).__module__.startswith("lmgcpy.")

    @property
    def solver(self) -> Solver:
        """The solver. It may be changed between steps, but not in a run that is recorded: its file holds one."""
        return self._solver

    @solver.setter
    def solver(self, solver: Solver) -> None:
        self._refuse_recorded("solver")
        check_solver(solver)
        self._solver = solver

    def _refuse_asked(self, call: str) -> None:
        """RuntimeError in a function that a recorded run calls: its file would have a hole, or a step twice."""
        if self._asked and self.state.recorded:
            raise RuntimeError(
                f"{call} cannot be called in {self._asked} of a run that is recorded: the steps in its file are those that "
                f"the run makes. Call {call} after the run."
            )

    def _refuse_recorded(self, what: str) -> None:
        if self._made:
            self.state.refuse_recorded(what)

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
        """Angular velocities [rad/s], (n,) in 2D, (n, 3) in 3D, along the axes of space: a view of the state, or a copy if
        bodies keep a rotation in space."""
        return self.velocities_in_space[:, 2 if self.model.dimension == 2 else slice(3, 6)]

    @property
    def velocities_in_space(self) -> np.ndarray:
        """Velocities [m/s] and spins [rad/s] along the axes of space, (n, k): a view of the state, or a copy if bodies keep
        a rotation in space."""
        state, turning = self.state, self.state.turning
        if not len(turning):
            return state.velocities
        velocities = state.velocities.copy()
        velocities[turning, 3:] = in_space(state.positions[turning, 3:], velocities[turning, 3:])
        return velocities

    @property
    def rotations(self) -> np.ndarray:
        """Angles turned [rad], (n,), a view of the state. In 3D quaternions (q_x, q_y, q_z, q_w), (n, 4), a view to
        read; AttributeError if no body keeps a rotation."""
        if self.model.dimension == 2:
            return self.state.positions[:, 2]
        if not len(self.state.turning):
            raise AttributeError("No body of this scene keeps a rotation: spheres look alike from all sides.")
        quaternions = self.state.positions[:, 3:]
        return read_only(quaternions)  # four numbers that are no rotation would pass for one

    @property
    def interactions(self) -> InteractionView:
        """Links and all candidates within alert of the last step, copied; none before it and after a step that failed."""
        if self._last is None:
            return InteractionView.empty(self.model.dimension, self._detector.state_names, self._detector.rolling_rows)
        problem, interactions, model, _ = self._last
        detected = self._last.detected(self.positions)
        return InteractionView.of(problem, interactions, self._detector.state_names, detected, model.extent)

    @property
    def last_step(self) -> MadeStep | None:
        """The last step as it was made; None before it and after a step that failed."""
        return self._last

    def _reaction_of(self, body: int) -> Any:
        """The reaction of a body in the last step; simulations ask the measures."""
        raise NotImplementedError

    def problem(self) -> Problem:
        """The last step as a problem of its own: to solve otherwise, to measure, to write out.

        Raises RuntimeError before the first step and TypeError if a law has no conic form.
        """
        if self._last is None:
            raise RuntimeError("There is no step yet to make a problem of: call step() or run() first.")
        return self._last.problem.conic()[0]

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} of {len(self.positions)} bodies at t = {self.time:g} s, step {self.steps}, "
            f"h = {self.time_step:g} s; {f'last step {self.report.status}' if self.steps else 'no step yet'}>"
        )


def is_small(model: Model) -> bool:
    """Whether steps of plain Python serve until the kernels of a scene are compiled: it has few bodies, and laws of
    lmgcpy, which are known to compile."""
    laws = [*(row.law for row in model.rows), *(links.law for links in model.links)]
    return len(model.mass) <= MOST and all(map(of_lmgcpy, laws))


def of_lmgcpy(part: Any) -> bool:
    """Whether a law or a solver is one of lmgcpy."""
    return type(part).__module__.startswith("lmgcpy.")
