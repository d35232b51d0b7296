"""Output of ``lmgcpy column``: tables, figures and the summary of a study."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.experiment.column.course import Course, dry_run_out, time_unit
from lmgcpy.experiment.column.result import (
    KEPT_HEIGHT,
    KEPT_RADIUS,
    LASTING,
    ColumnResult,
    Fall,
    bracket,
    grain_weight,
    lasting_tension,
    linear_content,
    run_name,
    solid_fraction,
    words,
)
from lmgcpy.experiment.study.folder import ReportFolder, StudyFolder, markdown, sections, texts
from lmgcpy.experiment.study.unsolved import unsolved_words
from lmgcpy.io.run import open_run
from lmgcpy.view.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

USUAL = (100.0, 200.0)
"""Usual contents of TexSol [km/m^3] (paper, section 1)."""

PICTURES = ("columns.png", "inside.png")
CAMERA = (0.4, -1.0, 0.35)
"""Direction from which the columns are looked at."""


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
        "beads or nodes": laid.sample.bead_count,
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
            "beads or nodes": f"{fall.laid.sample.bead_count}",
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
    what = "smooth thread" if wired[0].laid.sample.thread else "chain of beads"
    lines += ["", f"The wire is a {what} of {thread:.3g} dtex, as heavy as polyester of its diameter."]
    return "\n".join(lines)


def _runs_part(result: ColumnResult) -> str:
    rows = [
        {"run": f"{words(fall.content)}, {what}", **_run_row(course, time_unit(fall.laid))}
        for fall in result.falls
        for what, course in (("pour", fall.pour), ("release", fall.release))
    ]
    study, parts = result.study, ("pour", "release")
    courses = {f"{words(fall.content)}, {what}": getattr(fall, what) for fall in result.falls for what in parts}
    unsolved = unsolved_words(courses, tolerance=study.tolerance, max_iterations=study.max_iterations)
    if unsolved:
        unsolved += (
            " In a pour, sand and wire fall and are caught, so steps begin far from their solution; in a column at rest"
            " the impulses of the step before are nearly the solution."
        )
    took = (
        f"Time unit sqrt(H/g) = {time_unit(result.dry.laid):.3g} s. {result.seconds:.0f} s of steps in all, "
        f"{study.threads} columns at once."
    )
    return "\n\n".join(filter(None, ["## The runs", markdown(rows), unsolved, took]))


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


# --------------------------------------------------------------------------------------------------------------- pictures


def course_figure(result: ColumnResult) -> Figure:
    """Height and run-out against time, one curve a column, and the tension in the wires."""
    figure = new_figure(12.0, 4.2)
    height, radius, tension = figure.subplots(1, 3)
    unit, weight = time_unit(result.dry.laid), grain_weight(result)
    for fall, color in zip(result.falls, _colors(len(result.falls)), strict=True):
        course, start = fall.release, fall.pour
        time = np.concatenate([[0.0], course.time / unit])
        label = words(fall.content)
        for axes, values, first in (
            (height, course.height[:, 0], start.height[-1, 0]),
            (radius, course.spread[:, 0], start.spread[-1, 0]),
        ):
            axes.plot(time, np.concatenate([[first], values]) / first, color=color, label=label)
        if fall.content > 0.0:
            tension.plot(time[1:], lasting_tension(fall)[:, 0] / weight, color=color, linewidth=1.0)
    height.axhline(KEPT_HEIGHT, color="grey", linewidth=0.6, linestyle="--")
    radius.axhline(KEPT_RADIUS, color="grey", linewidth=0.6, linestyle="--")
    height.set_ylim(bottom=0.0)
    tension.set_ylim(bottom=0.0)
    height.set_ylabel("height / height at the release")
    radius.set_ylabel("radius of 95 % of the sand / at the release")
    tension.set_ylabel("greatest tension [weights of a grain]")
    for axes in (height, radius, tension):
        axes.set_xlabel(r"time since the release [$\sqrt{H/g}$]")
        axes.set_xlim(left=0.0)
    height.legend(frameon=False)
    return figure


def _colors(count: int) -> list:
    """Sand, and blues that darken with the content."""
    from matplotlib import colormaps

    blues = colormaps["Blues"](np.linspace(0.45, 1.0, max(count - 1, 1)))
    return ["#8c6d31", *blues][:count]


def draw_columns(result: ColumnResult, folder: StudyFolder, report: ReportFolder) -> None:
    """The dry column and the column with the most wire side by side, at the release and at the end, grains coloured by
    their first layer; and the column with wire cut open. Raises ImportError if pyvista is missing.
    """
    from lmgcpy.view import render

    falls = (result.dry, result.falls[-1])
    top = float(max(fall.pour.height[-1, 1] for fall in falls))
    look: dict[str, Any] = {"grains": "layer", "wires": "plain", "limits": (0.0, top), "camera": CAMERA, "size": (800, 480)}
    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(folder.run_file(run_name("release", fall.content)))) for fall in falls]
        dry, wired = (words(fall.content) for fall in falls)
        titles = [f"{name}, {when}" for when in ("in the mould", "released") for name in (dry, wired)]
        render([*runs, *runs], report.path / PICTURES[0], frame=[0, 0, -1, -1], title=titles, columns=2, **look)
        cut = [f"{wired}, {when}, cut open" for when in ("in the mould", "released")]
        render([runs[1]] * 2, report.path / PICTURES[1], frame=[0, -1], clip="y", title=cut, **look)
    report.written += [report.path / name for name in PICTURES]
