"""Biaxial compression of a 2D sample (paper, section 3): imposed velocity on top, pressure on the lateral walls."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.box_2d import WALLS, Box2D, Sample, characteristic_time
from lmgcpy.experiment.trial import carry_out
from lmgcpy.io.kept import KeptRun
from lmgcpy.io.run import Run
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.measure.stress import stress
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel
from lmgcpy.solve.report import STATUS

RAMP = 0.02
"""Part of the test in which the platen takes up its velocity, so that it starts without a shock."""
PARTS = ("total", "sand", "wire")
"""Parts of the Weber stress."""


@dataclass(frozen=True)
class Frame:
    """The sample at one moment."""

    strain: float
    """Crushing, as a fraction of the height at the start."""
    top_force: float
    """Force on the upper platen [N]."""
    positions: np.ndarray
    """Of the particles [m], (n, 2)."""
    walls: np.ndarray
    """Left, right, bottom, top [m], (4,)."""
    lines: np.ndarray
    """Force lines: their two ends [m], (m, 2, 2)."""
    forces: np.ndarray
    """Normal force along each, compression positive [N], (m,)."""
    in_wire: np.ndarray
    """Which of them are links, (m,) bool."""


@dataclass
class BiaxialRecord:
    """What a biaxial test measured, step by step."""

    law: str
    tolerance: float
    inertial_number: float
    strain: np.ndarray
    """Crushing, (s,)."""
    reaction: np.ndarray
    """Support reaction below [N], (s,)."""
    top_force: np.ndarray
    """Force on the upper platen [N], (s,)."""
    lateral: np.ndarray
    """Mean force on the lateral walls [N], (s,)."""
    size: np.ndarray
    """Width and height [m], (s, 2)."""
    stress: dict[str, np.ndarray]
    """Weber stress of :data:`PARTS` [Pa], (s, 2, 2) each."""
    residual: np.ndarray
    iterations: np.ndarray
    interactions: np.ndarray
    kinetic: np.ndarray
    """Kinetic energy of the free components [J], (s,)."""
    stored: np.ndarray
    """Energy in elastic links [J], (s,)."""
    defect: np.ndarray
    """What the energy identity of the step leaves [J], (s,)."""
    status: list[str]
    frames: list[Frame] = field(default_factory=list)
    seconds: float = 0.0
    """Time of the clock that the steps took [s]."""

    @property
    def unconverged(self) -> int:
        """Steps that did not reach the tolerance."""
        return sum(status != STATUS[0] for status in self.status)

    def smooth(self, values: np.ndarray, width: float = 0.0025) -> np.ndarray:
        """Running mean over ``width`` of strain along the first axis."""
        if len(values) < 3:
            return values
        count = max(1, round(width / float(np.mean(np.diff(self.strain)))))
        sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
        index = np.arange(len(values))
        low, high = np.maximum(index - count // 2, 0), np.minimum(index + count // 2 + 1, len(values))
        return (sums[high] - sums[low]) / (high - low).reshape(-1, *[1] * (values.ndim - 1))


@named_arguments
class Biaxial:
    """A biaxial test, ready to run.

    ``law`` links the beads (None: sand). The upper platen goes down at ``v = I H sqrt(p/rho)/d``, which makes the
    inertial number ``I = v d sqrt(rho/p)/H`` of the test; ``time_step`` [s] is by default a fifth of ``d sqrt(rho/p)``.
    A rigid or elastic rod keeps the gaps at the start of the test as its reference, a wire the sample's reference gap.
    """

    def __init__(
        self,
        sample: Sample,
        law: Law | None = None,
        *,
        pressure: float = 1e5,
        density: float = 2600.0,
        friction: float = 0.4,
        platen_friction: float = 0.0,
        inertial_number: float = 1e-3,
        time_step: float | None = None,
        solver: AcceleratedGaussSeidel | GaussSeidel | None = None,
    ):
        self.pressure = number(pressure, "pressure", above=0.0, unit="Pa")
        number(friction, "friction", minimum=0.0)
        number(platen_friction, "platen_friction", minimum=0.0)
        self.inertial_number = number(inertial_number, "inertial_number", above=0.0, maximum=0.1)
        self.law = law
        if law is not None and not isinstance(law, Law):
            raise TypeError(f"law of the wire must be a law such as lmgcpy.RigidWire(), or None, got {shown(law)}.")
        unilateral = law is not None and "pull" in law.TRAITS
        self.box = Box2D(
            sample,
            density=density,
            friction=friction,
            platen_friction=platen_friction,
            law=law,
            reference_gap="wire" if unilateral else "built",
        )
        moment = characteristic_time(sample.diameter, density, pressure)
        self.height = sample.height
        self.speed = inertial_number * sample.height / moment
        self.time_step = 0.2 * moment if time_step is None else number(time_step, "time_step", above=0.0, unit="s")
        self.solver = solver or AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=20_000)
        self.bead_count = sample.bead_count
        self._duration = 1.0
        self.box.load_laterally(self.pressure)
        self.box.top.impose_velocity(y=lambda time: -self.speed * min(1.0, time / (RAMP * self._duration)))
        self.simulation: Simulation | None = None

    def step_count(self, strain: float) -> int:
        """Steps that a test to this strain takes."""
        return max(1, int(np.ceil(strain * self.height / (self.speed * self.time_step) * (1.0 + 0.5 * RAMP))))

    def run(
        self,
        strain: float = 0.1,
        *,
        frames: int = 50,
        file: str | os.PathLike | None = None,
        on_step: Callable[[int], None] | None = None,
        interrupted: Callable[[], bool] | None = None,
    ) -> BiaxialRecord:
        """Crush the sample by ``strain`` of its height; ``frames`` of it are kept, evenly spaced.

        ``file``, ``on_step`` and ``interrupted`` as in :func:`lmgcpy.experiment.trial.carry_out`.
        """
        number(strain, "strain", above=0.0, maximum=0.9)
        whole(frames, "frames")
        self._duration = strain * self.height / self.speed
        sim = self.simulation = Simulation(
            self.box.scene,
            time_step=self.time_step,
            solver=self.solver,
            on_unconverged="ignore",
            overlap="ignore",  # what the tolerance of the relaxation left
        )
        count = self.step_count(strain)
        with carry_out(
            sim,
            steps=count,
            observe={"reactions": self.box.reactions, "size": self.box.size, "stress": self._stress},
            every=max(1, count // frames) if frames else count + 1,
            notes={
                "experiment": "biaxial test",
                "pressure": self.pressure,
                "inertial_number": self.inertial_number,
                "strain": strain,
            },
            file=file,
            on_step=on_step,
            interrupted=interrupted,
        ) as run:
            return self._record(run)

    def _stress(self, sim: Simulation) -> np.ndarray:
        """Weber stress of :data:`PARTS` [Pa], (3, 2, 2)."""
        sigma = stress(sim)
        wire = np.zeros((2, 2)) if self.law is None else sigma[self.law.NAME]
        return np.stack([sigma["total"], sigma[Coulomb.NAME], wire])

    def _record(self, run: KeptRun | Run) -> BiaxialRecord:
        history = run.history[:]
        left, right, bottom, top = run.observed["reactions"][:].T
        size, sigma = run.observed["size"][:], run.observed["stress"][:]
        strain = 1.0 - size[:, 1] / self.height
        stored = history["stored"].sum(axis=1)
        return BiaxialRecord(
            law="none" if self.law is None else self.law.NAME,
            tolerance=self.solver.tolerance,
            inertial_number=self.inertial_number,
            strain=strain,
            reaction=bottom,
            top_force=top,
            lateral=0.5 * (left + right),
            size=size,
            stress={part: sigma[:, k] for k, part in enumerate(PARTS)},
            residual=history["residual"],
            iterations=history["iterations"],
            interactions=history["interactions"],
            kinetic=history["kinetic"],
            stored=stored,
            defect=history["defect"],
            status=[STATUS[code] for code in history["status"]],
            frames=[self._frame(run, k, strain[step - 1], top[step - 1]) for k, step in enumerate(run.steps) if step > 0],
            seconds=float(history["step_seconds"].sum()),
        )

    def _frame(self, run: KeptRun | Run, k: int, strain: float, top_force: float) -> Frame:
        net, positions = run.interactions(k), run.positions[k]
        acting = net.force[:, 0] != 0.0
        antagonist, candidate = net.antagonist[acting], net.candidate[acting]
        count = len(self.box.particles)
        at_wall = (antagonist >= count)[:, None]
        start = np.where(at_wall, positions[candidate] + net.lever[acting, 0], positions[antagonist])
        walls = {name: positions[getattr(self.box, name).id] for name in WALLS}
        return Frame(
            strain=float(strain),
            top_force=float(top_force),
            positions=positions[:count],
            walls=np.array([walls["left"][0], walls["right"][0], walls["bottom"][1], walls["top"][1]]),
            lines=np.stack([start, positions[candidate]], axis=1),
            forces=net.force[acting, 0],
            in_wire=np.zeros(int(acting.sum()), dtype=bool) if self.law is None else net.law[acting] == self.law.NAME,
        )
