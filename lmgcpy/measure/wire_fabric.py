"""Fabric of the wire: its length per volume, and its directions, tension and stretch in bins by angle to an axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, named_arguments, number, one_of, shown, vector, whole
from lmgcpy.measure.moment import Moment, Source, moment, motion
from lmgcpy.measure.strain import strain_of
from lmgcpy.measure.stress import sample_volume
from lmgcpy.measure.table import Table
from lmgcpy.measure.wire_links import links_of, pulling_links
from lmgcpy.writing import html_of_fields


@dataclass(frozen=True)
class DirectionBins:
    """Bins of the angle between a direction and an axis, from 0 to 90 degrees; a direction and its opposite count as one.

    In 2D the angle is divided evenly, in 3D its cosine, so that each bin has the same solid angle: isotropic directions
    fill all bins alike.
    """

    axis: np.ndarray
    """Unit vector, (d,)."""
    edges: np.ndarray
    """Bounds of the bins, ascending [degrees], (b + 1,)."""

    @classmethod
    def along(cls, axis: Any, bins: Any, dimension: int) -> DirectionBins:
        """So many ``bins`` of the angle to an ``axis``: "x", "y", "z" or a vector (d,), by default upward."""
        count = whole(bins, "bins", minimum=1, maximum=10_000)
        names = AXES[:dimension]
        if axis is None or isinstance(axis, str):
            unit = np.eye(dimension)[names.index(one_of(names[-1] if axis is None else axis, "axis", names))]
        else:
            given = vector(axis, "axis", dimension)
            size = float(np.linalg.norm(given))
            if size == 0.0:
                raise ValueError(f"axis must have a direction, got {shown(axis)}.")
            unit = given / size
        part = np.linspace(0.0, 1.0, count + 1)
        edges = 90.0 * part if dimension == 2 else np.degrees(np.arccos(1.0 - part))
        return cls(unit, edges)

    @property
    def count(self) -> int:
        """Number of bins b."""
        return len(self.edges) - 1

    def of(self, directions: np.ndarray) -> np.ndarray:
        """The bin of each unit vector (m, d): (m,)."""
        cosine = np.minimum(np.abs(directions @ self.axis), 1.0)
        part = np.arccos(cosine) / (0.5 * np.pi) if directions.shape[1] == 2 else 1.0 - cosine
        return np.minimum((part * self.count).astype(np.int64), self.count - 1)


def means_along(
    values: np.ndarray, bins: np.ndarray, count: int, chain: np.ndarray, reach: int | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of the values (m,) in each of ``count`` bins and its standard error, (count,) each; NaN in empty bins.

    Values that follow each other along a wire are not independent. The variance of the mean is the estimate of Newey and
    West (Econometrica 55, 1987): with r the values less their mean, over pairs of one bin and one chain,

        n^2 var = sum r_i^2 + 2 sum_k (1 - k/(K + 1)) sum_i r_i r_{i+k},    k = 1 ... K,

    times n/(n - 1), as the mean is taken from the same values. K is ``reach``, by default ``4 (m/100)^(2/9)`` (their rule
    of 1994), at most m - 1. If the correlation reaches beyond K, the variance is somewhat too small.
    """
    size = np.bincount(bins, minlength=count).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.bincount(bins, weights=values, minlength=count) / size
        rest = values - mean[bins]
        variance: np.ndarray = np.bincount(bins, weights=rest * rest, minlength=count)
        last = int(4.0 * (len(values) / 100.0) ** (2.0 / 9.0)) if reach is None else reach
        last = min(last, len(values) - 1)
        for k in range(1, last + 1):
            same = (bins[k:] == bins[:-k]) & (chain[k:] == chain[:-k])
            product = (rest[k:] * rest[:-k])[same]
            sums = np.bincount(bins[k:][same], weights=product, minlength=count)
            variance = variance + 2.0 * (1.0 - k / (last + 1)) * sums
        error = np.sqrt(np.maximum(variance, 0.0) * size / (size - 1.0)) / size
    return mean, np.where(size > 1, error, np.nan)


@dataclass(frozen=True)
class WireFabric:
    """Amount, directions and slack of the wire, in d dimensions; its l links are the parts."""

    link_count: int
    """Number of links of all chains, l."""
    length: float
    """Length of all wires, ``sum l_i`` [m]."""
    volume: float
    """Volume of the sample [m^3, per metre of depth in 2D]; NaN if it is not known."""
    fabric: np.ndarray
    """``sum l_i t_i (x) t_i / sum l_i``, t the directions of the links, of trace 1, (d, d); zero without a wire. For an
    isotropic wire it is 1/d times the unit tensor."""
    fabric_error: np.ndarray
    """Standard errors of its components, (d, d), with the correlation of links along a wire."""
    taut_share: float
    """Share of the length that pulls; NaN without a wire or before the first step."""
    slack: float
    """Mean slack of the links that do not pull, ``(reference length - length) / reference length``; NaN without any."""

    @property
    def length_per_volume(self) -> float:
        """Length of wire per volume of the sample [1/m^2, in 2D 1/m]; NaN if the volume is not known."""
        return self.length / self.volume

    @property
    def anisotropy(self) -> float:
        """Greatest less smallest principal value of the fabric: 0 if no direction is preferred, 1 for parallel links."""
        principal = np.linalg.eigvalsh(self.fabric)
        return float(principal[-1] - principal[0])

    def __repr__(self) -> str:
        return f"<WireFabric: {self.link_count} links, {self.length:.4g} m of wire, anisotropy {self.anisotropy:.3f}>"

    def _repr_html_(self) -> str:
        return html_of_fields(self)


