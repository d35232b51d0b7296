"""Mass of a rigid body: volume, centre of mass and inertia of a solid of density one, and its principal axes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

SAME = 1e-9
"""Moments of inertia are the same, and products of inertia are zero, within this part of the largest moment."""


@dataclass(frozen=True)
class Solid:
    """A solid, or an area in 2D, of density one. Mass and inertia of a body are its density times these.

    ``volume`` [m^3], in 2D the area [m^2]; ``centre`` of mass (d,) [m]; ``inertia`` about it, (3, 3) [m^5], in 2D the polar
    moment [m^4]; ``error``: estimated relative error of volume and inertia.
    """

    volume: float
    centre: np.ndarray
    inertia: np.ndarray | float
    error: float = 0.0


def principal_axes(inertia: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Principal moments (3,) of an inertia tensor (3, 3), and the rotation from the principal axes to the given ones.

    The columns of the rotation's matrix Q are the principal axes, inertia = Q diag(moments) Q^T. Of all right-handed sets
    of axes they are the one at the smallest angle from the given axes. So a tensor that is diagonal, or one with three
    equal moments, gives the identity exactly, and the moments are in the order of the axes to which they are near.
    """
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    values, vectors = np.linalg.eigh(inertia)
    near = SAME * values[2]
    if np.abs(inertia - np.diag(np.diag(inertia))).max() <= near:
        axes = np.eye(3)
    elif values[1] - values[0] <= near or values[2] - values[1] <= near:
        axes = _shortest_turn(vectors[:, 2 if values[1] - values[0] <= near else 0])
    else:
        signed = [vectors[:, order] * signs for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
        right_handed = [q for q in signed if np.linalg.det(q) > 0.0]
        # rounded, so that noise does not choose between equal angles
        axes = max(right_handed, key=lambda q: tuple(np.round([np.trace(q), *q.ravel()], 9)))
    moments = np.diag(axes.T @ inertia @ axes)
    same = np.abs(moments[:, None] - moments) <= near
    return same @ moments / same.sum(axis=1), Rotation.from_matrix(axes)


def _shortest_turn(axis: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) of the smallest angle that turns a coordinate axis, the nearest one, to the line along ``axis``
    (3,) (Rodrigues' formula)."""
    nearest = int(np.argmax(np.round(np.abs(axis), 9)))
    axis = axis * np.sign(axis[nearest])
    turn = np.outer(axis, np.eye(3)[nearest])
    turn -= turn.T
    return np.eye(3) + turn + turn @ turn / (1.0 + axis[nearest])
