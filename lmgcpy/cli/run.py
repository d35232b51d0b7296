"""Commands on run files: ``info``, ``resume``, ``compare``, ``export``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
def info(files: tuple[Path, ...]) -> None:
    """Show the content of a run file, the progress of the run, and its errors; of several files a table with a row each."""
    from lmgcpy.io.run import open_run
    from lmgcpy.writing import is_being_written

    rows = [HEAD]
    for file in files:
        with open_run(file) as run:
            state = "being written" if is_being_written(file) else "closed" if run.closed else "killed"
            if len(files) == 1:
                rows = [[line] for line in report(run, state)]
            else:
                rows.append(row_of(run, state))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        click.echo("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


HEAD = ["file", "state", "bodies", "steps", "t [s]", "frames", "unsolved", "worst residual", "laws", "notes"]
"""Columns of the table of several files."""


def row_of(run, state: str) -> list[str]:
    """The row of a run in the table of several files."""
    history = run.history[:]
    residual = f"{history['residual'].max():.2g}" if len(history) else ""
    last = f"{history['time'][-1]:.6g}" if len(history) else "0"
    numbers = [len(run.scene["bodies"]["mass"]), len(history), last, run.frame_count, run.unconverged_steps, residual]
    laws = "; ".join(law_sentence(law).split(" from ")[0] for law in run.scene["laws"])
    notes = ", ".join(f"{name}: {value}" for name, value in run.notes.items())
    return [str(run.path), state, *map(str, numbers), laws, notes]


def report(run, writer: str) -> list[str]:
    """The lines of ``lmgcpy info``; ``writer`` is "being written", "closed" or "killed"."""
    from lmgcpy.scene.description import functions_of_time
    from lmgcpy.solve.problems.report import ROUND_OFF

    scene, options, history = run.scene, run.options, run.history[:]
    bodies, of_time = scene["bodies"], len(functions_of_time(scene))
    kinds = [(kind, int((bodies["kind"] == i).sum())) for i, kind in enumerate(bodies["kinds"])]
    solver = ", ".join(f"{name}={value}" for name, value in (options["solver_fields"] or {}).items())
    checkpoint = run.checkpoint()
    closing = {
        "being written": "being written",
        "closed": "closed normally",
        "killed": f"not closed by its writer; lmgcpy resume goes on from step {checkpoint.steps}",
    }
    lines = [
        f"{run.path}: {closing[writer]}",
        f"  made      {run.created}, with " + ", ".join(f"{name} {value}" for name, value in run.versions.items()),
        f"  scene     dimension {run.dimension}, {len(bodies['mass'])} bodies ("
        + ", ".join(f"{count} {kind}" for kind, count in kinds)
        + f"), {len(scene['chains']['law'])} chains"
        + (f", {len(scene['joints']['law'])} joints" if "joints" in scene else ""),
        "  laws      " + ("; ".join(law_sentence(law) for law in scene["laws"]) or "none"),
        f"  functions {of_time} conditions are functions of time, which the file does not hold",
        f"  options   time step {options['time_step']:g} s, theta {options['theta']:g}, {options['solver']}({solver})",
        f"  so far    {checkpoint.steps} steps to t = {checkpoint.time:g} s; {run.frame_count} frames, "
        f"one in {options['every']} steps",
    ]
    if run.notes:
        lines.append("  notes     " + ", ".join(f"{name}: {value}" for name, value in run.notes.items()))
    if run.observed:
        lines.append("  observed  " + "; ".join(observation(*item) for item in run.observed.items()))
    if len(history):
        energy = checkpoint.energy
        works = ", ".join(f"{law} {work:.6g}" for law, work in energy.total_interactions.items())
        lines += [
            f"  solver    {run.unconverged_steps} of {len(history)} steps not converged"
            + (f", {rounded} solved to round-off" if (rounded := int((history["status"] == ROUND_OFF).sum())) else "")
            + f", worst residual {history['residual'].max():.3g}, "
            + (f"worst slip {history['slip'].max():.3g}, " if "slip" in history.dtype.names else "")
            + f"{history['iterations'].mean():.1f} iterations a step, {history['step_seconds'].sum():.3g} s in all",
            f"  energy    kinetic {energy.kinetic:.6g} J, stored {sum(energy.stored.values()):.6g} J; work of loads "
            f"{energy.total_loads:.6g} J, of drives {energy.total_drives:.6g} J, of interactions: {works or 'none'} J; "
            f"largest defect of a step {abs(history['defect']).max():.2g} J"
            + (f"; made by interactions at most {history['made'].max():.3g} J" if "made" in history.dtype.names else ""),
        ]
        if "stretch" in history.dtype.names and len(scene["chains"]["law"]):
            lines.append(
                f"  links     rigid links leave their reference length by {100.0 * history['stretch'].max():.3g} % at most"
            )
    return lines


def observation(name: str, column) -> str:
    """An observation in words: the shape of an array, or the last value of a number."""
    if column.ndim > 1:
        return f"{name} {column.shape[1:]}"
    return f"{name}, last {float(column[-1]):g}" if len(column) else name


def law_sentence(law: dict) -> str:
    """A law in words, with its parameters and its distribution."""
    given = ", ".join(f"{name}={value:g}" for name, value in law["parameters"].items() if value is not None)
    return f"{law['name']}({given}) from {law['distribution']}"


@click.command()
@click.argument("file", type=FILE)
@click.option("--steps", type=int, required=True, help="Number of steps to make.")
@click.option("--record", type=FILE, help="Another file, in which the run goes on; the first file stays as it is.")
@click.option("--time-step", type=float, help="Another time step [s]; it needs --record.")
@click.option("--progress/--no-progress", default=True, help="Show a progress bar on a terminal.")
def resume(file: Path, steps: int, record: Path | None, time_step: float | None, progress: bool) -> None:
    """Continue a run in its file, or in another one.

    On the same type of processor, with the same versions, it goes on bit for bit as if it had not stopped.
    """
    from lmgcpy.simulation.resume import resume as go_on

    if time_step is not None and record is None:
        raise click.UsageError("--time-step needs another file, as a file holds one time step: give --record FILE.")
    sim = go_on(file, record=record, time_step=time_step)
    try:
        sim.run(steps=steps, progress=progress)
    except KeyboardInterrupt as interrupt:
        click.echo(str(interrupt), err=True)
        sys.exit(130)
    click.echo(f"{record or file}: {sim.steps} steps, to t = {sim.time:g} s")


@click.command()
@click.argument("a", type=FILE)
@click.argument("b", type=FILE)
@click.option(
    "--tolerance", type=float, default=0.0, help="Allowed difference, relative to the largest value; 0: to the last bit."
)
def compare(a: Path, b: Path, tolerance: float) -> None:
    """Show the first difference of two runs: its quantity, time and size.

    Exit code 0: the runs agree; 1: they differ.
    """
    from lmgcpy.io.compare import compare as first_difference
    from lmgcpy.io.run import open_run

    with open_run(a) as one, open_run(b) as other:
        difference = first_difference(one, other, tolerance=tolerance)
    if difference is not None:
        click.echo(str(difference))
        sys.exit(1)
    click.echo("They agree" + (" to the last bit." if tolerance == 0.0 else f" to {tolerance:g}."))


@click.command()
@click.argument("file", type=FILE)
@click.option("--csv", type=FILE, help="Folder for CSV tables.")
@click.option("--vtk", type=FILE, help="Folder for ParaView files.")
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def export(file: Path, csv: Path | None, vtk: Path | None, force: bool) -> None:
    """Export a run as CSV tables or as ParaView files."""
    from lmgcpy.io.csv_tables import export_csv
    from lmgcpy.io.run import open_run
    from lmgcpy.view.vtk import export_vtk

    if csv is None and vtk is None:
        raise click.UsageError("Say where to export to: --csv FOLDER, --vtk FOLDER, or both")
    with open_run(file) as run:
        written = [] if csv is None else export_csv(run, csv, force=force)
        written += [] if vtk is None else export_vtk(run, vtk, force=force)
    for path in written:
        click.echo(path)


COMMANDS = (info, resume, compare, export)
