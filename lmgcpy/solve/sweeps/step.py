"""The problem of one time step in one object: the argument of a solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.contact.spare_rows import with_spare_rows
from lmgcpy.solve.kernels.matrix_system import MatrixSystem
from lmgcpy.solve.kernels.system import Groups, System
from lmgcpy.solve.problems.problem import Conic
from lmgcpy.solve.problems.report import Outcome
from lmgcpy.solve.sweeps.light_bodies import LightBodies, no_light_bodies
from lmgcpy.solve.sweeps.sweep import judge, work
from lmgcpy.solve.sweeps.team import Crew, Iterates


@dataclass(frozen=True)
class ConicForm:
    """Makes the problem of a step in conic form when it is called, which may take longer than some sweeps."""

    make: Callable[[], Conic]
    """Assembles the problem."""
    missing: str | None = None
    """Name of a law of the step that has no conic form; the call raises TypeError then."""

    def __call__(self) -> Conic:
        return self.make()

    def __repr__(self) -> str:
        return f"<ConicForm: {'to be assembled' if self.missing is None else f'none, law {self.missing!r} has none'}>"


@dataclass(frozen=True)
class Step:
    """The problem of one time step, of m interactions in dimension d: ``u = H^T v_free + W r`` and a law for each.

    Arrays of shape (m, d) have further columns in scenes with rolling friction: 3 in all in 2D, and 6 in 3D.

    A solver gets it from a scene (dynamics makes it from its ``StepProblem``) or from a :class:`Problem <lmgcpy.Problem>`
    that stands alone. The solver leaves impulses in ``system.impulse`` and the velocities that belong to them in
    ``system.velocity``. A solver on an assembled W asks for ``conic()`` and gives its impulses to :meth:`judged`; a solver
    by sweeps calls the kernels of the groups through :meth:`led`.
    """

    groups: Groups
    """Rows of the groups of interactions, and the kernels of their laws."""
    system: System | MatrixSystem
    """The arrays of the interactions and velocities."""
    free_velocity: np.ndarray
    """Velocities without impulses: of the bodies (n, k), or of the interactions (m, d) if there are no bodies."""
    guess: np.ndarray
    """Impulses to start from [N s], (m, d)."""
    conic: ConicForm
    """``conic()`` gives (problem, acting): the step as a :class:`Problem <lmgcpy.Problem>`, and whether each of the m
    interactions is in it, (m,) bool. It raises TypeError if a law has no conic form; ``conic.missing`` names that law."""
    components: Callable[[], np.ndarray]
    """``components()`` says whether the law of an interaction has a component of the impulse, (m, d) bool."""
    driver: Mapping[str, Any] = field(default_factory=dict)
    """Slots of the kernels that lead sweeps, for the kind of bodies that there are."""
    light: LightBodies = field(default_factory=lambda: no_light_bodies(0))
    """Bodies that are swept with a larger mass than they have."""
    threads: int = 1
    """How many threads may share the work of a partitioned scene."""

    def __repr__(self) -> str:
        return f"<Step of {len(self.guess)} interactions in {self.dimension}D>"

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.system.carried.shape[1] + 1

    def starting_from(self, guess: np.ndarray) -> Step:
        """This step with other impulses to start from, (m, d)."""
        return self if guess is self.guess else replace(self, guess=guess)

    def led(self, solver: Kernel, bounds: tuple[float, float, float], *limits: Any, iterates: bool = False) -> Outcome:
        """Run ``solver(team, *limits)``, a kernel that leads sweeps and returns (sweeps, status).

        ``bounds``: of the residual, the slip and the error of a force, see :class:`Solver <lmgcpy.Solver>`. ``iterates``:
        whether the solver keeps the iterates of accelerated sweeps.
        """
        crew = self._crew_with_iterates if iterates else self._crew
        sweeps, status = crew.lead(solver, bounds, *limits)
        residual, slip, _, _, force, imbalance = self.system.measured.tolist()
        return Outcome(sweeps, residual, status, 0, slip, max(force, imbalance))

    @cached_property
    def _crew(self) -> Crew:
        return self._crew_of(Iterates(*[np.zeros(0)] * len(Iterates._fields)))

    @cached_property
    def _crew_with_iterates(self) -> Crew:
        system = self.system
        impulse, velocity = system.impulse.reshape(-1), system.velocity.reshape(-1)
        start, last, best = (with_spare_rows(len(impulse)) for _ in range(3))
        weight = system.delassus[:, : system.impulse.shape[1]].reshape(-1)
        return self._crew_of(Iterates(impulse, velocity, start, last, with_spare_rows(len(velocity)), best, weight))

    def _crew_of(self, iterates: Iterates) -> Crew:
        arrays = self.groups, self.system, self.free_velocity, self.guess, self.light
        return Crew(work.specialise(**self.driver), arrays, iterates, self.threads)

    def judged(self, impulses: np.ndarray, bounds: tuple[float, float, float]) -> Outcome:
        """Take impulses (m, d) for the answer: velocities are made from them, and the kernels of the laws measure them.

        Components that a law does not have are set to zero: no law would measure them. ``bounds``: as of :meth:`led`. The
        status is "converged", "round-off", "not finite" or "budget spent".
        """
        there = self.components()
        impulses = np.where(there, impulses, 0.0)
        return self.starting_from(impulses).led(judge, bounds)
