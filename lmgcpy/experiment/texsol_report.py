"""What ``lmgcpy texsol`` writes: tables, figures and the summary of a study."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import lmgcpy.view.figures as figures
from lmgcpy.experiment.biaxial import BiaxialRecord
from lmgcpy.experiment.report_files import ReportFolder
from lmgcpy.experiment.texsol_2d import column, compression_in_links, stiffening
from lmgcpy.experiment.texsol_pictures import draw_flat_pictures
from lmgcpy.experiment.texsol_tests import Result, deviation, versions

NEAR_ZERO = 0.2
"""A principal stress below this part of the other counts as near zero."""


def write_report(result: Result, out: Path) -> list[Path]:
    """Write everything into the folder ``out``, which is made; returns the files."""
    report = ReportFolder(out)
    records = list(result.records.values())
    wires = [record for record in records if record.law != "none"]
    report.table("reaction.csv", *_reaction_table(records))
    report.figure("reaction.png", figures.reaction_figure(records))
    report.table("stress.csv", *_stress_table(records))
    shown = next((record for record in wires if record.law == "rigid-wire"), wires[0] if wires else None)
    if shown is not None:
        report.figure("stress.png", figures.stress_figure(shown))
    missing = draw_flat_pictures(result, report)
    report.text("summary.md", summary(result, missing))
    return report.written


def _reaction_table(records: list[BiaxialRecord]) -> tuple[list[str], list[list]]:
    header = [
        "law",
        "crushing [%]",
        "support reaction [N/m]",
        "mean support reaction [N/m]",
        "upper force [N/m]",
        "width [m]",
        "height [m]",
        "residual",
        "iterations",
    ]
    rows = []
    for record in records:
        mean = record.smooth(record.reaction)
        for k in range(len(record.strain)):
            rows.append(
                [
                    record.law,
                    f"{100 * record.strain[k]:.6f}",
                    f"{record.reaction[k]:.6g}",
                    f"{mean[k]:.6g}",
                    f"{record.top_force[k]:.6g}",
                    f"{record.size[k, 0]:.9g}",
                    f"{record.size[k, 1]:.9g}",
                    f"{record.residual[k]:.3e}",
                    int(record.iterations[k]),
                ]
            )
    return header, rows


def _stress_table(records: list[BiaxialRecord]) -> tuple[list[str], list[list]]:
    header = ["law", "crushing [%]"]
    for part in ("total", "sand", "wire"):
        header += [f"{part} greater [Pa]", f"{part} smaller [Pa]"]
        header += [f"{part} {component} [Pa]" for component in ("xx", "yy", "xy", "yx")]
    rows = []
    for record in records:
        principal = {part: figures.principal_series(record, part) for part in record.stress}
        for k in range(len(record.strain)):
            row = [record.law, f"{100 * record.strain[k]:.6f}"]
            for part in ("total", "sand", "wire"):
                sigma = record.stress[part][k]
                values = [*principal[part][k], sigma[0, 0], sigma[1, 1], sigma[0, 1], sigma[1, 0]]
                row += [f"{value:.6g}" for value in values]
            rows.append(row)
    return header, rows


# ----------------------------------------------------------------------------------------------------------- summary


def summary(result: Result, missing: str = "") -> str:
    """The study in words and numbers, as Markdown; ``missing``: why there are no pictures of the sample."""
    parts = [_sample_part(result), _stiffening_part(result), _column_part(result), _wire_stress_part(result)]
    parts += [_runs_part(result), _accuracy_part(result), missing]
    return "\n\n".join(["# TexSol in 2D: what the wire does to the sand", *filter(None, parts)]) + "\n"


def _sample_part(result: Result) -> str:
    study, relaxed, sample = result.study, result.compaction, result.sample
    rest = "at rest" if relaxed.at_rest else "NOT at rest"
    return (
        f"{len(sample.radii)} particles, {sample.bead_count} of them beads of one wire, seed {study.seed}, in "
        f"{sample.width:.3f} m x {sample.height:.3f} m, relaxed without friction to {1e-3 * study.pressure:g} kPa in "
        f"{relaxed.steps} steps ({rest}: loads balanced to {100 * relaxed.unrest.imbalance:.1f} %, deepest overlap "
        f"{relaxed.penetration:.1e} m). Solid fraction one coarsest diameter from the walls: "
        f"**{relaxed.solid_fraction:.3f}**. Test: friction {study.friction:g}, at the platens {study.platen_friction:g}, "
        f"{100 * study.strain:g} % of crushing, no gravity."
    )


def _stiffening_part(result: Result) -> str:
    sand = result.records.get("none")
    if sand is None:
        return ""
    lines = ["## By how much the wire stiffens the sand", ""]
    strains = [s for s in (0.005, 0.01, 0.02, 0.05, 0.10) if s <= result.study.strain + 1e-9]
    lines += ["Support reaction with the wire over that of the sand at equal crushing:", ""]
    lines += ["| law | " + " | ".join(f"{100 * s:g} %" for s in strains) + " |", "|---" * (len(strains) + 1) + "|"]
    for law, record in result.records.items():
        if law != "none":
            ratios = stiffening(record, sand, strains)
            lines.append(f"| {law} | " + " | ".join(f"{ratio:.2f}" for _, ratio in ratios) + " |")
    return "\n".join(lines)


def _column_part(result: Result) -> str:
    rods = [record for law, record in result.records.items() if law.endswith("rod")]
    wire = result.records.get("rigid-wire")
    if not rods:
        return ""
    lines = ["## Did the rods form a compression column?", ""]
    for rod in rods:
        share, at = compression_in_links(rod)
        text = (
            f"{rod.law}: compressed links carry up to {100 * share:.0f} % of the vertical load "
            f"(at {100 * at:.1f} % of crushing); those of a wire carry none."
        )
        if wire is not None:
            where, ratio = column(rod, wire)
            if where is None:
                text += f" **No**: the reaction does not exceed twice the rigid wire's; it is {ratio:.1f} times at most."
            else:
                text += (
                    f" **Yes**: from {100 * where:.1f} % of crushing on the reaction exceeds twice the rigid wire's, "
                    f"which has no such jump; at the most it is {ratio:.1f} times."
                )
        lines.append(text)
    return "\n".join(lines)


def _wire_stress_part(result: Result) -> str:
    lines = ["## The wire's part of the stress", ""]
    for law, record in result.records.items():
        if law == "none":
            continue
        values = figures.principal_series(record, "wire")
        total = figures.principal_series(record, "total")
        late = record.strain > 0.5 * record.strain[-1]
        greater, smaller = values[late].mean(axis=0)
        if greater <= 0.0:
            lines.append(f"* {law}: the wire bore no tension in the second half of the test.")
            continue
        ratio = smaller / greater
        one_sided = abs(ratio) < NEAR_ZERO
        verdict = "one tensile principal stress and one near zero" if one_sided else "not one tensile and one near zero"
        lines.append(
            f"* {law}, second half of the test: {1e-3 * greater:.1f} and {1e-3 * smaller:.1f} kPa (traction positive), the "
            f"second {ratio:.2f} times the first: **{verdict}** (near zero: below {NEAR_ZERO:g} times); "
            f"the whole sample bears {1e-3 * total[late, 0].mean():.1f} and {1e-3 * total[late, 1].mean():.1f} kPa."
        )
    return "\n".join(lines) if len(lines) > 2 else ""


def _runs_part(result: Result) -> str:
    lines = [
        "## The runs",
        "",
        "| law | steps | mean residual | worst residual | unconverged steps | iterations a step | inertial number | "
        "interactions | energy defect [J] | stress against walls | seconds |",
        "|---" * 11 + "|",
    ]
    for law, record in result.records.items():
        lines.append(
            f"| {law} | {len(record.strain)} | {record.residual.mean():.1e} | {record.residual.max():.1e} | "
            f"{record.unconverged} | {record.iterations.mean():.0f} | {record.inertial_number:.1e} | "
            f"{record.interactions.mean():.0f} | {np.abs(record.defect).max():.1e} | "
            f"{100 * boundary_mismatch(record):.2f} % | {record.seconds:.0f} |"
        )
    lines += ["", f"{result.seconds:.0f} s of steps in all, {result.study.threads} tests at once; {versions()}."]
    return "\n".join(lines)


def boundary_mismatch(record: BiaxialRecord) -> float:
    """Relative difference of the mean Weber stress and the mean forces on the walls over their area, the worse axis."""
    width, height = record.size[:, 0], record.size[:, 1]
    vertical = -(record.stress["total"][:, 1, 1] * width).mean()
    lateral = -(record.stress["total"][:, 0, 0] * height).mean()
    platens = 0.5 * (record.reaction + record.top_force).mean()
    return float(max(abs(vertical / platens - 1.0), abs(lateral / record.lateral.mean() - 1.0)))


def _accuracy_part(result: Result) -> str:
    if not result.checks:
        return ""
    strain = min(result.study.check_strain, result.study.strain)
    lines = [
        "## How far the result is the solver's",
        "",
        f"Mean change of the reaction over the first {100 * strain:g} % of crushing at a ten times tighter tolerance:",
        "",
        "| law | change | tolerance | mean residual there | unconverged steps there | seconds there |",
        "|---" * 6 + "|",
    ]
    for law, check in result.checks.items():
        lines.append(
            f"| {law} | {100 * deviation(result.records[law], check):.1f} % | {check.tolerance:.0e} | "
            f"{check.residual.mean():.1e} | {check.unconverged} of {len(check.strain)} | {check.seconds:.0f} |"
        )
    return "\n".join(lines)
