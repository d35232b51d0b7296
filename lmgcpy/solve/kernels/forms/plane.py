"""The form of an interaction in the plane.

With the levers ``arm`` along the normal and ``lateral`` across it (:class:`lmgcpy.solve.kernels.system.System`), candidate
c and antagonist a, the rows that meet the velocities ``(v, spin)_c`` and ``(v, spin)_a`` are

    n:  ( n, -lateral_c)  (-n,  lateral_a)
    t:  ( t,     -arm_c)  (-t,     -arm_a)         t = (-n_y, n_x).

Names in capitals are constants of the specialisation, so that a contact between disks pays for nothing that only other
shapes need.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.contact.frames import local_frames

ROWS = 2
"""1 if the impulse is normal only."""
CENTRAL = True
"""Whether the contact point lies on the line along the normal through both centres."""
DIAGONAL = True
"""Whether all local blocks of W are diagonal."""
WALLS = -1
"""0 or 1 if the candidates or antagonists are held walls: other threads read their velocities, so no thread writes them."""


def relative_velocity(i, s):
    """(u_n, u_t) of interaction ``i`` at the contact point, candidate minus antagonist."""
    return relative_velocity_for(s.velocity, i, s, CENTRAL)


def relative_velocity_for(velocity, i, s, central):
    """``H^T v`` of interaction ``i`` for velocities ``v`` of the bodies, (n, 3)."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    v_x = velocity[c, 0] - velocity[a, 0]
    v_y = velocity[c, 1] - velocity[a, 1]
    # centres: n . v and t . v; then the spins by their levers
    u_n = n_x * v_x + n_y * v_y
    if ROWS == 1 and central:
        return u_n, 0.0
    spin_c = velocity[c, 2]
    spin_a = velocity[a, 2]
    u_t = n_x * v_y - n_y * v_x - s.arm[i, 0] * spin_c - s.arm[i, 1] * spin_a
    if not central:
        u_n += s.lateral[i, 1] * spin_a - s.lateral[i, 0] * spin_c
    return u_n, u_t


def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    add_impulse(s.velocity, i, s, d, WALLS, CENTRAL, True)


def add_impulse(result, i, s, d, walls, central, weighed):
    """Add ``H d`` of interaction ``i`` to ``result`` (n, 3): +d on the candidate, -d on the antagonist; ``M^-1 H d`` if it
    is ``weighed``."""
    c = s.candidate[i]
    a = s.antagonist[i]
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    # force d_n n + d_t t, then its moments about both centres
    d_x = n_x * d[0]
    d_y = n_y * d[0]
    if ROWS == 2:
        d_x -= n_y * d[1]
        d_y += n_x * d[1]
    if walls != 0:
        result[c, 0] += share(s, c, 0, weighed) * d_x
        result[c, 1] += share(s, c, 1, weighed) * d_y
        if not central:
            result[c, 2] -= share(s, c, 2, weighed) * (s.arm[i, 0] * d[1] + s.lateral[i, 0] * d[0])
        elif ROWS == 2:
            result[c, 2] -= share(s, c, 2, weighed) * s.arm[i, 0] * d[1]
    if walls != 1:
        result[a, 0] -= share(s, a, 0, weighed) * d_x
        result[a, 1] -= share(s, a, 1, weighed) * d_y
        if not central:
            result[a, 2] += share(s, a, 2, weighed) * (s.lateral[i, 1] * d[0] - s.arm[i, 1] * d[1])
        elif ROWS == 2:
            result[a, 2] -= share(s, a, 2, weighed) * s.arm[i, 1] * d[1]


def share(s, body, component, weighed):
    """Inverse mass, or inertia, of a component of a body; 1 where nothing is ``weighed``."""
    return s.inverse_mass[body, component] if weighed else 1.0


def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    # u - W r, the diagonal of W first, then its coupling
    w_nn = s.delassus[i, 0]
    w_tt = s.delassus[i, 1]
    w_nt = 0.0
    free_n = u[0] - w_nn * r[0]
    free_t = u[1] - w_tt * r[1]
    if not DIAGONAL:
        w_nt = s.coupling[i]
        free_n -= w_nt * r[1]
        free_t -= w_nt * r[0]
    return ((w_nn, w_nt), (w_nt, w_tt)), (free_n, free_t)


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = s.impulse[i, 0], s.impulse[i, 1]
        if r[0] != 0.0 or r[1] != 0.0:
            add_impulse(s.velocity, i, s, r, walls, CENTRAL, False)
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t) of some interactions for velocities of the bodies, into ``result`` (m, 2 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1] = relative_velocity_for(velocity, i, s, CENTRAL)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 2, 6)."""
    frame = local_frames(s.normal[part])
    moment = np.zeros((2, len(frame), 2, 1))
    moment[:, :, 1, 0] = -s.arm[part].T
    if len(s.lateral):
        moment[:, :, 0, 0] = s.lateral[part].T * [[-1.0], [1.0]]
    return np.concatenate([frame, moment[0], -frame, moment[1]], axis=2)
