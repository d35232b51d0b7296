"""The report of the frontier: work-precision diagrams and performance profiles, tables, and a page that shows them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.bench import load, machine
from lmgcpy.bench.frontier import OVERHEAD, SMALLEST, Judged, Profile, SolverRun, profile
from lmgcpy.bench.reference import APART, ENOUGH, MARGIN, Reference
from lmgcpy.solve.problems.report import SOLVED
from lmgcpy.view.figures import new_figure, save
from lmgcpy.writing import make_folder, markdown_table, write_table, write_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"gauss-seidel": "#6b6b6b", "accelerated": "#e08214", "newton": "#1b4f9c", "auto": "#b2182b"}
MARKERS = {"gauss-seidel": "s", "accelerated": "^", "newton": "D", "auto": "o"}
SHOWN = 4
"""Number of problems in the figure of a family, those with the most interactions."""
LEAST = 1e-14
"""Smallest error in the figures; smaller errors are round-off."""

TARGETS = (1e-2, 1e-4, 1e-6)
"""True errors of the tables and profiles."""
PAGE = "frontier.md"


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
    for axis, each in zip(axes, profiles, strict=True):
        finite = np.concatenate([ratios[np.isfinite(ratios)] for ratios in each.ratios.values()])
        end = 1.5 * float(finite.max(initial=10.0))
        for solver, ratios in each.ratios.items():
            steps = np.r_[1.0, ratios[np.isfinite(ratios)], end]
            heights = [each.share(solver, ratio) for ratio in steps]
            label = f"{solver} ({each.failures(solver)} not solved)"
            axis.step(steps, heights, where="post", color=COLOURS[solver], linewidth=1.8, label=label)
        axis.set_xscale("log")
        axis.set_xlim(1.0, end)
        axis.set_ylim(0.0, 1.03)
        axis.grid(True, color="#e4e4e4", linewidth=0.6)
        axis.set_title(f"to an error of {each.target:g}, {each.problems} problems", fontsize=10)
        axis.set_xlabel("time / time of the fastest")
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), fontsize=8, frameon=False)  # clear of the curves
    axes[0].set_ylabel("part of the problems")
    return figure


def write_report(
    judged: Sequence[Judged], left_out: Sequence[str], solvers: Sequence[str], folder: Path, load_before: str
) -> list[Path]:
    """Write ``runs.csv``, ``references.csv``, the figures and the page; returns their paths, the page last."""
    make_folder(folder)
    paths = [runs_table(judged, folder / "runs.csv"), references_table(judged, folder / "references.csv")]
    pictures = []
    for family in dict.fromkeys(problem.family for problem in judged):
        picture = folder / f"work-{re.sub(r'[^A-Za-z0-9]+', '-', family).strip('-')}.png"
        save(work_precision([problem for problem in judged if problem.family == family], solvers), picture)
        pictures.append((family, picture))
    profiles = [each for each in (profile(judged, solvers, target) for target in TARGETS) if each.problems]
    if profiles:
        save(performance_profiles(profiles), folder / "profiles.png")
        paths.append(folder / "profiles.png")
    page = folder / PAGE
    lines = ["# Speed against error", "", *conditions(load_before), "", *how_to_read(left_out), ""]
    if profiles:
        lines += ["## Performance profiles", "", profile_words(), "", "![profiles](profiles.png)", ""]
        lines += [*profile_rows(profiles, solvers), ""]
    for family, picture in pictures:
        lines += [
            f"## {family}",
            "",
            f"![work and precision]({picture.name})",
            "",
            *family_rows(judged, family, solvers),
            "",
        ]
    write_text(page, "\n".join(lines))
    return [*paths, *(picture for _, picture in pictures), page]


def conditions(load_before: str) -> list[str]:
    """The machine, the date and the load, in words."""
    return [
        f"{machine()}. {datetime.now(UTC):%Y-%m-%d}. Load of the machine {load_before} at the beginning, {load()} at the "
        "end: if it is above 1, times are longer than on an idle machine, and only their ratios are of use."
    ]


def how_to_read(left_out: Sequence[str]) -> list[str]:
    """Meaning of the numbers, in words."""
    lines = [
        "An error is that of the relative velocities, |u - u_ref| / |q - u_ref|: 1 is the error of doing nothing. Each "
        "problem has two references, found by different methods. The tables give their distance. Errors below "
        f"{MARGIN:g} times this distance are not judged: a table shows the time to a target error above that limit, and "
        '"?" for a target below it; in a figure they lie in the shaded part. Times are those of the solver alone, with '
        "compiled kernels, from the guess of the problem. Hollow marks are runs that missed their tolerance. Every run is "
        "in runs.csv, every reference in references.csv. With friction a problem may have several solutions: any impulses "
        f"with a residual of at most {ENOUGH:g} are one. If several were found, the table gives their number, an error is "
        f"the distance to the nearest of them, and errors above {MARGIN * APART:g} are judged."
    ]
    if left_out:
        lines += ["", f"These problems are left out, because no impulse changes a velocity: {', '.join(left_out)}."]
    return lines


def profile_words() -> str:
    """The meaning of the profiles, in words."""
    return (
        "A curve shows the share of the problems that a solver solves to the error, against its time relative to the "
        f"fastest solver. Problems with fewer than {SMALLEST} interactions, and those whose references cannot judge the "
        f"error, are left out; times below {1e3 * OVERHEAD:g} ms count as {1e3 * OVERHEAD:g} ms."
    )


def profile_rows(profiles: Sequence[Profile], solvers: Sequence[str]) -> list[str]:
    """The table of the profiles, one row an error."""
    rows = []
    for each in profiles:
        cells = [
            f"{100 * each.share(name, 1.0):.0f} % / {100 * each.share(name, 2.0):.0f} % / {each.failures(name)}"
            for name in solvers
        ]
        rows.append([f"{each.target:g}", str(each.problems), str(each.unsolved), *cells])
    heads = ["error", "problems", "solved by none", *(f"{name}: fastest / within twice / failures" for name in solvers)]
    return markdown_table(heads, rows)


def family_rows(judged: Sequence[Judged], family: str, solvers: Sequence[str]) -> list[str]:
    """The table of a family, one row a problem: its references, and the time to each error."""
    rows = []
    for problem in judged:
        if problem.family != family:
            continue
        reference = problem.reference
        cells = [" / ".join(cell(problem, name, target) for target in TARGETS) for name in solvers]
        size = f"{problem.interactions} ({problem.dimension}D)"
        rows.append([problem.name, size, " and ".join(reference.methods), distance_cell(reference), *cells])
    targets = " / ".join(f"{target:g}" for target in TARGETS)
    return markdown_table(
        ["problem", "interactions", "references", "distance", *(f"{name}: s to {targets}" for name in solvers)], rows
    )


def distance_cell(reference: Reference) -> str:
    """The distance of the references, and the number of solutions."""
    several = f" ({len(reference.solutions)} solutions)" if len(reference.solutions) > 1 else ""
    return f"{reference.distance:.0e}{several}"


def cell(problem: Judged, solver: str, target: float) -> str:
    """Seconds to an error; "-" if it was not reached, "?" if the references cannot judge it."""
    if problem.reference.floor > target:
        return "?"
    run = problem.best(solver, target)
    return "-" if run is None else f"{run.seconds:.2g}"


def runs_table(judged: Sequence[Judged], path: Path) -> Path:
    """Write every run."""
    own = [field.name for field in fields(SolverRun) if field.name != "problem"]
    rows = []
    for problem in judged:
        for run in problem.runs:
            values = [asdict(run)[name] for name in own]
            is_judged = "yes" if run.error > problem.reference.floor else "no"
            rows.append([problem.name, problem.family, problem.dimension, problem.interactions, *values, is_judged])
    write_table(path, ["problem", "family", "dimension", "interactions", *own, "judged"], rows)
    return path


def references_table(judged: Sequence[Judged], path: Path) -> Path:
    """Write every reference."""
    rows = []
    for problem in judged:
        reference = problem.reference
        pairs = [part for pair in zip(reference.methods, reference.residuals, strict=True) for part in pair]
        rows.append([problem.name, *pairs, reference.distance, reference.scale])
    write_table(path, ["problem", "first", "its residual", "second", "its residual", "distance", "scale [m/s]"], rows)
    return path
