"""The hard case of size: one step of a dense sample of spheres under pressure."""

from __future__ import annotations

from functools import cache

import numpy as np
from case import Number, Result, Watch

import lmgcpy as lm
from lmgcpy.dynamics.checkpoint import Checkpoint

DENSITY, PRESSURE = 2600.0, 1e5


def pressed(count: int, friction: float, steps: int, seed: int = 0) -> lm.Simulation:
    """A deposit of spheres between six walls, one of which presses, after so many steps of compaction.

    The time step is a fifth of d sqrt(rho/p), the time in which the pressure moves a grain by its size.
    """
    radii = lm.sample.grading(count, minimum=0.004, maximum=0.005, by="diameter", seed=seed)
    volume = float((4.0 / 3.0 * np.pi * radii**3).sum())
    side = (volume / 0.58) ** (1.0 / 3.0)
    places = lm.sample.deposit(radii, box=(side, side, None), seed=seed)
    top = float((places[:, 2] + radii).max())
    scene = lm.Scene(dimension=3)
    material = lm.Material("sand", density=DENSITY)
    for radius, place in zip(radii, places, strict=True):
        scene.add(lm.sphere(radius=radius, position=place, material=material))
    for point, normal in (
        ((0, 0, 0), (0, 0, 1)),
        ((0, 0, 0), (1, 0, 0)),
        ((0, 0, 0), (0, 1, 0)),
        ((side, 0, 0), (-1, 0, 0)),
        ((0, side, 0), (0, -1, 0)),
    ):
        scene.add(lm.wall(point=point, normal=normal))
    lid = scene.add(lm.wall(point=(0, 0, top), normal=(0, 0, -1), mass=0.1 * DENSITY * volume))
    lid.impose_force(z=-PRESSURE * side**2)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    step = 0.2 * 0.009 * (DENSITY / PRESSURE) ** 0.5
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=1000)
    return lm.Simulation(scene, time_step=step, solver=solver, on_unconverged="ignore").run(steps=steps)


@cache
def sample(count: int, friction: float) -> tuple[lm.Simulation, Checkpoint]:
    """Made once for all solvers."""
    sim = pressed(count, friction, 40)
    return sim, sim.checkpoint()


def last_step(count: int, friction: float, solver) -> Result:
    """One more step of a sample, with the solver, from the impulses of the step before."""
    sim, start = sample(count, friction)
    sim.restore(start)
    sim.solver = solver
    watch = Watch(sim)
    impulses = watch.step().interactions.impulse
    return watch.result(Number("residual", lm.residual(sim.problem(), impulses), 1e-8))


def smooth(solver, long: bool) -> Result:
    """A step of the compaction of 10 000 smooth spheres in a box, under the pressure of a lid.

    Hard: forty thousand contacts, jammed, and the lid's force comes down through all of them; sweeps take off what is
    short in the sample and leave what is long. Number: the residual, computed from the assembled problem in numpy, to
    1e-8.
    """
    return last_step(10_000, 0.0, solver)


def rough(solver, long: bool) -> Result:
    """The same with 150 spheres and a friction of 0.3.

    Hard: friction is not associated, so that neither a convex problem nor a symmetric operator is at hand, and many
    contacts are on the edge between sticking and sliding. Number: as :func:`smooth`.
    """
    return last_step(150, 0.3, solver)
