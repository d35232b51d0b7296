"""Small scenes that compile every kernel, so that no later run waits for the compiler."""

from __future__ import annotations

import itertools
import math
import pickle
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

import lmgcpy as lm
from lmgcpy.compiled.ahead import ahead
from lmgcpy.compiled.cache import CacheWarning
from lmgcpy.compiled.kernel import Statistics, statistics
from lmgcpy.compiled.meanwhile import meanwhile
from lmgcpy.contact.slabs import partition_from
from lmgcpy.experiment.texsol.sample import lay_sample
from lmgcpy.laws import Law, Parameter, registry
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.proximal import proximal_newton
from lmgcpy.solve.solvers import SOLVERS

REACH = 1.0
"""Alert distance [m] at which every pair in the scenes is an interaction."""


class Part(NamedTuple):
    """A part of the kernels, which one process compiles at a time."""

    dimension: int
    law: str | None
    """Name of a law, or None for samples, neighbour lists and Newton steps, which all laws share."""


class Made(NamedTuple):
    """The result of compiling a part."""

    part: Part
    failure: Exception | None
    statistics: Statistics
    """Origins of the kernels of the process, for this part and the parts before it."""


def warm_up(
    laws: list[type[Law]], dimensions: list[int], tick: Callable[[int], None], workers: int = 1
) -> tuple[dict[str, Exception], list[Statistics]]:
    """Compile or load every kernel that scenes with these laws need; returns the laws that failed, with the cause, and
    where the kernels come from, for each part.

    ``tick`` is called with the number of parts that are done. ``workers`` processes share the parts; laws that a script has
    registered, which other processes do not know, are compiled in this one. Raises CacheWarning if the cache cannot keep a
    kernel.
    """
    # dimensions in turn: two workers begin with what only one of them needs
    parts = [Part(d, law.NAME) for law in laws for d in dimensions] + [Part(d, None) for d in dimensions]
    script = {name for name, one in registry.registrations().items() if one.distribution == "script"}
    made: list[Made] = []

    def enter(one: Made) -> None:
        made.append(one)
        tick(len(made))

    here = [part for part in parts if workers == 1 or part.law in script]
    elsewhere = [part for part in parts if part not in here]
    if elsewhere:
        with ProcessPoolExecutor(min(workers, len(elsewhere)), get_context("spawn")) as pool:
            try:
                for future in as_completed([pool.submit(make, part) for part in elsewhere]):
                    enter(future.result())
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    for part in here:
        enter(make(part))
    failures = {str(one.part.law): one.failure for one in made if one.failure is not None}
    return failures, [one.statistics for one in made]


