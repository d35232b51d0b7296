"""What geometric stiffness costs: one sweep over a taut wire, with and without it, in 2D and 3D, and whole steps.

Both sweeps start from the same impulses, those of a solved step of a taut wire of light beads that has begun to swing; each
is one visit of the wire block. Steps: the same wire, one thousand of them, as a user makes them.

    python benchmarks/geometric_stiffness.py
"""

from __future__ import annotations

import time

import numpy as np
from contact_update import sweep_by_law
from table import report

import lmgcpy as lm

LINKS = 1000
VISITS = 40
RUNS = 15
STEPS = 300


def wire(dimension: int, stiffness: bool) -> lm.Simulation:
    """A wire of beads of 1 g under 1 kN, bent and thrown across; seed 0."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    for i in range(LINKS + 1):
        at = (0.02 * i, 1e-3 * np.sin(0.01 * i), 0.0)[:dimension]
        speed = rng.normal(0.0, 0.1, dimension)
        scene.add(make(radius=0.005, position=at, mass=1e-3, velocity=speed))
    scene.bodies[0].fix()
    scene.bodies[-1].impose_force(x=1e3)
    scene.chain(scene.bodies, lm.RigidWire())
    solver = lm.GaussSeidel(tolerance=1e-8)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, geometric_stiffness=stiffness, on_unconverged="ignore")


def per_link(sim: lm.Simulation) -> float:
    """One visit of the block, from a disturbed solution [s a link]."""
    problem = sim._last[0]
    s = problem.system
    impulse, velocity = s.impulse.copy(), s.velocity.copy()
    total = 0.0
    for _ in range(VISITS):
        s.impulse[:], s.velocity[:] = impulse, velocity
        s.velocity[1:-1, 0] += 1e-3 * np.sin(np.arange(LINKS - 1))
        begin = time.perf_counter()
        sweep_by_law(problem.table, s, 1)
        total += time.perf_counter() - begin
    return total / (VISITS * LINKS)


def compare(dimension: int) -> list:
    without, having = wire(dimension, False), wire(dimension, True)
    seconds = []
    for sim in (without, having):
        sim.run(steps=3)
        per_link(sim)
        begin = time.process_time()
        sim.run(steps=STEPS)
        seconds.append((time.process_time() - begin) / STEPS)
    assert having.interactions.impulse[:, 1:].any(), "it is not on"
    with np.errstate(over="ignore", invalid="ignore"):
        without = wire(dimension, False).run(steps=3)
    times = np.array([[per_link(without), per_link(having)] for _ in range(RUNS)])
    off, on = np.median(times, axis=0)
    ratio = float(np.median(times[:, 1] / times[:, 0]))
    return [
        f"{dimension}D",
        LINKS,
        *(f"{1e9 * t:.0f}" for t in (off, on)),
        f"{ratio:.2f}",
        *(f"{1e3 * t:.2f}" for t in seconds),
        f"{seconds[1] / seconds[0]:.2f}",
    ]


if __name__ == "__main__":
    header = ["", "links", "sweep without [ns a link]", "with [ns a link]", "with / without (goal 2)"]
    header += ["step without [ms]", "with [ms]", "with / without"]
    report("geometric_stiffness", header, [compare(2), compare(3)])
