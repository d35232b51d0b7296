"""The figure of the columns against time, and the pictures of the columns."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.experiment.column.course import time_unit
from lmgcpy.experiment.column.quantities import grain_weight, lasting_tension
from lmgcpy.experiment.column.result import KEPT_HEIGHT, KEPT_RADIUS, ColumnResult, run_name, words
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.study.report import ReportFolder
from lmgcpy.io.run import open_run
from lmgcpy.view.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = ("columns.png", "inside.png")
CAMERA = (0.4, -1.0, 0.35)
"""Direction from which the columns are looked at."""


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
