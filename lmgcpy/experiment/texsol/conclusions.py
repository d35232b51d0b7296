"""Conclusions of the studies from their records, in 2D and in 3D (paper, sections 3 and 4).

The links of a wire that pull explain the second principal stress by their directions (figure 5 of the paper). A wire's part
of the Weber stress is ``sigma = (1/V) sum f l t (x) t`` over its links, f the tension, l the length, t the direction.
Under compression along y the sample widens along x, and links within some angle of x are drawn taut. With equal tensions
f l in all directions between ``-a`` and ``a``

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

from lmgcpy.errors import AXES
from lmgcpy.experiment.biaxial import BiaxialRecord, Frame
from lmgcpy.experiment.triaxial import TriaxialRecord

UPRIGHT = "z"
"""The axis across the layers in 3D."""


# ------------------------------------------------------------------------------------------------------------------ in 2D


def stiffening(wire: BiaxialRecord, sand: BiaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, reaction with the wire / reaction of the sand) at the given crushing, to the end of the shorter test."""
    found = []
    for strain in strains:
        if strain <= min(wire.strain[-1], sand.strain[-1]) + 1e-3:
            there = [np.interp(strain, record.strain, record.smooth(record.reaction, 0.005)) for record in (wire, sand)]
            found.append((strain, float(there[0] / there[1])))
    return found


def column(rod: BiaxialRecord, wire: BiaxialRecord, factor: float = 2.0) -> tuple[float | None, float]:
    """(crushing at which the rods' mean reaction first exceeds ``factor`` times the wire's, greatest ratio of the two). The
    crushing is None if the reaction never exceeds it over 0.5 % of crushing without a break.
    """
    strain = rod.strain[rod.strain <= wire.strain[-1]]
    of_wire = np.interp(strain, wire.strain, wire.smooth(wire.reaction))
    ratio = rod.smooth(rod.reaction)[: len(strain)] / of_wire
    above = ratio > factor
    for k in np.flatnonzero(above):
        if above[(strain >= strain[k]) & (strain <= strain[k] + 0.005)].all():
            return float(strain[k]), float(ratio.max())
    return None, float(ratio.max())


def frames_of_column(rod: BiaxialRecord, wire: BiaxialRecord) -> tuple[Frame, Frame] | None:
    """The last frame before the rods' reaction jumps, and the frame of the greatest load after it; None without a jump."""
    where, _ = column(rod, wire)
    earlier = [frame for frame in rod.frames if where is not None and frame.strain < where]
    later = [frame for frame in rod.frames if where is not None and frame.strain >= where]
    return (earlier[-1], max(later, key=lambda frame: frame.top_force)) if earlier and later else None


def compression_in_links(record: BiaxialRecord) -> tuple[float, float]:
    """(share, crushing): the greatest :func:`compressed_share` of the frames, and where."""
    return max([(0.0, 0.0), *((compressed_share(frame), frame.strain) for frame in record.frames)])


def compressed_share(frame: Frame) -> float:
    """Part of the vertical Weber stress that comes from links in compression, over the load on top; 0 without a load."""
    x0, x1, y0, y1 = frame.walls
    chosen = frame.in_wire & (frame.forces > 0.0)
    branch = frame.lines[chosen, 1] - frame.lines[chosen, 0]
    length = np.linalg.norm(branch, axis=1)
    carried = float(np.sum(frame.forces[chosen] * branch[:, 1] ** 2 / length)) / ((x1 - x0) * (y1 - y0))
    total = frame.top_force / (x1 - x0)
    return carried / total if total > 0.0 else 0.0


def frames_at_equal_force(wire: BiaxialRecord, sand: BiaxialRecord) -> tuple[Frame, Frame]:
    """A frame of each test, at the same force on top to 1 %.

    Of all such pairs it is the most crushed one; if there is none, the pair whose forces differ least.
    """
    force = [np.array([frame.top_force for frame in record.frames]) for record in (wire, sand)]
    strain = [np.array([frame.strain for frame in record.frames]) for record in (wire, sand)]
    apart = np.abs(force[0][:, None] - force[1][None]) / np.maximum(force[0][:, None], force[1][None])
    crushed = strain[0][:, None] + strain[1][None]
    rank = np.where(apart <= 0.01, crushed, -apart)
    i, j = np.unravel_index(int(np.argmax(rank)), rank.shape)
    return wire.frames[i], sand.frames[j]


# ----------------------------------------------------------------------------------------------------- in 3D, and of both


def at(record: TriaxialRecord, values: np.ndarray, strain: float, width: float = 0.01) -> np.ndarray:
    """Running mean of ``values`` over ``width`` of strain, at a strain."""
    return record.smooth(values, width)[int(np.argmin(np.abs(record.strain - strain)))]


