"""What geometric stiffness costs: one sweep over a taut wire, with and without it, in 2D and 3D, and whole steps.

Both sweeps are one visit of the wire block in the third step of a taut wire of light beads, from that step's solution with
velocities disturbed by a tenth, as contacts do it between two visits. Both take one Newton step; that with the term finds
its matrix eliminated by the visit before, as in all sweeps of a solve but the first. Steps: the same wire, as a user makes
them; without the term it zigzags by then, and takes more Newton steps a visit.

    python benchmarks/geometric_stiffness.py
"""

from __future__ import annotations

import time

import numpy as np
from contact_update import sweep_by_law
from table import report

import lmgcpy as lm
from lmgcpy.dynamics.step_problem import StepProblem

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


def per_link(problem: StepProblem) -> float:
    """One visit of the block, from the solution with disturbed velocities [s a link]."""
    s = problem.system
    impulse, velocity = s.impulse.copy(), s.velocity.copy()
    velocity[1:-1, :3] += 0.1 * np.sin(np.arange(3 * (LINKS - 1))).reshape(-1, 3)
    total = 0.0
    for _ in range(VISITS):
        s.impulse[:], s.velocity[:] = impulse, velocity
        begin = time.process_time()  # other processes would show on a clock on the wall
        sweep_by_law(problem.groups, s, 1)
        total += time.process_time() - begin
    assert np.abs(s.impulse - impulse).max() > 0.0
    s.impulse[:] = impulse
    return total / (VISITS * LINKS)


def without_it(problem: StepProblem) -> StepProblem:
    """The same step with the normal rows alone."""
    return problem.on(problem.system, stiffened=False)


def compare(dimension: int) -> list:
    seconds = []
    for stiffness in (False, True):
        sim = wire(dimension, stiffness).run(steps=3)
        begin = time.process_time()
        sim.run(steps=STEPS)
        seconds.append((time.process_time() - begin) / STEPS)
    having = wire(dimension, True).run(steps=3)._last[0]
    assert len(having.system.geometric), "it is not on"
    without = without_it(having)
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
