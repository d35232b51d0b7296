"""The command line: studies, commands on run files, problems and laws, and ``lmgcpy warmup``."""

from __future__ import annotations

import warnings

import click

import lmgcpy
from lmgcpy.cli import campaign, column, continuum, example, fields, laws, measure, run, solve, texsol, view, warmup
from lmgcpy.errors import closest, shown

EXPECTED = (ValueError, TypeError, LookupError, OSError, RuntimeError, FloatingPointError, ImportError, MemoryError)
"""Exceptions whose message is a sentence for the user."""


class Sentences(click.Group):
    """A group of commands that answer wrong input with a sentence and a non-zero exit code, without a traceback."""

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
        except (click.exceptions.Exit, click.Abort, BrokenPipeError):  # --help, Ctrl-C, a closed pipe
            raise
        except click.UsageError as error:
            raise one_sentence(error) from error
        except click.ClickException:
            raise
        except Exception as error:
            if ctx.params.get("traceback"):
                raise
            message = str(error)
            if isinstance(error, OSError) and error.filename is not None and error.strerror:  # raised by the system
                message = f"'{error.filename}' cannot be used: {error.strerror[0].lower()}{error.strerror[1:]}."
            if not isinstance(error, EXPECTED) or isinstance(error, KeyError):
                message = f"This is an error of lmgcpy: {shown(error)}. Please report it, with the output of --traceback."
            raise click.ClickException(message) from error


class WrongUse(click.ClickException):
    """A wrong use of the command line, shown without click's lines on usage."""

    exit_code = 2


def one_sentence(error: click.UsageError) -> click.ClickException:
    """The error as one sentence."""
    if isinstance(error, getattr(click.exceptions, "NoArgsIsHelpError", ())):
        return error
    text = error.format_message()
    return WrongUse(text if text.endswith((".", "?", ")")) else f"{text}.")


@click.group(cls=Sentences, context_settings={"help_option_names": ["-h", "--help"], "show_default": True})
@click.version_option(lmgcpy.__version__, prog_name="lmgcpy")
@click.option("--traceback", is_flag=True, help="Show the traceback of an error.")
def main(traceback: bool) -> None:
    """Non Smooth Contact Dynamics of rigid bodies, made for wire-reinforced sand."""
    if not traceback:  # show warnings as sentences, without the line of the program
        warnings.formatwarning = lambda message, *_: f"Warning: {message}\n"


for command in (
    example.example,
    texsol.texsol,
    column.column,
    campaign.campaign,
    continuum.continuum,
    *run.COMMANDS,
    measure.measure,
    fields.fields,
    *solve.COMMANDS,
    *laws.COMMANDS,
    *view.COMMANDS,
    warmup.warmup,
):
    main.add_command(command)
