"""The interactions of a step, as the narrow phase writes them; and arrays whose length changes a little a step."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference
from lmgcpy.contact.frames import local_frames

FEW = 64
"""Arrays of at most this many rows get no spare rows: memory for them fits in any hole."""


@by_reference
class Interactions(NamedTuple):
    """The interactions of a step; m of them.

    :class:`lmgcpy.solve.kernels.system.System` has the arrays without a text.
    """

    candidate: np.ndarray
    antagonist: np.ndarray
    gap: np.ndarray
    """At the detection configuration [m], (m,)."""
    normal: np.ndarray
    tangent: np.ndarray
    arm: np.ndarray
    lateral: np.ndarray
    lever: np.ndarray
    delassus: np.ndarray
    coupling: np.ndarray
    shear: np.ndarray
    corner: np.ndarray
    weight: np.ndarray
    slot: np.ndarray
    """Index of the interaction in the list of neighbours, ascending, (m,) int32."""

    def cut(self, count: int) -> Interactions:
        """The first ``count`` interactions, as views."""
        return Interactions(*(a[:count] for a in self))


def empty_interactions(
    capacity: int, central: bool, dimension: int, *, plain: bool = False, corners: int = 0
) -> Interactions:
    """Arrays for ``capacity`` interactions. ``central``: whether all contact points lie between the centres. ``plain``:
    whether all interactions of the scene are contacts in 3D with diagonal blocks of W. ``corners``: most corners that both
    sides of an interaction have."""
    in_space, on_elements = capacity if dimension == 3 else 0, capacity if corners else 0
    return Interactions(
        candidate=np.empty(capacity, np.uint32),
        antagonist=np.empty(capacity, np.uint32),
        gap=np.empty(capacity),
        normal=np.empty((capacity, dimension)),
        tangent=np.empty((in_space, 3)),
        arm=np.empty((capacity, 2)),
        # links come first, do not write these, and keep the zeros
        lateral=np.zeros((0 if central or dimension == 3 else capacity, 2)),
        lever=np.zeros((0 if central else in_space, 6)),
        delassus=np.empty((capacity, dimension)),
        coupling=np.empty(0 if plain else capacity),
        shear=np.empty((0 if plain else in_space, 2)),
        corner=np.zeros((on_elements, corners), np.uint32),
        weight=np.zeros((on_elements, (dimension + 1) * corners)),
        slot=np.empty(capacity, np.int32),
    )


def levers(s: Any, part: slice | np.ndarray) -> np.ndarray:
    """Points of some interactions of ``s``, these arrays or those of a step, seen from the centres of the candidates and of
    the antagonists, along the axes of space [m], (m, 2, d); new."""
    if len(s.lever):
        return s.lever[part].reshape(-1, 2, 3).copy()
    normal, arm = s.normal[part], s.arm[part]
    lever = np.stack([-arm[:, :1] * normal, arm[:, 1:] * normal], axis=1)
    if len(s.lateral):
        lever += s.lateral[part][:, :, None] * local_frames(normal)[:, 1][:, None, :]
    return lever


def with_spare_rows(*shape: int, fill: float | None = None, dtype: Any = float) -> np.ndarray:
    """An array of this shape, a view of the first rows of an array with up to an eighth more rows.

    An array that is slightly longer than the last does not fit into the memory that the last has freed, and such holes
    let the memory of a process grow: by 400 bytes a body at 100 000 spheres. With spare rows lengths repeat.
    """
    count = shape[0]
    if count <= FEW:
        array = np.empty(shape, dtype)
        if fill is not None:
            array.fill(fill)
        return array
    step = max(64, 1 << max(count.bit_length() - 4, 0))
    array = np.empty((-(-count // step) * step, *shape[1:]), dtype)[:count]
    if fill is not None:
        array[:] = fill
    return array


def copy_with_spare_rows(array: np.ndarray) -> np.ndarray:
    """A copy of an array, with memory as :func:`with_spare_rows` has it."""
    if len(array) <= FEW:
        return array.copy()
    copied = with_spare_rows(*array.shape, dtype=array.dtype)
    copied[:] = array
    return copied
