"""The TexSol studies: one sample, compacted, and compressed once per law of the wire and axis.

In 2D it is the paper's study (section 3), biaxial tests of a wire in random orientation. In 3D it is the continuation
(section 4), triaxial tests across and along the layers of the wire.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from lmgcpy.errors import AXES, closest, named_arguments, number, one_of, shown, whole
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import MOMENTUM, Sample, characteristic_time, wire_frictions
from lmgcpy.experiment.compaction import Compaction, compact
from lmgcpy.experiment.compression import Compression
from lmgcpy.experiment.study.engine import Site, Study, Task
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.result import TexSolResult, measures
from lmgcpy.experiment.texsol.sample import THETA_MAX_2D, THETA_MAX_3D, lay_sample, lay_sample_3d
from lmgcpy.experiment.thread_course import WIRES
from lmgcpy.experiment.triaxial import Triaxial
from lmgcpy.laws import Law
from lmgcpy.laws.elastic import ElasticRod, ElasticWire
from lmgcpy.laws.rigid import RigidRod, RigidWire
from lmgcpy.sample.wires import bead_mass as mass_of_a_bead
from lmgcpy.solve.newton.alternating import Auto
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.solver import Solver

DENSITY = 2600.0
"""Density of the particles [kg/m^3]."""
RELAXATION_STEPS = 800
"""Greatest number of steps of a relaxation, if the study does not say otherwise."""
BEAD_MASSES = ("grain", "own")
"""Mass of a bead or node in the tests in 3D: the mass of a mean grain, or of its part of the wire."""
THREAD = 167.0
"""Linear density of the thread in 3D [dtex]."""
BEADS = {
    "bead_mass": "grain",
    "wire": "beads",
    "thread_diameter": None,
    "node_distance": 0.7,
    "dtex": THREAD,
    "wire_friction": None,
    "force_error": None,
}
"""Fields of studies in 3D before there were threads."""
PER_PARTICLE_AND_STEP = {2: 2.7 * 1000 * 15e-9, 3: 3.8 * 500 * 20e-9}
"""Seconds of one processor: interactions a particle, sweeps a step, and seconds an interaction and sweep, as measured on
the default studies (docs/texsol.md, docs/texsol_3d.md, docs/benchmarks.md). Jammed rods take several times as much."""
RELAXATION_COST = 0.5
"""Cost of a relaxation, in tests to 10 % of crushing."""
RELAXATION_STEP_3D = 0.08
"""Time step of the compaction in 3D, in parts of ``d sqrt(rho/p)``."""

PREPARATIONS = ("loose", "dense")
"""Relaxations: with the friction of the test, or without friction."""
SOLVERS = ("auto", "accelerated")
"""Solvers of the tests: sweeps and Newton steps, or sweeps alone."""
FACTORISATIONS = 200
"""Most Newton steps of a step of a test. (Rods in the 2D sample of seed 4: 97.0 % of the steps solved with 60, 99.4 % with
200, in the same time, as hardly solved steps leave harder ones behind; 93.1 % by sweeps alone.)"""

LAWS: dict[str, Callable[[float], Law | None]] = {
    "none": lambda axial_rigidity: None,
    "rigid-wire": lambda axial_rigidity: RigidWire(),
    "rigid-rod": lambda axial_rigidity: RigidRod(),
    "elastic-wire": lambda axial_rigidity: ElasticWire(axial_rigidity=axial_rigidity),
    "elastic-rod": lambda axial_rigidity: ElasticRod(axial_rigidity=axial_rigidity),
}
"""Laws that may link the beads; "none" is sand."""


@dataclass(frozen=True)
class PlannedTest:
    """A test of a study: a law, an axis, and how much tighter than the study's its tolerance is."""

    law: str
    axis: str | None
    """None: the upright one, in 2D."""
    strain: float
    frames: int
    tighter: float = 1.0

    @property
    def name(self) -> str:
        """The name of its run file."""
        name = self.law if self.axis is None else f"{self.law}-{self.axis}"
        return f"{name}-tight" if self.tighter > 1.0 else name


