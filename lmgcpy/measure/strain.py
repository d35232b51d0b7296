"""Displacements and local strain between two frames of a run, or since an earlier state of a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import named_arguments, numbers, shown, whole
from lmgcpy.measure.sources import RecordedRun, is_run
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
def strain(sim: RecordedRun | Stepper, *, frame: int | None = None, since: Any = 0) -> LocalStrain:
    """Displacements since an earlier state, and the strain around each body.

    Of an open run, from a frame ``since``, by default the first, to a ``frame``, by default the last. Of a simulation, from
    positions that were copied earlier, ``since=sim.positions.copy()`` [m], (n, d), to those of now.

    The neighbours of a body are those of the Delaunay triangulation of the centres at the beginning. The gradient G is
    the least-squares fit of their relative displacements, ``minimise sum |du - G dx|^2``, and ``rest`` is what is left
    (Falk and Langer, Phys. Rev. E 57, 1998, whose D^2_min is the sum). An affine field is found to round-off.
    In a periodic cell bodies across its faces do not count as neighbours.
    """
    from scipy.spatial import Delaunay, QhullError  # takes as long to import as the rest of lmgcpy

    if isinstance(sim, Stepper):
        if frame is not None:
            raise TypeError("frame is for run files: a simulation knows its last step only.")
        extent, end = sim.model.extent, sim.positions
        begin = numbers(since, "since of a simulation", "positions copied earlier, sim.positions.copy() [m]")
        if begin.shape != end.shape:
            raise ValueError(
                f"since of a simulation must be positions of all its bodies, copied earlier, {end.shape} [m], got an array "
                f"of shape {begin.shape}: since=sim.positions.copy()."
            )
    elif is_run(sim):
        first = whole(since, "since", minimum=-(2**62))
        last = -1 if frame is None else whole(frame, "frame", minimum=-(2**62))
        extent, begin, end = sim.extent, sim.positions[first], sim.positions[last]
    else:
        raise TypeError(f"strain takes a simulation or a run file that lmgcpy.io.open_run opens, got {shown(sim)}.")
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
