"""What slabs and threads gain: one step of a dense sample solved to the same residual in the plain order by ids, and by
slabs with one, two … threads.

The step is the same for all: they start from one checkpoint. The samples are geometric deposits, released, whose ids say
nothing of where a sphere is, and the same with ids sorted by height, the best that the plain order can have. Seconds are
those of the clock, the least of several runs that take turns; results with slabs are compared to the bit.

    python benchmarks/threads.py
"""

from __future__ import annotations

import os

import numpy as np
from step_cost_3d import RADIUS, scene_of
from table import report

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from

RUNS = 2
COUNTS = (10_000, 50_000)
SWEEPS = 400
"""By ids; the residual that they leave is what the others have to reach."""


def deposit(count: int, by_height: bool) -> lm.Scene:
    radii = lm.sample.grading(count, minimum=1.6 * RADIUS, maximum=2.0 * RADIUS, by="diameter", seed=0)
    side = (np.sum(4.0 / 3.0 * np.pi * radii**3) / 0.6) ** (1.0 / 3.0)
    places = lm.sample.deposit(radii, box=(side, side, None), seed=0)
    order = np.argsort(places[:, 2]) if by_height else np.arange(count)
    return scene_of(radii[order], places[order], side, velocity=np.zeros((count, 3)))


def simulation(count: int, by_height: bool, *, slabs: bool, threads: int, solver) -> lm.Simulation:
    with partition_from(0 if slabs else count + 1):
        scene = deposit(count, by_height)
        options = {"solver": solver, "threads": threads, "overlap": "ignore", "on_unconverged": "ignore"}
        return lm.Simulation(scene, time_step=2e-4, **options)


def measure(count: int, by_height: bool) -> list[list]:
    given = lm.GaussSeidel(tolerance=1e-6, max_iterations=SWEEPS)
    ways = {"by ids": (False, 1)} | {f"slabs, {n} thread{'s' * (n > 1)}": (True, n) for n in range(1, os.cpu_count() + 1)}
    sims = [simulation(count, by_height, slabs=slabs, threads=n, solver=given) for slabs, n in ways.values()]
    sims[0].solver = lm.GaussSeidel(tolerance=1e-2, max_iterations=50)
    start = sims[0].run(steps=40).checkpoint()
    sims[0].solver = given
    seconds, impulses = np.empty((RUNS, len(sims))), {}
    for run in range(RUNS):
        for k, sim in enumerate(sims):
            sim.restore(start)
            if k > 0:
                sim.solver = lm.GaussSeidel(tolerance=sims[0].report.residual, max_iterations=10 * SWEEPS)
            seconds[run, k] = sim.step().seconds
            impulses[k] = sim.interactions.impulse
    assert all(np.array_equal(impulses[1], impulses[k]) for k in range(2, len(sims))), "the bits depend on the threads"
    best = seconds.min(axis=0)
    order = "by height" if by_height else "at random"
    return [
        [
            count,
            sims[k].report.interactions,
            order,
            way,
            sims[k].report.iterations,
            f"{sims[k].report.residual:.1e}",
            f"{1e3 * best[k]:.0f}",
            f"{1e9 * best[k] / (sims[k].report.iterations * sims[k].report.interactions):.1f}",
            f"{best[0] / best[k]:.2f}",
        ]
        for k, way in enumerate(ways)
    ]


if __name__ == "__main__":
    header = ["spheres", "interactions", "ids", "order", "sweeps", "residual", "solver [ms]"]
    header += ["an interaction and sweep [ns]", "speed, by ids = 1 (goal 1.6 with 2 threads)"]
    rows = []
    for count in COUNTS:
        for by_height in (False, True):
            rows += measure(count, by_height)
    report("threads", header, rows)