@named_arguments
def wire_fabric(sim: Source, *, frame: int | None = None, volume: float | None = None) -> WireFabric:
    """Fabric of the wire after the last step of a simulation, or at a ``frame`` of an open run.

    ``volume`` [m^3, per metre of depth in 2D] is by default the volume of the periodic cell, or of the box between
    opposite walls. In a scene without both the length per volume is NaN.
    """
    now = moment(sim, frame, "wire_fabric")
    d, links = now.positions.shape[1], links_of(now)
    length = float(links.length.sum())
    fabric, error = np.zeros((2, d, d))
    if len(links) and length > 0.0:
        dyads = links.direction[:, :, None] * links.direction[:, None, :]
        # to first order, error of a ratio of means = (error of the mean of l (t (x) t - fabric)) / (mean of l)
        fabric = np.einsum("l,lij->ij", links.length, dyads) / length
        rest = links.length[:, None, None] * (dyads - fabric)
        one = np.zeros(len(links), dtype=np.int64)
        for i, j in np.ndindex(d, d):
            error[i, j] = means_along(rest[:, i, j], one, 1, links.chain)[1][0] / links.length.mean()
    loose = links.tension <= 0.0
    stepped = length > 0.0 and not np.isnan(links.tension).any()
    return WireFabric(
        link_count=len(links),
        length=length,
        volume=volume_if_known(now, volume),
        fabric=fabric,
        fabric_error=error,
        taut_share=float(links.length[links.taut].sum()) / length if stepped else math.nan,
        slack=float(links.slack[loose].mean()) if loose.any() else math.nan,
    )


def volume_if_known(now: Moment, volume: Any) -> float:
    """The given volume, or the volume of the sample if None is given [m^d]; NaN if that is not known."""
    if volume is not None:
        return number(volume, "volume", above=0.0, unit=f"m^{now.positions.shape[1]}")
    try:
        return sample_volume(now)
    except ValueError:
        return math.nan


@dataclass(frozen=True, repr=False)
class TensionByDirection(Table):
    """Links by the angle of their direction to an axis, in b bins; d dimensions."""

    lower: np.ndarray
    """Least angle of each bin [degrees], (b,)."""
    upper: np.ndarray
    """Greatest angle of each bin [degrees], (b,)."""
    links: np.ndarray
    """Number of links, (b,)."""
    taut_share: np.ndarray
    """Share of the links that pull, (b,); NaN in an empty bin, as all means."""
    taut_share_error: np.ndarray
    """Its standard error, (b,)."""
    tension: np.ndarray
    """Mean tension of all links of the bin, slack ones included [N], (b,)."""
    tension_error: np.ndarray
    """Its standard error [N], (b,)."""
    pull: np.ndarray
    """``sum f l`` over the links, f their tensions [N m], (b,)."""
    stress: np.ndarray
    """Part of the links in the stress of the sample, ``(1/V) sum f l t (x) t`` [Pa], traction positive, (b, d, d); NaN
    if the volume V is not known. The sum over the bins is the stress of the laws of the chains."""


@named_arguments
def tension_by_direction(
    sim: Source, *, frame: int | None = None, axis: Any = None, bins: int = 9, volume: float | None = None
) -> TensionByDirection:
    """Tension of the links by direction, in the last step of a simulation or in the step of a ``frame`` of an open run.

    ``axis`` is "x", "y", "z" or a vector, by default upward. Directions are sorted by their angle to it, from 0 to 90
    degrees, into ``bins`` bins: of the same angle in 2D, of the same solid angle in 3D, so that an isotropic wire fills
    all alike. Directions and lengths are taken at the detection, as in :func:`stress`. Standard errors take the
    correlation of neighbouring links along a wire into account. ``volume`` as in :func:`wire_fabric`.

    Raises ValueError before the first step, if there are chains.
    """
    now = moment(sim, frame, "tension_by_direction")
    sorted_by = DirectionBins.along(axis, bins, now.positions.shape[1])
    links, count = pulling_links(now), sorted_by.count
    part = slice(0, len(links))
    normal, branch = now.net.normal[part], now.net.lever[part, 1] - now.net.lever[part, 0]
    where = sorted_by.of(normal)
    share, share_error = means_along(links.taut.astype(float), where, count, links.chain)
    tension, tension_error = means_along(links.tension, where, count, links.chain)
    dyads = links.tension[:, None, None] * normal[:, :, None] * branch[:, None, :]
    sums = np.zeros((count, *dyads.shape[1:]))
    np.add.at(sums, where, dyads)
    return TensionByDirection(
        lower=sorted_by.edges[:-1],
        upper=sorted_by.edges[1:],
        links=np.bincount(where, minlength=count),
        taut_share=share,
        taut_share_error=share_error,
        tension=tension,
        tension_error=tension_error,
        pull=np.trace(sums, axis1=1, axis2=2),
        stress=sums / volume_if_known(now, volume),
    )


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
