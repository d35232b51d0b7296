"""The command ``lmgcpy texsol``: the paper's study in 2D, and its continuation in 3D."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.options import CommaList, kept_in, options_of, run_study, study_of

FIELDS = {"grains": "grain_count", "beads": "bead_count"}
"""Fields of a study by option, if their names differ."""
ONLY_3D = {
    "slenderness", "wires", "axes", "bead_mass", "wire", "thread_diameter", "node_distance", "dtex", "wire_friction"
}  # fmt: skip
"""Options that only the study in 3D has."""
UNITS = {"strain": 0.01, "pressure": 1e3, "thread_diameter": 1e-3}
"""Units of options that are not in SI."""


def studies() -> dict[str, Any]:
    """The studies in 2D and in 3D with their defaults."""
    from lmgcpy.experiment.texsol.study import STUDIES

    return {f"{dimension}D: ": make() for dimension, make in STUDIES.items()}


option = options_of(studies, FIELDS, UNITS)


@click.command()
@click.option("--dimension", type=click.Choice(["2", "3"]), default="2", help="Dimension of the sample.")
@option("--laws", type=CommaList(str, "rigid-wire,rigid-rod"), help="Laws of the wire, separated by commas.")
@option("--grains", type=int, help="Grains of sand.")
@option("--beads", type=int, help="Beads of the wire.")
@option("--slenderness", type=float, help="3D: height of the sample over its width.")
@option("--wires", type=int, help="3D: wires that share the beads.")
@option("--wire", type=click.Choice(["thread", "beads"]), help="3D: a smooth thread, or a chain of beads.")
@option("--thread-diameter", type=float, help="3D: diameter of the thread [mm]; otherwise a fifth of the smallest grain.")
@option("--node-distance", type=float, help="3D: distance of the thread's nodes [mean grain diameters].")
@option("--dtex", type=float, help="3D: mass of the wire [g per 10 km].")
@option(
    "--wire-friction",
    type=CommaList(float, "0.3,0.2", count=2),
    help="3D: friction of the thread against grains and against itself; otherwise that of the grains.",
)
@option(
    "--bead-mass",
    type=click.Choice(["grain", "own"]),
    help="3D: mass of a bead or node, that of a mean grain or of its part of the wire; of a thread its own.",
)
@option(
    "--axes",
    type=CommaList(str, "x,z"),
    help="3D: axes along which the sample is compressed, separated by commas; z is upright.",
)
@option("--seed", type=int, help="Seed of the random sample.")
@option(
    "--preparation",
    type=click.Choice(["loose", "dense"]),
    help="How the sample is relaxed: with the friction of the test, or without friction.",
)
@option("--theta-max", type=float, help="Greatest turn of the wire from bead to bead as it is laid [rad].")
@option("--strain", type=float, help="Crushing to reach [%].")
@option("--pressure", type=float, help="Pressure on the lateral walls [kPa].")
@option(
    "--solver",
    type=click.Choice(["auto", "accelerated"]),
    help="Solver of the tests: sweeps and Newton steps, or sweeps alone.",
)
@option("--tolerance", type=float, help="Residual at which a step is solved.")
@option(
    "--greatest-reaction",
    type=float,
    help="A test ends where the reaction exceeds so many times pressure x area; by default where the sample is locked.",
)
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
    from lmgcpy.experiment.study.folder import StudyFolder
    from lmgcpy.experiment.texsol.study import TexSolStudy

    folder = StudyFolder(out or Path("texsol" if dimension == "2" else "texsol-3d"), TexSolStudy)
    how = {"quick": quick, "force": force, "resume": resume}
    run_study(folder, options, lambda given: new_study(int(dimension), given, quick), **how)


def new_study(dimension: int, given: dict[str, Any], quick: bool) -> Any:
    """The study that the options ask for; see :func:`lmgcpy.cli.options.study_of`."""
    from lmgcpy.experiment.texsol.study import STUDIES

    strange = sorted(ONLY_3D & given.keys())
    if dimension == 2 and strange:
        options = " and ".join("--" + name.replace("_", "-") for name in strange)
        raise ValueError(f"A study in 2D has no {options}: add --dimension 3, or leave that out.")
    return study_of(STUDIES[dimension], given, quick, FIELDS, UNITS)
