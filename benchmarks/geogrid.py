"""Pull-out of a geogrid from sand, force against displacement: docs/threads.md.

Grains of 1 mm lie below and above a geogrid in a box, and are compacted without friction by pressures from below and
above. Then the front edge of the grid, outside the box, is drawn at constant speed, with friction of grains among each
other and on the grid. The grid passes through the front wall, which holds the grains. The figure is the force of the front
edge over twice the pressure times the area of the grid in the box: the friction of a sheet in its place. Grains in the
meshes bear on the cross bars, so that it may be more than the friction of the bars; a smooth grid shows how much more.

    python benchmarks/geogrid.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import sys
import time
import warnings

import numpy as np
from fibres import words
from table import report

import lmgcpy as lm
from lmgcpy.experiment import characteristic_time

PRESSURE, DENSITY, FRICTION, D = 1e5, 2600.0, 0.4, 1e-3
LENGTH, WIDTH = 12.0, 6.0
"""Of the box along and across the pull, in mean diameters."""
BAR, MESH = 0.15, 3.0
"""Radius of the bars and width of the meshes, in mean diameters."""
INERTIA = 2e-3
"""Of the pull: ``speed sqrt(rho/p)`` over the length of the box."""
WINDOWS = ((0.0, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 3.0))
"""Of the displacement in mean diameters, over which the force is averaged."""


def buried(grains: int, seed: int, friction: float):
    """Grains around a grid at rest under the lid: the simulation, the nodes of the grid, and its front edge (a mask)."""
    rng = np.random.default_rng(seed)
    radii = 0.5 * D * rng.uniform(0.8, 1.2, grains)
    length, width, bar = LENGTH * D, WIDTH * D, BAR * D
    half = 4.0 / 3.0 * np.pi * float((radii**3).sum()) / 0.15 / (2.0 * length * width)
    scene, sand = lm.Scene(dimension=3), lm.Material("sand", density=DENSITY)
    box = np.array([length, width, half]) - 2.0 * radii.max()
    for k in (0, 1):
        places = lm.sample.scatter(radii[k::2], cell=box, seed=seed + 1000 * k) + radii.max()
        places[:, 2] += bar if k else -half - bar
        scene.add_spheres(radii[k::2], places, material=sand)
    made = lm.sample.net(size=(LENGTH * D + MESH * D, WIDTH * D), mesh=MESH * D, nodes=3)
    mass = 1000.0 * np.pi * bar**2 * MESH * D / 3.0
    nodes = [scene.add(lm.point_mass(position=x, mass=mass)) for x in made.positions]
    law = lm.ElasticRod(axial_rigidity=200.0 * PRESSURE * D**2)
    scene.net(nodes, made.cells, law, surface=lm.Thread(bar, color="GRID"))
    for axis, far in ((0, length), (1, width)):
        normal = np.eye(3)[axis]
        scene.add(lm.wall(point=np.zeros(3), normal=normal))
        scene.add(lm.wall(point=far * normal, normal=-normal))
    mass = DENSITY * D**3 * grains / 10.0
    for side in (-1.0, 1.0):  # both press, so that the grid stays where it is
        lid = scene.add(lm.wall(point=(0.0, 0.0, side * (half + bar)), normal=(0.0, 0.0, -side), mass=mass))
        lid.fix("x", "y").impose_force(z=-side * PRESSURE * length * width)
    for one, other in (("GRAIN", "GRAIN"), ("GRAIN", "GRID"), ("GRAIN", "WALL")):
        scene.see(one, other, lm.Coulomb(friction=0.0))
    tick = characteristic_time(D, DENSITY, PRESSURE)
    scene.drag(linear=2.0 / tick * 0.02 * DENSITY * D**3)
    front = made.positions[:, 0] > length + 0.5 * MESH * D
    for node, held in zip(nodes, front, strict=True):
        node.fix(*("xyz" if held else "y"))
    solver = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=3000)
    sim = lm.Simulation(scene, time_step=0.1 * tick, solver=solver)
    sim.run(steps=1500)
    scene.set_law("GRAIN", "GRAIN", lm.Coulomb(friction=FRICTION))
    scene.set_law("GRAIN", "GRID", lm.Coulomb(friction=friction))
    return sim, nodes, front


def pulled(grains: int, seed: int, friction: float) -> list[float]:
    """Means of the force over the windows, unsolved steps, processor time [s]."""
    begin = time.process_time()
    sim, nodes, front = buried(grains, seed, friction)
    speed = INERTIA * LENGTH * D / characteristic_time(D, DENSITY, PRESSURE)
    before, start = sim.unconverged_steps, sim.time
    for k in np.flatnonzero(front).tolist():
        nodes[k].impose_velocity(x=speed)
    rows, told = np.array([node.id for node in nodes]), []
    while (drawn := speed * (sim.time - start)) < WINDOWS[-1][1] * D:
        sim.step()
        net, inside = sim.interactions, LENGTH * D - max(0.0, float(sim.positions[rows, 0].min()))
        along = np.einsum("mk,mk->m", net.force, net.frame[:, :, 0])
        pull = along[np.isin(net.antagonist, rows[front])].sum() - along[np.isin(net.candidate, rows[front])].sum()
        told.append((drawn / D, float(pull) / (2.0 * PRESSURE * inside * WIDTH * D)))
    way, force = np.array(told).T
    means = [float(force[(way >= low) & (way < high)].mean()) for low, high in WINDOWS]
    return [*means, sim.unconverged_steps - before, time.process_time() - begin]


def main(seeds: int = 5, grains: int = 400) -> None:
    """Grids as rough as the grains, and smooth ones."""
    runs = [[f, seed, *pulled(grains, seed, f)] for f in (FRICTION, 0.0) for seed in range(seeds)]
    ways = [f"drawn by {low:g} to {high:g} d" for low, high in WINDOWS]
    told = [[*run[:2], *(f"{value:.3f}" for value in run[2:-2]), run[-2], f"{run[-1]:.0f}"] for run in runs]
    report("geogrid_runs", ["friction on the grid", "seed", *ways, "unsolved steps", "processor [s]"], told)
    rows = []
    for f in (FRICTION, 0.0):
        numbers = np.array([run[2:-2] for run in runs if run[0] == f]).T
        rows.append([f, seeds, *(words(values, ".2f") for values in numbers)])
    report("geogrid", ["friction on the grid", "samples", *ways], rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # light bars between grains move fast now and then
    main(*map(int, sys.argv[1:]))
