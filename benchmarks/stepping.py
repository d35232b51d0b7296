"""One level above the solvers: what tolerance and time step do to the results of a run.

1. Biaxial tests of one small sample of sand and of TexSol: mean reaction and Weber stress over the last part of the test,
   for solver tolerances of 1e-2 to 1e-7 at the default time step and for time steps of 2, 1, 1/2 and 1/4 times the
   default one at 1e-4. The path of a sample is chaotic: any change, also one of round-off in the guess, leads to another
   history of slips; what that does is told by runs with grains moved by 1e-9 of their size.
2. Order of the stepping where nothing opens, closes or slides: errors at a given time against the time step, of a
   pendulum (rigid rod), of a mass on an elastic rod, and of a ball on an incline that rolls.

    python benchmarks/stepping.py
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from table import report

import lmgcpy as lm
from lmgcpy.bench.machine import load
from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol_sample import lay_sample

PRESSURE, DENSITY, STRAIN = 1e5, 2600.0, 0.02
TOLERANCES = tuple(10.0**-k for k in range(2, 8))
MOVED = (1, 2, 3)
"""Seeds of runs with grains moved by 1e-9 of their size."""


def crush(sample: Sample, law: lm.Law | None, tolerance: float, part: float = 1.0) -> BiaxialRecord:
    """A biaxial test at ``part`` times the default time step."""
    solver = lm.Auto(tolerance=tolerance, max_iterations=4000, max_factorisations=40)
    test = {"pressure": PRESSURE, "density": DENSITY, "solver": solver}
    step = part * Biaxial(sample, law, **test).time_step
    return Biaxial(sample, law, time_step=step, **test).run(STRAIN, frames=0)


def late(record: BiaxialRecord) -> np.ndarray:
    """Means over the second half of the test: reaction [kN], stress along and across the axis, that of the wire [kPa]."""
    half = record.strain > 0.5 * STRAIN
    total, wire = (record.stress[part][half].mean(axis=0) for part in ("total", "wire"))
    return np.array([record.reaction[half].mean(), total[1, 1], total[0, 0], wire[1, 1]]) / 1e3


def row(name: str, changed: str, record: BiaxialRecord) -> list:
    steps = len(record.status)
    cells = [name, changed, *(f"{value:.3f}" for value in late(record)), f"{record.unconverged} of {steps}"]
    cells += [f"{record.iterations.mean():.0f}", f"{record.seconds:.1f}"]
    print(*cells, file=sys.stderr, flush=True)  # so that one sees how far it is
    return cells


def samples() -> None:
    sample = compact(lay_sample(170, 30, seed=0), pressure=PRESSURE, density=DENSITY).sample
    rows = []
    for law in (None, lm.RigidWire()):
        name = "sand" if law is None else law.NAME
        for tolerance in TOLERANCES:
            rows.append(row(name, f"tolerance {tolerance:g}", crush(sample, law, tolerance)))
        for part in (2.0, 0.5, 0.25):
            rows.append(row(name, f"time step x {part:g}", crush(sample, law, 1e-4, part)))
        for seed in MOVED:
            away = np.random.default_rng(seed).uniform(-1e-9, 1e-9, sample.positions.shape) * sample.radii[:, None]
            moved = replace(sample, positions=sample.positions + away)
            rows.append(row(name, "grains moved by 1e-9", crush(moved, law, 1e-4)))
    heads = [
        "reaction [kN]",
        "axial stress [kPa]",
        "lateral stress [kPa]",
        "axial stress of the wire [kPa]",
        "not converged",
    ]
    report("stepping_samples", ["sample", "changed", *heads, "sweeps a step", "s"], rows)


# --------------------------------------------------------------------------------------------------------------- orders

LENGTH, GRAVITY, STIFFNESS = 1.0, 9.81, 10.0
STEPS = (400, 800, 1600, 3200)


def pendulum(steps: int, theta: float) -> float:
    """Distance from the solution of the equation of motion after a second, started at rest at an angle of 1 [m]."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -GRAVITY))
    pivot = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    pivot.fix()
    bob = scene.add(lm.disk(radius=0.1, position=(LENGTH * np.sin(1.0), -LENGTH * np.cos(1.0)), mass=1.0))
    scene.chain([pivot, bob], lm.RigidRod())
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    motion = solve_ivp(
        lambda t, y: (y[1], -GRAVITY / LENGTH * np.sin(y[0])), (0.0, 1.0), (1.0, 0.0), rtol=1e-12, atol=1e-12
    )
    angle = motion.y[0, -1]
    return float(np.hypot(bob.position[0] - LENGTH * np.sin(angle), bob.position[1] + LENGTH * np.cos(angle)))


def spring(steps: int, theta: float) -> float:
    """Distance from ``v sin(omega t) / omega`` after a second of a mass on an elastic rod, pushed off at 0.3 m/s [m]."""
    scene = lm.Scene(dimension=2)
    end = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    end.fix()
    bob = scene.add(lm.disk(radius=0.1, position=(LENGTH, 0.0), mass=1.0, velocity=(0.3, 0.0)))
    scene.chain([end, bob], lm.ElasticRod(stiffness=STIFFNESS))
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    omega = np.sqrt(STIFFNESS)
    return float(abs(bob.position[0] - LENGTH - 0.3 / omega * np.sin(omega)))


def rolling(steps: int, theta: float) -> float:
    """Distance from ``g sin(a) t^2 / 3`` after a second of a disk that rolls down an incline of 0.2 [m]."""
    scene = lm.Scene(dimension=2, gravity=(GRAVITY * np.sin(0.2), -GRAVITY * np.cos(0.2)))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
    lm.Simulation(scene, time_step=1.0 / steps, theta=theta, solver=lm.Newton(tolerance=1e-13)).run(steps=steps)
    return float(abs(ball.position[0] - GRAVITY * np.sin(0.2) / 3.0))


def orders() -> None:
    rows = []
    for name, case in (("pendulum, rigid rod", pendulum), ("mass on an elastic rod", spring), ("rolling disk", rolling)):
        for theta in (0.5, 1.0):
            errors = np.array([case(steps, theta) for steps in STEPS])
            exact = errors.max() < 1e-10  # round-off
            order = "exact" if exact else f"{np.log2(errors[-2] / errors[-1]):.2f}"
            rows.append([name, theta, *(f"{error:.1e}" for error in errors), order])
    report(
        "stepping_orders",
        ["case", "theta", *(f"error at h = 1/{steps} s" for steps in STEPS), "order of the last two"],
        rows,
    )


def main() -> None:
    print(f"load of the machine: {load()}")
    orders()
    samples()


if __name__ == "__main__":
    main()
