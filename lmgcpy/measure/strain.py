"""Strain between two frames of a run, or since an earlier state: around each body, and of the sample as a whole.

The strain of the sample is one displacement gradient fitted to the displacements of its bodies, beside the gradient of the
box.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.lattice import Lattice
from lmgcpy.errors import named_arguments, number, one_of, shown, vector
from lmgcpy.measure.moment import Moment, Motion, Source, moment, motion
from lmgcpy.measure.table import Table
from lmgcpy.writing import html_of_fields

BLOCKS = {2: 4, 3: 3}
"""Blocks along each axis that are left out in turn for the standard error, by dimension: 16 and 27 in all."""
KINDS = ("all", "grains", "beads")


@dataclass(frozen=True, repr=False)
class LocalStrain(Table):
    """The p bodies with bounds, hidden ones left out; d dimensions."""

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
    body = np.flatnonzero(moved_from.bounded)
    before, after = moved_from.begin[body], moved_from.end[body]
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


@dataclass(frozen=True)
class MeanStrain:
    """The gradient G that fits the displacements of p bodies best, ``u = mean + G (x - centre) + rest``; d dimensions."""

    gradient: np.ndarray
    """Displacement gradient ``du_i/dx_j``, (d, d)."""
    standard_error: np.ndarray
    """Standard errors of its components, (d, d); NaN for a few bodies."""
    box: np.ndarray
    """The gradient of the box, (d, d): on the diagonal the change of the distance of opposite walls over this distance, in
    a periodic cell the change of its edges. NaN if there is neither."""
    centre: np.ndarray
    """Mean position of the bodies at the beginning [m], (d,)."""
    mean: np.ndarray
    """Mean displacement of the bodies [m], (d,)."""
    body: np.ndarray
    """Ids of the bodies, (p,)."""
    position: np.ndarray
    """Their positions at the beginning [m], (p, d)."""
    rest: np.ndarray
    """Displacements less the fitted field, their non-affine part [m], (p, d)."""
    non_affine_share: float
    """``sum |rest|^2 / sum |u - mean|^2``: 0 for an affine field, 1 if the gradient explains nothing; NaN at rest."""

    @property
    def strain(self) -> np.ndarray:
        """Symmetric part of the gradient, extension positive, (d, d)."""
        return 0.5 * (self.gradient + self.gradient.T)

    @property
    def rotation(self) -> np.ndarray:
        """Antisymmetric part of the gradient, (d, d)."""
        return 0.5 * (self.gradient - self.gradient.T)

    @property
    def non_affine(self) -> float:
        """Root mean square of the non-affine part [m]."""
        return float(np.sqrt((self.rest**2).sum(axis=1).mean()))

    @property
    def volumetric(self) -> float:
        """Change of the volume over the volume, ``det(1 + G) - 1``, dilation positive."""
        return float(np.linalg.det(np.eye(len(self.gradient)) + self.gradient)) - 1.0

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Affine displacements at places (m, d) [m]: ``mean + G (x - centre)``, (m, d)."""
        return self.mean + (positions - self.centre) @ self.gradient.T

    def __repr__(self) -> str:
        return (
            f"<MeanStrain of {len(self.body)} bodies: volume {self.volumetric:+.3g}, non-affine {self.non_affine:.3g} m, "
            f"{self.non_affine_share:.2g} of the squares>"
        )

    def _repr_html_(self) -> str:
        return html_of_fields(self)


@named_arguments
def mean_strain(
    sim: Source,
    *,
    frame: int | None = None,
    since: Any = 0,
    window: Any = None,
    margin: float = 0.0,
    kind: str = "all",
) -> MeanStrain:
    """Fit one displacement gradient to the displacements of the bodies with bounds, hidden ones left out.

    In an open run the displacements are from the frame ``since``, by default the first, to ``frame``, by default the last.
    In a simulation they are from positions that were copied earlier, ``since=sim.positions.copy()`` [m], (n, d), to the
    present positions. The fit minimises ``sum |u - mean - G (x - centre)|^2`` with equal weights, x the positions at the
    beginning.

    ``window``: two corners ((x, y), (x, y)) [m], with z in 3D: bodies whose centres lay there at the beginning.
    ``margin``: bodies whose centres were farther than this from every plane wall [m]; it leaves out layers at walls.
    ``kind``: "all", "grains" (bodies of no chain) or "beads".

    The standard error is a jackknife: the bodies are sorted into 16 blocks of space in 2D, 27 in 3D; G is fitted again
    without each block, and B blocks give ``var = (B - 1)/B sum (G_b - mean of G_b)^2``. So displacements of neighbours may
    be correlated, as they are in sand, as far as a block reaches.

    Raises ValueError for fewer than d + 1 bodies, and for bodies in a line or plane.

    Grains that move with a cell that is sheared have its gradient:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2)
    >>> cell = scene.periodic(x=1.0, y=1.0).impose_rate(xy=2.0)
    >>> places = [(0.2, 0.2), (0.8, 0.3), (0.4, 0.8)]
    >>> grains = [scene.add(lm.disk(radius=0.05, position=p, mass=1.0)) for p in places]
    >>> sim = lm.Simulation(scene, time_step=1e-3)
    >>> start = sim.positions.copy()
    >>> lm.measure.mean_strain(sim.run(duration=0.05), since=start).gradient.round(9) + 0.0
    array([[0. , 0.1],
           [0. , 0. ]])
    """
    return strain_of(moment(sim, frame, "mean_strain"), motion(sim, frame, since, "mean_strain"), window, margin, kind)


