"""The 3D study: one layered sample, triaxial tests across and along its layers, and what the wire does (section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.experiment.box import Sample, characteristic_time
from lmgcpy.experiment.stages import Stages
from lmgcpy.experiment.texsol_sample_3d import lay_sample_3d
from lmgcpy.experiment.texsol_tests import DENSITY, LAWS, Planned, Result, TexSolStudy, carry_out_study
from lmgcpy.experiment.triaxial import Triaxial, TriaxialRecord
from lmgcpy.sample.arguments import AXES
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel

if TYPE_CHECKING:
    from lmgcpy.experiment.texsol_folder import StudyFolder

UPRIGHT = "z"
"""The axis across the layers."""
RELAXATION_STEP = 0.08
"""Time step of the compaction, in parts of ``d sqrt(rho/p)``."""
TIGHTER = 3.0
"""By how much the tolerance of the checks is tighter."""


@named_arguments
@dataclass(frozen=True)
class Study3D(TexSolStudy):
    """What to compute in 3D. Defaults are a sample of 10 000 particles, of which 3500 are wire beads.

    ``axes`` along which the sample is compressed, a test each: "z" is across the layers of the wire, "x" and "y" are
    along them. ``wires`` share the beads. Checks, none by default, are made of the first axis at a three times tighter
    tolerance: with 10 000 particles such steps take thousands of sweeps. Other fields as in :class:`TexSolStudy`.
    """

    DIMENSION: ClassVar[int] = 3
    WIRE_BLOCKS: ClassVar[bool] = False
    """Grains hold the wire at every bead: blocks take as many sweeps as links one by one, and each 1.5 times as long."""
    MOMENTUM: ClassVar[float] = 0.9
    """With the solver's own 0.97 steps with a taut wire stall at 0.05; with 0.9 they take 300 sweeps to 0.01."""

    laws: tuple[str, ...] = ("none", "rigid-wire")
    grain_count: int = 6500
    bead_count: int = 3500
    seed: int = 0
    strain: float = 0.15
    pressure: float = 1e5
    tolerance: float = 1e-2
    max_iterations: int = 2000
    friction: float = 0.4
    platen_friction: float = 0.0
    inertial_number: float = 2e-3
    axial_rigidity: float = 120.0
    check_strain: float = 0.0
    threads: int = 2
    axes: tuple[str, ...] = ("z", "x")
    wires: int = 1

    def __post_init__(self):
        rods = [law for law in self.laws if str(law).endswith("rod")] if isinstance(self.laws, (tuple, list)) else []
        if rods:
            raise ValueError(
                f"laws of the study in 3D cannot be '{rods[0]}': a chain of beads finer than the grains gives way sideways "
                "and is no column that could bear a push. Take rigid-wire or elastic-wire."
            )
        super().__post_init__()
        self._check_names("axes", "axis", tuple(AXES))
        whole(self.wires, "wires", minimum=1)

    def quick(self) -> Study3D:
        """The same on a small sample, for a look: 770 particles, 8 % crushing."""
        return replace(self, grain_count=500, bead_count=270, strain=0.08, tolerance=3e-3)


def run_study_3d(
    study: Study3D, stages: Stages | None = None, folder: StudyFolder | None = None, *, resume: bool = False
) -> Result:
    """Prepare the sample and compress it once per law and axis, records by "law-axis"; see
    :func:`lmgcpy.experiment.texsol_tests.carry_out_study`.
    """

    def planned(law: str, axis: str, tighter: float = 1.0) -> Planned:
        def make(sample):
            return Triaxial(sample, LAWS[law](study.axial_rigidity), axis=axis, **study.options(tighter))

        name, label = f"{law}-{axis}", f"triaxial test along {axis}, {law}"
        if tighter > 1.0:
            strain = min(study.check_strain, study.strain)
            return Planned(f"{name}-tight", f"{label}, tolerance / {tighter:g}", make, strain, 0)
        return Planned(name, label, make, study.strain, 20)

    # the longest first, so that no thread waits for the last
    order = sorted(study.laws, key=lambda law: "wire" not in law)
    checks = [planned(law, study.axes[0], TIGHTER) for law in order] if study.check_strain > 0.0 else []
    tests = [planned(law, axis) for law in order for axis in study.axes]
    compaction, done = carry_out_study(
        study,
        lambda: lay_sample_3d(study.grain_count, study.bead_count, wires=study.wires, density=DENSITY, seed=study.seed),
        [*checks, *tests],
        relaxation=lambda laid: relaxation(study, laid),
        stages=stages,
        folder=folder,
        resume=resume,
    )
    names = [f"{law}-{axis}" for law in study.laws for axis in study.axes]
    first = [f"{law}-{study.axes[0]}" for law in study.laws] if checks else []
    return Result(study, compaction, {name: done[name] for name in names}, {name: done[f"{name}-tight"] for name in first})


