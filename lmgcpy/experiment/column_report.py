"""What ``lmgcpy column`` writes: tables, figures and the summary of a study."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.experiment.column import GRAVITY, Course, time_unit
from lmgcpy.experiment.column_folder import ColumnFolder
from lmgcpy.experiment.column_measure import dry_run_out
from lmgcpy.experiment.column_sample import SAND_DENSITY
from lmgcpy.experiment.column_study import (
    KEPT_HEIGHT,
    KEPT_RADIUS,
    ColumnResult,
    Fall,
    bracket,
    run_name,
    words,
)
from lmgcpy.experiment.report_files import ReportFolder
from lmgcpy.sample import wire_content

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = ("columns.png", "inside.png")
LASTING = 0.1
"""Over which tensions are averaged, in time units."""
CAMERA = (0.4, -1.0, 0.35)
"""From which the columns are looked at."""
USUAL = (100.0, 200.0)
"""Usual contents of TexSol [km/m^3] (paper, section 1)."""
COURSE = (
    "column",
    "time [s]",
    "radius of 95 % [m]",
    "radius of 99 % [m]",
    "front [m]",
    "height of 99 % [m]",
    "highest grain [m]",
    "kinetic energy / (weight x grain diameter)",
    "greatest tension [N]",
    "mean tension [N]",
    "residual",
    "iterations",
)


def write_report(result: ColumnResult, folder: ColumnFolder) -> list[Path]:
    """Write everything into the folder of the study, whose runs are there; returns the files."""
    report = ReportFolder(folder.path)
    report.table("columns.csv", *_columns_table(result))
    report.table("course.csv", COURSE, (row for fall in result.falls for row in _course_rows(fall)))
    report.figure("course.png", course_figure(result))
    missing = ""
    try:
        report.written += draw_columns(result, folder)
    except ImportError as error:
        missing = str(error)
    report.text(folder.summary.name, summary(result, missing))
    return report.written


def _columns_table(result: ColumnResult) -> tuple[list[str], list[list]]:
    """A row a column: what it is made of, and what became of it."""
    header = [
        "wire content, asked for",
        "wire content, laid",
        "wire content [km/m^3]",
        "wire by weight [%]",
        "beads",
        "solid fraction of the sand, settled",
        "height at release [m]",
        "height at the end [m]",
        "height kept",
        "radius of 95 % at release [m]",
        "radius of 95 % at the end [m]",
        "radius of 99 % at the end [m]",
        "front at the end [m]",
        "growth of the radius of 95 %",
        "stands",
        "at rest",
        "greatest tension [N]",
        "greatest tension, in weights of a grain",
    ]
    rows = []
    for fall in result.falls:
        laid, start, end = fall.laid, fall.pour, fall.release
        rows.append(
            [
                f"{fall.content:.6g}",
                f"{laid.content:.6g}",
                f"{linear_content(fall):.6g}",
                f"{100 * laid.content_by_weight:.4g}",
                laid.sample.bead_count,
                f"{solid_fraction(fall):.4f}",
                *(f"{value:.6g}" for value in (start.height[-1, 0], end.height[-1, 0], fall.kept_height)),
                f"{start.spread[-1, 0]:.6g}",
                *(f"{value:.6g}" for value in (*end.spread[-1], fall.grown_radius)),
                "yes" if fall.stands else "no",
                "yes" if end.at_rest else "no",
                f"{lasting_tension(fall)[:, 0].max():.4g}",
                f"{lasting_tension(fall)[:, 0].max() / grain_weight(result):.4g}",
            ]
        )
    return header, rows


def _course_rows(fall: Fall) -> Iterable[list]:
    course = fall.release
    for k in range(len(course.time)):
        yield [
            words(fall.content),
            f"{course.time[k]:.6g}",
            *(f"{value:.6g}" for value in (*course.spread[k], *course.height[k], course.motion[k], *course.tension[k])),
            f"{course.residual[k]:.3e}",
            int(course.iterations[k]),
        ]


def grain_weight(result: ColumnResult) -> float:
    """Of a grain of the mean diameter [N]."""
    return SAND_DENSITY * math.pi / 6.0 * result.study.diameter**3 * GRAVITY


def linear_content(fall: Fall) -> float:
    """Length of wire in the settled column [km/m^3]."""
    return wire_content(length=fall.laid.wire_length, volume=settled_volume(fall))


def settled_volume(fall: Fall) -> float:
    """Of the mould up to the level below which 99 % of the grains' mass lies, at the release [m^3]."""
    return fall.laid.mould.side**2 * float(fall.pour.height[-1, 0])


def solid_fraction(fall: Fall) -> float:
    """Of the sand in its settled volume [-]."""
    radii = fall.laid.sample.radii[fall.laid.sample.bead_count :]
    return 0.99 * 4.0 / 3.0 * math.pi * float(np.sum(radii**3)) / settled_volume(fall)


def lasting_tension(fall: Fall) -> np.ndarray:
    """Greatest and mean tension of the links during the release, running means over :data:`LASTING` [N], (s, 2).

    In a step in which the wire snaps taut the force is an impulse over the time step, a number of the step's as well.
    """
    tension, time = fall.release.tension, fall.release.time
    count = min(len(time), max(1, round(LASTING * time_unit(fall.laid) / time[0])))
    return np.column_stack([np.convolve(column, np.full(count, 1.0 / count), mode="same") for column in tension.T])


# ----------------------------------------------------------------------------------------------------------- pictures


