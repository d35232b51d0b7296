"""The command ``lmgcpy texsol``: the paper's study in 2D, and its continuation in 3D."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.study_options import kept_in, options_of, study_in, tell

FIELDS = {"grains": "grain_count", "beads": "bead_count"}
"""Fields of a study by option, where they are not called alike."""
IN_SPACE = {"wires", "axes"}
"""Options of 3D."""
UNITS = {"strain": 0.01, "pressure": 1e3}
"""Of options that are not in SI units."""


def field_value(option: str, value: Any) -> Any:
    """An option as a study takes it."""
    if option in ("laws", "axes"):
        return tuple(word.strip() for word in value.split(",") if word.strip())
    return value * UNITS.get(option, 1)


def studies() -> dict[str, Any]:
    """Those in 2D and in 3D, as they are if nothing is said."""
    from lmgcpy.experiment.texsol_folder import STUDIES

    return {f"{dimension}D: ": make() for dimension, make in STUDIES.items()}


option = options_of(studies, FIELDS, UNITS)


@click.command()
@click.option("--dimension", type=click.Choice(["2", "3"]), default="2", help="Of the sample.")
@option("--laws", help="Of the wire, by commas.")
@option("--grains", type=int, help="Grains of sand.")
@option("--beads", type=int, help="Beads of the wire.")
@option("--wires", type=int, help="3D: wires that share the beads.")
@option("--axes", help="3D: axes along which the sample is compressed, by commas; z is upright.")
@option("--seed", type=int, help="Of the random sample.")
@option("--strain", type=float, help="Crushing to reach [%].")
@option("--pressure", type=float, help="On the lateral walls [kPa].")
@option("--tolerance", type=float, help="Residual at which a step is solved.")
@option("--axial-rigidity", type=float, help="EA of the elastic laws [N].")
@option("--platen-friction", type=float, help="Coefficient of friction at the platens.")
@option("--threads", type=int, help="Tests that run at once.")
@click.option("--quick", is_flag=True, help="A small sample and less crushing, for a look.")
@kept_in(None, shown="texsol; 3D: texsol-3d")
def texsol(dimension: str, quick: bool, out: Path | None, force: bool, resume: bool, **options: Any) -> None:
    """The paper's study: compression of sand without and with wire.

    Prepares a sample, crushes it once per law, and writes tables, figures and a summary, and beside them the runs as run
    files. In 2D biaxial tests (section 3 of the paper); in 3D triaxial tests of a sample with the wire in layers, across
    and along them (section 4). Interrupted by Ctrl-C, or killed, it goes on by --resume.
    """
    from lmgcpy.experiment.stages import Stages
    from lmgcpy.experiment.texsol_folder import StudyFolder

    given = {name: value for name, value in options.items() if value is not None}
    folder = StudyFolder(out or Path("texsol" if dimension == "2" else "texsol-3d"))
    how = {"quick": quick, "force": force, "resume": resume}
    study = study_in(folder, given, **how, new=lambda: new_study(int(dimension), given, quick))
    tell(folder, lambda: carry_out(study, Stages(), folder, resume))


def carry_out(study: Any, stages: Any, folder: Any, resume: bool) -> list[Path]:
    """Compute and report; the files written."""
    if study.DIMENSION == 2:
        from lmgcpy.experiment.texsol_2d import run_study
        from lmgcpy.experiment.texsol_report import write_report

        return write_report(run_study(study, stages, folder, resume=resume), folder.path)
    from lmgcpy.experiment.texsol_3d import run_study_3d
    from lmgcpy.experiment.texsol_report_3d import write_report_3d

    return write_report_3d(run_study_3d(study, stages, folder, resume=resume), folder)


def new_study(dimension: int, given: dict[str, Any], quick: bool) -> Any:
    """The study that the options ask for; the quick one keeps every option that the user gave."""
    from lmgcpy.experiment.texsol_folder import STUDIES

    strange = sorted(IN_SPACE & given.keys())
    if dimension == 2 and strange:
        options = " and ".join("--" + name for name in strange)
        raise ValueError(f"A study in 2D has no {options}: add --dimension 3, or leave that out.")
    fields = {FIELDS.get(name, name): field_value(name, value) for name, value in given.items()}
    study = STUDIES[dimension](**fields)
    return replace(study.quick(), **fields) if quick else study
