"""What a step costs in small scenes, where the work around the kernels counts: heaps of 1 to 1000 grains in a box.

The cost of ``sim.step()`` and of a step of ``sim.run``, which records nothing, with ``Auto`` and with ``GaussSeidel``:
least mean of 100 steps, of five in turn. The error is the penetration, in radii, of the worst contact.

python benchmarks/small_scenes.py
"""

from __future__ import annotations

import time

import numpy as np
from table import report

import lmgcpy as lm

RADIUS = 0.01
COUNTS = (1, 10, 100, 1000)
STEPS, TURNS = 100, 5
SOLVERS = (lm.Auto, lm.GaussSeidel)


def heap(dimension: int, count: int) -> lm.Simulation:
    """Grains on a lattice, a little apart, in a box whose walls they do not fill."""
    rng = np.random.default_rng(1)
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=tuple(-9.81 * up))
    stone = lm.Material("stone", density=2600.0)
    grain = lm.disk if dimension == 2 else lm.sphere
    side = max(1, round(count ** (1.0 / dimension)))
    for i in range(count):
        cell = np.array([i // side**axis % side for axis in range(dimension - 1)] + [i // side ** (dimension - 1)])
        place = RADIUS * (2.05 * cell + 1.05)
        place[0] += 0.04 * RADIUS * rng.random()
        scene.add(grain(radius=RADIUS, position=tuple(place), material=stone))
    width = RADIUS * (2.05 * side + 0.2)
    scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(up)))
    for axis in np.eye(dimension)[:-1]:
        scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(axis)))
        scene.add(lm.wall(point=tuple(width * axis), normal=tuple(-axis)))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-4))


def settled(dimension: int, count: int, solver: type[lm.Solver] = lm.Auto) -> lm.Simulation:
    """The heap after 0.3 s."""
    sim = heap(dimension, count)
    sim.solver = solver(tolerance=1e-4)
    sim.on_unconverged = "ignore"  # at rest GaussSeidel stagnates in one or two steps of a thousand
    return sim.run(steps=300)


def stepped(sim: lm.Simulation) -> None:
    for _ in range(STEPS):
        sim.step()


def main() -> None:
    scenes = [(dimension, count) for dimension in (2, 3) for count in COUNTS]
    sims = {(*scene, solver): settled(*scene, solver) for scene in scenes for solver in SOLVERS}
    ways = {"step": stepped, "run": lambda sim: sim.run(steps=STEPS)}
    seconds: dict[tuple, list[float]] = {(*which, way): [] for which in sims for way in ways}
    for _ in range(TURNS):
        for which, sim in sims.items():
            for way, make in ways.items():
                begin = time.perf_counter()
                make(sim)
                seconds[*which, way].append((time.perf_counter() - begin) / STEPS)
    rows = []
    for dimension, count in scenes:
        milliseconds = [f"{1e3 * min(seconds[dimension, count, solver, way]):.3f}" for solver in SOLVERS for way in ways]
        sim = sims[dimension, count, lm.Auto]
        gap = sim.interactions.gap
        worst = max(0.0, -float(gap.min())) / RADIUS if len(gap) else 0.0
        rows.append([f"{dimension}D", count, len(gap), sim.report.iterations, *milliseconds, f"{worst:.1e}"])
    report(
        "small_scenes",
        [
            "",
            "grains",
            "interactions",
            "sweeps of the last step",
            "step() [ms]",
            "a step of run() [ms]",
            "step(), GaussSeidel [ms]",
            "a step of run(), GaussSeidel [ms]",
            "penetration [radii]",
        ],
        rows,
    )


if __name__ == "__main__":
    main()
