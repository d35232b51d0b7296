"""Newton steps of problems whose contacts roll."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.rolling_path import (
    next_rolling_bend,
    next_rolling_wall,
    pass_rolling_bend,
    pass_rolling_wall,
    rolling_impulses_of,
)
from lmgcpy.solve.newton.rolling_rows import disk_columns, rolling_local_maps, rolling_natural_map
from lmgcpy.solve.problems.problem import Problem


class RollingStatus(NamedTuple):
    """Statuses of all interactions, as ``active_set.Status``."""

    kind: np.ndarray
    """OPEN, LINK, or CLOSED with a bit for each disk that slides, (m,)."""
    direction: np.ndarray
    """tau of the disks that slide, (m, D - 1), zero elsewhere."""
    turning: np.ndarray
    """``|a| / (c a_n) - 1`` of the disks that slide, (m, disks), zero elsewhere."""

    def changes(self, other: RollingStatus) -> int:
        """Number of interactions that differ in kind or slide in the opposite direction."""
        product, differ, d = self.direction * other.direction, self.kind != other.kind, self.turning.shape[1]
        for g in range(d):  # as many disks as dimensions
            first, end = disk_columns(g, d)
            differ |= product[:, first - 1 : end - 1].sum(axis=1) < 0.0
        return int(np.count_nonzero(differ))


class RollingActiveSet(ActiveSet):
    """The active set for contacts with rolling components: friction and rolling each stick or slide on their own."""

    def __init__(self, problem: Problem):
        self.shares = np.stack([share for _, share in problem.disks], axis=1)
        self._across = np.zeros((len(problem.mu), problem.width - 1))
        super().__init__(problem)

    def natural(self, u: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, RollingStatus]:  # type: ignore[override]
        count, width = r.shape
        turning = np.zeros_like(self.shares)
        status = RollingStatus(np.zeros(count, np.int64), np.zeros((count, width - 1)), turning)
        error = np.zeros_like(r)
        w, _, compliance, geometric, cones = self.laws
        rolling_natural_map(u, r, w, self.shares, compliance, geometric, cones, self.dimension, error, *status)
        return error, status

    def local_maps(self, status: RollingStatus) -> np.ndarray:  # type: ignore[override]
        rolling_local_maps(*status, self.shares, self.geometric, self.dimension, *self._maps, self._across)
        return self._across

    # ------------------------------------------------------------------------------------------- for paths, by kernels

    turning_disks = 2

    def next_bend(self, a: np.ndarray, along: np.ndarray, status: RollingStatus) -> tuple[int, float, float]:  # type: ignore[override]
        return next_rolling_bend(a, along, status.kind, status.direction, self.shares, self.laws[4])

    def pass_bend(  # type: ignore[override]
        self, i: int, side: float, a: np.ndarray, status: RollingStatus, wall: np.ndarray, jump: np.ndarray
    ) -> None:
        w, _, compliance, _, cones = self.laws
        pass_rolling_bend(i, side, a, status.kind, status.direction, w, self.shares, compliance, cones, wall, jump)

    def impulses_of(self, a: np.ndarray, kind: np.ndarray) -> tuple[np.ndarray, RollingStatus]:  # type: ignore[override]
        w, _, compliance, geometric, _ = self.laws
        r, status = np.zeros_like(a), RollingStatus(kind, np.zeros_like(a[:, 1:]), np.zeros_like(self.shares))
        rolling_impulses_of(a, *status, w, self.shares, compliance, geometric, r)
        return r, status

    def next_wall(
        self, a: np.ndarray, along: np.ndarray, kind: np.ndarray, direction: np.ndarray
    ) -> tuple[int, int, float, float]:
        return next_rolling_wall(a, along, kind, direction, self.shares, self.laws[4])

    def pass_wall(self, i: int, between: int, a: np.ndarray, model: RollingStatus, *arrays: np.ndarray) -> None:  # type: ignore[override]
        w, _, compliance, _, cones = self.laws
        pass_rolling_wall(i, between, a, *model, w, self.shares, compliance, cones, *arrays)


def active_set_of(problem: Problem) -> ActiveSet:
    """The active set of a problem."""
    return RollingActiveSet(problem) if problem.width > problem.dimension else ActiveSet(problem)
