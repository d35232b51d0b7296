"""Figures of the frontier: work-precision diagrams, performance profiles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.bench.frontier import Judged, Profile
from lmgcpy.solve.problems.report import SOLVED
from lmgcpy.view.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"gauss-seidel": "#6b6b6b", "accelerated": "#e08214", "newton": "#1b4f9c", "auto": "#b2182b"}
MARKERS = {"gauss-seidel": "s", "accelerated": "^", "newton": "D", "auto": "o"}
SHOWN = 4
"""Number of problems in the figure of a family, those with the most interactions."""
LEAST = 1e-14
"""Smallest error in the figures; smaller errors are round-off."""


def work_precision(judged: Sequence[Judged], solvers: Sequence[str]) -> Figure:
    """True error against seconds and against sweeps x interactions, one row a problem.

    Errors in the shaded part are not judged. A filled mark shows a converged run, a hollow one a missed tolerance.
    """
    from matplotlib.ticker import NullFormatter

    rows = sorted(judged, key=lambda problem: -problem.interactions)[:SHOWN]
    figure = new_figure(9.0, 2.7 * len(rows) + 0.6)
    axes = figure.subplots(len(rows), 2, squeeze=False, sharey="row")
    for (left, right), problem in zip(axes, rows, strict=True):
        for solver in solvers:
            _curve(left, problem, solver, "seconds")
            _curve(right, problem, solver, "updates")
        left.set_title(
            f"{problem.name}: {problem.interactions} interactions in {problem.dimension}D", loc="left", fontsize=9
        )
        left.set_ylabel("error of the velocities")
        for axis in (left, right):
            axis.set_xscale("log")
            axis.set_yscale("log")
            axis.grid(True, color="#e4e4e4", linewidth=0.6)
            axis.set_axisbelow(True)
            low, high = axis.get_xlim()
            axis.set_xlim(min(low, 0.3 * high / 10.0), max(high, 3.0 * low * 10.0))  # at least a decade
            axis.xaxis.set_minor_formatter(NullFormatter())
            bottom = max(0.3 * min(_errors(problem)), 0.3 * LEAST)
            axis.set_ylim(bottom, 3.0)
            axis.axhspan(bottom, max(problem.reference.floor, bottom), color="#000000", alpha=0.08, linewidth=0.0)
    axes[-1][0].set_xlabel("time [s]")
    axes[-1][1].set_xlabel("sweeps x interactions (Newton steps not counted)")
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(solvers), frameon=False)
    return figure


def _errors(problem: Judged) -> list[float]:
    return [max(run.error, LEAST) for run in problem.runs]


def _curve(axis: Axes, problem: Judged, solver: str, cost: str) -> None:
    runs = [run for run in problem.runs if run.solver == solver]
    least = 1e-5 if cost == "seconds" else problem.interactions  # a guess that needs no sweep is drawn at one sweep
    x = np.array([max(getattr(run, cost), least) for run in runs])
    y = np.array([max(run.error, LEAST) for run in runs])
    colour, marker = COLOURS[solver], MARKERS[solver]
    axis.plot(x, y, color=colour, marker=marker, markersize=4.5, linewidth=1.3, label=solver)
    missed = np.array([run.status not in SOLVED for run in runs], bool)
    axis.plot(x[missed], y[missed], marker, color=colour, markerfacecolor="white", markersize=5.5, linestyle="none")


def performance_profiles(profiles: Sequence[Profile]) -> Figure:
    """Share of the problems that a solver solves to an error, against its time relative to the fastest solver.

    At the right end, the difference to 1 is the share of its failures.
    """
    figure = new_figure(3.4 * len(profiles), 4.2)
    axes = figure.subplots(1, len(profiles), squeeze=False, sharey=True)[0]
    for axis, profile in zip(axes, profiles, strict=True):
        finite = np.concatenate([ratios[np.isfinite(ratios)] for ratios in profile.ratios.values()])
        end = 1.5 * float(finite.max(initial=10.0))
        for solver, ratios in profile.ratios.items():
            steps = np.r_[1.0, ratios[np.isfinite(ratios)], end]
            heights = [profile.share(solver, ratio) for ratio in steps]
            label = f"{solver} ({profile.failures(solver)} not solved)"
            axis.step(steps, heights, where="post", color=COLOURS[solver], linewidth=1.8, label=label)
        axis.set_xscale("log")
        axis.set_xlim(1.0, end)
        axis.set_ylim(0.0, 1.03)
        axis.grid(True, color="#e4e4e4", linewidth=0.6)
        axis.set_title(f"to an error of {profile.target:g}, {profile.problems} problems", fontsize=10)
        axis.set_xlabel("time / time of the fastest")
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), fontsize=8, frameon=False)  # clear of the curves
    axes[0].set_ylabel("part of the problems")
    return figure
