"""What it takes to build a scene of many grains: one body after another, in one call, and to compile it into arrays.

Processor time, the least of three in turn. The error is the largest difference of a mass, an inertia or a position between
the two scenes.

python benchmarks/authoring.py
"""

from __future__ import annotations

import time

import numpy as np
from table import report

import lmgcpy as lm

COUNTS = (1_000, 10_000, 100_000)
TURNS = 3
SAND = lm.Material("sand", density=2600.0)


def laid(dimension: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Radii and positions of grains on a lattice, seed 0."""
    radii = np.random.default_rng(0).uniform(0.005, 0.01, count)
    side = int(np.ceil(count ** (1.0 / dimension)))
    return radii, 0.02 * np.stack(np.unravel_index(np.arange(count), (side,) * dimension), axis=1)


def one_by_one(dimension: int, radii: np.ndarray, positions: np.ndarray) -> lm.Scene:
    scene, make = lm.Scene(dimension=dimension), lm.disk if dimension == 2 else lm.sphere
    for radius, position in zip(radii, positions, strict=True):
        scene.add(make(radius=radius, position=position, material=SAND))
    return scene


def at_once(dimension: int, radii: np.ndarray, positions: np.ndarray) -> lm.Scene:
    scene = lm.Scene(dimension=dimension)
    (scene.add_disks if dimension == 2 else scene.add_spheres)(radii, positions, material=SAND)
    return scene


def timed(call, *arguments):
    begin = time.process_time()
    result = call(*arguments)
    return result, time.process_time() - begin


def main() -> None:
    rows = []
    for dimension in (2, 3):
        for count in COUNTS:
            given = dimension, *laid(dimension, count)
            seconds = []
            for _ in range(TURNS):
                (slow, alone), (scene, together) = timed(one_by_one, *given), timed(at_once, *given)
                model, compiled = timed(scene.compile)
                seconds.append((alone, together, compiled))
            other = slow.compile()
            pairs = (model.mass, other.mass), (model.start.positions, other.start.positions)
            error = max(float(abs(one - two).max()) for one, two in pairs)
            rows.append([f"{dimension}D", count, *(f"{least:.3f}" for least in np.min(seconds, axis=0)), f"{error:.0e}"])
    report(
        "authoring", ["", "grains", "scene.add [s]", "in one call [s]", "compile [s] (goal, both: 0.5)", "difference"], rows
    )


if __name__ == "__main__":
    main()
