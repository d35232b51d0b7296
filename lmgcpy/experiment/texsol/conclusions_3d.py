"""Conclusions of the 3D study from its records (paper, section 4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lmgcpy.errors import AXES
from lmgcpy.experiment.biaxial import BiaxialRecord
from lmgcpy.experiment.triaxial import TriaxialRecord

UPRIGHT = "z"
"""The axis across the layers."""


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
