"""The same thread in the same sand, once as beads and once as segments of one grain diameter: docs/threads.md.

A sample of TexSol in space is laid with a wire of beads, whose radius is a fifth of the smallest grain's. Smooth walls
press it with 100 kPa, without friction, then it is crushed along z by 6 % with friction. The thread has nodes at
every third bead, or at each of them, the same radius and, with the mass of its nodes, the same weight. Deviators and
tensions are means over the second half of the strain.

    python benchmarks/thread_in_sand.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import sys
import time
import warnings

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import characteristic_time, lay_sample_3d

PRESSURE, DENSITY, FRICTION, STRAIN, INERTIAL_NUMBER = 1e5, 2600.0, 0.4, 0.06, 2e-3
SPACING = 0.32
"""Distance of the beads in mean diameters of the grains."""
RIGIDITY = 120.0
"""EA of the wire [N]: 167 dtex of polyester."""


def run(grains: int, seed: int, every: int) -> list:
    """A row of the table; ``every``: how many beads there are to a node of the thread, 0 for a wire of beads."""
    smooth = every > 0
    laid = lay_sample_3d(grains, grains, seed=seed)
    beads = laid.wires[0]
    scene, sand = lm.Scene(dimension=3), lm.Material("sand", density=DENSITY)
    chosen = laid.positions[: beads : max(every, 1)]
    mass = laid.bead_mass * beads / len(chosen)
    if smooth:
        wire = [scene.add(lm.point_mass(position=x, mass=mass)) for x in chosen]
    else:
        radius = float(laid.radii[0])
        wire = [scene.add(lm.sphere(radius=radius, position=x, mass=mass, color="THREAD")) for x in chosen]
    law = lm.ElasticWire(axial_rigidity=RIGIDITY)
    surface = lm.Thread(float(laid.radii[0])) if smooth else None
    chain = scene.chain(wire, law, surface=surface, block_spin=not smooth)
    scene.add_spheres(laid.radii[beads:], laid.positions[beads:], material=sand)
    walls = {}
    for axis in range(3):
        for low in (True, False):
            normal = np.eye(3)[axis] * (1.0 if low else -1.0)
            point = np.eye(3)[axis] * (0.0 if low else laid.box[axis])
            given = {} if low else {"mass": 0.1 * DENSITY * float(np.prod(laid.box))}
            walls[axis, low] = scene.add(lm.wall(point=point, normal=normal, color="WALL", **given))

    def size() -> np.ndarray:
        return np.array([walls[axis, False].position[axis] - walls[axis, True].position[axis] for axis in range(3)])

    def load(axes: tuple[int, ...]) -> None:
        for axis in axes:
            force = -PRESSURE * float(np.prod(np.delete(size(), axis)))
            walls[axis, False].impose_force(**{"xyz"[axis]: force})

    for other in ("GRAIN", "THREAD"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.0))
    scene.see("THREAD", "THREAD", lm.Coulomb(friction=0.0))
    for other in ("GRAIN", "THREAD"):
        scene.see(other, "WALL", lm.Coulomb(friction=0.0))
    load((0, 1, 2))
    tick = characteristic_time(1e-3, DENSITY, PRESSURE)
    scene.drag(linear=0.3 * laid.bead_mass / tick)
    solver = lm.Auto(tolerance=3e-3)
    sim = lm.Simulation(scene, time_step=0.05 * tick, solver=solver, on_unconverged="ignore", overlap="ignore")
    for _ in range(30):  # the areas of the walls change
        sim.run(steps=20)
        load((0, 1, 2))
    for one, other in (("GRAIN", "GRAIN"), ("GRAIN", "THREAD"), ("THREAD", "THREAD")):
        scene.set_law(one, other, lm.Coulomb(friction=FRICTION))
    begin, height = size(), float(size()[2])
    walls[2, False].impose_velocity(z=-INERTIAL_NUMBER / tick * height)
    sweeps, steps, told, pulls = 0, 0, [], []
    seconds, unsolved = time.process_time(), sim.unconverged_steps
    while size()[2] > height * (1.0 - STRAIN):
        sim.step()
        load((0, 1))
        sweeps, steps = sweeps + sim.report.iterations, steps + 1
        if size()[2] < height * (1.0 - 0.5 * STRAIN):
            net, now = sim.interactions, size()
            on_top = (net.antagonist == walls[2, False].id) | (net.candidate == walls[2, False].id)
            told.append(float(net.force[on_top, 0].sum()) / (now[0] * now[1]) - PRESSURE)
            pulls.append(lm.measure.wire_links(sim).tension.mean())
    seconds = time.process_time() - seconds
    change = float(np.prod(size()) / np.prod(begin) - 1.0)
    what = "thread" if smooth else "beads"
    cost = len(wire), len(sim.interactions), f"{sweeps / steps:.0f}", f"{1e3 * seconds / steps:.1f}"
    found = f"{np.mean(told) / 1e3:.0f}", f"{np.mean(pulls):.4g}", f"{100.0 * change:.2f}"
    length = float(np.sum(chain.lengths())) / float(np.prod(size()))
    spacing, content = f"{SPACING * max(every, 1):.2f}", f"{length / 1e3:.0f}"
    return [what, spacing, seed, *cost, *found, content, sim.unconverged_steps - unsolved]


def main(seeds: int = 3, grains: int = 600) -> None:
    """All cases, one after the other."""
    rows = []
    for seed in range(seeds):
        for every in (0, 1, 3):
            rows.append(run(grains, seed, every))
            print(*rows[-1], file=sys.stderr, flush=True)
    header = ["wire", "spacing [d]", "seed", "bodies of the wire", "interactions", "sweeps a step", "processor [ms] a step"]
    header += ["deviator [kPa]", "mean tension [N]", "dilation [%]", "wire [km/m^3]", "unsolved"]
    report("thread_in_sand", header, rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # light bodies move fast now and then
    main(*map(int, sys.argv[1:]))
