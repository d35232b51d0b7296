"""How a step was solved: statuses, the outcome of a solver, and the report of a step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from lmgcpy.writing import html_of_fields

CONVERGED, SPENT, STAGNATED, NOT_FINITE, ROUND_OFF, LOCKED = range(6)
STATUS = ("converged", "budget spent", "stagnated", "not finite", "round-off", "locked")
"""Words for how a solve ended; run files keep their places here, so that new ones come last."""
SOLVED_CODES = (CONVERGED, ROUND_OFF)
SOLVED = tuple(STATUS[code] for code in SOLVED_CODES)
"""Statuses of a problem that is solved: to the tolerance, or to round-off where the tolerance lies below it."""


class Outcome(NamedTuple):
    """How a solve ended."""

    iterations: int
    """Sweeps, or the iterations that a solver has in their stead."""
    residual: float
    """``|e(r)| / |e(0)|``."""
    status: int
    """Index into :data:`STATUS`."""
    factorisations: int = 0
    """Newton steps, each of which factorised a sparse matrix."""
    slip: float = 0.0
    """Largest ``h |e_i| / R_i``; 0 if no sizes are known."""
    force: float = 0.0
    """Largest ``|e_i| / W_nn`` over the load of the two bodies of an interaction, see ``lmgcpy.solve.kernels.loads``; for
    light bodies between heavy ones also the imbalance."""

    def __repr__(self) -> str:
        newton = f" and {self.factorisations} Newton steps" if self.factorisations else ""
        return f"<Outcome: {STATUS[self.status]} after {self.iterations} sweeps{newton}, residual {self.residual:.2g}>"


@dataclass(frozen=True)
class Worst:
    """The interaction whose error makes the largest displacement for its size: its law, the ids of ``candidate`` and
    ``antagonist``, the ``error`` [m/s]."""

    law: str
    candidate: int
    antagonist: int
    error: float

    def __str__(self) -> str:
        return f"{self.law} between bodies {self.candidate} and {self.antagonist}, off by {self.error:.2e} m/s"


@dataclass(frozen=True)
class Lock:
    """Why a step has no solution: impulses in balance on every free body, on which the imposed velocities do work.

    See ``lmgcpy.solve.problems.locked``.
    """

    driven: tuple[int, ...]
    """Ids of the bodies with an imposed velocity that is not zero."""
    held: tuple[int, ...]
    """Ids of the other bodies that these impulses press or pull."""
    motion: float
    """Least motion of any solution in the step: the mean displacement weighted by mass, in median radii."""
    chain: tuple[int, int] | None = None
    """Ids of the two held bodies between which a straight piece of a chain bears these impulses, if it does and no body is
    driven: it has no finite tension."""

    def __str__(self) -> str:
        held = _listed(self.held, "body", "bodies")
        if self.chain is not None:
            first, last = self.chain
            return (
                f"no finite tension: the chain from body {first} to body {last} is straight between held bodies; "
                "give it slack or an elastic law"
            )
        if not self.driven:
            return f"no finite impulses satisfy the constraints on {held}; links need some slack there, or an elastic law"
        driven = _listed(self.driven, "body", "bodies")
        return f"no motion of {driven} is compatible with the constraints on {held}"

    def __repr__(self) -> str:
        return f"<Lock: {self}>"


def _listed(ids: tuple[int, ...], one: str, many: str, most: int = 12) -> str:
    words = ", ".join(map(str, ids[:most])) + (f" and {len(ids) - most} more" if len(ids) > most else "")
    return f"{one if len(ids) == 1 else many} {words}"


@dataclass(frozen=True)
class Report:
    """How the last step was solved.

    ``iterations``: sweeps; ``factorisations``: Newton steps; ``residual``: ``|e(r)| / |e(0)|``, the error relative to the
    error of doing nothing; ``slip``: the largest ``h |e_i| / R_i``, the displacement that the error of one interaction
    makes in the step, in parts of its smaller body's radius; ``force``: the largest error of a force over the load of its
    bodies, and imbalance of a light body; ``status``: "converged", "budget spent", "stagnated", "not finite", "round-off",
    or "locked" for a step that has no solution; ``lock``: why it has none, None otherwise; ``worst``: the interaction of
    that slip, None if there is none; ``interactions``: how many there were; ``seconds``: of the solver; ``step_seconds``:
    of the whole step; ``stretch``: the largest part of its reference length by which a rigid link was off when the step
    began, a wire too long, a rod either way; ``solves``: how often the step was solved, until the geometric stiffness of
    its links fitted their impulses, and once more if links are pulled back by positions alone; ``iterations`` and
    ``factorisations`` count all solves together.
    """

    iterations: int = 0
    factorisations: int = 0
    residual: float = 0.0
    status: str = "converged"
    worst: Worst | None = None
    interactions: int = 0
    seconds: float = 0.0
    step_seconds: float = 0.0
    stretch: float = 0.0
    solves: int = 1
    slip: float = 0.0
    lock: Lock | None = None
    force: float = 0.0

    @property
    def solved(self) -> bool:
        """Whether the step was solved, to the tolerance or to round-off."""
        return self.status in SOLVED

    def of_step(self, stretch: float, seconds: float) -> Report:
        """The report with the numbers known at the end of its step."""
        made = object.__new__(Report)  # in a fifth of the time of dataclasses.replace
        made.__dict__.update(self.__dict__, stretch=stretch, step_seconds=seconds)
        return made

    def following(self, earlier: Report) -> Report:
        """The report of a step after one more solve: the sums of both, and the status of the one that was not solved."""
        return (self if earlier.solved else earlier).with_work(earlier, self)

    def with_work(self, *solves: Report) -> Report:
        """This report with the sums of the work of these solves."""
        names = "iterations", "factorisations", "seconds", "solves"
        return replace(self, **{name: sum(getattr(solve, name) for solve in solves) for name in names})

    def __str__(self) -> str:
        worst = f"; worst: {self.worst}" if self.worst else ""
        locked = f": {self.lock}," if self.lock else ""
        newton = f" and {self.factorisations} Newton steps" if self.factorisations else ""
        return (
            f"{self.status}{locked} after {self.iterations} sweeps{newton} at a residual of {self.residual:.2e} and a "
            f"slip of {self.slip:.2e} over {self.interactions} interactions in {self.seconds:.4f} s{worst}"
        )

    def __repr__(self) -> str:
        return f"<Report: {self}>"

    def _repr_html_(self) -> str:
        return html_of_fields(self)
