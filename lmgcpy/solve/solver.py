"""What a solver is to those who call one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from lmgcpy.errors import number, shown
from lmgcpy.solve.system import Groups

if TYPE_CHECKING:
    from lmgcpy.solve.problem import ConicForm


class Outcome(NamedTuple):
    """How a solve ended."""

    iterations: int
    """Sweeps."""
    residual: float
    """``|e(r)| / |e(0)|``."""
    status: int
    """Place in ``lmgcpy.solve.report.STATUS``."""
    factorisations: int = 0
    """Newton steps, each of which factorised a sparse matrix."""
    slip: float = 0.0
    """Largest ``h |e_i| / R_i``; 0 where no sizes are known."""


MOST_SLIP = 3e-3
"""No tolerance is so loose that an error may move an interaction by more in a step, in parts of its smaller body's radius.

The quick studies, at tolerances of 3e-4 to 1e-2, leave by the residual alone slips of up to 4e-3 (biaxial; 5e-4 in the
tests, the rest as the sample is laid), 3e-3 (triaxial) and 7e-3 (column). All sweeps of a study, in parts of those without
this bound, are with 3e-3: triaxial 1.01, column 1.01; with 2e-3: biaxial 1.02, triaxial 1.06, column 1.16; with 5e-4:
biaxial 0.97, triaxial 2.8, column 1.22."""


def check_tolerances(solver: Any) -> None:
    """Check ``tolerance`` and ``slip`` of a frozen solver in place (TypeError, ValueError)."""
    object.__setattr__(solver, "tolerance", number(solver.tolerance, "tolerance", above=0.0, maximum=1.0))
    if solver.slip is not None:
        object.__setattr__(solver, "slip", number(solver.slip, "slip", above=0.0))


def largest_slip(solver: Any) -> float:
    """What a solver allows of ``h |e_i| / R_i``: what it was given, or else its tolerance up to :data:`MOST_SLIP`."""
    return float(min(solver.tolerance, MOST_SLIP) if solver.slip is None else solver.slip)


def outcome(system: Any, sweeps: int, status: int) -> Outcome:
    """How a solve by sweeps ended, with what they left in ``system.told``."""
    return Outcome(sweeps, float(system.told[0]), status, 0, float(system.told[1]))


class Solver(Protocol):
    """A small frozen configuration object with a ``solve``."""

    @property
    def tolerance(self) -> float:
        """Residual at which a problem is solved."""

    @property
    def wire_blocks(self) -> bool:
        """Whether wires are solved as blocks."""

    def solve(
        self,
        groups: Groups,
        system: Any,
        free_velocity: np.ndarray,
        guess: np.ndarray,
        *,
        conic: ConicForm,
        **operator: Any,
    ) -> Outcome:
        """Solve in place from the impulses ``guess``: those in ``system`` and its velocities.

        ``conic`` makes the problem in conic form, for solvers that need it; ``operator``: functions that stand in for
        those on bodies, for a problem with an assembled W.
        """
        ...


def check_solver(solver: Any) -> None:
    """TypeError where ``solver`` is none."""
    if isinstance(solver, type) or not hasattr(solver, "wire_blocks") or not hasattr(solver, "solve"):
        raise TypeError(f"solver must be a solver such as lmgcpy.GaussSeidel(), got {shown(solver)}.")