@named_arguments
@dataclass(frozen=True)
class TexSolStudy(Study):
    """A study of wire-reinforced sand; the defaults are those of the study in 2D.

    ``preparation``: "loose", relaxed with the friction of the test, as the paper's "little LMGC90 deposit" does it, or
    "dense", relaxed without friction, to the densest state that there is. ``theta_max``: greatest turn of the wire from
    bead to bead as it is laid [rad]. ``solver`` of the tests: "auto", sweeps and Newton steps by turns, or "accelerated",
    sweeps alone. ``axial_rigidity``: EA [N] of the elastic laws. ``check_strain``: crushing over which the tests are made
    again at a tighter tolerance. ``tolerance`` and ``force_error``: residual and error of a force to which the steps of the
    tests are solved; without the second the solver's, see :class:`Solver <lmgcpy.Solver>`. ``greatest_reaction``: a test
    ends if its support reaction exceeds this multiple of the pressure times the area of the platen; never if None. A test
    also ends if the sample is locked.
    """

    COMMAND: ClassVar[str] = "texsol"
    DIMENSION: ClassVar[int]
    TEST: ClassVar[type[Compression]]
    """The test of the sample."""
    FRAMES: ClassVar[int]
    """Number of frames of a test that are recorded."""
    TIGHTER: ClassVar[float]
    """Factor by which the tolerance of the checks is tighter."""
    FORMER: ClassVar[Mapping[str, Any]] = {"preparation": "dense", "solver": "accelerated", "greatest_reaction": None}

    laws: tuple[str, ...] = ("none", "rigid-wire", "rigid-rod")
    grain_count: int = 1700
    bead_count: int = 300
    seed: int = 0
    preparation: str = "loose"
    theta_max: float = THETA_MAX_2D
    strain: float = 0.10
    pressure: float = 1e5
    solver: str = "auto"
    tolerance: float = 3e-3
    force_error: float | None = None
    max_iterations: int = 6000
    friction: float = 0.4
    platen_friction: float = 0.0
    inertial_number: float = 1e-3
    axial_rigidity: float = 1e7
    check_strain: float = 0.01
    greatest_reaction: float | None = None
    threads: int = 2

    def __post_init__(self):
        self._check_names("laws", "law", LAWS)
        whole(self.grain_count, "grains", minimum=10)
        whole(self.bead_count, "beads", minimum=0)
        if self.bead_count < 2 and set(self.laws) != {"none"}:
            raise ValueError(f"beads must be at least 2 for a wire, got {self.bead_count}; laws 'none' goes without.")
        whole(self.seed, "seed")
        one_of(self.preparation, "preparation", PREPARATIONS)
        number(self.theta_max, "theta_max", minimum=0.0, maximum=math.pi, unit="rad")
        number(self.strain, "strain", above=0.0, maximum=0.5)
        number(self.pressure, "pressure", above=0.0, unit="Pa")
        one_of(self.solver, "solver", SOLVERS)
        number(self.tolerance, "tolerance", above=0.0, maximum=1.0)
        if self.force_error is not None:
            number(self.force_error, "force_error", above=0.0, maximum=1.0)
        whole(self.max_iterations, "max_iterations", minimum=1)
        number(self.friction, "friction", minimum=0.0)
        number(self.platen_friction, "platen_friction", minimum=0.0)
        number(self.inertial_number, "inertial_number", above=0.0, maximum=0.1)
        number(self.axial_rigidity, "axial_rigidity", above=0.0, unit="N")
        number(self.check_strain, "check_strain", minimum=0.0, maximum=0.5)
        if self.greatest_reaction is not None:
            number(self.greatest_reaction, "greatest_reaction", above=0.0)
        whole(self.threads, "threads", minimum=1)

    def _check_names(self, field: str, what: str, known) -> None:
        """Check that a field names some of what is known, each once."""
        names = getattr(self, field)
        if not isinstance(names, (tuple, list)):
            raise TypeError(f"{field} must be a tuple of names, got {shown(names)}.")
        for name in names:
            if name not in known:
                raise ValueError(f"The study has no {what} '{name}'{closest(name, known)}")
        if not names or len(set(names)) < len(names):
            raise ValueError(f"{field} must name each {what} once, got {', '.join(names) or 'none'}.")

    @classmethod
    def kind(cls) -> dict[str, Any]:
        return {"dimension": cls.DIMENSION}

    @classmethod
    def class_of(cls, about: Mapping[str, Any]) -> type[TexSolStudy]:
        return STUDIES[about.get("dimension", 2)]

    @abstractmethod
    def quick(self) -> TexSolStudy:
        """A study of a small sample, for a first look."""

    @property
    def test_axes(self) -> Sequence[str | None]:
        """The axes along which the sample is compressed."""
        return (None,)

    @abstractmethod
    def lay_sample(self) -> Sample:
        """The sample before its relaxation."""

    def relaxation(self, laid: Sample) -> dict[str, Any]:
        """Options of :func:`lmgcpy.experiment.compaction.compact` that only some studies have."""
        return {}

    @property
    def wire_blocks(self) -> bool:
        """Whether the solver takes a wire as one block."""
        return True

    def solver_of_tests(self, tighter: float = 1.0) -> Solver:
        """The solver of the tests, its bounds divided by ``tighter``."""
        force = None if self.force_error is None else self.force_error / tighter
        bounds: dict[str, Any] = {"tolerance": self.tolerance / tighter, "force": force}
        options = {**bounds, "max_iterations": self.max_iterations, "wire_blocks": self.wire_blocks}
        if self.solver == "auto":
            return Auto(max_factorisations=FACTORISATIONS, **options)
        return AcceleratedGaussSeidel(momentum=MOMENTUM[self.DIMENSION], **options)

    def test(self, sample: Sample, planned: PlannedTest) -> Compression:
        """A planned test of the relaxed sample, ready to run."""
        return self.TEST(
            sample,
            LAWS[planned.law](self.axial_rigidity),
            axis=planned.axis,
            pressure=self.pressure,
            density=DENSITY,
            friction=self.friction,
            platen_friction=self.platen_friction,
            inertial_number=self.inertial_number,
            solver=self.solver_of_tests(planned.tighter),
            **self.of_wire,
        )

    @property
    def of_wire(self) -> dict[str, Any]:
        """Options of compactions and tests that only some wires have."""
        return {}

    @property
    def checks(self) -> list[PlannedTest]:
        """The tests that are made again at a tighter tolerance: those along the first axis."""
        strain = min(self.check_strain, self.strain)
        first = self.test_axes[0]
        return [PlannedTest(law, first, strain, 0, self.TIGHTER) for law in self.laws] if strain > 0.0 else []

    @property
    def planned(self) -> list[PlannedTest]:
        """The tests, law by law."""
        return [PlannedTest(law, axis, self.strain, self.FRAMES) for law in self.laws for axis in self.test_axes]

    # ------------------------------------------------------------------------------------------- what the engine asks for

    def lay(self, site: Site) -> Sample:
        with site.stage("sample: wire laid, grains deposited", 1) as tick:
            laid = self.lay_sample()
            tick(1)
        return laid

    def compaction(self, laid: Sample) -> dict[str, Any]:
        """All options of :func:`lmgcpy.experiment.compaction.compact` for the laid sample."""
        options = {"pressure": self.pressure, "density": DENSITY, "max_steps": RELAXATION_STEPS, **self.relaxation(laid)}
        return options | ({"friction": self.friction, **self.of_wire} if self.preparation == "loose" else {})

    def prepare(self, laid: Sample, site: Site) -> Compaction:
        options = self.compaction(laid)
        return site.run("compaction", "relaxation to the pressure", options["max_steps"], compact, laid, **options)

    def tests(self, prepared: Compaction, done: Mapping[str, Any]) -> list[Task]:
        # the longest first, so that no thread waits for the last: rods before wires before sand, then the checks
        tests = [*sorted(self.planned, key=_shortness), *sorted(self.checks, key=_shortness)]
        return [] if done else [Task(test.name, _compress, (self, prepared.sample, test)) for test in tests]

    def result(self, prepared: Compaction, done: Mapping[str, Any]) -> TexSolResult:
        records = {test.name: done[test.name] for test in self.planned}
        return TexSolResult(
            self, prepared, records, {test.name.removesuffix("-tight"): done[test.name] for test in self.checks}
        )

    def expected_seconds(self) -> float:
        # a test to a strain takes strain / (0.2 I) steps, I the inertial number: the velocity is I H/t, the step t/5
        strain = sum(test.strain for test in [*self.planned, *self.checks]) + RELAXATION_COST * 0.1
        steps = strain / (0.2 * self.inertial_number)
        return steps * (self.grain_count + self.bead_count) * PER_PARTICLE_AND_STEP[self.DIMENSION]

    def measures(self, result: TexSolResult) -> tuple[dict[str, float], dict[str, dict[str, np.ndarray]]]:
        return measures(result)


