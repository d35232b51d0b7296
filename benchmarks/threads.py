"""What slabs and threads gain: steps of a dense sample solved to the same residual in the plain order by ids and by slabs.

The steps are the same for both: they start from the same checkpoints. The samples are geometric deposits, released, whose
ids say nothing of where a body is, and the same with ids sorted by height, the best that the plain order can have.
One thread: seconds of the processor, so that other work on the machine does not count. Two threads and more: what a
hundred sweeps by them gain over the same sweeps by one, by the clock, the least times of many runs that take turns;
their results are compared to the bit.

Periodic scenes likewise: the deposit without side walls ("bed"), and scattered grains in a cell that compresses them until
they are dense, and then is sheared at a rate or yields to a pressure.

    python benchmarks/threads.py          deposits
    python benchmarks/threads.py cells    periodic cells
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from
from lmgcpy.dynamics import solve_step as stepping

RADIUS = 0.01
COUNTS = (3_000, 5_000, 10_000, 20_000)
STEPS = 3
SWEEPS = 200
"""By ids, a step; the residual that they leave is what the slabs have to reach."""
FEW = 100
"""Sweeps of which the gain of threads is measured: they are started for each step."""
RUNS = 12
CELLS = "bed", "sheared", "pressed"
SHEAR, PRESSURE = 2.0, 1e5
"""Rate of a cell that is sheared [1/s], and pressure on one that yields [Pa]."""
LOOSE, DENSE = {2: 0.45, 3: 0.3}, {2: 0.83, 3: 0.61}
"""Solid fractions of scattered grains, and at the end of the compression."""


def deposit(dimension: int, count: int, ids: str, *, walls: bool = True) -> lm.Scene:
    """A released geometric deposit of about the same height as width, between walls or periodic sides."""
    radii = lm.sample.grading(count, minimum=1.6 * RADIUS, maximum=2.0 * RADIUS, by="diameter", seed=0)
    sizes = np.pi * radii**2 / 0.82 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3 / 0.6
    side = float(np.sum(sizes) ** (1.0 / dimension))
    places = lm.sample.deposit(radii, box=(*[side] * (dimension - 1), None), seed=0)
    axes = np.eye(dimension)
    scene = lm.Scene(dimension=dimension, gravity=-9.81 * axes[-1])
    sand, make = lm.Material("sand", density=2600.0), lm.disk if dimension == 2 else lm.sphere
    for i in np.argsort(places[:, -1]) if ids == "by height" else range(count):
        scene.add(make(radius=radii[i], position=places[i], material=sand))
    for axis in axes[:-1] if walls else ():
        scene.add(lm.wall(point=0.0 * axis, normal=axis))
        scene.add(lm.wall(point=side * axis, normal=-axis))
    if not walls:
        scene.periodic(**dict.fromkeys("xy"[: dimension - 1], side))
    scene.add(lm.wall(point=0.0 * axes[-1], normal=axes[-1]))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    return scene


def periodic(radii: np.ndarray, places: np.ndarray, side: float) -> tuple[lm.Scene, lm.Cell]:
    """Grains in a square or cubic cell."""
    dimension = places.shape[1]
    scene = lm.Scene(dimension=dimension)
    sand, make = lm.Material("sand", density=2600.0), lm.disk if dimension == 2 else lm.sphere
    for radius, place in zip(radii, places, strict=True):
        scene.add(make(radius=radius, position=place, material=sand))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    return scene, scene.periodic(**dict.fromkeys("xyz"[:dimension], side))


@cache
def compressed(dimension: int, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Radii, places and side of a cell that was compressed at a rate until it is dense, in a hundred steps."""
    radii = lm.sample.grading(count, minimum=1.6 * RADIUS, maximum=2.0 * RADIUS, by="diameter", seed=0)
    volume = float((np.pi * radii**2 if dimension == 2 else 4.0 / 3.0 * np.pi * radii**3).sum())
    side = (volume / LOOSE[dimension]) ** (1.0 / dimension)
    scene, cell = periodic(radii, lm.sample.scatter(radii, cell=(side,) * dimension, seed=0), side)
    rate = -np.log(DENSE[dimension] / LOOSE[dimension]) / dimension / 0.02
    cell.impose_rate(**{axis + axis: rate for axis in "xyz"[:dimension]})
    solver = lm.GaussSeidel(tolerance=1e-2, max_iterations=50)
    options = {"solver": solver, "overlap": "ignore", "on_unconverged": "ignore"}
    sim = lm.Simulation(scene, time_step=2e-4, **options).run(steps=100)
    return radii, cell.wrapped(sim.positions[:count, :dimension]), float(cell.edges[0, 0])


