"""How tension decays along wires: its correlation, and the lengths over which links pull without a break."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.measure.moment import Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.measure.wire_links import WireLinks, pulling_links


@dataclass(frozen=True, repr=False)
class TensionCorrelation(Table):
    """Correlation of the tensions of two links over their distance along the wire, lag by lag from 0, (k,) each."""

    lag: np.ndarray
    """Number of links by which the two are apart, (k,)."""
    distance: np.ndarray
    """Length of wire between the two, ``lag`` times the mean length of a link [m], (k,)."""
    correlation: np.ndarray
    """``C = <dT_i dT_{i+k}> / <dT^2>``, dT the tension less its mean over all links, (k,); NaN if all are equal."""
    error: np.ndarray
    """Standard error by Bartlett's formula, ``sqrt((1 + 2 sum_{j<k} C_j^2) / count)``, (k,); 0 at lag 0."""
    count: np.ndarray
    """Number of pairs of links, (k,)."""

    @property
    def correlation_length(self) -> float:
        """Integral of C over the distance, from 0 up to the first lag where C is not positive, by the trapezoidal rule [m].

        It is the decay length b of ``exp(-s/b)``, and half a link if neighbours are independent; NaN without a variance.
        """
        if not len(self) or np.isnan(self.correlation).any():
            return float("nan")
        low = np.flatnonzero(self.correlation <= 0.0)
        c = self.correlation[: low[0] if len(low) else len(self)]
        link = float(self.distance[1]) if len(self) > 1 else 0.0
        return link * float(c.sum() - 0.5 * (c[0] + (0.0 if len(low) else c[-1])))


@named_arguments
def tension_correlation(sim: Source, *, frame: int | None = None, lags: int = 100) -> TensionCorrelation:
    """Autocorrelation of the tension along all chains, in the last step of a simulation or in the step of a ``frame``.

    It is given for 0 to ``lags`` links, and not beyond half of the longest chain. Slack links count, with tension 0. Links
    of two chains are no pair; a closed chain is taken as open.
    """
    most = whole(lags, "lags", minimum=1)
    return correlation_of(pulling_links(moment(sim, frame, "tension_correlation")), most)


def correlation_of(links: WireLinks, lags: int) -> TensionCorrelation:
    """The correlation of the tensions of links for 0 to ``lags`` links."""
    longest = int(np.bincount(links.chain).max()) if len(links) else 0
    last = min(lags, longest // 2)
    rest = links.tension - links.tension.mean() if len(links) else links.tension
    covariance, pairs = np.zeros((2, last + 1 if len(links) else 0))
    for k in range(len(pairs)):
        same = links.chain[k:] == links.chain[: len(links) - k]
        pairs[k] = same.sum()
        covariance[k] = (rest[k:] * rest[: len(links) - k])[same].sum() / max(pairs[k], 1.0)
    scale = float(np.abs(links.tension).max(initial=0.0))
    even = not len(links) or covariance[0] <= (1e-12 * scale) ** 2
    c = np.full(len(pairs), np.nan) if even else covariance / covariance[0]
    grown = np.cumsum(np.append(0.0, c[1:] ** 2))[: len(pairs)]
    error = np.sqrt((1.0 + 2.0 * np.append(0.0, grown[:-1])[: len(pairs)]) / np.maximum(pairs, 1.0))
    error[:1] = 0.0
    lag = np.arange(len(pairs))
    return TensionCorrelation(lag, lag * (links.length.mean() if len(links) else 0.0), c, error, pairs.astype(np.int64))


@dataclass(frozen=True, repr=False)
class TautRuns(Table):
    """The r runs of links that pull one after the other, between slack links or the ends of their chain."""

    chain: np.ndarray
    """Number of the chain, (r,)."""
    first: np.ndarray
    """Number of the first link in its chain, (r,)."""
    links: np.ndarray
    """Number of links, (r,)."""
    length: np.ndarray
    """Length [m], (r,)."""
    greatest: np.ndarray
    """Greatest tension [N], (r,)."""
    mean: np.ndarray
    """Mean tension [N], (r,)."""

    @property
    def mean_length(self) -> float:
        """Mean length of the run that a taut link belongs to, ``sum L^2 / sum L`` [m]; NaN without any."""
        return float((self.length**2).sum() / self.length.sum()) if len(self) else float("nan")

    @property
    def anchorage(self) -> float:
        """``q = 2 sum L T_max / sum L^2`` [N/m], NaN without any: the friction per length by which ``T_max = q L/2`` fits
        best. This is the tension in the middle of a run that sand holds from both ends toward it."""
        return 2.0 * float((self.length * self.greatest).sum() / (self.length**2).sum()) if len(self) else float("nan")


@named_arguments
def taut_runs(sim: Source, *, frame: int | None = None) -> TautRuns:
    """Runs of consecutive links that pull, in the last step of a simulation or in the step of a ``frame`` of an open run.

    In a closed chain a run may pass the link at which counting begins: it has the number of its first link.
    """
    now = moment(sim, frame, "taut_runs")
    return runs_of(pulling_links(now), np.asarray(now.scene["chains"]["closed"], dtype=bool))


def runs_of(links: WireLinks, closed: np.ndarray) -> TautRuns:
    """The runs among links; ``closed``: whether each of the c chains is closed, (c,) bool."""
    rows: list[tuple[int, int, np.ndarray]] = []
    for chain in np.unique(links.chain).tolist():
        mine = np.flatnonzero(links.chain == chain)
        taut = links.taut[mine]
        begin = 0
        if closed[chain] and not taut.all():
            begin = int(np.argmin(taut))  # a slack link: no run leads over it
        order = np.roll(np.arange(len(mine)), -begin)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], taut[order], [False]]).astype(np.int8)))
        rows += [(chain, int(order[a]), mine[order[a:b]]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return TautRuns(
        chain=np.array([chain for chain, _, _ in rows], dtype=np.int64),
        first=np.array([first for _, first, _ in rows], dtype=np.int64),
        links=np.array([len(part) for _, _, part in rows], dtype=np.int64),
        length=np.array([links.length[part].sum() for _, _, part in rows], dtype=float),
        greatest=np.array([links.tension[part].max() for _, _, part in rows], dtype=float),
        mean=np.array([links.tension[part].mean() for _, _, part in rows], dtype=float),
    )
