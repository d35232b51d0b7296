"""Stretch of the wire in each direction, and the stretch that the sample's mean strain would give."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.measure.directions import DirectionBins, means_along
from lmgcpy.measure.mean_strain import strain_of
from lmgcpy.measure.moment import Source, moment, motion
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class StretchByDirection(Table):
    """Pieces of wire by the angle of their direction at the beginning to an axis, in b bins."""

    lower: np.ndarray
    """Least angle of each bin [degrees], (b,)."""
    upper: np.ndarray
    """Greatest angle of each bin [degrees], (b,)."""
    pieces: np.ndarray
    """Number of pieces of wire, (b,)."""
    stretch: np.ndarray
    """Mean of ``(l - l0) / l0`` over the pieces, l the distance of their ends, (b,); NaN in an empty bin, as all means."""
    stretch_error: np.ndarray
    """Its standard error, (b,)."""
    affine: np.ndarray
    """Mean of ``n.eps.n`` over the same pieces, n their directions at the beginning and eps the mean strain, (b,)."""
    affine_finite: np.ndarray
    """Mean of ``|(1 + G) n| - 1``, G the displacement gradient of the mean strain: the same at finite strain, (b,)."""
    difference: np.ndarray
    """Mean of the stretch less its affine value at finite strain, (b,)."""
    difference_error: np.ndarray
    """Its standard error, (b,)."""


@named_arguments
def stretch_by_direction(
    sim: Source,
    *,
    frame: int | None = None,
    since: Any = 0,
    axis: Any = None,
    bins: int = 9,
    links: int = 1,
    kind: str = "all",
) -> StretchByDirection:
    """Mean stretch of the wire by direction, and the stretch of the same pieces under the affine assumption.

    ``since`` and ``frame`` as in :func:`mean_strain`, which gives G and its symmetric part eps, fitted to the bodies of a
    ``kind``. ``axis`` and ``bins`` as in :func:`tension_by_direction`.

    A piece is the chord of ``links`` links: its length is the distance of its two end beads. Pieces follow each other
    without overlap; the links left at the end of a chain are not counted. Taut links keep their length, while the chord of
    several stretches as the wire straightens. Standard errors take the correlation of neighbouring pieces along
    a wire into account, but take the mean strain as known.
    """
    now, moved = moment(sim, frame, "stretch_by_direction"), motion(sim, frame, since, "stretch_by_direction")
    d, size = moved.begin.shape[1], whole(links, "links", minimum=1)
    sorted_by = DirectionBins.along(axis, bins, d)
    gradient = strain_of(now, moved, kind=kind).gradient
    starts, ends, chain = _pieces([one.path for one in now.chains], size)
    before, after = (at[ends] - at[starts] for at in (moved.begin, moved.end))
    length = np.linalg.norm(before, axis=1)
    sound = length > 0.0  # a wire may close on itself
    before, after, length, chain = before[sound], after[sound], length[sound], chain[sound]
    direction = before / length[:, None]
    where, count = sorted_by.of(direction), sorted_by.count
    stretch = np.linalg.norm(after, axis=1) / length - 1.0
    affine = np.einsum("li,ij,lj->l", direction, gradient, direction)
    finite = np.linalg.norm(direction @ (np.eye(d) + gradient).T, axis=1) - 1.0
    mean, error = means_along(stretch, where, count, chain)
    difference, difference_error = means_along(stretch - finite, where, count, chain)
    return StretchByDirection(
        lower=sorted_by.edges[:-1],
        upper=sorted_by.edges[1:],
        pieces=np.bincount(where, minlength=count),
        stretch=mean,
        stretch_error=error,
        affine=means_along(affine, where, count, chain)[0],
        affine_finite=means_along(finite, where, count, chain)[0],
        difference=difference,
        difference_error=difference_error,
    )


def _pieces(paths: list[np.ndarray], size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ids of the first and the last bead of the pieces of ``size`` links, and their chains, (m,) each."""
    nodes = [path[::size] for path in paths]
    none = np.zeros(0, dtype=np.int64)
    return (
        np.concatenate([none, *(node[:-1] for node in nodes)]),
        np.concatenate([none, *(node[1:] for node in nodes)]),
        np.concatenate([none, *(np.full(max(len(node) - 1, 0), k) for k, node in enumerate(nodes))]),
    )
