"""What a wire costs and how exact it is: one step of a hanging chain, by length and by the mass at its tip.

Exact is every tension equal to the weight below. The time is that of one visit of the wire block (the whole solve of a
chain in a sweep), from a cold start. For comparison: the links visited one at a time, as usual, for the same time.

    python benchmarks/wire_solve.py
"""

from __future__ import annotations

import time

import numpy as np
from table import report

import lmgcpy as lm

RUNS = 9


def hanging(count: int, tip: float, solver: lm.GaussSeidel) -> tuple[lm.Simulation, np.ndarray]:
    """A chain of ``count`` links from a fixed bead, and the weight below each link [N]."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    mass, spacing = 1e-3, 0.01
    masses = np.full(count + 1, mass)
    masses[-1] *= tip
    beads = [scene.add(lm.disk(radius=0.25 * spacing, position=(0.0, -spacing * i), mass=m)) for i, m in enumerate(masses)]
    beads[0].fix()
    scene.chain(beads, lm.RigidWire())
    below = 9.81 * np.cumsum(masses[::-1])[::-1][1:]
    return lm.Simulation(scene, time_step=1e-3, solver=solver), below


def measure(count: int, tip: float) -> list:
    seconds = []
    for _ in range(RUNS):
        sim, below = hanging(count, tip, lm.GaussSeidel(tolerance=1e-6, max_iterations=1))
        sim.step()
        seconds.append(sim.report.seconds)
    error = float(np.abs(-sim.interactions.force[:, 0] / below - 1.0).max())
    block = float(np.median(seconds))
    one_by_one, below = hanging(count, tip, lm.GaussSeidel(tolerance=1e-15, max_iterations=2000, wire_blocks=False))
    one_by_one.step()
    swept = one_by_one.report
    usual = float(np.abs(-one_by_one.interactions.force[:, 0] / below - 1.0).max())
    return [
        count,
        f"{tip:g}",
        f"{error:.1e}",
        f"{1e3 * block:.3f}",
        f"{1e9 * block / count:.0f}",
        f"{usual:.1e}",
        f"{1e3 * swept.seconds:.1f}",
    ]


if __name__ == "__main__":
    begin = time.perf_counter()
    hanging(3, 1.0, lm.GaussSeidel())[0].step()
    hanging(3, 1.0, lm.GaussSeidel(wire_blocks=False))[0].step()
    print(f"compiled or loaded in {time.perf_counter() - begin:.1f} s")
    header = ["links", "tip mass / bead", "error of tension", "block [ms]", "per link [ns]"]
    header += ["error, 2000 sweeps of links", "their [ms]"]
    rows = [measure(count, tip) for tip in (1.0, 1e6) for count in (10, 100, 1000, 10_000)]
    report("wire_solve", header, rows)
