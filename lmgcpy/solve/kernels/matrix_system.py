"""The kernels of Gauss-Seidel on an assembled Delassus operator, for problems that come without bodies.

The templates are ``contact_block`` and ``wire_block``, unchanged. Only the functions that read a relative velocity and
pass on an impulse are others, the same in 2D and 3D. The system keeps the relative velocities of all interactions; an
impulse at one interaction changes the velocities that its block column of W reaches.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numba
import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.compiled.reference import by_reference
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.laws.rolling import RollingCoulomb
from lmgcpy.solve.kernels.forms import plane, space
from lmgcpy.solve.kernels.forms.form import Form
from lmgcpy.solve.kernels.law_kernels import KernelKey, LawKernels, law_kernels
from lmgcpy.solve.kernels.loads import LITTLE, NEARBY
from lmgcpy.solve.kernels.stiffened_wire_block import scratch_columns
from lmgcpy.solve.kernels.system import Groups
from lmgcpy.solve.problems.problem import BOTH, CONTACT, PULL, Problem

STANDARD: dict[int, type[Law]] = {CONTACT: Coulomb, PULL: ElasticWire, BOTH: ElasticRod}
"""A law for each cone; its bias is zero, as the problem has it in q."""


@by_reference
class MatrixSystem(NamedTuple):
    """Arrays of a problem in dimension d; m interactions. If contacts roll, blocks, W, impulses and velocities have D, not
    d, components."""

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
    """Geometric stiffness of each interaction [kg], (m,); (0,) if no interaction has any."""
    carried: np.ndarray
    """Zeros, (m, d - 1), or (0, d - 1): q contains the velocity that wires carry along."""
    own: np.ndarray
    """Local block of W of each interaction [1/kg], (m, d, d), or none."""
    following: np.ndarray
    """Block of W between each link and the next one of its wire [1/kg], (m, d, d), or none."""
    scratch: np.ndarray
    scale: np.ndarray
    squared_error: np.ndarray
    noise: np.ndarray
    floor: np.ndarray
    """See ``lmgcpy.solve.kernels.system.System``; ``noise`` has a row for each interaction."""
    measured: np.ndarray


_of_two = small_matrices(2)  # the specialisation gives the functions of its dimension
row, block, times, add_row = _of_two["row"], _of_two["block"], _of_two["times"], _of_two["add_row"]
less_row = _of_two["less_row"]


def relative_velocity(i, s):
    """(u_n, u_t(, u_s)) of interaction ``i``."""
    return row(s.velocity, i, 0)


def push(i, s, d):
    """Add the block column ``W_ji d`` of an impulse ``d`` on interaction ``i`` to the velocities that it reaches."""
    for k in range(np.uintp(s.first[i]), np.uintp(s.first[i + np.uintp(1)])):
        add_row(s.velocity, np.uintp(s.row[k]), times(block(s.block, k), d))


def push_first(i, s, d):
    """Passes on an impulse with fewer components than a block has rows; the components after its own are zero."""
    for k in range(np.uintp(s.first[i]), np.uintp(s.first[i + np.uintp(1)])):
        j = s.row[k]
        for a in range(s.block.shape[1]):
            for b in range(len(d)):
                s.velocity[j, a] += s.block[k, a, b] * d[b]


def own_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``, as a whole."""
    W = block(s.own, i)
    return W, less_row(u, times(W, r))


