"""Commands on problems of one step: ``solve`` solves one, ``bench`` compares the solvers on many."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from lmgcpy.cli.options import CommaList
from lmgcpy.errors import one_of
from lmgcpy.solve.solvers import SOLVERS
from lmgcpy.writing import check_target, write_bytes

if TYPE_CHECKING:
    from lmgcpy.solve.problems.problem import Problem
    from lmgcpy.solve.solve_to_measure import Solved
    from lmgcpy.solve.solvers import AnySolver

FILE = click.Path(path_type=Path)
MEASURES = ("natural", "fclib")
"""Measures of the error that need only the problem."""


@click.command()
@click.argument("file", type=FILE)
@click.option("--solver", "name", default="auto", help=f"Solver: {', '.join(SOLVERS)}.")
@click.option("--tolerance", type=float, default=1e-6, help="Error at which the problem counts as solved.")
@click.option("--max-iterations", type=int, default=None, help="Largest number of sweeps.  [default: the solver's]")
@click.option(
    "--measure", default="natural", help="Measure of the error: natural (the residual) or fclib (of published solvers)."
)
@click.option("--out", type=FILE, default=None, help="HDF5 file for the impulses and velocities.")
@click.option("--force", is_flag=True, help="Replace that file if it exists.")
def solve(
    file: Path, name: str, tolerance: float, max_iterations: int | None, measure: str, out: Path | None, force: bool
) -> None:
    """Solve the frictional-contact problem in FILE.

    The file has FCLIB's local layout (HDF5) and holds one step of any program: u = W r + q with a law for each
    interaction. Exit code 0: the problem is solved to the tolerance, or to round-off if that is larger; 1: it is not.
    """
    from lmgcpy.io import fclib
    from lmgcpy.solve.problems.report import SOLVED
    from lmgcpy.solve.problems.residual import residual
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
        f"  W         {problem.W.shape[0]} rows, {problem.W.nnz} entries",
        f"  solver    {name}, from {start}, to {solver.tolerance:g} ({measure})",
        f"  status    {solved.status} after {solved.iterations} sweeps and {solved.factorisations} Newton steps in "
        f"{solved.seconds:.3g} s",
        "  error     " + ", ".join(f"{each} {error:.3g}" for each, error in errors.items()),
        f"  acting    {acting} of {len(mu)} interactions carry an impulse",
    ]


def briefly(solver: AnySolver) -> AnySolver:
    """A copy of the solver with one sweep and at most one Newton step."""
    from lmgcpy.solve.newton.alternating import Alternating

    if isinstance(solver, Alternating):
        return replace(solver, max_iterations=1, max_factorisations=min(1, solver.max_factorisations))
    return replace(solver, max_iterations=1)


def write_solution(out: Path, problem: Problem, solved: Solved, about: dict[str, Any]) -> None:
    """Write FCLIB's group ``solution``: ``r`` [N s] and ``u`` [m/s], (m d,) each; ``about`` becomes its attributes."""
    from lmgcpy.io.hdf5 import in_memory
    from lmgcpy.version import versions

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
    type=CommaList(str, "chains,2d"),
    default="chains,2d,3d,packings",
    help="Families of problems to make, separated by commas; none: only the problems of the folders.",
)
@click.option(
    "--spheres",
    type=CommaList(int, "1000,10000"),
    default="1000",
    help="Numbers of spheres of the packings, separated by commas; 50000 spheres take long.",
)
@click.option(
    "--solvers",
    type=CommaList(str, "newton,auto"),
    default=",".join(SOLVERS),
    help="Solvers to compare, separated by commas.",
)
@click.option("--quick", is_flag=True, help="Make small problems of every family.")
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def bench(
    folders: tuple[Path, ...],
    out: Path,
    make: tuple[str, ...],
    spheres: tuple[int, ...],
    solvers: tuple[str, ...],
    quick: bool,
    force: bool,
) -> None:
    """Measure speed against error of every solver, at tolerances down to 1e-10.

    The problems are the FCLIB files in FOLDERS, and some that the command makes. Errors are true errors of the velocities,
    by two references each. The command writes tables, figures and the page frontier.md.
    """
    from lmgcpy.bench.study import Bench, run_bench
    from lmgcpy.experiment.study.stages import Stages

    study = Bench(folders, () if make == ("none",) else make, spheres, solvers, quick)
    if out.exists() and any(out.iterdir()) and not force:
        raise FileExistsError(f"The folder '{out}' is not empty: give another by --out, or --force to write there.")
    try:
        written = run_bench(study, out, Stages())
    except KeyboardInterrupt as interrupt:
        click.echo(str(interrupt), err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)


COMMANDS = (solve, bench)
