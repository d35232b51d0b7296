"""Chains on one line: tridiagonal problems with a solution in extended precision.

A chain of rigid wires hangs from a fixed point along the first axis. Its masses m_1 ... m_n lie below the point; the last
one is the tip. With n from the antagonist above to the candidate below, link i has

    W_ii = 1/m_{i-1} + 1/m_i,    W_{i,i+1} = -1/m_i,    1/m_0 = 0,    q_i = v_i - v_{i-1},

and ``0 <= -(W r + q) _|_ -r >= 0``. W is an M-matrix. So Newton's method on the set of taut links converges monotonically,
in at most as many steps as there are links (Chandrasekaran 1970, Opsearch 7); each step is a tridiagonal elimination. Here
it uses numpy's ``longdouble``, which has a mantissa of 64 bits on x86 and of more bits on some other processors. The code
is independent of the solvers that it judges.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sparse

from lmgcpy.bench.case import Case
from lmgcpy.laws.rigid import RigidWire
from lmgcpy.solve.problems.problem import Problem

BEADS = (10, 100, 1000, 10_000)
TIPS = (1.0, 1e3, 1e6)
"""Mass of the tip, in masses of a bead."""
BEAD_MASS, FALL = 1e-3, 9.81e-3
"""Mass of a bead [kg], and velocity that gravity adds to a free bead in a step of one millisecond [m/s]."""


def chain_problem(mass: np.ndarray, velocity: np.ndarray) -> Problem:
    """A chain of rigid wires below a fixed point, in 2D: ``mass`` [kg] and free ``velocity`` downwards [m/s], (n,) each."""
    count = len(mass)
    inverse = 1.0 / mass
    W_n = sparse.diags_array(
        [inverse + np.r_[0.0, inverse[:-1]], -inverse[:-1], -inverse[:-1]], offsets=[0, 1, -1], shape=(count, count)
    )
    # no bead turns, so that the tangential rows have the same masses
    W = sparse.csr_array(sparse.kron(W_n, sparse.eye_array(2)))
    q = np.zeros((count, 2))
    q[:, 0] = np.diff(velocity, prepend=0.0)
    laws = (RigidWire.NAME,) * count
    return Problem(W, q.ravel(), np.zeros(count), 2, laws, np.zeros(count), np.zeros((count, 2)))


def extended_solution(problem: Problem) -> np.ndarray:
    """Impulses (m, 2) of a chain of rigid wires, rounded from extended precision.

    Raises RuntimeError if the impulses do not satisfy the law; the check is in extended precision too.
    """
    W = problem.W.tocsr()
    count = len(problem.mu)
    row = 2 * np.arange(count)
    diagonal = np.asarray(W[row, row], dtype=np.longdouble)
    beside = np.asarray(W[row[:-1], row[1:]], dtype=np.longdouble)
    q = problem.q[::2].astype(np.longdouble)
    taut = q >= 0.0  # a hanging chain, in which only the first link has a free velocity, needs one step
    for _ in range(count + 2):
        r = _tridiagonal(np.where(taut, diagonal, 1), np.where(taut[:-1] & taut[1:], beside, 0), np.where(taut, -q, 0))
        u = diagonal * r + q
        u[:-1] += beside * r[1:]
        u[1:] += beside * r[:-1]
        small = 1e3 * np.finfo(np.longdouble).eps * np.abs(diagonal * r).max(initial=np.abs(q).max())  # round-off
        wrong = np.where(taut, diagonal * r > small, u > small)
        if not wrong.any():
            if (np.abs(u[taut]) > small).any():
                break
            return np.column_stack([r, np.zeros(count)]).astype(np.float64)
        taut = taut ^ wrong
    raise RuntimeError("The chain's solution in extended precision does not satisfy its law.")


def _tridiagonal(diagonal: np.ndarray, beside: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a symmetric tridiagonal system by elimination without pivoting."""
    d, x = diagonal.copy(), right.copy()
    for i in range(1, len(d)):
        factor = beside[i - 1] / d[i - 1]
        d[i] -= factor * beside[i - 1]
        x[i] -= factor * x[i - 1]
    x[-1] /= d[-1]
    for i in range(len(d) - 2, -1, -1):
        x[i] = (x[i] - beside[i] * x[i + 1]) / d[i]
    return x


def chains(beads: tuple[int, ...] = BEADS, tips: tuple[float, ...] = TIPS) -> Iterator[Case]:
    """Hanging chains with taut links, for every number of beads and every mass of the tip, and loose chains.

    The beads of a loose chain fly towards each other with random velocities, so that many links are slack.
    """
    for count in beads:
        for tip in tips:
            mass = np.full(count, BEAD_MASS)
            mass[-1] *= tip
            problem = chain_problem(mass, np.full(count, FALL))
            yield Case(f"hanging-{count}-tip-{tip:g}", "chains", problem, extended_solution(problem))
        rng = np.random.default_rng(count)
        problem = chain_problem(np.full(count, BEAD_MASS), np.cumsum(rng.normal(-0.5, 1.0, count)))
        yield Case(f"loose-{count}", "chains", problem, extended_solution(problem))
