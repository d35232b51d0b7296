"""Result of a TexSol study, and the measures of it that a campaign keeps: strengths, their gains over the sand, curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import Compaction
from lmgcpy.experiment.study.resolved import LateDifference, difference
from lmgcpy.experiment.texsol.conclusions import cohesion, late, late_part, mobilised_angle, peak
from lmgcpy.experiment.triaxial import TriaxialRecord

ROWS = 200
"""Rows of a curve."""


@dataclass(frozen=True)
class TexSolResult:
    """All that a TexSol study computed."""

    study: Any
    """A :class:`~lmgcpy.experiment.texsol.study.TexSolStudy`."""
    compaction: Compaction
    records: dict[str, Any]
    """Records of the tests, by the law, in 3D by "law-axis"."""
    checks: dict[str, Any]
    """Records of the same tests at a tighter tolerance, over their first part."""

    @property
    def seconds(self) -> float:
        """Wall clock time of the steps of all runs [s]."""
        return self.compaction.seconds + sum(run.seconds for run in [*self.records.values(), *self.checks.values()])

    @property
    def sample(self) -> Sample:
        """The relaxed sample at the start of the tests."""
        return self.compaction.sample


def deviation(record: Any, check: Any) -> float:
    """Mean difference of two runs' reactions over their common crushing, relative to the mean reaction."""
    strain = check.strain[check.strain <= record.strain[-1]]
    ours = np.interp(strain, record.strain, record.smooth(record.reaction))
    theirs = np.interp(strain, check.strain, check.smooth(check.reaction))
    return float(np.abs(ours - theirs).mean() / theirs.mean())


def late_gain(result: TexSolResult, wire: Any, sand: Any, values: Callable[[Any], np.ndarray]) -> LateDifference:
    """Late difference of the ``values`` of a record with the wire and the sand's, resolved or not, with the changes by a
    tighter tolerance where they were looked at."""
    one, other = (late_part(record, values(record)) for record in (wire, sand))
    laws = (wire.law, "none")
    changes = [deviation(result.records[name], check) for name, check in result.checks.items() if name.startswith(laws)]
    return difference(one, other, max(changes, default=0.0) * float(np.mean(one)))


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


def _strength(record: Any) -> dict[str, float]:
    crushing, greatest, angle = peak(record)
    end = float(late(record, record.deviator))
    wire, volume = record.stress["wire"], np.prod(record.size, axis=1)
    return {
        "peak deviator [Pa]": greatest,
        "crushing at the peak": crushing,
        "late deviator [Pa]": end,
        "peak friction angle [deg]": angle,
        "late friction angle [deg]": mobilised_angle(end, float(late(record, record.lateral_pressure))),
        "late mean stress of the wire [Pa]": float(late(record, np.trace(wire, axis1=1, axis2=2))) / wire.shape[1],
        "late change of volume": float(late(record, volume)) / float(volume[0]) - 1.0,
        "crushing reached": float(record.strain[-1]),
        "mean residual": float(np.mean(record.residual)),
        "unsolved steps": float(record.unconverged),
        "steps": float(len(record.strain)),
    }


def _gain(wire: Any, sand: Any) -> dict[str, float]:
    """By how much the wire strengthens the sand."""
    of_wire, of_sand = _strength(wire), _strength(sand)
    gains = {}
    for quantity in ("deviator [Pa]", "friction angle [deg]"):
        for when in ("peak", "late"):
            gains[f"gain of the {when} {quantity}"] = of_wire[f"{when} {quantity}"] - of_sand[f"{when} {quantity}"]
    if isinstance(wire, TriaxialRecord):
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
        "deviator [Pa]": record.smooth(record.deviator)[rows],
        "change of volume": record.smooth(volume)[rows],
        "mean stress of the wire [Pa]": record.smooth(wire)[rows],
        "residual": record.residual[rows],
    }
