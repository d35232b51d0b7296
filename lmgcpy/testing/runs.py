"""Properties of small runs: rotation of the scene, exchange of bodies, checkpoints and run files."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lmgcpy as lm
from lmgcpy.laws import Law, registry
from lmgcpy.laws.registry import Registration
from lmgcpy.testing.conformance import run_once

STEPS = 24
TIME_STEP = 1e-3
GRAVITY = 9.81
MASSES = (1.0, 2.0, 0.7, 1.3)
RADIUS = 0.1


ROUND, FLAT = {2: "disk", 3: "sphere"}, {2: "wall", 3: "plane"}
"""Kinds of lmgcpy's own contactors by dimension."""
TURN = {2: np.eye(2), 3: np.eye(3)}
"""No rotation of the scene."""


def kinds(law: Law, dimension: int) -> set[str]:
    """Pairs of lmgcpy's own contactors that a contact law serves: "round" with each other, and "flat" with them."""
    wanted = {frozenset(pair) for pair in type(law).PAIRS or ()}
    known = {"round": frozenset({ROUND[dimension]}), "flat": frozenset({ROUND[dimension], FLAT[dimension]})}
    return {name for name, pair in known.items() if type(law).PAIRS is None or pair in wanted}


def dimensions(law: Law) -> list[int]:
    """Dimensions in which a law can have a small run."""
    return [d for d in sorted(law.DIMENSIONS) if law.APPLIES_TO == "link" or kinds(law, d)]


def to_laws_for_scenes(law: Law) -> str:
    """The property applies to links, and to contacts between round bodies and walls."""
    return "" if dimensions(law) else "the law is for contactors that are not lmgcpy's own"


def turning_ball(*, radius: float, mass: float, **start: Any) -> lm.RigidBody:
    """A ball that keeps its rotation."""
    inertia = (0.4 * mass * radius**2,) * 3
    return lm.RigidBody([(lm.SphereContactor(radius), (0.0, 0.0, 0.0))], mass=mass, inertia=inertia, color="GRAIN", **start)


class SmallRun:
    """Four disks or spheres: a wire that hangs from the first and swings, or bodies thrown at each other and at a wall.

    ``turn`` (d, d) rotates the scene. ``reverse`` adds the bodies in reverse order, which exchanges candidates and
    antagonists. Masses and velocities differ, so that no two events are equal or simultaneous.
    """

    def __init__(self, law: Law, *, turn: np.ndarray = TURN[2], reverse: bool = False):
        self.turn, self.dimension = turn, len(turn)
        self.order = range(4)[::-1] if reverse else range(4)
        self.scene = lm.Scene(dimension=self.dimension, gravity=self.turned((0.0, -GRAVITY)))
        (self._wire if law.APPLIES_TO == "link" else self._heap)(law, reverse)
        solver = lm.GaussSeidel(tolerance=1e-11, max_iterations=20_000)
        self.sim = lm.Simulation(self.scene, time_step=TIME_STEP, solver=solver, on_unconverged="ignore", overlap="ignore")

    def turned(self, vector: Any, across: float = 0.0) -> np.ndarray:
        """A vector in the rotated scene; in 3D with a third component."""
        return self.turn @ (vector if self.dimension == 2 else (*vector, across))

    def _bodies(self, positions: np.ndarray, velocities: np.ndarray, tied: bool = False) -> list[lm.Body]:
        bodies: dict[int, lm.Body] = {}
        make: Any = lm.disk if self.dimension == 2 else lm.sphere
        if tied and self.dimension == 3:  # spheres have no points
            make = turning_ball
        for i in self.order:
            position, velocity = self.turned(positions[i], 0.01 * i), self.turned(velocities[i], 0.02 * i - 0.05)
            bodies[i] = self.scene.add(make(radius=RADIUS, mass=MASSES[i], position=position, velocity=velocity))
        return [bodies[i] for i in range(4)]

    def _wire(self, law: Law, reverse: bool) -> None:
        positions = np.array([(0.0, 0.0), (0.05, -0.3), (0.02, -0.6), (0.1, -0.87)])
        velocities = np.array([(0.0, 0.0), (0.3, 0.0), (0.15, -0.1), (-0.3, -0.2)])
        self.bodies = self._bodies(positions, velocities, law.TIES)
        self.bodies[0].fix()
        if not law.TIES:
            self.scene.chain(self.bodies[::-1] if reverse else self.bodies, law)
            return
        for pair in pairwise(self.bodies):  # tied half-way
            a, b = reversed(pair) if reverse else pair
            half = 0.5 * (b.position - a.position)
            self.scene.link(a, b, law, at=(half, -half))

    def _heap(self, law: Law, reverse: bool) -> None:
        positions = RADIUS * np.array([(-1.5, 1.001), (0.503, 1.002), (-0.52, 2.734), (1.51, 2.735)])
        velocities = np.array([(0.3, -0.1), (-0.2, -0.3), (0.1, -0.5), (-0.3, -0.6)])
        self.bodies = self._bodies(positions, velocities)
        self.scene.add(lm.wall(point=(0.0,) * self.dimension, normal=self.turned((0.0, 1.0))))
        if "round" in kinds(law, self.dimension):
            self.scene.see("GRAIN", "GRAIN", law, alert=0.5 * RADIUS)
        if "flat" in kinds(law, self.dimension):
            self.scene.see(*(("WALL", "GRAIN") if reverse else ("GRAIN", "WALL")), law, alert=0.5 * RADIUS)

    def run(self, steps: int = STEPS) -> SmallRun:
        """Make steps."""
        run(self.sim, steps)
        return self

    @property
    def motion(self) -> np.ndarray:
        """Positions [m] and velocities [m/s] along axes that rotate with the scene, (4, 2 d)."""
        rows = [np.concatenate([body.position @ self.turn, body.velocity @ self.turn]) for body in self.bodies]
        return np.array(rows)

    @property
    def forces(self) -> dict[tuple[int, int], np.ndarray]:
        """Forces of the last step on the first body of each pair along axes that rotate with the scene [N], (d,); 4 is the
        wall."""
        number = {body.id: i for i, body in enumerate(self.bodies)}
        net = self.sim.interactions
        found: dict[tuple[int, int], np.ndarray] = {}
        for c, a, force, frame in zip(net.candidate.tolist(), net.antagonist.tolist(), net.force, net.frame, strict=True):
            one, other = number.get(c, 4), number.get(a, 4)
            pair = min(one, other), max(one, other)
            on_first = (1.0 if one < other else -1.0) * (force @ frame @ self.turn)
            found[pair] = found.get(pair, 0.0) + on_first  # a joint has several links
        return found


