"""Predictions of the tests with a wire: the sand is fitted to the test without one, and nothing else is fitted.

Everything is compared over the logarithmic crushing of the sample. The rigid wire is the limit of an elastic one: its axial
rigidity is :data:`RIGID` times the rigidity with which ``p d^(D-1)`` would double its length.

Several folders of one study, one for each seed, are compared together. For the prediction of a folder, the anchorage of the
wire, and by how much the sand around it gains in friction, are measured in the other folders; a single folder uses its own.
Or they are measured in samples of another size or content.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.continuum import (
    DruckerPrager,
    MeasuredCompression,
    MohrCoulomb,
    NoSolution,
    Sand,
    TexSol,
    WireNetwork,
    biaxial,
    fit_sand,
    triaxial,
)
from lmgcpy.continuum.sand import STEEPEST
from lmgcpy.errors import AXES
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.continuum.wire import Anchorage, LaidWire, mean_anchorage, measured_anchorage
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.result import TexSolResult
from lmgcpy.experiment.texsol.study import TexSolStudy
from lmgcpy.io.run import open_run

INCREMENTS = 150
"""Increments of a path."""
RIGID = 1e4
"""Axial rigidity of the limit of a rigid wire, in units of p d^(D-1). (Ten times as much changes the deviator of an
anchored wire by less than 1 % in the mean: tests/experiment/continuum.)"""
FIRST = 0.1
"""Part of a test that is not judged: rigid grains start with a jump."""

OF_ONE_STUDY = ("seed", "threads")
"""Fields of a study that its samples may differ in."""
OF_ANOTHER_SIZE = (*OF_ONE_STUDY, "grain_count", "bead_count", "slenderness", "laws", "axes")
"""Fields in which a study may differ from one in which the anchorage was measured."""
UNILATERAL = ("elastic-wire", "rigid-wire")
"""Laws of the wire that the continuous model knows: it only pulls. The elastic one is the first to be measured."""


@dataclass(frozen=True)
class Curves:
    """A compression over the crushing, in s moments and d dimensions."""

    crushing: np.ndarray
    """Logarithmic, (s,)."""
    deviator: np.ndarray
    """[Pa], (s,)."""
    volume: np.ndarray
    """Logarithmic change of volume, dilation positive, (s,)."""
    wire: np.ndarray
    """Normal components of the wire's part of the stress, traction positive [Pa], (s, d)."""

    def at(self, crushing: np.ndarray) -> Curves:
        """The curves at other moments, NaN beyond the end."""

        def between(values: np.ndarray) -> np.ndarray:
            return np.interp(crushing, self.crushing, values, right=np.nan)

        wire = np.stack([between(column) for column in self.wire.T], axis=1)
        return Curves(crushing, between(self.deviator), between(self.volume), wire)


def no_curves(dimension: int) -> Curves:
    """Curves of a model without a solution."""
    none = np.zeros(1)
    return Curves(none, none, none, np.zeros((1, dimension)))


@dataclass(frozen=True)
class Prediction:
    """A test with a wire, and what two models say of it."""

    axis: str
    """Axis of the compression."""
    law: str
    seed: int
    run: Curves
    sand: Curves
    """The test without a wire."""
    local: Curves
    """The local model: every link follows the mean strain."""
    anchored: Curves
    """Spans that share a tension and slip."""
    stronger: Curves
    """As before, in sand whose friction is larger by a measured factor: see :func:`stronger`."""
    coulomb: Curves | None = None
    """As before, in sand after Mohr and Coulomb; None in 2D, as Drucker and Prager's sand is of this kind there."""

    def judged(self) -> np.ndarray:
        """The moments at which the models are judged, (s,)."""
        return np.linspace(FIRST * self.run.crushing[-1], 0.99 * self.run.crushing[-1], INCREMENTS)


@dataclass(frozen=True)
class Miss:
    """Mean distance of a model from a run."""

    deviator: float
    """Relative to the mean deviator of the run."""
    volume: float
    """Change of volume."""
    wire: np.ndarray
    """Normal components of the wire's part of the stress [Pa], (d,)."""


