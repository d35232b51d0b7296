"""What a solver says of a step."""

from __future__ import annotations

from dataclasses import dataclass

CONVERGED, SPENT, STAGNATED, NOT_FINITE = range(4)
STATUS = ("converged", "budget spent", "stagnated", "not finite")


@dataclass(frozen=True)
class Worst:
    """The interaction with the largest error: its law, the ids of ``candidate`` and ``antagonist``, the ``error`` [m/s]."""

    law: str
    candidate: int
    antagonist: int
    error: float

    def __str__(self) -> str:
        return f"{self.law} between bodies {self.candidate} and {self.antagonist}, off by {self.error:.2e} m/s"


@dataclass(frozen=True)
class Report:
    """How the last step was solved.

    ``iterations``: sweeps; ``factorisations``: Newton steps; ``residual``: ``|e(r)| / |e(0)|``, the error relative to that
    of doing nothing; ``status``: "converged", "budget spent", "stagnated" or "not finite"; ``worst``: the worst
    interaction, None where there is none; ``interactions``: how many there were; ``seconds``: of the solver;
    ``step_seconds``: of the whole step.
    """

    iterations: int = 0
    factorisations: int = 0
    residual: float = 0.0
    status: str = "converged"
    worst: Worst | None = None
    interactions: int = 0
    seconds: float = 0.0
    step_seconds: float = 0.0

    def __str__(self) -> str:
        worst = f"; worst: {self.worst}" if self.worst else ""
        newton = f" and {self.factorisations} Newton steps" if self.factorisations else ""
        return (
            f"{self.status} after {self.iterations} sweeps{newton} at a residual of {self.residual:.2e} over "
            f"{self.interactions} interactions in {self.seconds:.4f} s{worst}"
        )

    def __repr__(self) -> str:
        return f"<Report: {self}>"
