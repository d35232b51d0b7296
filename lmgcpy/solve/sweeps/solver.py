"""The class of solvers: a small frozen object of options with one ``solve(step)``."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.errors import flag, number, shown, whole
from lmgcpy.solve.problems.report import Outcome
from lmgcpy.solve.sweeps.step import Step

MOST_SLIP = 3e-3
"""No tolerance is so loose that an error may move an interaction by more in a step, in parts of its smaller body's radius.

The quick studies, at tolerances of 3e-4 to 1e-2, leave by the residual alone slips of up to 4e-3 (biaxial; 5e-4 in the
tests, the rest as the sample is laid), 3e-3 (triaxial) and 7e-3 (column). All sweeps of a study, in parts of those without
this bound, are with 3e-3: triaxial 1.01, column 1.01; with 2e-3: biaxial 1.02, triaxial 1.06, column 1.16; with 5e-4:
biaxial 0.97, triaxial 2.8, column 1.22."""


FORCE, MOST_FORCE = 100.0, 1e-2
"""Default bound of the error of a force, in parts of the load of its bodies: FORCE times the tolerance, MOST_FORCE at most.

The residual is relative to what loads do to all bodies, which in large samples is a hundredth of what interactions bear.
With errors of a hundredth friction holds a body that hangs on it (``tests/dynamics/test_light_bodies.py``)."""


@dataclass(frozen=True)
class Solver(ABC):
    """Solves the problem of a time step to a tolerance. A solver of your own is a frozen dataclass with one :meth:`solve`.

    ``tolerance``: a step is solved if ``|e(r)| <= tolerance |e(0)|`` (see ``lmgcpy.residual``); ``max_iterations``: sweeps
    a step at the most; ``wire_blocks``: if False, sweeps visit the links of a wire one at a time, as other codes do;
    ``slip``: no interaction's error may make a displacement in the step of more than this part of its smaller body's
    radius, ``h |e_i| <= slip R_i``, by default the tolerance, and 3e-3 if the tolerance is larger; ``force``: no force may
    be off by more than this part of the load of its bodies (``lmgcpy.solve.kernels.loads``), by default a hundred times the
    tolerance, 1e-2 at most.
    """

    tolerance: float = 1e-4
    max_iterations: int = 10_000
    wire_blocks: bool = True
    slip: float | None = None
    force: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", number(self.tolerance, "tolerance", above=0.0, maximum=1.0))
        if self.slip is not None:
            object.__setattr__(self, "slip", number(self.slip, "slip", above=0.0))
        if self.force is not None:
            object.__setattr__(self, "force", number(self.force, "force", above=0.0))
        object.__setattr__(self, "max_iterations", whole(self.max_iterations, "max_iterations", minimum=1))
        flag(self.wire_blocks, "wire_blocks")

    @abstractmethod
    def solve(self, step: Step) -> Outcome:
        """Leave impulses and velocities in ``step.system`` and say how the solve ended.

        :meth:`finish` does both for impulses that were found otherwise than by sweeps on ``step.system``.
        """

    @property
    def largest_slip(self) -> float:
        """Largest ``h |e_i| / R_i`` of a solved step."""
        return float(min(self.tolerance, MOST_SLIP) if self.slip is None else self.slip)

    @cached_property
    def bounds(self) -> tuple[float, float, float]:
        """Largest residual, slip, and error of a force of a solved step."""
        force = min(FORCE * self.tolerance, MOST_FORCE) if self.force is None else self.force
        return float(self.tolerance), self.largest_slip, float(force)

    def finish(self, step: Step, impulses: np.ndarray, *, iterations: int = 0, factorisations: int = 0) -> Outcome:
        """Take impulses (m, d) for the answer to a step and measure them by the kernels of its laws."""
        judged = step.judged(impulses, self.bounds)
        return judged._replace(iterations=iterations, factorisations=factorisations)


def check_solver(solver: Any) -> None:
    """TypeError if ``solver`` is no solver."""
    if not isinstance(solver, Solver):
        raise TypeError(
            f"solver must be a solver such as lmgcpy.GaussSeidel(), or one of your own, derived from lmgcpy.Solver, got "
            f"{shown(solver)}."
        )
