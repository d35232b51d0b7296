"""How far impulses are from solving a problem, in three measures."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, numbers, one_of
from lmgcpy.solve.problems.problem import CONTACT, Problem, check_problem

MEASURES = ("natural", "fclib", "slip")


@named_arguments
def residual(problem: Problem, impulses: Any, *, measure: str = "natural") -> float:
    """How far impulses (m, D) are from solving a problem; D is its ``width``.

    "natural": ``|e(r)| / |e(0)|`` with ``e = w (r - react(w I, u - w r))``, ``w`` the mean diagonal of the local block: the
    error of the velocities relative to the error of doing nothing. "fclib": ``|w0 r - P_K(w0 r - (u + mu |u_t| n))| / |q|``
    with ``w0`` the mean diagonal of W, the measure of published solvers; links have their own law's projection, rolling
    contacts have none (ValueError). Both are infinite if they overflow. "slip": the largest ``h |e_i| / R_i``, R_i the
    radius of the smaller body. Problems of ``Simulation.problem`` know the radii (ValueError if a problem does not).
    """
    check_problem(problem, "residual")
    one_of(measure, "measure", MEASURES)
    r = numbers(impulses, "impulses")
    if r.shape != problem.guess.shape:
        raise ValueError(f"impulses must have shape {problem.guess.shape}, got {r.shape}.")
    if measure == "slip":
        if problem.scale is None:
            raise ValueError(
                "This problem knows no sizes of bodies, as those from FCLIB files do not, so that measure='slip' has no "
                "meaning: say 'natural' or 'fclib', or take the problem from Simulation.problem()."
            )
        return float((problem.scale * np.linalg.norm(problem.errors(r), axis=1)).max(initial=0.0))
    if measure == "fclib" and problem.width > problem.dimension:
        raise ValueError(
            "measure='fclib' is that of contacts with friction alone, and this problem has rolling components: say "
            "'natural' or 'slip'."
        )
    with np.errstate(over="ignore", invalid="ignore"):
        if measure == "fclib":
            error, scale = _fclib_error(problem, r), float(np.linalg.norm(problem.q))
        else:
            error, scale = _natural_error(problem, r), _natural_error(problem, np.zeros_like(r))
    if scale == 0.0:
        return 0.0 if error == 0.0 else np.inf
    return error / scale if np.isfinite(error) else np.inf


def _natural_error(problem: Problem, r: np.ndarray) -> float:
    return float(np.linalg.norm(problem.errors(r)))


def _fclib_error(problem: Problem, r: np.ndarray) -> float:
    u = problem.velocities(r)
    w0 = float(problem.W.diagonal().mean()) if len(problem.mu) else 1.0
    cones = problem.cones
    weight = np.full(len(problem.mu), w0)
    projected = w0 * problem.react(u - w0 * r, weight)
    contact = cones == CONTACT
    shifted = u[contact]
    shifted[:, 0] += problem.mu[contact] * np.linalg.norm(u[contact, 1:], axis=1)
    projected[contact] = project_on_cone(w0 * r[contact] - shifted, problem.mu[contact])
    return float(np.linalg.norm(w0 * r - projected))


def project_on_cone(x: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Euclidean projection of rows (n, t...) on the cone ``|t| <= mu n``, (m, d)."""
    n, t = x[:, 0], x[:, 1:]
    size = np.linalg.norm(t, axis=1)
    inside = (size <= mu * n) & (n >= 0.0)  # without friction 0 <= 0 n holds below the cone as well
    polar = mu * size <= -n
    on_edge = (n + mu * size) / (1.0 + mu**2)
    edge = np.column_stack([on_edge, t * (mu * on_edge / np.where(size > 0.0, size, 1.0))[:, None]])
    return np.where(inside[:, None], x, np.where(polar[:, None], 0.0, edge))
