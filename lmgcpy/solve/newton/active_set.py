"""The semi-smooth Newton step of a proximal problem: the interactions that act, and one sparse system for their impulses.

A proximal problem has the velocities ``u + epsilon w (r - centre)`` in place of ``u = W r + q``: a small dashpot beside
every interaction, ``w`` the mean diagonal of its block of W, so that the solution is unique even if impulses are not.
Its natural map gives the status of every law at ``a = r - u / w`` (Alart, Curnier 1991, with the scaling of DESIGN's
error):

* open, ``a_n <= 0``:                            r = 0
* sticks, ``|a_t| <= mu a_n``:                   u = 0
* slides along ``tau = a_t / |a_t|``:            u_n = 0, r_tau = mu r_n, and across, in 3D with sigma normal to tau,
                                                 u_sigma = -w (|a_t| / (mu a_n) - 1) r_sigma
* a taut wire or a rod of compliance C:          u_n + C r_n = 0
* across a link of geometric stiffness kappa:    u_t + r_t / kappa = 0, taut or slack

A contact that rolls has the lines of sticking and sliding for each of its disks. The last line of sliding is the derivative
of ``mu a_n a_t / |a_t|`` across the direction of sliding: the direction turns with r_sigma. Every line either ties impulses
to each other or velocities to impulses. With ``r = E x``, x the free impulses, and ``S`` the rows in which a velocity is
given, a Newton step is

    S (W + epsilon w) E x + D x = S (-q + epsilon w centre),    r = E x,

with D from compliance and turning. It depends on the present impulses only by the statuses, directions and ``|a_t| / (mu
a_n)``. So in 2D a step is exact if the statuses do not change any more.

**The order in which the unknowns are eliminated.** In 2D the search for an order that keeps the factors sparse takes as
long as the factorisation (8.7 ms against 4.6 ms with the order given, 4400 unknowns; 95 ms against 80 ms with 9900
unknowns in 3D). From one Newton step to the next few interactions come or go, and the order found for the others is still
good. So the order of the interactions is kept as long as the factors stay about as sparse as when it was found.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.solve.newton.path_kernels import next_bend, pass_bend
from lmgcpy.solve.newton.path_kernels_3d import impulses_of, next_wall, pass_wall
from lmgcpy.solve.newton.rows import LINK, impulses_by, local_maps, natural_map, newton_rows, parity, velocities_given
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.sweeps.step import Step

PIVOT = 1e-3
"""A diagonal pivot is taken if it is at least this share of the largest entry of its column: the matrix is nearly symmetric
positive definite, and fill grows with other choices."""
NEW = 0.02
"""A new order is found if more than this share of the interactions are not in the old one; fewer are eliminated last."""
FILL = 1.1
"""A new order is also found if the number of entries of the factors has grown by this factor."""


class Elimination:
    """Finds and keeps the order of ``count`` interactions."""

    def __init__(self, count: int):
        self._count = count
        self._rank: np.ndarray | None = None
        self._fill = 0.0

    def order(self, acting: np.ndarray) -> tuple[np.ndarray, bool]:
        """(the rows ``acting`` of interactions in the order kept, True); (``acting``, False) if a new order is needed."""
        if self._rank is None:
            return acting, False
        rank = self._rank[acting]
        if np.count_nonzero(rank == self._count) > NEW * len(acting):
            return acting, False
        return acting[np.argsort(rank, kind="stable")], True

    def factorise(self, matrix: Any, order: np.ndarray, unknown: np.ndarray, known: bool) -> Any:
        """Factors of a matrix with the unknowns of the interactions in ``order``; ``unknown``: the first one of each.

        Raises RuntimeError if the matrix is singular to round-off.
        """
        from scipy.sparse.linalg import splu

        method = "NATURAL" if known else "MMD_AT_PLUS_A"
        lu = splu(matrix, permc_spec=method, diag_pivot_thresh=PIVOT, options={"SymmetricMode": True})
        if not known:
            self._rank = np.full(self._count, self._count)
            self._rank[order[np.argsort(lu.perm_c[unknown[order]])]] = np.arange(len(order))
            self._fill = lu.nnz / matrix.nnz
        elif lu.nnz > FILL * self._fill * matrix.nnz:
            self._rank = None
        return lu


LARGE = 1e12
"""Impulses beyond this multiple of an impulse that cancels ``e(0)`` leave less than four digits of a velocity."""


class Status(NamedTuple):
    """Statuses of all interactions."""

    kind: np.ndarray
    """OPEN, LINK, or STICK with a bit for each disk that slides, (m,)."""
    direction: np.ndarray
    """tau of the disks that slide, (m, D - 1), zero elsewhere."""
    turning: np.ndarray
    """``|a| / (c a_n) - 1`` of the disks that slide, (m, disks), zero elsewhere."""

    def changes(self, other: Status) -> int:
        """Number of interactions that differ in kind or slide in the opposite direction."""
        (disks, columns), product = (self.turning.shape[1], self.direction.shape[1]), self.direction * other.direction
        first = np.arange(disks) * -(-columns // disks)  # of each disk; only the last may have a column less
        reversed_ = (np.add.reduceat(product, first, axis=1) < 0.0).any(axis=1)
        return int(np.count_nonzero((self.kind != other.kind) | reversed_))


class ActiveSet:
    """A problem, and the arrays that its Newton steps use again and again."""

    def __init__(self, problem: Problem):
        self.problem = problem
        self.dimension, self.width = problem.dimension, problem.width
        self.q: np.ndarray = problem.q.reshape(-1, self.width)
        self.weight = problem.local_weight()
        self.geometric = np.array(problem.geometric)
        shares = np.stack([share for _, share in problem.disks], axis=1)
        self.laws: tuple[np.ndarray, ...] = self.weight, shares, np.array(problem.compliance), self.geometric, problem.cones
        count, d = self.q.shape
        split = problem.split
        self._cell = None if split is None else split.columns.reshape(count, d, -1)
        blocks = (problem.W if split is None else split.sparse).tobsr(blocksize=(d, d))
        self._blocks = blocks.indptr.astype(np.int32), blocks.indices.astype(np.int32), blocks.data
        capacity = blocks.data.size + self.q.size
        self._rows = np.zeros(self.q.size + 1, np.int32), np.zeros(capacity, np.int32), np.zeros(capacity)
        self._elimination = Elimination(count)
        self._maps = np.zeros(count, np.int64), np.zeros((count, d, d)), np.zeros((count, d, d))
        self._across = np.zeros((count, d - 1))
        self.nothing = float(np.linalg.norm(self.error(np.zeros_like(self.q))[0]))

    def resist(self, step: Step, acting: np.ndarray, r: np.ndarray) -> bool:
        """Take the friction and the slips that the laws of a step resist at the impulses r (m, d); whether they change."""
        if not step.resists:
            return False
        (w, shares, *rest), slip = self.laws, np.zeros((len(r), self.dimension - 1))
        a = r - (self.problem.times(r.ravel()) + self.problem.q).reshape(r.shape) / w[:, None]
        shares = shares.copy()
        step.resist(acting, a, w, shares[:, 0], slip)
        q = self.problem.q.reshape(r.shape).copy()
        q[:, 1 : self.dimension] += slip
        if np.array_equal(q, self.q) and np.array_equal(shares, self.laws[1]):
            return False
        self.q, self.laws = q, (w, shares, *rest)
        self.nothing = float(np.linalg.norm(self.error(np.zeros_like(self.q))[0]))
        return True

    @cached_property
    def columns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The transpose of W by block rows: first, column, block."""
        blocks = self.problem.W.T.tobsr(blocksize=(self.width, self.width))
        return blocks.indptr.astype(np.int32), blocks.indices.astype(np.int32), blocks.data

    def velocities(self, r: np.ndarray, epsilon: float = 0.0, centre: np.ndarray | None = None) -> np.ndarray:
        """``W r + q + epsilon w (r - centre)``, (m, d)."""
        u = self.problem.times(r.ravel()).reshape(r.shape) + self.q
        return u if centre is None else u + epsilon * self.weight[:, None] * (r - centre)

    def error(self, r: np.ndarray, epsilon: float = 0.0, centre: np.ndarray | None = None) -> tuple[np.ndarray, Status]:
        """``e = w (r - react(w I, u - w r))`` [m/s], (m, d), of the problem or the proximal problem, and the statuses."""
        return self.natural(self.velocities(r, epsilon, centre), r)

    def natural(self, u: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, Status]:
        """The error of velocities and impulses, both (m, d), and the statuses."""
        status = Status(np.zeros(len(r), np.int64), np.zeros_like(r[:, 1:]), np.zeros_like(self.laws[1]))
        error = np.zeros_like(r)
        natural_map(u, r, *self.laws, self.dimension, error, *status)
        return error, status

    def residual(self, r: np.ndarray) -> float:
        """``|e(r)| / |e(0)|``; zero if ``e(0)`` is zero, and no number if it is none."""
        return 0.0 if self.nothing == 0.0 else float(np.linalg.norm(self.error(r)[0])) / self.nothing

    def lost(self, r: np.ndarray) -> bool:
        """Whether impulses are so large that velocities of the size of ``e(0)`` are lost to round-off beside ``w r``: on
        the way to infinity, as in a problem that has no solution."""
        return float(np.abs(self.weight[:, None] * r).max(initial=0.0)) > LARGE * self.nothing

    def factors(self, status: Status, epsilon: float) -> Factors:
        """The matrix of these statuses, factorised.

        If W has a part ``C C^T`` of low rank, the matrix stays sparse with the further unknowns ``y = C^T E x``,

            [ S (W_sparse + epsilon w) E + D    S C ]
            [ C^T E                             -1  ].

        Raises RuntimeError if the matrix is singular to round-off.
        """
        import scipy.sparse as sparse

        free, E, S = self._maps
        local_maps(*status, self.laws[1], self.geometric, self.dimension, *self._maps, self._across)
        order, known = self._elimination.order(np.flatnonzero(free))
        if not len(order):
            return Factors(None, order, E[order], S[order], free[order], 0)
        unknown = np.zeros_like(free)
        unknown[order] = np.cumsum(free[order]) - free[order]
        diagonal = np.repeat(epsilon * self.weight[:, None], self.width, axis=1)  # S E is the identity
        diagonal[:, 0] += np.where(status.kind == LINK, self.problem.compliance, 0.0)
        diagonal[:, 1:] += self.weight[:, None] * self._across
        stiff = np.flatnonzero(self.geometric)
        if len(stiff):  # a slack link has only the rows across it, and these then come first
            beside = np.arange(self.width) >= (status.kind[stiff] == LINK)[:, None]
            diagonal[stiff] += beside / self.geometric[stiff, None]
        size = int(free.sum())
        count = newton_rows(*self._blocks, order, unknown, *self._maps, diagonal, *self._rows)
        pointer, index, entry = self._rows
        matrix = sparse.csr_array((entry[:count], index[:count], pointer[: size + 1]), shape=(size, size))
        if self._cell is not None:
            border, unknowns = self._cell.shape[2], np.arange(self.width) < free[order, None]
            down, across = (
                np.einsum(how, of[order], self._cell[order])[unknowns]
                for how, of in (("iab,ibq->iaq", S), ("iba,ibq->iaq", E))
            )
            matrix = sparse.block_array([[matrix, down], [across.T, -np.eye(border)]])
            size += border
        lu = self._elimination.factorise(matrix.tocsc(), order, unknown, known)
        return Factors(lu, order, E[order], S[order], free[order], size)

    def newton(self, status: Status, epsilon: float, centre: np.ndarray) -> np.ndarray:
        """The impulses that satisfy the proximal problem with these statuses, (m, d).

        Raises RuntimeError if the matrix is singular to round-off.
        """
        r = self.factors(status, epsilon).impulses(epsilon * self.weight[:, None] * centre - self.q)
        if not np.isfinite(r).all():
            raise RuntimeError("not finite")
        return r

    # ------------------------------------------------------------------------------------------- for paths, by kernels

    @property
    def turning_disks(self) -> int:
        """How many disks of a contact in space have a direction that turns."""
        return min(self.laws[1].shape[1], 2)

    def next_bend(self, a: np.ndarray, along: np.ndarray, status: Status) -> tuple[int, float, float]:
        """See ``path_kernels``."""
        return next_bend(a, along, status.kind, status.direction, self.laws[1], self.laws[4])

    def pass_bend(self, i: int, side: float, a: np.ndarray, status: Status, wall: np.ndarray, jump: np.ndarray) -> None:
        w, shares, compliance, _, cones = self.laws
        pass_bend(i, side, a, status.kind, status.direction, w, shares, compliance, cones, wall, jump)

    def impulses_of(self, a: np.ndarray, kind: np.ndarray) -> tuple[np.ndarray, Status]:
        """Impulses of ``a`` in the cell of these kinds, and the statuses there; see ``path_kernels_3d``."""
        r, status = np.zeros_like(a), Status(kind, np.zeros_like(a[:, 1:]), np.zeros_like(self.laws[1]))
        impulses_of(a, *status, *self.laws[:4], r)
        return r, status

    def next_wall(
        self, a: np.ndarray, along: np.ndarray, kind: np.ndarray, direction: np.ndarray
    ) -> tuple[int, int, float, float]:
        return next_wall(a, along, kind, direction, self.laws[1], self.laws[4])

    def pass_wall(self, i: int, disk: int, a: np.ndarray, model: Status, *arrays: np.ndarray) -> None:
        """``arrays``: wall, jump, and across and turned, which have a row for each disk that turns."""
        w, shares, compliance, _, cones = self.laws
        pass_wall(i, disk, a, *model, w, shares, compliance, cones, *arrays)


