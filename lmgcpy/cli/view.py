"""Commands that show runs: ``lmgcpy view``, ``render``, ``plot``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

FILE = click.Path(path_type=Path)
WHAT = "layout, grains or forces [default: grains]"


class Axis(click.ParamType):
    """An axis, or an axis and a coordinate: y, or y=0.1."""

    name = "axis"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """As :func:`lmgcpy.view.render` takes it."""
        axis, sign, at = value.partition("=")
        if not sign:
            return axis
        try:
            return axis, float(at)
        except ValueError:
            self.fail(f"'{value}' is no plane such as y or y=0.1", param, ctx)


class Numbers(click.ParamType):
    """Words, or as many numbers by commas as are asked for."""

    name = "numbers"

    def __init__(self, count: int, example: str, words: bool = False):
        self.count, self.example, self.words = count, example, words

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """A tuple, or the word."""
        if self.words and "," not in value:
            return value
        try:
            numbers = tuple(float(part) for part in value.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != self.count:
            self.fail(f"'{value}' is not {self.count} numbers by commas, such as {self.example}", param, ctx)
        return numbers


def looks(command: Callable) -> Callable:
    """Options about how a panel shows a run."""
    for option in (
        click.option("--what", help=WHAT),
        click.option("--grains", help="speed, spin, rotation, coordination, radius, layer, color, plain or hidden."),
        click.option("--wires", help="length, tension, layer, plain or hidden."),
        click.option("--opacity", type=float, help="Of the grains, 0 to 1."),
        click.option("--clip", type=Axis(), help="Leave out the grains before this plane: y, or y=0.1 [m]."),
        click.option("--section", type=Axis(), help="Show what this plane cuts: y, or y=0.1 [m]."),
        click.option("--title", help="Line above, instead of the time."),
        click.option("--limits", type=Numbers(2, "0,1.5"), help="Ends of the colour scale: low,high."),
        click.option("--scale", type=float, help="Force drawn half as thick as a mean grain [N]."),
    ):
        command = option(command)
    return command


@click.command()
@click.argument("file", type=FILE)
@click.option("--frame", type=int, default=-1, help="Which; negative: from the end.")
@click.option("--camera", type=Numbers(3, "1,-1,1", words=True), help="isometric, x, y, z, or a direction: 1,-1,1.")
@looks
def view(file: Path, frame: int, scale: float | None, **how: Any) -> None:
    """Show a frame of a run in a window."""
    from lmgcpy.io.run import open_run
    from lmgcpy.view.pictures import show

    with open_run(file) as run:
        show(run, frame=frame, force=scale, **how)


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option("--frame", type=int, multiple=True, help="Which; negative: from the end [default: the last].")
@click.option(
    "--camera",
    type=Numbers(3, "1,-1,1", words=True),
    multiple=True,
    help="isometric, x, y, z, or a direction: 1,-1,1 [default: isometric].",
)
@looks
@click.option("--size", type=Numbers(2, "1000,900"), help="Of a panel at the most [pixels]: width,height.")
@click.option("--columns", type=int, help="Panels in a row [default: all].")
@click.option("--fps", type=float, default=20.0, help="Frames a second, of a .gif.")
@click.option("--out", type=FILE, help="File to write, .png or, moving, .gif [default: by the first file's name].")
def render(
    files: tuple[Path, ...],
    frame: tuple[int, ...],
    camera: tuple[Any, ...],
    scale: float | None,
    fps: float,
    out: Path | None,
    what: str | None,
    **how: Any,
) -> None:
    """Draw a frame of a run, or all of them as a moving picture.

    No display is needed. Several files, frames or cameras stand side by side, as many of each. With --what layout a table
    tells which bodies overlap and which links are longer than their reference.
    """
    from lmgcpy.io.run import open_run
    from lmgcpy.view.layout import check
    from lmgcpy.view.pictures import render as draw

    target = Path(f"{files[0].stem}-{what or 'grains'}.png") if out is None else out
    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(file)) for file in files]
        written = draw(
            one_or_list(runs),
            target,
            what=what,
            frame=one_or_list(frame),
            camera=one_or_list(camera),
            force=scale,
            frames_per_second=fps,
            **how,
        )
        if what == "layout":
            for run in runs:
                click.echo(f"{run.path}: {check(run, frame=frame[-1] if frame else None)}")
    click.echo(written)


def one_or_list(values: Sequence[Any]) -> Any:
    """None of none, the one of one, else a list."""
    return list(values) if len(values) > 1 else next(iter(values), None)


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option("--what", default="reaction", help="reaction, deviator, stress, energy or solver.")
@click.option("--out", type=FILE, help="File to write, .png, .svg or .pdf [default: by what it shows].")
def plot(files: tuple[Path, ...], what: str, out: Path | None) -> None:
    """Draw curves of one run or of several, one over the other."""
    from lmgcpy.io.run import open_run
    from lmgcpy.view.curves import plot as draw

    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(file)) for file in files]
        click.echo(draw(runs, Path(f"{what}.png") if out is None else out, what=what))


COMMANDS = (view, render, plot)
