"""The form of an interaction in space of bodies that turn: the contact point may lie anywhere.

Spins are along the principal axes of each body, so that the mass matrix is diagonal. With the levers ``l = p - x`` to the
contact point p and the rotations R from the axes of the bodies to the axes of space, the rows that meet the velocities
``(v, spin)_c`` and ``(v, spin)_a`` are, for each axis e = n, t, s of the local frame,

    e:  (e, R_c^T (l_c x e))  (-e, -R_a^T (l_a x e)).

The moments, ``R_c^T (l_c x e)`` and ``-R_a^T (l_a x e)``, are made once a step (:func:`fill_moments`), so that sweeps turn
no vector: a contact has eighteen numbers more, in the order in which they are read. A body that keeps no rotation has
``R = 1``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined, kernel
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.frames import cross, cross_rows, local_frames
from lmgcpy.solve.kernels.forms.space import local_problem
from lmgcpy.solve.kernels.system import System

__all__ = ["fill_moments", "local_problem", "momentum", "push", "relative_velocities", "relative_velocity", "rows"]

ROWS = 3
"""As in ``space``, like the next one."""
WALLS = -1
_of_three = small_matrices(3)
row, dot, multiple_row = _of_three["row"], _of_three["dot"], _of_three["multiple_row"]
plus_row, less_row = _of_three["plus_row"], _of_three["less_row"]


@inlined
def spin_in_space(velocity, b, s):
    """``R spin`` of body ``b``."""
    return in_space(b, s, row(velocity, b, 3))


@inlined
def in_space(b, s, v):
    """``R v`` of body ``b``."""
    return dot(row(s.axes, b, 0), v), dot(row(s.axes, b, 3), v), dot(row(s.axes, b, 6), v)


@inlined
def in_own_axes(b, s, v):
    """``R^T v`` of body ``b``; v itself if no body keeps a rotation."""
    if s.axes.shape[0] == 0:
        return v
    two = plus_row(multiple_row(v[0], row(s.axes, b, 0)), multiple_row(v[1], row(s.axes, b, 3)))
    return plus_row(two, multiple_row(v[2], row(s.axes, b, 6)))


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
    spins = row(velocity, c, 3), row(velocity, a, 3)
    u_n = dot(n, v) + from_spins(i, 0, spins, s)
    if ROWS == 1:
        return u_n, 0.0, 0.0
    t = row(s.tangent, i, 0)
    return u_n, dot(t, v) + from_spins(i, 6, spins, s), dot(cross(n, t), v) + from_spins(i, 12, spins, s)


@inlined
def from_spins(i, at, spins, s):
    """Part of the spins in a relative velocity; ``at``: column of the first moment of the row."""
    return dot(row(s.moment, i, at), spins[0]) + dot(row(s.moment, i, at + 3), spins[1])


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
def own_moment(i, side, s, d):
    """Moment of an impulse ``d`` about the centre of the candidate (side 0) or the antagonist (3), along its axes."""
    moment = multiple_row(d[0], row(s.moment, i, side))
    if ROWS == 3:
        of_t, of_s = row(s.moment, i, 6 + side), row(s.moment, i, 12 + side)
        moment = plus_row(moment, plus_row(multiple_row(d[1], of_t), multiple_row(d[2], of_s)))
    return moment


@inlined
def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    force = force_of(i, s, d)
    if WALLS != 0:
        c = s.candidate[i]
        moment = own_moment(i, 0, s, d)
        for k in range(3):
            s.velocity[c, k] += s.inverse_mass[c, k] * force[k]
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * moment[k]
    if WALLS != 1:
        a = s.antagonist[i]
        moment = own_moment(i, 3, s, d)
        for k in range(3):
            s.velocity[a, k] -= s.inverse_mass[a, k] * force[k]
            s.velocity[a, 3 + k] += s.inverse_mass[a, 3 + k] * moment[k]


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = row(s.impulse, i, 0)
        if r[0] == 0.0 and r[1] == 0.0 and r[2] == 0.0:
            continue
        force = force_of(i, s, r)
        if walls != 0:
            c = s.candidate[i]
            moment = own_moment(i, 0, s, r)
            for k in range(3):
                s.velocity[c, k] += force[k]
                s.velocity[c, 3 + k] += moment[k]
        if walls != 1:
            a = s.antagonist[i]
            moment = own_moment(i, 3, s, r)
            for k in range(3):
                s.velocity[a, k] -= force[k]
                s.velocity[a, 3 + k] += moment[k]
    return 0.0


@kernel
def fill_moments(start, stop, s: System):
    """Fill ``s.moment`` of some interactions."""
    for i in range(start, stop):
        n = row(s.normal, i, 0)
        t = row(s.tangent, i, 0)
        frame = n, t, cross(n, t)
        for k in range(3):
            on_c = in_own_axes(s.candidate[i], s, cross(row(s.lever, i, 0), frame[k]))
            on_a = in_own_axes(s.antagonist[i], s, cross(frame[k], row(s.lever, i, 3)))
            for j in range(3):
                s.moment[i, 6 * k + j] = on_c[j]
                s.moment[i, 6 * k + 3 + j] = on_a[j]


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s) of some interactions for velocities of the bodies, into ``result`` (m, 3 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 12)."""
    frame = local_frames(s.normal[part])
    moment = cross_rows(s.lever[part].reshape(-1, 2, 1, 3), frame[:, None])
    if len(s.axes):
        axes = s.axes.reshape(-1, 3, 3)
        moment = moment @ np.stack([axes[s.candidate[part]], axes[s.antagonist[part]]], axis=1)
    return np.concatenate([frame, moment[:, 0], -frame, -moment[:, 1]], axis=2)
