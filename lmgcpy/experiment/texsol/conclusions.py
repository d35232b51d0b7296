"""Conclusions of the studies from their records, in 2D and in 3D (paper, sections 3 and 4)."""

from __future__ import annotations

from collections.abc import Sequence

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


def late(record: TriaxialRecord | BiaxialRecord, values: np.ndarray) -> np.ndarray:
    """Mean of ``values`` over the last fifth of the test."""
    return values[record.strain > 0.8 * record.strain[-1]].mean(axis=0)


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
