"""Sweeps a step of triaxial tests at the speed of the studies, by the size of the sample: docs/step_and_tolerance.md.

Dense samples of spheres are compressed by 2 % at an inertial number I of 2e-3; steps are solved to a residual of 1e-2 and
an error of force of I, by accelerated sweeps with a momentum of at most 0.9. Deviator: mean over the last three quarters;
volume: at the end.

    python benchmarks/sweeps_by_size.py [SPHERES ...]
"""

from __future__ import annotations

import sys
import time
import warnings

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Triaxial, compact, lay_grains

SEEDS = {500: 3, 2000: 3, 8000: 2, 30000: 1}
INERTIAL_NUMBER, STRAIN, PRESSURE = 2e-3, 0.02, 1e5
OPTIONS = {"tolerance": 1e-2, "momentum": 0.9, "max_iterations": 3000}
HEADER = ["spheres", "seed", "sweeps a step", "most", "unsolved of 51", "deviator [kPa]", "change of volume"]
HEADER += ["deepest overlap [radii]", "processor s", "compaction: steps", "processor s"]


def measured(count: int, seed: int) -> list:
    """A row of the table."""
    begin = time.process_time()
    exact = lm.AcceleratedGaussSeidel(force=1e-3, **OPTIONS)
    compacted = compact(lay_grains(count, seed=seed), pressure=PRESSURE, solver=exact)
    middle = time.process_time()
    solver = lm.AcceleratedGaussSeidel(force=INERTIAL_NUMBER, **OPTIONS)
    test = Triaxial(compacted.sample, friction=0.3, pressure=PRESSURE, inertial_number=INERTIAL_NUMBER, solver=solver)
    record = test.run(STRAIN, frames=0)
    end = time.process_time()
    deviator = record.deviator[len(record.strain) // 4 :].mean() / 1e3
    overlap = record.penetration[-1] / np.mean(compacted.sample.radii)
    row = [count, seed, f"{record.iterations.mean():.0f}", int(record.iterations.max()), record.unconverged]
    row += [f"{deviator:.1f}", f"{record.volume_change[-1]:+.2e}", f"{overlap:.1e}", f"{end - middle:.0f}"]
    return [*row, compacted.steps, f"{middle - begin:.0f}"]


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # grains that are pressed together move fast at first
    chosen = [int(count) for count in sys.argv[1:]] or list(SEEDS)
    rows = []
    for count in chosen:
        for seed in range(SEEDS.get(count, 1)):
            rows.append(measured(count, seed))
            print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    report("sweeps_by_size", HEADER, rows)