def miss(prediction: Prediction, model: Curves) -> Miss:
    """Mean distance of a model from the run over the judged moments; infinite if the model ended before them."""
    moments = prediction.judged()
    ours, theirs = model.at(moments), prediction.run.at(moments)
    if np.isnan(ours.deviator).any():
        return Miss(np.inf, np.inf, np.full(ours.wire.shape[1], np.inf))
    return Miss(
        float(np.abs(ours.deviator - theirs.deviator).mean() / theirs.deviator.mean()),
        float(np.abs(ours.volume - theirs.volume).mean()),
        np.abs(ours.wire - theirs.wire).mean(axis=0),
    )


def measured_compression(record: Any, sample: Sample) -> MeasuredCompression:
    """The record of a biaxial or triaxial test as the continuous model takes it."""
    k = AXES.index(record.axis)
    stress = np.empty_like(record.size)
    stress[:, k] = -(record.deviator + record.lateral_pressure)
    others = [j for j in range(sample.dimension) if j != k]
    stress[:, others] = -record.lateral if sample.dimension == 3 else -record.lateral_pressure[:, None]
    return MeasuredCompression(axis=record.axis, strain=np.log(record.size / sample.box), stress=stress)


def curves_of(record: Any, sample: Sample) -> Curves:
    """Running means of a record."""
    strain = np.log(record.size / sample.box)
    wire = record.smooth(np.diagonal(record.stress["wire"], axis1=1, axis2=2))
    crushing = -strain[:, AXES.index(record.axis)]
    return Curves(crushing, record.smooth(record.deviator), record.smooth(strain.sum(axis=1)), wire)


def driven(sand: Sand, wire: WireNetwork | None, axis: str, crushing: float, pressure: float) -> Curves:
    """The test predicted by the model up to a crushing, or as far as the model has a solution."""
    material = TexSol(sand, wire)
    test = biaxial if material.dimension == 2 else triaxial
    strain = -np.linspace(0.0, crushing, INCREMENTS + 1)[1:]
    try:
        path = test(material, strain, pressure=pressure, axis=axis)
    except NoSolution as error:
        if not error.solved:
            return no_curves(material.dimension)
        path = test(material, strain[: error.solved], pressure=pressure, axis=axis)
    d = material.dimension
    return Curves(-path.axial_strain, path.deviator, path.volume_change, path.wire[:, :d])


def axial_rigidity_of(law: str, study: Any, sample: Sample) -> float:
    """EA of the wire of a test [N]."""
    if law.startswith("elastic"):
        return float(study.axial_rigidity)
    return RIGID * float(study.pressure) * sample.diameter ** (sample.dimension - 1)


def friction_gain(result: Any, name: str) -> float:
    """By how much the sand of a test with a wire is stronger than in the test without: the ratio of both q/p, mean over
    the judged part. p and q are of the contacts, without the wire's part of the stress."""
    ratios = []
    crushing = np.linspace(FIRST, 0.99, INCREMENTS) * -np.log(result.records[name].size / result.sample.box).min()
    for test in (name, _bare(result, name)):
        record = result.records[test]
        k = AXES.index(record.axis)
        normal = record.smooth(np.diagonal(record.stress["sand"], axis1=1, axis2=2))
        deviator = np.delete(normal, k, axis=1).mean(axis=1) - normal[:, k]
        along = -np.log(record.size[:, k] / result.sample.box[k])
        ratios.append(np.interp(crushing, along, -deviator / normal.mean(axis=1)).mean())
    return ratios[0] / ratios[1]


def stronger(sand: DruckerPrager, gain: float) -> DruckerPrager | None:
    """The sand with ``gain`` times its friction, which spends all that it gains on dilation, by Taylor's rule:
    ``M' = gain M`` and ``D' = D + M' - M``, so that the work lost in a shear stays what it was. D' is
    ``beta' (M' - M_d')`` with ``beta' = (beta + gain - 1)/gain`` and ``M_d' = M_d beta/beta'``. None if such sand would
    carry a deviator without lateral pressure."""
    if gain * (sand.critical + sand.peak) >= STEEPEST[sand.dimension]:
        return None
    dilation = max((sand.dilation + gain - 1.0) / gain, 0.0)
    turning = sand.turning * sand.dilation / dilation if dilation > 0.0 else sand.turning
    return replace(sand, critical=gain * sand.critical, peak=gain * sand.peak, dilation=dilation, turning=turning)


def _numbers_of(sand: DruckerPrager) -> dict[str, Any]:
    return {item.name: getattr(sand, item.name) for item in fields(sand) if item.init}


