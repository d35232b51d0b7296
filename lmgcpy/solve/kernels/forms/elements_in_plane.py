"""The form of an interaction in the plane of which at least one side lies on several bodies
(:mod:`lmgcpy.contact.elements`).

It is ``elements_in_space`` without the second tangent: a corner has the three numbers ``sign w_k``, ``-rho G_k . n`` and
``rho G_k . t`` in ``System.weight``. Angular momentum is conserved.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.solve.kernels.forms import plane
from lmgcpy.solve.kernels.forms.elements_in_space import bodies
from lmgcpy.solve.kernels.forms.plane import local_problem

__all__ = ["bodies", "local_problem", "momentum", "push", "relative_velocities", "relative_velocity", "rows"]

CANDIDATE = 1
"""As in ``elements_in_space``, like the next two."""
ANTAGONIST = 2
BOTH = 2


def relative_velocity(i, s):
    """(u_n, u_t) of interaction ``i`` at the contact point, candidate minus antagonist."""
    return relative_velocity_for(s.velocity, i, s)


def relative_velocity_for(velocity, i, s):
    """``H^T v`` of interaction ``i`` for velocities ``v`` of the bodies, (n, 3)."""
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    u_n = 0.0
    u_t = 0.0
    # a side that is one body: its velocity and levers
    if CANDIDATE == 1:
        c = s.candidate[i]
        u_n += n_x * velocity[c, 0] + n_y * velocity[c, 1] - s.lateral[i, 0] * velocity[c, 2]
        u_t += n_x * velocity[c, 1] - n_y * velocity[c, 0] - s.arm[i, 0] * velocity[c, 2]
    if ANTAGONIST == 1:
        a = s.antagonist[i]
        u_n -= n_x * velocity[a, 0] + n_y * velocity[a, 1] - s.lateral[i, 1] * velocity[a, 2]
        u_t -= n_x * velocity[a, 1] - n_y * velocity[a, 0] + s.arm[i, 1] * velocity[a, 2]
    # corners: sign w v, -rho (G . n) v, rho (n . v) G
    for k in range(BOTH):
        b = s.corner[i, k]
        along = n_x * velocity[b, 0] + n_y * velocity[b, 1]
        across = n_x * velocity[b, 1] - n_y * velocity[b, 0]
        u_n += s.weight[i, 3 * k] * along
        u_t += (s.weight[i, 3 * k] + s.weight[i, 3 * k + 1]) * across + s.weight[i, 3 * k + 2] * along
    return u_n, u_t


def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies."""
    add_impulse(s.velocity, i, s, d, True)


def add_impulse(result, i, s, d, weighed):
    """Add ``H d`` of interaction ``i`` to ``result`` (n, 3), ``M^-1 H d`` if it is ``weighed``."""
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    f_x = n_x * d[0] - n_y * d[1]
    f_y = n_y * d[0] + n_x * d[1]
    if CANDIDATE == 1:
        add_to_body(result, s.candidate[i], s, (f_x, f_y, -s.arm[i, 0] * d[1] - s.lateral[i, 0] * d[0]), weighed)
    if ANTAGONIST == 1:
        add_to_body(result, s.antagonist[i], s, (-f_x, -f_y, s.lateral[i, 1] * d[0] - s.arm[i, 1] * d[1]), weighed)
    for k in range(BOTH):
        b = s.corner[i, k]
        # along n and t: sign w d, -rho (G . n) d_t, rho (G . t) d_t n
        along = s.weight[i, 3 * k] * d[0] + s.weight[i, 3 * k + 2] * d[1]
        across = (s.weight[i, 3 * k] + s.weight[i, 3 * k + 1]) * d[1]
        add_to_body(result, b, s, (n_x * along - n_y * across, n_y * along + n_x * across, 0.0), weighed)


def add_to_body(result, body, s, given, weighed):
    """Add a force and a moment on a body."""
    for j in range(3):
        result[body, j] += (s.inverse_mass[body, j] if weighed else 1.0) * given[j]


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    for i in range(start, stop):
        r = s.impulse[i, 0], s.impulse[i, 1]
        if r[0] != 0.0 or r[1] != 0.0:
            add_impulse(s.velocity, i, s, r, False)
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """(u_n, u_t) of some interactions for velocities of the bodies, into ``result`` (m, 2 or more)."""
    for k in range(start, stop):
        i = np.uintp(k)
        result[i, 0], result[i, 1] = relative_velocity_for(velocity, i, s)


def rows(s: Any, part: slice, candidate: int, antagonist: int) -> np.ndarray:
    """Rows of ``H^T`` of some interactions, (m, 2, 3 (2 + corners)); ``candidate``, ``antagonist``: their numbers of
    bodies."""
    own = plane.rows(s, part)
    for count, side in ((candidate, 0), (antagonist, 1)):
        if count > 1:
            own[:, :, 3 * side : 3 * side + 3] = 0.0
    n, t = local_frames(s.normal[part]).transpose(1, 0, 2)[:, :, None]
    corners = s.corner.shape[1]
    used = (candidate > 1) * candidate + (antagonist > 1) * antagonist
    on, across, tilt = s.weight[part].reshape(-1, corners, 3, 1)[:, :used].transpose(2, 0, 1, 3)
    result = np.zeros((len(n), 2, corners, 3))
    result[:, 0, :used, :2] = on * n
    result[:, 1, :used, :2] = (on + across) * t + tilt * n
    return np.concatenate([own, result.reshape(len(n), 2, -1)], axis=2)
