"""How a TexSol study is carried out, in 2D and 3D: sample, compaction, and tests, as many at once as there are threads."""

from __future__ import annotations

import platform
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numba
import numpy as np

from lmgcpy.dynamics.interrupt import between_steps
from lmgcpy.errors import closest, named_arguments, number, shown, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import Compaction, compact
from lmgcpy.experiment.compression import Compression
from lmgcpy.experiment.stages import Stages
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
class TexSolStudy(ABC):
    """What to compute; subclasses have the defaults.

    ``axial_rigidity`` EA [N] is that of the elastic laws. ``check_strain``: crushing over which every run is made again
    at a tighter tolerance.
    """

    DIMENSION: ClassVar[int]
    WIRE_BLOCKS: ClassVar[bool] = True
    """Whether the solver takes a wire as one block."""
    MOMENTUM: ClassVar[float] = AcceleratedGaussSeidel.momentum
    """Bound of the solver's momentum."""

    laws: tuple[str, ...]
    grain_count: int
    bead_count: int
    seed: int
    strain: float
    pressure: float
    tolerance: float
    max_iterations: int
    friction: float
    platen_friction: float
    inertial_number: float
    axial_rigidity: float
    check_strain: float
    threads: int

    def __post_init__(self):
        self._check_names("laws", "law", LAWS)
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

    def _check_names(self, field: str, what: str, known) -> None:
        """Whether a field names some of what is known, each once."""
        names = getattr(self, field)
        if not isinstance(names, (tuple, list)):
            raise TypeError(f"{field} must be a tuple of names, got {shown(names)}.")
        for name in names:
            if name not in known:
                raise ValueError(f"The study has no {what} '{name}'{closest(name, known)}")
        if not names or len(set(names)) < len(names):
            raise ValueError(f"{field} must name each {what} once, got {', '.join(names) or 'none'}.")

    @abstractmethod
    def quick(self) -> TexSolStudy:
        """The same on a small sample, for a look."""

    def solver(self, tighter: float = 1.0) -> AcceleratedGaussSeidel:
        """Solver of the tests, at a tolerance divided by ``tighter``."""
        return AcceleratedGaussSeidel(
            tolerance=self.tolerance / tighter,
            max_iterations=self.max_iterations,
            wire_blocks=self.WIRE_BLOCKS,
            momentum=self.MOMENTUM,
        )

    def options(self, tighter: float = 1.0) -> dict[str, Any]:
        """What every test of the study is made with."""
        return {
            "pressure": self.pressure,
            "density": DENSITY,
            "friction": self.friction,
            "platen_friction": self.platen_friction,
            "inertial_number": self.inertial_number,
            "solver": self.solver(tighter),
        }


@dataclass(frozen=True)
class Result:
    """All that a study computed."""

    study: Any
    compaction: Compaction
    records: dict[str, Any]
    """By name of the test."""
    checks: dict[str, Any]
    """The same at a tighter tolerance, over the first part of the test."""

    @property
    def seconds(self) -> float:
        """Time of the clock that the steps of all runs took [s]."""
        return self.compaction.seconds + sum(run.seconds for run in [*self.records.values(), *self.checks.values()])

    @property
    def sample(self) -> Sample:
        """The relaxed sample at the start of the tests."""
        return self.compaction.sample


@dataclass(frozen=True)
class Planned:
    """A test of a study."""

    name: str
    """That of its run file."""
    label: str
    """As the stages tell it."""
    make: Callable[[Sample], Compression]
    strain: float
    frames: int


def carry_out_study(
    study: TexSolStudy,
    lay: Callable[[], Sample],
    tests: Sequence[Planned],
    *,
    relaxation: Callable[[Sample], dict[str, Any]],
    stages: Stages | None,
    folder: StudyFolder | None,
    resume: bool,
) -> tuple[Compaction, dict[str, Any]]:
    """Prepare the sample and run the tests in their order, as many at once as there are threads; their records by name.

    ``relaxation``: options of :func:`lmgcpy.experiment.compaction.compact` for the laid sample. With a ``folder`` every run
    is kept in a file there; ``resume``: they are there in part already, and go on. Ctrl-C (KeyboardInterrupt), or an error
    in one run, ends every run between two steps, with good files.
    """
    stages = stages or Stages(quiet=True)
    failed = threading.Event()

    def file(name: str) -> Path | None:
        return None if folder is None else folder.run_file(name)

    with between_steps() as pressed:

        def interrupted() -> bool:
            return pressed() or failed.is_set()

        with stages.stage("sample: wire laid, grains deposited", 1) as tick:
            laid = lay()
            tick(1)
        if folder is not None and not resume:
            folder.begin(study)
        options = {"max_steps": 800, **relaxation(laid)}
        with stages.stage("relaxation to the pressure", options["max_steps"]) as tick:
            compaction = compact(
                laid,
                pressure=study.pressure,
                density=DENSITY,
                file=file("compaction"),
                on_step=tick,
                interrupted=interrupted,
                **options,
            )

        def run(planned: Planned) -> Any:
            test = planned.make(compaction.sample)
            try:
                with stages.stage(planned.label, test.step_count(planned.strain)) as tick:
                    return test.run(
                        planned.strain,
                        frames=planned.frames,
                        file=file(planned.name),
                        on_step=tick,
                        interrupted=interrupted,
                    )
            except BaseException:
                failed.set()
                raise

        with ThreadPoolExecutor(study.threads) as pool:
            runs = {planned.name: pool.submit(run, planned) for planned in tests}
        _raise_first(list(runs.values()))
        if pressed():
            raise KeyboardInterrupt
    return compaction, {name: future.result() for name, future in runs.items()}


def _raise_first(runs: Sequence[Future]) -> None:
    """Raise what ended a study: an error before the interruptions that it caused."""
    errors = [error for error in (run.exception() for run in runs) if error is not None]
    for error in sorted(errors, key=lambda error: isinstance(error, KeyboardInterrupt)):
        raise error


def deviation(record: Any, check: Any) -> float:
    """Mean difference of two runs' reactions over their common crushing, relative to the mean reaction."""
    strain = check.strain[check.strain <= record.strain[-1]]
    ours = np.interp(strain, record.strain, record.smooth(record.reaction))
    theirs = np.interp(strain, check.strain, check.smooth(check.reaction))
    return float(np.abs(ours - theirs).mean() / theirs.mean())


def versions() -> str:
    """Python, libraries and processor, for a report."""
    return (
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}, "
        f"{platform.system()} on {platform.machine()}"
    )
