"""What the commands that make studies have in common: a folder that is kept, ``--force``, ``--resume``, and Ctrl-C."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click


class OfStudy(click.Option):
    """An option that stands for a field of a study; its help tells the default that the study has."""

    def __init__(self, *arguments: Any, told: Callable[[str], str], **more: Any):
        super().__init__(*arguments, **more)
        self._told = told

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        self.show_default = self._told(str(self.name))
        return super().get_help_record(ctx)


def options_of(
    studies: Callable[[], dict[str, Any]], fields: Mapping[str, str], units: Mapping[str, float]
) -> Callable[..., Any]:
    """``click.option`` for the fields of studies; ``studies`` gives them with their defaults, by what is said before those,
    when help asks.

    ``fields``: names of fields by option, where they are not called alike; ``units``: of options that are not in SI units.
    """

    def default_of(option: str) -> str:
        field, unit = fields.get(option, option), units.get(option, 1.0)
        told: dict[str, str] = {}  # each default once, with what is said before the first that has it
        for beginning, study in studies().items():
            if hasattr(study, field):
                told.setdefault(_in_words(getattr(study, field), unit), beginning if told else "")
        return "; ".join(beginning + default for default, beginning in told.items())

    return partial(click.option, cls=OfStudy, told=default_of)


def _in_words(value: Any, unit: float) -> str:
    """The default of a field, in so large a unit."""
    if isinstance(value, tuple):
        return ",".join(item if isinstance(item, str) else f"{item:g}" for item in value)
    return f"{value / unit:g}"


def kept_in(default: Path | None, *, shown: bool | str = True) -> Callable[[Any], Any]:
    """The options --out, --force and --resume of a command; ``shown``: what its help says of the folder where no one
    ``default`` is."""
    folder = click.Path(path_type=Path, file_okay=False)
    options = [
        click.option("--out", type=folder, default=default, show_default=shown, help="Folder to write."),
        click.option("--force", is_flag=True, help="Write into a folder that is not empty."),
        click.option(
            "--resume",
            is_flag=True,
            help="Go on with the interrupted study in the folder; takes no other option but --threads.",
        ),
    ]

    def add(command: Any) -> Any:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def study_in(folder: Any, given: dict[str, Any], *, quick: bool, force: bool, resume: bool, new: Callable[[], Any]) -> Any:
    """The study to be carried out in a folder: the ``new`` one that the options ``given`` ask for, or the one that the
    folder holds, with as many threads as the user says."""
    if not resume:
        study = new()
        if not force:
            refuse_what_is_there(folder)
        return study
    strange = [name for name in given if name != "threads"]
    strange += [name for name, there in (("quick", quick), ("force", force)) if there]
    if strange:
        options = ", ".join("--" + name.replace("_", "-") for name in sorted(strange))
        raise click.UsageError(f"--resume takes the study as it is in '{folder.study_file}': leave out {options}.")
    return replace(folder.read(), **given)


def refuse_what_is_there(folder: Any) -> None:
    """Keep a folder that is not empty from being written into."""
    if folder.interrupted:
        raise click.ClickException(
            f"The folder '{folder.path}' holds an interrupted study: go on with lmgcpy {folder.COMMAND} --resume --out "
            f"{folder.path}, or begin anew by --force."
        )
    if folder.path.exists() and any(folder.path.iterdir()):
        raise click.ClickException(
            f"The folder '{folder.path}' is not empty: give another by --out, or --force to write there."
        )


def tell(folder: Any, carry_out: Callable[[], list[Path]]) -> None:
    """Carry a study out, and say which files were written, and what is in the summary."""
    try:
        written = carry_out()
    except KeyboardInterrupt:
        click.echo(f"Interrupted; go on with: lmgcpy {folder.COMMAND} --resume --out {folder.path}", err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)
    click.echo(folder.summary.read_text(encoding="utf-8"), nl=False)
