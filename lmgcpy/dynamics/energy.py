"""The energy balance of a step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lmgcpy.dynamics.assembly import StepProblem, ask
from lmgcpy.dynamics.not_finite import check_energy


@dataclass
class Energy:
    """Energies and works in [J] (per metre of depth in 2D).

    At every step ``kinetic - kinetic before = loads + drives + sum of interactions`` holds to round-off, each term the
    work at the mean velocity of the step: of gravity and imposed forces, of whatever holds the driven components, and of
    the impulses by name of law. ``kinetic`` is that of the free components. Names with ``total_`` are sums over the run.
    """

    kinetic: float = 0.0
    loads: float = 0.0
    drives: float = 0.0
    interactions: dict[str, float] = field(default_factory=dict)
    stored: dict[str, float] = field(default_factory=dict)
    """Energy in elastic links at the predicted gaps, by law; at each step its change and the work of the links'
    impulses sum to what the scheme damps, plus the links' second-order stretch."""
    defect: float = 0.0
    """What is left of the identity in this step."""
    total_loads: float = 0.0
    total_drives: float = 0.0
    total_interactions: dict[str, float] = field(default_factory=dict)

    @property
    def mechanical(self) -> float:
        """Kinetic and stored energy."""
        return self.kinetic + sum(self.stored.values())

    def advance(
        self,
        problem: StepProblem,
        mass: np.ndarray,
        force: np.ndarray,
        before: np.ndarray,
        after: np.ndarray,
    ) -> None:
        """Enter a closed step: ``mass`` and ``force`` by component, both zero where driven; velocities of the bodies.

        Raises FloatingPointError where a stored energy is not finite, with nothing entered.
        """
        mean = 0.5 * (before + after)
        data = problem.data
        relative_mean = 0.5 * (data.before + data.after)
        received = np.empty_like(mean)
        problem.space.momentum(problem.system, received)
        # impulses do work on driven components too, which their drives must bring up
        drives = -dot(np.where(mass > 0.0, 0.0, received), mean)
        works: dict[str, float] = {}
        stored: dict[str, float] = {}
        for group, kernels in zip(problem.groups, problem.kernels, strict=True):
            part = slice(group.start, group.stop)
            name = group.law.NAME
            works[name] = works.get(name, 0.0) + dot(problem.system.impulse[part], relative_mean[part])
            if kernels.energy is not None:
                arguments = group.start, group.stop, data, group.parameters.ravel()
                energy = ask(group, kernels.energy, "energy", problem.system, data, arguments)
                check_energy(problem, group, energy)
                stored[name] = stored.get(name, 0.0) + energy
        # from the change of velocity, not from two large numbers that nearly cancel
        gain = dot(mass * (after - before), mean)
        self.kinetic = kinetic_energy(mass, after)
        self.loads = data.time_step * dot(force, mean)
        self.drives = drives
        self.interactions = works
        self.stored = stored
        self.defect = gain - (self.loads + drives + sum(works.values()))
        self.total_loads += self.loads
        self.total_drives += drives
        for name, work in works.items():
            self.total_interactions[name] = self.total_interactions.get(name, 0.0) + work


PIECE = 8192
"""So many products a call of BLAS, which shares out longer sums among threads: their number would show in the last bits,
and on a busy machine the waiting for them took longer than the whole of the rest (16 ms at 10 000 spheres)."""


def dot(one: np.ndarray, other: np.ndarray) -> float:
    """Sum of the products of two arrays of one shape."""
    x, y = one.ravel(), other.ravel()
    return sum((float(np.dot(x[k : k + PIECE], y[k : k + PIECE])) for k in range(0, len(x), PIECE)), 0.0)


def kinetic_energy(mass: np.ndarray, velocities: np.ndarray) -> float:
    """``v . M v / 2`` [J]; ``mass`` by component, zero where driven."""
    return 0.5 * dot(mass * velocities, velocities)
