"""Piles: steps of pyramids of equal spheres, and of heaps whose masses lie decades apart, by each solver.

A pyramid is as hyperstatic as spheres can be: inside, each touches four neighbours in the layer, four below and four
above. In a heap masses are drawn at random over a range of up to six decades, whatever the place, so that heavy spheres lie
on light ones. The step of a pyramid is the first under gravity, from no impulses; that of a heap is taken after some steps
of settling, from the impulses of the step before. What is not solved stands in the table as well.

python benchmarks/piles.py [TOLERANCE]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.bench.frontier import warm
from lmgcpy.solve.problems.report import SOLVED
from lmgcpy.solve.solvers import SOLVERS

RADIUS = 0.01
LAYERS = (4, 6, 8)
RATIOS = (1e0, 1e2, 1e4, 1e6)
FRICTIONS = (0.3, 0.8)
SPHERES, SEEDS = 200, (0, 1)
GRAVITY = (0.0, 0.0, -9.81)


def pyramid(layers: int, friction: float) -> lm.Problem:
    """The first step of a pyramid with a square base on a rough floor."""
    scene = lm.Scene(dimension=3, gravity=GRAVITY)
    for layer in range(layers):
        side = layers - layer
        for i in range(side):
            for j in range(side):
                x, y = (RADIUS * (2 * k + layer) for k in (i, j))
                scene.add(lm.sphere(radius=RADIUS, position=(x, y, RADIUS * (1.0 + layer * 2.0**0.5)), mass=0.01))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    problem = step_of(scene, friction, steps=0)
    return replace(problem, guess=np.zeros_like(problem.guess))


def heap(ratio: float, friction: float, seed: int) -> lm.Problem:
    """A step of a deposit on a floor between four walls; masses are drawn over the ratio, evenly by their logarithm."""
    radii = lm.sample.grading(SPHERES, minimum=0.8 * RADIUS, maximum=RADIUS, by="diameter", seed=seed)
    side = 12.0 * RADIUS
    places = lm.sample.deposit(radii, box=(side, side, None), seed=seed)
    masses = 0.01 * ratio ** np.random.default_rng(seed).random(SPHERES)
    scene = lm.Scene(dimension=3, gravity=GRAVITY)
    for radius, place, mass in zip(radii, places, masses, strict=True):
        scene.add(lm.sphere(radius=radius, position=place, mass=mass))
    for axis in range(3):
        for end in (0.0, side)[: 2 if axis < 2 else 1]:
            point, normal = np.zeros(3), np.zeros(3)
            point[axis], normal[axis] = end, 1.0 if end == 0.0 else -1.0
            scene.add(lm.wall(point=point, normal=normal))
    return step_of(scene, friction, steps=40)


def step_of(scene: lm.Scene, friction: float, *, steps: int) -> lm.Problem:
    """The step after so many, made and left to be solved."""
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=friction))
    sweeps = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=1000)
    sim = lm.Simulation(scene, time_step=1e-3, solver=sweeps, on_unconverged="ignore").run(steps=steps)
    sim.solver = lm.GaussSeidel(tolerance=1e-3, max_iterations=1)
    return sim.run(steps=1).problem()


def problems() -> Iterator[tuple[str, float, list[lm.Problem]]]:
    """Name, friction, and the problems of one kind, with their guess."""
    for friction in FRICTIONS:
        for layers in LAYERS:
            yield f"pyramid of {layers} layers", friction, [pyramid(layers, friction)]
        for ratio in RATIOS:
            yield f"heap, masses over {ratio:g}", friction, [heap(ratio, friction, seed) for seed in SEEDS]


def main(tolerance: float) -> None:
    rows = []
    for name, friction, steps in problems():
        warm(steps[0])
        for solver, kind in SOLVERS.items():
            told = [lm.solve(problem, solver=kind(tolerance=tolerance)) for problem in steps]
            rows.append(
                [
                    name,
                    " / ".join(str(len(problem.mu)) for problem in steps),
                    friction,
                    solver,
                    f"{sum(solution.status in SOLVED for solution in told)} of {len(told)}",
                    f"{max(solution.residual for solution in told):.0e}",
                    " / ".join(str(solution.iterations) for solution in told),
                    " / ".join(str(solution.factorisations) for solution in told),
                    " / ".join(f"{solution.seconds:.2f}" for solution in told),
                ]
            )
            print(*rows[-1], sep=", ", file=sys.stderr, flush=True)
    head = ["step", "interactions", "friction", "solver", "solved", "worst residual", "sweeps", "Newton steps", "s"]
    report("piles", head, rows)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 1e-6)
