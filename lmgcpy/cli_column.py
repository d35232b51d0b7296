"""The command ``lmgcpy column``."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

FIELDS = {"grains": "grain_count", "bead": "bead_diameter", "refine": "refinements"}
"""Fields of a study whose options have other names."""


class Contents(click.ParamType):
    """Numbers by commas."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """As :class:`lmgcpy.experiment.column_study.ColumnStudy` takes them."""
        try:
            return tuple(float(part) for part in value.split(",") if part.strip())
        except ValueError:
            self.fail(f"'{value}' is not numbers by commas, such as 0.1,0.4", param, ctx)


@click.command()
@click.option("--contents", type=Contents(), show_default="0.05,0.2,0.8", help="Of wire, by commas: length x d2 / volume.")
@click.option("--grains", type=int, show_default="1000", help="Grains of sand.")
@click.option("--aspect", type=float, show_default="2", help="Height of the column over its radius.")
@click.option("--friction", type=float, show_default="0.5", help="Of grains, wire and ground.")
@click.option("--diameter", type=float, show_default="0.5", help="Mean diameter d of the grains [mm].")
@click.option("--bead", type=float, show_default="0.3", help="Diameter of the wire's beads, in mean grain diameters.")
@click.option("--seed", type=int, show_default="0", help="Of the random sample.")
@click.option("--refine", type=int, show_default="2", help="Bisections for the least content that stands, if one does.")
@click.option("--tolerance", type=float, show_default="0.01", help="Residual at which a step is solved.")
@click.option("--travel", type=float, show_default="1", help="Way of the fastest grain in a step, in radii of a bead.")
@click.option("--threads", type=int, show_default="2", help="Columns that fall at once.")
@click.option("--quick", is_flag=True, help="A small column and one content, for a look.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("column"),
    show_default=True,
    help="Folder to write.",
)
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
@click.option(
    "--resume", is_flag=True, help="Go on with the interrupted study in the folder; takes no other option but --threads."
)
def column(quick: bool, out: Path, force: bool, resume: bool, **options: Any) -> None:
    """Columns of sand, without and with wire, released from a mould.

    Tells how far each runs out, how high it remains, and from which content of wire on it stands, if it does. Writes
    tables, figures, a picture and a summary, and beside them the runs as run files. Interrupted by Ctrl-C, or killed, it
    goes on by --resume.
    """
    from lmgcpy.experiment.column_folder import ColumnFolder
    from lmgcpy.experiment.column_report import write_report
    from lmgcpy.experiment.column_study import run_study
    from lmgcpy.experiment.stages import Stages

    given = {name: value for name, value in options.items() if value is not None}
    folder = ColumnFolder(out)
    if resume:
        strange = {"quick": quick, "force": force, **{name: name != "threads" for name in given}}
        study = study_to_resume(folder, [name for name, there in strange.items() if there], given)
    else:
        study = new_study(given, quick)
        if not force:
            refuse_what_is_there(folder)
    try:
        written = write_report(run_study(study, Stages(), folder, resume=resume), folder)
    except KeyboardInterrupt:
        click.echo(f"Interrupted; go on with: lmgcpy column --resume --out {out}", err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)
    click.echo(folder.summary.read_text(encoding="utf-8"), nl=False)


def new_study(given: dict[str, Any], quick: bool) -> Any:
    """The study that the options ask for; the quick one keeps every option that the user gave."""
    from lmgcpy.experiment.column_study import ColumnStudy

    fields = {FIELDS.get(name, name): value for name, value in given.items()}
    if "diameter" in fields:
        fields["diameter"] *= 1e-3
    study = ColumnStudy(**fields)
    return replace(study.quick(), **fields) if quick else study


def study_to_resume(folder: Any, strange: list[str], given: dict[str, Any]) -> Any:
    """The study that the folder holds, with as many threads as the user says."""
    if strange:
        options = ", ".join("--" + name for name in sorted(strange))
        raise click.UsageError(f"--resume takes the study as it is in '{folder.study_file}': leave out {options}.")
    return replace(folder.read(), **given)


def refuse_what_is_there(folder: Any) -> None:
    """Keep a folder that is not empty from being written into."""
    if folder.interrupted:
        raise click.ClickException(
            f"The folder '{folder.path}' holds an interrupted study: go on with lmgcpy column --resume --out "
            f"{folder.path}, or begin anew by --force."
        )
    if folder.path.exists() and any(folder.path.iterdir()):
        raise click.ClickException(
            f"The folder '{folder.path}' is not empty: give another by --out, or --force to write there."
        )
