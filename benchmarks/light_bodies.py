"""Light bodies between heavy ones: a squeezed wire that is pulled, and a triaxial test with beads of their own mass.

The wire: twenty beads, each squeezed by 100 N between grains of 1 kg, friction 0.4, pulled by a part of what friction
holds; the way of the pulled bead in ten steps, in its radii, over mass ratios, time steps and solvers. Below 1 it must
not move. The test: 800 grains of 1 mm and a rigid wire of 350 beads, crushed across the layers to 8 % with beads as
heavy as a mean grain, and then, from rest, by 40 steps more with lighter ones; three seeds. Under "taut" are links of
349 that pull.

    python benchmarks/light_bodies.py
"""

from __future__ import annotations

import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Triaxial, compact
from lmgcpy.experiment.texsol.study import DENSITY, Study3D

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "dynamics"))
from squeezed_wire import squeezed_wire, way

SOLVERS = {
    "accelerated 1e-2": lm.AcceleratedGaussSeidel(tolerance=1e-2),
    "auto 1e-4": lm.Auto(tolerance=1e-4),
    "auto 1e-9": lm.Auto(tolerance=1e-9),
}
SEEDS = 3
STEPS = 40
BUDGET = 4000


def pulled() -> None:
    """The squeezed wire."""
    rows = []
    for pull in (0.5, 0.9, 1.1, 1.5):
        for ratio in (1e2, 1e4, 1e6):
            for time_step in (1e-3, 2.5e-4, 6e-5):
                for name, solver in SOLVERS.items():
                    begin = time.process_time()
                    end, longest, sim = way(*squeezed_wire(ratio, pull), time_step, solver, 10)
                    seconds = time.process_time() - begin
                    row = [pull, f"{ratio:g}", f"{1e3 * time_step:g}", name, f"{end:.2g}", f"{longest:.1g}"]
                    rows.append([*row, sim.unconverged_steps, f"{seconds:.2f}"])
    header = ["pull", "mass ratio", "h [ms]", "solver", "way [radii]", "longest way of a body", "unsolved of 10", "s"]
    report("light_bodies_wire", header, rows)


def crushing(seed: int):
    """The relaxed sample, and its test at 8 % with heavy beads."""
    study = Study3D(grain_count=800, bead_count=350, seed=seed, laws=("rigid-wire",), axes=("z",))
    laid = study.lay_sample()
    relaxed = compact(laid, pressure=1e5, density=DENSITY, friction=0.4, **study.relaxation(laid)).sample
    test = Triaxial(relaxed, lm.RigidWire(), inertial_number=2e-3, solver=study.solver_of_tests())
    test.run(0.08, frames=0)
    return relaxed, test


def crushed(seed: int):
    """The sample at 8 % with heavy beads."""
    relaxed, test = crushing(seed)
    return test.box.sample(relaxed)


def running() -> None:
    """The triaxial test whose beads get lighter as it runs."""
    rows = []
    for seed in range(SEEDS):
        relaxed, heavy = crushing(seed)
        start, sims, least, found = heavy.simulation.checkpoint(), {}, {}, {}
        for part in (1.0, 1e-2, 1 / 400):
            solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=BUDGET)
            lighter = replace(relaxed, bead_mass=part * relaxed.bead_mass)
            test = Triaxial(lighter, lm.RigidWire(), inertial_number=2e-3, solver=solver)
            test._duration = heavy._duration  # of the ramp of the platen
            options = {"time_step": test.time_step, "on_unconverged": "ignore", "overlap": "ignore"}
            sims[part] = lm.Simulation(test.box.scene, solver=solver, **options)
        for _ in range(4):  # the first one compiles
            for part, sim in sims.items():
                sim.restore(start)
                begin = time.process_time()
                found[part] = [sim.step() for _ in range(20)]
                seconds = time.process_time() - begin
                least[part] = min(seconds, least.get(part, np.inf))
        sweeps = {part: np.mean([step.iterations for step in steps]) for part, steps in found.items()}
        for part, steps in found.items():
            row = [f"{part:g}", seed, f"{sum(step.solved for step in steps)} of 20", f"{sweeps[part]:.0f}"]
            row += [f"{50 * least[part]:.0f}", f"{sweeps[part] / sweeps[1.0]:.1f}", f"{least[part] / least[1.0]:.1f}"]
            rows.append(row)
    header = ["bead / grain", "seed", "solved", "sweeps a step", "ms a step", "ratio of sweeps", "ratio of times"]
    report("light_bodies_running", header, rows)


def tests() -> None:
    """The triaxial test."""
    rows = []
    samples = [crushed(seed) for seed in range(SEEDS)]
    for part in (1.0, 1e-1, 1e-2, 1 / 400, 1e-5):
        for seed, sample in enumerate(samples):
            solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=BUDGET)
            lighter = replace(sample, bead_mass=part * sample.bead_mass)
            test = Triaxial(lighter, lm.RigidWire(), inertial_number=2e-3, solver=solver)
            simulation = lm.Simulation(
                test.box.scene, time_step=test.time_step, solver=solver, on_unconverged="ignore", overlap="ignore"
            )
            found, begin = [], time.process_time()
            for _ in range(STEPS):
                step = simulation.step()
                pull = -simulation.interactions.force[: sample.bead_count - 1, 0]
                taut = (pull > 1e-3 * pull.max()).sum()
                found.append([step.solved, step.iterations, step.stretch, pull.mean(), taut, step.slip, step.force])
            seconds = time.process_time() - begin
            solved, sweeps, stretch, tension, taut, slip, force = np.array(found, dtype=float).T
            row = [f"{part:g}", seed, f"{int(solved.sum())} of {STEPS}", f"{sweeps.mean():.0f}", f"{np.median(sweeps):.0f}"]
            row += [f"{1e3 * seconds / STEPS:.0f}", f"{slip.max():.1e}", f"{force.max():.1e}", f"{np.median(stretch):.1e}"]
            rows.append([*row, f"{tension[5:].mean():.4f}", f"{taut[5:].mean():.0f}"])
    header = ["bead / grain", "seed", "solved", "sweeps a step", "median", "ms a step", "greatest slip", "of a force"]
    report("light_bodies_test", [*header, "elongation, median", "tension [N]", "taut"], rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # wires that are torn out move far in a step
    pulled()
    tests()
    running()
