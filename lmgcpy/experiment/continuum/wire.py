"""The wire of a sample in the continuous model: its geometry at the start of a test, and its anchorage in the sand.

The local model takes each link as a separate wire that follows the mean strain, with the length per volume, the direction
and the slack of the link. The runs show that two things must be added, in the anchored model (docs/continuum.md):

* **span**: a wire slips along itself, so that a span of it shares one tension. Its length is the correlation length of
  the tension along the wire.
* **anchorage**: sand holds a wire with a force that grows with its pressure and as the wire slips. A wire that would pull
  more slips, and straightens. Its greatest tension is the tension of all links, shared out among the spans that the
  measured strain stretches, over the pressure of the sand; it is known at the mean slip of the spans, the part of their
  stretch that this tension leaves.

Both are measured in a run. In a sample of another width the same slip, relative to length, is another way along the sand.
If sand of the pressure p holds a wire by a force ``k p u`` a length, in proportion to the way u, and extends by e beside a
wire that does not, ``u = e s`` at the distance s from the middle of a wire that is free at ``s = a``, and from
``dT/ds = -k p u``::

    T = k p e (a^2 - s^2)/2,    of the mean k p e a^2/3.

So the tension at a given slip grows with the square of the width; once the force no longer grows with the way, it grows
with the width itself. Runs say the square from 11 to 18 grains, and the width from there to 25 (docs/continuum.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import isotonic_regression

from lmgcpy.continuum import Directions, GrowingAnchorage, WireNetwork, spans_of
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compression import CompressionRecord
from lmgcpy.io.run import Run
from lmgcpy.measure import tension_correlation, wire_links

EARLY = 0.2
"""Part of a test in which spans are not measured: much of the wire is slack there."""
LAGS = 400
"""Links over which the tension is correlated at most."""


@dataclass(frozen=True)
class Anchorage:
    """How the sand holds a wire in a sample."""

    width: float
    """Length of the sample along the wire [m]."""
    span: float
    """Length of wire that shares a tension [m]."""
    slip: np.ndarray
    """Mean slips of the spans, growing (n,)."""
    strength: np.ndarray
    """Greatest tension over the pressure of the sand at these slips [m^2], in 2D [m], (n,)."""

    def at(self, width: float) -> Anchorage:
        """The anchorage in a sample of another width [m]: at the same slips, the tension goes with the square of it. (Too
        much for samples wider than 18 grains, by a third at 25.)"""
        ratio = width / self.width
        return Anchorage(width, ratio * self.span, self.slip, ratio**2 * self.strength)


@dataclass(frozen=True)
class LaidWire:
    """The l links of the wires of a sample, in d dimensions."""

    direction: np.ndarray
    """(l, d)."""
    length: np.ndarray
    """Lengths at which they pull [m], (l,)."""
    slack: np.ndarray
    """Slack: shortening of each link relative to its length at which it pulls, (l,)."""
    chain: np.ndarray
    """Number of the wire, (l,)."""
    box: np.ndarray
    """Lengths of the sample [m], (d,)."""

    @classmethod
    def of(cls, sample: Sample) -> LaidWire:
        """The wires of a sample; ValueError if it has none."""
        if not sample.wires:
            raise ValueError("The sample has no wire, and so nothing to predict: take a study with beads.")
        parts = [_links(sample, *of) for of in zip(sample.chains, sample.link_lengths, strict=True)]
        direction, length, slack = (np.concatenate(part) for part in zip(*parts, strict=True))
        chain = np.repeat(np.arange(len(parts)), [len(part[1]) for part in parts])
        return cls(direction, length, slack, chain, np.asarray(sample.box))

    @property
    def content(self) -> float:
        """Length of wire per volume [1/m^2], in 2D [1/m]."""
        return float(self.length.sum() / np.prod(self.box))

    @property
    def width(self) -> float:
        """Length of the sample along the wire [m]: the mean of the lengths of the box by the squares of its directions."""
        return float(np.average(self.direction**2 @ self.box, weights=self.length))

    def local(self, axial_rigidity: float) -> WireNetwork:
        """The network of the local model; ``axial_rigidity`` EA [N]."""
        return WireNetwork(self.content, axial_rigidity, Directions(self.direction, self.length), slack=self.slack)

    def anchored(self, axial_rigidity: float, held: Anchorage) -> WireNetwork:
        """The network of spans that share a tension and slip."""
        held = held.at(self.width)
        spans = spans_of(self.direction, self.length, held.span, self.chain)
        grows = GrowingAnchorage(held.slip, held.strength)
        return WireNetwork(self.content, axial_rigidity, spans, anchorage=grows)


def _links(sample: Sample, chain: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Direction, reference length and slack of the links of a chain; ``lengths``: by the sample, (l,)."""
    branch = np.diff(sample.positions[chain], axis=0)
    distance = np.linalg.norm(branch, axis=1)
    # a link that is longer than the reference of the sample keeps its length, as in the tests
    length = np.maximum(lengths, distance)
    return branch / distance[:, None], length, 1.0 - distance / length


def measured_anchorage(run: Run, record: CompressionRecord, sample: Sample, axial_rigidity: float) -> Anchorage:
    """How the sand held the wire of a sample in a test: its strength in each frame, its mean span after the first fifth.

    Raises ValueError if no link pulls in them.
    """
    steps, laid = run.steps, LaidWire.of(sample)
    tensions = {frame: wire_links(run, frame=frame).tension for frame in np.flatnonzero(steps > 0).tolist()}
    frames = [frame for frame, tension in tensions.items() if (tension > 0.0).any()]
    lengths = [
        tension_correlation(run, frame=frame, lags=LAGS).correlation_length
        for frame in frames
        if steps[frame] > EARLY * steps[-1]
    ]
    if not lengths:
        raise ValueError(f"No link pulls in '{run.path}': there is no tension to measure how the sand holds the wire.")
    span = float(np.mean(np.where(np.isfinite(lengths), lengths, 0.0)))
    shared = spans_of(laid.direction, laid.length, span, laid.chain)
    strengths, slips, slip = [], [], np.zeros(len(shared))
    for frame in frames:
        step = steps[frame] - 1
        stretch = shared.products[:, : sample.dimension] @ np.log(record.size[step] / sample.box)
        part = float(shared.weights @ (stretch > 0.0))
        if part > 0.0:
            tension = float(shared.weights @ tensions[frame]) / part
            slip = np.maximum(slip, stretch - tension / axial_rigidity)
            strengths.append(tension / (-np.trace(record.stress["sand"][step]) / sample.dimension))
            slips.append(float(shared.weights @ slip))
    return Anchorage(laid.width, span, *_by_slip(np.array(slips), np.array(strengths)))


def _by_slip(slips: np.ndarray, strengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The slips, each once, and the mean of the strengths at each."""
    slip, of = np.unique(slips, return_inverse=True)
    return slip, np.bincount(of, strengths) / np.bincount(of)


def mean_anchorage(found: Sequence[Anchorage]) -> Anchorage:
    """The mean of several, at the mean of their widths: of their strengths at all slips that were measured, as the closest
    curve that does not fall."""
    width = float(np.mean([one.width for one in found]))
    there = [one.at(width) for one in found]
    slip = np.unique(np.concatenate([one.slip for one in there]))
    mean = np.mean([np.interp(slip, one.slip, one.strength) for one in there], axis=0)
    return Anchorage(width, float(np.mean([one.span for one in there])), slip, isotonic_regression(mean).x)
