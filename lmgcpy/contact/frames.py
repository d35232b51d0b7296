"""Local frames from normals.

In 2D t is n turned by +90 degrees. In 3D t is horizontal, ``n x z`` turned to the left, unless n is steep: then it lies in
the plane y z; and s = n x t. So a scene in the plane x y has the same frames as in 2D.
"""

from __future__ import annotations

import numpy as np

STEEP = 0.8
"""Vertical part of a normal from which on the tangent is taken in the plane y z."""


def cross(u, v):
    """``u x v``; for kernels."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def cross_rows(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """``u x v`` for vectors (..., 3): the bits of ``np.cross`` in half of its time."""
    return np.stack(cross([u[..., k] for k in range(3)], [v[..., k] for k in range(3)]), axis=-1)


def tangent_of(n_x, n_y, n_z):
    """The unit vector t at right angles to n in 3D; for kernels."""
    if abs(n_z) <= STEEP:
        length = np.sqrt(n_x * n_x + n_y * n_y)
        return -n_y / length, n_x / length, 0.0
    length = np.sqrt(n_y * n_y + n_z * n_z)
    return 0.0, -n_z / length, n_y / length


def local_frames(normal: np.ndarray) -> np.ndarray:
    """Rows n, t(, s) of the local frames of normals (m, d): (m, d, d)."""
    if normal.shape[1] == 2:
        return np.stack([normal, np.column_stack([-normal[:, 1], normal[:, 0]])], axis=1)
    x, y, z = normal.T
    nothing = np.zeros(len(normal))
    level = np.abs(z) <= STEEP
    tangent = np.where(level[:, None], np.column_stack([-y, x, nothing]), np.column_stack([nothing, -z, y]))
    tangent /= np.sqrt(np.where(level, x * x + y * y, y * y + z * z))[:, None]
    return np.stack([normal, tangent, cross_rows(normal, tangent)], axis=1)
