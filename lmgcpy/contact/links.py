"""Links of a chain: gap, local frame and blocks of W. Between centres one kernel for 2D and 3D.

Links may act at points p of their bodies, with the levers ``l = p - x``. An impulse f at a point gives the point the
velocity ``K f``, with the mobility

    K = M^-1 + B^T I^-1 B,      B f = R^T (l x f),

R the rotation from the axes of the body to those of space, in 2D without R. So the block of W of a link along n is
``n . (K_c + K_a) n``, and between neighbours, which act at the same point of the body that they share, the entry is
``-n_i . K n_j``: the part of W of a chain stays tridiagonal.

A joint is a link along each axis of space, whose gap is the component of the vector from the antagonist's point to the
candidate's. Both bodies feel it half-way between their points, so that the pair of forces has no moment. The part of W of
its d links is ``K_c + K_a``: two links in a row in 2D, and in 3D three links in a ring, whose entries ``coupling`` holds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import Kernel, kernel
from lmgcpy.contact.detection_tables import ChainTable, JointTable, Points
from lmgcpy.contact.frames import cross_rows, local_frames, tangent_of
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.lattice import Lattice
from lmgcpy.contact.narrow_phase import translation_block
from lmgcpy.contact.narrow_phase_3d import moves, weighted
from lmgcpy.contact.positions import axes_of, in_plane, in_space

centre_line: Callable[..., Any] = Slot("centre_line")
"""``(bodies, c, a)``: distance between two centres [m] and unit vector from a to c; upward if they coincide."""
link_block: Callable[..., Any] = Slot("link_block")
"""``(i, n, c, a, inverse_mass, tangent)``: diagonal of the local block of W [1/kg]; writes the tangent if it is kept."""


@kernel
def detect_links(chain, radius_sum, closed, first, first_slot, bodies, inverse_mass, result: Interactions):
    """Write the links of one chain from row ``first`` on; ``coupling`` is the entry of W between a link and the next.

    ``closed``: whether the last body of the chain is the first, or an image of it.
    """
    count = radius_sum.shape[0]
    for k in range(count):
        i = first + k
        a = chain[k]
        c = chain[k + 1]
        distance, n = centre_line(bodies, c, a)
        block = link_block(i, n, c, a, inverse_mass, result.tangent)
        result.candidate[i] = c
        result.antagonist[i] = a
        result.gap[i] = distance - radius_sum[k]
        for axis in range(len(n)):
            result.normal[i, axis] = n[axis]
            result.delassus[i, axis] = block[axis]
        # a link acts on the centres: no lever
        result.arm[i, 0] = 0.0
        result.arm[i, 1] = 0.0
        if result.shear.shape[0] > 0:
            result.shear[i, 0] = 0.0
            result.shear[i, 1] = 0.0
        result.slot[i] = first_slot + k
    for k in range(count):
        i = first + k
        j = first if k == count - 1 else i + 1
        shared = chain[k + 1]
        # W between neighbours is -n_i . M^-1 n_j: the shared body is candidate of the one and antagonist of the other
        entry = 0.0
        if k < count - 1 or closed:
            entry = result.normal[i, 0] * result.normal[j, 0] * inverse_mass[shared, 0]
            for axis in range(1, result.normal.shape[1]):
                entry += result.normal[i, axis] * result.normal[j, axis] * inverse_mass[shared, axis]
            entry = -entry
        result.coupling[i] = entry


def _centre_line_2d(bodies, c, a):
    x = bodies[c, 0] - bodies[a, 0]
    y = bodies[c, 1] - bodies[a, 1]
    distance = np.sqrt(x * x + y * y)
    if distance > 0.0:
        return distance, (x / distance, y / distance)
    return distance, (0.0, 1.0)


def _centre_line_3d(bodies, c, a):
    x = bodies[c, 0] - bodies[a, 0]
    y = bodies[c, 1] - bodies[a, 1]
    z = bodies[c, 2] - bodies[a, 2]
    distance = np.sqrt(x * x + y * y + z * z)
    if distance > 0.0:
        return distance, (x / distance, y / distance, z / distance)
    return distance, (0.0, 0.0, 1.0)


def _link_block_2d(i, n, c, a, inverse_mass, tangent):
    x = inverse_mass[c, 0] + inverse_mass[a, 0]
    y = inverse_mass[c, 1] + inverse_mass[a, 1]
    w_nn, w_tt, _ = translation_block(n[0], n[1], x, y)
    return w_nn, w_tt


def _link_block_3d(i, n, c, a, inverse_mass, tangent):
    moving = moves(c, a, inverse_mass)
    t = tangent_of(n[0], n[1], n[2])
    tangent[i, 0], tangent[i, 1], tangent[i, 2] = t
    w_nn = weighted(n, moving, n)
    w_tt = weighted(t, moving, t)
    # W_ss from the trace, which does not depend on the frame
    return w_nn, w_tt, moving[0] + moving[1] + moving[2] - w_nn - w_tt


LINKS: dict[int, Kernel] = {
    2: detect_links.specialise(centre_line=_centre_line_2d, link_block=_link_block_2d),
    3: detect_links.specialise(centre_line=_centre_line_3d, link_block=_link_block_3d),
}
"""The kernel of each dimension."""


def offsets_in_space(points: Points, positions: np.ndarray) -> np.ndarray:
    """Vectors from the centres to the points (k, d), along the axes of space [m]; ``positions`` of the bodies, (k, w)."""
    if points.offset.shape[1] == 2:
        return in_plane(positions[:, 2], points.offset)
    return in_space(positions[:, 3:], points.offset) if positions.shape[1] == 7 else points.offset


def turning_mobility(lever: np.ndarray, axes: np.ndarray | None, inverse_inertia: np.ndarray) -> np.ndarray:
    """``B^T I^-1 B`` of points with these levers (k, d) [1/kg], (k, d, d); ``axes``: R of the bodies, (k, 3, 3), None in
    2D; inverse inertias (k, 1 or 3)."""
    if axes is None:
        B = np.column_stack([-lever[:, 1], lever[:, 0]])[:, :, None]  # its transpose, as below
    else:
        B = cross_rows(lever[:, None], np.eye(3)) @ axes
    return (B * inverse_inertia[:, None]) @ B.transpose(0, 2, 1)


def mobility(lever: np.ndarray, positions: np.ndarray, inverse_mass: np.ndarray) -> np.ndarray:
    """K of points with these levers (k, d) on bodies at ``positions`` (k, w) [1/kg], (k, d, d)."""
    d = lever.shape[1]
    result = turning_mobility(lever, axes_of(positions) if d == 3 else None, inverse_mass[:, d:])
    result[:, range(d), range(d)] += inverse_mass[:, :d]
    return result


class LinksAtPoints(NamedTuple):
    """Links at points; L of them between k ends."""

    normal: np.ndarray
    """(L, d)."""
    distance: np.ndarray
    """Between the points, of a joint along the normal, with its sign [m], (L,)."""
    lever: np.ndarray
    """Of the ends [m], (k, d); zero where a point does not turn with its body."""
    block: np.ndarray
    """Mobility of both ends together [1/kg], (L, d, d)."""
    coupling: np.ndarray
    """Entry of W between a link and the next one [1/kg], (L,)."""


def detect_at_points(
    chain: ChainTable,
    start: int,
    first_slot: int,
    bodies: np.ndarray,
    inverse_mass: np.ndarray,
    lattice: Lattice | None,
    result: Interactions,
) -> None:
    """Write the links of a chain, or of joints, at points of bodies, from the row ``start`` on; see ``detect_links``."""
    assert chain.points is not None
    rows, d, count = chain.bodies, chain.points.offset.shape[1], chain.link_count
    positions = bodies[rows]
    offset = offsets_in_space(chain.points, positions)
    find = of_joints if isinstance(chain, JointTable) else of_chain
    edges = None if lattice is None else lattice.edges(bodies)
    found = find(chain, offset, positions, inverse_mass[rows], lattice, edges)
    part, (a, c) = slice(start, start + count), chain.ends
    frame = local_frames(found.normal)
    result.candidate[part], result.antagonist[part] = rows[c], rows[a]
    result.gap[part] = found.distance - chain.radius_sum
    result.normal[part], result.coupling[part] = found.normal, found.coupling
    result.delassus[part] = np.einsum("kei,kij,kej->ke", frame, found.block, frame)
    result.slot[part] = first_slot + np.arange(count)
    ends = np.stack([found.lever[c], found.lever[a]], axis=1)
    if d == 3:
        result.tangent[part] = frame[:, 1]
        result.arm[part] = 0.0
        result.shear[part] = 0.0
        if len(result.lever):
            result.lever[part] = ends.reshape(-1, 6)
        return
    # distance along the normal towards the other body, and tangential coordinate of the point
    result.arm[part] = np.einsum("kej,kj->ke", ends, found.normal) * [-1.0, 1.0]
    if len(result.lateral):
        result.lateral[part] = np.einsum("kej,kj->ke", ends, frame[:, 1])


def of_chain(
    chain: ChainTable,
    offset: np.ndarray,
    positions: np.ndarray,
    inverse_mass: np.ndarray,
    lattice: Lattice | None,
    edges: np.ndarray | None,
) -> LinksAtPoints:
    """The links of a chain whose points have these offsets from the centres (k, d)."""
    assert chain.points is not None
    d = offset.shape[1]
    place = positions[:, :d] + offset
    if lattice is not None and edges is not None:
        place = lattice.course(place, edges)
    branch = np.diff(place, axis=0)
    distance = np.sqrt((branch * branch).sum(axis=1))
    upward = np.eye(d)[-1]
    normal = np.where(distance[:, None] > 0.0, branch / np.where(distance > 0.0, distance, 1.0)[:, None], upward)
    lever = np.where(chain.points.turns[:, None], offset, 0.0)
    K = mobility(lever, positions, inverse_mass)
    coupling = -np.einsum("ki,kij,kj->k", normal, K[1:], np.roll(normal, -1, axis=0))
    if not chain.closed:
        coupling[-1] = 0.0
    return LinksAtPoints(normal, distance, lever, K[:-1] + K[1:], coupling)


def of_joints(
    joints: ChainTable,
    offset: np.ndarray,
    positions: np.ndarray,
    inverse_mass: np.ndarray,
    lattice: Lattice | None,
    edges: np.ndarray | None,
) -> LinksAtPoints:
    """The links of joints whose points have these offsets from the centres (k, d)."""
    assert joints.points is not None
    d = offset.shape[1]
    place = positions[:, :d] + offset
    branch = place[1::2] - place[::2]
    if lattice is not None and edges is not None:
        branch = lattice.shortened(branch, edges)
    # both act half-way between the points, which are apart by an error of the step: no moment is left over
    half_way = offset + 0.5 * np.stack([branch, -branch], axis=1).reshape(-1, d)
    lever = np.where(joints.points.turns[:, None], half_way, 0.0)
    K = mobility(lever, positions, inverse_mass)
    block = K[::2] + K[1::2]
    coupling = block[:, range(d), np.roll(range(d), -1)]
    if d == 2:  # no ring: the second is the last
        coupling[:, 1] = 0.0
    normal = np.tile(np.eye(d), (len(block), 1))
    return LinksAtPoints(normal, branch.ravel(), lever, np.repeat(block, d, axis=0), coupling.ravel())
