"""Displacements and local strain between two frames of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, shown, whole
from lmgcpy.measure.sources import RecordedRun, is_run
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class LocalStrain(Table):
    """The p bodies with bounds; d dimensions."""

    body: np.ndarray
    """Ids, (p,)."""
    position: np.ndarray
    """Centres at the first of the two frames [m], (p, d)."""
    displacement: np.ndarray
    """From there to the second [m], (p, d)."""
    gradient: np.ndarray
    """Displacement gradient around each body, ``du_i/dx_j``, (p, d, d); NaN for a body whose neighbours lie in a line."""
    rest: np.ndarray
    """Mean square of what the gradient leaves of the neighbours' displacements [m^2], (p,): large at rearrangements."""

    @property
    def strain(self) -> np.ndarray:
        """Symmetric part of the gradient, extension positive, (p, d, d)."""
        return 0.5 * (self.gradient + self.gradient.swapaxes(1, 2))


@named_arguments
def strain(run: RecordedRun, *, frame: int = -1, since: int = 0) -> LocalStrain:
    """Displacements from a frame ``since`` to a ``frame`` of an open run, and the strain around each body.

    The neighbours of a body are those of the Delaunay triangulation of the centres at the first frame. The gradient G is
    the least-squares fit of their relative displacements, ``minimise sum |du - G dx|^2``, and ``rest`` is what is left
    (Falk and Langer, Phys. Rev. E 57, 1998, whose D^2_min is the sum). An affine field is found to round-off.
    In a periodic cell bodies across its faces do not count as neighbours.
    """
    from scipy.spatial import Delaunay, QhullError  # takes as long to import as the rest of lmgcpy

    if not is_run(run):
        raise TypeError(f"run must be a run file that lmgcpy.io.open_run opens, got {shown(run)}.")
    first, last = (whole(k, name, minimum=-(2**62)) for k, name in ((since, "since"), (frame, "frame")))
    body = np.flatnonzero(np.isfinite(run.extent))
    before, after = run.positions[first][body], run.positions[last][body]
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
