"""Compression of a sample in its box, biaxial or triaxial: imposed velocity on top, pressure on the lateral walls."""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, named_arguments, number, one_of, shown, whole
from lmgcpy.experiment.box import Box, Sample, characteristic_time, usual_solver
from lmgcpy.experiment.recorded_run import carry_out
from lmgcpy.io.rows import Observe, entries
from lmgcpy.io.run import Run
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.measure.stress import stress
from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.report import SOLVED, STATUS
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.view.recorded import running_mean

RAMP = 0.02
"""Part of the test in which the velocity of the platen grows to its value, so that it starts without a shock."""
NODE_DRAG = 50.0
"""Velocities of the nodes of a thread decay by ``exp(-NODE_DRAG)`` in the time ``d sqrt(rho/p)``, five steps. A node, a
hundredth of a grain, is squeezed out of a gap, and what the error of force leaves of its balance moves it as well, by its
radius in a step; nothing brakes it, and it went through its own thread. (With 5 some 15 of 379 steps of a sample of 400
grains had such a node, with 50 there was none, and steps took half the sweeps.) The force of the drag on a node that moves
with the grains, ``m v NODE_DRAG / (d sqrt(rho/p))``, is ``26 I m / m_grain`` of the force p d^2 of the pressure on a grain:
4e-4 for I = 2e-3 and a node of 1/137, less than the error of force."""
MANY = 2000
"""Number of spheres from which on the error of a force may grow with their number."""
PARTS = ("total", "sand", "wire")
"""Parts of the Weber stress."""


@dataclass(kw_only=True, repr=False)
class CompressionRecord:
    """Measurements of a test in d dimensions, step by step; forces in 2D per metre of depth."""

    law: str
    """Name of the law between the beads, "none" without one."""
    tolerance: float
    """Tolerance of the solver."""
    inertial_number: float
    """Inertial number of the test, ``v d sqrt(rho/p)/H``."""
    strain: np.ndarray
    """Crushing, (s,)."""
    reaction: np.ndarray
    """Support reaction, the force on the lower platen [N], (s,)."""
    top_force: np.ndarray
    """Force on the upper platen [N], (s,)."""
    size: np.ndarray
    """Sizes of the box [m], (s, d)."""
    stress: dict[str, np.ndarray]
    """Weber stress [Pa], its "total" and the parts of "sand" and "wire", (s, d, d) each."""
    residual: np.ndarray
    """Residual of the solver, (s,)."""
    iterations: np.ndarray
    """Number of sweeps, (s,)."""
    interactions: np.ndarray
    """Number of interactions, (s,)."""
    kinetic: np.ndarray
    """Kinetic energy of the free components [J], (s,)."""
    stored: np.ndarray
    """Energy in elastic links [J], (s,)."""
    defect: np.ndarray
    """Defect of the energy identity of the step [J], (s,)."""
    status: list[str]
    """Status of the solver after each step."""
    seconds: float = 0.0
    """Wall clock time of the steps [s]."""
    ended: str = ""
    """Why the test ended before its strain: "locked", "greatest reaction", or nothing."""

    @property
    def unconverged(self) -> int:
        """Number of steps that did not reach the tolerance."""
        return sum(status not in SOLVED for status in self.status)

    def smooth(self, values: np.ndarray, width: float = 0.0025) -> np.ndarray:
        """Running mean over ``width`` of strain along the first axis."""
        return running_mean(self.strain, values, width)

    def __repr__(self) -> str:
        crushed = f"{100.0 * self.strain[-1]:.3g} %" if len(self.strain) else "nothing"
        ended = f", ended by {self.ended}" if self.ended else ""
        return (
            f"<{type(self).__name__} of law '{self.law}': {len(self.strain)} steps to {crushed} of crushing, "
            f"{self.unconverged} not converged{ended}>"
        )


def usual_force(sample: Sample, inertial_number: float) -> float:
    """Error of a force to which a test is solved: I; of n > 2000 spheres without a wire ``I sqrt(n/2000)``.

    The bound is on the worst contact, and a mean over many contacts, as the deviator and the change of volume are, has an
    error that falls with the root of their number: so it is the same for all sizes (docs/step_and_tolerance.md). The
    tension of a wire is no such mean.
    """
    is_sand = sample.dimension == 3 and not sample.wires and not sample.bodies
    return inertial_number * max(1.0, math.sqrt(len(sample.radii) / MANY)) if is_sand else inertial_number


