"""The paper's 2D study: one sample, a biaxial test per law, and what the wire does to the sand (section 3)."""

from __future__ import annotations

import platform
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numba
import numpy as np

from lmgcpy.dynamics.interrupt import between_steps
from lmgcpy.errors import closest, named_arguments, number, shown, whole
from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord, Frame
from lmgcpy.experiment.box_2d import Sample
from lmgcpy.experiment.compaction import Compaction, compact
from lmgcpy.experiment.stages import Stages
from lmgcpy.experiment.texsol_sample import lay_sample
from lmgcpy.laws import Law
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.laws.rigid import RigidRod, RigidWire
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel

if TYPE_CHECKING:
    from lmgcpy.experiment.texsol_folder import StudyFolder

DENSITY = 2600.0
"""Of the particles [kg/m^3]."""

LAWS: dict[str, Callable[[float], Law | None]] = {
    "none": lambda axial_rigidity: None,
    "rigid-wire": lambda axial_rigidity: RigidWire(),
    "rigid-rod": lambda axial_rigidity: RigidRod(),
    "elastic-wire": lambda axial_rigidity: ElasticWire(axial_rigidity=axial_rigidity),
    "elastic-rod": lambda axial_rigidity: ElasticRod(axial_rigidity=axial_rigidity),
}
"""What the beads may be linked by; "none" is sand."""


@named_arguments
@dataclass(frozen=True)
class Study:
    """What to compute. Defaults are the paper's sample: 2000 particles of which 300 are wire beads.

    ``axial_rigidity`` EA [N] is that of the elastic laws. ``check_strain``: crushing over which every run is made again
    at a ten times tighter tolerance.
    """

    laws: tuple[str, ...] = ("none", "rigid-wire", "rigid-rod")
    grain_count: int = 1700
    bead_count: int = 300
    seed: int = 0
    strain: float = 0.10
    pressure: float = 1e5
    tolerance: float = 3e-3
    max_iterations: int = 6000
    friction: float = 0.4
    platen_friction: float = 0.0
    inertial_number: float = 1e-3
    axial_rigidity: float = 1e7
    check_strain: float = 0.05
    threads: int = 2

    def __post_init__(self):
        if not isinstance(self.laws, (tuple, list)):
            raise TypeError(f"laws must be a tuple of names, got {shown(self.laws)}.")
        for law in self.laws:
            if law not in LAWS:
                raise ValueError(f"The study has no law '{law}'{closest(law, LAWS)}")
        if not self.laws or len(set(self.laws)) < len(self.laws):
            raise ValueError(f"laws must name each law once, got {', '.join(self.laws) or 'none'}.")
        whole(self.grain_count, "grains", minimum=10)
        whole(self.bead_count, "beads", minimum=0)
        if self.bead_count < 2 and set(self.laws) != {"none"}:
            raise ValueError(f"beads must be at least 2 for a wire, got {self.bead_count}; laws 'none' goes without.")
        whole(self.seed, "seed")
        number(self.strain, "strain", above=0.0, maximum=0.5)
        number(self.pressure, "pressure", above=0.0, unit="Pa")
        number(self.tolerance, "tolerance", above=0.0, maximum=1.0)
        whole(self.max_iterations, "max_iterations", minimum=1)
        number(self.friction, "friction", minimum=0.0)
        number(self.platen_friction, "platen_friction", minimum=0.0)
        number(self.inertial_number, "inertial_number", above=0.0, maximum=0.1)
        number(self.axial_rigidity, "axial_rigidity", above=0.0, unit="N")
        number(self.check_strain, "check_strain", minimum=0.0, maximum=0.5)
        whole(self.threads, "threads", minimum=1)

    def quick(self) -> Study:
        """The same on a small sample, for a look: 340 particles, 5 % crushing."""
        return replace(self, grain_count=280, bead_count=60, strain=0.05, check_strain=0.02)

    def solver(self, tighter: float = 1.0) -> AcceleratedGaussSeidel:
        """Solver of the tests, at a tolerance divided by ``tighter``."""
        return AcceleratedGaussSeidel(tolerance=self.tolerance / tighter, max_iterations=self.max_iterations)


@dataclass(frozen=True)
class Result:
    """All that a study computed."""

    study: Study
    compaction: Compaction
    records: dict[str, BiaxialRecord]
    """By law."""
    checks: dict[str, BiaxialRecord]
    """The same at a ten times tighter tolerance, over the first part of the test."""

    @property
    def seconds(self) -> float:
        """Time of the clock that the steps of all runs took [s]."""
        return self.compaction.seconds + sum(run.seconds for run in [*self.records.values(), *self.checks.values()])

    @property
    def sample(self) -> Sample:
        """The relaxed sample at the start of the tests."""
        return self.compaction.sample


