"""The problem of one time step in one object: the argument of a solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.solve.kernels.matrix_system import MatrixSystem
from lmgcpy.solve.kernels.system import Groups, System
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.problems.report import Outcome
from lmgcpy.solve.sweeps.light_bodies import LightBodies, no_light_bodies
from lmgcpy.solve.sweeps.sweep import judge, work
from lmgcpy.solve.sweeps.team import Crew, make_ready


@dataclass(kw_only=True, eq=False, repr=False)
class Step(ABC):
    """The problem of one time step, of m interactions in dimension d: ``u = H^T v_free + W r`` and a law for each.

    Arrays of shape (m, d) have further columns in scenes with rolling friction: 3 in all in 2D, and 6 in 3D.

    A simulation makes it from a scene, and :func:`lmgcpy.solve` from a :class:`Problem <lmgcpy.Problem>` that stands alone.
    A solver leaves impulses in ``system.impulse`` and the velocities that belong to them in ``system.velocity``. A solver
    on an assembled W asks for :meth:`conic` and gives its impulses to :meth:`judged`; a solver by sweeps calls the kernels
    of the groups through :meth:`led`.
    """

    groups: Groups
    """Rows of the groups of interactions, and the kernels of their laws."""
    system: System | MatrixSystem
    """The arrays of the interactions and velocities."""
    free_velocity: np.ndarray
    """Velocities without impulses: of the bodies (n, k), or of the interactions (m, d) if there are no bodies."""
    guess: np.ndarray
    """Impulses to start from [N s], (m, d)."""
    light: LightBodies = field(default_factory=lambda: no_light_bodies(0))
    """Bodies that are swept with a larger mass than they have."""
    row: np.ndarray | None = None
    """Row of each body in the arrays of sweeps (n,), by which bodies that meet are near in memory; None: its own row."""
    threads: int = 1
    """How many threads may share the work of a partitioned scene."""
    crews: dict[bool, Crew] = field(default_factory=dict, init=False)
    """Threads and their shared arrays without and with the iterates of accelerated sweeps, made when they are asked for."""

    DRIVER: ClassVar[Mapping[str, Any]] = {}
    """Slots of the kernels that lead sweeps, for the kind of bodies that there are."""

    @abstractmethod
    def conic(self) -> tuple[Problem, np.ndarray]:
        """The step in conic form, with an assembled W, and whether each of the m interactions is in it, (m,) bool.

        TypeError if a law has no conic form. It may take longer than some sweeps.
        """

    @property
    def resists(self) -> bool:
        """Whether a law has friction that depends on the impulses, ``Law.resisted``."""
        return False

    def resist(self, acting: np.ndarray, a: np.ndarray, w: np.ndarray, friction: np.ndarray, slip: np.ndarray) -> None:
        """Enter the coefficients of friction (k,) and slips [m/s] (k, d - 1) of these laws at ``a = r - u/w`` (k, d),
        w (k,), of the interactions ``acting`` (m,) in conic form."""
        raise TypeError("No law of this step has friction that depends on the impulses.")

    @property
    @abstractmethod
    def law_without_conic(self) -> str | None:
        """Name of a law of the step that has no conic form; None if all have one."""

    @abstractmethod
    def components(self) -> np.ndarray:
        """Whether the law of an interaction has a component of the impulse, (m, d) bool."""

    def __repr__(self) -> str:
        return f"<Step of {len(self.guess)} interactions in {self.dimension}D>"

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.system.carried.shape[1] + 1

    def starting_from(self, guess: np.ndarray) -> Self:
        """This step with other impulses to start from, (m, d)."""
        return self if guess is self.guess else replace(self, guess=guess)

    def led(self, solver: Kernel, bounds: tuple[float, float, float], *limits: Any, iterates: bool = False) -> Outcome:
        """Run ``solver(team, *limits)``, a kernel that leads sweeps and returns (sweeps, status).

        ``bounds``: of the residual, the slip and the error of a force, see :class:`Solver <lmgcpy.Solver>`. ``iterates``:
        whether the solver keeps the iterates of accelerated sweeps.
        """
        system = self.system
        if iterates not in self.crews:
            make_ready(solver, limits)
            self.muster(iterates)
        sweeps, status = self.crews[iterates].run(solver, bounds, limits)
        if self.row is not None:
            system.velocity[:] = self.crews[iterates].velocity.take(self.row, axis=0)
        residual, slip, _, _, force, imbalance = system.measured.tolist()
        return Outcome(sweeps, residual, status, 0, slip, max(force, imbalance))

    def muster(self, iterates: bool) -> None:
        """Make a crew for this step, with the iterates of accelerated sweeps or without."""
        system, free_velocity, light = self.system, self.free_velocity, self.light
        if self.row is not None:
            assert isinstance(system, System)
            system, free_velocity = system.reordered(self.row, free_velocity)
            light = light._replace(body=self.row[light.body])
        elif len(light.body):
            free_velocity = free_velocity.copy()  # sweeps move the centres of light bodies
        arrays = self.groups, system, free_velocity, self.guess, light
        self.crews[iterates] = Crew(work.specialise(**self.DRIVER), arrays, iterates, self.threads)

    def judged(self, impulses: np.ndarray, bounds: tuple[float, float, float]) -> Outcome:
        """Take impulses (m, d) for the answer: velocities are made from them, and the kernels of the laws measure them.

        Components that a law does not have are set to zero: no law would measure them. ``bounds``: as of :meth:`led`. The
        status is "converged", "round-off", "not finite" or "budget spent".
        """
        return self.starting_from(np.where(self.components(), impulses, 0.0)).led(judge, bounds)
