"""The semi-smooth Newton step of a proximal problem: which interactions act, and one sparse system for their impulses.

A proximal problem has the velocities ``u + epsilon w (r - centre)`` in place of ``u = W r + q``: a small dashpot beside
every interaction, ``w`` the mean diagonal of its block of W, so that there is one solution where impulses are not unique.
Its natural map asks every law where it stands at ``a = r - u / w`` (Alart, Curnier 1991, with the scaling of DESIGN's
error):

* open, ``a_n <= 0``:                            r = 0
* sticks, ``|a_t| <= mu a_n``:                   u = 0
* slides along ``tau = a_t / |a_t|``:            u_n = 0, r_tau = mu r_n, and across, in 3D with sigma normal to tau,
                                                 u_sigma = -w (|a_t| / (mu a_n) - 1) r_sigma
* a taut wire or a rod of compliance C:          u_n + C r_n = 0

The last line of sliding is what the derivative of ``mu a_n a_t / |a_t|`` leaves across the direction of sliding: the
direction turns with r_sigma. Every line either ties impulses to each other or velocities to impulses. With ``E`` the
impulses by those that are free in them, and ``S`` the rows in which a velocity is given, a Newton step is

    S (W + epsilon w) E x + D x = S (-q + epsilon w centre),    r = E x,

with D from compliance and turning. It depends on the present impulses by the statuses and directions alone, so that where
these do not change any more, in 2D, a step is exact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lmgcpy.solve.problem import BOTH, CONTACT, PULL, Problem

if TYPE_CHECKING:
    import scipy.sparse as sparse

OPEN, STICK, SLIDE, LINK = range(4)
PIVOT = 1e-3
"""A diagonal pivot is taken where it is at least so much of the largest entry of its column: the matrix is nearly that of
a symmetric positive definite one, and fill grows with other choices."""

LARGE = 1e12
"""Impulses beyond so many times what would cancel ``e(0)`` leave less than four digits of a velocity."""


class Status(NamedTuple):
    """Where every interaction stands."""

    kind: np.ndarray
    """OPEN, STICK, SLIDE or LINK, (m,)."""
    direction: np.ndarray
    """tau of those that slide, (m, d - 1), zero elsewhere."""
    turning: np.ndarray
    """``|a_t| / (mu a_n) - 1`` of those that slide, (m,), zero elsewhere."""

    def changes(self, other: Status) -> int:
        """How many interactions differ in kind, or slide the other way."""
        reversed_ = np.einsum("it,it->i", self.direction, other.direction) < 0.0
        return int(np.count_nonzero((self.kind != other.kind) | reversed_))


class ActiveSet:
    """A problem with what its Newton steps need."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.dimension = problem.dimension
        self.q = problem.q.reshape(-1, self.dimension)
        self.mu = problem.mu
        cones = problem.cones
        self.contact, self.pull, self.both = cones == CONTACT, cones == PULL, cones == BOTH
        self.rough = self.contact & (problem.mu > 0.0)
        self.weight = problem.local_weight()
        self.nothing = float(np.linalg.norm(self.error(np.zeros_like(self.q))[0]))

    def velocities(self, r: np.ndarray, epsilon: float = 0.0, centre: np.ndarray | None = None) -> np.ndarray:
        """``W r + q + epsilon w (r - centre)``, (m, d)."""
        u = (self.problem.W @ r.ravel()).reshape(r.shape) + self.q
        return u if centre is None else u + epsilon * self.weight[:, None] * (r - centre)

    def error(self, r: np.ndarray, epsilon: float = 0.0, centre: np.ndarray | None = None) -> tuple[np.ndarray, Status]:
        """``e = w (r - react(w I, u - w r))`` [m/s], (m, d), of the problem or the proximal one, and the statuses."""
        w = self.weight
        a = r - self.velocities(r, epsilon, centre) / w[:, None]
        a_n = a[:, 0]
        taut = self.both | (self.pull & (a_n < 0.0))
        pressed = self.contact & (a_n > 0.0)
        reaction = np.zeros_like(a)
        reaction[pressed, 0] = a_n[pressed]
        reaction[taut, 0] = (w * a_n)[taut] / (w + self.problem.compliance)[taut]
        kind = np.where(pressed, STICK, np.where(taut, LINK, OPEN))
        limit = np.where(pressed, self.mu * a_n, 0.0)
        size = np.sqrt(np.einsum("it,it->i", a[:, 1:], a[:, 1:]))
        slides = pressed & self.rough & (size > limit)
        direction = np.zeros_like(a[:, 1:])
        direction[slides] = a[slides, 1:] / size[slides, None]
        turning = np.zeros(len(w))
        turning[slides] = size[slides] / limit[slides] - 1.0
        kind[slides] = SLIDE
        inside = self.rough & pressed & ~slides
        reaction[inside, 1:] = a[inside, 1:]
        reaction[slides, 1:] = limit[slides, None] * direction[slides]
        return w[:, None] * (r - reaction), Status(kind, direction, turning)

    def residual(self, r: np.ndarray) -> float:
        """``|e(r)| / |e(0)|``, zero where ``e(0)`` is."""
        return float(np.linalg.norm(self.error(r)[0])) / self.nothing if self.nothing > 0.0 else 0.0

    def lost(self, r: np.ndarray) -> bool:
        """Whether impulses are so large that velocities of the size of ``e(0)`` are lost to round-off beside ``w r``: on
        the way to infinity, as in a problem that has no solution."""
        return float(np.abs(self.weight[:, None] * r).max(initial=0.0)) > LARGE * self.nothing

    def newton(self, status: Status, epsilon: float, centre: np.ndarray) -> np.ndarray:
        """The impulses that satisfy the proximal problem with these statuses, (m, d).

        Raises RuntimeError where the matrix is singular to round-off.
        """
        from scipy.sparse.linalg import splu

        S, E, D = self._maps(status)
        damping = np.repeat(epsilon * self.weight, self.dimension)
        matrix = self._matrix(S, E, D, damping)
        lu = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=PIVOT, options={"SymmetricMode": True})
        x = lu.solve(S @ (damping * centre.ravel() - self.problem.q))
        if not np.isfinite(x).all():
            raise RuntimeError("not finite")
        return (E @ x).reshape(self.q.shape)

    def _matrix(self, S: sparse.csr_array, E: sparse.csr_array, D: np.ndarray, damping: np.ndarray) -> sparse.csc_array:
        import scipy.sparse as sparse

        operator = self.problem.W + sparse.diags_array(damping, format="csr")
        return sparse.csc_array((S @ operator) @ E + sparse.diags_array(D))

    def _maps(self, status: Status) -> tuple[sparse.csr_array, sparse.csr_array, np.ndarray]:
        """(S, E, D): given velocities by rows, impulses by free ones, and the diagonal beside W."""
        import scipy.sparse as sparse

        d, kind = self.dimension, status.kind
        free = np.zeros(self.q.shape, dtype=bool)
        free[:, 0] = kind != OPEN
        free[:, 1:] = ((kind == STICK) & self.rough)[:, None]
        slides = np.flatnonzero(kind == SLIDE)
        if d == 3:
            free[slides, 2] = True  # the place of sigma
        place = np.full(free.size, -1)
        rows = np.flatnonzero(free)
        place[rows] = np.arange(len(rows))
        straight = rows if d == 2 else np.setdiff1d(rows, 3 * slides + 2, assume_unique=True)
        one = np.ones(len(straight))
        normal = place[d * slides]
        tau = status.direction[slides] * self.mu[slides, None]
        s_rows, s_columns, s_values = [place[straight]], [straight], [one]
        e_rows, e_columns, e_values = [straight], [place[straight]], [one]
        for k in range(d - 1):
            e_rows.append(d * slides + 1 + k)
            e_columns.append(normal)
            e_values.append(tau[:, k])
        D = np.zeros(len(rows))
        D[place[d * np.flatnonzero(kind == LINK)]] = self.problem.compliance[kind == LINK]
        if d == 3:
            across = place[3 * slides + 2]
            D[across] = self.weight[slides] * status.turning[slides]
            for k, component in ((1, -status.direction[slides, 1]), (2, status.direction[slides, 0])):
                s_rows.append(across)
                s_columns.append(3 * slides + k)
                e_rows.append(3 * slides + k)
                e_columns.append(across)
                s_values.append(component)
                e_values.append(component)
        shape = len(rows), free.size
        S = sparse.csr_array((np.concatenate(s_values), (np.concatenate(s_rows), np.concatenate(s_columns))), shape=shape)
        E = sparse.csr_array(
            (np.concatenate(e_values), (np.concatenate(e_rows), np.concatenate(e_columns))), shape=shape[::-1]
        )
        return S, E, D
