"""Narrow phase in 3D: gap, local frame, levers and local block of W of every interaction; templates and kernels.

Contact points lie on the line along the normal through both centres. The tangent t is horizontal, ``n x z`` turned to
the left, unless n is steep: then it lies in the plane y z; so that in a scene in the plane x y the frame is that of 2D.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import kernel, row_reader
from lmgcpy.contact.narrow_phase import Interactions

narrow: Callable[..., Any] = Slot("narrow")
"""The pair's narrow phase, given by the specialisation, like the names below."""
read_position: Callable[..., Any] = row_reader(3)
read_shape_c: Callable[..., Any] = row_reader(1)
read_shape_a: Callable[..., Any] = row_reader(1)
FLIPPED = False
"""The candidate is the narrow phase's antagonist."""
STEEP = 0.8
"""Vertical part of a normal from which the tangent is taken in the plane y z."""


def tangent_of(n_x, n_y, n_z):
    """A unit vector at right angles to n."""
    if abs(n_z) <= STEEP:
        length = np.sqrt(n_x * n_x + n_y * n_y)
        return -n_y / length, n_x / length, 0.0
    length = np.sqrt(n_y * n_y + n_z * n_z)
    return 0.0, -n_z / length, n_y / length


def form(x, diagonal, y):
    """``x . D y``."""
    return x[0] * diagonal[0] * y[0] + x[1] * diagonal[1] * y[1] + x[2] * diagonal[2] * y[2]


def mobility(c, a, arm_c, arm_a, inverse_mass):
    """What two bodies yield to an impulse between them by moving along x, y, z, and by turning about them."""
    square_c = arm_c * arm_c
    square_a = arm_a * arm_a
    moving = (
        inverse_mass[c, 0] + inverse_mass[a, 0],
        inverse_mass[c, 1] + inverse_mass[a, 1],
        inverse_mass[c, 2] + inverse_mass[a, 2],
    )
    turning = (
        square_c * inverse_mass[c, 3] + square_a * inverse_mass[a, 3],
        square_c * inverse_mass[c, 4] + square_a * inverse_mass[a, 4],
        square_c * inverse_mass[c, 5] + square_a * inverse_mass[a, 5],
    )
    return moving, turning


def local_block(n, t, moving, turning):
    """The local block of W: its diagonal, W_nt, (W_ns, W_ts), and whether it is diagonal.

    With masses and inertias that are the same in all directions it is ``diag(w, w + l, w + l)``: l is what turning adds.

    Of what the interactions are it gets numbers only: handed over whole they are a hundred words, which the compiler
    pushed on the stack at every interaction, at twice the cost of all the rest.
    """
    if moving[0] == moving[1] == moving[2] and turning[0] == turning[1] == turning[2]:
        w = moving[0]
        return (w, w + turning[0], w + turning[0]), 0.0, (0.0, 0.0), True
    s = (n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0])
    w_nn = form(n, moving, n)
    w_tt = form(t, moving, t) + form(s, turning, s)
    w_ss = form(s, moving, s) + form(t, turning, t)
    if w_tt <= 0.0:  # held along a tangent: friction moves nothing, and any positive weight finds it
        w_tt = w_nn
    if w_ss <= 0.0:
        w_ss = w_nn
    return (w_nn, w_tt, w_ss), form(n, moving, t), (form(n, moving, s), form(t, moving, s) - form(s, turning, t)), False


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
            gap, (n_x, n_y, n_z), (p_x, p_y, p_z) = narrow(position_a, shape_a, position_c, shape_c)
            n_x = -n_x
            n_y = -n_y
            n_z = -n_z
        else:
            gap, (n_x, n_y, n_z), (p_x, p_y, p_z) = narrow(position_c, shape_c, position_a, shape_a)
        if gap > alert:
            continue
        c = body[k_c]
        a = body[k_a]
        # levers from the centres to the contact point along n, away from the centre
        arm_c = n_x * (bodies[c, 0] - p_x) + n_y * (bodies[c, 1] - p_y) + n_z * (bodies[c, 2] - p_z)
        arm_a = n_x * (p_x - bodies[a, 0]) + n_y * (p_y - bodies[a, 1]) + n_z * (p_z - bodies[a, 2])
        moving, turning = mobility(c, a, arm_c, arm_a, inverse_mass)
        n = (n_x, n_y, n_z)
        t = tangent_of(n_x, n_y, n_z)
        block, w_nt, shear, plain = local_block(n, t, moving, turning)
        if block[0] <= 0.0:  # neither can move along the normal: no impulse changes anything
            continue
        diagonal = diagonal and plain
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        for k in range(3):
            result.normal[m, k] = n[k]
            result.tangent[m, k] = t[k]
            result.delassus[m, k] = block[k]
        result.arm[m, 0] = arm_c
        result.arm[m, 1] = arm_a
        if result.shear.shape[0] > 0:
            result.coupling[m] = w_nt
            result.shear[m, 0] = shear[0]
            result.shear[m, 1] = shear[1]
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
        z = bodies[c, 2] - bodies[a, 2]
        distance = np.sqrt(x * x + y * y + z * z)
        n_x = 0.0
        n_y = 0.0
        n_z = 1.0
        if distance > 0.0:
            n_x = x / distance
            n_y = y / distance
            n_z = z / distance
        result.candidate[i] = c
        result.antagonist[i] = a
        result.gap[i] = distance - radius_sum[k]
        result.normal[i, 0] = n_x
        result.normal[i, 1] = n_y
        result.normal[i, 2] = n_z
        result.tangent[i, 0], result.tangent[i, 1], result.tangent[i, 2] = tangent_of(n_x, n_y, n_z)
        result.arm[i, 0] = 0.0  # it acts on the centres
        result.arm[i, 1] = 0.0
        n = (n_x, n_y, n_z)
        t = (result.tangent[i, 0], result.tangent[i, 1], result.tangent[i, 2])
        moving, _ = mobility(c, a, 0.0, 0.0, inverse_mass)
        result.delassus[i, 0] = form(n, moving, n)
        result.delassus[i, 1] = form(t, moving, t)
        result.delassus[i, 2] = moving[0] + moving[1] + moving[2] - result.delassus[i, 0] - result.delassus[i, 1]
        result.shear[i, 0] = 0.0
        result.shear[i, 1] = 0.0
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
                + result.normal[i, 2] * result.normal[j, 2] * inverse_mass[shared, 2]
            )
