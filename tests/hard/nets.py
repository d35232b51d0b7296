"""Hard cases of nets: under one ball, and under many."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from case import Number, Result, Watch, worst_of
from taut import G, coarse, octaves, only

import lmgcpy as lm

MESH, CHAINS, BEAD, SLACK = 0.05, 4, 0.005, 1.02
"""Distance of the nodes [m], chains of each direction, radius of the beads [m], length over distance."""


def net(scene: lm.Scene) -> None:
    """Four chains of one direction and four of the other, of beads of 0.1 g; nodes are shared, with a bead between two of
    them, and ends are fixed."""
    last = 2 * (CHAINS + 1)
    rows = range(2, last, 2)
    paths = [[(i, row) for i in range(last + 1)] for row in rows] + [[(row, j) for j in range(last + 1)] for row in rows]
    beads = {}
    for i, j in sorted({place for path in paths for place in path}):
        position = (0.5 * MESH * i - 0.25 * MESH * last, 0.5 * MESH * j - 0.25 * MESH * last, 0.0)
        beads[i, j] = scene.add(lm.sphere(radius=BEAD, position=position, mass=1e-4, color="NET"))
        if {i, j} & {0, last}:
            beads[i, j].fix()
    for path in paths:
        scene.chain([beads[place] for place in path], lm.RigidWire(), reference_gap=0.5 * SLACK * MESH - 2.0 * BEAD)


def ball_on_net(solver, long: bool, **options: Any) -> Result:
    """A ball of 0.1 g, 1 kg and 100 kg falls 5 cm on a net of eight wires, nodes shared; friction 0.3.

    Hard: nodes of four links, beads of 0.1 g under a ball of up to 1e6 times that, and a jerk of all wires at once.
    Numbers: no node hangs lower than the middle of its two wires, of 0.255 m over 0.25 m, allows, 25 mm; the ball, of 6
    cm, sinks between four nodes, 35 mm from the middle of their mesh, by another 10 mm less the beads' radius: 30 mm in
    all, and what the wires stretch as a step's slack is used up at v = 1.2 m/s, h v. At one height it loses half of its
    speed: to h v it is the height at the finest step. (The lowest height of the run is no such number: a jerk leaves up to
    0.2 v, up or down, 4 mm in the rest of the run.) A net gives nothing back, so that a ball heavier than its beads is
    caught: pulling back the stretch of a jerk with velocities would throw it back at half of its speed of 1.25 m/s, and
    errors of the jerk leave up to 0.3 of it, and, sideways too, 0.15 of its energy. Wires make at most a hundredth of
    their energy in a step (see ``taut.dropped``) and give no more than they took; friction of beads that the jerk pressed
    into the ball, and that are pushed out again, at most a tenth. Two solvers: swept, it takes a minute and steps stay
    unsolved.
    """
    results = []
    for load in (1e-4, 1.0, 100.0):
        heights, steps = [], octaves(4e-3, 6 if long else 4)
        for h in steps:
            watch, low, caught_at, up = caught(load, h, 0.15, solver, **options)
            heights.append(caught_at)
            left = float((watch.sim.velocities[-1] ** 2).sum()) / 1.25**2
            back = [Number("thrown back", up / 1.25, 0.3), Number("kept", left, 0.15)] if load > 1e-4 else []
            results.append(
                watch.result(
                    Number("depth [30 mm + h v]", -low / (0.0304 + 1.2 * h), 1.0),
                    Number("energy made", watch.energy, 0.03),
                    Number("gained", watch.gained, 0.1),
                    *back,
                )
            )
        if load > 1e-4:
            away = [abs(z - heights[-1]) / (1.2 * h) for z, h in zip(heights[:-1], steps[:-1], strict=True)]
            results.append(only(Number("from the finest [h v]", max(away), 1.0)))
    return worst_of(results)


def caught(load: float, h: float, duration: float, solver, **options: Any) -> tuple[Watch, float, float, float]:
    """The run as watched; of the ball's lowest point, the lowest height and the height at which it first lost half of its
    speed of 1.25 m/s [m]; and the ball's fastest speed upwards [m/s]."""
    radius = 0.06
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    net(scene)
    position = (0.003, 0.001, radius + BEAD + 0.05)
    ball = scene.add(lm.sphere(radius=radius, position=position, mass=load, color="BALL"))
    scene.see("BALL", "NET", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    lowest, caught_at, fastest, fell = math.inf, math.nan, 0.0, False
    with coarse():
        for _ in range(round(duration / h)):
            lowest = min(lowest, float(watch.step().positions[ball.id, 2]) - radius)
            speed = float(ball.velocity[2])
            fastest, fell = max(fastest, speed), fell or speed < -1.0
            if fell and speed > -0.625 and math.isnan(caught_at):
                caught_at = float(ball.position[2]) - radius
    return watch, lowest, caught_at, fastest


def spheres_on_net(solver, long: bool, **options: Any) -> Result:
    """Two layers of sixteen spheres of 0.2 kg fall on the net; friction 0.3 among them and with the net.

    Hard: contacts of many on nodes of light beads, where a wire that zigzags throws spheres and contacts take what it
    makes. Numbers: wires and contacts each only take energy, 1e-2 of what gravity turns over; interactions together make
    none, 1e-2. Solved to 1e-4, as beds are. Two solvers: as above. Long: three layers, 0.4 s and four octaves.
    """
    results = []
    for h in octaves(2e-3, 4 if long else 1):
        watch = poured(3 if long else 2, h, 0.4 if long else 0.12, solver, **options)
        results.append(watch.result(Number("energy made", watch.energy, 1e-2), Number("gained", watch.gained, 1e-2)))
    return worst_of(results)


def poured(layers: int, h: float, duration: float, solver, **options: Any) -> Watch:
    """Layers of sixteen spheres, seed 1."""
    radius, side = 0.03, 4
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    net(scene)
    rng = np.random.default_rng(1)
    for layer in range(layers):
        for i in range(side):
            for j in range(side):
                x, y = (2.05 * radius * (k - 0.5 * (side - 1)) for k in (i, j))
                z = BEAD + radius + 0.02 + 2.2 * radius * layer
                position = np.array([x, y, z]) + 0.02 * radius * rng.uniform(-1.0, 1.0, 3)
                scene.add(lm.sphere(radius=radius, position=position, mass=0.2, color="BALL"))
    scene.see("BALL", "NET", lm.Coulomb(friction=0.3))
    scene.see("BALL", "BALL", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    with coarse():
        watch.run(round(duration / h))
    return watch