@dataclass(frozen=True)
class Factors:
    """The factorised matrix ``S (W + epsilon w) E + D`` of one set of statuses."""

    lu: Any
    order: np.ndarray
    """The interactions that act, in the order of their elimination, (k,)."""
    E: np.ndarray
    S: np.ndarray
    free: np.ndarray
    """Number of columns of E, and of rows of S, (k,)."""
    size: int
    """Number of unknowns; the unknowns of a periodic cell come last."""

    @property
    def sign(self) -> float:
        """Sign of the determinant."""
        if not len(self.order):
            return 1.0
        diagonal = self.lu.U.diagonal()
        border = self.size - int(self.free.sum())
        of_border = -1.0 if border % 2 else 1.0  # det = det(-1) det(S (W + epsilon w) E + D)
        return of_border * parity(self.lu.perm_r) * parity(self.lu.perm_c) * float(np.prod(np.sign(diagonal)))

    def impulses(self, given: np.ndarray) -> np.ndarray:
        """``r = E x`` with ``(S (W + epsilon w) E + D) x = S given``, of the shape of ``given`` (m, d)."""
        r = np.zeros_like(given)
        if len(self.order):
            right = np.zeros(self.size)
            velocities_given(given, self.order, self.S, self.free, right)
            impulses_by(self.lu.solve(right), self.order, self.E, self.free, r)
        return r
