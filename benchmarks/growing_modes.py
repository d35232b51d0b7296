"""Why sweeps and outer loops do not come to rest where friction jams: how they answer to a small error of a solution.

Steps of packs of rough spheres (``jammed``), small enough for Newton's method to solve them. At the solution, with

    a = r - u / w,    J = 1 - P (1 - W / w),    P = dr/da,

w the mean diagonal of a contact's block, and P by status: 0 where open, 1 where sticking, and where sliding along
``tau = a_t / |a_t|`` the derivative of ``(a_n, mu a_n tau)``. An error d of the impulses becomes ``G d`` by

* a sweep, ``G = -(L + D)^-1 U``, the parts of J below, on and above its blocks of contacts;
* a turn of the loop on thresholds: all contacts are solved with ``|r_t| <= g``, then ``g <- mu r_n`` (Haslinger 1983);
* a turn of the loop on dilations: all are solved with ``r`` in the cone and ``(u_n + mu s, u_t)`` in its dual, then
  ``s <- |u_t|`` (De Saxce, Feng 1998; Acary, Cadoux, Lemarechal, Malick 2011).

In the last two the contacts that slide have, beside ``r_n``, one unknown across ``tau``, of stiffness
``|u_t| / (mu r_n) = w (|a_t| / (mu a_n) - 1)``. An eigenvalue of G beyond 1 in size is an error that grows. Damping,
``1 - theta + theta G``, keeps at bay what has a real part below 1; what has not grows under every damping. For the fastest
of a sweep the growth is measured as well: the solution is disturbed along it, and swept.

python benchmarks/growing_modes.py [SPHERES [SAMPLES]]
"""

from __future__ import annotations

import sys

import numpy as np
from jammed import FRICTIONS, isotropic
from table import report

import lmgcpy as lm
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.rows import OPEN, SLIDE

SOLVED = 1e-8
"""Residual up to which a step counts as solved."""
BEYOND = 1e-5
"""What an eigenvalue must be beyond 1 to count: modes that a sweep does not change are 1 but for round-off."""
DISTURBED, TURNS, FAR = 1e-9, 1000, 100.0
"""Relative size of the disturbance, sweeps in which its growth is measured, and growth after which no more are made."""


