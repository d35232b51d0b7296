"""Locked or not yet solved: the certificate of a step for which there is no solution.

For rigid bodies between a moving and a fixed platen there may be no velocities that satisfy all constraints. Then
impulses grow from sweep to sweep along a self-stress: impulses in their cones that leave no body a resultant,
``W rho = 0``, and on which the imposed velocities do positive work. Such a rho proves that there is no solution:

Let s_i be the sliding velocities |u_t| at the contacts. A solution ``u = W x + q`` has ``u + mu s n`` in the dual cone of
every contact (de Saxce and Feng 1998), so that any rho in the cones obeys ``rho . u + sum mu rho_n s >= 0``, and

    rho . W x >= P(rho) = -rho . q - sum mu rho_n s,

the work of the imposed velocities on rho less the dissipation by slip. With the inequality of Cauchy and Schwarz,

    |x|_W >= P(rho) / |rho|_W,    |x|_W = sqrt(x . W x),

and |x|_W is the kinetic norm ``sqrt(sum m (v - v_free)^2)`` of the change of velocities that impulses x make. So if rho is
a self-stress with P > 0, no change of velocities, however large, is enough. If rho is nearly a self-stress, the bound is
the least change. If a step is solved, the bound equals the change. The statement holds for the convex problem with the
sliding velocities s (Acary, Cadoux, Lemarechal, Malick 2011), which are taken from the last impulses.

A row that yields, by an elastic law or by geometric stiffness, never locks, and energy that it stores is no motion. So
rho is zero in such rows: what is left of W is the one of the rigid rows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lmgcpy.solve.problems.problem import CONTACT, PULL, Problem

WEIGHT = 1e8
"""Weight of the velocities against the impulses, over the mean diagonal of W: in every turn the part of the impulses that
moves bodies of that weight falls by this factor."""
TURNS = 20
"""A column by itself is found to round-off in two."""

LEAST_WORK = 1e-6
"""Work below this part of the sum of its absolute terms may be the round-off of zero."""
ROUNDING = 1e-13
"""Round-off of velocities, in parts of the velocities that single impulses make."""


class LeastMotion(NamedTuple):
    """Lower bound of the change of velocities in any solution, and the impulses that prove it."""

    norm: float
    """In the kinetic norm [sqrt(kg) m/s]; for a self-stress as large as rounding lets it be."""
    stress: np.ndarray
    """The impulses that prove it [N s], (m, d)."""


def least_motion(problem: Problem, impulses: np.ndarray) -> LeastMotion:
    """Least motion of a step that was not solved, from the impulses r (m, d) at which its solver ended.

    With ``q_s = q + mu s n`` the step is the convex problem of the least ``1/2 rho . W rho + q_s . rho`` in the cones. One
    large implicit step of its gradient, ``(I + t W)^-1 (r - t q_s)``, moves far along -q_s in the directions of
    self-stresses, and hardly in directions that move bodies. The result is projected on the cones; this step, which damps
    the part that moves bodies, and the projection alternate.
    """
    import scipy.sparse as sparse
    from scipy.sparse.linalg import splu

    impulses = np.asarray(impulses, dtype=float)
    velocities = problem.velocities(impulses)
    convex = problem.q.reshape(impulses.shape).copy()
    for part, share in problem.disks:
        sliding = np.linalg.norm(velocities[:, part], axis=1)
        convex[:, 0] += np.where(problem.cones == CONTACT, share * sliding, 0.0)
    there = _rigid(problem)  # the others bear nothing, not even on the way
    if not there.any():
        return LeastMotion(0.0, np.zeros_like(impulses))
    bodies = problem.W if problem.split is None else problem.split.sparse
    cell = np.zeros((len(there), 0)) if problem.split is None else problem.split.columns
    operator, cell = sparse.csc_array(bodies)[there][:, there], cell[there]
    diagonal = operator.diagonal() + (cell**2).sum(axis=1)
    weight = WEIGHT / float(diagonal[diagonal > 0.0].mean()) if (diagonal > 0.0).any() else WEIGHT
    # (I + t W)^-1 of W = bodies + cell cell^T by the formula of Woodbury: the part of a cell that yields is dense
    damped = splu(sparse.csc_array(sparse.eye_array(len(diagonal)) + weight * operator))
    of_cell = damped.solve(cell)
    small = np.eye(cell.shape[1]) / weight + cell.T @ of_cell

    def step(b: np.ndarray) -> np.ndarray:
        moved = damped.solve(b)
        return moved - of_cell @ np.linalg.solve(small, cell.T @ moved)

    stress, best = impulses - weight * convex, LeastMotion(0.0, impulses)
    for _ in range(TURNS):
        steered = np.zeros_like(impulses)
        steered.ravel()[there] = step(stress.ravel()[there])
        stress = within_cones(problem, steered)
        acting = stress.ravel()[there]
        work, most_work = -float((stress * convex).sum()), float(np.abs(stress * convex).sum())
        of_edges = cell.T @ acting
        moved = float(acting @ (operator @ acting) + of_edges @ of_edges)
        most_moved = float(diagonal @ acting**2)
        if work > LEAST_WORK * most_work:
            moved = max(moved, ROUNDING**2 * most_moved)
            norm = work / math.sqrt(moved) if moved > 0.0 else math.inf
            best = max(best, LeastMotion(norm, stress), key=lambda told: told.norm)
    return best


def _rigid(problem: Problem) -> np.ndarray:
    """Whether a component has a law that does not yield, (D m,) bool."""
    rigid = problem.rows.copy()
    rigid[problem.compliance > 0.0, 0] = False
    rigid[problem.geometric > 0.0, 1 : problem.dimension] = False
    return rigid.ravel()


def within_cones(problem: Problem, impulses: np.ndarray) -> np.ndarray:
    """Projection of impulses (m, D) on the cones.

    The cone of a contact is ``|r_j| <= c_j r_n`` for friction and, if there are any, rolling and torsion. The normal part
    n of the projection solves ``n = r_n + sum c_j max(|r_j| - c_j n, 0)``, by Newton steps from ``n = r_n``, which rise
    from one bend of this concave, piecewise linear equation to the next; 0 if n is negative. The other parts are cut to
    ``c_j n``.
    """
    near = np.where(problem.rows, impulses, 0.0)
    pull, contact = problem.cones == PULL, problem.cones == CONTACT
    near[pull, 0] = np.minimum(near[pull, 0], 0.0)
    given = near[contact]
    sizes = np.stack([np.linalg.norm(given[:, part], axis=1) for part, _ in problem.disks], axis=1)
    shares = np.stack([share[contact] for _, share in problem.disks], axis=1)
    normal = given[:, 0]
    for _ in range(len(problem.disks) + 1):
        beyond = sizes > shares * normal[:, None]
        square = (shares**2 * beyond).sum(axis=1)
        normal = (given[:, 0] + (shares * sizes * beyond).sum(axis=1)) / (1.0 + square)
    normal = np.maximum(normal, 0.0)
    for (part, _), size, limit in zip(problem.disks, sizes.T, (shares * normal[:, None]).T, strict=True):
        given[:, part] *= np.divide(limit, size, out=np.ones_like(size), where=size > limit)[:, None]
    given[:, 0] = normal
    near[contact] = given
    return near