def run_study(
    study: Study, stages: Stages | None = None, folder: StudyFolder | None = None, *, resume: bool = False
) -> Result:
    """Prepare the sample and run the tests, as many at once as there are threads.

    With a ``folder`` every run is kept in a file there; ``resume``: they are there in part already, and go on. Ctrl-C
    (KeyboardInterrupt), or an error in one run, ends every run between two steps, with good files.
    """
    stages = stages or Stages(quiet=True)
    failed = threading.Event()

    def file(name: str) -> Path | None:
        return None if folder is None else folder.run_file(name)

    with between_steps() as pressed:

        def interrupted() -> bool:
            return pressed() or failed.is_set()

        with stages.stage("sample: wire laid, grains deposited", 1) as tick:
            laid = lay_sample(study.grain_count, study.bead_count, seed=study.seed)
            tick(1)
        if folder is not None and not resume:
            folder.begin(study)
        with stages.stage("relaxation to the pressure", 800) as tick:
            compaction = compact(
                laid,
                pressure=study.pressure,
                density=DENSITY,
                file=file("compaction"),
                on_step=tick,
                interrupted=interrupted,
            )

        def test(law: str, tighter: float, strain: float) -> BiaxialRecord:
            biaxial = Biaxial(
                compaction.sample,
                LAWS[law](study.axial_rigidity),
                pressure=study.pressure,
                density=DENSITY,
                friction=study.friction,
                platen_friction=study.platen_friction,
                inertial_number=study.inertial_number,
                solver=study.solver(tighter),
            )
            label = f"biaxial test, {law}" + (f", tolerance / {tighter:g}" if tighter > 1.0 else "")
            name, frames = (f"{law}-tight", 0) if tighter > 1.0 else (law, 100)
            try:
                with stages.stage(label, biaxial.step_count(strain)) as tick:
                    return biaxial.run(strain, frames=frames, file=file(name), on_step=tick, interrupted=interrupted)
            except BaseException:
                failed.set()
                raise

        # the longest first, so that no thread waits for the last
        check = min(study.check_strain, study.strain)
        order = sorted(study.laws, key=lambda law: ("rod" not in law, "wire" not in law))
        with ThreadPoolExecutor(study.threads) as pool:
            tighter = {law: pool.submit(test, law, 10.0, check) for law in order if check > 0.0}
            runs = {law: pool.submit(test, law, 1.0, study.strain) for law in order}
        _raise_first([*tighter.values(), *runs.values()])
        if pressed():
            raise KeyboardInterrupt
        checks = {law: tighter[law].result() for law in study.laws if check > 0.0}
        records = {law: runs[law].result() for law in study.laws}
    return Result(study, compaction, records, checks)


def _raise_first(runs: Sequence[Future]) -> None:
    """Raise what ended a study: an error before the interruptions that it caused."""
    errors = [error for error in (run.exception() for run in runs) if error is not None]
    for error in sorted(errors, key=lambda error: isinstance(error, KeyboardInterrupt)):
        raise error


# ------------------------------------------------------------------------------------------------------- conclusions


def stiffening(wire: BiaxialRecord, sand: BiaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, reaction with the wire / reaction of the sand) at the given crushing, as far as the tests went."""
    found = []
    for strain in strains:
        if strain <= min(wire.strain[-1], sand.strain[-1]) + 1e-3:
            there = [np.interp(strain, record.strain, record.smooth(record.reaction, 0.005)) for record in (wire, sand)]
            found.append((strain, float(there[0] / there[1])))
    return found


def column(rod: BiaxialRecord, wire: BiaxialRecord, factor: float = 2.0) -> tuple[float | None, float]:
    """(crushing, ratio): where the rods' mean reaction first exceeds ``factor`` times the wire's, and the greatest ratio
    of the two. The crushing is None where it never does so for 0.5 % on end.
    """
    strain = rod.strain[rod.strain <= wire.strain[-1]]
    of_wire = np.interp(strain, wire.strain, wire.smooth(wire.reaction))
    ratio = rod.smooth(rod.reaction)[: len(strain)] / of_wire
    above = ratio > factor
    for k in np.flatnonzero(above):
        if above[(strain >= strain[k]) & (strain <= strain[k] + 0.005)].all():
            return float(strain[k]), float(ratio.max())
    return None, float(ratio.max())


def compression_in_links(record: BiaxialRecord) -> tuple[float, float]:
    """(share, crushing): the greatest share of the vertical load that links carry in compression, and where.

    The share is the part of the vertical Weber stress that comes from links with a compressive force, over the total,
    frame by frame.
    """
    best = (0.0, 0.0)
    for frame in record.frames:
        x0, x1, y0, y1 = frame.walls
        chosen = frame.in_wire & (frame.forces > 0.0)
        branch = frame.lines[chosen, 1] - frame.lines[chosen, 0]
        length = np.linalg.norm(branch, axis=1)
        carried = float(np.sum(frame.forces[chosen] * branch[:, 1] ** 2 / length)) / ((x1 - x0) * (y1 - y0))
        total = frame.top_force / (x1 - x0)
        if total > 0.0 and carried / total > best[0]:
            best = (carried / total, frame.strain)
    return best


def deviation(record: BiaxialRecord, check: BiaxialRecord) -> float:
    """Mean difference of two runs' reactions over their common crushing, relative to the mean reaction."""
    strain = check.strain[check.strain <= record.strain[-1]]
    ours = np.interp(strain, record.strain, record.smooth(record.reaction))
    theirs = np.interp(strain, check.strain, check.smooth(check.reaction))
    return float(np.abs(ours - theirs).mean() / theirs.mean())


def frames_at_equal_force(wire: BiaxialRecord, sand: BiaxialRecord) -> tuple[Frame, Frame]:
    """A frame of each at the same force on top, to 1 %: of all such pairs the most crushed one. Where there is none, the
    pair whose forces differ least."""
    force = [np.array([frame.top_force for frame in record.frames]) for record in (wire, sand)]
    strain = [np.array([frame.strain for frame in record.frames]) for record in (wire, sand)]
    apart = np.abs(force[0][:, None] - force[1][None]) / np.maximum(force[0][:, None], force[1][None])
    crushed = strain[0][:, None] + strain[1][None]
    rank = np.where(apart <= 0.01, crushed, -apart)
    i, j = np.unravel_index(int(np.argmax(rank)), rank.shape)
    return wire.frames[i], sand.frames[j]


def versions() -> str:
    """Python, libraries and processor, for a report."""
    return (
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}, "
        f"{platform.system()} on {platform.machine()}"
    )
