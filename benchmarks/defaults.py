"""What the default solver costs on an ordinary job, by tolerance: grains that settle in a box and are pressed by its lid.

1000 disks, and 300 spheres, lie as they were deposited and settle for 60 steps. Then their lid is let go, and pressed
down with 1e5 Pa for 60 more. Errors: the largest overlap at the end in least radii, and the lid's way, which varies by
chance.

    python benchmarks/defaults.py
"""

from __future__ import annotations

import time
import warnings

import numpy as np
from table import report

import lmgcpy as lm

RADIUS = 0.005
PRESSURE = 1e5
STEPS = 60
SOLVERS = {
    "Auto, 1e-2": lm.Auto(tolerance=1e-2),
    "Auto, 1e-3 (default)": lm.Auto(),
    "Auto, 3e-4": lm.Auto(tolerance=3e-4),
    "Auto, 1e-4": lm.Auto(tolerance=1e-4),
    "AcceleratedGaussSeidel, 1e-3": lm.AcceleratedGaussSeidel(tolerance=1e-3),
}


def box(dimension: int, grains: int, solver: lm.Solver) -> tuple[lm.Simulation, lm.Body, float]:
    """Grains in a box, its lid, and the force on the lid [N]."""
    radii = lm.sample.grading(grains, minimum=RADIUS, maximum=2.0 * RADIUS, by="diameter", seed=0)
    side = 0.015 * grains ** (1.0 / dimension)
    places = lm.sample.deposit(radii, box=(*(side,) * (dimension - 1), None), seed=0)
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=tuple(-9.81 * up))
    add = scene.add_disks if dimension == 2 else scene.add_spheres
    add(radii, places, material=lm.Material("sand", density=2600.0))
    scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(up)))
    for axis in np.eye(dimension)[:-1]:
        scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(axis)))
        scene.add(lm.wall(point=tuple(side * axis), normal=tuple(-axis)))
    top = (np.asarray(places)[:, -1] + radii).max()
    lid = scene.add(lm.wall(point=tuple(top * up), normal=tuple(-up), mass=50.0))
    lid.fix()
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.4))
    sim = lm.Simulation(scene, time_step=5e-4, solver=solver, on_unconverged="ignore")
    return sim, lid, PRESSURE * side ** (dimension - 1)


def job(dimension: int, grains: int, name: str, solver: lm.Solver) -> list:
    """A row of the table."""
    sim, lid, force = box(dimension, grains, solver)
    down = "y" if dimension == 2 else "z"
    sim.step()  # compiles
    begin = time.process_time()
    sweeps = sum(sim.step().iterations for _ in range(STEPS))
    lid.free(down)
    lid.impose_force(**{down: -force})
    start = lid.position[-1]
    sweeps += sum(sim.step().iterations for _ in range(STEPS))
    seconds = time.process_time() - begin
    overlap = -sim.interactions.gap.min() / RADIUS
    row = [f"{dimension}D", name, f"{sweeps / (2 * STEPS):.0f}", sim.unconverged_steps, f"{overlap:.1e}"]
    return [*row, f"{1e3 * (start - lid.position[-1]):.3f}", f"{seconds:.1f}"]


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    rows = [job(d, grains, *solver) for d, grains in ((2, 1000), (3, 300)) for solver in SOLVERS.items()]
    header = ["job", "solver", "sweeps a step", "unsolved of 121", "overlap [r]", "way of the lid [mm]", "s"]
    report("defaults", header, rows)
