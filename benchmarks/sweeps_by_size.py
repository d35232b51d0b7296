"""Sweeps a step of triaxial tests at the speed of the studies, by the size of the sample: docs/step_and_tolerance.md.

Dense samples of spheres are compressed by 2 % at an inertial number I of 2e-3; steps are solved to a residual of 1e-2 and
to errors of force of I, 2 I and 4 I, by accelerated sweeps with a momentum of at most 0.9. The reference is the same test
to an error of force of I/4, of 30 000 spheres I/2. Deviator: mean over the last three quarters; volume: at the end.

    python benchmarks/sweeps_by_size.py [SPHERES [SEED ...]]
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Triaxial, compact, lay_grains

SEEDS = {500: 3, 2000: 3, 8000: 3, 30000: 1}
INERTIAL_NUMBER, STRAIN, PRESSURE = 2e-3, 0.02, 1e5
BOUNDS = (1.0, 2.0, 4.0)
REFERENCE = {30000: 0.5}
"""Error of force of the reference where I/4 would take hours."""
OPTIONS = {"tolerance": 1e-2, "momentum": 0.9, "max_iterations": 5000}
HEADER = ["spheres", "seed", "error of force [I]", "sweeps a step", "most", "unsolved of 51", "deviator [kPa]"]
HEADER += ["error of it", "change of volume", "error of it", "deepest overlap [radii]", "processor s"]
HEADER += ["compaction: steps", "processor s"]


def measured(count: int, seed: int) -> Iterator[list]:
    """Rows of one sample, one for each bound."""
    begin = time.process_time()
    exact = lm.AcceleratedGaussSeidel(force=1e-3, **OPTIONS)
    compacted = compact(lay_grains(count, seed=seed), pressure=PRESSURE, solver=exact)
    compaction = time.process_time() - begin
    exact_deviator = exact_volume = np.nan
    for bound in (None, *BOUNDS):
        begin = time.process_time()
        error = bound or REFERENCE.get(count, 0.25)
        solver = lm.AcceleratedGaussSeidel(force=error * INERTIAL_NUMBER, **OPTIONS)
        test = Triaxial(compacted.sample, friction=0.3, pressure=PRESSURE, inertial_number=INERTIAL_NUMBER, solver=solver)
        record = test.run(STRAIN, frames=0)
        seconds = time.process_time() - begin
        deviator = record.deviator[len(record.strain) // 4 :].mean() / 1e3
        volume = record.volume_change[-1]
        if bound is None:
            exact_deviator, exact_volume = deviator, volume
        overlap = record.penetration[-1] / np.mean(compacted.sample.radii)
        sweeps = record.iterations
        row = [count, seed, f"{error:g}", f"{sweeps.mean():.0f}", int(sweeps.max()), record.unconverged]
        row += [f"{deviator:.1f}", f"{deviator / exact_deviator - 1.0:+.1%}"]
        row += [f"{volume:+.2e}", f"{volume - exact_volume:+.1e}", f"{overlap:.1e}", f"{seconds:.0f}"]
        yield [*row, compacted.steps, f"{compaction:.0f}"]


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # grains that are pressed together move fast at first
    asked = [int(word) for word in sys.argv[1:]]
    rows = []
    for count in asked[:1] or SEEDS:
        for seed in asked[1:] or range(SEEDS.get(count, 1)):
            for row in measured(count, seed):
                print(*row, sep=" | ", file=sys.stderr, flush=True)
                rows.append(row)
    report("sweeps_by_size", HEADER, rows)
