"""The command line: ``lmgcpy texsol``, ``lmgcpy warmup``, and the commands on run files."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import click

import lmgcpy
from lmgcpy import cli_laws, cli_run, cli_warmup
from lmgcpy.errors import closest, shown

EXPECTED = (ValueError, TypeError, LookupError, OSError, RuntimeError, FloatingPointError, ImportError, MemoryError)
"""Kinds of exception that have a sentence for the user."""


class Sentences(click.Group):
    """A group whose commands answer wrong input with a sentence and a non-zero exit, not with a traceback."""

    def make_context(self, *arguments, **options):
        try:
            return super().make_context(*arguments, **options)
        except click.UsageError as error:
            raise one_sentence(error) from error

    def resolve_command(self, ctx: click.Context, args: list[str]):
        if args and not args[0].startswith("-") and self.get_command(ctx, args[0]) is None:
            raise click.UsageError(f"There is no command '{args[0]}'{closest(args[0], self.list_commands(ctx))}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context):
        try:
            return super().invoke(ctx)
        except (click.exceptions.Exit, click.Abort, BrokenPipeError):  # of --help, Ctrl-C, a reader that had enough
            raise
        except click.UsageError as error:
            raise one_sentence(error) from error
        except click.ClickException:
            raise
        except Exception as error:
            if ctx.params.get("traceback"):
                raise
            message = str(error)
            if isinstance(error, OSError) and error.filename is not None and error.strerror:  # as the system says it
                message = f"'{error.filename}' cannot be used: {error.strerror[0].lower()}{error.strerror[1:]}."
            if not isinstance(error, EXPECTED) or isinstance(error, KeyError):
                message = f"This is an error of lmgcpy: {shown(error)}. Please report it, with what --traceback shows."
            raise click.ClickException(message) from error


class WrongUse(click.ClickException):
    """A wrong use of the command line, without the lines on usage that click puts before it."""

    exit_code = 2


def one_sentence(error: click.UsageError) -> click.ClickException:
    if isinstance(error, getattr(click.exceptions, "NoArgsIsHelpError", ())):
        return error
    text = error.format_message()
    return WrongUse(text if text.endswith((".", "?", ")")) else f"{text}.")


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
@click.option(
    "--resume", is_flag=True, help="Go on with the interrupted study in the folder; takes no other option but --threads."
)
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
    resume: bool,
) -> None:
    """The paper's 2D study: biaxial compression of sand and of wire-reinforced sand.

    Prepares a sample, crushes it once per law, and writes tables, figures and a summary, and beside them the runs as run
    files. Interrupted by Ctrl-C, or killed, it goes on by --resume.
    """
    from lmgcpy.experiment.stages import Stages
    from lmgcpy.experiment.texsol_2d import Study, run_study
    from lmgcpy.experiment.texsol_folder import StudyFolder
    from lmgcpy.experiment.texsol_report import write_report

    context = click.get_current_context()
    folder = StudyFolder(out)
    if resume:
        study = study_to_resume(folder, context)
    else:
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
            study = quick_but(study, context)
        if not force:
            refuse_what_is_there(folder)
    try:
        result = run_study(study, Stages(), folder, resume=resume)
        written = write_report(result, out)
    except KeyboardInterrupt:
        click.echo(f"Interrupted; go on with: lmgcpy texsol --resume --out {out}", err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)
    click.echo(folder.summary.read_text(encoding="utf-8"), nl=False)


def given_options(context: click.Context) -> set[str]:
    """Names of the options that the user gave."""
    default = click.core.ParameterSource.DEFAULT
    return {name for name in context.params if context.get_parameter_source(name) is not default}


def quick_but(study, context: click.Context):
    """The quick study, but with every option that the user gave."""
    options = (("grain_count", "grains"), ("bead_count", "beads"), ("strain", "strain"))
    given = {field: getattr(study, field) for field, option in options if option in given_options(context)}
    return replace(study.quick(), **given)


def study_to_resume(folder, context: click.Context):
    """The study that the folder holds, with as many threads as the user says."""
    given = given_options(context)
    strange = sorted(given - {"resume", "out", "threads"})
    if strange:
        names = ", ".join("--" + name.replace("_", "-") for name in strange)
        raise click.UsageError(f"--resume takes the study as it is in '{folder.study_file}': leave out {names}.")
    study = folder.read()
    return replace(study, threads=context.params["threads"]) if "threads" in given else study


def refuse_what_is_there(folder) -> None:
    """Keep a folder that is not empty from being written into."""
    if folder.interrupted:
        raise click.ClickException(
            f"The folder '{folder.path}' holds an interrupted study: go on with lmgcpy texsol --resume --out "
            f"{folder.path}, or begin anew by --force."
        )
    if folder.path.exists() and any(folder.path.iterdir()):
        raise click.ClickException(
            f"The folder '{folder.path}' is not empty: give another by --out, or --force to write there."
        )


for command in (*cli_run.COMMANDS, *cli_laws.COMMANDS, cli_warmup.warmup):
    main.add_command(command)


if __name__ == "__main__":
    sys.exit(main())
