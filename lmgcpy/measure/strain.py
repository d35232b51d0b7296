"""Displacements and local strain between two frames of a run, or since an earlier state of a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments
from lmgcpy.measure.moment import Source, motion
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class LocalStrain(Table):
    """The p bodies with bounds; d dimensions."""

    body: np.ndarray
    """Ids, (p,)."""
    position: np.ndarray
    """Centres at the beginning [m], (p, d)."""
    displacement: np.ndarray
    """From there to the end [m], (p, d)."""
    gradient: np.ndarray
    """Displacement gradient around each body, ``du_i/dx_j``, (p, d, d); NaN for a body whose neighbours lie in a line."""
    rest: np.ndarray
    """Mean square of what the gradient leaves of the neighbours' displacements [m^2], (p,): large at rearrangements."""

    @property
    def strain(self) -> np.ndarray:
        """Symmetric part of the gradient, extension positive, (p, d, d)."""
        return 0.5 * (self.gradient + self.gradient.swapaxes(1, 2))


@named_arguments
def strain(sim: Source, *, frame: int | None = None, since: Any = 0) -> LocalStrain:
    """Displacements since an earlier state, and the strain around each body.

    In an open run they are from the frame ``since``, by default the first, to ``frame``, by default the last. In a
    simulation they are from positions that were copied earlier, ``since=sim.positions.copy()`` [m], (n, d), to the present
    positions.

    The neighbours of a body are its neighbours in the Delaunay triangulation of the centres at the beginning. The gradient
    G is the least-squares fit of their relative displacements, ``minimise sum |du - G dx|^2``; ``rest`` measures the
    remainder (Falk and Langer, Phys. Rev. E 57, 1998, whose D^2_min is the sum). An affine field is found to round-off.
    In a periodic cell bodies across its faces do not count as neighbours.
    """
    from scipy.spatial import Delaunay, QhullError  # takes as long to import as the rest of lmgcpy

    moved_from = motion(sim, frame, since, "strain")
    begin, end, extent = moved_from.begin, moved_from.end, moved_from.extent
    body = np.flatnonzero(np.isfinite(extent))
    before, after = begin[body], end[body]
    moved, d = after - before, before.shape[1]
    try:
        start, neighbours = Delaunay(before).vertex_neighbor_vertices
    except (QhullError, ValueError) as error:
        raise ValueError(
            f"strain needs at least {d + 1} bodies that lie in no line or plane, there are {len(body)}."
        ) from error
    own = np.repeat(np.arange(len(body)), np.diff(start))
    dx, du = before[neighbours] - before[own], moved[neighbours] - moved[own]
    # normal equations of the fit: G (sum dx dx^T) = sum du dx^T
    spread, product = np.zeros((2, len(body), d, d))
    np.add.at(spread, own, dx[:, :, None] * dx[:, None, :])
    np.add.at(product, own, du[:, :, None] * dx[:, None, :])
    flat = np.linalg.cond(spread) > 1e12
    spread[flat] = np.eye(d)
    gradient = np.linalg.solve(spread, product.swapaxes(1, 2)).swapaxes(1, 2)
    left = du - np.einsum("mij,mj->mi", gradient[own], dx)
    rest = np.bincount(own, weights=(left * left).sum(axis=1), minlength=len(body)) / np.maximum(np.diff(start), 1)
    gradient[flat] = np.nan
    rest[flat] = np.nan
    return LocalStrain(body, before, moved, gradient, rest)
