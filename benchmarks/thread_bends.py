"""A thread that is drawn over a drum and over a corner, by the distance of its nodes: docs/threads.md.

Ratio of the tensions before and behind half a turn around a fixed drum of radius R, friction 0.3, thread of radius 0.08 R,
drawn at 0.01 R a step, over that of a thick thread; and over a sharp corner of 45 and 90 degrees by the radius r of the
thread, drawn at 0.02 r a step, over Euler's for a thin one. Means, least and greatest values of steps over which three
distances of nodes are drawn, after one.

    python benchmarks/thread_bends.py
"""

from __future__ import annotations

import math
import warnings

import numpy as np
from table import report

import lmgcpy as lm

FRICTION, STEP = 0.3, 1e-3
DRAWN = 3
"""Distances of nodes that are measured; one before them is not."""


def laid(angle: float, radius: float, distance: float) -> np.ndarray:
    """Nodes of a thread whose axis turns by an angle on a circle, symmetric, straight before and behind."""
    count = math.ceil(0.5 * angle * radius / distance) + DRAWN + 3
    along = distance * np.arange(-count, count + 1)
    turned = np.clip(along / radius, -0.5 * angle, 0.5 * angle)
    past = along - turned * radius
    # on a polygon around the circle no segment cuts into it
    out = radius / math.cos(min(0.5 * distance / radius, 0.45 * angle))
    return np.column_stack([out * np.sin(turned) + past * np.cos(turned), out * np.cos(turned) - past * np.sin(turned)])


def ratios(scene: lm.Scene, places: np.ndarray, angle: float, radius: float, speed: float) -> np.ndarray:
    """Tension behind the bend over the load, step by step."""
    nodes = [scene.add(lm.point_mass(position=tuple(place), mass=1e-7)) for place in places]
    scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=radius))
    before, behind = (np.array([side * math.cos(0.5 * angle), -math.sin(0.5 * angle)]) for side in (-1.0, 1.0))
    nodes[0].impose_force(x=before[0], y=before[1])
    nodes[-1].impose_velocity(x=speed * behind[0], y=speed * behind[1])
    sim = lm.Simulation(scene, time_step=STEP)
    distance = np.linalg.norm(places[1] - places[0])
    steps = [round(k * distance / (speed * STEP)) for k in (1, 1 + DRAWN)]
    sim.run(steps=steps[0])
    found = []
    for _ in range(*steps):
        sim.step()
        found.append(lm.measure.wire_links(sim).tension[-1])
    return np.array(found)


def drum(distance: float) -> list:
    """A row: nodes so many radii of the drum apart."""
    size, radius, angle = 0.01, 0.0008, math.pi
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=size, position=(0.0, 0.0), mass=1.0)).fix()
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=FRICTION))
    found = ratios(scene, laid(angle, size + radius, distance * size), angle, radius, 0.01 * size / STEP)
    share = radius / (size + radius)
    # of a thick thread: k (1 + share mu k) = (1 - share) mu, docs/threads.md
    k = (math.sqrt(1.0 + 4.0 * share * FRICTION * (1.0 - share) * FRICTION) - 1.0) / (2.0 * share * FRICTION)
    return row("drum, 180 degrees", f"{distance:g} R", found, math.exp(k * angle))


def corner(degrees: float, distance: float) -> list:
    """A row: nodes so many radii of the thread apart."""
    radius, angle = 0.001, math.radians(degrees)
    ends = [(side * 0.3 * math.cos(0.5 * angle), -0.3 * math.sin(0.5 * angle)) for side in (-1.0, 1.0)]
    scene = lm.Scene(dimension=2)
    scene.add(lm.wall_segment(ends[0], (0.0, 0.0), ends[1]))
    scene.see("WALL", "THREAD", lm.Coulomb(friction=FRICTION))
    found = ratios(scene, laid(angle, radius, distance * radius), angle, radius, 0.02 * radius / STEP)
    return row(f"corner, {degrees:g} degrees", f"{distance:g} r", found, math.exp(FRICTION * angle))


def row(bend: str, distance: str, found: np.ndarray, euler: float) -> list:
    return [bend, distance, f"{euler:.3f}", *(f"{value / euler:.3f}" for value in (found.mean(), found.min(), found.max()))]


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # nodes are laid a little off the bend, and pulled onto it in the first step
    rows = [drum(distance) for distance in (0.2, 0.5, 1.0, 1.4, 2.0)]
    rows += [corner(degrees, distance) for degrees in (45.0, 90.0) for distance in (2.5, 5.0, 10.0)]
    report("thread_bends", ["bend", "distance of nodes", "expected", "mean ratio over it", "least", "greatest"], rows)
