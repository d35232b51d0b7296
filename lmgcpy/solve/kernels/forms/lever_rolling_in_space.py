"""The form of a contact with rolling friction in space of bodies that turn.

Three more rows meet the spins alone, as in ``rolling_in_space``: about ``b = n x t``, ``-t`` and n, with the effective
radius R for a lever. The detection turns these axes into the axes of the bodies (``System.moment``, from column 18 on).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.solve.kernels.forms.lever_in_space import local_problem as plain_problem
from lmgcpy.solve.kernels.forms.lever_in_space import momentum as plain_momentum
from lmgcpy.solve.kernels.forms.lever_in_space import push as plain_push
from lmgcpy.solve.kernels.forms.lever_in_space import relative_velocities as plain_velocities
from lmgcpy.solve.kernels.forms.lever_in_space import relative_velocity as plain_velocity
from lmgcpy.solve.kernels.forms.lever_in_space import rows as plain_rows
from lmgcpy.solve.kernels.small_matrices import small_matrices

WALLS = -1
"""As in ``space``."""
_of_three = small_matrices(3)
row, dot, multiple_row = _of_three["row"], _of_three["dot"], _of_three["multiple_row"]
plus_row, scaled_row = _of_three["plus_row"], _of_three["scaled_row"]


@inlined
def rolling_velocity(velocity, i, s):
    """(u_1, u_2, u_z) of interaction ``i`` for velocities of the bodies, (n, 6)."""
    spin_c = row(velocity, s.candidate[i], 3)
    spin_a = row(velocity, s.antagonist[i], 3)
    lever = s.rolling[i]
    return (
        lever * (dot(row(s.moment, i, 18), spin_c) + dot(row(s.moment, i, 27), spin_a)),
        lever * (dot(row(s.moment, i, 21), spin_c) + dot(row(s.moment, i, 30), spin_a)),
        lever * (dot(row(s.moment, i, 24), spin_c) + dot(row(s.moment, i, 33), spin_a)),
    )


@inlined
def rolling_moment(i, s, r_1, r_2, r_z, side):
    """Moment of rolling impulses on the candidate (``side`` 0) or the antagonist (1), along its own axes."""
    at = 18 + 9 * side
    sum_ = plus_row(multiple_row(r_1, row(s.moment, i, at)), multiple_row(r_2, row(s.moment, i, at + 3)))
    return multiple_row(s.rolling[i], plus_row(sum_, multiple_row(r_z, row(s.moment, i, at + 6))))


@inlined
def relative_velocity(i, s):
    """(u_n, u_t, u_s, u_1, u_2, u_z) of interaction ``i``, candidate minus antagonist."""
    u_n, u_t, u_s = plain_velocity(i, s)
    u_1, u_2, u_z = rolling_velocity(s.velocity, i, s)
    return u_n, u_t, u_s, u_1, u_2, u_z


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    plain_push(i, s, (d[0], d[1], d[2]))
    if WALLS != 0:
        c = s.candidate[i]
        moment = rolling_moment(i, s, d[3], d[4], d[5], 0)
        for k in range(3):
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * moment[k]
    if WALLS != 1:
        a = s.antagonist[i]
        moment = rolling_moment(i, s, d[3], d[4], d[5], 1)
        for k in range(3):
            s.velocity[a, 3 + k] += s.inverse_mass[a, 3 + k] * moment[k]


@inlined
def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    given = (u[0], u[1], u[2]), (r[0], r[1], r[2])
    ((w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss)), (free_n, free_t, free_s) = plain_problem(i, s, *given)
    # velocities of the rows n, t, s and of the rolling rows from rolling impulses of one
    w_n1, w_t1, w_s1, w_11, _, _ = yielding(i, s, 0)
    w_n2, w_t2, w_s2, w_12, w_22, _ = yielding(i, s, 3)
    w_nz, w_tz, w_sz, w_1z, w_2z, w_zz = yielding(i, s, 6)
    free_n -= w_n1 * r[3] + w_n2 * r[4] + w_nz * r[5]
    free_t -= w_t1 * r[3] + w_t2 * r[4] + w_tz * r[5]
    free_s -= w_s1 * r[3] + w_s2 * r[4] + w_sz * r[5]
    free_1 = u[3] - (w_n1 * r[0] + w_t1 * r[1] + w_s1 * r[2] + w_11 * r[3] + w_12 * r[4] + w_1z * r[5])
    free_2 = u[4] - (w_n2 * r[0] + w_t2 * r[1] + w_s2 * r[2] + w_12 * r[3] + w_22 * r[4] + w_2z * r[5])
    free_z = u[5] - (w_nz * r[0] + w_tz * r[1] + w_sz * r[2] + w_1z * r[3] + w_2z * r[4] + w_zz * r[5])
    W = (
        (w_nn, w_nt, w_ns, w_n1, w_n2, w_nz),
        (w_nt, w_tt, w_ts, w_t1, w_t2, w_tz),
        (w_ns, w_ts, w_ss, w_s1, w_s2, w_sz),
        (w_n1, w_t1, w_s1, w_11, w_12, w_1z),
        (w_n2, w_t2, w_s2, w_12, w_22, w_2z),
        (w_nz, w_tz, w_sz, w_1z, w_2z, w_zz),
    )
    return W, (free_n, free_t, free_s, free_1, free_2, free_z)


@inlined
def yielding(i, s, at):
    """Column of W of the rolling component whose moments begin at 18 + ``at``."""
    lever = s.rolling[i]
    # spins from a unit impulse, and what each row reads of them
    turn_c = scaled_row(multiple_row(lever, row(s.inverse_mass, s.candidate[i], 3)), row(s.moment, i, 18 + at))
    turn_a = scaled_row(multiple_row(lever, row(s.inverse_mass, s.antagonist[i], 3)), row(s.moment, i, 27 + at))
    return (
        dot(row(s.moment, i, 0), turn_c) + dot(row(s.moment, i, 9), turn_a),
        dot(row(s.moment, i, 3), turn_c) + dot(row(s.moment, i, 12), turn_a),
        dot(row(s.moment, i, 6), turn_c) + dot(row(s.moment, i, 15), turn_a),
        lever * (dot(row(s.moment, i, 18), turn_c) + dot(row(s.moment, i, 27), turn_a)),
        lever * (dot(row(s.moment, i, 21), turn_c) + dot(row(s.moment, i, 30), turn_a)),
        lever * (dot(row(s.moment, i, 24), turn_c) + dot(row(s.moment, i, 33), turn_a)),
    )


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    plain_momentum(start, stop, walls, s)
    for i in range(start, stop):
        r_1, r_2, r_z = s.impulse[i, 3], s.impulse[i, 4], s.impulse[i, 5]
        if r_1 == 0.0 and r_2 == 0.0 and r_z == 0.0:
            continue
        on_c = rolling_moment(i, s, r_1, r_2, r_z, 0)
        on_a = rolling_moment(i, s, r_1, r_2, r_z, 1)
        for k in range(3):
            if walls != 0:
                s.velocity[s.candidate[i], 3 + k] += on_c[k]
            if walls != 1:
                s.velocity[s.antagonist[i], 3 + k] += on_a[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s, u_1, u_2, u_z) of some interactions for velocities of the bodies, into ``result`` (m, 6)."""
    plain_velocities(start, stop, s, velocity, result)
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 3], result[i, 4], result[i, 5] = rolling_velocity(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 6, 12)."""
    moment = s.rolling[part, None, None, None] * s.moment[part, 18:].reshape(-1, 2, 3, 3)
    turning = np.zeros((len(moment), 3, 12))
    turning[:, :, 3:6], turning[:, :, 9:] = moment[:, 0], moment[:, 1]
    return np.concatenate([plain_rows(s, part), turning], axis=1)
