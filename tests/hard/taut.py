"""Hard cases of taut wires: jerked, drawn over drums and pegs, woven to nets."""

from __future__ import annotations

import math

import numpy as np
from case import Number, Result, Watch, worst_of

import lmgcpy as lm

G = 9.81


def order(steps, errors) -> float:
    """Slope of errors over steps, both logarithmic; a straight line fitted to all of them."""
    return float(np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0])


def octaves(first: float, count: int) -> list[float]:
    """So many steps, each half of the one before."""
    return [first / 2**k for k in range(count)]


# ------------------------------------------------------------------------------------------------- a jerked wire


def jerked(load: float, h: float, duration: float, solver, **options) -> tuple[Watch, float, float]:
    """Twenty links of 10.1 mm over 0.2 m, beads of 1 g, and a load in the middle; what was seen, and how long and how
    deep it was at most [m]."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(21):
        scene.add(lm.disk(radius=0.002, position=(0.01 * i, 0.0), mass=load if i == 10 else 1e-3))
    scene.bodies[0].fix()
    scene.bodies[-1].fix()
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.0101 - 0.004)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    longest = deepest = 0.0
    for _ in range(round(duration / h)):
        x = watch.step().positions
        longest = max(longest, float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum()))
        deepest = max(deepest, -float(x[10, 1]))
    return watch, longest, deepest


# -------------------------------------------------------------------------------------------- wires over drums


class Pulley:
    """A wire of beads over half a turn of a fixed drum, blocks at its ends; 14 links hang on both sides.

    Beads of 1 cm radius and 2.05 cm apart on a drum of 10 cm; their spin is blocked. ``ratio`` and ``acceleration``:
    mean ratio of the end tensions, and mean acceleration of the first block downward, over the last half of the run.
    """

    def __init__(self, first: float, second: float, friction: float, bead: float, h: float, duration: float, solver, **options):
        drum, radius, spacing, side = 0.1, 0.01, 0.0205, 14
        rim = drum + radius
        scene = lm.Scene(dimension=2, gravity=(0.0, -G))
        scene.add(lm.disk(radius=drum, position=(0.0, 0.0), mass=1.0, color="DRUM")).fix()
        turn = 2.0 * math.asin(0.5 * spacing / rim)
        links = math.floor(math.pi / turn)
        start = 0.5 * (math.pi - links * turn)
        angle = start + turn * np.arange(links + 1)
        on = rim * np.column_stack([np.cos(angle), np.sin(angle)])
        down = np.column_stack([np.zeros(side), -spacing * np.arange(1, side + 1)])
        path = np.concatenate([(on[0] + down)[::-1], on, on[-1] + down])
        last = len(path) - 1
        beads = []
        for i, position in enumerate(path):
            mass, color = {0: (first, "END"), last: (second, "END")}.get(i, (bead, "BEAD"))
            beads.append(scene.add(lm.disk(radius=radius, position=position, mass=mass, color=color)))
        scene.see("BEAD", "DRUM", lm.Coulomb(friction=friction))
        scene.chain(beads, lm.RigidWire(), block_spin=True)
        self.watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
        self.turn = turn
        sim, steps = self.watch.sim, max(4, round(duration / h))
        ratios, half = [], 0.0
        for k in range(steps):
            if k == steps // 2:
                half, begin = float(sim.velocities[1, 1]), sim.time
            self.watch.step()
            if k >= steps // 2:
                tension = -sim.interactions.force[:last, 0]
                ratios.append(tension[0] / tension[-1] if tension[-1] > 0.0 else math.inf)
        self.ratio = float(np.mean(ratios))
        self.acceleration = (half - float(sim.velocities[1, 1])) / (sim.time - begin)