def _shortness(test: PlannedTest) -> tuple[bool, bool]:
    return "rod" not in test.law, "wire" not in test.law


def _compress(site: Site, study: TexSolStudy, sample: Sample, planned: PlannedTest) -> Any:
    """A test of the study, carried out."""
    test = study.test(sample, planned)
    label = test.NAME if planned.axis is None else f"{test.NAME} along {planned.axis}"
    label += f", {planned.law}" + (f", tolerance / {planned.tighter:g}" if planned.tighter > 1.0 else "")
    steps = test.step_count(planned.strain)
    options = {"frames": planned.frames, "greatest_reaction": study.greatest_reaction}
    return site.run(planned.name, label, steps, test.run, planned.strain, **options)


@named_arguments
@dataclass(frozen=True)
class Study2D(TexSolStudy):
    """A study in 2D. The defaults are the paper's sample: 2000 particles, of which 300 are wire beads.

    Other fields as in :class:`TexSolStudy`.
    """

    DIMENSION: ClassVar[int] = 2
    TEST: ClassVar[type[Compression]] = Biaxial
    FRAMES: ClassVar[int] = 100
    TIGHTER: ClassVar[float] = 10.0
    FORMER: ClassVar[Mapping[str, Any]] = {**TexSolStudy.FORMER, "theta_max": 0.6}

    def quick(self) -> Study2D:
        """A study of a small dense sample, for a first look: 360 particles, 5 % crushing. The rigid wire adds 12 to 42 % to
        the late reaction with seeds 0 to 4, resolved in each."""
        return replace(self, grain_count=280, bead_count=80, preparation="dense", strain=0.05)

    def lay_sample(self) -> Sample:
        return lay_sample(self.grain_count, self.bead_count, theta_max=self.theta_max, seed=self.seed)

    def report(self, result: TexSolResult, folder: StudyFolder) -> list[Path]:
        from lmgcpy.experiment.texsol.report_2d import write_report

        return write_report(result, folder)


