"""Narrow phase: gap, local frame, levers and local block of W of every interaction; templates and kernels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import kernel, row_reader


class Interactions(NamedTuple):
    """The interactions of a step; m of them (see :class:`lmgcpy.solve.system.System` for those not told here)."""

    candidate: np.ndarray
    antagonist: np.ndarray
    gap: np.ndarray
    """At the detection configuration [m], (m,)."""
    normal: np.ndarray
    tangent: np.ndarray
    arm: np.ndarray
    lateral: np.ndarray
    delassus: np.ndarray
    coupling: np.ndarray
    shear: np.ndarray
    slot: np.ndarray
    """Place of the interaction in the list of neighbours, ascending, (m,) int32."""

    def cut(self, count: int) -> Interactions:
        """The first ``count`` interactions, as views."""
        return Interactions(*(a[:count] for a in self))


def empty_interactions(capacity: int, central: bool, dimension: int, *, plain: bool = False) -> Interactions:
    """Room for so many interactions; ``central``: whether all contact points lie between the centres; ``plain``: whether
    there is nothing but contacts in 3D with diagonal blocks of W."""
    in_space = capacity if dimension == 3 else 0
    return Interactions(
        candidate=np.empty(capacity, np.uint32),
        antagonist=np.empty(capacity, np.uint32),
        gap=np.empty(capacity),
        normal=np.empty((capacity, dimension)),
        tangent=np.empty((in_space, 3)),
        arm=np.empty((capacity, 2)),
        lateral=np.zeros((0 if central else capacity, 2)),  # of links, which come first and do not write it
        delassus=np.empty((capacity, dimension)),
        coupling=np.empty(0 if plain else capacity),
        shear=np.empty((0 if plain else in_space, 2)),
        slot=np.empty(capacity, np.int32),
    )


narrow: Callable[..., Any] = Slot("narrow")
"""The pair's narrow phase, given by the specialisation, like the names below."""
read_position: Callable[..., Any] = row_reader(3)
read_shape_c: Callable[..., Any] = row_reader(1)
read_shape_a: Callable[..., Any] = row_reader(1)
FLIPPED = False
"""The candidate is the narrow phase's antagonist."""
CENTRAL = True


@kernel
def detect_contacts(
    pairs, first, first_slot, alert, contactors, body, shapes, stride, bodies, inverse_mass, result: Interactions
):
    """Narrow phase of one group: write interactions from row ``first`` on.

    Returns (row after the last, whether all local blocks of W are diagonal).
    """
    m = first
    diagonal = True
    for p in range(pairs.shape[0]):
        k_c = pairs[p, 0]
        k_a = pairs[p, 1]
        position_c = read_position(contactors, 3 * k_c)
        position_a = read_position(contactors, 3 * k_a)
        shape_c = read_shape_c(shapes, stride * k_c)
        shape_a = read_shape_a(shapes, stride * k_a)
        if FLIPPED:
            gap, (n_x, n_y), (p_x, p_y) = narrow(position_a, shape_a, position_c, shape_c)
            n_x = -n_x
            n_y = -n_y
        else:
            gap, (n_x, n_y), (p_x, p_y) = narrow(position_c, shape_c, position_a, shape_a)
        if gap > alert:
            continue
        c = body[k_c]
        a = body[k_a]
        inverse_c = inverse_mass[c, 2]
        inverse_a = inverse_mass[a, 2]
        # levers from the centres to the contact point, along n (away from the centre) and along t
        arm_c = n_x * (bodies[c, 0] - p_x) + n_y * (bodies[c, 1] - p_y)
        arm_a = n_x * (p_x - bodies[a, 0]) + n_y * (p_y - bodies[a, 1])
        x = inverse_mass[c, 0] + inverse_mass[a, 0]
        y = inverse_mass[c, 1] + inverse_mass[a, 1]
        w_nn = n_x * n_x * x + n_y * n_y * y
        w_tt = n_y * n_y * x + n_x * n_x * y + arm_c * arm_c * inverse_c + arm_a * arm_a * inverse_a
        w_nt = n_x * n_y * (y - x)
        if not CENTRAL:
            lateral_c = n_x * (p_y - bodies[c, 1]) - n_y * (p_x - bodies[c, 0])
            lateral_a = n_x * (p_y - bodies[a, 1]) - n_y * (p_x - bodies[a, 0])
            result.lateral[m, 0] = lateral_c
            result.lateral[m, 1] = lateral_a
            w_nn += lateral_c * lateral_c * inverse_c + lateral_a * lateral_a * inverse_a
            w_nt += arm_c * lateral_c * inverse_c - arm_a * lateral_a * inverse_a
        elif result.lateral.shape[0] > 0:  # other groups need it, and the arrays are used again
            result.lateral[m, 0] = 0.0
            result.lateral[m, 1] = 0.0
        if w_nn <= 0.0:  # neither can move along the normal: no impulse changes anything
            continue
        if w_tt <= 0.0:  # held along the tangent: friction moves nothing, and any positive weight finds it
            w_tt = w_nn
        if w_nt != 0.0:
            diagonal = False
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        result.normal[m, 0] = n_x
        result.normal[m, 1] = n_y
        result.arm[m, 0] = arm_c
        result.arm[m, 1] = arm_a
        result.delassus[m, 0] = w_nn
        result.delassus[m, 1] = w_tt
        result.coupling[m] = w_nt
        result.slot[m] = first_slot + p
        m += 1
    return m, diagonal


