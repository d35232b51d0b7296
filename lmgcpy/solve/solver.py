"""What a solver is to those who call one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from lmgcpy.errors import shown
from lmgcpy.solve.system import Groups

if TYPE_CHECKING:
    from lmgcpy.solve.problem import Conic


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
        conic: Callable[[], Conic],
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
