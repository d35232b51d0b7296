"""One interaction as a block of Gauss-Seidel: templates, specialised for a law's ``react`` (``lmgcpy.compiled.kernel``).

With the relative velocity ``u`` under the present impulses, the free velocity of one interaction is ``u - W r``; the law
gives the new impulse; the bodies' velocities follow at once. Names in capitals are constants of the specialisation, so
that a contact between disks pays for nothing that only other shapes need.
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
ROWS = 2
"""1 where the impulse is normal only."""
CENTRAL = True
"""Whether the contact point lies on the line along the normal through both centres."""
DIAGONAL = True
"""Whether all local blocks of W are diagonal."""
WALLS = -1
"""0 or 1 where the candidates or antagonists are held walls, which other threads see and nobody writes to."""


def relative_velocity(i, s):
    """(u_n, u_t) of interaction ``i`` at the contact point, candidate minus antagonist."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    v_x = s.velocity[c, 0] - s.velocity[a, 0]
    v_y = s.velocity[c, 1] - s.velocity[a, 1]
    u_n = n_x * v_x + n_y * v_y
    if ROWS == 1 and CENTRAL:
        return u_n, 0.0
    spin_c = s.velocity[c, 2]
    spin_a = s.velocity[a, 2]
    u_t = n_x * v_y - n_y * v_x - s.arm[i, 0] * spin_c - s.arm[i, 1] * spin_a
    if not CENTRAL:
        u_n += s.lateral[i, 1] * spin_a - s.lateral[i, 0] * spin_c
    return u_n, u_t


def push(i, s, d_n, d_t):
    """Add an impulse to interaction ``i``: +d on the candidate, -d on the antagonist, and to their velocities."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    d_x = n_x * d_n
    d_y = n_y * d_n
    if ROWS == 2:
        d_x -= n_y * d_t
        d_y += n_x * d_t
    if WALLS != 0:
        s.velocity[c, 0] += s.inverse_mass[c, 0] * d_x
        s.velocity[c, 1] += s.inverse_mass[c, 1] * d_y
        if not CENTRAL:
            s.velocity[c, 2] -= s.inverse_mass[c, 2] * (s.arm[i, 0] * d_t + s.lateral[i, 0] * d_n)
        elif ROWS == 2:
            s.velocity[c, 2] -= s.inverse_mass[c, 2] * s.arm[i, 0] * d_t
    if WALLS != 1:
        s.velocity[a, 0] -= s.inverse_mass[a, 0] * d_x
        s.velocity[a, 1] -= s.inverse_mass[a, 1] * d_y
        if not CENTRAL:
            s.velocity[a, 2] += s.inverse_mass[a, 2] * (s.lateral[i, 1] * d_n - s.arm[i, 1] * d_t)
        elif ROWS == 2:
            s.velocity[a, 2] -= s.inverse_mass[a, 2] * s.arm[i, 1] * d_t


def normal_velocity(i, s):
    """u_n of link ``i``."""
    return relative_velocity(i, s)[0]


def push_normal(i, s, d):
    """Add a normal impulse to link ``i``."""
    push(i, s, d, 0.0)


def push_row(i, s, d):
    """Add the impulse (d_n, d_t), the first numbers of an array, to link ``i``."""
    push(i, s, d[0], d[1])


def sweep(start, stop, offset, s: System):
    """Update the impulses of a group one after another."""
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)  # an unsigned index is not tested for counting from the end: gains 10 %
        u_n, u_t = relative_velocity(i, s)
        w_nn = s.delassus[i, 0]
        r_n = s.impulse[i, 0]
        if ROWS == 1:
            if w_nn == 0.0:  # a link between bodies that are both held
                continue
            (new_n,) = react(((w_nn,),), (u_n - w_nn * r_n,), prepared)
            if new_n != r_n:
                s.impulse[i, 0] = new_n
                push(i, s, new_n - r_n, 0.0)
        else:
            w_tt = s.delassus[i, 1]
            r_t = s.impulse[i, 1]
            free_n = u_n - w_nn * r_n
            free_t = u_t - w_tt * r_t
            w_nt = 0.0
            if not DIAGONAL:
                w_nt = s.coupling[i]
                free_n -= w_nt * r_t
                free_t -= w_nt * r_n
            new_n, new_t = react(((w_nn, w_nt), (w_nt, w_tt)), (free_n, free_t), prepared)
            if new_n != r_n or new_t != r_t:
                s.impulse[i, 0] = new_n
                s.impulse[i, 1] = new_t
                push(i, s, new_n - r_n, new_t - r_t)
    return 0.0


def error(start, stop, offset, s: System):
    """Sum of squares of ``e = w (r - react(w I, u - w r))`` over a group [m^2/s^2], w the mean diagonal of its W; the
    squares are left in ``s.squared_error``."""
    total = 0.0
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        u_n, u_t = relative_velocity(i, s)
        r_n = s.impulse[i, 0]
        if ROWS == 1:
            w = s.delassus[i, 0]
            if w == 0.0:
                s.squared_error[i] = 0.0
                continue
            (new_n,) = react(((w,),), (u_n - w * r_n,), prepared)
            square = (w * (r_n - new_n)) ** 2
        else:
            w = 0.5 * (s.delassus[i, 0] + s.delassus[i, 1])
            r_t = s.impulse[i, 1]
            new_n, new_t = react(((w, 0.0), (0.0, w)), (u_n - w * r_n, u_t - w * r_t), prepared)
            square = (w * (r_n - new_n)) ** 2 + (w * (r_t - new_t)) ** 2
        s.squared_error[i] = square
        total += square
    return total


def momentum(start, stop, walls, s, result):
    """Add ``H r``, what the impulses of some interactions give to the bodies [N s, N m s], to ``result`` (n, 3); not to
    candidates (``walls`` 0) or antagonists (1) that are held walls."""
    for i in range(start, stop):
        c = s.candidate[i]
        a = s.antagonist[i]
        r_n = s.impulse[i, 0]
        r_t = s.impulse[i, 1]
        if r_n == 0.0 and r_t == 0.0:
            continue
        x = s.normal[i, 0] * r_n - s.normal[i, 1] * r_t
        y = s.normal[i, 1] * r_n + s.normal[i, 0] * r_t
        spin_c = -s.arm[i, 0] * r_t
        spin_a = -s.arm[i, 1] * r_t
        if s.lateral.shape[0] > 0:
            spin_c -= s.lateral[i, 0] * r_n
            spin_a += s.lateral[i, 1] * r_n
        if walls != 0:
            result[c, 0] += x
            result[c, 1] += y
            result[c, 2] += spin_c
        if walls != 1:
            result[a, 0] -= x
            result[a, 1] -= y
            result[a, 2] += spin_a


def relative_velocities(s, velocity, result):
    """(u_n, u_t) of every interaction for the velocities of the bodies, into ``result`` (m, 2)."""
    for i in range(s.candidate.shape[0]):
        c = s.candidate[i]
        a = s.antagonist[i]
        x = velocity[c, 0] - velocity[a, 0]
        y = velocity[c, 1] - velocity[a, 1]
        spin_c = velocity[c, 2]
        spin_a = velocity[a, 2]
        u_n = s.normal[i, 0] * x + s.normal[i, 1] * y
        if s.lateral.shape[0] > 0:
            u_n += s.lateral[i, 1] * spin_a - s.lateral[i, 0] * spin_c
        result[i, 0] = u_n
        result[i, 1] = s.normal[i, 0] * y - s.normal[i, 1] * x - s.arm[i, 0] * spin_c - s.arm[i, 1] * spin_a
