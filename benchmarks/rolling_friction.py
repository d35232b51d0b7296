"""The slope of a heap against rolling friction: columns of disks, and of spheres, collapse on a plane, five seeds.

Columns of 200 disks, between three and four times as high as wide, are left alone at t = 0 and looked at 3 s later; columns
of 200 spheres, two to three times as high as wide, 2 s later.
By rolling friction mu_r, with friction 0.5 (and in 3D torsion friction 2/3 mu mu_r): mean and standard deviation over the
seeds of the slope of the heap, the least and the most. For a heap with the section of a triangle of height H and half base
L, grains have the mean height H/3 and the mean distance L/3 from the middle: the slope is ``atan(mean height / mean
distance)``, both weighted by mass. For a cone they are H/4 and L/2: ``atan(2 mean height / mean distance)``. Beside it
the speed that is left [m/s], steps that were not solved to the tolerance of 1e-4, and the largest error of the energy
identity, in parts of the energy at the start.

Then what a sweep costs an interaction [ns], in a box of grains at rest on each other: the least of twenty steps of 200
sweeps, with Coulomb's law and with rolling friction.

    python benchmarks/rolling_friction.py [--short] [plane] [space] [cost]
"""

from __future__ import annotations

import sys

import numpy as np
from table import report

import lmgcpy as lm

ROLLING = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)
SEEDS = 5
G = 9.81
SIDE = {2: 0.11, 3: 0.12}
"""Width of the columns [m]."""
PLANE, SPACE, COST = "rolling_friction", "rolling_friction_3d", "rolling_friction_cost"
"""Names of the tables."""


def heap(rolling: float, seed: int, *, dimension: int, grains: int, duration: float) -> tuple[float, float, int, float]:
    """Slope [degrees], speed that is left [m/s], unsolved steps, error of the energy identity."""
    flat = dimension == 2
    radii = lm.sample.grading(grains, minimum=0.01, maximum=0.02, by="diameter", seed=seed)
    positions = lm.sample.deposit(radii, box=(*[SIDE[dimension]] * (dimension - 1), None), seed=seed)
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=-G * up)
    material = lm.Material("sand", density=2600.0)
    grain = lm.disk if flat else lm.sphere
    for radius, position in zip(radii, positions, strict=True):
        scene.add(grain(radius=radius, position=position, material=material))
    scene.add(lm.wall(point=0.0 * up, normal=up))
    law = lm.RollingCoulomb(friction=0.5, rolling_friction=rolling)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    solver = lm.GaussSeidel(tolerance=1e-4, max_iterations=2000) if flat else lm.Auto(tolerance=1e-4)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    weight = radii**dimension
    start = 2600.0 * (np.pi if flat else 4 / 3 * np.pi) * (weight * positions[:, -1]).sum() * G
    mass = weight / weight.sum()
    defect = 0.0
    while sim.time < duration:
        sim.step()
        defect = max(defect, abs(sim.energy.defect) / start)
    place = sim.positions[:grains]
    distance = np.linalg.norm(place[:, :-1] - np.median(place[:, :-1], axis=0), axis=1) @ mass
    height = place[:, -1] @ mass * (1 if flat else 2)
    speed = np.sqrt((sim.velocities[:grains] ** 2).sum(axis=1) @ mass)
    return float(np.degrees(np.arctan2(height, distance))), float(speed), sim.unconverged_steps, defect


def table(name: str, dimension: int, *, short: bool) -> None:
    """One dimension's table."""
    rows: list[list] = []
    long = {"grains": 200, "duration": 3.0 if dimension == 2 else 2.0}
    for rolling in ROLLING[::3] if short else ROLLING:
        given = {"grains": 60, "duration": 0.3 if dimension == 2 else 0.1} if short else long
        found = np.array([heap(rolling, seed, dimension=dimension, **given) for seed in range(SEEDS)])
        slope = found[:, 0]
        numbers = f"{slope.mean():.1f}", f"{slope.std(ddof=1):.1f}", f"{slope.min():.1f}", f"{slope.max():.1f}"
        rows.append([rolling, *numbers, f"{found[:, 1].max():.1g}", int(found[:, 2].sum()), f"{found[:, 3].max():.0e}"])
    header = ["mu_r", "slope [deg]", "deviation", "least", "most", "speed left [m/s]", "unsolved steps", "energy defect"]
    report(name, header, rows)


def sweep_cost(law: lm.Law, dimension: int, *, grains: int) -> tuple[int, float]:
    """Interactions of a box of grains, and what a sweep costs one of them [ns]."""
    side = 0.5 if dimension == 2 else 0.15
    radii = lm.sample.grading(grains, minimum=0.01, maximum=0.02, by="diameter", seed=0)
    positions = lm.sample.deposit(radii, box=(*[side] * (dimension - 1), None), seed=0)
    axes = np.eye(dimension)
    scene = lm.Scene(dimension=dimension, gravity=-G * axes[-1])
    material = lm.Material("sand", density=2600.0)
    for radius, position in zip(radii, positions, strict=True):
        scene.add((lm.disk if dimension == 2 else lm.sphere)(radius=radius, position=position, material=material))
    for axis in axes:
        scene.add(lm.wall(point=0.0 * axis, normal=axis))
    for axis in axes[:-1]:
        scene.add(lm.wall(point=side * axis, normal=-axis))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=200)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore").run(steps=100)
    reports = [sim.step() for _ in range(20)]
    return len(sim.interactions), 1e9 * min(r.seconds / r.iterations / r.interactions for r in reports)


def cost(*, short: bool) -> None:
    """The table of costs."""
    rows = []
    for dimension in (2, 3):
        for law in (lm.Coulomb(friction=0.5), lm.RollingCoulomb(friction=0.5, rolling_friction=0.1)):
            interactions, time = sweep_cost(law, dimension, grains=200 if short else 2000)
            rows.append([f"{dimension}D", law.NAME, interactions, f"{time:.0f}"])
    report(COST, ["dimension", "law", "interactions", "a sweep of one [ns]"], rows)


def main() -> None:
    short = "--short" in sys.argv
    chosen = {"plane", "space", "cost"} & set(sys.argv) or {"plane", "space", "cost"}
    if "plane" in chosen:
        table(PLANE, 2, short=short)
    if "space" in chosen:
        table(SPACE, 3, short=short)
    if "cost" in chosen:
        cost(short=short)


if __name__ == "__main__":
    main()
