"""``lmgcpy measure``: the micro-macro numbers of a frame of a run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from lmgcpy.cli.measure_report import Subject
    from lmgcpy.io.run import Run

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("file", type=FILE)
@click.option("--frame", type=int, help="Number of the frame; negative: from the end [default: -1].")
@click.option("--since", type=int, default=0, help="Frame from which strain, stretch and slip are counted.")
@click.option(
    "--axis",
    type=click.Choice(["x", "y", "z"]),
    help="Axis by the angle to which links are sorted [default: that of the test, or upward].",
)
@click.option("--all-frames", is_flag=True, help="A table of all frames, a row each, into the CSV file that --out names.")
@click.option("--out", type=FILE, help="Folder for CSV tables; with --all-frames a file.")
@click.option("--force", is_flag=True, help="Write into a folder that is not empty, or replace a file.")
def measure(
    file: Path, frame: int | None, since: int, axis: str | None, all_frames: bool, out: Path | None, force: bool
) -> None:
    """Show what a frame of a run measures: stress, contacts, strain, wires, friction.

    Strain, stretch of the wire and slip of its beads are counted from an earlier frame. With --out each measure is written
    as a table. The measures come from lmgcpy.measure. A number after "+-" is a standard error.
    """
    from lmgcpy.cli.measure_report import Subject, direction_table, report
    from lmgcpy.io.csv_tables import folder_for
    from lmgcpy.io.run import open_run

    if all_frames and frame is not None:
        raise click.UsageError("--frame chooses one frame, and --all-frames takes all: leave out one of them.")
    if force and out is None:
        raise click.UsageError("--force is about what --out names: add --out, or leave --force out.")
    with open_run(file) as run:
        if all_frames:
            click.echo(table_of_frames(run, since, axis, out, force))
            return
        subject = Subject.of(run, -1 if frame is None else frame, since, axis)
        folder = None if out is None else folder_for(out, force)
        found = report(subject)
        times = run.times
        click.echo(
            f"{run.path}: frame {subject.frame} (of 0 to {run.frame_count - 1}), t = {times[subject.frame]:g} s; "
            f"motion since frame {subject.since}, t = {times[subject.since]:g} s"
        )
        for line in text(found):
            click.echo(line)
        rows = direction_table(subject)
        if rows:
            click.echo("\nWire by direction")
        for line in aligned(rows):
            click.echo(f"  {line}")
        if folder is not None:
            click.echo()
            for path in tables(subject, found, folder):
                click.echo(path)


def table_of_frames(run: Run, since: int, axis: str | None, out: Path | None, force: bool) -> Path:
    """Write the entries of all frames, a row each; the path of the file."""
    from lmgcpy.cli.measure_report import Subject, report
    from lmgcpy.writing import check_target, write_table

    if out is None:
        raise ValueError("--all-frames needs --out, the CSV file to write: --out table.csv.")
    check_target(out, force=force, name="--out", instead="give another name by --out, or --force to replace it")
    columns: dict[str, dict[int, float]] = {}
    for k in range(run.frame_count):
        of_entry = ""
        for part in report(Subject.of(run, k, since, axis)).values():
            for entry in part:
                if isinstance(entry, str):
                    continue
                label = entry.label
                if label.startswith(" "):  # it goes on with the one above
                    label = f"{of_entry}: {label.strip()}"
                else:
                    of_entry = label
                name = f"{label} [{entry.unit}]" if entry.unit else label
                columns.setdefault(name, {})[k] = entry.value
    steps, times = run.steps, run.times
    rows = [
        [k, int(steps[k]), float(times[k]), *(column.get(k, math.nan) for column in columns.values())]
        for k in range(run.frame_count)
    ]
    write_table(out, ["frame", "step", "time [s]", *columns], rows)
    return out


def text(found: dict[str, list[Any]]) -> Iterator[str]:
    """The headings and their entries, numbers in one column."""
    from lmgcpy.cli.measure_report import with_error

    entries = [entry for part in found.values() for entry in part if not isinstance(entry, str)]
    width = max((len(entry.label) for entry in entries), default=0)
    for heading, part in found.items():
        yield ""
        yield heading
        for entry in part:
            if isinstance(entry, str):
                yield f"  {entry}"
            else:
                yield f"  {entry.label:<{width}}  {with_error(entry.value, entry.error)} {entry.unit}".rstrip()


def aligned(rows: list[list[str]]) -> list[str]:
    """The lines of a table."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]


