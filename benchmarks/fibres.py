"""Strength and dilation of sand with short fibres against their content: docs/fibres.md.

Triaxial tests of small dense samples, five of each: grains between 0.8 and 1.2 mm and fibres of 3.2 x 0.2 mm, relaxed
without friction to 100 kPa, friction 0.4 in the tests. Contents are volumes of fibres over those of grains. A fibre is one
stiff capsule, or a chain of four on ball joints, laid in the same place.

    python benchmarks/fibres.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Sequence

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Sample, Triaxial, TriaxialRecord, characteristic_time, compact, lay_grains
from lmgcpy.experiment.campaign.statistics import mean_and_interval
from lmgcpy.scene.body_3d import capsule_volume

PRESSURE, DENSITY = 1e5, 2600.0
RADIUS, LENGTH = 0.1e-3, 3e-3
CASES = (
    *((0.0, "random", 1), (0.005, "random", 1), (0.01, "random", 1), (0.02, "random", 1), (0.02, "horizontal", 1)),
    *((0.02, "random", 4), (0.02, "horizontal", 4)),
)
STRAIN, LATE = 0.12, 0.1


def dense(laid: Sample):
    """Compacted without friction. Drag, step and tolerance are those of the TexSol study in 3D."""
    step = 0.08 * characteristic_time(laid.diameter, DENSITY, PRESSURE)
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=2000)
    return compact(laid, pressure=PRESSURE, drag=2.0, time_step=step, solver=solver, max_steps=4000)


def crushed(sample: Sample) -> TriaxialRecord:
    """The record of a test along z, as slow and as exact as a small sample needs it."""
    solver = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=3000)
    return Triaxial(sample, pressure=PRESSURE, friction=0.4, inertial_number=2e-3, solver=solver).run(STRAIN, frames=0)


def strengths(record: TriaxialRecord) -> list[float]:
    """Deviator at the peak and late [kPa], q/p at the peak, change of volume at the end [%]; the peak is one of the running
    mean over 1 % of crushing."""
    late, smooth = record.strain > LATE, record.smooth(record.deviator, 0.01)
    ratio = record.smooth(record.deviator / record.mean_pressure, 0.01)
    return [smooth.max() / 1e3, record.deviator[late].mean() / 1e3, ratio.max(), 100.0 * record.volume_change[-1]]


def words(values: Sequence[float], form: str = ".1f") -> str:
    """Mean and 95 % interval of the mean."""
    told = mean_and_interval(np.array(values))
    return f"{told.mean:{form}} [{told.low:{form}}, {told.high:{form}}]"


def case(content: float, orientation: str, segments: int, grains: int, seed: int) -> list:
    """A row of the table of runs."""
    begin = time.process_time()
    more = {"content": content, "fibre_radius": RADIUS, "fibre_length": LENGTH, "orientation": orientation}
    laid = lay_grains(grains, seed=seed, segments=segments, **more)
    done = dense(laid)
    record = crushed(done.sample)
    fibres, volume = len(laid.bodies) // segments, float(np.prod(done.sample.box))
    solid = (done.sample.solid_volume - fibres * capsule_volume(RADIUS, LENGTH)) / volume
    length = fibres * LENGTH * laid.diameter**2 / volume
    told = [f"{value:.4g}" for value in (length, solid, done.coordination, *strengths(record))]
    unsolved, overlap = record.unconverged + done.unconverged, record.penetration.max() / laid.diameter
    spent = time.process_time() - begin
    return [content, orientation, segments, seed, fibres, *told, done.at_rest, unsolved, f"{overlap:.1e}", f"{spent:.0f}"]


def tables(runs: list[list]) -> None:
    """Print and write the runs, and their means with intervals."""
    rows = []
    for of in dict.fromkeys(tuple(run[:3]) for run in runs):
        numbers = np.array([run[4:12] for run in runs if tuple(run[:3]) == of], dtype=float)
        fibres, length, solid, contacts, peak, late, ratio, dilation = numbers.T
        kind = [of[1], of[2]] if of[0] else ["", ""]
        laid = [f"{100.0 * of[0]:g} %", *kind, f"{fibres.mean():.0f}", f"{length.mean():.2f}"]
        told = (*map(words, (peak, late, dilation)), words(ratio, ".2f"))
        rows.append([*laid, len(numbers), words(solid, ".3f"), words(contacts, ".2f"), *told])
    names = ["solid fraction of grains", "coordination", "peak deviator [kPa]", "late [kPa]"]
    kind = ["content", "orientation", "segments"]
    header = [*kind, "seed", "fibres", "length d^2 / volume", *names, "peak q/p", "dilation [%]"]
    report("fibres_runs", [*header, "at rest", "unsolved steps", "overlap / d", "processor [s]"], runs)
    header = [*kind, "fibres", "length d^2 / volume", "samples", *names, "dilation [%]", "peak q/p"]
    report("fibres", header, rows)


def main(seeds: int = 5, grains: int = 400) -> None:
    """All cases, one after the other."""
    tables([case(*of, grains, seed) for of in CASES for seed in range(seeds)])


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # single bodies move fast now and then; overlaps are in the table
    main(*map(int, sys.argv[1:]))
