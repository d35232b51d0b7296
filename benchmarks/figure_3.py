"""Figure 3 of the paper over many samples: the support reaction of sand, wire and rods, and when rods form columns.

The default 2D study is carried out for one seed after the other, each in a folder of its own below the given one; what is
there already is only read, and an interrupted study goes on. Reactions are in units of pressure x width at the start, so
that samples compare. A column is what `lmgcpy texsol` calls one: the rods' mean reaction exceeds twice the wire's for 0.5 %
of crushing on end.

    python benchmarks/figure_3.py FOLDER [number of seeds, 8] [loose or dense]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from table import RESULTS, report

from lmgcpy.experiment import BiaxialRecord, Study2D, StudyFolder, carry_out_study
from lmgcpy.experiment.study.stages import Stages
from lmgcpy.experiment.texsol.conclusions import column
from lmgcpy.experiment.texsol.result import TexSolResult
from lmgcpy.experiment.texsol.study import TexSolStudy
from lmgcpy.view.drawing import CURVES
from lmgcpy.view.figures import name_of, new_figure, save

STRAINS = (0.002, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.10)
CHECKED, CHECK_STRAIN = 3, 0.03
"""Number of seeds whose tests are made again at a tighter tolerance, and up to which crushing."""


@dataclass(frozen=True)
class Curve:
    """A test's mean reaction over pressure x width, at evenly spaced crushing."""

    strain: np.ndarray
    reaction: np.ndarray


def curve(record: BiaxialRecord, study: Study2D, width: float) -> Curve:
    strain = np.linspace(0.0, study.strain, 501)[1:]
    mean = record.smooth(record.reaction) / (study.pressure * width)
    return Curve(strain, np.interp(strain, record.strain, mean))


def study_of(seed: int, preparation: str, folder: Path) -> TexSolResult:
    """The study of one seed, carried out or read."""
    study = Study2D(seed=seed, preparation=preparation, check_strain=CHECK_STRAIN if seed < CHECKED else 0.0)
    place = StudyFolder(folder / f"{preparation}-{seed}", TexSolStudy)
    there = place.study_file.exists()
    study = place.read() if there else study
    result = carry_out_study(study, Stages(), place, resume=there)
    study.report(result, place)
    return result


def summary_rows(curves: dict[str, list[Curve]]) -> list[list]:
    """Mean and standard deviation over the samples, by law and crushing."""
    rows = []
    for law, of_law in curves.items():
        for strain in STRAINS:
            at = np.array(
                [np.interp(strain, one.strain, one.reaction) for one in of_law if strain <= one.strain[-1] + 1e-9]
            )
            if len(at):
                spread = at.std(ddof=1) if len(at) > 1 else 0.0
                rows.append(
                    [law, f"{100 * strain:g}", f"{at.mean():.3f}", f"{spread:.3f}", f"{at.min():.3f}", f"{at.max():.3f}"]
                )
    return rows


def column_rows(results: dict[int, TexSolResult]) -> list[list]:
    """Of each sample: where its rods leave the wire, by how much they exceed it at most, and how well it was solved."""
    rows = []
    for seed, result in results.items():
        rod, wire = result.records["rigid-rod"], result.records["rigid-wire"]
        where, ratio = column(rod, wire)
        until = np.inf if where is None else where
        before = np.array([status == "converged" for status in rod.status])[rod.strain < until]
        rows.append(
            [
                seed,
                "no" if where is None else f"{100 * where:.1f}",
                f"{ratio:.1f}",
                f"{100 * before.mean():.1f}",
                *(f"{100 * (1 - record.unconverged / len(record.strain)):.1f}" for record in result.records.values()),
                f"{result.compaction.solid_fraction:.4f}",
                f"{result.seconds:.0f}",
            ]
        )
    return rows


def change_rows(results: dict[int, TexSolResult]) -> list[list]:
    """Change of the mean over the checked samples at the tighter tolerance: the paths of single samples part."""
    checked = {seed: result for seed, result in results.items() if result.checks}
    rows = []
    for law in next(iter(results.values())).records:
        apart, single = [], []
        for strain in STRAINS:
            if all(strain <= result.checks[law].strain[-1] for result in checked.values()):
                ours, theirs = (
                    np.array([np.interp(strain, run.strain, run.smooth(run.reaction, 0.005)) for run in runs])
                    for runs in (
                        [result.records[law] for result in checked.values()],
                        [result.checks[law] for result in checked.values()],
                    )
                )
                apart.append(abs(ours.mean() / theirs.mean() - 1.0))
                single.append(np.abs(ours / theirs - 1.0).mean())
        solved = np.mean(
            [1 - result.checks[law].unconverged / len(result.checks[law].strain) for result in checked.values()]
        )
        rows.append(
            [law, len(checked), f"{100 * np.mean(apart):.1f}", f"{100 * np.mean(single):.1f}", f"{100 * solved:.0f}"]
        )
    return rows


def main(folder: Path, seeds: int, preparation: str) -> None:
    results = {seed: study_of(seed, preparation, folder) for seed in range(seeds)}
    curves: dict[str, list[Curve]] = {}
    for result in results.values():
        for law, record in result.records.items():
            curves.setdefault(law, []).append(curve(record, result.study, result.sample.width))
    ending = "" if preparation == "loose" else f"_{preparation}"
    report(f"figure_3{ending}", ["law", "crushing [%]", "mean", "deviation", "least", "greatest"], summary_rows(curves))
    report(
        f"figure_3{ending}_columns",
        ["seed", "column at [%]", "rod / wire at most", "rod solved before [%]", "sand solved [%]", "wire solved [%]",
         "rod solved [%]", "solid fraction", "seconds"],
        column_rows(results),
    )  # fmt: skip
    if any(result.checks for result in results.values()):
        header = ["law", "samples", "change of the mean [%]", "mean change of a sample [%]", "steps solved there [%]"]
        report(f"figure_3{ending}_tolerance", header, change_rows(results))

    figure = new_figure(11.0)
    one, all_ = figure.subplots(1, 2, sharey=True)
    for law, of_law in curves.items():
        percent = 100.0 * of_law[0].strain
        values = np.array([run.reaction for run in of_law])
        one.plot(percent, values[0], color=CURVES[law], label=name_of(law))
        all_.plot(percent, np.median(values, axis=0), color=CURVES[law], label=f"{name_of(law)}, median")
        all_.fill_between(percent, values.min(axis=0), values.max(axis=0), color=CURVES[law], alpha=0.2, linewidth=0)
        all_.plot(percent, values.T, color=CURVES[law], linewidth=0.3)
    one.set_title("one sample", fontsize="medium")
    all_.set_title(f"{seeds} samples, each and the band that they fill", fontsize="medium")
    for axes in (one, all_):
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(0.0, percent[-1])
    one.set_ylabel("support reaction / (pressure x width)")
    top = max(float(run.reaction.max()) for of_law in curves.values() for run in of_law)
    if top > 12.0:
        one.set_yscale("log")
    else:
        one.set_ylim(0.0, 1.05 * top)
    all_.legend(frameon=False, fontsize="small", loc="upper left")
    save(figure, RESULTS / f"figure_3{ending}.png")


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 4:
        sys.exit("python benchmarks/figure_3.py FOLDER [number of seeds, 8] [loose or dense]")
    main(Path(sys.argv[1]), int((sys.argv[2:] or ["8"])[0]), (sys.argv[3:] or ["loose"])[0])