class Solution:
    """A solved step, with the contacts that act as arrays."""

    def __init__(self, problem: lm.Problem, impulses: np.ndarray):
        active = ActiveSet(problem)
        _, status = active.error(impulses)
        self.problem, self.impulses = problem, impulses
        self.acting = np.flatnonzero(status.kind != OPEN)
        rows = (3 * self.acting[:, None] + np.arange(3)).ravel()
        self.W = problem.W.toarray()[np.ix_(rows, rows)]
        self.w, self.mu = active.weight[self.acting], problem.mu[self.acting]
        self.sliding = status.kind[self.acting] == SLIDE
        self.tau, self.turning = status.direction[self.acting], status.turning[self.acting, 0]

    def of_sweep(self) -> np.ndarray:
        """G of a sweep over the contacts that act."""
        count = len(self.acting)
        P = np.zeros((3 * count, 3 * count))
        for k in range(count):
            block = np.eye(3)
            if self.sliding[k]:
                tau = self.tau[k]
                block[1:, 0] = self.mu[k] * tau
                block[1:, 1:] = (np.eye(2) - np.outer(tau, tau)) / (1.0 + self.turning[k])
            P[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
        J = np.eye(3 * count) - P @ (np.eye(3 * count) - self.W / np.repeat(self.w, 3)[:, None])
        lower = J * np.kron(np.tril(np.ones((count, count))), np.ones((3, 3)))
        return np.eye(3 * count) - np.linalg.solve(lower, J)

    def of_loops(self) -> tuple[np.ndarray, np.ndarray]:
        """G of a turn of the loop on thresholds, and of the loop on dilations."""
        # columns: what is free in the impulses of each contact; of sliding ones normal and across
        columns, stiffness, normal_of = [], [], []
        for k in range(len(self.acting)):
            if self.sliding[k]:
                normal_of.append(len(columns))
                across = np.array([0.0, -self.tau[k, 1], self.tau[k, 0]])
                local = [np.array([1.0, 0.0, 0.0]), across]
                stiffness += [0.0, self.w[k] * self.turning[k]]
            else:
                local = list(np.eye(3))
                stiffness += [0.0] * 3
            for vector in local:
                column = np.zeros(3 * len(self.acting))
                column[3 * k : 3 * k + 3] = vector
                columns.append(column)
        C, normal = np.array(columns).T, np.array(normal_of, int)
        mu = self.mu[self.sliding]
        along = np.zeros((len(C), len(mu)))
        for j, k in enumerate(np.flatnonzero(self.sliding)):
            along[3 * k + 1 : 3 * k + 3, j] = self.tau[k]
        answer = solved(C.T @ self.W @ C + np.diag(stiffness), -C.T @ self.W @ along)
        thresholds = mu[:, None] * answer[normal]
        edge = C.copy()
        edge[:, normal] += mu * along
        push = np.zeros((C.shape[1], len(mu)))
        push[normal, np.arange(len(mu))] = -mu
        answer = solved(edge.T @ self.W @ edge + np.diag(stiffness), push)
        dilations = -along.T @ self.W @ edge @ answer
        return thresholds, dilations

    def growth(self, G: np.ndarray) -> float:
        """Factor a sweep by which disturbances along the fastest mode of ``G`` grow, measured.

        Of a pair of complex modes the real and the imaginary part are disturbances of their own: ``|G^k a|^2 + |G^k b|^2``
        grows by ``|lambda|^2`` a sweep, though each of them swings.
        """
        values, vectors = np.linalg.eig(G)
        mode = vectors[:, np.argmax(abs(values))]
        states = [self.impulses.copy() for _ in range(3)]  # the solution itself is swept as well, as it is not exact either
        scale = DISTURBED * np.linalg.norm(self.impulses)
        for state, part in zip(states[1:], (mode.real, mode.imag), strict=True):
            state[self.acting] += scale * part.reshape(-1, 3)
        sizes: list[float] = []
        while len(sizes) < TURNS and (not sizes or sizes[-1] < FAR * sizes[0]):
            sizes.append(float(np.hypot(*(np.linalg.norm(state - states[0]) for state in states[1:]))))
            states = [self.swept(state) for state in states]
        return float((sizes[-1] / sizes[0]) ** (1.0 / (len(sizes) - 1)))

    def swept(self, r: np.ndarray) -> np.ndarray:
        return lm.solve(self.problem, solver=lm.GaussSeidel(tolerance=1e-14, max_iterations=1), guess=r).impulses


def solved(K: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The least x of ``K x = right`` with K positive semidefinite, scaled to a diagonal of ones."""
    scale = 1.0 / np.sqrt(np.diag(K))
    return scale[:, None] * np.linalg.lstsq(scale[:, None] * K * scale, scale[:, None] * right, rcond=1e-11)[0]


def beyond(G: np.ndarray) -> tuple[int, int, float]:
    """How many eigenvalues are beyond 1 in size, how many in their real part, and the largest size."""
    values = np.linalg.eigvals(G)
    size = abs(values)
    return int((size > 1.0 + BEYOND).sum()), int((values.real > 1.0 + BEYOND).sum()), float(size.max(initial=0.0))


def main(spheres: int, samples: int) -> None:
    rows = []
    newton = lm.Newton(tolerance=1e-10, max_iterations=40_000)
    for friction in FRICTIONS:
        for seed in range(samples):
            problem = isotropic(spheres, friction, seed)
            found = lm.solve(problem, solver=newton)
            row = [spheres, friction, seed, f"{found.residual:.0e}"]
            if found.residual > SOLVED:
                rows.append([*row, *[""] * 8])
                continue
            solution = Solution(problem, found.impulses)
            G = solution.of_sweep()
            sweep = beyond(G)
            measured = f"{solution.growth(G):.5f}" if sweep[0] else ""
            row += [f"{solution.sliding.sum()} of {len(solution.acting)}", sweep[0], f"{sweep[2]:.5f}", measured]
            for loop in map(beyond, solution.of_loops()):
                row += [f"{loop[0]}, {loop[1]}", f"{loop[2]:.2f}"]
            rows.append(row)
            print(*row, file=sys.stderr, flush=True)
    header = ["spheres", "friction", "seed", "residual", "sliding contacts"]
    header += ["modes of a sweep that grow", "fastest, a sweep", "measured"]
    for loop in ("threshold", "dilation"):
        header += [f"modes of the loop on {loop} that grow, under every damping", f"fastest, a turn ({loop})"]
    report("growing_modes", header, rows)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(int(given[0]) if given else 150, int(given[1]) if len(given) > 1 else 4)
