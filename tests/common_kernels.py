"""Kernels that tests of many files need, compiled once and by all workers of pytest-xdist together.

Each job is taken by one worker. No test is imported before all are done: two workers that compile the same kernels at
the same time are no faster than one. Where the cache has the kernels it takes a second or two.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import lmgcpy as lm

PATIENCE = 600.0
"""How long a worker waits for the others [s]; after it, it compiles what it needs by itself."""
SOLVERS = lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Auto


def two_steps(scene: lm.Scene, **options) -> lm.Simulation:
    return lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore", overlap="ignore", **options).run(steps=2)


def contacts(dimension: int) -> None:
    """Grains on a floor, with friction and without, by every solver."""
    up = np.eye(dimension)[-1]
    for friction, solver in [(0.3, solver) for solver in SOLVERS] + [(0.0, lm.GaussSeidel)]:
        scene = lm.Scene(dimension=dimension, gravity=-9.81 * up)
        grain = lm.disk if dimension == 2 else lm.sphere
        for k in range(3):
            scene.add(grain(radius=0.1, position=(0.1 + 0.2 * k) * up, mass=1.0))
        scene.add(lm.wall(point=0.0 * up, normal=up))
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
        two_steps(scene, solver=solver(tolerance=1e-12))


def wires(dimension: int) -> None:
    """A wire, a rod and an elastic wire, each as a block."""
    grain = lm.disk if dimension == 2 else lm.sphere
    for law in (lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e3)):
        scene = lm.Scene(dimension=dimension, gravity=-9.81 * np.eye(dimension)[-1])
        beads = [scene.add(grain(radius=0.1, position=0.3 * k * np.eye(dimension)[0], mass=1.0)) for k in range(4)]
        beads[0].fix()
        scene.chain(beads, law)
        two_steps(scene, solver=lm.GaussSeidel())


def sample_in_the_plane() -> None:
    lm.sample.deposit([0.1] * 20, box=(1.0, None), seed=0)


def sample_in_space() -> None:
    lm.sample.deposit([0.1] * 20, box=(1.0, 1.0, None), seed=0)


JOBS: tuple[Callable[[], None], ...] = (
    lambda: contacts(2),
    sample_in_space,
    sample_in_the_plane,
    lambda: wires(2),
    lambda: contacts(3),
    lambda: wires(3),
)
"""The first has the drivers of the solvers, which all others but the samples need as well."""


def compile_together(folder: Path) -> None:
    """Take jobs until none is left, then wait for those that others have taken; ``folder``: of this run of tests."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, job in enumerate(JOBS):
        try:
            (folder / f"taken-{number}").touch(exist_ok=False)
        except FileExistsError:
            continue
        try:
            job()
        finally:
            (folder / f"done-{number}").touch()
    begin = time.monotonic()
    while len(list(folder.glob("done-*"))) < len(JOBS) and time.monotonic() - begin < PATIENCE:
        time.sleep(0.2)
