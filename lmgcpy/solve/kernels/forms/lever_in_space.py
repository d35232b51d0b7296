"""The form of an interaction in space of bodies that turn: the contact point may lie anywhere.

Spins are along the principal axes of each body, so that the mass matrix is diagonal. With the levers ``l = p - x`` to the
contact point p and the rotations R from the axes of the bodies to the axes of space, the rows that meet the velocities
``(v, spin)_c`` and ``(v, spin)_a`` are, for each axis e = n, t, s of the local frame,

    e:  (e, R_c^T (l_c x e))  (-e, -R_a^T (l_a x e)).

Kernels go by the vectors: ``u = v_c + (R_c spin_c) x l_c - v_a - (R_a spin_a) x l_a`` in the local frame, and the moment of
a force f on the candidate is ``R_c^T (l_c x f)``. So a contact has six numbers more, and a body nine. (With the rows
themselves a contact has eighteen, and sweeps wait for memory.) A body that keeps no rotation has ``R = 1``.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import inlined
from lmgcpy.contact.frames import cross, local_frames
from lmgcpy.solve.kernels.forms.space import local_problem
from lmgcpy.solve.kernels.small_matrices import small_matrices

__all__ = ["local_problem", "momentum", "push", "relative_velocities", "relative_velocity", "rows"]

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
    """``R^T v`` of body ``b``."""
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
    # u = v_c + spin_c x l_c - (v_a + spin_a x l_a)
    u = plus_row(row(velocity, c, 0), cross(spin_in_space(velocity, c, s), row(s.lever, i, 0)))
    u = less_row(u, plus_row(row(velocity, a, 0), cross(spin_in_space(velocity, a, s), row(s.lever, i, 3))))
    n = row(s.normal, i, 0)
    if ROWS == 1:
        return dot(n, u), 0.0, 0.0
    t = row(s.tangent, i, 0)
    return dot(n, u), dot(t, u), dot(cross(n, t), u)


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
    force = force_of(i, s, d)
    if WALLS != 0:
        c = s.candidate[i]
        moment = in_own_axes(c, s, cross(row(s.lever, i, 0), force))
        for k in range(3):
            s.velocity[c, k] += s.inverse_mass[c, k] * force[k]
            s.velocity[c, 3 + k] += s.inverse_mass[c, 3 + k] * moment[k]
    if WALLS != 1:
        a = s.antagonist[i]
        moment = in_own_axes(a, s, cross(row(s.lever, i, 3), force))
        for k in range(3):
            s.velocity[a, k] -= s.inverse_mass[a, k] * force[k]
            s.velocity[a, 3 + k] -= s.inverse_mass[a, 3 + k] * moment[k]


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = row(s.impulse, i, 0)
        if r[0] == 0.0 and r[1] == 0.0 and r[2] == 0.0:
            continue
        force = force_of(i, s, r)
        if walls != 0:
            c = s.candidate[i]
            moment = in_own_axes(c, s, cross(row(s.lever, i, 0), force))
            for k in range(3):
                s.velocity[c, k] += force[k]
                s.velocity[c, 3 + k] += moment[k]
        if walls != 1:
            a = s.antagonist[i]
            moment = in_own_axes(a, s, cross(row(s.lever, i, 3), force))
            for k in range(3):
                s.velocity[a, k] -= force[k]
                s.velocity[a, 3 + k] -= moment[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t, u_s) of some interactions for velocities of the bodies, into ``result`` (m, 3 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1], result[i, 2] = relative_velocity_for(velocity, i, s)


def rows(s: Any, part: slice) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 3, 12)."""
    frame = local_frames(s.normal[part])
    lever, axes = s.lever[part].reshape(-1, 2, 1, 3), s.axes.reshape(-1, 3, 3)
    moment = np.cross(lever, frame[:, None]) @ np.stack([axes[s.candidate[part]], axes[s.antagonist[part]]], axis=1)
    return np.concatenate([frame, moment[:, 0], -frame, -moment[:, 1]], axis=2)