UNITS = {
    **dict.fromkeys(("along", "to_end", "position", "length", "reference_length", "distance"), "m"),
    **dict.fromkeys(("from_mean", "from_neighbours", "along_mean", "along_neighbours"), "m"),
    **dict.fromkeys(("tension", "tension_error", "normal", "tangential", "limit", "force_along", "friction_along"), "N"),
    **dict.fromkeys(("greatest", "mean", "force"), "N"),
    **dict.fromkeys(("lower", "upper"), "degrees"),
    "pull": "N m",
    **dict.fromkeys(("stress", "pressure"), "Pa"),
    "area": "m^2",
}
"""Units of the columns by field of the measure; fields that are not named have none."""


def tables(subject: Subject, found: dict[str, list[Any]], folder: Path) -> Iterator[Path]:
    """Write the tables; their paths, one by one."""
    from lmgcpy import measure as measures
    from lmgcpy.cli.measure_report import CHORD
    from lmgcpy.writing import write_table

    def written(name: str, head: list[str], rows: Any) -> Path:
        write_table(folder / f"{name}.csv", head, rows)
        return folder / f"{name}.csv"

    entries = [(heading, entry) for heading, part in found.items() for entry in part if not isinstance(entry, str)]
    summary = [[heading, e.label.strip(), e.value, e.error, e.unit] for heading, e in entries]
    yield written("summary", ["part", "quantity", "value", "standard error", "unit"], summary)
    run, axis = subject.run, subject.axis
    at: dict[str, Any] = {"frame": subject.frame}
    moved: dict[str, Any] = {**at, "since": subject.since}
    made: dict[str, Any] = {}
    if subject.has_step:
        forces = measures.contact_forces(run, **at)
        made |= {"contacts": forces, "contact-kinds": measures.contact_kinds(run, **at)}
        if len(found_on := measures.facets(run, **at)):
            made["facets"] = found_on
        if len(forces):
            centres, density = forces.distribution()
            rows = zip(centres.tolist(), density.tolist(), strict=True)
            yield written("contact-forces", ["f / mean f", "probability density"], rows)
    if run.dimension == 3 and len(axes := measures.long_axes(run, **at)):
        made["long-axes"] = axes
    if subject.has_wire:
        made["links"] = measures.wire_links(run, **at)
    if subject.has_wire and subject.has_step:
        made |= {
            "tension-by-direction": measures.tension_by_direction(run, axis=axis, **at),
            "beads": measures.wire_contacts(run, **at),
            "forces-along": measures.forces_along(run, **at),
            "tension-correlation": measures.tension_correlation(run, **at),
            "taut-runs": measures.taut_runs(run, **at),
        }
    if subject.has_wire and subject.frame != subject.since:
        with suppress(ValueError):  # too few bodies, as the lines above say
            for links in (1, CHORD):
                made[f"stretch-of-{links}-links"] = measures.stretch_by_direction(run, axis=axis, links=links, **moved)
            made["slip"] = measures.bead_slip(run, **moved)
    for name, table in made.items():
        columns = table.columns()
        head = [f"{column} [{unit}]" if (unit := unit_of(column)) else column for column in columns]
        yield written(name, head, zip(*(values.tolist() for values in columns.values()), strict=True))


def unit_of(column: str) -> str:
    """The unit of a column, by its own name or by the name of the vector or tensor whose component it is."""
    return UNITS.get(column) or UNITS.get(column.rpartition("_")[0], "")