def _bare(result: Any, name: str) -> str:
    """The test without a wire along the same axis."""
    return name.replace(result.records[name].law, "none", 1)


def predict(result: Any, name: str, held: Anchorage, gain: float) -> Prediction:
    """The prediction of the test ``name`` in the result of a TexSol study: a sand of rigid grains is fitted to the test
    without a wire along the same axis. ``gain``: factor of its friction in the stronger sand."""
    study, sample, record = result.study, result.sample, result.records[name]
    bare = result.records[_bare(result, name)]
    sand = fit_sand(measured_compression(bare, sample), bulk_modulus=math.inf, shear_modulus=math.inf).sand()
    strong = stronger(sand, gain)
    run, laid = curves_of(record, sample), LaidWire.of(sample)
    rigidity = axial_rigidity_of(record.law, study, sample)
    anchored = laid.anchored(rigidity, held)

    def model(sand: Sand | None, wire: WireNetwork) -> Curves:
        if sand is None:
            return no_curves(sample.dimension)
        return driven(sand, wire, record.axis, float(run.crushing[-1]), study.pressure)

    models = [model(sand, laid.local(rigidity)), model(sand, anchored), model(strong, anchored)]
    if sand.dimension == 3:
        models.append(model(strong and MohrCoulomb(**_numbers_of(strong)), anchored))
    return Prediction(record.axis, record.law, study.seed, run, curves_of(bare, sample), *models)


def mean_curves(many: Sequence[Curves]) -> tuple[Curves, Curves]:
    """Mean and standard deviation of several at the moments of the shortest."""
    last = min(float(one.crushing[-1]) for one in many)
    moments = np.linspace(0.0, last, INCREMENTS)
    there = [one.at(moments) for one in many]
    spread = int(len(many) > 1)

    def parts(of: Any, **options: Any) -> list[np.ndarray]:
        return [of([getattr(one, name) for one in there], axis=0, **options) for name in ("deviator", "volume", "wire")]

    scatter = parts(np.std, ddof=spread) if spread else [0.0 * part for part in parts(np.mean)]
    return Curves(moments, *parts(np.mean)), Curves(moments, *scatter)


@dataclass(frozen=True)
class Comparison:
    """Predictions of the continuous model for a study, with its runs."""

    studies: list[Any]
    """The study of each folder."""
    measured_in: str
    """Name of the test in which the anchorage of the wire was measured."""
    anchorages: list[Anchorage]
    """The anchorage measured in this test, for each folder."""
    gains: dict[str, list[float]]
    """By the name of the test, the gain in friction of the sand in each folder: see :func:`friction_gain`."""
    predictions: dict[str, list[Prediction]]
    """By the name of the test, a prediction for each folder."""
    diameters: list[float]
    """Mean diameter of the grains of each sample [m]."""
    wires: list[LaidWire]
    """The wires at the start of the tests."""
    source: Comparison | None = None
    """The samples in which anchorage and gains were measured; None: each time in the others of these."""

    @property
    def content(self) -> float:
        """Length of wire by the square of the grain diameter over the volume; in 2D by the diameter, over the area."""
        power = self.wires[0].direction.shape[1] - 1
        return float(np.mean([wire.content for wire in self.wires]) * np.mean(self.diameters) ** power)

    def for_sample(self, k: int, name: str) -> tuple[Anchorage, float]:
        """What the prediction of the test ``name`` of sample ``k`` takes: the anchorage, and the gain in friction of the
        sand, from the source or from the other samples; from its own test if there is no other."""
        at = self.source or self
        there = [i for i in range(len(at.studies)) if at is not self or i != k] or [k]
        gain = float(np.mean([at.gains[name][i] for i in there]))
        held = mean_anchorage([at.anchorages[i] for i in there])
        return held, 1.0 + self.content / at.content * (gain - 1.0)

    def __repr__(self) -> str:
        return f"<Comparison of {len(self.studies)} studies: {', '.join(self.predictions)}>"


