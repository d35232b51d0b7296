"""Fabric of the wire: its length per volume, its directions, and its tension by direction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number
from lmgcpy.measure.directions import DirectionBins, means_along
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.stress import sample_volume
from lmgcpy.measure.table import Table
from lmgcpy.measure.wire_links import links_of, pulling_links


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
