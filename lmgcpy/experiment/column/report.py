"""Output of ``lmgcpy column``: tables, figures and the summary of a study."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.experiment.column.course import Course, time_unit
from lmgcpy.experiment.column.measure import dry_run_out
from lmgcpy.experiment.column.pictures import course_figure, draw_columns
from lmgcpy.experiment.column.quantities import LASTING, grain_weight, lasting_tension, linear_content, solid_fraction
from lmgcpy.experiment.column.result import KEPT_HEIGHT, KEPT_RADIUS, ColumnResult, Fall, bracket, words
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.study.report import ReportFolder, markdown, sections, texts

USUAL = (100.0, 200.0)
"""Usual contents of TexSol [km/m^3] (paper, section 1)."""


def write_report(result: ColumnResult, folder: StudyFolder) -> list[Path]:
    """Write everything into the folder of the study, in which its run files are; returns the files."""
    report = ReportFolder(folder.path)
    weight = grain_weight(result)
    report.table("columns.csv", [_columns_row(fall, weight) for fall in result.falls])
    report.table("course.csv", map(_course_columns, result.falls))
    report.figure("course.png", course_figure(result))
    missing = ""
    try:
        draw_columns(result, folder, report)
    except ImportError as error:
        missing = str(error)
    report.text(folder.summary.name, summary(result, missing))
    return report.written


def _columns_row(fall: Fall, weight: float) -> Mapping[str, Any]:
    """A row of the table of columns: what the column is made of, and what became of it."""
    laid, start, end, tension = fall.laid, fall.pour, fall.release, lasting_tension(fall)[:, 0].max()
    row = {
        "wire content, asked for": f"{fall.content:.6g}",
        "wire content, laid": f"{laid.content:.6g}",
        "wire content [km/m^3]": f"{linear_content(fall):.6g}",
        "wire by weight [%]": f"{100 * laid.content_by_weight:.4g}",
        "beads": laid.sample.bead_count,
        "solid fraction of the sand, settled": f"{solid_fraction(fall):.4f}",
        "height at release [m]": f"{start.height[-1, 0]:.6g}",
        "height at the end [m]": f"{end.height[-1, 0]:.6g}",
        "height kept": f"{fall.kept_height:.6g}",
        "radius of 95 % at release [m]": f"{start.spread[-1, 0]:.6g}",
        "radius of 95 % at the end [m]": f"{end.spread[-1, 0]:.6g}",
        "radius of 99 % at the end [m]": f"{end.spread[-1, 1]:.6g}",
        "front at the end [m]": f"{end.spread[-1, 2]:.6g}",
        "growth of the radius of 95 %": f"{fall.grown_radius:.6g}",
        "stands": "yes" if fall.stands else "no",
        "at rest": "yes" if end.at_rest else "no",
        "greatest tension [N]": f"{tension:.4g}",
        "greatest tension, in weights of a grain": f"{tension / weight:.4g}",
    }
    return {heading: [entry] for heading, entry in row.items()}


def _course_columns(fall: Fall) -> Mapping[str, Any]:
    """The release of a column, step by step."""
    course = fall.release
    return {
        "column": [words(fall.content)] * len(course.time),
        "time [s]": texts(course.time, ".6g"),
        "radius of 95 % [m]": texts(course.spread[:, 0], ".6g"),
        "radius of 99 % [m]": texts(course.spread[:, 1], ".6g"),
        "front [m]": texts(course.spread[:, 2], ".6g"),
        "height of 99 % [m]": texts(course.height[:, 0], ".6g"),
        "highest grain [m]": texts(course.height[:, 1], ".6g"),
        "kinetic energy / (weight x grain diameter)": texts(course.motion, ".6g"),
        "greatest tension [N]": texts(course.tension[:, 0], ".6g"),
        "mean tension [N]": texts(course.tension[:, 1], ".6g"),
        "residual": texts(course.residual, ".3e"),
        "iterations": map(int, course.iterations),
    }


# ------------------------------------------------------------------------------------------------------------ summary


def summary(result: ColumnResult, missing: str = "") -> str:
    """The study in words and numbers, as Markdown; ``missing``: why there is no picture of the columns."""
    parts = [_verdict(result), _columns_part(result), _dry_part(result), _wire_part(result), _runs_part(result)]
    parts.append(f"There is no picture of the columns. {missing}" if missing else "")
    return sections("The column: sand, and sand with wire, released from its mould", parts)


def _verdict(result: ColumnResult) -> str:
    study, dry = result.study, result.dry
    mould = dry.laid.mould
    made = (
        f"{study.grain_count} spheres of {1e3 * study.diameter:g} mm mean diameter, friction {study.friction:g}, "
        f"seed {study.seed}, in a mould {mould.side / study.diameter:.1f} grains wide, filled "
        f"{mould.height / study.diameter:.1f} grains high: {study.aspect:g} times the radius of a circle of its area. "
        f"A column **stands** if it keeps {100 * KEPT_HEIGHT:g} % of its height and the radius that holds 95 % of its "
        f"sand grows by less than {100 * (KEPT_RADIUS - 1):.0f} %."
    )
    below, least = bracket({fall.content: fall.stands for fall in result.falls})
    most = result.falls[-1]
    if dry.stands:
        found = "**The dry sand stands by itself**: it has no need of wire."
    elif least is None:
        found = (
            f"**No content of wire that was tried makes it stand**, up to {most.laid.content:.3g} "
            f"({linear_content(most):.0f} km/m³ at this grain size, {100 * most.laid.content_by_weight:.2g} % by weight). "
            f"Of its height the dry column keeps {100 * dry.kept_height:.0f} %, that with the most wire "
            f"{100 * most.kept_height:.0f} %; the radius of 95 % of the sand grows {dry.grown_radius:.2f} and "
            f"{most.grown_radius:.2f} times."
        )
    else:
        it = next(fall for fall in result.falls if fall.content == least)
        found = (
            f"**It stands from a wire content of {least:.3g} on** ({linear_content(it):.0f} km/m³ at this grain size, "
            f"{100 * it.laid.content_by_weight:.2g} % by weight); with {below:.3g} it falls. It keeps "
            f"{100 * it.kept_height:.0f} % of its height, the dry column {100 * dry.kept_height:.0f} %."
        )
    return f"{made}\n\n{found}"


def _columns_part(result: ColumnResult) -> str:
    weight, rows = grain_weight(result), []
    for fall in result.falls:
        held = fall.release.spread[-1] / fall.laid.mould.radius
        row = {
            "content": f"{fall.laid.content:.3g}{' (cut)' if fall.laid.wire_cut else ''}",
            "km/m³": f"{linear_content(fall):.0f}",
            "% by weight": f"{100 * fall.laid.content_by_weight:.2g}",
            "beads": f"{fall.laid.sample.bead_count}",
            "solid fraction": f"{solid_fraction(fall):.3f}",
            "height kept": f"{fall.kept_height:.2f}",
            **{name: f"{r:.2f}" for name, r in zip(("radius of 95 %", "of 99 %", "front"), held, strict=True)},
            "growth of the radius of 95 %": f"{fall.grown_radius:.2f}",
            "stands": "yes" if fall.stands else "no",
            "greatest tension [grain weights]": f"{lasting_tension(fall)[:, 0].max() / weight:.0f}",
        }
        rows.append(row)
    low, high = (1e3 * content * result.study.diameter**2 for content in USUAL)
    parts = [
        "## The columns",
        "Content: length of wire x (mean grain diameter)² / volume of the sand. Radii in radii of the mould (of a circle "
        "of its area).",
        markdown(rows),
        f"The usual {USUAL[0]:g} to {USUAL[1]:g} km/m³ are contents of {low:.2g} to {high:.2g} in sand of this size.",
    ]
    if any(fall.laid.wire_cut for fall in result.falls):
        parts.insert(3, "Cut: no room was left for the rest of the wire that was asked for; no more can be laid.")
    return "\n\n".join(parts)


def _dry_part(result: ColumnResult) -> str:
    dry = result.dry
    unit = dry.laid.mould.radius
    held = dry.release.spread[-1] / unit - 1.0
    law = dry_run_out(result.study.aspect)
    return (
        "## The dry column against experiments\n\n"
        f"Run-out (radius - R)/R: {held[2]:.2f} at the front of the covered ground, {held[0]:.2f} and {held[1]:.2f} at the "
        f"radii of 95 and 99 % of the sand. Round columns of sand on rough and smooth grounds run out by {law:.2f} at this "
        "aspect ratio (Lube et al. 2004). This one is square, few grains wide, and of spheres, which roll."
    )


def _wire_part(result: ColumnResult) -> str:
    wired = [fall for fall in result.falls if fall.content > 0.0]
    unit, weight = time_unit(result.dry.laid), grain_weight(result)
    lines = ["## The tension in the wire", "", f"Averaged over {LASTING:g} time units:", ""]
    for fall in wired:
        pull = lasting_tension(fall)
        when = int(np.argmax(pull[:, 0]))
        lines.append(
            f"* {words(fall.content)}: at the most {pull[when, 0]:.2g} N, {pull[when, 0] / weight:.0f} weights of a grain, "
            f"{fall.release.time[when] / unit:.1f} time units after the release; in the mean over the links up to "
            f"{pull[:, 1].max() / weight:.1f} weights, at the end {fall.release.tension[-1, 1] / weight:.1f}."
        )
    thread = wired[0].laid.linear_density
    lines += ["", f"The wire is a thread of {thread:.3g} dtex, as heavy as polyester of the diameter of its beads."]
    return "\n".join(lines)


def _runs_part(result: ColumnResult) -> str:
    rows = [
        {"run": f"{words(fall.content)}, {what}", **_run_row(course, time_unit(fall.laid))}
        for fall in result.falls
        for what, course in (("pour", fall.pour), ("release", fall.release))
    ]
    return (
        f"## The runs\n\n{markdown(rows)}\n\nTime unit sqrt(H/g) = {time_unit(result.dry.laid):.3g} s. "
        f"{result.seconds:.0f} s of steps in all, {result.study.threads} columns at once."
    )


def _run_row(course: Course, unit: float) -> dict[str, str]:
    return {
        "steps": f"{len(course.time)}",
        "time units": f"{course.time[-1] / unit:.1f}",
        "came to rest": "yes" if course.at_rest else "**no**",
        "mean residual": f"{course.residual.mean():.1e}",
        "unconverged steps": f"{course.unconverged}",
        "iterations a step": f"{course.iterations.mean():.0f}",
        "seconds": f"{course.seconds:.0f}",
    }
