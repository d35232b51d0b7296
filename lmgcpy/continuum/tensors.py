"""Symmetric tensors as vectors in Mandel's notation: the product of two vectors is the product of the tensors.

In 3D the components are xx, yy, zz, sqrt2 yz, sqrt2 xz, sqrt2 xy, in 2D xx, yy, sqrt2 xy. So ``sigma . eps`` is work, the
length of a vector is the length of its tensor, a turn of space is an orthogonal matrix, and a tangent is a (6, 6) or (3, 3)
matrix, symmetric if the fourth-order tensor is.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy.errors import numbers, shown, whole

PAIRS = {2: ((0, 1),), 3: ((1, 2), (0, 2), (0, 1))}
"""Axes of the components off the diagonal, in their order, by dimension."""
SIZE = {2: 3, 3: 6}
"""Number of components by dimension."""
SQRT2 = math.sqrt(2.0)


def check_dimension(value: Any) -> int:
    """``value``, if it is 2 or 3; raises TypeError or ValueError with a sentence."""
    return whole(value, "dimension", minimum=2, maximum=3)


def dimension_of(components: int) -> int:
    """Dimension of vectors of 3 or 6 components; raises ValueError for other numbers."""
    for dimension, size in SIZE.items():
        if size == components:
            return dimension
    raise ValueError(f"A vector in Mandel's notation has 3 components in 2D and 6 in 3D, got {components}.")


def mandel(tensor: Any) -> np.ndarray:
    """Vectors (..., m) of symmetric tensors (..., d, d).

    Raises TypeError if they hold anything but numbers, ValueError for other shapes and for tensors that are not symmetric.
    """
    given = numbers(tensor, "tensor", "symmetric tensors (..., d, d)")
    if given.ndim < 2 or given.shape[-1] != given.shape[-2] or given.shape[-1] not in SIZE:
        raise ValueError(f"tensor must be of shape (..., 2, 2) or (..., 3, 3), got {given.shape}.")
    if np.abs(given - np.swapaxes(given, -1, -2)).max(initial=0.0) > 1e-9 * np.abs(given).max(initial=0.0):
        raise ValueError(f"tensor must be symmetric, got {shown(tensor)}.")
    dimension = given.shape[-1]
    on = [given[..., i, i] for i in range(dimension)]
    off = [(given[..., i, j] + given[..., j, i]) / SQRT2 for i, j in PAIRS[dimension]]
    return np.stack([*on, *off], axis=-1)


def tensor_of(vector: Any) -> np.ndarray:
    """Symmetric tensors (..., d, d) of vectors (..., m); raises TypeError or ValueError with a sentence."""
    given = numbers(vector, "vector", "vectors in Mandel's notation (..., m)")
    if given.ndim < 1:
        raise ValueError(f"vector must be of shape (..., 3) or (..., 6), got {shown(vector)}.")
    dimension = dimension_of(given.shape[-1])
    result = np.empty((*given.shape[:-1], dimension, dimension))
    for i in range(dimension):
        result[..., i, i] = given[..., i]
    for place, (i, j) in enumerate(PAIRS[dimension], start=dimension):
        result[..., i, j] = result[..., j, i] = given[..., place] / SQRT2
    return result


def dyads(units: np.ndarray) -> np.ndarray:
    """Vectors of ``n (x) n``, shape (k, m), for directions n of shape (k, d). ``n . eps . n`` is their product with eps."""
    dimension = units.shape[1]
    off = [SQRT2 * units[:, i] * units[:, j] for i, j in PAIRS[dimension]]
    return np.stack([*(units.T**2), *off], axis=1)


def products_of(axes: np.ndarray) -> np.ndarray:
    """Orthonormal vectors (m, m) of the products of d orthogonal unit vectors, the rows of ``axes`` (d, d): ``a (x) a`` of
    each and ``(a (x) b + b (x) a)/sqrt2`` of each pair, in the order of the components."""
    mixed = [
        [SQRT2 * axes[a] * axes[b], [axes[a, i] * axes[b, j] + axes[a, j] * axes[b, i] for i, j in PAIRS[len(axes)]]]
        for a, b in PAIRS[len(axes)]
    ]
    return np.vstack([dyads(axes), [np.concatenate(parts) for parts in mixed]])


def identity(dimension: int) -> np.ndarray:
    """The unit tensor, (m,): its product with a vector is the trace."""
    return np.concatenate([np.ones(dimension), np.zeros(SIZE[dimension] - dimension)])


def turn(rotation: np.ndarray) -> np.ndarray:
    """Orthogonal matrix (m, m) that maps the vector of A to the vector of ``R A R^T``, R the ``rotation`` (d, d)."""
    units = np.eye(SIZE[len(rotation)])
    return mandel(np.array([rotation @ tensor_of(unit) @ rotation.T for unit in units])).T
