"""The command ``lmgcpy column``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.options import CommaList, kept_in, options_of, run_study, study_of

FIELDS = {"grains": "grain_count", "bead": "bead_diameter", "refine": "refinements"}
"""Fields of a study by option, if their names differ."""
UNITS = {"diameter": 1e-3}
"""Units of options that are not in SI."""


def studies() -> dict[str, Any]:
    """The study with its defaults."""
    from lmgcpy.experiment.column.study import ColumnStudy

    return {"": ColumnStudy()}


option = options_of(studies, FIELDS, UNITS)


@click.command()
@option(
    "--contents", type=CommaList(float, "0.1,0.4"), help="Contents of wire, separated by commas: length x d^2 / volume."
)
@option("--grains", type=int, help="Grains of sand.")
@option("--aspect", type=float, help="Height of the column over its radius.")
@option("--friction", type=float, help="Friction of grains, wire and ground.")
@option("--diameter", type=float, help="Mean diameter d of the grains [mm].")
@option("--bead", type=float, help="Diameter of the wire's beads, in mean grain diameters.")
@option("--wire", type=click.Choice(["thread", "beads"]), help="A smooth thread, or a chain of beads.")
@option("--node-distance", type=float, help="Greatest distance of the nodes of a thread, in mean grain diameters.")
@option("--seed", type=int, help="Seed of the random sample.")
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
    from lmgcpy.experiment.column.study import ColumnStudy
    from lmgcpy.experiment.study.folder import StudyFolder

    how = {"quick": quick, "force": force, "resume": resume}
    run_study(StudyFolder(out, ColumnStudy), options, lambda given: new_study(given, quick), **how)


def new_study(given: dict[str, Any], quick: bool) -> Any:
    """The study that the options ask for; see :func:`lmgcpy.cli.options.study_of`."""
    from lmgcpy.experiment.column.study import ColumnStudy

    return study_of(ColumnStudy, given, quick, FIELDS, UNITS)