def relaxation(study: Study3D, laid: Sample) -> dict:
    """How the laid sample is compacted: in short steps, as beads are small and move fast; with a drag that keeps the wire
    from being crumpled; solved to 1e-3, as a relaxation gains little in a step, and errors would add up to overlaps.
    """
    step = RELAXATION_STEP * characteristic_time(laid.diameter, DENSITY, study.pressure)
    solver = AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=2000, wire_blocks=study.WIRE_BLOCKS)
    return {"time_step": step, "drag": 2.0, "solver": solver, "max_steps": 1500}


# ------------------------------------------------------------------------------------------------------- conclusions


def at(record: TriaxialRecord, values: np.ndarray, strain: float, width: float = 0.01) -> np.ndarray:
    """Running mean of ``values`` over ``width`` of strain, at a strain."""
    return record.smooth(values, width)[int(np.argmin(np.abs(record.strain - strain)))]


def friction_angle(deviator: float, mean_pressure: float) -> float:
    """Mobilised angle of friction [degrees] in triaxial compression: sin phi = (s1 - s3)/(s1 + s3) = 3 q/(6 p + q)."""
    return float(np.degrees(np.arcsin(3.0 * deviator / (6.0 * mean_pressure + deviator))))


def peak(record: TriaxialRecord) -> tuple[float, float, float]:
    """(crushing, deviator [Pa], mobilised angle [degrees]) where the running mean of the deviator is greatest."""
    q, p = record.smooth(record.deviator, 0.01), record.smooth(record.mean_pressure, 0.01)
    k = int(np.argmax(q))
    return float(record.strain[k]), float(q[k]), friction_angle(float(q[k]), float(p[k]))


def late(record: TriaxialRecord, values: np.ndarray) -> np.ndarray:
    """Mean of ``values`` over the last fifth of the test."""
    return values[record.strain > 0.8 * record.strain[-1]].mean(axis=0)


def cohesion(wire: TriaxialRecord, sand: TriaxialRecord) -> float:
    """Cohesion [Pa] that the wire has given the sand by the end of the test: that which, at the sand's angle of friction,
    raises the deviator as much, ``c = (q_wire - q_sand) (1 - sin phi) / (2 cos phi)``.
    """
    phi = np.radians(friction_angle(float(late(sand, sand.deviator)), float(late(sand, sand.mean_pressure))))
    gain = late(wire, wire.deviator) - late(sand, sand.deviator)
    return float(gain * (1.0 - np.sin(phi)) / (2.0 * np.cos(phi)))


def layer_parts(record: TriaxialRecord) -> tuple[np.ndarray, np.ndarray]:
    """Wire part of the Weber stress [Pa]: the mean of xx and yy, within the layers, and zz, across them, (s,) each."""
    wire = record.stress["wire"]
    return 0.5 * (wire[:, 0, 0] + wire[:, 1, 1]), wire[:, 2, 2]


def principal_axes(sigma: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal values of stresses (s, 3, 3), greatest first [Pa], (s, 3), and as rows their directions, (s, 3, 3), each
    with its greatest component positive."""
    values, vectors = np.linalg.eigh(0.5 * (sigma + np.swapaxes(sigma, 1, 2)))
    rows = np.swapaxes(vectors[:, :, ::-1], 1, 2)
    greatest = np.take_along_axis(rows, np.abs(rows).argmax(axis=2)[:, :, None], axis=2)
    return values[:, ::-1], rows * np.where(greatest < 0.0, -1.0, 1.0)


def gains(wire: TriaxialRecord, sand: TriaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, deviator with the wire / deviator of the sand) at the given crushing, as far as the tests went."""
    end = min(wire.strain[-1], sand.strain[-1]) + 1e-3
    return [
        (strain, float(at(wire, wire.deviator, strain) / at(sand, sand.deviator, strain)))
        for strain in strains
        if strain <= end
    ]


def boundary_mismatch(record: TriaxialRecord) -> float:
    """Relative difference of the mean Weber stress and the mean pressures on the walls, the worst axis."""
    axis = AXES.index(record.axis)
    others = [k for k in range(3) if k != axis]
    measured = np.array([record.axial.mean(), *record.lateral.mean(axis=0)])
    sigma = -record.stress["total"].mean(axis=0)[[axis, *others], [axis, *others]]
    return float(np.abs(sigma / measured - 1.0).max())
