"""How far a step of a mechanical test has to be solved, by the size of the sample: residual against error of a force.

Samples of 500 to 8000 spheres, or of 240 to 1700 disks, are compacted without friction and compressed by 2 % at an inertial
number of 1e-3. Each test is made with its steps solved to a residual, or to an error of a force in parts of the load of its
bodies; the other bound is off. The reference is solved to an error of force of 3e-4. Errors are those of the mean deviator
over the last three quarters, in parts of it, and of the change of volume at the end, in parts of the sample. Two runs that
differ by round-off part by some percent of the deviator, as "scatter" shows (root mean square).

    python benchmarks/sample_size.py [2 or 3] [grains ...]
"""

from __future__ import annotations

import sys

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, Triaxial, compact, lay_grains, lay_sample

SIZES = {2: (240, 1700), 3: (500, 2000, 8000)}
REFERENCE = 3e-4
BOUNDS = [("residual", 1e-2), ("residual", 3e-3), ("force", 3e-3), ("force", 1e-3)]
OFF = {"tolerance": 1.0, "force": 1.0}


def solver(measure: str, bound: float) -> lm.Solver:
    """Accelerated sweeps to a residual or to an error of a force alone."""
    name = "tolerance" if measure == "residual" else measure
    return lm.AcceleratedGaussSeidel(max_iterations=3000, momentum=0.9, slip=3e-3, **{**OFF, name: bound})


def tested(dimension: int, sample, how: lm.Solver):
    """Deviator [Pa] and change of volume by step, and the sweeps of a step."""
    test = (Biaxial if dimension == 2 else Triaxial)(sample, friction=0.3, solver=how)
    record = test.run(0.02, frames=0)
    volume = np.prod(record.size, axis=1) / np.prod(sample.box) - 1.0
    return record.deviator, volume, float(np.mean(record.iterations))


def measured(dimension: int, count: int) -> list[list]:
    """The rows of one sample."""
    laid = lay_sample(count, 0, seed=0) if dimension == 2 else lay_grains(count, seed=0)
    sample = compact(laid, pressure=1e5).sample
    q, v, sweeps = tested(dimension, sample, solver("force", REFERENCE))
    grains = f"{count} {'disks' if dimension == 2 else 'spheres'}"
    rows = [[grains, "force", f"{REFERENCE:g}", f"{sweeps:.0f}", "", "", f"{v[-1]:+.1e}", ""]]
    later = slice(len(q) // 4, None)
    for measure, bound in BOUNDS:
        other, volume, sweeps = tested(dimension, sample, solver(measure, bound))
        off = (other - q)[later] / q[later].mean()
        errors = f"{off.mean():+.3f}", f"{np.sqrt((off**2).mean()):.3f}", f"{volume[-1]:+.1e}", f"{volume[-1] - v[-1]:+.1e}"
        rows.append([grains, measure, f"{bound:g}", f"{sweeps:.0f}", *errors])
    return rows


if __name__ == "__main__":
    dimension = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    counts = [int(count) for count in sys.argv[2:]] or SIZES[dimension]
    header = ["sample", "solved to", "bound", "sweeps a step", "error of the deviator", "scatter", "change of volume"]
    rows = [row for count in counts for row in measured(dimension, count)]
    report(f"sample_size_{dimension}d", [*header, "error of it"], rows)
