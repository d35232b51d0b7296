"""Commands on problems of one step: ``solve`` a file, ``bench`` many."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lmgcpy.errors import one_of
from lmgcpy.writing import check_target, write_bytes

if TYPE_CHECKING:
    from lmgcpy.solve.problem import Problem
    from lmgcpy.solve.solve_to_measure import Solved
    from lmgcpy.solve.solvers import AnySolver

FILE = click.Path(path_type=Path)
MEASURES = ("natural", "fclib")
"""Measures of the error that need nothing but the problem."""


@click.command()
@click.argument("file", type=FILE)
@click.option("--solver", "name", default="auto", help="auto, newton, accelerated or gauss-seidel.")
@click.option("--tolerance", type=float, default=1e-6, help="Error at which the problem is solved, in the measure.")
@click.option("--max-iterations", type=int, default=None, help="Sweeps at the most.  [default: the solver's]")
@click.option("--measure", default="natural", help="Of the error: natural (the residual) or fclib (of published solvers).")
@click.option("--out", type=FILE, default=None, help="HDF5 file to write with the impulses and velocities.")
@click.option("--force", is_flag=True, help="Replace that file if it exists.")
def solve(
    file: Path, name: str, tolerance: float, max_iterations: int | None, measure: str, out: Path | None, force: bool
) -> None:
    """Solve the frictional-contact problem in FILE.

    The file is in FCLIB's local layout, HDF5, and holds one step of any program: u = W r + q with a law for each
    interaction. Exit code 0: solved to the tolerance, or to round-off where that lies above it; 1: not.
    """
    from lmgcpy.io import fclib
    from lmgcpy.solve.report import SOLVED
    from lmgcpy.solve.residual import residual
    from lmgcpy.solve.solve_to_measure import solve_to_measure
    from lmgcpy.solve.solvers import SOLVERS

    kind = SOLVERS[one_of(name, "solver", SOLVERS)]
    one_of(measure, "measure", MEASURES)
    solver = kind(tolerance=tolerance)
    if max_iterations is not None:
        solver = replace(solver, max_iterations=max_iterations)
    if out is not None:
        check_target(out, force=force, name="--out", instead="give another by --out, or --force to replace it")
    problem = fclib.read(file)
    solve_to_measure(problem, briefly(solver))  # loads or compiles the kernels: times are of the solver alone
    solved = solve_to_measure(problem, solver, measure=measure)
    errors = {each: residual(problem, solved.impulses, measure=each) for each in MEASURES}
    for line in report(file, problem, name, solver, measure, solved, errors):
        click.echo(line)
    if out is not None:
        about = {"file": str(file), "solver": name, "tolerance": solver.tolerance, "measure": measure}
        write_solution(out, problem, solved, {**about, **{f"error_{each}": error for each, error in errors.items()}})
        click.echo(f"{out}: impulses and velocities")
    if solved.status not in SOLVED:
        sys.exit(1)


def report(
    file: Path, problem: Problem, name: str, solver: Any, measure: str, solved: Solved, errors: dict[str, float]
) -> list[str]:
    """The lines of ``lmgcpy solve``."""
    import numpy as np

    d, mu = problem.dimension, problem.mu
    names, counts = np.unique(np.array(problem.laws, dtype=str), return_counts=True)
    by_law = ", ".join(f"{count} {law}" for law, count in zip(names, counts, strict=True)) or "none"
    acting = np.count_nonzero(np.any(solved.impulses != 0.0, axis=1))
    start = "the guess in the file" if problem.guess.any() else "nothing"
    friction = f", friction {mu.min():g} to {mu.max():g}" if len(mu) and mu.any() else ""
    return [
        f"{file}: {len(mu)} interactions in {d}D",
        f"  laws      {by_law}{friction}",
        f"  W         {d * len(mu)} rows, {problem.W.nnz} entries",
        f"  solver    {name}, from {start}, to {solver.tolerance:g} ({measure})",
        f"  status    {solved.status} after {solved.iterations} sweeps and {solved.factorisations} Newton steps in "
        f"{solved.seconds:.3g} s",
        "  error     " + ", ".join(f"{each} {error:.3g}" for each, error in errors.items()),
        f"  acting    {acting} of {len(mu)} interactions carry an impulse",
    ]


def briefly(solver: AnySolver) -> AnySolver:
    """The same solver for one sweep, and for one Newton step at the most."""
    from lmgcpy.solve.newton.alternating import Alternating

    if isinstance(solver, Alternating):
        return replace(solver, max_iterations=1, max_factorisations=min(1, solver.max_factorisations))
    return replace(solver, max_iterations=1)


def write_solution(out: Path, problem: Problem, solved: Solved, about: dict[str, Any]) -> None:
    """Group ``solution`` of FCLIB: ``r`` [N s] and ``u`` [m/s], (m d,) each, with what is known of them as attributes."""
    from lmgcpy.io.hdf5 import in_memory
    from lmgcpy.io.recorder import versions

    def fill(into: Any) -> None:
        group = into.create_group("solution")
        group["r"] = solved.impulses.ravel()
        group["u"] = problem.velocities(solved.impulses).ravel()
        counts = {"sweeps": solved.iterations, "newton_steps": solved.factorisations, "seconds": solved.seconds}
        group.attrs.update({**about, "status": solved.status, **counts})
        group.attrs.update({f"version_{name}": version for name, version in versions().items()})

    write_bytes(out, in_memory(fill, libver=("earliest", "v110")))


@click.command()
@click.argument("folders", type=FILE, nargs=-1)
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), required=True, help="Folder to write.")
@click.option(
    "--make",
    default="chains,2d,3d,packings",
    help="Families of problems to make, by commas; none: only those of the folders.",
)
@click.option("--spheres", default="1000", help="Sizes of the packings, by commas; those of 50000 take long.")
@click.option("--solvers", default="gauss-seidel,accelerated,newton,auto", help="Solvers to compare, by commas.")
@click.option("--quick", is_flag=True, help="Small problems of every family, for a look.")
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def bench(folders: tuple[Path, ...], out: Path, make: str, spheres: str, solvers: str, quick: bool, force: bool) -> None:
    """Speed against error of every solver, at tolerances down to 1e-10.

    On the problems in FOLDERS, which hold FCLIB files, and on some made here. Errors are true errors of the velocities, by
    two references each. Writes tables, figures and the page frontier.md.
    """
    from lmgcpy.bench.study import Bench, run_bench
    from lmgcpy.experiment.stages import Stages

    families = () if make.strip() == "none" else words(make)
    study = Bench(folders, families, sizes(spheres), words(solvers), quick)
    if out.exists() and any(out.iterdir()) and not force:
        raise FileExistsError(f"The folder '{out}' is not empty: give another by --out, or --force to write there.")
    try:
        written = run_bench(study, out, Stages())
    except KeyboardInterrupt as interrupt:
        click.echo(str(interrupt), err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)


def words(text: str) -> tuple[str, ...]:
    """Words between commas."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def sizes(text: str) -> tuple[int, ...]:
    """Whole numbers between commas, or a sentence (ValueError)."""
    try:
        return tuple(int(word) for word in words(text))
    except ValueError:
        raise ValueError(f"--spheres takes whole numbers by commas, got '{text}'.") from None


COMMANDS = (solve, bench)
