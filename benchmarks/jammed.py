"""Where friction jams: steps of dense packs of rough spheres, solved by each solver within what it allows itself.

Every pack is a deposit between six walls, three of which press alike; its step is taken after so many steps of compaction,
from the impulses of the step before and from none. What is not solved stands in the table as well.

python benchmarks/jammed.py [SPHERES [SAMPLES [TOLERANCE]]]
"""

from __future__ import annotations

import sys
import time as clock

import numpy as np
from table import report

import lmgcpy as lm

DENSITY, PRESSURE = 2600.0, 1e5
FRICTIONS = (0.3, 0.5, 0.8)
STEPS = 80
"""Steps of compaction: a step is a fifth of d sqrt(rho/p), the time in which the pressure moves a grain by its size."""


def isotropic(count: int, friction: float, seed: int) -> lm.Problem:
    """A step of a deposit of spheres between three walls that stand and three that press alike, as a problem."""
    radii = lm.sample.grading(count, minimum=0.004, maximum=0.005, by="diameter", seed=seed)
    volume = float((4.0 / 3.0 * np.pi * radii**3).sum())
    side = (volume / 0.58) ** (1.0 / 3.0)
    places = lm.sample.deposit(radii, box=(side, side, None), seed=seed)
    edges = np.array([side, side, float((places[:, 2] + radii).max())])
    scene = lm.Scene(dimension=3)
    material = lm.Material("sand", density=DENSITY)
    for radius, place in zip(radii, places, strict=True):
        scene.add(lm.sphere(radius=radius, position=place, material=material))
    for axis, normal in zip("xyz", np.eye(3), strict=True):
        scene.add(lm.wall(point=(0, 0, 0), normal=normal))
        lid = scene.add(lm.wall(point=edges * normal, normal=-normal, mass=0.1 * DENSITY * volume))
        lid.impose_force(**{axis: -PRESSURE * edges.prod() / (edges @ normal)})
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    step = 0.2 * 0.009 * (DENSITY / PRESSURE) ** 0.5
    sweeps = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=500)
    sim = lm.Simulation(scene, time_step=step, solver=sweeps, on_unconverged="ignore").run(steps=STEPS)
    sim.solver = lm.GaussSeidel(tolerance=3e-3, max_iterations=1)  # the step is made, and left to be solved
    return sim.run(steps=1).problem()


def main(spheres: int, samples: int, tolerance: float) -> None:
    solvers = lm.AcceleratedGaussSeidel(tolerance=tolerance), lm.Auto(tolerance=tolerance)
    rows = []
    for friction in FRICTIONS:
        for seed in range(samples):
            problem = isotropic(spheres, friction, seed)
            for start, guess in (("warm", problem.guess), ("cold", np.zeros_like(problem.guess))):
                for solver in solvers:
                    if not rows:
                        lm.solve(problem, solver=solver, guess=guess)  # loads the kernels
                    begin = clock.process_time()
                    solution = lm.solve(problem, solver=solver, guess=guess)
                    seconds = clock.process_time() - begin
                    rows.append(
                        [
                            spheres,
                            len(problem.mu),
                            friction,
                            seed,
                            start,
                            type(solver).__name__,
                            solution.status,
                            f"{solution.residual:.1e}",
                            solution.iterations,
                            solution.factorisations,
                            f"{seconds:.2f}",
                        ]
                    )
                    print(*rows[-1], file=sys.stderr, flush=True)
    header = ["spheres", "interactions", "friction", "seed", "start", "solver", "status", "residual", "sweeps"]
    report(f"jammed_{spheres}", [*header, "Newton steps", "processor seconds"], rows)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(
        int(given[0]) if given else 500,
        int(given[1]) if len(given) > 1 else 2,
        float(given[2]) if len(given) > 2 else 1e-4,
    )