def add_impulses(start, stop, walls, s):
    """Add ``W r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        push(np.uintp(i), s, row(s.impulse, i, 0))
    return 0.0


def kept_velocities(start, stop, s, velocity, result):
    """Copies the relative velocities, which this system keeps instead of velocities of bodies."""
    result[start:stop] = velocity[start:stop]


def add_noise(start, stop, walls, s):
    """Add ``|W| |r|`` of some interactions to the sizes of the terms."""
    for i in range(start, stop):
        for k in range(s.first[i], s.first[i + 1]):
            j = s.row[k]
            for row in range(s.block.shape[1]):
                for column in range(s.block.shape[2]):
                    s.noise[j, min(row, 1)] += abs(s.block[k, row, column] * s.impulse[i, column])


def add_load(start, stop, walls, s, found):
    """Column 2 of ``s.noise``: the greatest impulse [N s] among the interactions that reach an interaction by W."""
    for i in range(start, stop):
        size = 0.0
        for k in range(s.impulse.shape[1]):
            size += s.impulse[i, k] * s.impulse[i, k]
        if size > 0.0:
            found[1] += 0.5 * np.log(size)
            found[2] += 1.0
        for k in range(s.first[i], s.first[i + 1]):
            s.noise[s.row[k], 2] = max(s.noise[s.row[k], 2], np.sqrt(size))


def share_load(start, stop, walls, s):
    """Column 3 of ``s.noise``: the greatest column 2 among the interactions that reach an interaction by W [N s]."""
    for i in range(start, stop):
        for k in range(s.first[i], s.first[i + 1]):
            s.noise[s.row[k], 3] = max(s.noise[s.row[k], 3], s.noise[i, 2])


def load_of(i, s, typical):
    """The greatest impulse on the bodies of an interaction [N s]."""
    return max(s.noise[i, 2], NEARBY * s.noise[i, 3], LITTLE * typical)


def gather_noise(first, last, s):
    """Sizes of the terms of some relative velocities [m/s], into ``s.floor``."""
    for i in range(first, last):
        s.floor[i] = s.noise[i, 0] + s.noise[i, 1]


def begin_noise(first, last, s, free_velocity, gaps):
    """Sizes of the terms of the velocities without impulses: the sizes of these velocities."""
    for i in range(first, last):
        s.noise[i, 0] = abs(free_velocity[i, 0])
        s.noise[i, 1] = 0.0
        for k in range(1, free_velocity.shape[1]):
            s.noise[i, 1] += abs(free_velocity[i, k])


def kinetic_energy(first, last, s, velocity):
    """Zero, as there are no masses."""
    return 0.0


def begin_free(first, last, s, free_velocity):
    """``u = q``."""
    s.velocity[first:last] = free_velocity[first:last]


def leave(first, last, s, free_velocity):
    """Nothing: the velocities of the interactions are complete."""


@cache
def matrix_form(dimension: int, width: int, rolls: bool) -> Form:
    """The form of interactions of a problem of this width; ``rolls``: of a contact that has all of its components."""
    own, passing = plane if dimension == 2 else space, push if width == dimension else push_first
    problem, passing = (own_problem, push) if rolls else (own.local_problem, passing)
    return Form(
        dimension=dimension,
        width=width if rolls else dimension,
        relative_velocity=relative_velocity,
        push=passing,
        local_problem=problem,
        momentum=Kernel(add_impulses, small_matrices(width)),
        relative_velocities=Kernel(kept_velocities),
        seen=width if rolls else dimension,
    )


DRIVER = {
    "clear": begin_free,
    "combine": leave,
    "begin_noise": begin_noise,
    "kinetic_energy": kinetic_energy,
    "add_noise": add_noise,
    "gather_noise": gather_noise,
    "add_load": add_load,
    "share_load": share_load,
    "load_of": load_of,
}
"""Slots of the kernels that lead sweeps."""


def _runs(problem: Problem) -> list[tuple[int, int]]:
    """Rows (start, stop) of interactions that one kernel call solves: contacts that roll, others, or links of one wire.

    Links form one wire as long as each meets the link before it and no earlier one.
    """
    d, cones, W, rolls = problem.width, problem.cones, problem.W.tocsr(), problem.rolls
    bounds = [0] if len(cones) else []
    for i in range(1, len(cones)):
        same = cones[i] == cones[i - 1] and rolls[i] == rolls[i - 1]
        if cones[i] != CONTACT and same:
            row = slice(W.indptr[d * i], W.indptr[d * i + 1])
            met = W.indices[row][W.data[row] != 0.0]
            met = met[(met >= d * bounds[-1]) & (met < d * i) & (met % d == 0)]
            same = met.tolist() == [d * (i - 1)]
        if not same:
            bounds.append(i)
    return list(pairwise([*bounds, len(cones)]))


def _stiffening(problem: Problem, runs: list[tuple[int, int]]) -> dict[str, np.ndarray]:
    """Further arrays of a system whose links have geometric stiffness. They are empty if no link has any, except the local
    blocks if contacts roll."""
    d, width = problem.dimension, problem.width
    count = len(problem.mu) if problem.geometric.any() else 0
    own, following = np.zeros((len(problem.mu) if count or width > d else 0, width, width)), np.zeros((count, d, d))
    first = width * np.arange(len(own))
    for a in range(width):
        for b in range(width):
            own[:, a, b] = np.asarray(problem.W[first + a, first + b]).ravel() if len(own) else 0.0
    if count:
        along = np.concatenate([np.arange(start, stop - 1) for start, stop in runs])
        for a in range(d):
            for b in range(d):
                following[along, a, b] = np.asarray(problem.W[first[along] + a, first[along] + width + b]).ravel()
    geometric = problem.geometric.copy() if count else np.zeros(0)
    return {"geometric": geometric, "carried": np.zeros((count, d - 1)), "own": own, "following": following}


def assemble_problem(problem: Problem, wire_blocks: bool) -> tuple[Groups, MatrixSystem, list[LawKernels]]:
    """Groups and system of a problem, and the kernels, which must stay alive while the groups are used."""
    count, d, width = len(problem.mu), problem.dimension, problem.width
    columns = problem.W.T.tobsr(blocksize=(width, width)) if count else problem.W.T.tobsr(blocksize=(1, 1))
    diagonal = problem.W.diagonal().reshape(-1, width)
    normal = width * np.arange(count)
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
    rolls = problem.rolls
    second = np.where(cones == CONTACT, problem.mu, problem.compliance)
    prepared, offset = prepared_numbers(problem, second, runs)
    links = max((stop for start, stop in runs if cones[start] != CONTACT), default=0)
    system = MatrixSystem(
        first=columns.indptr.astype(np.int64),
        row=columns.indices.astype(np.int64),
        block=np.ascontiguousarray(columns.data.transpose(0, 2, 1)) if count else np.zeros((0, width, width)),
        delassus=np.ascontiguousarray(diagonal),
        coupling=coupling,
        shear=np.column_stack([local(0, 2), local(1, 2)]) if d == 3 else np.zeros((0, 2)),
        prepared=prepared,
        impulse=np.zeros((count, width)),
        velocity=np.zeros((count, width)),
        **_stiffening(problem, runs),
        scratch=np.zeros((links, scratch_columns(d)["WIDTH"] if problem.geometric.any() else 4)),
        scale=np.zeros(count) if problem.scale is None else problem.scale,
        squared_error=np.zeros(count),
        noise=np.zeros((count, 4)),
        floor=np.zeros(count),
        measured=np.zeros(6),
    )
    kernels = []
    for start, stop in runs:
        law = RollingCoulomb if rolls[start] else STANDARD[int(cones[start])]
        contact = cones[start] == CONTACT
        rows = width if rolls[start] else d if contact and problem.mu[start:stop].any() else 1
        key = KernelKey(
            form=matrix_form(d, width, bool(rolls[start])),
            rows=rows,
            diagonal=not (contact and (coupling[start:stop].any() or system.shear[start:stop].any())),
            block=wire_blocks and not contact and problem.split is None,  # as in dynamics.assembly
            stiffened=not contact and len(system.geometric) > 0,
            system_type=numba.typeof(system),
        )
        kernels.append(law_kernels(law, key))
    table = Groups.in_order(kernels, [start for start, _ in runs], [stop for _, stop in runs], offset)
    return table, system, kernels


def prepared_numbers(problem: Problem, second: np.ndarray, runs: list[tuple[int, int]]) -> tuple[np.ndarray, list[int]]:
    """The prepared numbers of all interactions in a row, and the start of each run. An interaction has the bias 0 and
    ``second`` (m,), a rolling contact in addition its coefficients of rolling and torsion."""
    pieces, offset, rolls = [np.zeros(0)], [], problem.rolls
    for start, stop in runs:
        offset.append(sum(map(len, pieces)))
        part = slice(start, stop)
        turning = [problem.rolling[part], problem.torsion[part]] if rolls[start] else []
        pieces.append(np.column_stack([np.zeros(stop - start), second[part], *turning]).ravel())
    return np.concatenate(pieces), offset
