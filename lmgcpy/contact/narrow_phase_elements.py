"""Narrow phase of contacts in 2D and 3D of which at least one side is an element (:mod:`lmgcpy.contact.elements`).

Levers, weights and the local block of W are those of the forms ``elements_in_plane`` and ``elements_in_space``. The body of
an element is the one at the corner with the largest weight.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import kernel
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.elements import Elements
from lmgcpy.contact.frames import cross, tangent_of
from lmgcpy.contact.meeting import FOREIGN, is_sound, meet, normal_sign
from lmgcpy.contact.narrow_phase_3d import weighted
from lmgcpy.contact.positions import quaternion_of, turned_back

D = 2
"""Dimension, given by the specialisation like the names below."""
CANDIDATE = 1
"""Number of bodies of the candidate; 1: no element."""
ANTAGONIST = 1
dot: Callable[..., Any] = Slot("dot")
row: Callable[..., Any] = Slot("row")
less_row: Callable[..., Any] = Slot("less_row")
plus_row: Callable[..., Any] = Slot("plus_row")
multiple_row: Callable[..., Any] = Slot("multiple_row")
scaled_row: Callable[..., Any] = Slot("scaled_row")
VECTORS = ("dot", "row", "less_row", "plus_row", "multiple_row", "scaled_row")
"""Functions of vectors; the specialisation gives those of the dimension."""
frame_of: Callable[..., Any] = Slot("frame_of")
"""``n``: the vectors n, t(, s)."""
moment_block: Callable[..., Any] = Slot("moment_block")
"""``(b, lever, e, f, bodies, inverse_mass)``: entry of W of the spin of body ``b`` between rows along e and f."""


def frame_in_plane(n):
    return n, (-n[1], n[0])


def frame_in_space(n):
    t = tangent_of(n[0], n[1], n[2])
    return n, t, cross(n, t)


def moment_in_plane(b, lever, e, f, bodies, inverse_mass):
    m_e = lever[0] * e[1] - lever[1] * e[0]
    m_f = lever[0] * f[1] - lever[1] * f[0]
    return m_e * inverse_mass[b, 2] * m_f


def moment_in_space(b, lever, e, f, bodies, inverse_mass):
    return weighted(cross(lever, e), easy(b, inverse_mass), cross(lever, f))


def moment_on_turned(b, lever, e, f, bodies, inverse_mass):
    """Spins are along the own axes of bodies that keep a rotation."""
    q = quaternion_of(bodies, b)
    return weighted(turned_back(q, cross(lever, e)), easy(b, inverse_mass), turned_back(q, cross(lever, f)))


def easy(b, inverse_mass):
    """Inverse inertias of a body."""
    return inverse_mass[b, 3], inverse_mass[b, 4], inverse_mass[b, 5]


@kernel
def detect_contacts(
    pairs, first, first_slot, alert, contactors, body, shapes, stride, bodies, inverse_mass, elements: Elements, result
):
    """Narrow phase of one group: write interactions from row ``first`` on; arguments and answer as in ``narrow_phase``."""
    m = first
    diagonal = True
    for p in range(pairs.shape[0]):
        k_c = pairs[p, 0]
        k_a = pairs[p, 1]
        gap, n, point = meet(k_c, k_a, contactors, shapes, stride)
        if FOREIGN and not is_sound(gap, n):
            return -1 - p, False
        if gap > alert:
            continue
        frame = frame_of(multiple_row(normal_sign(), n))
        # corners of the candidate first; a side that is one body has a lever
        c = body[k_c]
        a = body[k_a]
        for k in range(result.weight.shape[1]):
            result.weight[m, k] = 0.0
        used = 0
        lever_c = point
        lever_a = point
        if CANDIDATE > 1:
            c, lever_c = write_corners(m, 0, 1.0, CANDIDATE, k_c, frame, point, elements, result)
            used = CANDIDATE
        else:
            lever_c = less_row(point, row(bodies, c, 0))
        if ANTAGONIST > 1:
            a, lever_a = write_corners(m, used, -1.0, ANTAGONIST, k_a, frame, point, elements, result)
            used += ANTAGONIST
        else:
            lever_a = less_row(point, row(bodies, a, 0))
        plain = True
        for e in range(D):
            for f in range(e, D):
                # W = H^T M^-1 H between the rows e and f of the frame
                w = 0.0
                if CANDIDATE == 1:
                    w += body_block(c, lever_c, frame[e], frame[f], bodies, inverse_mass)
                if ANTAGONIST == 1:
                    w += body_block(a, lever_a, frame[e], frame[f], bodies, inverse_mass)
                for k in range(used):
                    b = result.corner[m, k]
                    along_e, along_f = corner_row(m, k, e, frame, result), corner_row(m, k, f, frame, result)
                    w += weighted_by(row(inverse_mass, b, 0), along_e, along_f)
                if e == f:
                    result.delassus[m, e] = w
                else:
                    plain = plain and w == 0.0
                    if e == 0 and f == 1:
                        result.coupling[m] = w
                    else:
                        result.shear[m, e + f - 2] = w
        if result.delassus[m, 0] <= 0.0:  # neither side can move along the normal: no impulse changes anything
            continue
        for e in range(1, D):
            if result.delassus[m, e] <= 0.0:  # both are held along a tangent: any positive weight gives friction
                result.delassus[m, e] = result.delassus[m, 0]
        diagonal = diagonal and plain
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        result.arm[m, 0] = -dot(frame[0], lever_c)
        result.arm[m, 1] = dot(frame[0], lever_a)
        for k in range(D):
            result.normal[m, k] = frame[0][k]
        if D == 2:
            result.lateral[m, 0] = dot(frame[1], lever_c)
            result.lateral[m, 1] = dot(frame[1], lever_a)
        else:
            for k in range(D):
                result.tangent[m, k] = frame[1][k]
                result.lever[m, k] = lever_c[k]
                result.lever[m, 3 + k] = lever_a[k]
        result.slot[m] = first_slot + p
        m += 1
    return m, diagonal


def body_block(b, lever, e, f, bodies, inverse_mass):
    """Entry of W of one body between rows along e and f: mass, then inertia."""
    return weighted_by(row(inverse_mass, b, 0), e, f) + moment_block(b, lever, e, f, bodies, inverse_mass)


def weighted_by(diagonal, x, y):
    """``x . D y`` with a diagonal matrix D."""
    return dot(x, scaled_row(diagonal, y))


def corner_row(m, k, e, frame, result):
    """Row ``e`` of H^T of corner ``k``: sign w n, or (sign w - rho G . n) t + rho (G . t) n."""
    at = (D + 1) * k
    if e == 0:
        return multiple_row(result.weight[m, at], frame[0])
    along = multiple_row(result.weight[m, at] + result.weight[m, at + 1], frame[e])
    return plus_row(along, multiple_row(result.weight[m, at + 1 + e], frame[0]))


def write_corners(m, first, sign, count, contactor, frame, point, elements, result):
    """Write the corners of a side and their numbers; returns the body at the nearest corner, and the contact point as seen
    from its centre."""
    element = elements.row[contactor]
    from_middle = less_row(point, row(elements.middle, element, 0))
    nearest = 0
    largest = -np.inf
    for k in range(count):
        gradient = row(elements.gradient, element, D * k)
        shift = elements.slope[element] * dot(gradient, from_middle)
        weight = elements.weight[element, k] + shift
        result.corner[m, first + k] = elements.corner[element, k]
        result.weight[m, (D + 1) * (first + k)] = sign * weight
        if weight > largest:
            largest = weight
            nearest = k
    rho = -sign * dot(frame[0], from_middle)  # p = x + rho m, m = -sign n
    for k in range(count):
        gradient = row(elements.gradient, element, D * k)
        at_k = (D + 1) * (first + k)
        result.weight[m, at_k + 1] = -rho * dot(gradient, frame[0])
        for e in range(1, D):
            result.weight[m, at_k + 1 + e] = rho * dot(gradient, frame[e])
    return elements.corner[element, nearest], less_row(point, row(elements.place, element, D * nearest))


def names_of(dimension: int, width: int, candidate: int, antagonist: int) -> dict[str, Any]:
    """Arguments for ``specialise``; ``width``: of a position; ``candidate``, ``antagonist``: number of their bodies."""
    in_plane = dimension == 2
    in_space = moment_in_space if width == 3 else moment_on_turned
    return {
        **{name: small_matrices(dimension)[name] for name in VECTORS},
        "frame_of": frame_in_plane if in_plane else frame_in_space,
        "moment_block": moment_in_plane if in_plane else in_space,
        "D": dimension,
        "CANDIDATE": candidate,
        "ANTAGONIST": antagonist,
    }
