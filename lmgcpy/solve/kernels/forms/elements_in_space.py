"""The form of an interaction in space of which at least one side lies on several bodies (:mod:`lmgcpy.contact.elements`).

A side is one body, as in ``lever_in_space``, or an element with the bodies k at its corners. With the weights w_k, and G_k
and rho as there, the rows that meet the velocity v_k are, with the sign +1 of the candidate or -1 of the antagonist,

    n:  sign w_k n
    t:  (sign w_k - rho G_k . n) t + rho (G_k . t) n
    s:  (sign w_k - rho G_k . n) s + rho (G_k . s) n.

The four numbers ``sign w_k``, ``-rho G_k . n``, ``rho G_k . t``, ``rho G_k . s`` of each corner are in ``System.weight``.
The sum of the w_k is one and the sum of the G_k zero, so momentum is conserved; so is angular momentum, but for the part
about the axis of a segment, ``rho r_b`` for the impulse r_b across segment and normal: the segment is held against torsion.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.frames import cross, local_frames
from lmgcpy.solve.kernels.forms import lever_in_space
from lmgcpy.solve.kernels.forms.lever_in_space import own_moment
from lmgcpy.solve.kernels.forms.space import local_problem

__all__ = ["bodies", "local_problem", "momentum", "push", "relative_velocities", "relative_velocity", "rows"]

ROWS = 3
"""As in ``space``."""
CANDIDATE = 1
"""Number of bodies of the candidate; 1: a body with its lever."""
ANTAGONIST = 2
BOTH = 2
"""Number of corners of both sides."""
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
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    b = cross(n, t)
    v = (0.0, 0.0, 0.0)
    across = (0.0, 0.0, 0.0)
    tilt_t = 0.0
    tilt_s = 0.0
    u_n = 0.0
    # a side that is one body: its velocity and moments
    if CANDIDATE == 1:
        c = s.candidate[i]
        v = row(velocity, c, 0)
        spin = row(velocity, c, 3)
        u_n += dot(row(s.moment, i, 0), spin)
        tilt_t += dot(row(s.moment, i, 6), spin)
        tilt_s += dot(row(s.moment, i, 12), spin)
    if ANTAGONIST == 1:
        a = s.antagonist[i]
        v = less_row(v, row(velocity, a, 0))
        spin = row(velocity, a, 3)
        u_n += dot(row(s.moment, i, 3), spin)
        tilt_t += dot(row(s.moment, i, 9), spin)
        tilt_s += dot(row(s.moment, i, 15), spin)
    # corners: sign w v, -rho (G . n) v, rho (n . v) G
    for k in range(BOTH):
        v_k = row(velocity, s.corner[i, k], 0)
        along = dot(n, v_k)
        v = plus_row(v, multiple_row(s.weight[i, 4 * k], v_k))
        across = plus_row(across, multiple_row(s.weight[i, 4 * k + 1], v_k))
        tilt_t += s.weight[i, 4 * k + 2] * along
        tilt_s += s.weight[i, 4 * k + 3] * along
    moving = plus_row(v, across)
    return u_n + dot(n, v), dot(t, moving) + tilt_t, dot(b, moving) + tilt_s


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    add_impulse(s.velocity, i, s, d, True)


@inlined
def add_impulse(result, i, s, d, weighed):
    """Add ``H d`` of interaction ``i`` to ``result`` (n, 6), ``M^-1 H d`` if it is ``weighed``."""
    n = row(s.normal, i, 0)
    t = row(s.tangent, i, 0)
    tangential = plus_row(multiple_row(d[1], t), multiple_row(d[2], cross(n, t)))
    force = plus_row(multiple_row(d[0], n), tangential)
    if CANDIDATE == 1:
        add_to_body(result, s.candidate[i], s, force, own_moment(i, 0, s, d), weighed)
    if ANTAGONIST == 1:
        add_to_body(result, s.antagonist[i], s, multiple_row(-1.0, force), own_moment(i, 3, s, d), weighed)
    for k in range(BOTH):
        # sign w f, -rho (G . n) f_t, rho (G . f_t) n
        tilt = s.weight[i, 4 * k + 2] * d[1] + s.weight[i, 4 * k + 3] * d[2]
        given = plus_row(multiple_row(s.weight[i, 4 * k], force), multiple_row(s.weight[i, 4 * k + 1], tangential))
        given = plus_row(given, multiple_row(tilt, n))
        body = s.corner[i, k]
        for j in range(3):
            result[body, j] += (s.inverse_mass[body, j] if weighed else 1.0) * given[j]


@inlined
def add_to_body(result, body, s, force, moment, weighed):
    """Add a force and a moment on a body."""
    for j in range(3):
        result[body, j] += (s.inverse_mass[body, j] if weighed else 1.0) * force[j]
        result[body, 3 + j] += (s.inverse_mass[body, 3 + j] if weighed else 1.0) * moment[j]


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = row(s.impulse, i, 0)
        if r[0] != 0.0 or r[1] != 0.0 or r[2] != 0.0:
            add_impulse(s.velocity, i, s, r, False)
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s) of some interactions for velocities of the bodies, into ``result`` (m, 3 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def bodies(s: Any, part: slice) -> np.ndarray:
    """Rows of the bodies whose columns :func:`rows` has, (m, 2 + corners)."""
    return np.column_stack([s.candidate[part], s.antagonist[part], s.corner[part]]).astype(np.int64)


def rows(s: Any, part: slice, candidate: int, antagonist: int) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 6 (2 + corners)); ``candidate``, ``antagonist``: their numbers of
    bodies."""
    own = lever_in_space.rows(s, part)
    for count, side in ((candidate, 0), (antagonist, 1)):
        if count > 1:
            own[:, :, 6 * side : 6 * side + 6] = 0.0
    n, t, b = local_frames(s.normal[part]).transpose(1, 0, 2)[:, :, None]
    corners = s.corner.shape[1]
    used = (candidate > 1) * candidate + (antagonist > 1) * antagonist
    on, across, tilt_t, tilt_s = s.weight[part].reshape(-1, corners, 4, 1)[:, :used].transpose(2, 0, 1, 3)
    result = np.zeros((len(n), 3, corners, 6))
    result[:, 0, :used, :3] = on * n
    result[:, 1, :used, :3] = (on + across) * t + tilt_t * n
    result[:, 2, :used, :3] = (on + across) * b + tilt_s * n
    return np.concatenate([own, result.reshape(len(n), 3, -1)], axis=2)
