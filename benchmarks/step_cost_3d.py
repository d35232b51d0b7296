"""What a step in 3D costs from 1 000 to 100 000 spheres, and which part of it is detection.

Spheres that fall from a loose lattice into a box, where lists of neighbours are made anew every few steps, and dense
samples from the deposit, at 25 sweeps a step. Seconds are those of the processor, on one thread; detection is all that
leads from positions to interactions, lists included.

    python benchmarks/step_cost_3d.py
"""

from __future__ import annotations

import time
from types import SimpleNamespace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.contact.detector import Detector
from lmgcpy.dynamics import solve_step, stepper

SWEEPS = 25
RADIUS = 0.01
COUNTS = (1_000, 10_000, 100_000)


def falling(count: int) -> lm.Scene:
    """A lattice with gaps of 2 % of a diameter and more, thrown about."""
    rng = np.random.default_rng(0)
    side = round(count ** (1.0 / 3.0))
    cells = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    radii = RADIUS * rng.uniform(0.8, 1.0, len(cells))
    places = 2.02 * RADIUS * (cells + 0.5) + 0.01 * RADIUS * rng.uniform(-1.0, 1.0, cells.shape)
    return scene_of(radii, places, 2.02 * RADIUS * side, velocity=0.3 * rng.normal(size=cells.shape))


def dense(count: int) -> lm.Scene:
    """A geometric deposit of about the same height as width, released."""
    radii = lm.sample.grading(count, minimum=1.6 * RADIUS, maximum=2.0 * RADIUS, by="diameter", seed=0)
    side = (np.sum(4.0 / 3.0 * np.pi * radii**3) / 0.6) ** (1.0 / 3.0)
    places = lm.sample.deposit(radii, box=(side, side, None), seed=0)
    return scene_of(radii, places, side, velocity=np.zeros((count, 3)))


def scene_of(radii: np.ndarray, places: np.ndarray, side: float, velocity: np.ndarray) -> lm.Scene:
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
    sand = lm.Material("sand", density=2600.0)
    for radius, place, start in zip(radii, places, velocity, strict=True):
        scene.add(lm.sphere(radius=radius, position=place, material=sand, velocity=start))
    for axis, end in ((0, 0.0), (0, side), (1, 0.0), (1, side), (2, 0.0)):
        normal = np.eye(3)[axis] * (1.0 if end == 0.0 else -1.0)
        scene.add(lm.wall(point=end * np.eye(3)[axis], normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return scene


def measure(name: str, scene: lm.Scene, steps: int) -> list:
    solver = lm.GaussSeidel(tolerance=1e-6, max_iterations=SWEEPS)
    sim = lm.Simulation(scene, time_step=5e-4, solver=solver, on_unconverged="ignore", overlap="ignore")
    sim.run(steps=20)
    detection, detect, rebuilds = [], Detector.detect, sim._detector.rebuilds

    def timed(*arguments):
        begin = time.thread_time()
        found = detect(*arguments)
        detection.append(time.thread_time() - begin)
        return found

    clock, counted = stepper.clock, SimpleNamespace(perf_counter=time.thread_time)
    stepper.clock = solve_step.clock = counted  # type: ignore[assignment]
    Detector.detect = timed  # type: ignore[method-assign]
    try:
        reports = [sim.step() for _ in range(steps)]
    finally:
        Detector.detect, stepper.clock, solve_step.clock = detect, clock, clock  # type: ignore[method-assign]
    assert np.isfinite(sim.positions).all()
    whole, solve = (sum(getattr(r, what) for r in reports) for what in ("step_seconds", "seconds"))
    updates = sum(r.interactions * r.iterations for r in reports)
    return [
        name,
        len(sim.positions),
        f"{reports[-1].interactions / len(sim.positions):.1f}",
        f"{(sim._detector.rebuilds - rebuilds) / steps:.2f}",
        f"{1e3 * whole / steps:.1f}",
        f"{1e9 * solve / updates:.1f}",
        f"{1e9 * whole / updates:.1f}",
        f"{100 * sum(detection) / whole:.0f} %",
        f"{100 * (whole - solve) / whole:.0f} %",
    ]


if __name__ == "__main__":
    header = [
        "scene",
        "bodies",
        "interactions a body",
        "lists a step",
        "step [ms]",
        "solver, an interaction and sweep [ns]",
    ]
    header += ["step, an interaction and sweep [ns]", "detection (goal 20 %)", "all but the solver"]
    rows = []
    for count in COUNTS:
        steps = max(10, 100_000 // count)
        rows += [measure(scene.__name__, scene(count), steps) for scene in (falling, dense)]
    report("step_cost_3d", header, rows)
