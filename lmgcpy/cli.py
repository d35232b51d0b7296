"""The command line: ``lmgcpy texsol``, and the commands on run files."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import click

import lmgcpy
from lmgcpy import cli_run


class Sentences(click.Group):
    """A group whose commands answer wrong input with a sentence and a non-zero exit, not with a traceback."""

    def invoke(self, ctx: click.Context):
        try:
            return super().invoke(ctx)
        except (ValueError, TypeError, LookupError, OSError, RuntimeError, FloatingPointError) as error:
            if ctx.params.get("traceback"):
                raise
            message = error.args[0] if isinstance(error, KeyError) and error.args else error
            raise click.ClickException(str(message)) from error


@click.group(cls=Sentences, context_settings={"help_option_names": ["-h", "--help"], "show_default": True})
@click.version_option(lmgcpy.__version__, prog_name="lmgcpy")
@click.option("--traceback", is_flag=True, help="Show where in the program an error arose.")
def main(traceback: bool) -> None:
    """Non Smooth Contact Dynamics of rigid bodies, made for wire-reinforced sand."""
    if not traceback:  # a warning is a sentence too, without the line of the program
        warnings.formatwarning = lambda message, *_: f"Warning: {message}\n"


@main.command()
@click.option("--laws", default="none,rigid-wire,rigid-rod", help="Laws of the wire, one test each, by commas.")
@click.option("--grains", type=int, default=1700, help="Grains of sand.")
@click.option("--beads", type=int, default=300, help="Beads of the wire.")
@click.option("--seed", type=int, default=0, help="Of the random sample.")
@click.option("--strain", type=float, default=10.0, help="Crushing to reach [%].")
@click.option("--pressure", type=float, default=100.0, help="On the lateral walls [kPa].")
@click.option("--tolerance", type=float, default=3e-3, help="Residual at which a step is solved.")
@click.option("--axial-rigidity", type=float, default=1e7, help="EA of the elastic laws [N].")
@click.option("--platen-friction", type=float, default=0.0, help="Coefficient of friction at the platens.")
@click.option("--threads", type=int, default=2, help="Tests that run at once.")
@click.option("--quick", is_flag=True, help="A small sample and less crushing, for a look.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=Path("texsol"), help="Folder to write.")
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def texsol(
    laws: str,
    grains: int,
    beads: int,
    seed: int,
    strain: float,
    pressure: float,
    tolerance: float,
    axial_rigidity: float,
    platen_friction: float,
    threads: int,
    quick: bool,
    out: Path,
    force: bool,
) -> None:
    """The paper's 2D study: biaxial compression of sand and of wire-reinforced sand.

    Prepares a sample, crushes it once per law, and writes tables, figures and a summary.
    """
    from lmgcpy.experiment.stages import Stages
    from lmgcpy.experiment.texsol_2d import Study, run_study
    from lmgcpy.experiment.texsol_report import write_report

    study = Study(
        laws=tuple(law.strip() for law in laws.split(",") if law.strip()),
        grain_count=grains,
        bead_count=beads,
        seed=seed,
        strain=0.01 * strain,
        pressure=1e3 * pressure,
        tolerance=tolerance,
        axial_rigidity=axial_rigidity,
        platen_friction=platen_friction,
        threads=threads,
    )
    if quick:
        study = quick_but(study, click.get_current_context())
    if out.exists() and any(out.iterdir()) and not force:
        raise click.ClickException(f"The folder '{out}' is not empty: give another by --out, or --force to write there.")
    result = run_study(study, Stages())
    for path in write_report(result, out):
        click.echo(path)
    click.echo((out / "summary.md").read_text(encoding="utf-8"), nl=False)


def quick_but(study, context: click.Context):
    """The quick study, but with every option that the user gave."""
    given = {
        field: getattr(study, field)
        for field, option in (("grain_count", "grains"), ("bead_count", "beads"), ("strain", "strain"))
        if context.get_parameter_source(option) is not click.core.ParameterSource.DEFAULT
    }
    return replace(study.quick(), **given)


for command in cli_run.COMMANDS:
    main.add_command(command)


if __name__ == "__main__":
    sys.exit(main())
