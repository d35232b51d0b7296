"""The form of a contact with rolling friction in space.

Three more rows meet the spins alone, with the effective radius R of the two bodies for a lever. The rolling velocity is
``R (spin_c - spin_a) x n``, a vector of the tangent plane; the torsion velocity is ``R n . (spin_c - spin_a)``. With
``s = n x t`` the rows that meet spin_c are (and those that meet spin_a their opposites)

    1:  R s         2:  -R t         z:  R n.

So rows t and 1, and s and 2, couple by the same number where inertias are the same in all directions,
``R (arm_a / I_a - arm_c / I_c)``, as t and r do in 2D; and torsion is alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.frames import cross, local_frames
from lmgcpy.solve.kernels.forms.space import local_problem as space_problem
from lmgcpy.solve.kernels.forms.space import momentum as space_momentum
from lmgcpy.solve.kernels.forms.space import push as space_push
from lmgcpy.solve.kernels.forms.space import relative_velocities as space_velocities
from lmgcpy.solve.kernels.forms.space import relative_velocity as space_velocity
from lmgcpy.solve.kernels.forms.space import rows as space_rows

WALLS = -1
"""As in ``space``."""
ISOTROPIC = True
"""Whether all bodies turn alike about all axes. Then most of W is zero, which the compiler sees, and so it leaves out what
the law has for other blocks."""
_of_three = small_matrices(3)
row, dot, multiple_row = _of_three["row"], _of_three["dot"], _of_three["multiple_row"]
plus_row, less_row, scaled_row = _of_three["plus_row"], _of_three["less_row"], _of_three["scaled_row"]


@inlined
def rolling_velocity(velocity, i, s):
    """(u_1, u_2, u_z) of interaction ``i`` for velocities of the bodies, (n, 6)."""
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    spin = multiple_row(s.rolling[i], less_row(row(velocity, s.candidate[i], 3), row(velocity, s.antagonist[i], 3)))
    return dot(cross(n, t), spin), -dot(t, spin), dot(n, spin)


@inlined
def moment_of(i, s, r_1, r_2, r_z):
    """Moment ``R (r_1 s - r_2 t + r_z n)`` of rolling impulses on the candidate [N m s]."""
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    sum_ = less_row(multiple_row(r_1, cross(n, t)), multiple_row(r_2, t))
    return multiple_row(s.rolling[i], plus_row(sum_, multiple_row(r_z, n)))


@inlined
def relative_velocity(i, s):
    """(u_n, u_t, u_s, u_1, u_2, u_z) of interaction ``i``, candidate minus antagonist."""
    u_n, u_t, u_s = space_velocity(i, s)
    u_1, u_2, u_z = rolling_velocity(s.velocity, i, s)
    return u_n, u_t, u_s, u_1, u_2, u_z


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    space_push(i, s, (d[0], d[1], d[2]))
    moment = moment_of(i, s, d[3], d[4], d[5])
    c = s.candidate[i]
    a = s.antagonist[i]
    if WALLS != 0:
        for k in range(3):
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * moment[k]
    if WALLS != 1:
        for k in range(3):
            s.velocity[a, 3 + k] -= s.inverse_mass[a, 3 + k] * moment[k]


@inlined
def local_problem(i, s, u, r):
    """(the local block of W, ``u - W r``) of interaction ``i``."""
    given = (u[0], u[1], u[2]), (r[0], r[1], r[2])
    ((w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss)), (free_n, free_t, free_s) = space_problem(i, s, *given)
    lever = s.rolling[i]
    easy_c = multiple_row(lever, row(s.inverse_mass, s.candidate[i], 3))
    easy_a = multiple_row(lever, row(s.inverse_mass, s.antagonist[i], 3))
    # what rolling yields to moments, diagonal in the axes of the scene, and how it couples with the levers of t and s
    rolls = multiple_row(lever, plus_row(easy_c, easy_a))
    couples = less_row(multiple_row(s.arm[i, 1], easy_a), multiple_row(s.arm[i, 0], easy_c))
    w_11 = rolls[0]
    w_22 = rolls[0]
    w_zz = rolls[0]
    w_t1 = couples[0]
    w_s2 = couples[0]
    w_12 = w_1z = w_2z = w_t2 = w_tz = w_s1 = w_sz = 0.0
    if not ISOTROPIC:
        n = row(s.normal, i, 0)
        t = row(s.tangent, i, 0)
        b = cross(n, t)
        across, along, turning = scaled_row(rolls, b), scaled_row(rolls, t), scaled_row(rolls, n)
        w_11, w_12, w_1z = dot(b, across), -dot(t, across), dot(n, across)
        w_22, w_2z, w_zz = dot(t, along), -dot(n, along), dot(n, turning)
        across, along = scaled_row(couples, b), scaled_row(couples, t)
        w_t1, w_t2, w_tz = dot(b, across), -dot(t, across), dot(n, across)
        w_s1, w_s2, w_sz = -dot(b, along), dot(t, along), -dot(n, along)
    free_t -= w_t1 * r[3] + w_t2 * r[4] + w_tz * r[5]
    free_s -= w_s1 * r[3] + w_s2 * r[4] + w_sz * r[5]
    free_1 = u[3] - (w_t1 * r[1] + w_s1 * r[2] + w_11 * r[3] + w_12 * r[4] + w_1z * r[5])
    free_2 = u[4] - (w_t2 * r[1] + w_s2 * r[2] + w_12 * r[3] + w_22 * r[4] + w_2z * r[5])
    free_z = u[5] - (w_tz * r[1] + w_sz * r[2] + w_1z * r[3] + w_2z * r[4] + w_zz * r[5])
    W = (
        (w_nn, w_nt, w_ns, 0.0, 0.0, 0.0),
        (w_nt, w_tt, w_ts, w_t1, w_t2, w_tz),
        (w_ns, w_ts, w_ss, w_s1, w_s2, w_sz),
        (0.0, w_t1, w_s1, w_11, w_12, w_1z),
        (0.0, w_t2, w_s2, w_12, w_22, w_2z),
        (0.0, w_tz, w_sz, w_1z, w_2z, w_zz),
    )
    return W, (free_n, free_t, free_s, free_1, free_2, free_z)


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    space_momentum(start, stop, walls, s)
    for i in range(start, stop):
        r_1, r_2, r_z = s.impulse[i, 3], s.impulse[i, 4], s.impulse[i, 5]
        if r_1 == 0.0 and r_2 == 0.0 and r_z == 0.0:
            continue
        moment = moment_of(i, s, r_1, r_2, r_z)
        for k in range(3):
            if walls != 0:
                s.velocity[s.candidate[i], 3 + k] += moment[k]
            if walls != 1:
                s.velocity[s.antagonist[i], 3 + k] -= moment[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s, u_1, u_2, u_z) of some interactions for velocities of the bodies, into ``result`` (m, 6)."""
    space_velocities(start, stop, s, velocity, result)
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 3], result[i, 4], result[i, 5] = rolling_velocity(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 6, 12)."""
    plain = space_rows(s, part)
    frame = local_frames(s.normal[part])
    axes = s.rolling[part, None, None] * (frame[:, [2, 1, 0]] * [[1.0], [-1.0], [1.0]])
    turning = np.zeros((len(plain), 3, 12))
    turning[:, :, 3:6], turning[:, :, 9:] = axes, -axes
    return np.concatenate([plain, turning], axis=1)
