"""Links of a chain, between centres: gap, local frame and blocks of W; one kernel for 2D and 3D."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import Kernel, kernel
from lmgcpy.contact.frames import tangent_of
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.narrow_phase import translation_block
from lmgcpy.contact.narrow_phase_3d import moves, weighted

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
