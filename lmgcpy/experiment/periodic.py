"""Samples without walls: a periodic cell of grains, and its simple shear under a normal stress.

The stress is held by the cell itself, which yields to it (:meth:`lmgcpy.Scene.periodic`), and is measured as Weber's stress
of its contacts. There is no wall, so that no layer of grains is ordered by one and no platen slips.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, named_arguments, number, numbers, shown, whole
from lmgcpy.experiment.box import FORCE, GRAIN, SampleScene, characteristic_time, usual_solver
from lmgcpy.experiment.recorded_run import carry_out
from lmgcpy.io.rows import Observe, entries
from lmgcpy.io.run import Run
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.measure.stress import stress
from lmgcpy.sample.arguments import radii, spheres
from lmgcpy.sample.loose import scatter
from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.report import SOLVED, STATUS
from lmgcpy.solve.sweeps.solver import Solver

LOOSE = {2: 0.45, 3: 0.3}
"""Solid fraction of a cell before its compaction."""


@named_arguments
@dataclass(frozen=True)
class PeriodicSample:
    """Grains in a periodic cell; n grains, d dimensions."""

    positions: np.ndarray
    """[m], (n, d); they may lie outside of the cell, as images do."""
    radii: np.ndarray
    """[m], (n,)."""
    edges: np.ndarray
    """Edges of the cell [m], (d, d), a row for each."""

    def __post_init__(self):
        edges = numbers(self.edges, "edges of the periodic sample")
        if edges.shape not in ((2, 2), (3, 3)):
            raise ValueError(f"edges of the periodic sample must be (2, 2) or (3, 3) [m], got {shown(self.edges)}.")
        positions, sizes = spheres(self.positions, self.radii, len(edges), "the periodic sample")
        radii(sizes, "the radii of the periodic sample")
        for name, value in (("positions", positions), ("radii", sizes), ("edges", edges)):
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.edges)

    @property
    def diameter(self) -> float:
        """Mean diameter of the grains [m]."""
        return 2.0 * float(self.radii.mean())

    @property
    def solid_volume(self) -> float:
        """Volume of the grains [m^3], in 2D per metre of depth; overlaps count twice."""
        return float((np.pi * self.radii**2 if self.dimension == 2 else 4.0 / 3.0 * np.pi * self.radii**3).sum())

    @property
    def solid_fraction(self) -> float:
        """Volume of the grains over the volume of the cell."""
        return self.solid_volume / abs(float(np.linalg.det(self.edges)))

    def __repr__(self) -> str:
        return (
            f"<PeriodicSample in {self.dimension}D: {len(self.radii)} grains, solid fraction {self.solid_fraction:.3f}, "
            f"edges {shown(self.edges.tolist())} m>"
        )


@named_arguments
def lay_periodic(sizes: Any, *, dimension: int, solid_fraction: float | None = None, seed: Any = 0) -> PeriodicSample:
    """Grains of these radii, ``sizes`` [m] (n,), at random in a square or cubic cell; not yet compacted.

    ``solid_fraction`` is by default 0.45 in 2D and 0.3 in 3D, close to the most that :func:`lmgcpy.sample.scatter` lays.
    """
    grains = radii(sizes, "sizes")
    d = whole(dimension, "dimension", minimum=2, maximum=3)
    fraction = number(LOOSE[d] if solid_fraction is None else solid_fraction, "solid_fraction", above=0.0, maximum=1.0)
    volume = float((np.pi * grains**2 if d == 2 else 4.0 / 3.0 * np.pi * grains**3).sum()) / fraction
    length = volume ** (1.0 / d)
    return PeriodicSample(scatter(grains, cell=(length,) * d, seed=seed), grains, length * np.eye(d))


class PeriodicCell(SampleScene):
    """The scene of a periodic sample, without gravity; the caller says how its ``cell`` deforms.

    ``friction`` acts between the grains; ``heavy``: the inertia of the cell over ``M w^2 / 12``, M the mass of the grains
    and w the width of a cube of its volume.
    """

    def __init__(self, sample: PeriodicSample, *, density: float, friction: float, heavy: float = 1.0):
        if not isinstance(sample, PeriodicSample):
            raise TypeError(f"A periodic cell is for a PeriodicSample, which lay_periodic() makes, got {shown(sample)}.")
        super().__init__(sample)
        self.radii, self.solid_volume = sample.radii, sample.solid_volume
        self.add_particles(sample.radii, sample.positions, density)
        self.grains = self.particles
        self.scene.see(GRAIN, GRAIN, Coulomb(friction=friction))
        width = (sample.solid_volume / sample.solid_fraction) ** (1.0 / self.dimension)
        inertia = heavy * density * sample.solid_volume * width**2 / 12.0
        self.cell = self.scene.periodic(**dict(zip(AXES, sample.edges, strict=False)), inertia=inertia)

    def __repr__(self) -> str:
        return f"<PeriodicCell of {len(self.grains)} grains in {self.dimension}D>"

    @property
    def sample(self) -> PeriodicSample:
        """The sample in its present state, its grains in the cell."""
        positions = np.array([grain.position for grain in self.grains])
        return PeriodicSample(self.cell.wrapped(positions), self.radii, self.cell.edges)

    def press(self, pressure: float) -> None:
        """Impose the ``pressure`` [Pa] from all sides. The velocity gradient is upper triangular: it deforms the cell and
        does not turn it."""
        axes = AXES[: self.dimension]
        for k, axis in enumerate(axes):
            self.cell.impose_stress(**{axis + axis: -pressure}, **{axis + other: 0.0 for other in axes[k + 1 :]})

    def mean_stress(self, rows: Mapping[str, np.ndarray]) -> np.ndarray:
        """Mean Weber stress of recorded rows [Pa], (d, d), traction positive."""
        return rows["stress"].mean(axis=0)

    def observed(self) -> Observe:
        """The quantities that are recorded at every step: Weber stress [Pa] (d, d), volume [m^d], velocity gradient [1/s]
        (d, d), deepest overlap [m], mean resultant force on a grain [N], kinetic energy of the grains [J], and the network
        (coordination, share of rattlers, fabric)."""
        return {
            "stress": (lambda sim: stress(sim)["total"], entries("stress", self.dimension, "Pa")),
            "volume": (lambda sim: self.cell.volume, f"m^{self.dimension}"),
            "rate": (lambda sim: self.cell.rate, entries("rate", self.dimension, "1/s")),
            "penetration": (self.penetration, "m"),
            "unbalanced": (self.unbalanced, "N"),
            "kinetic": (self._kinetic, "J"),
            "network": (self.network, self.network_names),
        }

    def _kinetic(self, sim: Simulation) -> float:
        grains = slice(0, len(self.grains))
        return 0.5 * float((sim.model.mass[grains] * sim.state.velocities[grains] ** 2).sum())


@dataclass(frozen=True, kw_only=True, repr=False)
class PeriodicShearRecord:
    """Measurements of a simple shear, step by step; d dimensions. Shear is along x, its gradient along y."""

    inertial_number: float
    """``G_xy d sqrt(rho/p)``."""
    pressure: float
    """Imposed normal stress, compression positive [Pa]."""
    strain: np.ndarray
    """Shear strain, (s,)."""
    stress: np.ndarray
    """Weber stress [Pa], traction positive, (s, d, d)."""
    rate: np.ndarray
    """Velocity gradient [1/s], (s, d, d)."""
    solid_fraction: np.ndarray
    """Volume of the grains over the volume of the cell, (s,)."""
    coordination: np.ndarray
    """Mean number of contacts of the grains that are no rattlers, (s,)."""
    fabric: np.ndarray
    """Mean of n (x) n over the contacts, (s, d, d)."""
    penetration: np.ndarray
    """Deepest overlap [m], (s,)."""
    defect: np.ndarray
    """Defect of the energy identity of the step [J], (s,)."""
    status: list[str]
    """Status of the solver after each step."""
    seconds: float
    """Wall clock time of the steps [s]."""

    @property
    def friction(self) -> np.ndarray:
        """Macroscopic friction ``sigma_xy / -sigma_yy``, (s,)."""
        return self.stress[:, 0, 1] / -self.stress[:, 1, 1]

    @property
    def unconverged(self) -> int:
        """Number of steps that did not reach the tolerance."""
        return sum(word not in SOLVED for word in self.status)

    def mean(self, since: float) -> dict[str, float]:
        """Means from the strain ``since`` on: "friction" of the mean stresses, "normal" stress over the imposed one,
        "solid_fraction", "coordination"."""
        late = self.strain >= number(since, "since", minimum=0.0)
        if not late.any():
            raise ValueError(f"The shear ended at a strain of {self.strain[-1]:.3g}, before {since:g}: take less.")
        sigma = self.stress[late].mean(axis=0)
        return {
            "friction": float(sigma[0, 1] / -sigma[1, 1]),
            "normal": float(-sigma[1, 1] / self.pressure),
            "solid_fraction": float(self.solid_fraction[late].mean()),
            "coordination": float(self.coordination[late].mean()),
        }

    def __repr__(self) -> str:
        reached = f"{self.strain[-1]:.3g}" if len(self.strain) else "0"
        steps = f"{len(self.strain)} steps to a shear strain of {reached}"
        return f"<PeriodicShearRecord: {steps}, {self.unconverged} not converged>"


@named_arguments
class PeriodicShear:
    """Simple shear of a periodic sample along x, with the normal stress along y held at ``-pressure`` [Pa], ready to run.

    ``G_xy`` is driven at the rate that makes the ``inertial_number`` ``G_xy d sqrt(rho/p)``, ``G_yy`` yields to the stress,
    and all other components are held: the cell dilates along y alone. ``time_step`` [s] is by default a fifth of
    ``d sqrt(rho/p)``.
    """

    def __init__(
        self,
        sample: PeriodicSample,
        *,
        pressure: float,
        density: float = 2600.0,
        friction: float = 0.4,
        inertial_number: float = 1e-2,
        time_step: float | None = None,
        solver: Solver | None = None,
    ):
        self.pressure = number(pressure, "pressure", above=0.0, unit="Pa")
        self.inertial_number = number(inertial_number, "inertial_number", above=0.0, maximum=0.5)
        self.held = PeriodicCell(sample, density=density, friction=number(friction, "friction", minimum=0.0))
        moment = characteristic_time(sample.diameter, density, pressure)
        self.rate = inertial_number / moment
        self.time_step = 0.2 * moment if time_step is None else number(time_step, "time_step", above=0.0, unit="s")
        self.solver = solver or usual_solver(sample.dimension, force=min(FORCE, inertial_number))
        self.held.cell.impose_rate(xy=self.rate)
        self.held.cell.impose_stress(yy=-self.pressure)
        self.simulation: Simulation | None = None

    def run(
        self,
        strain: float = 1.0,
        *,
        frames: int = 20,
        file: str | os.PathLike | None = None,
        on_step: Callable[[int], None] | None = None,
        interrupted: Callable[[], bool] | None = None,
    ) -> PeriodicShearRecord:
        """Shear by ``strain`` and return the record; ``frames`` are kept in the file, evenly spaced.

        ``file``, ``on_step`` and ``interrupted`` as in :func:`lmgcpy.experiment.carry_out`.
        """
        number(strain, "strain", above=0.0)
        whole(frames, "frames")
        sim = self.simulation = Simulation(
            self.held.scene,
            time_step=self.time_step,
            solver=self.solver,
            on_unconverged="ignore",
            overlap="ignore",  # the tolerance of the compaction leaves some
        )
        count = max(1, round(strain / (self.rate * self.time_step)))
        with carry_out(
            sim,
            steps=count,
            observe=self.held.observed(),
            every=max(1, count // frames) if frames else count + 1,
            notes={
                "experiment": "periodic shear",
                "pressure": self.pressure,
                "inertial_number": self.inertial_number,
                "strain": strain,
            },
            file=file,
            on_step=on_step,
            interrupted=interrupted,
        ) as run:
            return self.record(run)

    def record(self, run: Run) -> PeriodicShearRecord:
        """The record of a run."""
        history, observed, d = run.history[:], run.observed, self.held.dimension
        net = observed["network"][:]
        return PeriodicShearRecord(
            inertial_number=self.inertial_number,
            pressure=self.pressure,
            strain=self.rate * self.time_step * np.arange(1, len(history) + 1),
            stress=observed["stress"][:],
            rate=observed["rate"][:],
            solid_fraction=self.held.solid_volume / observed["volume"][:],
            coordination=net[:, 0],
            fabric=net[:, 2:].reshape(-1, d, d),
            penetration=observed["penetration"][:],
            defect=history["defect"],
            status=[STATUS[code] for code in history["status"]],
            seconds=float(history["step_seconds"].sum()),
        )

    def __repr__(self) -> str:
        return f"<PeriodicShear of {len(self.held.grains)} grains in {self.held.dimension}D at {self.pressure:g} Pa>"
