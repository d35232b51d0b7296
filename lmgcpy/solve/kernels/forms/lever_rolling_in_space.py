"""The form of a contact with rolling friction in space of bodies that turn.

Three more rows meet the spins alone, as in ``rolling_in_space``: about ``b = n x t``, ``-t`` and n, with the effective
radius R for a lever. Spins in space are those of ``lever_in_space``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.frames import cross, local_frames
from lmgcpy.solve.kernels.forms.lever_in_space import in_own_axes, in_space, spin_in_space
from lmgcpy.solve.kernels.forms.lever_in_space import local_problem as plain_problem
from lmgcpy.solve.kernels.forms.lever_in_space import momentum as plain_momentum
from lmgcpy.solve.kernels.forms.lever_in_space import push as plain_push
from lmgcpy.solve.kernels.forms.lever_in_space import relative_velocities as plain_velocities
from lmgcpy.solve.kernels.forms.lever_in_space import relative_velocity as plain_velocity
from lmgcpy.solve.kernels.forms.lever_in_space import rows as plain_rows
from lmgcpy.solve.kernels.forms.rolling_in_space import moment_of

WALLS = -1
"""As in ``space``."""
_of_three = small_matrices(3)
row, dot, multiple_row = _of_three["row"], _of_three["dot"], _of_three["multiple_row"]
plus_row, less_row, scaled_row = _of_three["plus_row"], _of_three["less_row"], _of_three["scaled_row"]


@inlined
def rolling_velocity(velocity, i, s):
    """(u_1, u_2, u_z) of interaction ``i`` for velocities of the bodies, (n, 6)."""
    spin = less_row(spin_in_space(velocity, s.candidate[i], s), spin_in_space(velocity, s.antagonist[i], s))
    return about_rolling_axes(i, s, spin)


@inlined
def about_rolling_axes(i, s, spin):
    """A spin in space about the axes of the rolling rows, times R."""
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    lever = s.rolling[i]
    return lever * dot(cross(n, t), spin), -lever * dot(t, spin), lever * dot(n, spin)


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
    moment = moment_of(i, s, d[3], d[4], d[5])
    if WALLS != 0:
        c = s.candidate[i]
        own = in_own_axes(c, s, moment)
        for k in range(3):
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * own[k]
    if WALLS != 1:
        a = s.antagonist[i]
        own = in_own_axes(a, s, moment)
        for k in range(3):
            s.velocity[a, 3 + k] -= s.inverse_mass[a, 3 + k] * own[k]


@inlined
def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    given = (u[0], u[1], u[2]), (r[0], r[1], r[2])
    ((w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss)), (free_n, free_t, free_s) = plain_problem(i, s, *given)
    # velocities of all rows from rolling impulses of one
    w_n1, w_t1, w_s1, w_11, _, _ = from_moment(i, s, moment_of(i, s, 1.0, 0.0, 0.0))
    w_n2, w_t2, w_s2, w_12, w_22, _ = from_moment(i, s, moment_of(i, s, 0.0, 1.0, 0.0))
    w_nz, w_tz, w_sz, w_1z, w_2z, w_zz = from_moment(i, s, moment_of(i, s, 0.0, 0.0, 1.0))
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
def from_moment(i, s, moment):
    """Relative velocities from a moment on the candidate, and its opposite on the antagonist."""
    spin_c = given_spin(s.candidate[i], s, moment)
    spin_a = given_spin(s.antagonist[i], s, moment)
    # spin_c x l_c + spin_a x l_a, as the antagonist gets -spin_a
    u = plus_row(cross(spin_c, row(s.lever, i, 0)), cross(spin_a, row(s.lever, i, 3)))
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    u_1, u_2, u_z = about_rolling_axes(i, s, plus_row(spin_c, spin_a))
    return dot(n, u), dot(t, u), dot(cross(n, t), u), u_1, u_2, u_z


@inlined
def given_spin(b, s, moment):
    """``R I^-1 R^T m``: spin in space that a moment gives to body ``b``."""
    return in_space(b, s, scaled_row(row(s.inverse_mass, b, 3), in_own_axes(b, s, moment)))


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    plain_momentum(start, stop, walls, s)
    for i in range(start, stop):
        r_1, r_2, r_z = s.impulse[i, 3], s.impulse[i, 4], s.impulse[i, 5]
        if r_1 == 0.0 and r_2 == 0.0 and r_z == 0.0:
            continue
        moment = moment_of(i, s, r_1, r_2, r_z)
        on_c = in_own_axes(s.candidate[i], s, moment)
        on_a = in_own_axes(s.antagonist[i], s, moment)
        for k in range(3):
            if walls != 0:
                s.velocity[s.candidate[i], 3 + k] += on_c[k]
            if walls != 1:
                s.velocity[s.antagonist[i], 3 + k] -= on_a[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s, u_1, u_2, u_z) of some interactions for velocities of the bodies, into ``result`` (m, 6)."""
    plain_velocities(start, stop, s, velocity, result)
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 3], result[i, 4], result[i, 5] = rolling_velocity(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 6, 12)."""
    about = s.rolling[part, None, None] * (local_frames(s.normal[part])[:, [2, 1, 0]] * [[1.0], [-1.0], [1.0]])
    axes = s.axes.reshape(-1, 3, 3)
    turning = np.zeros((len(about), 3, 12))
    turning[:, :, 3:6], turning[:, :, 9:] = about @ axes[s.candidate[part]], -about @ axes[s.antagonist[part]]
    return np.concatenate([plain_rows(s, part), turning], axis=1)
