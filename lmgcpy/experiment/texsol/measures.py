"""What a campaign keeps of a TexSol study: strengths by test, their gains over the sand, and curves."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.experiment.texsol.conclusions_3d import cohesion, friction_angle, late
from lmgcpy.experiment.texsol.result import TexSolResult

SMOOTH = 0.01
"""Width of the running mean [crushing] in which a peak is looked for."""
ROWS = 200
"""Rows of a curve."""


def measures(result: TexSolResult) -> tuple[dict[str, float], dict[str, dict[str, np.ndarray]]]:
    """Numbers by name and curves by test.

    Names begin with the test if there are several, "rigid-wire-z: peak deviator [Pa]". "late" is the mean over the last
    fifth of a test. Gains are those over the sand of the same sample.
    """
    several = len(result.records) > 1
    found: dict[str, float] = {}
    curves: dict[str, dict[str, np.ndarray]] = {}
    for name, record in result.records.items():
        sand = result.records.get(name.replace(record.law, "none", 1)) if record.law != "none" else None
        of_test = {**_strength(record), **({} if sand is None else _gain(record, sand))}
        begin = f"{name}: " if several else ""
        found |= {begin + quantity: value for quantity, value in of_test.items()}
        curves[name if several else ""] = _curve(record)
    return found, curves


def deviator(record: Any) -> np.ndarray:
    """Greatest less smallest principal pressure of the test [Pa]: that on the platens less that on the lateral walls."""
    if hasattr(record, "deviator"):
        return record.deviator
    size = record.size  # (s, 2); the upright axis is the last
    return record.reaction / size[:, 0] - record.lateral / size[:, 1]


def angle(record: Any, q: float) -> float:
    """Mobilised angle of friction [degrees] at a deviator, with the mean lateral pressure p3 of the test:
    ``sin phi = q / (q + 2 p3)``, in 2D and in triaxial compression alike."""
    if hasattr(record, "lateral") and record.lateral.ndim == 2:
        pressure = float(record.lateral.mean())
    else:
        pressure = float((record.lateral / record.size[:, 1]).mean())
    return friction_angle(q, pressure + q / 3.0)


def _strength(record: Any) -> dict[str, float]:
    q = deviator(record)
    smooth = record.smooth(q, SMOOTH)
    k, end = int(np.argmax(smooth)), float(late(record, q))
    wire = record.stress["wire"]
    return {
        "peak deviator [Pa]": float(smooth[k]),
        "crushing at the peak": float(record.strain[k]),
        "late deviator [Pa]": end,
        "peak friction angle [deg]": angle(record, float(smooth[k])),
        "late friction angle [deg]": angle(record, end),
        "late mean stress of the wire [Pa]": float(late(record, np.trace(wire, axis1=1, axis2=2))) / wire.shape[1],
        "late change of volume": float(late(record, np.prod(record.size, axis=1))) / float(np.prod(record.size[0])) - 1.0,
        "crushing reached": float(record.strain[-1]),
        "mean residual": float(np.mean(record.residual)),
        "unsolved steps": float(record.unconverged),
        "steps": float(len(record.strain)),
    }


def _gain(wire: Any, sand: Any) -> dict[str, float]:
    """By how much the wire strengthens the sand."""
    of_wire, of_sand = _strength(wire), _strength(sand)
    gains = {
        f"gain of the {when} deviator [Pa]": of_wire[f"{when} deviator [Pa]"] - of_sand[f"{when} deviator [Pa]"]
        for when in ("peak", "late")
    }
    gains |= {
        f"gain of the {when} friction angle [deg]": of_wire[f"{when} friction angle [deg]"]
        - of_sand[f"{when} friction angle [deg]"]
        for when in ("peak", "late")
    }
    if hasattr(wire, "deviator"):
        gains["cohesion that would do the same late [Pa]"] = cohesion(wire, sand)
    return gains


def _curve(record: Any) -> dict[str, np.ndarray]:
    """Columns over the crushing, running means at :data:`ROWS` places."""
    rows = np.unique(np.linspace(0, len(record.strain) - 1, ROWS).round().astype(int))
    volume = np.prod(record.size, axis=1) / float(np.prod(record.size[0])) - 1.0
    wire = np.trace(record.stress["wire"], axis1=1, axis2=2) / record.size.shape[1]
    return {
        "crushing": record.strain[rows],
        "reaction [N]": record.smooth(record.reaction)[rows],
        "deviator [Pa]": record.smooth(deviator(record))[rows],
        "change of volume": record.smooth(volume)[rows],
        "mean stress of the wire [Pa]": record.smooth(wire)[rows],
        "residual": record.residual[rows],
    }
