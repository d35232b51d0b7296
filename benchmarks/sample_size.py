"""How far a step of a mechanical test has to be solved, by the size of the sample: residual against error of a force.

Samples of 500 to 30 000 spheres, or of 240 to 1700 disks, three of each size up to 8000 and one beyond, are compacted
without friction and compressed by 2 % at an inertial number of 1e-3. Each test is made with its steps solved to a residual,
or to an error of a force in parts of the load of its bodies; the other bound is off. The reference is solved to an error of
force of 3e-4, or of 1e-3 beyond 8000 grains. Errors are those of the mean deviator over the last three quarters, in parts
of it, and of the change of volume at the end, in parts of the sample: mean over the samples, and the largest size. Two runs
that differ by round-off part by some percent of the deviator, as "scatter" shows (root mean square).

    python benchmarks/sample_size.py [2 or 3] [grains ...]
"""

from __future__ import annotations

import sys

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, Triaxial, compact, lay_grains, lay_sample

SIZES = {2: (240, 1700), 3: (500, 2000, 8000, 30000)}
LARGE = 8000
"""Beyond as many grains there is one sample and a coarser reference, which takes an hour."""
BOUNDS = [("residual", 1e-2), ("residual", 3e-3), ("force", 3e-3), ("force", 2e-3), ("force", 1e-3)]
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
    """The rows of one size."""
    seeds = range(3) if count <= LARGE else range(1)
    reference = ("force", 3e-4 if count <= LARGE else 1e-3)
    found: dict[tuple[str, float], list[tuple]] = {}
    for seed in seeds:
        laid = lay_sample(count, 0, seed=seed) if dimension == 2 else lay_grains(count, seed=seed)
        sample = compact(laid, pressure=1e5).sample
        q, v, sweeps = tested(dimension, sample, solver(*reference))
        found.setdefault(reference, []).append((sweeps, 0.0, 0.0, v[-1], 0.0))
        later = slice(len(q) // 4, None)
        for how in BOUNDS:
            if how != reference:
                other, volume, sweeps = tested(dimension, sample, solver(*how))
                off = (other - q)[later] / q[later].mean()
                errors = off.mean(), np.sqrt((off**2).mean()), volume[-1], volume[-1] - v[-1]
                found.setdefault(how, []).append((sweeps, *errors))
                print(count, seed, how, round(sweeps), *(f"{error:+.1e}" for error in errors), flush=True)
    grains, rows = f"{count} {'disks' if dimension == 2 else 'spheres'}", []
    for (measure, bound), runs in found.items():
        sweeps, q_off, scatter, volume, v_off = np.array(runs).T
        row = [grains, len(runs), measure, f"{bound:g}", f"{sweeps.mean():.0f}"]
        if (measure, bound) == reference:
            rows.append([*row, "", "", "", f"{volume.mean():+.1e}", "", ""])
        else:
            of_deviator = f"{q_off.mean():+.3f}", f"{np.abs(q_off).max():.3f}", f"{scatter.mean():.3f}"
            rows.append([*row, *of_deviator, f"{volume.mean():+.1e}", f"{v_off.mean():+.1e}", f"{np.abs(v_off).max():.1e}"])
    return rows


if __name__ == "__main__":
    dimension = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    counts = [int(count) for count in sys.argv[2:]] or SIZES[dimension]
    header = ["sample", "seeds", "solved to", "bound", "sweeps a step", "error of the deviator", "largest", "scatter"]
    rows = [row for count in counts for row in measured(dimension, count)]
    report(f"sample_size_{dimension}d", [*header, "change of volume", "error of it", "largest"], rows)