def make(part: Part) -> Made:
    """Compile or load the kernels of a part; raises CacheWarning, and what goes wrong with what all laws share."""
    failure = None
    ahead.is_over = True  # the workers share all processors
    meanwhile.stop()
    if _no_cache:  # said once, but parts may wait in the queue of this process
        raise _no_cache[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error", CacheWarning)
        try:
            if part.law is None:
                shared_kernels(part.dimension)
            else:
                kernels_of_law(registry.get(part.law), part.dimension)
        except CacheWarning as warning:
            _no_cache.append(warning)
            raise
        except Exception as error:  # the law of a plug-in may fail; the other laws are still compiled
            if part.law is None:
                raise
            failure = error if workers_can_say(error) else RuntimeError(f"{type(error).__name__}: {error}")
    return Made(part, failure, statistics())


_no_cache: list[CacheWarning] = []
"""Why the cache of this process cannot keep kernels."""


def workers_can_say(error: Exception) -> bool:
    """Whether an error of a plug-in's own goes from one process to another."""
    try:
        return type(pickle.loads(pickle.dumps(error))) is type(error)
    except Exception:
        return False


def shared_kernels(dimension: int) -> None:
    """Compile what scenes of a dimension need whatever their laws are."""
    if dimension == 2:
        lay_sample(20, 5)
    else:
        lay_in_space()
    two_in_flight(dimension)
    newton_step()


def solver_kernels(dimension: int) -> None:
    """Compile what the default solver and scenes without interactions need: what no law and no contactor changes."""
    scene = lm.Scene(dimension=dimension)
    scene.add(grain(dimension, 0.0, 0.0, 0.0))
    lm.Simulation(scene, time_step=1e-3, solver=WorkFirst()).step()


class WorkFirst(lm.Auto):
    """Compiles the work of sweeps before the kernel that leads it, as a second process does for one that does not."""

    def solve(self, step: Any) -> Any:
        """As ``lmgcpy.Auto`` does."""
        step.muster(iterates=True)
        return super().solve(step)


def kernels_of_law(law: type[Law], dimension: int) -> None:
    """Compile the kernels of a law by two steps of small scenes.

    The scenes have every kind of interaction; each solver makes the steps, with wires as blocks and link by link, with
    geometric stiffness and without. The last step is solved as a problem. Contacts are also solved by two threads.
    """
    contact = law.APPLIES_TO == "contact"
    scenes: tuple[Callable[[Law, int], lm.Scene], ...]
    if contact:
        scenes = (plain, crooked) if dimension == 2 else (plain, held, turning)
    else:
        scenes = (joined,) if law.TIES else (wire, joined)
    found = instances(law, dimension)
    for instance, scene, kind, wire_blocks in itertools.product(found, scenes, SOLVERS.values(), (True, False)):
        solver = kind(wire_blocks=wire_blocks, max_iterations=2)
        sim = two_steps(scene(instance, dimension), solver)
        if law.conic is not None:
            lm.solve(sim.problem(), solver=solver)
        if sim._links.count:
            stiffen(sim)
    if contact:
        for instance, turned, kind in itertools.product(found, (False, True), SOLVERS.values()):
            with partition_from(0):
                two_steps(row_of_grains(instance, dimension, turned), kind(max_iterations=2), threads=2)


def stiffen(sim: lm.Simulation) -> None:
    """Compile the kernels of links with geometric stiffness."""
    assert sim.last_step is not None
    links = sim._links
    links.stiffen(sim.last_step.problem, np.ones(links.count), np.zeros(links.count))


def two_steps(scene: lm.Scene, solver: Any, *, threads: int = 1) -> lm.Simulation:
    """A simulation of a scene after two steps."""
    options = {"solver": solver, "threads": threads, "on_unconverged": "ignore", "overlap": "ignore"}
    return lm.Simulation(scene, time_step=1e-3, **options).run(steps=2)


def instances(law: type[Law], dimension: int) -> list[Law]:
    """Instances of a law, one for each number of rows and each number of parameters of its kernels."""
    parameters = law.parameters()
    found: dict[tuple[int, ...], Law] = {}
    refused: Exception | None = None
    for values in itertools.product(*map(choices, parameters.values())):
        try:
            instance = law(**{name: value for name, value in zip(parameters, values, strict=True) if value is not None})
        except (TypeError, ValueError) as error:
            refused = error
            continue
        found.setdefault((instance.rows(dimension), instance.table(np.ones(1)).shape[1]), instance)
    if not found:
        raise ValueError(f"No parameters within their bounds were found that make a law '{law.NAME}': {refused}")
    return list(found.values())


def choices(parameter: Parameter) -> list[float | None]:
    """Values to try: the minimum (friction 0 needs another kernel), one inside the bounds, and None if it is optional."""
    bounds = parameter.bounds
    low, high = max(bounds["minimum"], bounds["above"]), bounds["maximum"]
    if math.isfinite(low) and math.isfinite(high):
        inside = 0.5 * (low + high)
    else:
        inside = low + 1.0 if math.isfinite(low) else min(high, 1.0)
    least = [bounds["minimum"]] if math.isfinite(bounds["minimum"]) else []
    return [*least, inside, *([None] if parameter.default is None else [])]


# ------------------------------------------------------------------------------------------------------------- scenes


def grain(dimension: int, *position: float, velocity: tuple[float, ...] = (0.1, -0.1, 0.0)) -> Any:
    """A disk or a sphere of radius 0.1 m."""
    start: dict[str, Any] = {"position": position[:dimension], "velocity": velocity[:dimension]}
    return lm.disk(radius=0.1, mass=1.0, **start) if dimension == 2 else lm.sphere(radius=0.1, mass=1.0, **start)


def unbounded(dimension: int) -> list[Any]:
    """Walls and, in 3D, hollow cylinders, each as FLOOR and as LID."""
    nothing = (0,) * (dimension - 2)
    made: list[Any] = [lm.wall(point=(0, 0, *nothing), normal=(0, 1, *nothing), color="FLOOR")]
    lid = lm.wall(point=(0, 1, *nothing), normal=(0, -1, *nothing), color="LID")
    made.append(lid.impose_velocity(y=-0.01))  # the energy balance asks what drives that move receive
    if dimension == 3:
        made += [lm.cylinder_wall(point=(0, 0.5, 0), axis=(1, 0, 0), radius=0.5, color=c) for c in ("FLOOR", "LID")]
    return made


def see_all(scene: lm.Scene, law: Law) -> lm.Scene:
    """Let grains see each other, and grains and walls in both orders."""
    for candidate, antagonist in (("GRAIN", "GRAIN"), ("GRAIN", "FLOOR"), ("LID", "GRAIN")):
        scene.see(candidate, antagonist, law, alert=REACH)
    return scene


def two_in_flight(dimension: int) -> None:
    """Two grains that touch and fly together, so far that neighbour lists are rebuilt and impulses carried over."""
    scene = lm.Scene(dimension=dimension)
    for x in (0.1, 0.3):
        scene.add(grain(dimension, x, 0.0, 0.0, velocity=(15.0, 0.0, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    lm.Simulation(scene, time_step=1e-3).run(steps=4)


def newton_step() -> None:
    """A single step of Newton's method, for contacts that roll and for others: in scenes as small as these, sweeps leave
    nothing to it."""
    for law in (lm.Coulomb(friction=0.3), lm.RollingCoulomb(friction=0.3, rolling_friction=0.1)):
        sim = lm.Simulation(plain(law, 2), time_step=1e-3, on_unconverged="ignore").run(steps=1)
        problem = sim.problem()
        proximal_newton(ActiveSet(problem), np.zeros_like(problem.guess), 0.0, 1)


def plain(law: Law, dimension: int) -> lm.Scene:
    """Grains and walls, each pair in both orders: contacts are central, and local blocks of W are diagonal."""
    scene = lm.Scene(dimension=dimension)
    for body in [grain(dimension, x, 0.1, 0.0) for x in (0.1, 0.3)] + unbounded(dimension):
        scene.add(body)
    return see_all(scene, law)


def held(law: Law, dimension: int) -> lm.Scene:
    """The scene of :func:`plain` with a grain held in x, which couples normal and tangents."""
    scene = plain(law, dimension)
    scene.bodies[0].fix("x")
    return scene


def turning(law: Law, dimension: int) -> lm.Scene:
    """Capsules and a sphere between walls, in a scene whose bodies keep rotations."""
    scene = lm.Scene(dimension=3)
    for x in (0.1, 0.4):
        scene.add(lm.capsule(radius=0.1, length=0.2, position=(x, 0.1, 0.0), mass=1.0, velocity=(0.1, -0.1, 0.0)))
    for body in (grain(dimension, 0.7, 0.1, 0.0), *unbounded(dimension)):
        scene.add(body)
    return see_all(scene, law)


def row_of_grains(law: Law, dimension: int, turned: bool) -> lm.Scene:
    """A row of grains that is long enough for slabs; ``turned`` holds them in x, so that local blocks of W are full."""
    scene = lm.Scene(dimension=dimension)
    for k in range(40):
        scene.add(grain(dimension, 0.5 * k, 0.1, 0.0))
        if turned:
            scene.bodies[-1].fix("x")
    for body in unbounded(dimension):
        scene.add(body)
    return see_all(scene, law)


def lay_in_space() -> None:
    """A wire among spheres in a box."""
    box, radius = (1.0, 1.0, 1.0), 0.1
    laid = lm.sample.wire_3d(
        box=box, bead_radius=0.02, interstice=0.01, bead_count=30, theta_max=0.4, phi_max=0.15, raise_angle=None, seed=0
    )
    obstacles = laid.positions, laid.radii
    lm.sample.deposit([radius] * 20, box=box, obstacles=obstacles, seed=0)
    lm.sample.deposit([radius] * 20, box=(1.0, 1.0, None), seed=0)


def crooked(law: Law, dimension: int) -> lm.Scene:
    """Disks driven in x, which couples normal and tangent, and clusters, whose contacts are not central.

    The local block of W of an upright cluster on the floor is still diagonal.
    """
    scene = lm.Scene(dimension=2)
    for x, y in ((0.1, 0.1), (0.25, 0.25)):
        scene.add(lm.disk(radius=0.1, position=(x, y), mass=1.0, velocity=(0.1, -0.1))).impose_velocity(x=0.1)
    for color, x, arm in (("UPRIGHT", 0.5, (0.0, 0.1)), ("LYING", 0.8, (0.1, 0.0))):
        contactors = [(lm.DiskContactor(0.1), (sign * arm[0], sign * arm[1])) for sign in (1, -1)]
        at = (x, 0.1 + arm[1])
        scene.add(lm.RigidBody(contactors, mass=1.0, inertia=0.01, position=at, color=color, velocity=(0.1, -0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    scene.add(lm.wall(point=(0, 1), normal=(0, -1), color="LID"))
    for candidate, antagonist in (("GRAIN", "GRAIN"), ("UPRIGHT", "FLOOR"), ("LYING", "GRAIN"), ("LID", "LYING")):
        scene.see(candidate, antagonist, law, alert=REACH)
    return scene


def wire(law: Law, dimension: int) -> lm.Scene:
    """A chain of three links."""
    scene = lm.Scene(dimension=dimension)
    beads = [scene.add(grain(dimension, 0.3 * i, 0.0, 0.0)) for i in range(4)]
    scene.chain(beads, law)
    return scene


def joined(law: Law, dimension: int) -> lm.Scene:
    """Three rods, each tied to the next by its end, or linked to it there."""
    scene = lm.Scene(dimension=dimension)
    rods: list[Any] = []
    for k in range(3):
        place, end = ((0.3 if law.TIES else 0.4) * k, 0.0, 0.0), (0.15, 0.0) if dimension == 2 else (0.0, 0.0, 0.15)
        if dimension == 2:
            balls = [(lm.DiskContactor(0.1), (0.0, 0.0))]
            rods.append(scene.add(lm.RigidBody(balls, mass=1.0, inertia=0.01, position=place[:2], color="GRAIN")))
        else:
            rods.append(scene.add(lm.capsule(radius=0.1, length=0.3, mass=1.0, position=place, axis=(1, 0, 0))))
        if k:
            scene.link(rods[k - 1], rods[k], law, at=(end, tuple(-x for x in end)))
    return scene
