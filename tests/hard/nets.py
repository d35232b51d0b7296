"""Hard cases of wires that carry: a net under balls, a chain over pegs."""

from __future__ import annotations

import math

import numpy as np
from case import Number, Result, Watch, worst_of
from taut import G, octaves, order

import lmgcpy as lm

MESH, CHAINS, BEAD, SLACK = 0.05, 4, 0.005, 1.02


def net(scene: lm.Scene, mass: float) -> list:
    """Four chains of one direction and four of the other, nodes shared, a bead between nodes; ends are fixed."""
    at = {}
    width = CHAINS + 1
    for i in range(2 * width + 1):
        for j in range(2 * width + 1):
            if (i % 2 == 0 or j % 2 == 0) and not (i in (0, 2 * width) and j in (0, 2 * width)):
                on_edge = i in (0, 2 * width) or j in (0, 2 * width)
                if on_edge and (i % 2 or j % 2):
                    continue
                position = (0.5 * MESH * (i - width), 0.5 * MESH * (j - width), 0.0)
                at[i, j] = scene.add(lm.sphere(radius=BEAD, position=position, mass=mass, color="NET"))
                if on_edge:
                    at[i, j].fix()
    law = lm.RigidWire()
    for k in range(1, width):
        for path in ([(i, 2 * k) for i in range(2 * width + 1)], [(2 * k, j) for j in range(2 * width + 1)]):
            scene.chain([at[p] for p in path], law, reference_gap=0.5 * SLACK * MESH - 2.0 * BEAD)
    return list(at.values())


def caught(load: float, h: float, duration: float, solver, **options):
    """A ball falls on the net. Returns watch, longest link's stretch, height of the ball's bottom at least and at the end."""
    radius = 0.06
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    net(scene, 1e-4)
    start = radius + BEAD + 0.05
    ball = scene.add(lm.sphere(radius=radius, position=(0.003, 0.001, start), mass=load, color="BALL"))
    scene.see("BALL", "NET", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim, lowest, stretch = watch.sim, 0.0, 0.0
    a, c = None, None
    for _ in range(round(duration / h)):
        watch.step()
        z = float(sim.positions[ball.id, 2]) - radius
        lowest = min(lowest, z)
        links = sim._links.count
        gaps = sim.interactions.gap[:links] if hasattr(sim.interactions, "gap") else None
        if gaps is not None:
            stretch = max(stretch, float((gaps + 2 * BEAD).max() / (0.5 * SLACK * MESH) - 1.0))
    return watch, stretch, lowest, z


def many(side: int, layers: int, h: float, duration: float, solver, **options):
    """Spheres fall on the net, layer by layer."""
    radius = 0.03
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    net(scene, 1e-4)
    rng = np.random.default_rng(1)
    for layer in range(layers):
        for i in range(side):
            for j in range(side):
                x, y = (2.05 * radius * (k - 0.5 * (side - 1)) for k in (i, j))
                z = BEAD + radius + 0.02 + 2.2 * radius * layer
                jitter = 0.02 * radius * rng.uniform(-1.0, 1.0, 3)
                scene.add(lm.sphere(radius=radius, position=np.array([x, y, z]) + jitter, mass=0.2, color="BALL"))
    law = lm.Coulomb(friction=0.3)
    scene.see("BALL", "NET", law)
    scene.see("BALL", "BALL", law)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    watch.run(round(duration / h))
    return watch


def pegs(load: float, h: float, duration: float, solver, **options):
    """120 beads fall on three pegs."""
    radius, spacing, mass, count, friction = 0.005, 0.0125, 1e-3, 120, 0.3
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    peg = 0.04
    for x in (-0.2, 0.0, 0.2):
        scene.add(lm.disk(radius=peg, position=(x, -peg - radius - 1e-3), mass=1.0, color="PEG")).fix()
    beads = []
    for i in range(count):
        end = i in (0, count - 1)
        position = (spacing * (i - 0.5 * (count - 1)), 0.0)
        beads.append(scene.add(lm.disk(radius=radius, position=position, mass=load if end else mass, color="BEAD")))
    scene.see("BEAD", "PEG", lm.Coulomb(friction=friction))
    scene.chain(beads, lm.RigidWire(), block_spin=True)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim = watch.sim
    steps = round(duration / h)
    peak, lift = 0.0, []
    for k in range(steps):
        watch.step()
        if k >= 0.9 * steps:
            f = sim.interactions.force
            peak = max(peak, float(-f[: count - 1, 0].min()))
            net_ = sim.interactions
            lift.append(float((net_.force[count - 1 :, 0] * np.abs(net_.normal[count - 1 :, 1])).sum()))
    weight = G * ((count - 2) * mass + 2 * load)
    return watch, peak / weight, np.array(lift) / weight
