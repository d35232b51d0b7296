"""Curves of recorded runs: ``lmgcpy plot``."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.errors import file_path, named_arguments, one_of, shown
from lmgcpy.io.run import Run
from lmgcpy.solve.problems.report import SOLVED_CODES
from lmgcpy.view import figures
from lmgcpy.view.figures import name_of, new_figure, save
from lmgcpy.view.recorded import (
    Tested,
    frames_with_forces,
    is_test,
    recorded_test,
    stresses_by_frame,
    wall_forces_by_frame,
)
from lmgcpy.writing import check_target

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")


@named_arguments
def plot(runs: Run | Sequence[Run], path: str | os.PathLike, *, what: str = "reaction") -> Path:
    """Draw curves of one run or of several, which ``lmgcpy.io.open_run`` opened, into a PNG, SVG or PDF file. A
    file of that name is replaced, as by :func:`render`.

    ``what``:

    * "reaction": support reaction against crushing, of mechanical tests; of other runs the normal force on every wall
      against time;
    * "deviator": deviator of the Weber stress, and of tests the change of volume;
    * "stress": greatest and smallest principal value of the Weber stress, in all, of contacts and of links;
    * "energy": kinetic and stored energy, and the works of loads, drives and interactions since the start;
    * "solver": residual and iterations of every step, and which steps were not solved.

    The function returns the path, and raises ValueError if a run does not hold the quantity asked for.
    """
    given = list(runs) if isinstance(runs, (list, tuple)) else [runs]
    chosen = [run for run in given if isinstance(run, Run)]
    if not chosen or len(chosen) < len(given):
        raise TypeError(f"runs must be what lmgcpy.io.open_run(path) opens, one or a list of them, got {shown(runs)}.")
    target = Path(file_path(path, "path"))
    if target.suffix.lower() not in SUFFIXES:
        raise ValueError(f"path must end in {', '.join(SUFFIXES)}, got '{target}'.")
    check_target(target, force=True)
    figure = CURVES[one_of(what, "what", CURVES)](chosen, names_of(chosen))
    save(figure, target)
    return target


def names_of(runs: Sequence[Run]) -> list[str]:
    """Names of runs: their files, with as many folders as are needed to tell them apart."""
    paths = [Path(run.path).resolve().with_suffix("") for run in runs]
    for depth in range(1, 1 + max(len(path.parts) for path in paths)):
        names = ["/".join(path.parts[-depth:]) for path in paths]
        if len(set(names)) == len(set(paths)):
            break
    return names


def tests_by_name(records: Sequence[Tested], names: Sequence[str]) -> list[str]:
    """Names of tests: their laws if all differ, else their files."""
    laws = [name_of(record.law) for record in records]
    return laws if len(set(laws)) == len(laws) else list(names)


def reaction(runs: Sequence[Run], names: Sequence[str]) -> Figure:
    """Support reactions, or forces on walls."""
    if all(is_test(run) for run in runs):
        records = [recorded_test(run) for run in runs]
        pressures = {run.notes.get("pressure") for run in runs}
        one = pressures.pop() if len(pressures) == 1 else None
        pressure = float(one) if isinstance(one, (int, float)) and one > 0.0 else None
        return figures.reaction_figure(records, tests_by_name(records, names), pressure=pressure)
    figure = new_figure()
    axes = figure.subplots()
    for run, name in zip(runs, names, strict=True):
        if not run.wall_normals:
            raise ValueError(f"'{run.path}' has no wall, hence no reaction: ask for what='energy' or 'solver'.")
        _refuse_without_steps(run, frames=True)
        time, forces = wall_forces_by_frame(run)
        for wall, force in forces.items():
            axes.plot(time, force, label=wall if len(runs) == 1 else f"{name}: {wall}")
    axes.set_xlabel("time [s]")
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel("normal force on the wall " + ("[N per m of depth]" if runs[0].dimension == 2 else "[N]"))
    axes.legend(frameon=False, fontsize="small")
    return figure


def deviator(runs: Sequence[Run], names: Sequence[str]) -> Figure:
    """Deviators of the Weber stress."""
    if all(is_test(run) for run in runs):
        records = [recorded_test(run) for run in runs]
        return figures.deviator_figure(records, tests_by_name(records, names))
    figure = new_figure()
    axes = figure.subplots()
    for run, name in zip(runs, names, strict=True):
        _refuse_without_steps(run, frames=True)
        time, sigma = stresses_by_frame(run)
        axes.plot(time, 1e-3 * figures.deviator(sigma["total"]), label=name)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("deviator [kPa]")
    axes.legend(frameon=False)
    return figure


def stress(runs: Sequence[Run], names: Sequence[str]) -> Figure:
    """Principal values of the Weber stress."""
    if all(is_test(run) for run in runs):
        records = [recorded_test(run) for run in runs]
        return figures.stress_figure(*records, names=tests_by_name(records, names))
    figure = new_figure(7.0 * len(runs))
    panels = figure.subplots(1, len(runs), squeeze=False, sharey=True)[0]
    for axes, run, name in zip(panels, runs, names, strict=True):
        _refuse_without_steps(run, frames=True)
        time, sigma = stresses_by_frame(run)
        figures.draw_principal(axes, time, sigma)
        axes.set_xlabel("time [s]")
        axes.set_title(f"Weber stress, {name}")
        axes.legend(frameon=False, fontsize="small", ncols=3)
    panels[0].set_ylabel("principal stress, traction positive [kPa]")
    return figure


def energy(runs: Sequence[Run], names: Sequence[str]) -> Figure:
    """Energies, and works since the start of the run."""
    figure = new_figure(7.0 * len(runs))
    panels = figure.subplots(1, len(runs), squeeze=False, sharey=True)[0]
    for axes, run, name in zip(panels, runs, names, strict=True):
        _refuse_without_steps(run)
        time, balance = run.history[:]["time"], run.energy
        axes.plot(time, balance["kinetic"], color="black", label="kinetic energy")
        stored = sum(balance["stored"].values(), np.zeros(len(time)))
        if stored.any():
            axes.plot(time, stored, color="black", linestyle="--", label="energy stored in links")
        for what, label in (("loads", "work of loads and weight"), ("drives", "work of what is driven")):
            if balance[what].any():
                axes.plot(time, np.cumsum(balance[what]), label=label)
        for law, work in balance["work"].items():
            axes.plot(time, np.cumsum(work), label=f"work of {law}")
        axes.set_xlabel("time [s]")
        axes.set_title(f"{name}: defect of a step at most {np.abs(balance['defect']).max():.1e} J", fontsize="medium")
        axes.legend(frameon=False, fontsize="small")
    panels[0].set_ylabel("energy " + ("[J per m of depth]" if runs[0].dimension == 2 else "[J]"))
    return figure


def solver(runs: Sequence[Run], names: Sequence[str]) -> Figure:
    """Residuals and iterations."""
    figure = new_figure(7.0, 6.4)
    above, below = figure.subplots(2, 1, sharex=True)
    shown: list[float] = []
    for k, (run, name) in enumerate(zip(runs, names, strict=True)):
        _refuse_without_steps(run)
        history = run.history[:]
        missed = ~np.isin(history["status"], SOLVED_CODES)
        label = f"{name}, {missed.sum()} of {len(history)} steps not converged"
        residual = np.where(history["residual"] > 0.0, history["residual"], np.nan)  # nothing to solve
        above.plot(history["time"], residual, color=f"C{k}", linewidth=0.8, label=label)
        above.plot(history["time"][missed], residual[missed], ".", color=f"C{k}", markersize=4)
        fields = run.options["solver_fields"] or {}  # no bounds are known of a solver from elsewhere
        tolerances = [fields["tolerance"]] if "tolerance" in fields else []
        for tolerance in tolerances:
            above.axhline(tolerance, color=f"C{k}", linestyle=":", linewidth=0.8)
        shown += [*tolerances, *residual[np.isfinite(residual)].tolist()]
        below.plot(history["time"], history["iterations"], color=f"C{k}", linewidth=0.8)
    if shown:
        above.set_ylim(0.5 * min(shown), 2.0 * max(shown))
        above.set_yscale("log")
    above.set_ylabel("residual")
    above.set_title("dotted: tolerance; dots: steps that were not solved to it", fontsize="small")
    above.legend(frameon=False, fontsize="small")
    below.set_ylabel("iterations a step")
    below.set_ylim(bottom=0.0)
    below.set_xlabel("time [s]")
    return figure


CURVES: dict[str, Callable[[Sequence[Run], Sequence[str]], Figure]] = {
    "reaction": reaction,
    "deviator": deviator,
    "stress": stress,
    "energy": energy,
    "solver": solver,
}
"""The functions that draw curves, by the word that asks for them."""


def _refuse_without_steps(run: Run, *, frames: bool = False) -> None:
    if not len(run.history) or (frames and not frames_with_forces(run)):
        what = "frame after a step" if frames else "step"
        raise ValueError(f"'{run.path}' holds no {what} yet: there is nothing to draw.")