@named_arguments
@dataclass(frozen=True)
class Study3D(TexSolStudy):
    """A study in 3D. The defaults are a sample of 10 000 particles, of which 3500 are wire beads.

    ``axes``: axes along which the sample is compressed, with a test for each; "z" is across the layers of the wire, "x" and
    "y" are along them. ``slenderness``: height of the sample as laid over its width. ``wires``: number of wires that share
    the beads. ``wire``: "thread", a smooth surface of ``thread_diameter`` [m] (None: as thick as beads) along the course of
    the beads, with nodes at most ``node_distance`` mean diameters of a grain apart, or "beads", the paper's. ``dtex``: mass
    of the wire [g per 10 km]. ``wire_friction``: of a thread against grains and against itself; None: ``friction``.
    ``bead_mass`` in the tests with a wire: "own", the mass of a bead's or node's part of the wire, or "grain", the mass of
    a mean grain; None: "own" for a thread. Checks, none by default, are made along the first axis: with 10 000 particles
    their steps take thousands of sweeps. Other fields as in :class:`TexSolStudy`.
    """

    DIMENSION: ClassVar[int] = 3
    TEST: ClassVar[type[Compression]] = Triaxial
    FRAMES: ClassVar[int] = 20
    TIGHTER: ClassVar[float] = 3.0
    FORMER: ClassVar[Mapping[str, Any]] = {**TexSolStudy.FORMER, "theta_max": 0.1, **BEADS, "slenderness": 1.0}

    laws: tuple[str, ...] = ("none", "rigid-wire")
    grain_count: int = 6500
    bead_count: int = 3500
    theta_max: float = THETA_MAX_3D
    strain: float = 0.15
    solver: str = "accelerated"
    tolerance: float = 1e-2
    force_error: float | None = 2e-3  # the inertial number, see lmgcpy.experiment.box
    max_iterations: int = 2000
    inertial_number: float = 2e-3
    axial_rigidity: float = 120.0
    check_strain: float = 0.0
    axes: tuple[str, ...] = ("z", "x")
    slenderness: float = 1.0
    wires: int = 1
    wire: str = "beads"
    thread_diameter: float | None = None
    node_distance: float = 0.7
    dtex: float = THREAD
    wire_friction: tuple[float, float] | None = None
    bead_mass: str | None = None

    def __post_init__(self):
        rods = [law for law in self.laws if str(law).endswith("rod")] if isinstance(self.laws, (tuple, list)) else []
        if rods:
            raise ValueError(
                f"laws of the study in 3D cannot be '{rods[0]}': a chain of beads finer than the grains gives way sideways "
                "and is no column that could bear a push. Take rigid-wire or elastic-wire."
            )
        super().__post_init__()
        one_of(self.wire, "wire", WIRES)
        number(self.slenderness, "slenderness", minimum=0.1, maximum=10.0)
        number(self.node_distance, "node_distance", above=0.0)
        number(self.dtex, "dtex", above=0.0, unit="dtex")
        if self.thread_diameter is not None:
            number(self.thread_diameter, "thread_diameter", above=0.0, unit="m")
        if self.bead_mass is not None:
            one_of(self.bead_mass, "bead_mass", BEAD_MASSES)
        wire_frictions(self.wire_friction)
        usual = {field.name: field.default for field in fields(Study3D)}
        threads = ("thread_diameter", "wire_friction", "node_distance")
        strange = [name for name in threads if getattr(self, name) != usual[name]]
        if self.dtex != usual["dtex"] and not self.has_own_mass:
            raise ValueError(
                "dtex is the mass of a wire's own beads or nodes, and bead_mass of this study is "
                f"{self.bead_mass or 'grain'!r}: give bead_mass='own' (--bead-mass own), or leave dtex out."
            )
        if self.wire == "beads" and strange:
            raise ValueError(
                f"{strange[0]} is of a thread, and the wire of this study has beads: give wire='thread' (--wire thread)."
            )
        self._check_names("axes", "axis", tuple(AXES))
        whole(self.wires, "wires", minimum=1)

    def quick(self) -> Study3D:
        """A study of a small dense sample with much wire, for a first look: 400 grains and 800 beads, 8 % crushing. Across
        the layers the rigid wire adds 36, 56 and 25 % to the late deviator with seeds 0, 1 and 2."""
        return replace(self, grain_count=400, bead_count=800, preparation="dense", strain=0.08)

    @property
    def has_own_mass(self) -> bool:
        """Whether beads or nodes have the mass of their part of the wire in the tests."""
        return self.wire == "thread" if self.bead_mass is None else self.bead_mass == "own"

    @property
    def wire_blocks(self) -> bool:
        """Whether wires are solved as blocks. Grains hold heavy beads one by one: with blocks the number of sweeps is the
        same as with single links, and a sweep takes 1.5 times as long."""
        return self.has_own_mass

    @property
    def of_wire(self) -> dict[str, Any]:
        return {"wire_friction": self.wire_friction} if self.wire == "thread" else {}

    @property
    def test_axes(self) -> Sequence[str]:
        return self.axes

    def lay_sample(self) -> Sample:
        return lay_sample_3d(
            self.grain_count,
            self.bead_count,
            slenderness=self.slenderness,
            wires=self.wires,
            theta_max=self.theta_max,
            density=DENSITY,
            seed=self.seed,
            thread=self.wire == "thread",
            thread_diameter=self.thread_diameter,
            node_distance=self.node_distance,
        )

    def test(self, sample: Sample, planned: PlannedTest) -> Compression:
        """A planned test of the sample, which was relaxed with heavy beads: grains on their way to rest would
        fling light beads about, and the wire would crumple."""
        if self.has_own_mass and sample.wires and planned.law != "none":
            own = mass_of_a_bead(linear_density_dtex=self.dtex, spacing=sample.wire_length / sample.bead_count)
            sample = replace(sample, bead_mass=own)
        return super().test(sample, planned)

    def relaxation(self, laid: Sample) -> dict[str, Any]:
        """The steps are short, as beads are small and move fast; a drag keeps the wire from being crumpled.

        An error of force of 5e-3 is a quarter of the mean resultant force of a sample at rest, and asks the same of all
        sizes; a residual of 1e-3 is beyond the sweeps of most steps of 6500 grains. With friction 10 000 particles want the
        momentum of the tests, and not the solver's own.
        """
        step = RELAXATION_STEP_3D * characteristic_time(laid.diameter, DENSITY, self.pressure)
        momentum = MOMENTUM[3] if self.preparation == "loose" else AcceleratedGaussSeidel.momentum
        solver = AcceleratedGaussSeidel(
            tolerance=1e-2, force=5e-3, max_iterations=2000, wire_blocks=False, momentum=momentum
        )
        return {"time_step": step, "drag": 2.0, "solver": solver, "max_steps": 1500}

    def report(self, result: TexSolResult, folder: StudyFolder) -> list[Path]:
        from lmgcpy.experiment.texsol.report_3d import write_report

        return write_report(result, folder)


STUDIES: dict[int, Any] = {kind.DIMENSION: kind for kind in (Study2D, Study3D)}
"""The studies by dimension."""