def compare(
    folders: Sequence[Path], tell: Callable[[str], None] = lambda text: None, source: Comparison | None = None
) -> Comparison:
    """Fit, measure and predict; ``tell`` is called with a line on each action.

    ``source``: samples of another size or content, in which anchorage and gains were measured. The anchorage is taken to
    the width of each sample, see :meth:`Anchorage.at`, and the gain less one goes with the content of wire.

    Raises FileNotFoundError if a folder holds no TexSol study or lacks a run. Raises ValueError if studies differ in more
    than their seed or have the same seed, if a run is not complete, if tests without a wire or with one are missing, or if
    the source differs in more than seeds, size and content, or lacks a test.
    """
    results: list[TexSolResult] = []
    runs: list[StudyFolder] = []
    elsewhere = [] if source is None else source.studies
    for path in folders:
        folder = StudyFolder(path, TexSolStudy)
        study = folder.read()
        check_runs(folder, study)
        if results:
            _check_same(study, results[0].study, path, OF_ONE_STUDY, "compare studies that differ in their seed only")
        if _sample_of(study) in [_sample_of(other) for other in (*(result.study for result in results), *elsewhere)]:
            raise ValueError(
                f"The seed {study.seed} of '{path}' is there already: a sample cannot be predicted from itself."
            )
        tell(f"{path}: reading the tests")
        results.append(carry_out_study(study, None, folder, resume=True))
        runs.append(folder)
    tests = [name for name, record in results[0].records.items() if record.law in UNILATERAL]
    measured_in = min(tests, key=lambda name: (UNILATERAL.index(results[0].records[name].law), tests.index(name)))
    anchorages = []
    for result, folder in zip(results, runs, strict=True):
        record = result.records[measured_in]
        rigidity = axial_rigidity_of(record.law, result.study, result.sample)
        with open_run(folder.run_file(measured_in)) as run:
            anchorages.append(measured_anchorage(run, record, result.sample, rigidity))
    if source is not None:
        _check_source(source, results[0].study, tests, folders[0])
    found = Comparison(
        studies=[result.study for result in results],
        measured_in=measured_in,
        anchorages=anchorages,
        gains={name: [friction_gain(result, name) for result in results] for name in tests},
        predictions={},
        diameters=[result.sample.diameter for result in results],
        wires=[LaidWire.of(result.sample) for result in results],
        source=source,
    )
    for name in tests:
        tell(f"{name}: predicting")
        found.predictions[name] = [predict(result, name, *found.for_sample(k, name)) for k, result in enumerate(results)]
    return found


def check_runs(folder: StudyFolder, study: Any) -> None:
    """Raise FileNotFoundError or ValueError unless the study has tests with and without a wire, all carried out."""
    laws = set(study.laws)
    if "none" not in laws or not laws & set(UNILATERAL):
        raise ValueError(
            f"The study in '{folder.path}' has the laws {', '.join(study.laws)}: the model is fitted to 'none', the sand, "
            f"and predicts {' or '.join(UNILATERAL)}. Make one by lmgcpy texsol --laws none,elastic-wire,rigid-wire."
        )
    for name in ["compaction", *(test.name for test in [*study.planned, *study.checks])]:
        file = folder.run_file(name)
        if not file.exists():
            raise FileNotFoundError(
                f"The study in '{folder.path}' is not complete, '{file}' is missing: go on with it by "
                "lmgcpy texsol --resume."
            )
        with open_run(file) as run:
            if not run.closed:
                raise ValueError(
                    f"The run '{file}' is not complete: wait for its end, or go on with it by lmgcpy texsol --resume."
                )


def _sample_of(study: Any) -> dict[str, Any]:
    """The fields of a study that make its sample and tests."""
    return {name: value for name, value in asdict(study).items() if name != "threads"}


def _check_same(study: Any, first: Any, path: Path, free: tuple[str, ...], advice: str) -> None:
    """Raise ValueError if a study differs from the first in more than the ``free`` fields."""
    mine, theirs = asdict(study), asdict(first)
    other = [name for name in mine if name not in free and mine[name] != theirs.get(name)]
    if type(study) is not type(first) or other:
        what = ", ".join(other) or "its dimension"
        raise ValueError(f"The study in '{path}' differs from the first in {what}: {advice}.")


def _check_source(source: Comparison, study: Any, tests: list[str], path: Path) -> None:
    """Raise ValueError if what was measured in the source says nothing of these tests."""
    advice = "measure in studies that differ from it in seed, size and content only"
    first = source.studies[0]
    _check_same(study, first, path, OF_ANOTHER_SIZE, advice)
    if lacking := [name for name in tests if name not in source.gains]:
        raise ValueError(
            f"The study in '{path}' has the test {lacking[0]}, and the studies to measure in have "
            f"{', '.join(source.gains)}: {advice}."
        )
