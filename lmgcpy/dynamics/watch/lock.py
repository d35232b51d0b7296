"""A step that was not solved because it has no solution: which bodies are locked, and what drives them."""

from __future__ import annotations

import numpy as np

from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.dynamics.straight_spans import StraightSpans
from lmgcpy.solve.newton.alternating import newton_steps
from lmgcpy.solve.problems.locked import least_motion
from lmgcpy.solve.problems.report import Lock, Report

WORTH = 5
"""A lock is looked for if the solve has cost at least this number of Newton steps. The search costs as much as one. (Sweeps
that stagnate have cost 7 at least.)"""
MOST_IN_CELL = 10_000
"""A lock is not looked for in a periodic cell that deforms if there are more components of impulses: the matrix W of a
problem in such a cell is dense."""
CARRIES = 0.1
"""A body belongs to a lock if it bears more than this part of the greatest force of the self-stress."""


def find_lock(problem: StepProblem, report: Report, spans: StraightSpans) -> Lock | None:
    """The lock of a step that was not solved, or None if there is no lock or the solver gave up early. ``spans``: the
    straight spans of the model.

    The step is locked if any solution would move the bodies, in the mean weighted by mass, by more than the radius of one:
    in such a step the linearised constraints no longer hold. Laws without a conic form are not examined.
    """
    cost = report.factorisations + newton_steps(report.iterations, *problem.system.impulse.shape)
    if cost < WORTH or problem.law_without_conic is not None:
        return None
    if problem.system.deforms and problem.system.impulse.size > MOST_IN_CELL:
        return None
    try:
        conic, acting = problem.conic()
    except (ValueError, RuntimeError):  # numbers that no problem may have, a law that raises: the step itself is made
        return None
    if conic.scale is None or not (conic.scale > 0.0).any():
        return None
    with np.errstate(all="ignore"):
        told = least_motion(conic, problem.system.impulse[acting])
    if not told.norm > 0.0:
        return None
    of_body = problem.inverse_mass[:, : problem.dimension].max(axis=1)  # not those with which light bodies are swept
    mass = float((1.0 / of_body[of_body > 0.0]).sum())
    h_over_radius = float(np.median(conic.scale[conic.scale > 0.0]))
    motion = told.norm / np.sqrt(mass) * h_over_radius if mass > 0.0 else np.inf
    if not motion > 1.0:
        return None
    size = np.linalg.norm(told.stress, axis=1)
    carries = size > CARRIES * size.max()
    pairs = np.stack([problem.system.candidate[acting], problem.system.antagonist[acting]], axis=1)[carries]
    bodies = np.unique(pairs)
    imposed = (problem.system.inverse_mass[bodies] == 0.0) & (problem.free_velocity[bodies] != 0.0)
    driven = bodies[imposed.any(axis=1)]
    held = np.setdiff1d(bodies, driven)
    chain = None
    if not len(driven):
        bears = np.zeros(len(acting), dtype=bool)
        bears[acting] = carries
        chain = spans.bearing(bears, problem.system.normal)
    return Lock(tuple(map(int, driven)), tuple(map(int, held)), float(motion), chain)
