"""The slope of a heap against rolling friction: columns of disks collapse on a plane, five seeds.

Columns of 200 disks, between three and four times as high as wide, are left alone at t = 0 and looked at 3 s later.
By rolling friction mu_r, with friction 0.5: mean and standard deviation over the seeds of the slope of the heap, the least
and the most. For a heap with the section of a triangle of height H and half base L, grains have the mean height H/3 and
the mean distance L/3 from the middle: the slope is ``atan(mean height / mean distance)``, both weighted by mass. Beside it
the speed that is left [m/s], steps that were not solved to the tolerance of 1e-4, and the largest error of the energy
identity, in parts of the energy at the start.

    python benchmarks/rolling_friction.py [--short]
"""

from __future__ import annotations

import sys

import numpy as np
from table import report

import lmgcpy as lm

ROLLING = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)
SEEDS = 5
G = 9.81


def heap(rolling: float, seed: int, *, grains: int, duration: float) -> tuple[float, float, int, float]:
    """Slope [degrees], speed that is left [m/s], unsolved steps, error of the energy identity."""
    radii = lm.sample.grading(grains, minimum=0.01, maximum=0.02, by="diameter", seed=seed)
    positions = lm.sample.deposit(radii, box=(0.11, None), seed=seed)
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    material = lm.Material("sand", density=2600.0)
    for radius, position in zip(radii, positions, strict=True):
        scene.add(lm.disk(radius=radius, position=position, material=material))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    law = lm.RollingCoulomb(friction=0.5, rolling_friction=rolling)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    solver = lm.GaussSeidel(tolerance=1e-4, max_iterations=2000)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    mass = radii**2 / (radii**2).sum()
    start = 2600.0 * np.pi * (radii**2 * positions[:, 1]).sum() * G
    defect = 0.0
    while sim.time < duration:
        sim.step()
        defect = max(defect, abs(sim.energy.defect) / start)
    x, y = sim.positions[:grains].T
    distance = np.abs(x - np.median(x)) @ mass
    speed = np.sqrt((sim.velocities[:grains] ** 2).sum(axis=1) @ mass)
    return float(np.degrees(np.arctan2(y @ mass, distance))), float(speed), sim.unconverged_steps, defect


def main() -> None:
    short = "--short" in sys.argv
    rows: list[list] = []
    for rolling in ROLLING[::3] if short else ROLLING:
        given = {"grains": 60, "duration": 0.3} if short else {"grains": 200, "duration": 3.0}
        found = np.array([heap(rolling, seed, **given) for seed in range(SEEDS)])
        slope = found[:, 0]
        numbers = f"{slope.mean():.1f}", f"{slope.std(ddof=1):.1f}", f"{slope.min():.1f}", f"{slope.max():.1f}"
        rows.append([rolling, *numbers, f"{found[:, 1].max():.1g}", int(found[:, 2].sum()), f"{found[:, 3].max():.0e}"])
    header = ["mu_r", "slope [deg]", "deviation", "least", "most", "speed left [m/s]", "unsolved steps", "energy defect"]
    report("rolling_friction", header, rows)


if __name__ == "__main__":
    main()
