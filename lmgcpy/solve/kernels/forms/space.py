"""The form of an interaction in space.

The contact point lies on the line along the normal through both centres, as it does for spheres, planes and cylinders
seen from inside: levers are ``-arm_c n`` and ``arm_a n``. With ``b = n x t`` for the second tangent s, the rows that meet
the velocities ``(v, spin)_c`` and ``(v, spin)_a`` are

    n:  (n,        0)  (-n,        0)
    t:  (t, -arm_c b)  (-t, -arm_a b)
    s:  (b,  arm_c t)  (-b,  arm_a t).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.frames import cross, local_frames

ROWS = 3
"""1 if the impulse is normal only."""
DIAGONAL = True
"""Whether all local blocks of W are diagonal."""
WALLS = -1
"""0 or 1 if the candidates or antagonists are held walls: other threads read their velocities, so no thread writes them."""
_of_three = small_matrices(3)
row, dot, multiple_row = _of_three["row"], _of_three["dot"], _of_three["multiple_row"]
plus_row, less_row = _of_three["plus_row"], _of_three["less_row"]


@inlined
def relative_velocity(i, s):
    """(u_n, u_t, u_s) of interaction ``i`` at the contact point, candidate minus antagonist."""
    return relative_velocity_for(s.velocity, i, s)


@inlined
def relative_velocity_for(velocity, i, s):
    """``H^T v`` of interaction ``i`` for velocities ``v`` of the bodies, (n, 6)."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n = row(s.normal, i, 0)
    v = less_row(row(velocity, c, 0), row(velocity, a, 0))
    if ROWS == 1:
        return dot(n, v), 0.0, 0.0
    t = row(s.tangent, i, 0)
    b = cross(n, t)
    # w = arm_c spin_c + arm_a spin_a: the contact point moves by v - w x n
    w = plus_row(multiple_row(s.arm[i, 0], row(velocity, c, 3)), multiple_row(s.arm[i, 1], row(velocity, a, 3)))
    return dot(n, v), dot(t, v) - dot(b, w), dot(b, v) + dot(t, w)


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n = row(s.normal, i, 0)
    # force d_n n + (d_t t + d_s b)
    force = multiple_row(d[0], n)
    if ROWS == 3:
        t = row(s.tangent, i, 0)
        b = cross(n, t)
        force = plus_row(force, plus_row(multiple_row(d[1], t), multiple_row(d[2], b)))
        # moments about both centres: -arm n x (d_t t + d_s b)
        moment = less_row(multiple_row(d[2], t), multiple_row(d[1], b))
        arm_c = s.arm[i, 0]
        arm_a = s.arm[i, 1]
        if WALLS != 0:
            for k in range(3):
                s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * (arm_c * moment[k])
        if WALLS != 1:
            for k in range(3):
                s.velocity[a, 3 + k] += s.inverse_mass[a, 3 + k] * (arm_a * moment[k])
    if WALLS != 0:
        for k in range(3):
            s.velocity[c, k] += s.inverse_mass[c, k] * force[k]
    if WALLS != 1:
        for k in range(3):
            s.velocity[a, k] -= s.inverse_mass[a, k] * force[k]


def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    # u - W r, the diagonal of W first, then its couplings
    w_nn = s.delassus[i, 0]
    w_tt = s.delassus[i, 1]
    w_ss = s.delassus[i, 2]
    w_nt = 0.0
    w_ns = 0.0
    w_ts = 0.0
    free_n = u[0] - w_nn * r[0]
    free_t = u[1] - w_tt * r[1]
    free_s = u[2] - w_ss * r[2]
    if not DIAGONAL:
        w_nt = s.coupling[i]
        w_ns = s.shear[i, 0]
        w_ts = s.shear[i, 1]
        free_n -= w_nt * r[1] + w_ns * r[2]
        free_t -= w_nt * r[0] + w_ts * r[2]
        free_s -= w_ns * r[0] + w_ts * r[1]
    return ((w_nn, w_nt, w_ns), (w_nt, w_tt, w_ts), (w_ns, w_ts, w_ss)), (free_n, free_t, free_s)


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = row(s.impulse, i, 0)
        if r[0] == 0.0 and r[1] == 0.0 and r[2] == 0.0:
            continue
        c = s.candidate[i]
        a = s.antagonist[i]
        n = row(s.normal, i, 0)
        t = row(s.tangent, i, 0)
        b = cross(n, t)
        # (d_n n + d_t t) + d_s b, where push has d_n n + (d_t t + d_s b): one order for both would change round-off
        force = plus_row(plus_row(multiple_row(r[0], n), multiple_row(r[1], t)), multiple_row(r[2], b))
        moment = less_row(multiple_row(r[2], t), multiple_row(r[1], b))
        if walls != 0:
            for k in range(3):
                s.velocity[c, k] += force[k]
                s.velocity[c, 3 + k] += s.arm[i, 0] * moment[k]
        if walls != 1:
            for k in range(3):
                s.velocity[a, k] -= force[k]
                s.velocity[a, 3 + k] += s.arm[i, 1] * moment[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s) of some interactions for velocities of the bodies, into ``result`` (m, 3 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 12)."""
    frame = local_frames(s.normal[part])
    turned = np.zeros_like(frame)  # e x n, taken from the frame, where it is exact
    turned[:, 1], turned[:, 2] = -frame[:, 2], frame[:, 1]
    moment = s.arm[part, :, None, None] * turned[:, None]
    return np.concatenate([frame, moment[:, 0], -frame, moment[:, 1]], axis=2)
