"""The form of a contact with rolling friction in the plane.

A third row meets the spins alone, with the effective radius R of the two bodies for a lever:

    r:  (0, R)  (0, -R).

So the rolling velocity ``u_r = R (spin_c - spin_a)`` [m/s], the rolling impulse ``r_r`` [N s], the moment over R, and
its entries of W [1/kg] have the units of the other rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.solve.kernels.forms.plane import local_problem as plane_problem
from lmgcpy.solve.kernels.forms.plane import momentum as plane_momentum
from lmgcpy.solve.kernels.forms.plane import push as plane_push
from lmgcpy.solve.kernels.forms.plane import relative_velocities as plane_velocities
from lmgcpy.solve.kernels.forms.plane import relative_velocity as plane_velocity
from lmgcpy.solve.kernels.forms.plane import rows as plane_rows

CENTRAL = True
"""As in ``plane``, and so is what follows."""
WALLS = -1


def relative_velocity(i, s):
    """(u_n, u_t, u_r) of interaction ``i``, candidate minus antagonist."""
    u_n, u_t = plane_velocity(i, s)
    return u_n, u_t, s.rolling[i] * (s.velocity[s.candidate[i], 2] - s.velocity[s.antagonist[i], 2])


def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    plane_push(i, s, d)
    c = s.candidate[i]
    a = s.antagonist[i]
    moment = s.rolling[i] * d[2]
    if WALLS != 0:
        s.velocity[c, 2] += s.inverse_mass[c, 2] * moment
    if WALLS != 1:
        s.velocity[a, 2] -= s.inverse_mass[a, 2] * moment


def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    ((w_nn, w_nt), (_, w_tt)), (free_n, free_t) = plane_problem(i, s, u, r)
    # spins couple the rows: the levers of n and t with R, by the inverse inertias
    turn_c = s.rolling[i] * s.inverse_mass[s.candidate[i], 2]
    turn_a = s.rolling[i] * s.inverse_mass[s.antagonist[i], 2]
    w_rr = s.delassus[i, 2]
    w_tr = s.arm[i, 1] * turn_a - s.arm[i, 0] * turn_c
    w_nr = 0.0
    if not CENTRAL:
        w_nr = -s.lateral[i, 0] * turn_c - s.lateral[i, 1] * turn_a
    free_n -= w_nr * r[2]
    free_t -= w_tr * r[2]
    free_r = u[2] - w_nr * r[0] - w_tr * r[1] - w_rr * r[2]
    return ((w_nn, w_nt, w_nr), (w_nt, w_tt, w_tr), (w_nr, w_tr, w_rr)), (free_n, free_t, free_r)


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    plane_momentum(start, stop, walls, s)
    for i in range(start, stop):
        moment = s.rolling[i] * s.impulse[i, 2]
        if walls != 0:
            s.velocity[s.candidate[i], 2] += moment
        if walls != 1:
            s.velocity[s.antagonist[i], 2] -= moment
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_r) of some interactions for velocities of the bodies, into ``result`` (m, 3)."""
    plane_velocities(start, stop, s, velocity, result)
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 2] = s.rolling[i] * (velocity[s.candidate[i], 2] - velocity[s.antagonist[i], 2])


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 6)."""
    plain = plane_rows(s, part)
    turning = np.zeros((len(plain), 1, 6))
    turning[:, 0, 2], turning[:, 0, 5] = s.rolling[part], -s.rolling[part]
    return np.concatenate([plain, turning], axis=1)