def run(sim: lm.Simulation, steps: int, **options: Any) -> None:
    """Make steps without warnings: a law may accelerate bodies."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        sim.run(steps=steps, **options)


@contextmanager
def registered(law: Law) -> Iterator[None]:
    """Register the class of the law within the block: run files need its name."""
    lm.laws.names()
    before = registry._laws.get(law.NAME)
    registry._laws[law.NAME] = Registration(type(law), "conformance kit")
    try:
        yield
    finally:
        del registry._laws[law.NAME]
        if before is not None:
            registry._laws[law.NAME] = before


@run_once("scene", "a scene turned by an angle, or with bodies in another order: the same forces", to_laws_for_scenes)
def scene(law: Law) -> str:
    """Frame indifference of a run of four bodies, in 2D and 3D: the rotated scene has the same forces and the same motion
    along axes that rotate with it. So has the scene with candidates and antagonists exchanged, since n, t, u and r are
    reversed together. Each step is solved to 1e-11 of the error of doing nothing."""
    return next((message for d in dimensions(law) if (message := _other_frames(law, d))), "")


def rotation(dimension: int) -> np.ndarray:
    """A rotation by 0.7 rad, in 3D about an axis that is none of the scene's."""
    if dimension == 2:
        return Rotation.from_rotvec((0.0, 0.0, 0.7)).as_matrix()[:2, :2]
    return Rotation.from_rotvec(0.7 * np.array((2.0, -1.0, 2.0)) / 3.0).as_matrix()


def _other_frames(law: Law, dimension: int) -> str:
    plain = SmallRun(law, turn=TURN[dimension]).run()
    where = f"the run of four bodies in {dimension}D"
    if plain.sim.unconverged_steps:
        return (
            f"{plain.sim.unconverged_steps} of {STEPS} steps of a run of four bodies were not solved in {dimension}D, the "
            f"worst to {plain.sim.worst_residual:.2g}: react may have no answer where bodies act on each other, or many, "
            "or the slope of a link is not its derivative."
        )
    for what, other in (
        ("turned by 0.7 rad", SmallRun(law, turn=rotation(dimension))),
        ("with candidates and antagonists exchanged", SmallRun(law, turn=TURN[dimension], reverse=True)),
    ):
        off = np.abs(other.run().motion - plain.motion).max()
        if off > 1e-7:  # motions are about one; 24 steps amplify the solver's error of 1e-11
            return f"after {STEPS} steps {what} {where} differs by {off:.2g} m or m/s, expected the same."
        largest = max((float(np.abs(force).max()) for force in plain.forces.values()), default=0.0)
        forces = other.forces
        for pair, force in plain.forces.items():
            got = forces.get(pair, np.zeros(dimension))
            if np.abs(got - force).max() > 1e-5 * max(largest, GRAVITY):
                return (
                    f"the force between bodies {list(pair)} {what} is {got.tolist()} N, expected that of the plain run, "
                    f"{force.tolist()} N, in {where}."
                )
    return ""


@run_once("restart", "a run from a checkpoint, or from its run file, has the bits of the whole run", to_laws_for_scenes)
def restart(law: Law) -> str:
    """An interaction remembers its state only: a run of 24 steps, and one that continues after 11 steps from a checkpoint
    or from its file, end with the same bits of motion, impulses and states. The file holds the law by name and
    parameters. The run is in 2D unless the law is for 3D only."""
    turn = TURN[dimensions(law)[0]]
    with registered(law):
        whole = SmallRun(law, turn=turn).run().sim
        half = SmallRun(law, turn=turn).run(11)
        rest = SmallRun(law, turn=turn).sim
        rest.restore(half.sim.checkpoint())
        run(rest, STEPS - 11)
        message = difference(whole, rest)
        if message:
            return f"after a restart from a checkpoint {message}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.h5"
            run(SmallRun(law, turn=turn).sim, 11, record=path)
            again = lm.resume(path)
            run(again, STEPS - 11)
        message = difference(whole, again)
        return f"after a restart from the run file {message}" if message else ""


def difference(one: lm.Simulation, other: lm.Simulation) -> str:
    """The first quantity that differs in any bit, as a clause; "" if there is none."""
    parts = {"positions": (one.positions, other.positions), "velocities": (one.velocities, other.velocities)}
    parts["impulses"] = one.interactions.impulse, other.interactions.impulse
    for name, state in one.interactions.state.items():
        parts[f"state {name}"] = state, other.interactions.state[name]
    for name, (a, b) in parts.items():
        if not np.array_equal(a, b, equal_nan=True):
            return f"{name} differ by {np.nanmax(np.abs(a - b)):.3g}, expected the same to the last bit."
    return ""
