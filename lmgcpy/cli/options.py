"""Options of commands: values separated by commas, and what commands of studies share: options with the study's defaults,
a folder, ``--force``, ``--resume``, Ctrl-C.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import click

NOUNS: dict[type, str] = {str: "words", int: "whole numbers", float: "numbers"}


class CommaList(click.ParamType):
    """Values of one type, separated by commas, as a tuple.

    ``count``: number of values, any number if None; ``or_word``: a value without a comma is taken as a word.
    """

    def __init__(self, kind: type, example: str, *, count: int | None = None, or_word: bool = False):
        self.name = NOUNS[kind]
        self.kind, self.example, self.count, self.or_word = kind, example, count, or_word

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The tuple, or the word."""
        if not isinstance(value, str) or (self.or_word and "," not in value):
            return value
        parts = [part.strip() for part in value.split(",")]
        if self.count is None:
            parts = [part for part in parts if part]
        try:
            values = tuple(self.kind(part) for part in parts)
        except ValueError:
            values = None
        if values is None or self.count not in (None, len(values)):
            wanted = f"{self.count or 'a list of'} {self.name} separated by commas, such as {self.example}"
            self.fail(f"'{value}' is not {wanted}", param, ctx)
        return values


class OfStudy(click.Option):
    """An option for a field of a study; its help names the default of the study."""

    def __init__(self, *arguments: Any, told: Callable[[str], str], **more: Any):
        super().__init__(*arguments, **more)
        self._told = told

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        self.show_default = self._told(str(self.name)) or False  # no default to be named
        return super().get_help_record(ctx)


def options_of(
    studies: Callable[[], dict[str, Any]], fields: Mapping[str, str], units: Mapping[str, float]
) -> Callable[..., Any]:
    """``click.option`` for the fields of studies.

    ``studies`` is called when help is asked for and gives the studies with their defaults, by the words that help says
    before these. ``fields``: names of fields by option, if they differ; ``units``: units of options that are not in SI.
    """

    def default_of(option: str) -> str:
        field, unit = fields.get(option, option), units.get(option, 1.0)
        told: dict[str, str] = {}  # each default once, with the words before the first that has it
        for beginning, study in studies().items():
            if getattr(study, field, None) is not None:
                told.setdefault(_in_words(getattr(study, field), unit), beginning if told else "")
        return "; ".join(beginning + default for default, beginning in told.items())

    return partial(click.option, cls=OfStudy, told=default_of)


def study_of(
    kind: Callable[..., Any], given: Mapping[str, Any], quick: bool, fields: Mapping[str, str], units: Mapping[str, float]
) -> Any:
    """The study of this class that the options ask for; the quick one keeps every option that the user gave."""
    asked = {fields.get(name, name): value * units[name] if name in units else value for name, value in given.items()}
    study = kind(**asked)
    return replace(study.quick(), **asked) if quick else study


def _in_words(value: Any, unit: float) -> str:
    """The default of a field in its unit."""
    if isinstance(value, tuple):
        return ",".join(_in_words(item, unit) for item in value)
    return value if isinstance(value, str) else f"{value / unit:g}"


def kept_in(default: Path | None, *, shown: bool | str = True) -> Callable[[Any], Any]:
    """The options --out, --force and --resume of a command; ``shown``: what its help says of the folder if there is no
    single ``default``."""
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


def run_study(
    folder: Any, options: Mapping[str, Any], new: Callable[[dict[str, Any]], Any], *, quick: bool, force: bool, resume: bool
) -> None:
    """Carry a study out in its folder, and print which files were written and the summary.

    ``new`` makes the study that the options ask for; with ``resume`` it is the one that the folder holds, with the number
    of threads that the user gives.
    """
    from lmgcpy.experiment.study.engine import carry_out_study
    from lmgcpy.experiment.study.stages import Stages

    given = {name: value for name, value in options.items() if value is not None}
    if resume:
        strange = [name for name in given if name != "threads"]
        strange += [name for name, there in (("quick", quick), ("force", force)) if there]
        if strange:
            words = ", ".join("--" + name.replace("_", "-") for name in sorted(strange))
            raise click.UsageError(f"--resume takes the study as it is in '{folder.study_file}': leave out {words}.")
        study = replace(folder.read(), **given)
    else:
        study = new(given)
        if not force:
            refuse_what_is_there(folder)
    try:
        written = study.report(carry_out_study(study, Stages(), folder, resume=resume), folder)
    except KeyboardInterrupt:
        click.echo(f"Interrupted; go on with: lmgcpy {study.COMMAND} --resume --out {folder.path}", err=True)
        sys.exit(130)
    for path in written:
        click.echo(path)
    click.echo(folder.summary.read_text(encoding="utf-8"), nl=False)


def refuse_what_is_there(folder: Any) -> None:
    """Raise if the folder is not empty, so that nothing in it is overwritten."""
    if folder.interrupted:
        raise click.ClickException(
            f"The folder '{folder.path}' holds an interrupted study: go on with lmgcpy {folder.kind.COMMAND} --resume "
            f"--out {folder.path}, or begin anew by --force."
        )
    if folder.path.exists() and any(folder.path.iterdir()):
        raise click.ClickException(
            f"The folder '{folder.path}' is not empty: give another by --out, or --force to write there."
        )
