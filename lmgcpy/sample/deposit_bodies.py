"""Deposits of clumps, capsules and spheres in a box: a simulation lets them fall and come to rest."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import named_arguments, shown, whole
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.sample import arguments
from lmgcpy.sample.grid import grid_positions
from lmgcpy.sample.settle import GRAVITY, come_to_rest
from lmgcpy.scene.body import Body, RigidBody, wall
from lmgcpy.scene.body_3d import Sphere
from lmgcpy.scene.placed import placed
from lmgcpy.scene.scene import Scene
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

DAMPING = 1.0
"""Rate of the drag on the bodies, over the rate ``sqrt(2 g / height)`` of a fall from the loose grid: no body falls faster
than half of what it would reach without, and what has no friction comes to rest by it."""


@named_arguments
def deposit_bodies(
    bodies: Sequence[Body], *, box: Any, friction: float = 0.3, seed: Any = 0, max_steps: int = 20_000
) -> list[Body]:
    """Twins of clumps, capsules and spheres, at rest in a box after a fall under gravity, in the order of ``bodies``.

    The bodies are laid on a loose grid by the spheres around them, in rotations uniform on SO(3), and fall onto the floor
    through a medium with drag, with ``friction`` between all, until their speeds are below a hundredth of that after a fall
    by the finest radius. The less friction, the denser is the deposit. Where the bodies given stand does not matter; those
    returned are new, keep colour and mass, and are in no scene: ``for body in deposit: scene.add(body)``. The steps are
    such that a fall takes some six heights of the loose grid over the finest radius.

    ``box``: three lengths [m], from the origin; the last, the height, may be None, an open top. ``seed`` as for
    ``numpy.random.default_rng``. Raises RuntimeError if the bodies are not at rest after ``max_steps``; ValueError if they
    rest above the top of the box, do not fit beside each other, or an argument makes no sense.

    >>> import lmgcpy as lm
    >>> peanut = lm.clump([0.01, 0.01], [(0, 0, 0), (0.01, 0, 0)], density=2650)
    >>> laid = lm.sample.deposit_bodies([peanut.at((0, 0, 0))] * 3, box=(0.05, 0.05, None))
    >>> all(0.0099 < body.position[2] < 0.016 for body in laid)
    True
    """
    if not isinstance(bodies, (list, tuple)) or not bodies:
        raise TypeError(f"bodies of a deposit must be a list of clumps, capsules and spheres, got {shown(bodies)}.")
    for body in bodies:
        if not isinstance(body, (RigidBody, Sphere)) or body.dimension != 3:
            raise TypeError(f"bodies of a deposit must be clumps, capsules and spheres in 3D, got {shown(body)}.")
    lengths = arguments.box(box, dimensions=(3,))
    max_steps = whole(max_steps, "max_steps", minimum=1)
    rng = arguments.generator(seed)
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    extents = np.array([body.extent for body in bodies])
    finest = min(getattr(shape, "radius", extents.min()) for body in bodies for shape, _ in body.contactors)
    loose = grid_positions(extents, box=(*lengths[:2], None), seed=rng)
    turns = Rotation.random(len(bodies), rng)
    scene = Scene(dimension=3, gravity=(0.0, 0.0, -GRAVITY))
    law = Coulomb(friction=friction)
    for body, place, turn in zip(bodies, loose, turns, strict=True):
        scene.add(placed(body, place, turn)).color = "GRAIN"
    for axis in range(3):
        normal = np.eye(3)[axis]
        scene.add(wall(point=(0.0, 0.0, 0.0), normal=normal))
        if axis < 2:
            scene.add(wall(point=lengths[axis] * normal, normal=-normal))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    height = float((loose[:, 2] + extents).max())
    speed = float(np.sqrt(2.0 * GRAVITY * height))
    scene.drag(scene.bodies[: len(bodies)], rate=DAMPING * speed / height)
    sim = Stepper(
        scene,
        time_step=0.5 * finest / speed,  # a fall moves by a quarter of the finest radius, and what turns a little more
        solver=AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=2000),
        on_unconverged="ignore",
    )
    come_to_rest(sim, len(bodies), finest, max_steps, "allow more by max_steps, or give more friction")
    laid = [placed(body, body.position.copy()) for body in scene.bodies[: len(bodies)]]
    top = max(_top(body) for body in laid)
    if top > lengths[-1]:
        raise ValueError(
            f"The bodies rest up to {top:g} m, above the top of the box at {lengths[-1]:g} m: take fewer, or a higher box."
        )
    for body, given in zip(laid, bodies, strict=True):
        body.color = given.color
    return laid


def _top(body: Body) -> float:
    """Height of the highest point of a body of spheres and rods, whose ends are spheres [m]."""
    offsets = np.array([offset for _, offset in body.contactors])
    at = body.position[2] + (body.rotation.apply(offsets)[:, 2] if body.turns else offsets[:, 2])
    return float(max(z + getattr(shape, "radius", 0.0) for z, (shape, _) in zip(at, body.contactors, strict=True)))
