"""The links of all wires: positions, directions, slack and tensions; and over what length along a wire tension decays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class WireLinks(Table):
    """The l links of all chains, chain after chain, each from its first body to its last; d dimensions."""

    chain: np.ndarray
    """Number of the chain, (l,)."""
    pairs: np.ndarray
    """Ids of candidate and antagonist, (l, 2)."""
    along: np.ndarray
    """Length of wire from the start of the chain up to the middle of the link [m], (l,)."""
    position: np.ndarray
    """Middle of the link [m], (l, d)."""
    direction: np.ndarray
    """Unit vectors from the antagonist to the candidate, (l, d); zero where the two coincide."""
    length: np.ndarray
    """Distance between the centres [m], (l,)."""
    reference_length: np.ndarray
    """Reference gap and both radii [m], (l,)."""
    slack: np.ndarray
    """``(reference length - length) / reference length``, (l,): the strain at which a slack link begins to pull; negative
    for a link that is stretched."""
    tension: np.ndarray
    """Tension, a push negative [N], (l,); NaN before the first step."""

    @property
    def stretch(self) -> np.ndarray:
        """``(length - reference length) / reference length``, (l,): the opposite of the slack."""
        return -self.slack

    @property
    def taut(self) -> np.ndarray:
        """Whether the link pulls, (l,) bool."""
        return self.tension > 0.0


@named_arguments
def wire_links(sim: Source, *, frame: int | None = None) -> WireLinks:
    """The links of all chains after the last step of a simulation, or at a ``frame`` of an open run; empty without chains.

    Lengths and directions are taken at the end of the step, tensions are means over the step. While a chain relaxes to its
    reference (``relaxation=``), the reference length is the one at the end of the relaxation.

    A load of 10 N on a wire of two links:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> beads = [scene.add(lm.disk(radius=0.01, position=(0.0, -0.1 * i), mass=0.5)) for i in range(3)]
    >>> hook = beads[0].fix()
    >>> chain = scene.chain(beads, lm.RigidWire())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=10)
    >>> lm.measure.wire_links(sim).tension.round(9)
    array([10.,  5.])
    """
    return links_of(moment(sim, frame, "wire_links"))


def links_of(now: Moment) -> WireLinks:
    """The links of a moment."""
    chain, pairs = chain_pairs(now)
    courses = [one.course(now.lattice, now.positions, now.rotations) for one in now.chains]
    branch = np.concatenate([np.zeros((0, now.positions.shape[1])), *(np.diff(course, axis=0) for course in courses)])
    places = [one.places(now.positions, now.rotations)[:-1] for one in now.chains]
    begin = np.concatenate([np.zeros((0, now.positions.shape[1])), *places])
    length = np.linalg.norm(branch, axis=1)
    radius = np.concatenate([np.zeros(0), *(one.radius[:-1] + one.radius[1:] for one in now.chains)])
    reference = now.reference_gaps + radius
    force = now.net.force[: len(pairs), 0] if len(now.net) else np.full(len(pairs), np.nan)
    return WireLinks(
        chain=chain,
        pairs=pairs,
        along=_middles(length, chain),
        position=begin + 0.5 * branch,
        direction=np.divide(branch, length[:, None], out=np.zeros_like(branch), where=length[:, None] > 0.0),
        length=length,
        reference_length=reference,
        slack=1.0 - length / reference,
        tension=0.0 - force,  # slack: 0, not -0
    )


def pulling_links(now: Moment) -> WireLinks:
    """The links of a moment; ValueError if there was no step yet, and so no tension."""
    links = links_of(now)
    if np.isnan(links.tension).any():
        raise ValueError("There is no step yet, and so no tension: run the simulation first, or take a later frame.")
    return links


def chain_pairs(now: Moment) -> tuple[np.ndarray, np.ndarray]:
    """Chain of each link, (l,), and ids of its candidate and antagonist, (l, 2), from the description of the scene: the
    links come first among the interactions, in this order."""
    pairs = [np.column_stack([one.path[1:], one.path[:-1]]) for one in now.chains]
    number = np.repeat(np.arange(len(pairs)), [len(of_chain) for of_chain in pairs])
    return number, np.concatenate([np.zeros((0, 2), dtype=np.int64), *pairs])


def _middles(length: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Length of wire up to the middle of each link [m], (l,), counted anew in each chain."""
    end = np.cumsum(length)
    first = np.searchsorted(chain, np.arange(chain[-1] + 1 if len(chain) else 0))
    start = np.concatenate([[0.0], end])[first]
    return end - 0.5 * length - start[chain]


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