def friction_angle(deviator: float, mean_pressure: float) -> float:
    """Mobilised angle of friction [degrees] in triaxial compression: sin phi = (s1 - s3)/(s1 + s3) = 3 q/(6 p + q)."""
    return float(np.degrees(np.arcsin(3.0 * deviator / (6.0 * mean_pressure + deviator))))


def mobilised_angle(deviator: float, lateral_pressure: float) -> float:
    """Mobilised friction angle from the lateral pressure s3, in triaxial or biaxial compression: sin phi = q/(q + 2 s3)."""
    return friction_angle(deviator, lateral_pressure + deviator / 3.0)


def peak(record: TriaxialRecord | BiaxialRecord) -> tuple[float, float, float]:
    """(crushing, deviator [Pa], mobilised angle [degrees]) at the greatest running mean of the deviator."""
    q, lateral = record.smooth(record.deviator, 0.01), record.smooth(record.lateral_pressure, 0.01)
    k = int(np.argmax(q))
    return float(record.strain[k]), float(q[k]), mobilised_angle(float(q[k]), float(lateral[k]))


def late_part(record: TriaxialRecord | BiaxialRecord, values: np.ndarray) -> np.ndarray:
    """``values`` in the last fifth of the test."""
    return values[record.strain > 0.8 * record.strain[-1]]


def late(record: TriaxialRecord | BiaxialRecord, values: np.ndarray) -> np.ndarray:
    """Mean of ``values`` over the last fifth of the test."""
    return late_part(record, values).mean(axis=0)


def cohesion(wire: TriaxialRecord, sand: TriaxialRecord) -> float:
    """Cohesion [Pa] that would raise the late deviator of the sand, at its angle of friction, to that with the wire:
    ``c = (q_wire - q_sand) (1 - sin phi) / (2 cos phi)``.
    """
    phi = np.radians(friction_angle(float(late(sand, sand.deviator)), float(late(sand, sand.mean_pressure))))
    gain = late(wire, wire.deviator) - late(sand, sand.deviator)
    return float(gain * (1.0 - np.sin(phi)) / (2.0 * np.cos(phi)))


def envelope(angles: tuple[float, float], pressures: tuple[float, float]) -> tuple[float, float]:
    """Cohesion [Pa] and angle of friction [degrees] of the line ``s1 = K s3 + 2 c sqrt(K)``, ``K = (1 + sin phi)/(1 - sin
    phi)``, through two strengths: mobilised angles [degrees] at lateral pressures s3 [Pa]."""
    sines = np.sin(np.radians(angles))
    s3 = np.array(pressures)
    low, high = (1.0 + sines) / (1.0 - sines) * s3  # s1
    K = (high - low) / (s3[1] - s3[0])
    return float((low - K * s3[0]) / (2.0 * np.sqrt(K))), float(np.degrees(np.arcsin((K - 1.0) / (K + 1.0))))


def layer_parts(record: TriaxialRecord) -> tuple[np.ndarray, np.ndarray]:
    """Wire part of the Weber stress [Pa]: the mean of xx and yy, within the layers, and zz, across them, (s,) each."""
    wire = record.stress["wire"]
    return 0.5 * (wire[:, 0, 0] + wire[:, 1, 1]), wire[:, 2, 2]


def principal_axes(sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal values of stresses (s, 3, 3), greatest first [Pa], (s, 3), and as rows their directions, (s, 3, 3), each
    with its greatest component positive."""
    values, vectors = np.linalg.eigh(0.5 * (sigma + np.swapaxes(sigma, 1, 2)))
    rows = np.swapaxes(vectors[:, :, ::-1], 1, 2)
    greatest = np.take_along_axis(rows, np.abs(rows).argmax(axis=2)[:, :, None], axis=2)
    return values[:, ::-1], rows * np.where(greatest < 0.0, -1.0, 1.0)


def gains(wire: TriaxialRecord, sand: TriaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, deviator with the wire / deviator of the sand) at the given crushing, to the end of the shorter test."""
    end = min(wire.strain[-1], sand.strain[-1]) + 1e-3
    return [
        (strain, float(at(wire, wire.deviator, strain) / at(sand, sand.deviator, strain)))
        for strain in strains
        if strain <= end
    ]


def boundary_mismatch(record: TriaxialRecord) -> float:
    """Relative difference of the mean Weber stress and the mean pressures on the walls, the worst axis."""
    axis = AXES.index(record.axis)
    others = [k for k in range(3) if k != axis]
    measured = np.array([record.axial.mean(), *record.lateral.mean(axis=0)])
    sigma = -record.stress["total"].mean(axis=0)[[axis, *others], [axis, *others]]
    return float(np.abs(sigma / measured - 1.0).max())


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