@named_arguments
class Compression(ABC):
    """A test of a sample, ready to run.

    ``law`` links the beads; None: sand. The upper platen across ``axis``, a word such as "y", by default the last axis,
    moves down at ``v = I H sqrt(p/rho)/d``, which makes the inertial number ``I = v d sqrt(rho/p)/H`` of the test;
    ``time_step`` [s] is by default a fifth of ``d sqrt(rho/p)``; ``solver`` sweeps by default to a residual of 1e-2 and an
    error of force of I, at which errors add up to less than the crushing, in space ``I sqrt(n/2000)`` of n > 2000 grains
    without a wire (docs/step_and_tolerance.md). A rigid or elastic rod keeps the gaps at the start of the test as its
    reference, a wire the sample's reference gap. ``wire_friction`` is the friction of a smooth thread against grains and
    against itself, by default ``friction``.
    """

    NAME: str
    DIMENSION: int
    BLOCK_SPIN: bool
    """Whether linked beads are kept from rolling."""

    def __init__(
        self,
        sample: Sample,
        law: Law | None = None,
        *,
        pressure: float = 1e5,
        density: float = 2600.0,
        friction: float = 0.4,
        platen_friction: float = 0.0,
        wire_friction: tuple[float, float] | None = None,
        inertial_number: float = 1e-3,
        axis: str | None = None,
        time_step: float | None = None,
        solver: Solver | None = None,
    ):
        if not isinstance(sample, Sample):
            raise TypeError(f"A {self.NAME} is for a Sample, such as lay_sample() makes, got {shown(sample)}.")
        if sample.dimension != self.DIMENSION:
            raise ValueError(
                f"A {self.NAME} takes a sample of dimension {self.DIMENSION}, this one is of dimension {sample.dimension}."
            )
        self.pressure = number(pressure, "pressure", above=0.0, unit="Pa")
        number(friction, "friction", minimum=0.0)
        number(platen_friction, "platen_friction", minimum=0.0)
        self.inertial_number = number(inertial_number, "inertial_number", above=0.0, maximum=0.1)
        self.law = law
        if law is not None and not isinstance(law, Law):
            raise TypeError(f"law of the wire must be a law such as lmgcpy.RigidWire(), or None, got {shown(law)}.")
        unilateral = law is not None and "pull" in law.TRAITS
        axes = AXES[: self.DIMENSION]
        self.axis = axes.index(one_of(axes[-1] if axis is None else axis, "axis", axes))
        self.box = Box(
            sample,
            density=density,
            friction=friction,
            platen_friction=platen_friction,
            wire_friction=wire_friction,
            law=law,
            reference_gap="wire" if unilateral else "built",
            block_spin=self.BLOCK_SPIN,
            axis=self.axis,
        )
        moment = characteristic_time(sample.diameter, density, pressure)
        self.start = sample.box
        self.height = float(sample.box[self.axis])
        self.speed = inertial_number * self.height / moment
        self.time_step = 0.2 * moment if time_step is None else number(time_step, "time_step", above=0.0, unit="s")
        self.solver = solver or usual_solver(sample.dimension, force=usual_force(sample, inertial_number))
        self.bead_count = sample.bead_count
        self._duration = 1.0
        if self.box.nodes:
            self.box.scene.drag(self.box.particles[: self.box.nodes], rate=NODE_DRAG / moment)
        self.box.load_laterally(self.pressure)
        self.box.drive_top(lambda time: self.speed * min(1.0, time / (RAMP * self._duration)))
        self.simulation: Simulation | None = None

    def step_count(self, strain: float) -> int:
        """Number of steps of a test to this strain."""
        return max(1, int(np.ceil(strain * self.height / (self.speed * self.time_step) * (1.0 + 0.5 * RAMP))))

    def run(
        self,
        strain: float = 0.1,
        *,
        frames: int = 50,
        greatest_reaction: float | None = None,
        file: str | os.PathLike | None = None,
        on_step: Callable[[int], None] | None = None,
        interrupted: Callable[[], bool] | None = None,
    ) -> Any:
        """Crush the sample by ``strain`` of its height and return the record with ``frames`` frames, evenly spaced.

        The test ends earlier if the sample is locked, so that no motion of the platen is possible
        (``lmgcpy.solve.problems.locked``), or if the support reaction exceeds ``greatest_reaction``, the capacity of the
        press, in units of the pressure times the area of the platen at the start. ``file``, ``on_step`` and ``interrupted``
        as in :func:`lmgcpy.experiment.carry_out`.
        """
        number(strain, "strain", above=0.0, maximum=0.9)
        whole(frames, "frames")
        if greatest_reaction is not None:
            number(greatest_reaction, "greatest_reaction", above=0.0)
        limit = np.inf if greatest_reaction is None else greatest_reaction * self.pressure * self.box.area(self.axis)
        self._duration = strain * self.height / self.speed
        sim = self.simulation = Simulation(
            self.box.scene,
            time_step=self.time_step,
            solver=self.solver,
            on_unconverged="ignore",
            overlap="ignore",  # the tolerance of the relaxation leaves some
        )
        count = self.step_count(strain)
        with carry_out(
            sim,
            steps=count,
            observe=self.observed(),
            every=max(1, count // frames) if frames else count + 1,
            notes={
                "experiment": self.NAME,
                "axis": AXES[self.axis],
                "pressure": self.pressure,
                "inertial_number": self.inertial_number,
                "strain": strain,
                # files of former versions say nothing of it
                **({} if greatest_reaction is None else {"greatest_reaction": greatest_reaction}),
            },
            rule=lambda rows: self._ended(rows, limit) != "",
            window=1,
            file=file,
            on_step=on_step,
            interrupted=interrupted,
        ) as run:
            record = self.record(run)
            rows = {"reactions": run.observed["reactions"][-1:], "status": run.status[-1:]}
            record.ended = self._ended(rows, limit)
            return record

    def _ended(self, rows: Mapping[str, np.ndarray], limit: float) -> str:
        """Why a test is over before its strain, from its last step, if there was one; nothing if it is not."""
        if "locked" in rows["status"]:
            return "locked"
        low = rows["reactions"].reshape(-1, 2 * self.DIMENSION)[:, 2 * self.axis]
        return "greatest reaction" if (low > limit).any() else ""

    def observed(self) -> Observe:
        """The quantities that are recorded at every step."""
        stresses = [name for part in PARTS for name in entries(f"stress_{part}", self.DIMENSION, "Pa")]
        return {
            "reactions": (self.box.reactions, self.box.reaction_names),
            "size": (self.box.size, self.box.size_names),
            "stress": (self._stress, stresses),
        }

    @abstractmethod
    def record(self, run: Run) -> CompressionRecord:
        """The record of a run."""

    def _stress(self, sim: Simulation) -> np.ndarray:
        """Weber stress of :data:`PARTS` [Pa], (3, d, d)."""
        sigma = stress(sim)
        wire = np.zeros((self.DIMENSION, self.DIMENSION)) if self.law is None else sigma[self.law.NAME]
        return np.stack([sigma["total"], sigma[Coulomb.NAME], wire])

    def measured(self, run: Run) -> dict[str, Any]:
        """The fields of a :class:`CompressionRecord`."""
        history, size, sigma = run.history[:], run.observed["size"][:], run.observed["stress"][:]
        low, high = run.observed["reactions"][:, 2 * self.axis : 2 * self.axis + 2].T
        return {
            "law": "none" if self.law is None else self.law.NAME,
            "tolerance": self.solver.tolerance,
            "inertial_number": self.inertial_number,
            "strain": 1.0 - size[:, self.axis] / self.height,
            "reaction": low,
            "top_force": high,
            "size": size,
            "stress": {part: sigma[:, k] for k, part in enumerate(PARTS)},
            "residual": history["residual"],
            "iterations": history["iterations"],
            "interactions": history["interactions"],
            "kinetic": history["kinetic"],
            "stored": history["stored"].sum(axis=1),
            "defect": history["defect"],
            "status": [STATUS[code] for code in history["status"]],
            "seconds": float(history["step_seconds"].sum()),
        }

    def __repr__(self) -> str:
        law = repr(self.law) if self.law else "no law between the beads"
        what = f"{type(self).__name__} along {AXES[self.axis]}"
        return f"<{what}, {law}, at {self.pressure:g} Pa: {len(self.box.particles)} particles>"
