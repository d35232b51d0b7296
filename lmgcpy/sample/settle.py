"""The paper's slow way to a deposit: time steps let loose grains fall under gravity."""

from __future__ import annotations

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import named_arguments, whole
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.sample import arguments
from lmgcpy.scene.body import wall
from lmgcpy.scene.scene import Scene
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

GRAVITY = 9.81
STILL = 0.01
"""Largest speed of a deposit at rest, as part of the speed after a fall by the finest radius."""
LOOK_EVERY = 20
"""Number of steps after which the speeds are looked at."""


def come_to_rest(sim: Stepper, count: int, finest: float, max_steps: int, remedy: str) -> None:
    """Make steps until the first ``count`` bodies are slow against a fall by the ``finest`` radius [m].

    RuntimeError with the ``remedy`` if that takes more than ``max_steps``.
    """
    still = STILL * float(np.sqrt(2.0 * GRAVITY * finest))
    while True:
        for _ in range(LOOK_EVERY):
            sim.step()
        # A grain at the top of its flight is slow as well, but gravity makes it faster than this by the next look.
        if float(np.abs(sim.velocities[:count]).max()) < still:
            return
        if sim.steps >= max_steps:
            raise RuntimeError(
                f"The grains have not come to rest after {sim.steps} steps ({sim.time:g} s): {remedy}."
            )


@named_arguments
def settle(
    positions: np.ndarray,
    radii: np.ndarray,
    *,
    box: tuple,
    obstacles: tuple[np.ndarray, np.ndarray],
    friction: float = 0.0,
    max_steps: int = 20_000,
) -> np.ndarray:
    """Let loose disks fall into a box, around fixed obstacles, until they rest; positions [m], (n, 2).

    The time step is such that a grain that has fallen through the whole sample moves by half the finest radius in one
    step. The function raises RuntimeError if the grains have not come to rest after ``max_steps``, and ValueError if they
    rest above the top of the box or an argument makes no sense.
    """
    lengths = arguments.box(box)
    if len(lengths) != 2:
        raise NotImplementedError("Deposits by simulation are built in 2D only so far: give a box of two lengths.")
    positions, radii = arguments.spheres(positions, arguments.radii(radii), 2, "the grains")
    obstacles = arguments.obstacles(obstacles, 2)
    max_steps = whole(max_steps, "max_steps", minimum=1)
    finest = float(radii.min())
    scene = Scene(dimension=2, gravity=(0.0, -GRAVITY))
    scene.add_disks(radii, positions, masses=np.pi * radii**2)
    for obstacle in scene.add_disks(obstacles[1], obstacles[0], masses=1.0, color="OBSTACLE"):
        obstacle.fix()
    scene.add(wall(point=(0.0, 0.0), normal=(0, 1)))
    scene.add(wall(point=(0.0, 0.0), normal=(1, 0)))
    scene.add(wall(point=(lengths[0], 0.0), normal=(-1, 0)))
    law = Coulomb(friction=friction)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    if len(obstacles[1]):
        scene.see("GRAIN", "OBSTACLE", law)
    height = max(finest, float((positions[:, 1] + radii).max()))
    step = 0.5 * finest / float(np.sqrt(2.0 * GRAVITY * height))
    solver = AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=2000)
    sim = Stepper(scene, time_step=step, solver=solver, on_unconverged="ignore")
    count = len(radii)
    come_to_rest(sim, count, finest, max_steps, "allow more by max_steps, or take method='geometric'")
    settled = sim.positions[:count].copy()
    top = float((settled[:, 1] + radii).max())
    if top > lengths[-1]:
        raise ValueError(
            f"The grains rest up to {top:g} m, above the top of the box at {lengths[-1]:g} m: take fewer, or a higher box."
        )
    return settled
