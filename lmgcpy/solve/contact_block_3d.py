"""One interaction in 3D as a block of Gauss-Seidel: templates, as ``contact_block`` has them for 2D.

The contact point lies on the line along the normal through both centres, as it does for spheres, planes and cylinders
seen from inside: levers are ``-arm_c n`` and ``arm_a n``, and with ``w = arm_c spin_c + arm_a spin_a`` the relative
velocity at the contact point is ``v_c - v_a - w x n``: in the frame (n, t, s = n x t)

    u_n = n . v,    u_t = t . v - s . w,    u_s = s . v + t . w.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.solve.system import System

react: Callable[..., Any] = Slot("react")  # given by the specialisation
"""The law."""
read: Callable[..., Any] = Slot("read")
"""Reader of one row of prepared numbers."""
PREPARED = 0
"""How many numbers the law prepares."""
ROWS = 3
"""1 where the impulse is normal only."""
DIAGONAL = True
"""Whether all local blocks of W are diagonal."""
WALLS = -1
"""0 or 1 where the candidates or antagonists are held walls, which other threads see and nobody writes to."""


def cross(n_x, n_y, n_z, t_x, t_y, t_z):
    """``n x t``."""
    return n_y * t_z - n_z * t_y, n_z * t_x - n_x * t_z, n_x * t_y - n_y * t_x


def relative_velocity(i, s):
    """(u_n, u_t, u_s) of interaction ``i`` at the contact point, candidate minus antagonist."""
    return relative_velocity_for(s.velocity, i, s)


def relative_velocity_for(velocity, i, s):
    """The same for other velocities of the bodies, (n, 6)."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    n_z = s.normal[i, 2]
    v_x = velocity[c, 0] - velocity[a, 0]
    v_y = velocity[c, 1] - velocity[a, 1]
    v_z = velocity[c, 2] - velocity[a, 2]
    u_n = n_x * v_x + n_y * v_y + n_z * v_z
    if ROWS == 1:
        return u_n, 0.0, 0.0
    arm_c = s.arm[i, 0]
    arm_a = s.arm[i, 1]
    w_x = arm_c * velocity[c, 3] + arm_a * velocity[a, 3]
    w_y = arm_c * velocity[c, 4] + arm_a * velocity[a, 4]
    w_z = arm_c * velocity[c, 5] + arm_a * velocity[a, 5]
    t_x = s.tangent[i, 0]
    t_y = s.tangent[i, 1]
    t_z = s.tangent[i, 2]
    s_x, s_y, s_z = cross(n_x, n_y, n_z, t_x, t_y, t_z)
    u_t = t_x * v_x + t_y * v_y + t_z * v_z - (s_x * w_x + s_y * w_y + s_z * w_z)
    u_s = s_x * v_x + s_y * v_y + s_z * v_z + (t_x * w_x + t_y * w_y + t_z * w_z)
    return u_n, u_t, u_s