@kernel
def detect_links(chain, radius_sum, first, first_slot, bodies, inverse_mass, result: Interactions):
    """Links of one chain, between centres; ``coupling`` is the entry of W between a link and the next one."""
    count = radius_sum.shape[0]
    for k in range(count):
        i = first + k
        a = chain[k]
        c = chain[k + 1]
        x = bodies[c, 0] - bodies[a, 0]
        y = bodies[c, 1] - bodies[a, 1]
        distance = np.sqrt(x * x + y * y)
        n_x = 0.0
        n_y = 1.0
        if distance > 0.0:
            n_x = x / distance
            n_y = y / distance
        result.candidate[i] = c
        result.antagonist[i] = a
        result.gap[i] = distance - radius_sum[k]
        result.normal[i, 0] = n_x
        result.normal[i, 1] = n_y
        result.arm[i, 0] = 0.0  # it acts on the centres
        result.arm[i, 1] = 0.0
        moving_x = inverse_mass[c, 0] + inverse_mass[a, 0]
        moving_y = inverse_mass[c, 1] + inverse_mass[a, 1]
        result.delassus[i, 0] = n_x * n_x * moving_x + n_y * n_y * moving_y
        result.delassus[i, 1] = n_y * n_y * moving_x + n_x * n_x * moving_y
        result.slot[i] = first_slot + k
    closed = chain[0] == chain[count]
    for k in range(count):
        i = first + k
        j = first if k == count - 1 else i + 1
        shared = chain[k + 1]
        if k == count - 1 and not closed:
            result.coupling[i] = 0.0
        else:
            result.coupling[i] = -(
                result.normal[i, 0] * result.normal[j, 0] * inverse_mass[shared, 0]
                + result.normal[i, 1] * result.normal[j, 1] * inverse_mass[shared, 1]
            )


@kernel
def place_contactors(bodies, body, offset, result):
    """Positions (x, y, angle) of the contactors from those of their bodies."""
    for k in range(body.shape[0]):
        b = body[k]
        cosine = np.cos(bodies[b, 2])
        sine = np.sin(bodies[b, 2])
        result[k, 0] = bodies[b, 0] + cosine * offset[k, 0] - sine * offset[k, 1]
        result[k, 1] = bodies[b, 1] + sine * offset[k, 0] + cosine * offset[k, 1]
        result[k, 2] = bodies[b, 2]


@kernel
def farthest(positions, before, dimension):
    """Square of the largest displacement."""
    largest = 0.0
    for i in range(positions.shape[0]):
        x = positions[i, 0] - before[i, 0]
        y = positions[i, 1] - before[i, 1]
        z = positions[i, 2] - before[i, 2] if dimension == 3 else 0.0
        largest = max(largest, x * x + y * y + z * z)
    return largest
