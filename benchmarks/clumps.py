"""What bodies that turn in space cost: a contact of clumps beside one of spheres, and clumps that settle beside spheres.

The first table sweeps the same spheres in the same places twice, as spheres and as clumps of one ball each, which have the
general form of contacts: levers anywhere, full local blocks. After the same number of sweeps both must have the same
velocities; they may differ by a part of ``h g``, which a step gives without contacts. Times are those of the processor, of
whole steps, medians of alternating steps, a contact and sweep.

The second table lets clumps of four balls settle in a box, and as many spheres as there are balls.

    python benchmarks/clumps.py [clumps that settle]
"""

from __future__ import annotations

import sys
import time

import numpy as np
from scipy.spatial.transform import Rotation
from table import report

import lmgcpy as lm

SWEEPS = 200
STEPS = 9
RADIUS = 0.01
MOST_SWEEPS = 200
"""20 000 spheres would take more to a residual of 1e-2, which is relative to what gravity does to all."""


def box(scene: lm.Scene, low: np.ndarray, high: np.ndarray, law: lm.Law, *, lid: bool) -> None:
    for axis in range(3):
        normal = np.eye(3)[axis]
        scene.add(lm.wall(point=low, normal=normal))
        if lid or axis < 2:
            scene.add(lm.wall(point=high, normal=-normal))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)


def lattice(side: int, friction: float, clumps: bool) -> lm.Simulation:
    """Spheres on a cubic lattice that overlap by some per cent of a radius, in a box that presses them."""
    rng = np.random.default_rng(0)
    spacing = 1.99 * RADIUS
    places = spacing * np.array(list(np.ndindex(side, side, side))) + rng.normal(scale=2e-3 * RADIUS, size=(side**3, 3))
    scene = lm.Scene(dimension=3, gravity=(1.0, 2.0, -9.81))
    if clumps:
        scene.add_clumps(lm.clump([RADIUS], [(0, 0, 0)], density=2000.0), places)
    else:
        scene.add_spheres(RADIUS, places, material=lm.Material("stone", 2000.0))
    high = spacing * (side - 1) + 0.99 * RADIUS
    box(scene, np.full(3, -0.99 * RADIUS), np.full(3, high), lm.Coulomb(friction=friction), lid=True)
    solver = lm.GaussSeidel(tolerance=1e-15, max_iterations=SWEEPS)
    return lm.Simulation(scene, time_step=1e-4, solver=solver, on_unconverged="ignore", overlap="ignore").run(steps=2)


def contacts(side: int, friction: float) -> list:
    sims = [lattice(side, friction, clumps) for clumps in (False, True)]
    seconds = np.zeros((STEPS, 2))
    for step in range(STEPS):
        for k, sim in enumerate(sims):
            begin = time.process_time()
            sim.step()
            seconds[step, k] = (time.process_time() - begin) / (sim.report.iterations * sim.report.interactions)
    off = float(np.abs(sims[0].velocities - sims[1].velocities).max() / (1e-4 * 9.81))
    each, ratio = 1e9 * np.median(seconds, axis=0), float(np.median(seconds[:, 1] / seconds[:, 0]))
    return [side**3, friction, sims[0].report.interactions, f"{off:.0e}", *(f"{t:.1f}" for t in each), f"{ratio:.2f}"]


def settle(count: int, clumps: bool) -> list:
    """Grains that fall from a loose lattice into a box, for half a second, with at most ``MOST_SWEEPS`` sweeps a step."""
    rng, per_clump = np.random.default_rng(1), 4
    corners = 0.6 * RADIUS * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
    shape = lm.clump([RADIUS] * per_clump, corners, density=2000.0)
    number, size = (count, shape.extent) if clumps else (count * per_clump, RADIUS)
    side = int(np.ceil((number / 2.0) ** (1.0 / 3.0)))
    places = 2.1 * size * (np.array(list(np.ndindex(side, side, 2 * side + 2)))[:number] + 0.5)
    scene = lm.Scene(dimension=3, gravity=(0, 0, -9.81))
    if clumps:
        scene.add_clumps(shape, places, rotations=Rotation.random(number, rng))
    else:
        places += rng.uniform(-0.04 * size, 0.04 * size, places.shape)  # on the lattice itself they would stand in columns
        scene.add_spheres(RADIUS, places, material=lm.Material("stone", 2000.0))
    box(scene, np.zeros(3), np.full(3, 2.1 * size * side), lm.Coulomb(friction=0.5), lid=False)
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=MOST_SWEEPS)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    begin, sweeps, updates = time.process_time(), 0, 0
    for _ in range(500):
        sim.step()
        sweeps += sim.report.iterations
        updates += sim.report.iterations * sim.report.interactions
    seconds = time.process_time() - begin
    per_grain = sim.energy.kinetic / (number * 9.81 * RADIUS * scene.bodies[0].mass)
    what = f"{number} clumps of {per_clump}" if clumps else f"{number} spheres"
    overlap = -float(sim.interactions.gap.min()) / RADIUS
    found = sim.report.interactions, sweeps // 500, sim.unconverged_steps, f"{overlap:.0e}", f"{per_grain:.1e}"
    return [what, *found, f"{seconds:.0f}", f"{1e9 * seconds / max(updates, 1):.0f}"]


if __name__ == "__main__":
    header = ["spheres", "friction", "contacts", "velocities differ by [h g]"]
    header += ["spheres [ns]", "clumps [ns]", "ratio (goal 1.6)"]
    report("clumps", header, [contacts(side, friction) for side in (10, 20) for friction in (0.0, 0.3)])
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 250
    header = ["what settles", "contacts", "sweeps a step", "unsolved of 500", "deepest overlap [r]", "kinetic / (m g r)"]
    header += ["processor [s]", "ns a contact and sweep"]
    report("clumps_settling", header, [settle(number, clumps) for clumps in (True, False)])