def course_figure(result: ColumnResult) -> Figure:
    """Height and run-out against time, one curve a column, and the tension in the wires."""
    from lmgcpy.view.figures import new_figure

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


def draw_columns(result: ColumnResult, folder: ColumnFolder) -> list[Path]:
    """The dry column and the one with the most wire side by side, at the release and at the end, grains by the layer they
    were in; and the latter cut open. Raises ImportError where pyvista is missing.
    """
    from contextlib import ExitStack

    from lmgcpy.io.run import open_run
    from lmgcpy.view import render

    falls = (result.dry, result.falls[-1])
    paths = [folder.path / name for name in PICTURES]
    top = float(max(fall.pour.height[-1, 1] for fall in falls))
    look: dict[str, Any] = {"grains": "layer", "wires": "plain", "limits": (0.0, top), "camera": CAMERA, "size": (800, 480)}
    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(folder.run_file(run_name("release", fall.content)))) for fall in falls]
        dry, wired = (words(fall.content) for fall in falls)
        titles = [f"{name}, {when}" for when in ("in the mould", "released") for name in (dry, wired)]
        render([*runs, *runs], paths[0], frame=[0, 0, -1, -1], title=titles, columns=2, **look)
        cut = [f"{wired}, {when}, cut open" for when in ("in the mould", "released")]
        render([runs[1]] * 2, paths[1], frame=[0, -1], clip="y", title=cut, **look)
    return paths


# ------------------------------------------------------------------------------------------------------------ summary


def summary(result: ColumnResult, missing: str = "") -> str:
    """The study in words and numbers, as Markdown; ``missing``: why there is no picture of the columns."""
    parts = [_verdict(result), _columns_part(result), _dry_part(result), _wire_part(result), _runs_part(result)]
    if missing:
        parts.append(f"There is no picture of the columns. {missing}")
    return "\n\n".join(["# The column: sand, and sand with wire, released from its mould", *parts]) + "\n"


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
            f"({linear_content(most):.3g} km/m3 at this grain size, {100 * most.laid.content_by_weight:.2g} % by weight). "
            f"Of its height the dry column keeps {100 * dry.kept_height:.0f} %, that with the most wire "
            f"{100 * most.kept_height:.0f} %; the radius of 95 % of the sand grows {dry.grown_radius:.2f} and "
            f"{most.grown_radius:.2f} times."
        )
    else:
        it = next(fall for fall in result.falls if fall.content == least)
        found = (
            f"**It stands from a wire content of {least:.3g} on** ({linear_content(it):.3g} km/m3 at this grain size, "
            f"{100 * it.laid.content_by_weight:.2g} % by weight); with {below:.3g} it falls. It keeps "
            f"{100 * it.kept_height:.0f} % of its height, the dry column {100 * dry.kept_height:.0f} %."
        )
    return f"{made}\n\n{found}"


def _columns_part(result: ColumnResult) -> str:
    lines = [
        "## The columns",
        "",
        "Content: length of wire x (mean grain diameter)2 / volume of the sand. Radii in radii of the mould (of a circle "
        "of its area).",
        "",
        "| content | km/m3 | % by weight | beads | solid fraction | height kept | radius of 95 % | of 99 % | front | "
        "growth of the radius of 95 % | stands | greatest tension [grain weights] |",
        "|---" * 12 + "|",
    ]
    for fall in result.falls:
        held = fall.release.spread[-1] / fall.laid.mould.radius
        lines.append(
            f"| {fall.laid.content:.3g}{' (cut)' if fall.laid.wire_cut else ''} | {linear_content(fall):.3g} | "
            f"{100 * fall.laid.content_by_weight:.2g} | {fall.laid.sample.bead_count} | {solid_fraction(fall):.3f} | "
            f"{fall.kept_height:.2f} | {held[0]:.2f} | {held[1]:.2f} | {held[2]:.2f} | {fall.grown_radius:.2f} | "
            f"{'yes' if fall.stands else 'no'} | {lasting_tension(fall)[:, 0].max() / grain_weight(result):.0f} |"
        )
    if any(fall.laid.wire_cut for fall in result.falls):
        lines += ["", "Cut: no room was left for the rest of the wire that was asked for; no more can be laid."]
    low, high = (1e3 * content * result.study.diameter**2 for content in USUAL)
    lines += [
        "",
        f"The usual {USUAL[0]:g} to {USUAL[1]:g} km/m3 are contents of {low:.2g} to {high:.2g} in sand of this size.",
    ]
    return "\n".join(lines)


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
    lines = [
        "## The runs",
        "",
        "| run | steps | time units | came to rest | mean residual | unconverged steps | iterations a step | seconds |",
        "|---" * 8 + "|",
    ]
    for fall in result.falls:
        for what, course in (("pour", fall.pour), ("release", fall.release)):
            lines.append(f"| {words(fall.content)}, {what} | {_run_row(course, time_unit(fall.laid))} |")
    lines += [
        "",
        f"Time unit sqrt(H/g) = {time_unit(result.dry.laid):.3g} s. {result.seconds:.0f} s of steps in all, "
        f"{result.study.threads} columns at once.",
    ]
    return "\n".join(lines)


def _run_row(course: Course, unit: float) -> str:
    return (
        f"{len(course.time)} | {course.time[-1] / unit:.1f} | {'yes' if course.at_rest else '**no**'} | "
        f"{course.residual.mean():.1e} | {course.unconverged} | {course.iterations.mean():.0f} | {course.seconds:.0f}"
    )
