"""Positions of the contactors, and how far they have moved.

A position is (x, y, angle) in the plane. In space it is (x, y, z), and in scenes with bodies that keep a rotation four more
numbers, the unit quaternion (q_x, q_y, q_z, q_w) of the rotation from the axes of the body to the axes of space.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import inlined, kernel
from lmgcpy.contact.frames import cross_rows


@kernel
def place_in_plane(bodies, body, offset, result):
    """Positions (x, y, angle) of the contactors from the positions of their bodies."""
    for k in range(body.shape[0]):
        b = body[k]
        cosine = np.cos(bodies[b, 2])
        sine = np.sin(bodies[b, 2])
        # q + R(angle) offset
        result[k, 0] = bodies[b, 0] + cosine * offset[k, 0] - sine * offset[k, 1]
        result[k, 1] = bodies[b, 1] + sine * offset[k, 0] + cosine * offset[k, 1]
        result[k, 2] = bodies[b, 2]


@kernel
def place_in_space(bodies, body, offset, result):
    """Positions (x, y, z) and quaternions of the contactors from those of their bodies."""
    for k in range(body.shape[0]):
        b = body[k]
        # q + R(quaternion) offset
        x, y, z = rotated(quaternion_of(bodies, b), (offset[k, 0], offset[k, 1], offset[k, 2]))
        result[k, 0] = bodies[b, 0] + x
        result[k, 1] = bodies[b, 1] + y
        result[k, 2] = bodies[b, 2] + z
        for j in range(3, 7):
            result[k, j] = bodies[b, j]


@inlined
def quaternion_of(bodies, b):
    """The rotation of body ``b``, (q_x, q_y, q_z, q_w)."""
    return bodies[b, 3], bodies[b, 4], bodies[b, 5], bodies[b, 6]


@inlined
def rotated(q, v):
    """The vector v, given in the axes of a body with the unit quaternion q, in the axes of space."""
    # v + 2 w (e x v) + 2 e x (e x v), e the vector part of q, w the last
    x, y, z, w = q
    c_x = 2.0 * (y * v[2] - z * v[1])
    c_y = 2.0 * (z * v[0] - x * v[2])
    c_z = 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * c_x + (y * c_z - z * c_y),
        v[1] + w * c_y + (z * c_x - x * c_z),
        v[2] + w * c_z + (x * c_y - y * c_x),
    )


@inlined
def turned_back(q, v):
    """The vector v, given in the axes of space, in the axes of a body with the unit quaternion q."""
    return rotated((-q[0], -q[1], -q[2], q[3]), v)


def in_plane(angles: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 2) along the axes of bodies that are turned by these angles (...), along those of space."""
    cosine, sine, x, y = np.cos(angles), np.sin(angles), vectors[..., 0], vectors[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def in_space(quaternions: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) along the axes of bodies with these quaternions (..., 4), along those of space."""
    axis, last = quaternions[..., :3], quaternions[..., 3:]
    twice = 2.0 * cross_rows(axis, vectors)
    return vectors + last * twice + cross_rows(axis, twice)


def in_own_axes(quaternions: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) along the axes of space, along the axes of bodies with these quaternions (..., 4)."""
    return in_space(quaternions * [-1.0, -1.0, -1.0, 1.0], vectors)


def axes_of(positions: np.ndarray) -> np.ndarray:
    """Matrices of the rotations from the axes of bodies to those of space, (k, 3, 3), from positions in space (k, w)."""
    if positions.shape[1] == 3:
        return np.tile(np.eye(3), (len(positions), 1, 1))
    return in_space(positions[:, None, 3:], np.eye(3)[None]).transpose(0, 2, 1)  # columns: unit vectors of the body


@kernel
def largest_move(positions, before, unbounded, dimension):
    """Square of the largest displacement between two sets of positions [m^2]; infinite if a contactor of the rows
    ``unbounded`` has turned: its smallest turn moves its distant parts far."""
    for j in unbounded:
        for k in range(dimension, positions.shape[1]):
            if positions[j, k] != before[j, k]:
                return np.inf
    largest = 0.0
    for i in range(positions.shape[0]):
        x = positions[i, 0] - before[i, 0]
        y = positions[i, 1] - before[i, 1]
        z = positions[i, 2] - before[i, 2] if dimension == 3 else 0.0
        largest = max(largest, x * x + y * y + z * z)
    return largest
