"""The links of a wire that pull, and the second principal stress from their directions: figure 5 of the paper, explained.

A wire's part of the Weber stress is ``sigma = (1/V) sum f l t (x) t`` over its links, f the tension, l the length, t the
direction. Under compression along y the sample widens along x, and links within some angle of x are drawn taut. With equal
tensions f l in all directions between ``-a`` and ``a``

    sigma_2 / sigma_1 = <sin^2> / <cos^2> = (1 - s) / (1 + s),    s = sin(2 a) / (2 a),

which is 0.22 for a = 45 degrees: one principal stress is smaller than the other, but not near zero. In a homogeneous
deformation with principal strains e_x > 0 > e_y a direction at the angle a is not extended if
``tan^2 a = e_x / |e_y|``: 45 degrees at constant volume, more in a sample that dilates. Slack narrows the cone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lmgcpy.experiment.biaxial import BiaxialRecord, Frame


@dataclass(frozen=True)
class LinkDirections:
    """Directions of the links of a wire in some frames of a biaxial test, and their forces; b bins of angles."""

    edges: np.ndarray
    """Bounds of the bins of the angle to x, from 0 to 90 degrees, (b + 1,)."""
    links: np.ndarray
    """Number of links in each bin, (b,)."""
    taut: np.ndarray
    """Number of links in each bin that pull, (b,)."""
    pulled: np.ndarray
    """Sum of ``f l`` over the links that pull [N m], (b,)."""
    pushed: np.ndarray
    """Sum of ``-f l`` of the links that push [N m], (b,); zero for a wire."""
    equal: float
    """Ratio of the principal values of ``sum t (x) t`` over the taut links, as at equal tensions; nan without any."""

    @property
    def taut_share(self) -> np.ndarray:
        """Share of the links of each bin that pull, (b,); nan in an empty bin."""
        return np.divide(self.taut, self.links, out=np.full(len(self.links), math.nan), where=self.links > 0)

    def __repr__(self) -> str:
        count = int(self.links.sum())
        return f"<LinkDirections of {count} links, {int(self.taut.sum())} taut, equal tensions leave {self.equal:.2f}>"


def link_directions(frames: Sequence[Frame], chains: Sequence[np.ndarray], bins: int = 9) -> LinkDirections:
    """Directions and tensions of the links of ``chains`` (indices of beads) in the frames."""
    edges = np.linspace(0.0, 0.5 * math.pi, bins + 1)
    links, taut, pulled, pushed = (np.zeros(bins) for _ in range(4))
    moment = np.zeros((2, 2))
    for frame in frames:
        branches = [np.diff(frame.positions[chain], axis=0) for chain in chains]
        links += np.histogram(_angle(np.concatenate([np.zeros((0, 2)), *branches])), edges)[0]
        acting = frame.lines[frame.in_wire]
        branch, force = acting[:, 1] - acting[:, 0], frame.forces[frame.in_wire]
        angle, length = _angle(branch), np.linalg.norm(branch, axis=1)
        pulls = force < 0.0
        taut += np.histogram(angle[pulls], edges)[0]
        pulled += np.histogram(angle[pulls], edges, weights=(-force * length)[pulls])[0]
        pushed += np.histogram(angle[~pulls], edges, weights=(force * length)[~pulls])[0]
        t = branch[pulls] / length[pulls, None]
        moment += t.T @ t
    small, large = np.linalg.eigvalsh(moment)
    return LinkDirections(edges, links, taut, pulled, pushed, float(small / large) if large > 0.0 else math.nan)


def _angle(branch: np.ndarray) -> np.ndarray:
    """Angle of vectors to x, from 0 to pi/2, (m,)."""
    return np.arctan2(np.abs(branch[:, 1]), np.abs(branch[:, 0]))


def cone_ratio(angle: float) -> float:
    """Ratio of the principal stresses of links in all directions up to ``angle`` [rad] from x, at equal tensions."""
    s = math.sin(2.0 * angle) / (2.0 * angle) if angle > 0.0 else 1.0
    return (1.0 - s) / (1.0 + s)


def extended_cone(record: BiaxialRecord, since: float) -> float:
    """Angle to x up to which a direction is longer at the end of the test than at the crushing ``since`` [rad].

    Of the homogeneous deformation with the stretches of the box, ``(l_x cos a)^2 + (l_y sin a)^2 = 1`` at its bound.
    """
    width, height = record.size[-1] / record.size[int(np.searchsorted(record.strain, since))]
    if height >= 1.0:
        return 0.5 * math.pi
    return math.atan(math.sqrt(max(width**2 - 1.0, 0.0) / (1.0 - height**2)))
