"""The kernels of Gauss-Seidel on an assembled Delassus operator, for problems that come without bodies.

The templates of ``contact_block`` and ``wire_block`` stay as they are: only how a relative velocity is read and how an
impulse is passed on differ, in the same way in 2D and 3D. Here the relative velocities of all interactions are kept, and
an impulse of one changes those that its block column of W reaches.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numba
import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.compiled.reference import by_reference
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.solve import h_rows_2d, h_rows_3d
from lmgcpy.solve.law_kernels import group_kernels
from lmgcpy.solve.problem import BOTH, CONTACT, PULL, Problem
from lmgcpy.solve.small_matrices import small_matrices
from lmgcpy.solve.stiffened_wire_block import scratch_columns
from lmgcpy.solve.system import Groups

STANDARD: dict[int, type[Law]] = {CONTACT: Coulomb, PULL: ElasticWire, BOTH: ElasticRod}
"""A law for each cone; its bias is zero, as the problem has it in q."""


@by_reference
class MatrixSystem(NamedTuple):
    """Arrays of a problem in dimension d; m interactions."""

    first: np.ndarray
    """First block of each block column, and the end, (m + 1,) int64."""
    row: np.ndarray
    """Row of each block, (blocks,) int64."""
    block: np.ndarray
    """Blocks of W, (blocks, d, d)."""
    delassus: np.ndarray
    """Diagonal of the local blocks (W_nn, W_tt, W_ss) [1/kg], (m, d)."""
    coupling: np.ndarray
    """W_nt of a contact; of a link, the entry of W between it and the next link of its wire, (m,)."""
    shear: np.ndarray
    """(W_ns, W_ts) of a contact in 3D, (m, 2); (0, 2) in 2D."""
    prepared: np.ndarray
    impulse: np.ndarray
    """(r_n, r_t, r_s) [N s], (m, d)."""
    velocity: np.ndarray
    """Relative velocities under the present impulses [m/s], (m, d)."""
    geometric: np.ndarray
    """Geometric stiffness of each interaction [kg], (m,); (0,) where none has any."""
    carried: np.ndarray
    """Zeros, (m, d - 1) or none: it is part of q."""
    own: np.ndarray
    """Local block of W of each interaction [1/kg], (m, d, d), or none."""
    following: np.ndarray
    """Block of W between each link and the next one of its wire [1/kg], (m, d, d), or none."""
    scratch: np.ndarray
    scale: np.ndarray
    squared_error: np.ndarray
    noise: np.ndarray
    floor: np.ndarray
    """See ``lmgcpy.solve.system.System``; ``noise`` has a row for each interaction."""
    measured: np.ndarray


_of_two = small_matrices(2)  # the specialisation gives those of the dimension
row, block, times, add_row = _of_two["row"], _of_two["block"], _of_two["times"], _of_two["add_row"]


def relative_velocity(i, s):
    """(u_n, u_t(, u_s)) of interaction ``i``."""
    return row(s.velocity, i, 0)


def push(i, s, d):
    """Add the block column ``W_ji d`` of an impulse ``d`` on interaction ``i`` to the velocities that it reaches."""
    for k in range(np.uintp(s.first[i]), np.uintp(s.first[i + np.uintp(1)])):
        add_row(s.velocity, np.uintp(s.row[k]), times(block(s.block, k), d))


def add_impulses(start, stop, walls, s, velocity):
    """Add ``W r`` of some interactions."""
    for i in range(start, stop):
        push(np.uintp(i), s, row(s.impulse, i, 0))


def add_noise(start, stop, walls, s):
    """Add ``|W| |r|`` of some interactions to the sizes of the terms."""
    for i in range(start, stop):
        for k in range(s.first[i], s.first[i + 1]):
            j = s.row[k]
            for row in range(s.block.shape[1]):
                for column in range(s.block.shape[2]):
                    s.noise[j, min(row, 1)] += abs(s.block[k, row, column] * s.impulse[i, column])


def gather_noise(first, last, s):
    """Sizes of the terms of some relative velocities [m/s], into ``s.floor``."""
    for i in range(first, last):
        s.floor[i] = s.noise[i, 0] + s.noise[i, 1]


def begin_noise(first, last, s, free_velocity):
    """Sizes of the terms of the velocities without impulses: their own."""
    for i in range(first, last):
        s.noise[i, 0] = abs(free_velocity[i, 0])
        s.noise[i, 1] = 0.0
        for k in range(1, free_velocity.shape[1]):
            s.noise[i, 1] += abs(free_velocity[i, k])


def begin_free(first, last, s, free_velocity):
    """``u = q``."""
    s.velocity[first:last] = free_velocity[first:last]


def leave(first, last, s, free_velocity):
    """Nothing: the velocities of the interactions are complete."""


def parts_of(dimension: int) -> dict[str, Any]:
    """The parts of the templates that differ from those of bodies."""
    own = h_rows_2d if dimension == 2 else h_rows_3d
    return {"relative_velocity": relative_velocity, "push": push, "local_problem": own.local_problem}


def driver_of(dimension: int) -> dict[str, Any]:
    """Slots of the kernels that lead sweeps."""
    return {
        "clear": begin_free,
        "momentum": Kernel(add_impulses, small_matrices(dimension)),
        "combine": leave,
        "begin_noise": begin_noise,
        "add_noise": add_noise,
        "gather_noise": gather_noise,
    }


def _runs(problem: Problem) -> list[tuple[int, int]]:
    """Rows (start, stop) of interactions that one kernel call solves: contacts, or the links of one wire.

    Links are one wire as long as each meets the one before it and none of those before that.
    """
    d, cones, W = problem.dimension, problem.cones, problem.W.tocsr()
    bounds = [0] if len(cones) else []
    for i in range(1, len(cones)):
        same = cones[i] == cones[i - 1]
        if cones[i] != CONTACT and same:
            row = slice(W.indptr[d * i], W.indptr[d * i + 1])
            met = W.indices[row][W.data[row] != 0.0]
            met = met[(met >= d * bounds[-1]) & (met < d * i) & (met % d == 0)]
            same = met.tolist() == [d * (i - 1)]
        if not same:
            bounds.append(i)
    return list(pairwise([*bounds, len(cones)]))


def _stiffening(problem: Problem, runs: list[tuple[int, int]]) -> dict[str, np.ndarray]:
    """Further arrays of a system whose links have geometric stiffness; empty where none has any."""
    d = problem.dimension
    count = len(problem.mu) if problem.geometric.any() else 0
    own, following = np.zeros((count, d, d)), np.zeros((count, d, d))
    if count:
        first = d * np.arange(count)
        along = np.concatenate([np.arange(start, stop - 1) for start, stop in runs])
        for a in range(d):
            for b in range(d):
                own[:, a, b] = np.asarray(problem.W[first + a, first + b]).ravel()
                following[along, a, b] = np.asarray(problem.W[first[along] + a, first[along] + d + b]).ravel()
    geometric = problem.geometric.copy() if count else np.zeros(0)
    return {"geometric": geometric, "carried": np.zeros((count, d - 1)), "own": own, "following": following}


def assemble_problem(problem: Problem, wire_blocks: bool) -> tuple[Groups, MatrixSystem, list[Any]]:
    """Groups and system of a problem, and what must stay alive while they are used."""
    count, d = len(problem.mu), problem.dimension
    columns = problem.W.T.tobsr(blocksize=(d, d)) if count else problem.W.T.tobsr(blocksize=(1, 1))
    diagonal = problem.W.diagonal().reshape(-1, d)
    normal = d * np.arange(count)
    following = np.asarray(problem.W[normal[:-1], normal[1:]]).ravel() if count > 1 else np.zeros(0)

    def local(i: int, j: int) -> np.ndarray:
        return np.asarray(problem.W[normal + i, normal + j]).ravel() if count else np.zeros(0)

    tangential = local(0, 1)
    runs = _runs(problem)
    cones = problem.cones
    coupling = np.where(cones == CONTACT, tangential, 0.0)
    for start, stop in runs:
        if cones[start] != CONTACT:
            coupling[start : stop - 1] = following[start : stop - 1]
    second = np.where(cones == CONTACT, problem.mu, problem.compliance)
    links = max((stop for start, stop in runs if cones[start] != CONTACT), default=0)
    system = MatrixSystem(
        first=columns.indptr.astype(np.int64),
        row=columns.indices.astype(np.int64),
        block=np.ascontiguousarray(columns.data.transpose(0, 2, 1)) if count else np.zeros((0, d, d)),
        delassus=np.ascontiguousarray(diagonal),
        coupling=coupling,
        shear=np.column_stack([local(0, 2), local(1, 2)]) if d == 3 else np.zeros((0, 2)),
        prepared=np.column_stack([np.zeros(count), second]).ravel(),
        impulse=np.zeros((count, d)),
        velocity=np.zeros((count, d)),
        **_stiffening(problem, runs),
        scratch=np.zeros((links, scratch_columns(d)["WIDTH"] if problem.geometric.any() else 4)),
        scale=np.zeros(count) if problem.scale is None else problem.scale,
        squared_error=np.zeros(count),
        noise=np.zeros((count, 2)),
        floor=np.zeros(count),
        measured=np.zeros(4),
    )
    kernels = []
    for start, stop in runs:
        law = STANDARD[int(cones[start])]
        contact = cones[start] == CONTACT
        rows = d if contact and problem.mu[start:stop].any() else 1
        chain = wire_blocks and not contact
        diagonal_only = not (contact and (coupling[start:stop].any() or system.shear[start:stop].any()))
        stiffened = not contact and len(system.geometric) > 0
        given: tuple[Any, ...] = law, d, rows, diagonal_only, chain, numba.typeof(system), {}, parts_of(d)
        kernels.append(group_kernels(*given, stiffened=stiffened))
    table = Groups.in_order(
        sweep=[sweep.address for sweep, _ in kernels],
        error=[error.address for _, error in kernels],
        start=[start for start, _ in runs],
        stop=[stop for _, stop in runs],
        offset=[2 * start for start, _ in runs],
    )
    return table, system, kernels
