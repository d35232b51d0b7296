"""Smooth threads beside wires of beads: what a contact costs, and what a thread of long segments gives for it.

The first table times the sweep of one group of contacts at a time, all of which change their impulses: balls on balls,
balls on segments and balls on triangles, the same number of each, in nanoseconds a contact; medians of many calls.

The second table draws a straight thread through pairs of grains that press it, as beads and as a thread whose segments are
as long as a grain: bodies of the wire, sweeps and processor time a step, and the force that draws it over the one that
friction gives.

    python benchmarks/thread_surfaces.py [contacts]
"""

from __future__ import annotations

import sys
import time

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.solve.kernels.forms.form import called

REPEATS = 400
FRICTION = 0.3


def one_of_each(count: int) -> lm.Simulation:
    """As many balls on balls, on segments, and on triangles, far from each other, falling onto each other."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=3, gravity=(0, 0, -10.0))
    of_kind: dict[str, list] = {"SEGMENT": [], "TRIANGLE": []}
    for k in range(count):
        for row, kind in enumerate(("BALL", "SEGMENT", "TRIANGLE")):
            at = np.array([k % 100, 20.0 * row, k // 100]) * 1.0
            above = at + np.array([0.0, 0.0, 0.19])
            scene.add(lm.sphere(radius=0.1, position=above, mass=1.0, color=f"ON_{kind}", velocity=(1, 2, -3)))
            if kind == "BALL":
                scene.add(lm.sphere(radius=0.1, position=at, mass=1.0, color=kind))
                continue
            corners = 2 if kind == "SEGMENT" else 3
            angle = rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.arange(corners) / corners
            for x, y in 0.3 * np.column_stack([np.cos(angle), np.sin(angle)]):
                of_kind[kind].append(scene.add(lm.point_mass(position=at + np.array([x, y, 0.09]), mass=1.0)))
    elastic = lm.ElasticWire(stiffness=1.0)
    edges = np.arange(2 * count).reshape(-1, 2)
    scene.net(of_kind["SEGMENT"], edges, elastic, surface=lm.Thread(0.01, color="SEGMENT"))
    scene.membrane(of_kind["TRIANGLE"], np.arange(3 * count).reshape(-1, 3), elastic, radius=0.01, color="TRIANGLE")
    for kind in ("BALL", "SEGMENT", "TRIANGLE"):
        scene.see(f"ON_{kind}", kind, lm.Coulomb(friction=FRICTION))
    return lm.Simulation(scene, time_step=1e-4, solver=lm.Auto(tolerance=1e-4), overlap="ignore")


def costs(count: int) -> list[list]:
    sim = one_of_each(count)
    sim.step()
    problem = sim.last_step[0]
    system, rows = problem.system, {}
    velocities = system.velocity.copy()
    groups = [
        (group, kernels.sweep.address, offset)
        for group, kernels, offset in zip(problem.by_law, problem.kernels, problem.offset, strict=True)
        if group.chain is None and group.stop - group.start >= count // 2
    ]
    seconds: list[list[float]] = [[] for _ in groups]
    for _ in range(REPEATS):  # one after the other, so that all meet the same machine
        for (group, address, offset), taken in zip(groups, seconds, strict=True):
            system.impulse[group.start : group.stop] = 0.0
            system.velocity[:] = velocities
            system.velocity[:, 2] -= 1.0  # every contact gets an impulse
            begin = time.perf_counter()
            called(address, group.start, group.stop, offset, system)
            taken.append(time.perf_counter() - begin)
    for (group, _, _), taken in zip(groups, seconds, strict=True):
        contacts = group.stop - group.start
        rows[group.kinds.candidate, group.kinds.antagonist] = contacts, 1e9 * np.median(taken) / contacts
    first = next(iter(rows.values()))[1]
    return [[f"{c} on {a}", n, f"{t:.1f}", f"{t / first:.2f}"] for (c, a), (n, t) in rows.items()]


def draw(spacing: float, smooth: bool, friction: float) -> list:
    """A wire of radius 0.2 mm through 20 pairs of grains of 2 mm, drawn by 2 mm; ``spacing`` of its bodies [m]."""
    rng, radius, grain, force, pairs = np.random.default_rng(0), 2e-4, 1e-3, 1.0, 20
    length = (pairs + 8) * 2.0 * grain
    scene = lm.Scene(dimension=3)
    places = np.zeros((round(length / spacing) + 1, 3))
    places[:, 0] = spacing * np.arange(len(places))
    mass = 1.7e-5 * spacing  # 167 dtex
    if smooth:
        nodes = [scene.add(lm.point_mass(position=p, mass=mass)) for p in places]
    else:
        nodes = [scene.add(lm.sphere(radius=radius, position=p, mass=mass, color="THREAD")) for p in places]
    scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius) if smooth else None)
    for x in 2.0 * grain * (np.arange(3, pairs + 3) + rng.uniform(-0.3, 0.3, pairs)):
        for side in (1.0, -1.0):
            ball = scene.add(lm.sphere(radius=grain, position=(x, 0.0, side * (grain + radius)), mass=1e-5))
            ball.fix("x", "y", "spin_x", "spin_y", "spin_z").impose_force(z=-side * force)
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=friction))
    for node in nodes:
        node.fix("y")
    nodes[0].impose_force(x=-0.05 * force)
    nodes[-1].impose_velocity(x=0.02, z=0.0)
    options = {"solver": lm.Auto(tolerance=1e-4), "on_unconverged": "ignore", "overlap": "ignore"}
    sim = lm.Simulation(scene, time_step=2.5e-4, **options)
    sim.run(steps=40)
    begin, sweeps, tension = time.process_time(), 0, []
    for _ in range(400):
        sim.step()
        sweeps += sim.report.iterations
        tension.append(-sim.interactions.force[sim.interactions.law == "rigid-wire", 0][-1])
    seconds = time.process_time() - begin
    apparent = (np.array(tension) - 0.05 * force) / (2.0 * pairs * force)
    what = "thread" if smooth else "beads"
    found = f"{apparent.mean():.4f}", f"{apparent.std():.4f}", sim.unconverged_steps
    return [what, f"{spacing * 1e3:g}", len(nodes), friction, *found, f"{sweeps / 400:.0f}", f"{1e3 * seconds / 400:.2f}"]


if __name__ == "__main__":
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 400
    report("thread_contacts", ["contact", "contacts", "ns a contact and sweep", "over balls (goal 2)"], costs(number))
    header = ["wire", "spacing [mm]", "bodies of the wire", "friction", "apparent friction", "its scatter"]
    header += ["unsolved of 440", "sweeps a step", "processor [ms] a step"]
    cases = [(4e-4, False), (8e-4, False), (5e-4, True), (1e-3, True), (2e-3, True)]
    report("thread_drawn", header, [draw(*case, friction) for friction in (0.0, 0.2) for case in cases])
