"""Positions of the contactors, and how far they have moved."""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel


@kernel
def place_contactors(bodies, body, offset, result):
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
def largest_move(positions, before, dimension):
    """Square of the largest displacement between two sets of positions [m^2]."""
    largest = 0.0
    for i in range(positions.shape[0]):
        x = positions[i, 0] - before[i, 0]
        y = positions[i, 1] - before[i, 1]
        z = positions[i, 2] - before[i, 2] if dimension == 3 else 0.0
        largest = max(largest, x * x + y * y + z * z)
    return largest
