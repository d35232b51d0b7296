"""Properties of small runs: rotation of the scene, exchange of bodies, checkpoints and run files."""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import lmgcpy as lm
from lmgcpy.laws import Law, registry
from lmgcpy.laws.registry import Registration
from lmgcpy.testing.property import run_once

STEPS = 24
TIME_STEP = 1e-3
GRAVITY = 9.81
MASSES = (1.0, 2.0, 0.7, 1.3)
RADIUS = 0.1


def kinds(law: Law) -> set[str]:
    """Pairs of lmgcpy's own contactors that a contact law serves."""
    wanted = {frozenset(pair) for pair in type(law).PAIRS or ()}
    known = {"disks": frozenset({"disk"}), "wall": frozenset({"disk", "wall"})}
    return {name for name, pair in known.items() if type(law).PAIRS is None or pair in wanted}


def to_laws_for_scenes(law: Law) -> str:
    """The property applies to links, and to contacts between disks and walls."""
    fits = law.APPLIES_TO == "link" or kinds(law)
    return "" if fits else "the law is for contactors that are not lmgcpy's own"


class SmallRun:
    """Four disks: a wire that hangs from the first and swings, or disks thrown at each other and at a wall.

    ``angle`` [rad] rotates the scene. ``reverse`` adds the bodies in reverse order, which exchanges candidates and
    antagonists. Masses and velocities differ, so that no two events are equal or simultaneous.
    """

    def __init__(self, law: Law, *, angle: float = 0.0, reverse: bool = False):
        c, s = math.cos(angle), math.sin(angle)
        self.turn = np.array([[c, -s], [s, c]])
        self.order = range(4)[::-1] if reverse else range(4)
        self.scene = lm.Scene(dimension=2, gravity=self.turn @ (0.0, -GRAVITY))
        (self._wire if law.APPLIES_TO == "link" else self._heap)(law, reverse)
        solver = lm.GaussSeidel(tolerance=1e-11, max_iterations=20_000)
        self.sim = lm.Simulation(self.scene, time_step=TIME_STEP, solver=solver, on_unconverged="ignore", overlap="ignore")

    def _disks(self, positions: np.ndarray, velocities: np.ndarray) -> list[lm.Disk]:
        bodies: dict[int, lm.Disk] = {}
        for i in self.order:
            start = {"position": self.turn @ positions[i], "velocity": self.turn @ velocities[i]}
            bodies[i] = self.scene.add(lm.disk(radius=RADIUS, mass=MASSES[i], **start))
        return [bodies[i] for i in range(4)]

    def _wire(self, law: Law, reverse: bool) -> None:
        positions = np.array([(0.0, 0.0), (0.05, -0.3), (0.02, -0.6), (0.1, -0.87)])
        velocities = np.array([(0.0, 0.0), (0.3, 0.0), (0.15, -0.1), (-0.3, -0.2)])
        self.bodies = self._disks(positions, velocities)
        self.bodies[0].fix()
        self.scene.chain(self.bodies[::-1] if reverse else self.bodies, law)

    def _heap(self, law: Law, reverse: bool) -> None:
        positions = RADIUS * np.array([(-1.5, 1.001), (0.503, 1.002), (-0.52, 2.734), (1.51, 2.735)])
        velocities = np.array([(0.3, -0.1), (-0.2, -0.3), (0.1, -0.5), (-0.3, -0.6)])
        self.bodies = self._disks(positions, velocities)
        wall = lm.wall(point=(0.0, 0.0), normal=self.turn @ (0.0, 1.0))
        self.scene.add(wall)
        if "disks" in kinds(law):
            self.scene.see("GRAIN", "GRAIN", law, alert=0.5 * RADIUS)
        if "wall" in kinds(law):
            self.scene.see(*(("WALL", "GRAIN") if reverse else ("GRAIN", "WALL")), law, alert=0.5 * RADIUS)

    def run(self, steps: int = STEPS) -> SmallRun:
        """Make steps."""
        run(self.sim, steps)
        return self

    @property
    def motion(self) -> np.ndarray:
        """Positions [m] and velocities [m/s] along axes that rotate with the scene, (4, 4)."""
        rows = [np.concatenate([body.position @ self.turn, body.velocity @ self.turn]) for body in self.bodies]
        return np.array(rows)

    @property
    def forces(self) -> dict[frozenset[int], np.ndarray]:
        """Forces of the last step in their local frames by pair of bodies [N]; 4 is the wall."""
        number = {body.id: i for i, body in enumerate(self.bodies)}
        net = self.sim.interactions
        pairs = zip(net.candidate.tolist(), net.antagonist.tolist(), net.force, strict=True)
        return {frozenset({number.get(c, 4), number.get(a, 4)}): force for c, a, force in pairs}


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
    """Frame indifference of a run of four bodies: the rotated scene has the same forces in the local frames and the same
    motion. So has the scene with candidates and antagonists exchanged, since n, t, u and r are reversed together. Each step
    is solved to 1e-11 of the error of doing nothing."""
    plain = SmallRun(law).run()
    if plain.sim.unconverged_steps:
        return (
            f"{plain.sim.unconverged_steps} of {STEPS} steps of a run of four bodies were not solved, the worst to "
            f"{plain.sim.worst_residual:.2g}: react may have no answer where bodies act on each other, or many, or the "
            "slope of a link is not its derivative."
        )
    for what, other in (
        ("turned by 0.7 rad", SmallRun(law, angle=0.7)),
        ("with candidates and antagonists exchanged", SmallRun(law, reverse=True)),
    ):
        off = np.abs(other.run().motion - plain.motion).max()
        if off > 1e-7:  # motions are about one; 24 steps amplify the solver's error of 1e-11
            return f"after {STEPS} steps {what} the run of four bodies differs by {off:.2g} m or m/s, expected the same."
        largest = max((float(np.abs(force).max()) for force in plain.forces.values()), default=0.0)
        forces = other.forces
        for pair, force in plain.forces.items():
            got = forces.get(pair, np.zeros(2))
            if np.abs(got - force).max() > 1e-5 * max(largest, GRAVITY):
                return (
                    f"the force between bodies {sorted(pair)} {what} is {got.tolist()} N, expected that of the plain run, "
                    f"{force.tolist()} N."
                )
    return ""


@run_once("restart", "a run from a checkpoint, or from its run file, has the bits of the whole run", to_laws_for_scenes)
def restart(law: Law) -> str:
    """An interaction remembers its state only: a run of 24 steps, and one that continues after 11 steps from a checkpoint
    or from its file, end with the same bits of motion, impulses and states. The file holds the law by name and
    parameters."""
    with registered(law):
        whole = SmallRun(law).run().sim
        half = SmallRun(law).run(11)
        rest = SmallRun(law).sim
        rest.restore(half.sim.checkpoint())
        run(rest, STEPS - 11)
        message = difference(whole, rest)
        if message:
            return f"after a restart from a checkpoint {message}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.h5"
            run(SmallRun(law).sim, 11, record=path)
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
