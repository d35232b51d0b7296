"""What a hard case is: a scene that makes solvers fail, run with one of them, and numbers that are known beforehand."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import lmgcpy as lm

SOLVERS: dict[str, type] = {"GaussSeidel": lm.GaussSeidel, "Newton": lm.Newton, "Auto": lm.Auto}
"""Taken as they come, with their own budgets; a case gives the tolerance."""


@dataclass(frozen=True)
class Number:
    """An error, and what it may be."""

    what: str
    value: float
    bound: float

    @property
    def holds(self) -> bool:
        """Whether the value is within its bound; a NaN is not."""
        return self.value <= self.bound

    def __str__(self) -> str:
        return f"{self.what} {self.value:.1e}"


@dataclass(frozen=True)
class Result:
    """What one solver made of a case."""

    numbers: tuple[Number, ...]
    residual: float
    """Largest of all steps."""
    energy: float
    """What interactions made out of nothing, see :class:`Watch`."""
    seconds: float
    """Of the processor, for the steps."""

    @property
    def holds(self) -> bool:
        """Whether all numbers are within their bounds."""
        return all(number.holds for number in self.numbers)

    def __str__(self) -> str:
        numbers = ", ".join(map(str, self.numbers))
        return f"{numbers}; residual {self.residual:.1e}, energy {self.energy:.1e}, {self.seconds:.2f} s"


@dataclass(frozen=True)
class Case:
    """A hard case; the docstring of ``scene`` says why it is hard and derives its number.

    ``scene(solver, long)`` runs it. ``tolerance``: residual that the numbers need; ``fails``: solvers that do not reach
    the numbers, with the reason; ``others``: what other codes do, where measured; ``long``: whether the long form is
    another than the short one; ``says``: beginnings of what a run rightly warns of, as its coarsest steps turn links by
    much; ``solvers``: those that it runs with, fewer where the case is about the scheme or where one
    would take minutes for its failure; ``without``: what becomes of it without geometric stiffness, where that is what the
    case is about.
    """

    name: str
    scene: Callable[..., Result]
    tolerance: float
    fails: dict[str, str] = field(default_factory=dict)
    others: str = ""
    says: tuple[str, ...] = ()
    long: bool = False
    solvers: tuple[str, ...] = tuple(SOLVERS)
    without: str = ""

    def run(self, solver: str, long: bool = False, **options: Any) -> Result:
        """Run with the solver of that name; ``options`` of the simulation, for the cases of taut wires."""
        return self.scene(SOLVERS[solver](tolerance=self.tolerance), long, **options)


class Watch:
    """Makes the steps of a simulation and keeps what they cost and what became of the energy.

    ``made`` [J]: the work of all interactions plus what is stored in elastic links, which can only fall in nature;
    ``turned`` [J]: the largest so far of mechanical energy and of the work of loads and drives, and no less than what
    gravity alone gives from rest in a step; ``energy``: the largest
    rise of ``made`` from any earlier to any later time, in parts of ``turned``; ``gained``: the largest work so far of any
    one law from the start, with what its links store, in parts of ``turned``: none of the laws here has energy to give.
    """

    def __init__(self, sim: lm.Simulation):
        self.sim = sim
        self.residual = self.seconds = 0.0
        self.made = 0.0
        thrust = sim.time_step * sim.model.weight  # of gravity in a step
        self.turned = sim.energy.mechanical + 0.5 * float((thrust**2 * sim.model.inverse_mass).sum())
        self._lowest = self._rise = self._gain = 0.0

    def step(self) -> lm.Simulation:
        """One step."""
        begin = clock.process_time()
        report = self.sim.step()
        self.seconds += clock.process_time() - begin
        energy = self.sim.energy
        self.residual = max(self.residual, report.residual)
        self.made = sum(energy.total_interactions.values()) + sum(energy.stored.values())
        of_laws = [work + energy.stored.get(name, 0.0) for name, work in energy.total_interactions.items()]
        self._gain = max(self._gain, *of_laws, 0.0)
        self._lowest = min(self._lowest, self.made)
        self._rise = max(self._rise, self.made - self._lowest)
        self.turned = max(self.turned, energy.mechanical, abs(energy.total_loads), abs(energy.total_drives))
        return self.sim

    def run(self, steps: int) -> lm.Simulation:
        """So many steps."""
        for _ in range(steps):
            self.step()
        return self.sim

    @property
    def energy(self) -> float:
        """See the class."""
        return self._rise / self.turned if self.turned > 0.0 else self._rise

    @property
    def gained(self) -> float:
        """See the class."""
        return self._gain / self.turned if self.turned > 0.0 else self._gain

    def result(self, *numbers: Number) -> Result:
        """With what was seen."""
        return Result(numbers, self.residual, self.energy, self.seconds)


def worst_of(results: list[Result]) -> Result:
    """Several runs as one: of each number the worst, all seconds."""
    numbers: dict[str, Number] = {}
    for number in (number for result in results for number in result.numbers):
        if number.what not in numbers or not number.value <= numbers[number.what].value:
            numbers[number.what] = number
    return Result(
        tuple(numbers.values()),
        max(result.residual for result in results),
        max(result.energy for result in results),
        sum(result.seconds for result in results),
    )
