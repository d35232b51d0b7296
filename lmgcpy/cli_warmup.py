"""The command ``lmgcpy warmup``: small scenes that need every kernel, so that no later run waits for the compiler."""

from __future__ import annotations

import itertools
import math
import time as clock
import warnings

import click
import numpy as np

import lmgcpy as lm
from lmgcpy.experiment.stages import Stages
from lmgcpy.experiment.texsol_sample import lay_sample
from lmgcpy.io.restart import SOLVERS
from lmgcpy.jit import statistics
from lmgcpy.jit_cache import CacheWarning, cache_directory
from lmgcpy.laws import Law, Parameter

REACH = 1.0
"""Alert distance that makes an interaction of every pair in the scenes [m]."""


@click.command()
@click.option("--laws", default="", help="Only these, by commas; otherwise all that are registered.")
def warmup(laws: str) -> None:
    """Compile what 2D scenes need, before the first run does.

    Every law with every pair of contactors and every solver, the samples, and problems of one step; what the cache
    has already is left as it is. LMGCPY_CACHE_DIR says where the cache is, if not in the user's cache directory.
    """
    names = [name.strip() for name in laws.split(",") if name.strip()] or lm.laws.names()
    chosen = [lm.laws.get(name) for name in names]
    failures: dict[str, Exception] = {}
    begin = clock.perf_counter()
    try:
        with warnings.catch_warnings(), Stages().stage("warmup", len(chosen)) as tick:
            warnings.simplefilter("error", CacheWarning)
            for done, law in enumerate(chosen, start=1):
                try:
                    law_kernels(law)
                except CacheWarning:
                    raise
                except Exception as error:  # of a plug-in's law: the others are compiled all the same
                    failures[law.NAME] = error
                tick(done)
            lay_sample(20, 5)
            two_in_flight()
    except CacheWarning as warning:
        raise OSError(str(warning)) from warning
    compiled = set(statistics().compiled)
    there = set(statistics().loaded) - compiled  # some laws share kernels
    click.echo(
        f"{len(compiled) + len(there)} kernels in {cache_directory()}: {len(compiled)} compiled, {len(there)} were there; "
        f"{clock.perf_counter() - begin:.1f} s."
    )
    if failures:
        name, cause = next(iter(failures.items()))
        raise RuntimeError(
            f"Kernels of {', '.join(failures)} could not be compiled. Why: lmgcpy --traceback warmup --laws {name}"
        ) from cause


def law_kernels(law: type[Law]) -> None:
    """All that is made for a law: small scenes of every kind of interaction, two steps each, by every solver, with wires
    as blocks and link by link; and the last step as a problem."""
    scenes = (plain, crooked) if law.APPLIES_TO == "contact" else (wire,)
    for instance, scene, kind, wire_blocks in itertools.product(instances(law), scenes, SOLVERS.values(), (True, False)):
        solver = kind(wire_blocks=wire_blocks, max_iterations=2)
        sim = lm.Simulation(scene(instance), time_step=1e-3, solver=solver, on_unconverged="ignore").run(steps=2)
        if law.conic is not None:
            lm.solve(sim.problem(), solver=solver)


def instances(law: type[Law]) -> list[Law]:
    """A law with parameters within their bounds, one for every number of rows and of parameters that its kernels know."""
    parameters = law.parameters()
    found: dict[tuple[int, ...], Law] = {}
    refused: Exception | None = None
    for values in itertools.product(*map(choices, parameters.values())):
        try:
            instance = law(**{name: value for name, value in zip(parameters, values, strict=True) if value is not None})
        except (TypeError, ValueError) as error:
            refused = error
            continue
        found.setdefault((instance.rows(2), instance.table(np.ones(1)).shape[1]), instance)
    if not found:
        raise ValueError(f"No parameters within their bounds were found that make a law '{law.NAME}': {refused}")
    return list(found.values())


def choices(parameter: Parameter) -> list[float | None]:
    """Values to try: its least (friction 0 makes another kernel), one inside its bounds, and none if it is optional."""
    bounds = parameter.bounds
    low, high = max(bounds["minimum"], bounds["above"]), bounds["maximum"]
    if math.isfinite(low) and math.isfinite(high):
        inside = 0.5 * (low + high)
    else:
        inside = low + 1.0 if math.isfinite(low) else min(high, 1.0)
    least = [bounds["minimum"]] if math.isfinite(bounds["minimum"]) else []
    return [*least, inside, *([None] if parameter.default is None else [])]


# ------------------------------------------------------------------------------------------------------------- scenes


def plain(law: Law) -> lm.Scene:
    """Disks and walls, each pair in both orders: central contacts, local blocks of W diagonal."""
    scene = lm.Scene(dimension=2)
    for x in (0.1, 0.3):
        scene.add(lm.disk(radius=0.1, position=(x, 0.1), mass=1.0, velocity=(0.1, -0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    scene.add(lm.wall(point=(0, 1), normal=(0, -1), color="LID"))
    scene.see("GRAIN", "GRAIN", law, alert=REACH)
    scene.see("GRAIN", "FLOOR", law, alert=REACH)
    scene.see("LID", "GRAIN", law, alert=REACH)
    return scene


def two_in_flight() -> None:
    """Two disks that touch and fly together, so far that lists of neighbours are made anew and impulses carried over."""
    scene = lm.Scene(dimension=2)
    for x in (0.1, 0.3):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(15.0, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    lm.Simulation(scene, time_step=1e-3).run(steps=4)


def crooked(law: Law) -> lm.Scene:
    """A disk held in x, which couples normal and tangent, and clusters, whose contacts are not central: of an upright
    one on the floor the local block of W is diagonal even so."""
    scene = lm.Scene(dimension=2)
    for x, y in ((0.1, 0.1), (0.25, 0.25)):
        scene.add(lm.disk(radius=0.1, position=(x, y), mass=1.0, velocity=(0.1, -0.1))).fix("x")
    for color, x, arm in (("UPRIGHT", 0.5, (0.0, 0.1)), ("LYING", 0.8, (0.1, 0.0))):
        contactors = [(lm.DiskContactor(0.1), (sign * arm[0], sign * arm[1])) for sign in (1, -1)]
        place = (x, 0.1 + arm[1])
        scene.add(lm.RigidBody(contactors, mass=1.0, inertia=0.01, position=place, color=color, velocity=(0.1, -0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    scene.add(lm.wall(point=(0, 1), normal=(0, -1), color="LID"))
    for candidate, antagonist in (("GRAIN", "GRAIN"), ("UPRIGHT", "FLOOR"), ("LYING", "GRAIN"), ("LID", "LYING")):
        scene.see(candidate, antagonist, law, alert=REACH)
    return scene


def wire(law: Law) -> lm.Scene:
    """Three links."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.0), mass=1.0, velocity=(0.1 * i, 0.0))) for i in range(4)]
    scene.chain(beads, law)
    return scene
