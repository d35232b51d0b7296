"""Hard cases of wires in free motion: dropped on elastic wires, falling folded, cracking, spinning."""

from __future__ import annotations

import math

import numpy as np
from case import Number, Result, Watch, worst_of
from taut import G, octaves, order

import lmgcpy as lm


# -------------------------------------------------------------------------------------------------------- bungee


def bungee(rigidity: float, mass: float, links: int, h: float, solver, **options) -> tuple[Watch, float, float]:
    """``mass`` falls 0.5 m beside a wire of 1 m, folded zigzag, and stretches it; what was seen, the deepest it went and
    the depth by energy [m]."""
    length, bead, slack = 1.0, 1e-5, 0.5
    l = length / links
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    across = math.sqrt(1.0 - slack**2) * l
    for i in range(links + 1):
        position = (across * (i % 2), -slack * l * i)
        scene.add(lm.disk(radius=0.1 * l, position=position, mass=mass if i == links else bead))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=rigidity / l), reference_gap=0.8 * l)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim, fall = watch.sim, (1.0 - slack) * length
    k = rigidity / length
    e = mass * G / k + math.sqrt((mass * G / k) ** 2 + 2.0 * fall * mass * G / k)
    deepest = 0.0
    end = math.sqrt(2.0 * fall / G) + 4.0 * math.sqrt(mass / k) + 10.0 * h
    while sim.time < end:
        y = -float(watch.step().positions[-1, 1])
        deepest = max(deepest, y)
    return watch, deepest, length + e


# ---------------------------------------------------------------------------------------------------- folded chain


def folded(law, links: int, h: float, solver, **options):
    """A chain of 1 m hung by both ends side by side; one is let go. Fall of the tip [m] and its speed at every step."""
    length, gap, mass = 1.0, 0.02, 1.0
    l = length / links
    half = (links - 1) // 2
    x = np.concatenate([np.zeros(half + 1), np.full(half + 1, l)])
    y = np.concatenate([-l * np.arange(half + 1), -l * np.arange(half, -1, -1)])
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(len(x)):
        scene.add(lm.disk(radius=0.1 * l, position=(x[i], y[i]), mass=mass / len(x)))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, law)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    times, falls = [0.0], [0.0]
    while falls[-1] < 0.9 * length and watch.sim.time < 0.6:
        watch.step()
        times.append(watch.sim.time)
        falls.append(-float(watch.sim.positions[-1, 1]))
    return watch, np.array(times), np.array(falls)


# ------------------------------------------------------------------------------------------------------ crack


def crack(taper: float, links: int, h: float, solver, **options):
    """A whip of 1 m lies folded, its heavy arm at rest and fixed at the handle, and its other arm flies at 1 m/s."""
    length = 1.0
    l = length / links
    half = (links - 1) // 2
    count = 2 * half + 2
    x = np.concatenate([l * np.arange(half + 1), l * np.arange(half, -1, -1)])
    y = np.concatenate([np.zeros(half + 1), np.full(half + 1, l)])
    mass = np.geomspace(1.0, 1.0 / taper, count) * 1e-3
    scene = lm.Scene(dimension=2)
    for i in range(count):
        velocity = (1.0, 0.0) if i > half else (0.0, 0.0)
        scene.add(lm.disk(radius=0.1 * l, position=(x[i], y[i]), mass=mass[i], velocity=velocity))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidWire())
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    energy = watch.sim.energy.kinetic
    xs, vs = [], []
    while watch.sim.time < 1.2:
        watch.step()
        xs.append(float(watch.sim.positions[-1, 0]))
        vs.append(float(np.linalg.norm(watch.sim.velocities[-1, :2])))
    return watch, np.array(xs), np.array(vs), math.sqrt(2 * energy / mass[-1]), mass


# --------------------------------------------------------------------------------------------------- spinning


def spinning(end: float, h: float, steps: int, solver, **options):
    """Two bodies on a wire of nine beads of 0.1 g turn about each other at 10 rad/s; worst change of the angular momentum."""
    omega, length = 10.0, 0.02
    scene = lm.Scene(dimension=2)
    for i in range(11):
        x = length * (i - 5)
        mass = end if i in (0, 10) else 1e-4
        scene.add(lm.disk(radius=0.004, position=(x, 0.0), mass=mass, velocity=(0.0, omega * x)))
    scene.chain(scene.bodies, lm.RigidWire())
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim = watch.sim
    m = sim.model.mass[:, 0]

    def momentum():
        x, v = sim.positions, sim.velocities
        return float(m @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]))

    start = momentum()
    worst = []
    for _ in range(steps):
        watch.step()
        worst.append(abs(momentum() / start - 1.0))
    return watch, np.array(worst)
