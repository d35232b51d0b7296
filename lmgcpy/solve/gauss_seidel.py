"""Non-linear Gauss-Seidel on the velocities of the bodies (Jean 1999), with whole wires as blocks.

A sweep visits the groups of interactions in canonical order and calls the kernel of each group once, by its address:
no call per interaction, and nothing to compile anew when another set of laws comes together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import flag, named_arguments, number, whole
from lmgcpy.jit import kernel
from lmgcpy.solve.by_address import call, read
from lmgcpy.solve.contact_block import momentum  # of bodies in the plane, unless the specialisation gives another
from lmgcpy.solve.problem import Conic
from lmgcpy.solve.report import CONVERGED, NOT_FINITE, SPENT, STAGNATED
from lmgcpy.solve.solver import Outcome
from lmgcpy.solve.system import Groups
from lmgcpy.solve.team import Iterates, Team, lead, share_chunks, share_phases

SWEEP, ERROR, MOMENTUM, CLEAR, COMBINE, NOTHING, GUESS, FASTEST, *OWN = map(np.int64, range(16))
"""Kinds of work, the last those of a solver's own; numbers of numpy, as plain ones make a new function each."""


@kernel
def work(kind, task, job):
    """One task, specialised for what bodies there are; see :mod:`lmgcpy.solve.team`.

    Each kind reads of the job what it needs, no more.
    """
    if kind == SWEEP:
        sweep_pieces(task, job)
    elif kind == ERROR:
        measure_pieces(task, job)
    elif kind == MOMENTUM:
        add_momentum(task, job)
    elif kind <= FASTEST:
        bodies_work(kind, task, job)
    else:
        own_work(kind, task, job)


def sweep_pieces(task, job):
    """Update the impulses; leaves the sum of what the kernels return."""
    step = read(job)
    groups = step.groups
    total = 0.0
    for p in range(groups.task[task], groups.task[task + 1]):
        total += call(groups.sweep[p], groups.start[p], groups.stop[p], groups.offset[p], step.s)
    step.partial[task, 0] = total


def measure_pieces(task, job):
    """Leaves the sum of squared errors, the worst, and its row."""
    step = read(job)
    groups = step.groups
    worst = step.s.worst
    worst[0] = -1.0
    worst[1] = -1.0
    total = 0.0
    for p in range(groups.task[task], groups.task[task + 1]):
        total += call(groups.error[p], groups.start[p], groups.stop[p], groups.offset[p], step.s)
    step.partial[task, 0] = total
    step.partial[task, 1] = worst[0]
    step.partial[task, 2] = worst[1]


def add_momentum(task, job):
    """Give the impulses to the bodies."""
    step = read(job)
    groups = step.groups
    for p in range(groups.task[task], groups.task[task + 1]):
        momentum(groups.start[p], groups.stop[p], groups.walls[p], step.s, step.s.velocity)


def bodies_work(kind, task, job):
    """What is done to the arrays of bodies and impulses, a part of each."""
    step = read(job)
    s = step.s
    first, last = part(task, s.velocity.shape[0], step.chunks)
    if kind == CLEAR:
        clear(first, last, s, step.free_velocity)
    elif kind == COMBINE:
        combine(first, last, s, step.free_velocity)
    elif kind == FASTEST:
        fastest = 0.0
        for b in range(first, last):
            for k in range(s.velocity.shape[1]):
                fastest = max(fastest, abs(s.velocity[b, k]))
        step.partial[task, 0] = fastest
    else:
        for b in range(first, last):
            for k in range(s.velocity.shape[1]):
                s.velocity[b, k] = step.free_velocity[b, k]
        first, last = part(task, s.impulse.shape[0], step.chunks)
        for i in range(first, last):
            for k in range(s.impulse.shape[1]):
                s.impulse[i, k] = step.guess[i, k] if kind == GUESS else 0.0


def part(task, count, chunks):
    """Which of so many rows a task has that works on whole arrays: the first, and the one after the last."""
    return task * count // chunks, (task + 1) * count // chunks


def own_work(kind, task, job):
    """What solvers do beyond; given by the specialisation where there is any."""


def clear(first, last, s, free_velocity):
    """Make room for the momentum of some bodies."""
    for b in range(first, last):
        for k in range(s.velocity.shape[1]):
            s.velocity[b, k] = 0.0


def combine(first, last, s, free_velocity):
    """``v = v_free + M^-1 H r`` of some bodies, from their momentum."""
    for b in range(first, last):
        for k in range(s.velocity.shape[1]):
            s.velocity[b, k] = free_velocity[b, k] + s.inverse_mass[b, k] * s.velocity[b, k]


# ------------------------------------------------------------------------------------------- what leads the work


def total_error(team):
    """Euclidean norm of e over all interactions [m/s]; leaves the worst one in ``team.worst``."""
    share_phases(ERROR, team)
    found = team.partial
    total = 0.0
    worst = -1.0
    row = -1.0
    for task in range(team.phase[-1]):
        total += found[task, 0]
        if not found[task, 1] <= worst and not np.isnan(worst):  # the first NaN, too, is the worst
            worst = found[task, 1]
            row = found[task, 2]
    team.worst[0] = worst
    team.worst[1] = row
    return np.sqrt(total)