def periodic_scene(dimension: int, count: int, kind: str) -> lm.Scene:
    """A bed between periodic sides, or a compressed cell that is sheared or pressed from now on."""
    if kind == "bed":
        return deposit(dimension, count, "at random", walls=False)
    scene, cell = periodic(*compressed(dimension, count))
    if kind == "sheared":
        cell.impose_rate(xy=SHEAR)
    else:
        cell.impose_stress(**{axis + axis: -PRESSURE for axis in "xyz"[:dimension]})
    return scene


def simulation(make: Callable[..., lm.Scene], case: tuple, *, slabs: bool) -> lm.Simulation:
    scene = make(*case)
    with partition_from(0 if slabs else len(scene.bodies) + 1):
        return lm.Simulation(scene, time_step=2e-4, overlap="ignore", on_unconverged="ignore")


def solved(sim: lm.Simulation, residual: float, sweeps: int) -> tuple[int, float]:
    """Make a step, solved by the residual alone; returns (sweeps, seconds of the solver by the clock that the simulation
    has)."""
    sim.solver = lm.GaussSeidel(tolerance=residual, max_iterations=sweeps, slip=1e9, force=1e9)
    made = sim.step()
    return made.iterations, made.seconds


def gains(sim: lm.Simulation, start, counts: list[int]) -> list[float]:
    """How many times as fast some sweeps are by so many threads as by one."""
    seconds, impulses = np.empty((RUNS, 1 + len(counts))), set()
    for run in range(RUNS):
        for k, threads in enumerate([1, *counts]):
            sim.restore(start)
            sim.threads = threads
            seconds[run, k] = solved(sim, 1e-9, FEW)[1]
            if run == 0:
                impulses.add(sim.interactions.impulse.tobytes())
    sim.threads = 1
    assert len(impulses) == 1, "the bits depend on the threads"
    least = seconds.min(axis=0)
    return [float(least[0] / of_some) for of_some in least[1:]]


def measure(make: Callable[..., lm.Scene], case: tuple, counts: list[int]) -> list:
    by_ids, by_slabs = (simulation(make, case, slabs=slabs) for slabs in (False, True))
    by_ids.solver = lm.GaussSeidel(tolerance=1e-2, max_iterations=50)
    start = by_ids.run(steps=40).checkpoint()
    clock, stepping.clock = stepping.clock, SimpleNamespace(perf_counter=time.thread_time)  # type: ignore[assignment]
    totals = np.zeros((2, 2))
    try:
        for _ in range(STEPS):
            by_slabs.restore(start)
            totals[0] += solved(by_ids, 1e-9, SWEEPS)
            totals[1] += solved(by_slabs, by_ids.report.residual, 20 * SWEEPS)
            first, start = start, by_ids.checkpoint()
    finally:
        stepping.clock = clock
    sweeps, seconds = totals.T
    per_update = 1e9 * seconds / (sweeps * by_ids.report.interactions)
    alone = float(seconds[0] / seconds[1])
    dimension, count, kind = case
    return [
        *(f"{dimension}D", count, kind, by_ids.report.interactions),
        *(f"{by_ids.report.residual:.0e}", f"{sweeps[1] / sweeps[0]:.2f}", *(f"{t:.1f}" for t in per_update)),
        *(f"{alone * gain:.2f}" for gain in [1.0, *gains(by_slabs, first, counts)]),
    ]


if __name__ == "__main__":
    counts = list(range(2, os.cpu_count() + 1))
    name, make, kinds, of_kinds = "threads", deposit, ("at random", "by height"), "ids"
    sizes = [(d, n) for d in (3, 2) for n in COUNTS]
    if sys.argv[1:] == ["cells"]:
        name, make, kinds, of_kinds = "threads_in_cells", periodic_scene, CELLS, "cell"
        sizes = [(3, 3_000), (3, 10_000), (2, 10_000)]
    header = ["", "bodies", of_kinds, "interactions", "residual", "sweeps, by ids = 1"]
    header += [f"an interaction and sweep by {order} [ns]" for order in ("ids", "slabs")]
    header += ["speed with one thread, by ids = 1", *(f"with {n}" for n in counts)]
    cases = [(*size, kind) for size in sizes for kind in kinds]
    report(name, header, [measure(make, case, counts) for case in cases])
