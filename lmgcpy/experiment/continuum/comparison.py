"""The comparison of several folders of one study, such as those of its seeds.

For the prediction of a folder, the anchorage of the wire is measured in the other folders; a single folder uses its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from lmgcpy.experiment.continuum.prediction import Prediction, predict
from lmgcpy.experiment.continuum.wire import Anchorage, LaidWire, mean_anchorage, measured_anchorage
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.result import TexSolResult
from lmgcpy.experiment.texsol.study import TexSolStudy
from lmgcpy.io.run import open_run

UNILATERAL = ("elastic-wire", "rigid-wire")
"""Laws of the wire that the continuous model knows: it only pulls. The elastic one is the first to be measured."""


@dataclass(frozen=True)
class Comparison:
    """Predictions of the continuous model for a study, with its runs."""

    studies: list[Any]
    """The study of each folder."""
    measured_in: str
    """Name of the test in which the anchorage of the wire was measured."""
    anchorages: list[Anchorage]
    """The anchorage measured in this test, for each folder."""
    used: list[Anchorage]
    """The anchorage used in the predictions of each folder: the mean of the others, or its own if it is the only one."""
    predictions: dict[str, list[Prediction]]
    """By the name of the test, a prediction for each folder."""
    diameters: list[float]
    """Mean diameter of the grains of each sample [m]."""
    wires: list[LaidWire]
    """The wires at the start of the tests."""

    def __repr__(self) -> str:
        return f"<Comparison of {len(self.studies)} studies: {', '.join(self.predictions)}>"


def compare(folders: Sequence[Path], tell: Callable[[str], None] = lambda text: None) -> Comparison:
    """Fit, measure and predict; ``tell`` is called with a line on each action.

    Raises FileNotFoundError if a folder holds no TexSol study or lacks a run. Raises ValueError if studies differ in more
    than their seed or have the same seed, if a run is not complete, or if tests without a wire or with one are missing.
    """
    results: list[TexSolResult] = []
    runs: list[StudyFolder] = []
    for path in folders:
        folder = StudyFolder(path, TexSolStudy)
        study = folder.read()
        check_runs(folder, study)
        if results:
            _check_same(study, results[0].study, path)
        if study.seed in [result.study.seed for result in results]:
            raise ValueError(
                f"The seed {study.seed} of '{path}' is there already: a sample cannot be predicted from itself."
            )
        tell(f"{path}: reading the tests")
        results.append(carry_out_study(study, None, folder, resume=True))
        runs.append(folder)
    tests = [name for name, record in results[0].records.items() if record.law in UNILATERAL]
    source = min(tests, key=lambda name: (UNILATERAL.index(results[0].records[name].law), tests.index(name)))
    anchorages = []
    for result, folder in zip(results, runs, strict=True):
        with open_run(folder.run_file(source)) as run:
            anchorages.append(measured_anchorage(run, result.records[source]))
    used = [mean_anchorage(anchorages[:k] + anchorages[k + 1 :] or anchorages) for k in range(len(anchorages))]
    predictions: dict[str, list[Prediction]] = {}
    for name in tests:
        tell(f"{name}: predicting")
        predictions[name] = [predict(result, name, held) for result, held in zip(results, used, strict=True)]
    return Comparison(
        studies=[result.study for result in results],
        measured_in=source,
        anchorages=anchorages,
        used=used,
        predictions=predictions,
        diameters=[result.sample.diameter for result in results],
        wires=[LaidWire.of(result.sample) for result in results],
    )


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


def _check_same(study: Any, first: Any, path: Path) -> None:
    """Raise ValueError if a study differs from the first in more than its seed and its threads."""
    mine, theirs = asdict(study), asdict(first)
    other = [name for name in mine if name not in ("seed", "threads") and mine[name] != theirs.get(name)]
    if type(study) is not type(first) or other:
        raise ValueError(
            f"The study in '{path}' differs from the first in {', '.join(other) or 'its dimension'}: compare studies that "
            "differ in their seed only."
        )