def strain_of(now: Moment, moved: Motion, window: Any = None, margin: Any = 0.0, kind: Any = "all") -> MeanStrain:
    """The fit of a motion that ends at a moment."""
    begin, d = moved.begin, moved.begin.shape[1]
    chosen = moved.bounded.copy()
    if one_of(kind, "kind", KINDS) != "all":
        chosen &= now.beads == (kind == "beads")
    if window is not None:
        if not isinstance(window, (tuple, list, np.ndarray)) or len(window) != 2:
            raise TypeError(f"window must be two corners such as ((0, 0), (1, 2)) [m], got {shown(window)}.")
        low, high = (vector(corner, "a corner of window", d) for corner in window)
        if not (low < high).all():
            raise ValueError(f"window must be its low corner and its high corner [m], got {shown(window)}.")
        chosen &= ((low <= begin) & (begin <= high)).all(axis=1)
    if number(margin, "margin", minimum=0.0, unit="m") > 0.0:
        for wall, normal in now.wall_normals.items():
            chosen &= np.abs((begin - begin[wall]) @ normal) > margin
    body = np.flatnonzero(chosen)
    x, u = begin[body], (moved.end - begin)[body]
    if len(body) <= d or _flat(x - x.mean(axis=0)):
        raise ValueError(
            f"mean_strain needs at least {d + 1} bodies that lie in no line or plane, there are {len(body)}"
            + ("." if window is None and not margin and kind == "all" else ": take a larger window or another kind.")
        )
    centre, mean, gradient = fit(x, u)
    rest = u - mean - (x - centre) @ gradient.T
    spread = float(((u - mean) ** 2).sum())
    return MeanStrain(
        gradient=gradient,
        standard_error=_jackknife(x, u),
        box=_box_gradient(now, moved, gradient),
        centre=centre,
        mean=mean,
        body=body,
        position=x,
        rest=rest,
        non_affine_share=float((rest**2).sum()) / spread if spread > 0.0 else math.nan,
    )


def fit(x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centre (d,), mean displacement (d,) and gradient (d, d) of the best fit to displacements u at places x, (p, d)."""
    centre, mean = x.mean(axis=0), u.mean(axis=0)
    dx, du = x - centre, u - mean
    # normal equations: G (sum dx dx^T) = sum du dx^T
    return centre, mean, np.linalg.solve(dx.T @ dx, dx.T @ du).T


def _flat(dx: np.ndarray) -> bool:
    """Whether places (p, d) around their centre lie in a line or plane."""
    size = np.linalg.svd(dx, compute_uv=False)
    return bool(size[-1] <= 1e-9 * size[0])


def _jackknife(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Standard errors of the gradient by leaving out blocks of space, (d, d); NaN where a block holds too much."""
    d, low = x.shape[1], x.min(axis=0)
    along = BLOCKS[d]
    cell = np.minimum((along * (x - low) / np.ptp(x, axis=0)).astype(np.int64), along - 1)
    block = np.ravel_multi_index(tuple(cell.T), (along,) * d)
    found = []
    for one in np.unique(block):
        kept = block != one
        if kept.sum() <= d or _flat(x[kept] - x[kept].mean(axis=0)):
            return np.full((d, d), np.nan)
        found.append(fit(x[kept], u[kept])[2])
    deviation = np.array(found) - np.mean(found, axis=0)
    return np.sqrt((1.0 - 1.0 / len(found)) * (deviation**2).sum(axis=0))


def _box_gradient(now: Moment, moved: Motion, fitted: np.ndarray) -> np.ndarray:
    """Gradient of the box between opposite walls and of the periodic cell, (d, d); NaN if there is neither."""
    begin, end = moved.begin, moved.end
    d = begin.shape[1]
    axes = np.zeros(0, dtype=np.int64) if now.lattice is None else now.lattice.axes
    across = _walls_across(now.wall_normals, [k for k in range(d) if k not in axes])
    if len(across) + len(axes) < d:
        return np.full((d, d), np.nan)
    found = np.zeros((d, d))
    for axis, (one, other) in across.items():
        found[axis, axis] = (end[one] - end[other])[axis] / (begin[one] - begin[other])[axis] - 1.0
    if now.lattice is not None:
        found += _edges_gradient(now.lattice, begin, end, fitted, across)
    return found


def _edges_gradient(
    lattice: Lattice, begin: np.ndarray, end: np.ndarray, fitted: np.ndarray, across: dict[int, tuple[int, int]]
) -> np.ndarray:
    """The part of the edges of a periodic cell in the gradient, (d, d)."""
    before, after = edges_then_and_now(lattice, begin, end, fitted)
    change = np.zeros_like(fitted)
    change[:, lattice.axes] = (after - before).T
    return change @ np.linalg.inv(lattice.basis(before))


def edges_then_and_now(
    lattice: Lattice, begin: np.ndarray, end: np.ndarray, gradient: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Edges of the periodic cell at the beginning, and the same edges at the end [m], (p, d) each.

    A cell that was straightened has other edges of the same lattice: the edges at the end are the vectors of the lattice
    nearest to the old edges carried by the gradient.
    """
    before, after = lattice.edges(begin), lattice.edges(end)
    carried = before @ (np.eye(len(gradient)) + gradient).T
    return before, np.rint(lattice.reduced(carried, after)) @ after


def _walls_across(normals: dict[int, np.ndarray], axes: list[int]) -> dict[int, tuple[int, int]]:
    """Ids of two walls that face each other across each of the axes that has such a pair."""
    found = {}
    for axis in axes:
        at = [body for body, n in normals.items() if abs(abs(n[axis]) - 1.0) < 1e-12]
        pairs = [(one, other) for one in at for other in at if normals[one][axis] > 0.0 > normals[other][axis]]
        if pairs:
            found[axis] = pairs[0]
    return found