def push(i, s, d_n, d_t, d_s):
    """Add an impulse to interaction ``i``: +d on the candidate, -d on the antagonist, and to their velocities."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    n_z = s.normal[i, 2]
    d_x = n_x * d_n
    d_y = n_y * d_n
    d_z = n_z * d_n
    if ROWS == 3:
        t_x = s.tangent[i, 0]
        t_y = s.tangent[i, 1]
        t_z = s.tangent[i, 2]
        s_x, s_y, s_z = cross(n_x, n_y, n_z, t_x, t_y, t_z)
        d_x += t_x * d_t + s_x * d_s
        d_y += t_y * d_t + s_y * d_s
        d_z += t_z * d_t + s_z * d_s
        # moments about both centres: -arm n x (t d_t + s d_s)
        m_x = t_x * d_s - s_x * d_t
        m_y = t_y * d_s - s_y * d_t
        m_z = t_z * d_s - s_z * d_t
        arm_c = s.arm[i, 0]
        arm_a = s.arm[i, 1]
        if WALLS != 0:
            s.velocity[c, 3] += s.inverse_mass[c, 3] * (arm_c * m_x)
            s.velocity[c, 4] += s.inverse_mass[c, 4] * (arm_c * m_y)
            s.velocity[c, 5] += s.inverse_mass[c, 5] * (arm_c * m_z)
        if WALLS != 1:
            s.velocity[a, 3] += s.inverse_mass[a, 3] * (arm_a * m_x)
            s.velocity[a, 4] += s.inverse_mass[a, 4] * (arm_a * m_y)
            s.velocity[a, 5] += s.inverse_mass[a, 5] * (arm_a * m_z)
    if WALLS != 0:
        s.velocity[c, 0] += s.inverse_mass[c, 0] * d_x
        s.velocity[c, 1] += s.inverse_mass[c, 1] * d_y
        s.velocity[c, 2] += s.inverse_mass[c, 2] * d_z
    if WALLS != 1:
        s.velocity[a, 0] -= s.inverse_mass[a, 0] * d_x
        s.velocity[a, 1] -= s.inverse_mass[a, 1] * d_y
        s.velocity[a, 2] -= s.inverse_mass[a, 2] * d_z


def sweep(start, stop, offset, s: System):
    """Update the impulses of a group one after another."""
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        u_n, u_t, u_s = relative_velocity(i, s)
        w_nn = s.delassus[i, 0]
        r_n = s.impulse[i, 0]
        if ROWS == 1:
            if w_nn == 0.0:  # a link between bodies that are both held
                continue
            (new_n,) = react(((w_nn,),), (u_n - w_nn * r_n,), prepared)
            if new_n != r_n:
                s.impulse[i, 0] = new_n
                push(i, s, new_n - r_n, 0.0, 0.0)
        else:
            w_tt = s.delassus[i, 1]
            w_ss = s.delassus[i, 2]
            r_t = s.impulse[i, 1]
            r_s = s.impulse[i, 2]
            free_n = u_n - w_nn * r_n
            free_t = u_t - w_tt * r_t
            free_s = u_s - w_ss * r_s
            w_nt = 0.0
            w_ns = 0.0
            w_ts = 0.0
            if not DIAGONAL:
                w_nt = s.coupling[i]
                w_ns = s.shear[i, 0]
                w_ts = s.shear[i, 1]
                free_n -= w_nt * r_t + w_ns * r_s
                free_t -= w_nt * r_n + w_ts * r_s
                free_s -= w_ns * r_n + w_ts * r_t
            block = ((w_nn, w_nt, w_ns), (w_nt, w_tt, w_ts), (w_ns, w_ts, w_ss))
            new_n, new_t, new_s = react(block, (free_n, free_t, free_s), prepared)
            if new_n != r_n or new_t != r_t or new_s != r_s:
                s.impulse[i, 0] = new_n
                s.impulse[i, 1] = new_t
                s.impulse[i, 2] = new_s
                push(i, s, new_n - r_n, new_t - r_t, new_s - r_s)
    return 0.0


def error(start, stop, offset, s: System):
    """Sum of squares of ``e = w (r - react(w I, u - w r))`` over a group [m^2/s^2], w the mean diagonal of its W; the
    squares are left in ``s.squared_error``."""
    total = 0.0
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        u_n, u_t, u_s = relative_velocity(i, s)
        r_n = s.impulse[i, 0]
        if ROWS == 1:
            w = s.delassus[i, 0]
            if w == 0.0:
                s.squared_error[i] = 0.0
                continue
            (new_n,) = react(((w,),), (u_n - w * r_n,), prepared)
            square = (w * (r_n - new_n)) ** 2
        else:
            w = (s.delassus[i, 0] + s.delassus[i, 1] + s.delassus[i, 2]) / 3.0
            r_t = s.impulse[i, 1]
            r_s = s.impulse[i, 2]
            block = ((w, 0.0, 0.0), (0.0, w, 0.0), (0.0, 0.0, w))
            new_n, new_t, new_s = react(block, (u_n - w * r_n, u_t - w * r_t, u_s - w * r_s), prepared)
            square = (w * (r_n - new_n)) ** 2 + (w * (r_t - new_t)) ** 2 + (w * (r_s - new_s)) ** 2
        s.squared_error[i] = square
        total += square
    return total


def momentum(start, stop, walls, s, result):
    """Add ``H r``, what the impulses of some interactions give to the bodies [N s, N m s], to ``result`` (n, 6); not to
    candidates (``walls`` 0) or antagonists (1) that are held walls."""
    for i in range(start, stop):
        r_n = s.impulse[i, 0]
        r_t = s.impulse[i, 1]
        r_s = s.impulse[i, 2]
        if r_n == 0.0 and r_t == 0.0 and r_s == 0.0:
            continue
        c = s.candidate[i]
        a = s.antagonist[i]
        n_x = s.normal[i, 0]
        n_y = s.normal[i, 1]
        n_z = s.normal[i, 2]
        t_x = s.tangent[i, 0]
        t_y = s.tangent[i, 1]
        t_z = s.tangent[i, 2]
        s_x, s_y, s_z = cross(n_x, n_y, n_z, t_x, t_y, t_z)
        impulse = (
            n_x * r_n + t_x * r_t + s_x * r_s,
            n_y * r_n + t_y * r_t + s_y * r_s,
            n_z * r_n + t_z * r_t + s_z * r_s,
        )
        moment = (t_x * r_s - s_x * r_t, t_y * r_s - s_y * r_t, t_z * r_s - s_z * r_t)
        if walls != 0:
            for k in range(3):
                result[c, k] += impulse[k]
                result[c, 3 + k] += s.arm[i, 0] * moment[k]
        if walls != 1:
            for k in range(3):
                result[a, k] -= impulse[k]
                result[a, 3 + k] += s.arm[i, 1] * moment[k]


def relative_velocities(s, velocity, result):
    """(u_n, u_t, u_s) of every interaction for the velocities of the bodies, into ``result`` (m, 3)."""
    for i in range(s.candidate.shape[0]):
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def normal_velocity(i, s):
    """u_n of link ``i``."""
    c = s.candidate[i]
    a = s.antagonist[i]
    return (
        s.normal[i, 0] * (s.velocity[c, 0] - s.velocity[a, 0])
        + s.normal[i, 1] * (s.velocity[c, 1] - s.velocity[a, 1])
        + s.normal[i, 2] * (s.velocity[c, 2] - s.velocity[a, 2])
    )


def push_normal(i, s, d):
    """Add a normal impulse to link ``i``."""
    c = s.candidate[i]
    a = s.antagonist[i]
    d_x = s.normal[i, 0] * d
    d_y = s.normal[i, 1] * d
    d_z = s.normal[i, 2] * d
    s.velocity[c, 0] += s.inverse_mass[c, 0] * d_x
    s.velocity[c, 1] += s.inverse_mass[c, 1] * d_y
    s.velocity[c, 2] += s.inverse_mass[c, 2] * d_z
    s.velocity[a, 0] -= s.inverse_mass[a, 0] * d_x
    s.velocity[a, 1] -= s.inverse_mass[a, 1] * d_y
    s.velocity[a, 2] -= s.inverse_mass[a, 2] * d_z


def push_row(i, s, d):
    """Add the impulse (d_n, d_t, d_s), the first numbers of an array, to link ``i``."""
    push(i, s, d[0], d[1], d[2])
