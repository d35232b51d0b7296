"""Deposits in a box: grains laid by geometry around obstacles, and grains, clumps and capsules that fall under gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import named_arguments, one_of, shown, whole
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.sample import arguments
from lmgcpy.sample.deposit_2d import deposit_2d
from lmgcpy.sample.deposit_3d import deposit_3d
from lmgcpy.sample.loose import grid_positions
from lmgcpy.scene.body import Body, RigidBody, wall
from lmgcpy.scene.body_3d import Sphere, placed
from lmgcpy.scene.scene import Scene
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

METHODS = ("geometric", "grid")
ORDERS = ("random", "given")
GRAVITY = 9.81
STILL = 0.01
"""Largest speed of a deposit at rest, as part of the speed after a fall by the finest radius."""
LOOK_EVERY = 20
"""Number of steps after which the speeds are looked at."""
DAMPING = 1.0
"""Rate of the drag on the bodies, over the rate ``sqrt(2 g / height)`` of a fall from the loose grid: no body falls faster
than half of what it would reach without, and what has no friction comes to rest by it."""


@named_arguments
def deposit(
    radii: Any,
    *,
    box: Any,
    obstacles: Any = None,
    method: str = "geometric",
    order: str = "random",
    seed: Any = 0,
) -> np.ndarray:
    """Positions [m], shape (n, d), of a deposit of grains with the given ``radii`` [m], in the order of ``radii``.

    ``method="geometric"``
        Grains are placed one after the other, each at the lowest position where it rests without friction on two
        supports, in 3D on three. Supports are grains placed before, obstacles, the floor and the walls. Nothing overlaps
        by more than 1e-10 of the finest radius. A grain needs no path by which it could have fallen to its position:
        overhangs are filled, and fine grains find the holes left below. A wide grading (ratio 10) therefore holds more
        of its fine grains at the bottom; with ratios up to about 3 in 2D, and 2 in 3D, no such trend is seen. The method
        follows Taboada's pre-processor.
        Measured for 1700 grains, diameters uniform by number with ratio 2, in a box of 0.67 m: solid fraction 0.827
        (0.825 to 0.829 over 20 seeds) one coarsest diameter away from walls, floor and top, in 20 ms; 0.786, beads
        included, around a wire of 300 beads, where a void is left below each bead that hangs over.
        For 10 000 spheres in a box as high as wide, in the same kind of window: 0.612 with ratio 1.2 (0.612 to 0.613
        over 5 seeds), 0.640 with ratio 2, 0.663 with ratio 5, each in a second; 100 000 take 4 to 10 s. Equal spheres
        begin as a crystal on the floor, some five layers high, and come to 0.606.
    ``method="grid"``
        Grains are laid on a loose grid. In 2D a simulation lets them fall under gravity: this is slow, but ends in
        mechanical equilibrium. In 3D the loose grid itself is returned, for a simulation to start from; see
        :func:`lmgcpy.sample.grid_positions`.

    ``box``: lengths [m] of a box that starts at the origin; the last may be ``None``, an open top. ``obstacles``: pair
    (positions, radii) [m] of spheres that hang in space, such as the beads of a wire. ``order`` of insertion is "random",
    from the ``seed``, or as "given".

    The function raises ValueError if the grains do not fit, and says how many did; ValueError or TypeError if an argument
    makes no sense.
    """
    method = one_of(method, "method", METHODS)
    order = one_of(order, "order", ORDERS)
    sizes = arguments.radii(radii)
    lengths = arguments.box(box)
    centres, obstacle_radii = arguments.obstacles(obstacles, len(lengths))
    arguments.refuse_unfit(lengths, float(sizes.max()), "the coarsest grain")
    rng = arguments.generator(seed)
    if method == "grid":
        around = (centres, obstacle_radii)
        if len(lengths) == 3:
            return grid_positions(sizes, box=box, obstacles=around, order=order, seed=rng)
        loose = grid_positions(sizes, box=(*box[:-1], None), obstacles=around, order=order, seed=rng)
        return settle(loose, sizes, box=box, obstacles=around)
    sequence = rng.permutation(len(sizes)) if order == "random" else np.arange(len(sizes))
    *base, height = lengths
    if len(lengths) == 2:
        positions, placed = deposit_2d(sizes, sequence, base[0], height, centres, obstacle_radii)
    else:
        positions, placed = deposit_3d(sizes, sequence, base[0], base[1], height, centres, obstacle_radii)
    if placed == len(sizes):
        return positions
    if math.isinf(height):
        raise RuntimeError(
            f"grain {placed + 1} of {len(sizes)} found no pocket though the box is open: this is an error of lmgcpy. "
            "Another seed may help; please report it."
        )
    raise ValueError(
        f"the box is full: {placed} of {len(sizes)} grains fitted under its height of {height:g} m. Take fewer grains, "
        "a higher box, or None for an open top."
    )


def _come_to_rest(scene: Scene, time_step: float, count: int, finest: float, max_steps: int, remedy: str) -> Stepper:
    """Make steps until the first ``count`` bodies are slow against a fall by the ``finest`` radius [m].

    RuntimeError with the ``remedy`` if that takes more than ``max_steps``.
    """
    solver = AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=2000)
    sim = Stepper(scene, time_step=time_step, solver=solver, on_unconverged="ignore")
    still = STILL * float(np.sqrt(2.0 * GRAVITY * finest))
    while True:
        for _ in range(LOOK_EVERY):
            sim.step()
        # A grain at the top of its flight is slow as well, but gravity makes it faster than this by the next look.
        if float(np.abs(sim.velocities[:count]).max()) < still:
            return sim
        if sim.steps >= max_steps:
            raise RuntimeError(
                f"The grains have not come to rest after {sim.steps} steps ({sim.time:g} s): {remedy}."
            )


def _refuse_above(top: float, height: float, bodies: str) -> None:
    """ValueError if bodies at rest reach above the top of their box [m]."""
    if top > height:
        raise ValueError(
            f"The {bodies} rest up to {top:g} m, above the top of the box at {height:g} m: take fewer, or a higher box."
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
    remedy = "allow more by max_steps, or take method='geometric'"
    settled = _come_to_rest(scene, step, len(radii), finest, max_steps, remedy).positions[: len(radii)].copy()
    _refuse_above(float((settled[:, 1] + radii).max()), lengths[-1], "grains")
    return settled


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
    step = 0.5 * finest / speed  # a fall moves by a quarter of the finest radius, and what turns a little more
    _come_to_rest(scene, step, len(bodies), finest, max_steps, "allow more by max_steps, or give more friction")
    laid = [placed(body, body.position.copy()) for body in scene.bodies[: len(bodies)]]
    _refuse_above(max(_top(body) for body in laid), lengths[-1], "bodies")
    for body, given in zip(laid, bodies, strict=True):
        body.color = given.color
    return laid


def _top(body: Body) -> float:
    """Height of the highest point of a body of spheres and rods, whose ends are spheres [m]."""
    offsets = np.array([offset for _, offset in body.contactors])
    at = body.position[2] + (body.rotation.apply(offsets)[:, 2] if body.turns else offsets[:, 2])
    return float(max(z + getattr(shape, "radius", 0.0) for z, (shape, _) in zip(at, body.contactors, strict=True)))