def sweep_groups(team):
    """One sweep over all interactions; False where a law raised an exception."""
    share_phases(SWEEP, team)
    total = 0.0
    for task in range(team.phase[-1]):
        total += team.partial[task, 0]
    return total == 0.0


def measure(team, nothing, tolerance):
    """The residual; one within tolerance is told only after measuring it again on velocities made anew."""
    residual = total_error(team) / nothing
    if residual <= tolerance:
        apply_impulses(team)
        residual = total_error(team) / nothing
    return residual


def round_off(team):
    """What arithmetic leaves of relative velocities [m/s]: four units of the fastest body's, over all interactions."""
    share_chunks(FASTEST, team)
    fastest = 0.0
    for task in range(team.chunks):
        fastest = max(fastest, team.partial[task, 0])
    return 4.0 * 2.0**-52 * fastest * np.sqrt(team.rows)


def apply_impulses(team):
    """``v = v_free + M^-1 H r``, from the impulses, so that nothing of the path by which they came is left in v."""
    share_chunks(CLEAR, team)
    share_phases(MOMENTUM, team)
    share_chunks(COMBINE, team)


def begin(team, tolerance):
    """Start from the guess; returns (``|e(0)|``, residual, whether nothing is left to do, status).

    Where ``|e(0)|`` is no more than round-off, near rest, no error can be told relative to it, and ``r = 0`` is the answer.
    """
    share_chunks(NOTHING, team)
    nothing = total_error(team)
    if nothing <= round_off(team):
        team.worst[0] = 0.0
        return nothing, 0.0, True, CONVERGED
    if not np.isfinite(nothing):
        return nothing, nothing, True, NOT_FINITE
    share_chunks(GUESS, team)
    apply_impulses(team)
    residual = total_error(team) / nothing
    return nothing, residual, residual <= tolerance, CONVERGED


@kernel
def gauss_seidel(team: Team, tolerance, max_iterations):
    """Sweep until ``|e(r)| <= tolerance |e(0)|``; returns (sweeps, residual, status).

    The error is measured after sweeps 1, 2, 3 ... and then at intervals of an eighth of the sweeps done, so that
    measuring costs about an eighth; before success is told it is measured again on velocities made anew from the
    impulses. Stagnation: the last half of the sweeps, at least 1000 of them, gained less than 1 %.
    """
    nothing, residual, done, status = begin(team, tolerance)
    if done:
        return 0, residual, status
    best = residual
    milestone = residual
    milestone_sweep = 0
    sweeps = 0
    check = 1
    status = SPENT
    while sweeps < max_iterations:
        if not sweep_groups(team):
            status = NOT_FINITE
            break
        sweeps += 1
        if sweeps < check and sweeps < max_iterations:
            continue
        check = sweeps + 1 + sweeps // 8
        residual = measure(team, nothing, tolerance)
        if residual <= tolerance:
            status = CONVERGED
            break
        if not np.isfinite(residual):
            status = NOT_FINITE
            break
        best = min(best, residual)
        if sweeps >= 2 * milestone_sweep and sweeps - milestone_sweep >= 1000:
            if best > 0.99 * milestone:
                status = STAGNATED
                break
            milestone = best
            milestone_sweep = sweeps
    if status != CONVERGED and status != NOT_FINITE:
        apply_impulses(team)
        residual = total_error(team) / nothing
    return sweeps, residual, status


@named_arguments
@dataclass(frozen=True)
class GaussSeidel:
    """Gauss-Seidel, the standard method of the field, with every wire solved as one block.

    ``tolerance``: stops at ``|e(r)| <= tolerance |e(0)|`` (see ``lmgcpy.residual``); ``max_iterations``: sweeps a step
    at the most; ``wire_blocks``: False visits the links of a wire one at a time, as other codes do.
    """

    tolerance: float = 1e-4
    max_iterations: int = 10_000
    wire_blocks: bool = True

    def __post_init__(self):
        object.__setattr__(self, "tolerance", number(self.tolerance, "tolerance", above=0.0, maximum=1.0))
        object.__setattr__(self, "max_iterations", whole(self.max_iterations, "max_iterations", minimum=1))
        flag(self.wire_blocks, "wire_blocks")

    def solve(
        self,
        groups: Groups,
        system: Any,
        free_velocity: np.ndarray,
        guess: np.ndarray,
        *,
        conic: Callable[[], Conic] | None = None,
        threads: int = 1,
        **operator: Any,
    ) -> Outcome:
        """Solve in place from the impulses ``guess``.

        ``conic`` is for other solvers; ``threads``: how many may work on a partitioned scene; ``operator``: functions that
        stand in for those on bodies in the plane.
        """
        none = np.zeros(0)
        step, iterates = (groups, system, free_velocity, guess), Iterates(none, none, none, none, none)
        limits = float(self.tolerance), int(self.max_iterations)
        return Outcome(*lead(gauss_seidel, work.specialise(**operator), step, iterates, threads, *limits))
