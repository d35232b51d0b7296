"""One level above the solvers: what tolerance and time step do to the results of a run.

Biaxial tests to 2 % of five small samples (340 grains and 60 beads), of sand and with a rigid wire: mean reaction, deviator
and stress of the wire over the second half of the test, for tolerances of 1e-2 to 1e-7 at the default time step, and for
time steps of 2, 1/2 and 1/4 times the default one at 1e-4.

The path of a sample is chaotic: any change, also one of round-off, leads to another history of slips. What that does is
told by runs to 1e-6 with grains moved by 1e-9 of their radius. The reference of a sample is the mean of these and of the
runs to 1e-5 or less (without the run that is judged), chance the scatter of a run about it. A change is that of a setting
from the reference, mean over the samples and its standard error; below twice that it cannot be told from chance.

    python benchmarks/tolerance.py
"""

from __future__ import annotations

import multiprocessing
import sys
from collections import defaultdict
from dataclasses import replace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.bench import load
from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample

PRESSURE, DENSITY, STRAIN = 1e5, 2600.0, 0.02
SAMPLES = range(5)
"""Seeds of the samples."""
TOLERANCES = tuple(10.0**-k for k in range(2, 8))
STEPS = (2.0, 0.5, 0.25)
"""Time steps in default ones."""
MOVED = range(1, 4)
"""Seeds of the runs with grains moved."""
CHANCE = "grains moved"
ACCURATE = ("tolerance 1e-05", "tolerance 1e-06", "tolerance 1e-07", CHANCE)
LAWS = (None, lm.RigidWire())
PROCESSES = 2


def crush(sample: Sample, law: lm.Law | None, tolerance: float, part: float = 1.0) -> BiaxialRecord:
    """A biaxial test at ``part`` times the default time step."""
    solver = lm.Auto(tolerance=tolerance)
    test = {"pressure": PRESSURE, "density": DENSITY, "solver": solver}
    step = part * Biaxial(sample, law, **test).time_step
    return Biaxial(sample, law, time_step=step, **test).run(STRAIN, frames=0)


def moved(sample: Sample, seed: int) -> Sample:
    """The sample with its grains 1e-9 of their radius away."""
    away = np.random.default_rng(seed).uniform(-1e-9, 1e-9, sample.positions.shape) * sample.radii[:, None]
    return replace(sample, positions=sample.positions + away)


def late(record: BiaxialRecord) -> np.ndarray:
    """Means over the second half of the test: reaction [kN], deviator [kPa], mean stress of the wire [kPa]."""
    half = record.strain > 0.5 * STRAIN
    total, wire = (record.stress[part][half].mean(axis=0) for part in ("total", "wire"))
    return np.array([record.reaction[half].mean(), total[0, 0] - total[1, 1], 0.5 * np.trace(wire)]) / 1e3


def runs(case: tuple[lm.Law | None, int]) -> list[tuple[str, BiaxialRecord]]:
    """(what was changed, record) of every run of a law and a sample."""
    law, seed = case
    sample = compact(lay_sample(340, 60, seed=seed), pressure=PRESSURE, density=DENSITY).sample
    made = [(f"tolerance {tolerance:.0e}", crush(sample, law, tolerance)) for tolerance in TOLERANCES]
    made += [(f"time step x {part:g}", crush(sample, law, 1e-4, part)) for part in STEPS]
    made += [(CHANCE, crush(moved(sample, other), law, 1e-6)) for other in MOVED]
    print(f"{name(law)}, sample {seed}: done", file=sys.stderr, flush=True)
    return made


def name(law: lm.Law | None) -> str:
    return "sand" if law is None else law.NAME


def summary(title: str, found: dict[str, list[list[np.ndarray]]], records: dict[str, list[BiaxialRecord]]) -> list[list]:
    """A row per setting; ``found[setting][sample]`` are the means of its runs."""
    rows = []
    for setting, values in found.items():
        away = []
        for k, own in enumerate(values):
            others = [run for name in ACCURATE if name != setting for run in found[name][k]]
            with np.errstate(invalid="ignore"):  # sand has no wire
                away.append(np.mean(own, axis=0) / np.mean(others, axis=0) - 1.0)
        if setting == CHANCE:
            accurate = [np.array([run for name in ACCURATE for run in found[name][k]]) for k in range(len(values))]
            with np.errstate(invalid="ignore"):
                parts = [np.var(runs, axis=0, ddof=1) / runs.mean(axis=0) ** 2 for runs in accurate]
            scatter = np.mean(parts, axis=0) ** 0.5
            changes = [f"chance: {100 * part:.1f}" if np.isfinite(part) else "-" for part in scatter]
        else:
            spread = zip(np.mean(away, axis=0), np.std(away, axis=0, ddof=1) / len(away) ** 0.5, strict=True)
            changes = [f"{100 * mean:+.1f} ± {100 * error:.1f}" if np.isfinite(mean) else "-" for mean, error in spread]
        own = records[setting]
        steps = sum(len(record.status) for record in own)
        rows.append(
            [
                title,
                setting,
                f"{np.mean([v[0] for sample in values for v in sample]):.2f}",
                *changes,
                f"{100 * sum(record.unconverged for record in own) / steps:.0f} %",
                f"{np.mean(np.concatenate([record.iterations for record in own])):.0f}",
                f"{sum(record.seconds for record in own) / len(own):.1f}",
            ]
        )
    return rows


def main() -> None:
    print(f"load of the machine: {load()}")
    raw, rows = [], []
    cases = [(law, seed) for law in LAWS for seed in SAMPLES]
    with multiprocessing.get_context("spawn").Pool(PROCESSES) as pool:
        made = dict(zip(((name(law), seed) for law, seed in cases), pool.map(runs, cases, chunksize=1), strict=True))
    for title in map(name, LAWS):
        found: dict[str, list] = defaultdict(lambda: [[] for _ in SAMPLES])
        records = defaultdict(list)
        for seed in SAMPLES:
            for setting, record in made[title, seed]:
                found[setting][seed].append(late(record))
                records[setting].append(record)
                raw.append([title, seed, setting, *(f"{value:.4f}" for value in late(record)), record.unconverged])
                raw[-1] += [len(record.status), f"{record.iterations.mean():.0f}", f"{record.seconds:.2f}"]
        rows += summary(title, found, records)
    heads = ["reaction [kN]", "deviator [kPa]", "mean stress of the wire [kPa]"]
    cost = ["not converged", "sweeps a step", "s"]
    report("tolerance_runs", ["wire", "sample", "changed", *heads, "not converged", "steps", *cost[1:]], raw)
    changes = ["change of the reaction [%]", "of the deviator [%]", "of the stress of the wire [%]"]
    report("tolerance", ["wire", "changed", heads[0], *changes, *cost], rows)


if __name__ == "__main__":
    main()
