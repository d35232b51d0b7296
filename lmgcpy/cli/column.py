"""The command ``lmgcpy column``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.study_options import kept_in, options_of, study_in, tell

FIELDS = {"grains": "grain_count", "bead": "bead_diameter", "refine": "refinements"}
"""Fields of a study whose options have other names."""
UNITS = {"diameter": 1e-3}
"""Of options that are not in SI units."""


class Contents(click.ParamType):
    """Numbers by commas."""

    name = "numbers"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """As :class:`lmgcpy.experiment.column_study.ColumnStudy` takes them."""
        try:
            return tuple(float(part) for part in value.split(",") if part.strip())
        except ValueError:
            self.fail(f"'{value}' is not numbers by commas, such as 0.1,0.4", param, ctx)


def studies() -> dict[str, Any]:
    """The study as it is if nothing is said."""
    from lmgcpy.experiment.column_study import ColumnStudy

    return {"": ColumnStudy()}


option = options_of(studies, FIELDS, UNITS)


@click.command()
@option("--contents", type=Contents(), help="Of wire, by commas: length x d2 / volume.")
@option("--grains", type=int, help="Grains of sand.")
@option("--aspect", type=float, help="Height of the column over its radius.")
@option("--friction", type=float, help="Of grains, wire and ground.")
@option("--diameter", type=float, help="Mean diameter d of the grains [mm].")
@option("--bead", type=float, help="Diameter of the wire's beads, in mean grain diameters.")
@option("--seed", type=int, help="Of the random sample.")
@option("--refine", type=int, help="Bisections for the least content that stands, if one does.")
@option("--tolerance", type=float, help="Residual at which a step is solved.")
@option("--travel", type=float, help="Way of the fastest grain in a step, in radii of a bead.")
@option("--threads", type=int, help="Columns that fall at once.")
@click.option("--quick", is_flag=True, help="A small column and one content, for a look.")
@kept_in(Path("column"))
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
    how = {"quick": quick, "force": force, "resume": resume}
    study = study_in(folder, given, **how, new=lambda: new_study(given, quick))
    tell(folder, lambda: write_report(run_study(study, Stages(), folder, resume=resume), folder))


def new_study(given: dict[str, Any], quick: bool) -> Any:
    """The study that the options ask for; the quick one keeps every option that the user gave."""
    from lmgcpy.experiment.column_study import ColumnStudy

    fields = {FIELDS.get(name, name): value * UNITS[name] if name in UNITS else value for name, value in given.items()}
    study = ColumnStudy(**fields)
    return replace(study.quick(), **fields) if quick else study
