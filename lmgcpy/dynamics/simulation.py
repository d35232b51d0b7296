"""Moreau-Jean time stepping (theta-method) of a compiled scene."""

from __future__ import annotations

import time as clock
from dataclasses import replace
from typing import Any

import numpy as np

from lmgcpy.contact.detector import Detector
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.dynamics.as_problem import as_problem
from lmgcpy.dynamics.assembly import StepProblem, assemble
from lmgcpy.dynamics.energy import Energy, kinetic_energy
from lmgcpy.dynamics.interactions import InteractionView
from lmgcpy.dynamics.model import Model, State
from lmgcpy.errors import number, whole
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel
from lmgcpy.solve.problem import Problem
from lmgcpy.solve.report import NOT_FINITE, STATUS, Report


class Simulation:
    """Steps a scene through time.

    ``time_step`` h [s]; ``theta`` in [0.5, 1] of the time stepping, 0.5 is of second order in free motion and keeps the
    energy; ``solver``: of the problem of each step, ``AcceleratedGaussSeidel()`` if none is given. The scene is compiled
    and cannot be edited any more; its bodies become views of the simulation's state.

    The loop, for velocities v, positions q, external forces F, and impulses r along H:

        q_m    = q + (1 - theta) h v              detection at q_m
        v_free = v + h M^-1 F                     imposed components take their value at the end of the step
        solve  u = H^T v_free + W r and the laws
        v      = v_free + M^-1 H r
        q      = q_m + theta h v
    """

    def __init__(
        self,
        scene: Any,
        *,
        time_step: float,
        theta: float = 0.5,
        solver: AcceleratedGaussSeidel | GaussSeidel | None = None,
    ):
        self.time_step = number(time_step, "time_step", above=0.0, unit="s")
        self.theta = number(theta, "theta", minimum=0.5, maximum=1.0)
        self.solver = AcceleratedGaussSeidel() if solver is None else solver
        if not callable(getattr(self.solver, "solve", None)):
            raise TypeError(f"solver must be a solver such as lmgcpy.GaussSeidel(), got {self.solver!r}.")
        self.model: Model = scene.compile()
        self.state: State = self.model.start
        for drive in self.model.velocities:
            self.state.velocities[drive.body, drive.component] = drive.at(self.state.time)
        self.steps = 0
        self.report = Report()
        self._free_mass = np.where(self.model.inverse_mass > 0.0, self.model.mass, 0.0)
        self.energy = Energy(kinetic=kinetic_energy(self._free_mass, self.state.velocities))
        model = self.model
        self._detector = Detector(model.contactors, model.rows, model.chains, model.inverse_mass)
        self._work = np.zeros((4, max((chain.link_count for chain in self.model.chains), default=0)))
        self._last: tuple[StepProblem, Interactions] | None = None
        self._free_velocity = np.zeros_like(self.state.velocities)
        self._guess = np.zeros((0, 2))

    # ---------------------------------------------------------------------------------------------------- the loop

    def run(self, steps: int | None = None, *, duration: float | None = None, progress: bool = False) -> Simulation:
        """Make so many steps, or as many as the duration [s] takes; returns the simulation itself.

        ``progress``: a bar, where standard error is a terminal.
        """
        if (steps is None) == (duration is None):
            raise TypeError("run takes either steps or duration [s], one of the two.")
        if duration is not None:
            steps = round(number(duration, "duration", minimum=0.0, unit="s") / self.time_step)
        turns: Any = range(whole(steps, "steps"))
        if progress:
            from tqdm import tqdm

            turns = tqdm(turns, desc="lmgcpy", unit="step", disable=None)
        for _ in turns:
            self.step()
        return self

    def step(self) -> Report:
        """Make one step; returns how it was solved."""
        begin = clock.perf_counter()
        h, state = self.time_step, self.state
        before = state.velocities.copy()
        state.positions += (1.0 - self.theta) * h * before
        travel = h * float(np.sqrt(np.max(np.sum(before[:, :2] ** 2, axis=1), initial=0.0)))
        interactions = self._detector.detect(state.positions, travel)
        force = self._force(state.time + 0.5 * h)
        free_velocity = before + h * self.model.inverse_mass * force
        for drive in self.model.velocities:
            free_velocity[drive.body, drive.component] = drive.at(state.time + h)
        problem = assemble(
            self._detector.groups,
            interactions,
            time=state.time,
            time_step=h,
            before=before,
            free_velocity=free_velocity,
            inverse_mass=self.model.inverse_mass,
            work=self._work,
            wire_blocks=self.solver.wire_blocks,
        )
        self._solve(problem, interactions, free_velocity)
        state.velocities[:] = problem.system.velocity
        state.positions += self.theta * h * state.velocities
        state.time += h
        self.steps += 1
        self.energy.advance(problem, interactions.gap, h, self._free_mass, force, before, state.velocities)
        self._last = problem, interactions
        self.report = replace(self.report, step_seconds=clock.perf_counter() - begin)
        return self.report

    def _force(self, time: float) -> np.ndarray:
        """External forces on the free components at a time [N], (n, 3)."""
        force = self.model.weight.copy()
        for load in self.model.forces:
            force[load.body, load.component] += load.at(time)
        return force

    def _solve(self, problem: StepProblem, interactions: Interactions, free_velocity: np.ndarray) -> None:
        """Solve from the impulses of the last step and remember the new ones."""
        start = clock.perf_counter()
        guess = self._guess = self._detector.recall(interactions)
        self._free_velocity = free_velocity
        iterations, residual, status = self.solver.solve(problem.table, problem.system, free_velocity, guess)
        end = clock.perf_counter()
        self._detector.remember(interactions, problem.system.impulse)
        self.report = Report(
            iterations=iterations,
            residual=residual,
            status=STATUS[status],
            worst=problem.worst(),
            interactions=len(interactions.gap),
            seconds=end - start,
        )
        if status == NOT_FINITE:
            raise FloatingPointError(
                f"In the step from t = {self.state.time:g} s a number stopped being finite; "
                f"the worst interaction is {self.report.worst}."
            )

    # ------------------------------------------------------------------------------------------------------ results

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
        """Angular velocities [rad/s], (n,), a view of the state."""
        return self.state.velocities[:, 2]

    @property
    def rotations(self) -> np.ndarray:
        """Angles turned [rad], (n,), a view of the state."""
        return self.state.positions[:, 2]

    @property
    def interactions(self) -> InteractionView:
        """Links and all candidates within alert of the last step, copied; none before the first step."""
        if self._last is None:
            return InteractionView.of([], None, np.zeros((0, 2)), self.time_step)
        problem, interactions = self._last
        return InteractionView.of(problem.groups, interactions, problem.system.impulse, self.time_step)

    def problem(self) -> Problem:
        """The last step as a problem of its own: to solve otherwise, to measure, to write out.

        Raises RuntimeError before the first step and TypeError where a law has no conic form.
        """
        if self._last is None:
            raise RuntimeError("There is no step yet to make a problem of: call step() or run() first.")
        return as_problem(self._last[0], self._free_velocity, self._guess)

    def __repr__(self) -> str:
        return (
            f"<Simulation of {len(self.positions)} bodies at t = {self.time:g} s, step {self.steps}, "
            f"h = {self.time_step:g} s; last step {self.report.status}>"
        )
