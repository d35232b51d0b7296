"""The form of an interaction in space of bodies that turn: the contact point may lie anywhere.

Spins are along the principal axes of each body, so that the mass matrix is diagonal. With the levers ``l = p - x`` to the
contact point p and the rotations R from the axes of the bodies to the axes of space, the rows that meet the velocities
``(v, spin)_c`` and ``(v, spin)_a`` are, for each axis e = n, t, s of the local frame,

    e:  (e, R_c^T (l_c x e))  (-e, -R_a^T (l_a x e)).

The detection makes the moments ``R^T (l x e)`` (``System.moment``). Sweeps so need neither rotations nor levers. A body
that keeps no rotation has ``R = 1``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.contact.frames import local_frames
from lmgcpy.solve.kernels.forms.space import cross, local_problem
from lmgcpy.solve.kernels.small_matrices import small_matrices

__all__ = ["local_problem", "momentum", "push", "relative_velocities", "relative_velocity", "rows"]

ROWS = 3
"""As in ``space``, like the next one."""
WALLS = -1
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
    spin_c = row(velocity, c, 3)
    spin_a = row(velocity, a, 3)
    # centres: e . v; then the spins by their moments
    u_n = dot(n, v) + dot(row(s.moment, i, 0), spin_c) + dot(row(s.moment, i, 9), spin_a)
    if ROWS == 1:
        return u_n, 0.0, 0.0
    t = row(s.tangent, i, 0)
    b = cross(n, t)
    u_t = dot(t, v) + dot(row(s.moment, i, 3), spin_c) + dot(row(s.moment, i, 12), spin_a)
    u_s = dot(b, v) + dot(row(s.moment, i, 6), spin_c) + dot(row(s.moment, i, 15), spin_a)
    return u_n, u_t, u_s


@inlined
def moment_of(i, s, d, side):
    """Moment of an impulse ``d`` on the candidate (``side`` 0) or the antagonist (1), along its own axes."""
    moment = multiple_row(d[0], row(s.moment, i, 9 * side))
    if ROWS == 3:
        moment = plus_row(moment, multiple_row(d[1], row(s.moment, i, 9 * side + 3)))
        moment = plus_row(moment, multiple_row(d[2], row(s.moment, i, 9 * side + 6)))
    return moment


@inlined
def force_of(i, s, d):
    """An impulse ``d`` along the axes of space."""
    n = row(s.normal, i, 0)
    force = multiple_row(d[0], n)
    if ROWS == 3:
        t = row(s.tangent, i, 0)
        force = plus_row(force, plus_row(multiple_row(d[1], t), multiple_row(d[2], cross(n, t))))
    return force


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    c = s.candidate[i]
    a = s.antagonist[i]
    force = force_of(i, s, d)
    if WALLS != 0:
        moment = moment_of(i, s, d, 0)
        for k in range(3):
            s.velocity[c, k] += s.inverse_mass[c, k] * force[k]
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * moment[k]
    if WALLS != 1:
        moment = moment_of(i, s, d, 1)
        for k in range(3):
            s.velocity[a, k] -= s.inverse_mass[a, k] * force[k]
            s.velocity[a, 3 + k] += s.inverse_mass[a, 3 + k] * moment[k]


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = row(s.impulse, i, 0)
        if r[0] == 0.0 and r[1] == 0.0 and r[2] == 0.0:
            continue
        c = s.candidate[i]
        a = s.antagonist[i]
        force = force_of(i, s, r)
        if walls != 0:
            moment = moment_of(i, s, r, 0)
            for k in range(3):
                s.velocity[c, k] += force[k]
                s.velocity[c, 3 + k] += moment[k]
        if walls != 1:
            moment = moment_of(i, s, r, 1)
            for k in range(3):
                s.velocity[a, k] -= force[k]
                s.velocity[a, 3 + k] += moment[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s) of some interactions for velocities of the bodies, into ``result`` (m, 3 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 12)."""
    frame = local_frames(s.normal[part])
    moment = s.moment[part, :18].reshape(-1, 2, 3, 3)
    return np.concatenate([frame, moment[:, 0], -frame, moment[:, 1]], axis=2)
