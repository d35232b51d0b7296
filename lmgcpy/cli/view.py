"""Commands that show runs: ``lmgcpy view``, ``render``, ``plot``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from lmgcpy.cli.options import CommaList
from lmgcpy.writing import check_target

FILE = click.Path(path_type=Path)
CAMERA = CommaList(float, "1,-1,1", count=3, or_word=True)


class Plane(click.ParamType):
    """An axis, or an axis and a coordinate [m]: y, or y=0.1."""

    name = "axis"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The axis, or the axis and the coordinate, as :func:`lmgcpy.view.render` takes them."""
        axis, sign, at = value.partition("=")
        if not sign:
            return axis
        try:
            return axis, float(at)
        except ValueError:
            self.fail(f"'{value}' is no plane such as y or y=0.1", param, ctx)


class Region(click.ParamType):
    """Two corners: x,y,x,y, or x,y,z,x,y,z."""

    name = "corners"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The corners as :func:`lmgcpy.view.render` takes them."""
        if value == "everything":
            return value
        try:
            numbers = tuple(float(word) for word in value.split(","))
        except ValueError:
            numbers = ()
        if len(numbers) not in (4, 6):
            self.fail(f"'{value}' is no region such as 0,0,1,2", param, ctx)
        half = len(numbers) // 2
        return numbers[:half], numbers[half:]


def panel_options(command: Callable) -> Callable:
    """Add the options of the drawing of a panel."""
    for option in (
        click.option("--what", help="Kind of picture: layout, grains or forces [default: grains]."),
        click.option(
            "--grains",
            help="Colour of the grains: speed, spin, rotation, coordination, radius, layer, color, plain or hidden.",
        ),
        click.option("--wires", help="Colour of the wires: length, tension, layer, plain or hidden."),
        click.option("--opacity", type=float, help="Opacity of the grains, 0 to 1."),
        click.option("--clip", type=Plane(), help="Leave out the grains before this plane: y, or y=0.1 [m]."),
        click.option("--section", type=Plane(), help="Show the cut by this plane: y, or y=0.1 [m]."),
        click.option("--title", help="Line above the panel, instead of the time."),
        click.option("--limits", type=CommaList(float, "0,1.5", count=2), help="Ends of the colour scale: low,high."),
        click.option(
            "--region",
            type=Region(),
            help="What is seen [m]: low and high corner, x,y,x,y or x,y,z,x,y,z; or everything, escaped bodies too.",
        ),
        click.option("--scale", type=float, help="Force whose line is half as thick as a mean grain [N]."),
    ):
        command = option(command)
    return command


force_option = click.option("--force", is_flag=True, help="Replace a file that exists.")


@click.command()
@click.argument("file", type=FILE)
@click.option("--frame", type=int, default=-1, help="Number of the frame; negative: from the end.")
@click.option("--camera", type=CAMERA, help="View: isometric, x, y, z, or a direction: 1,-1,1.")
@panel_options
def view(file: Path, frame: int, scale: float | None, **how: Any) -> None:
    """Show a frame of a run in a window."""
    from lmgcpy.io.run import open_run
    from lmgcpy.view.pictures import show

    with open_run(file) as run:
        show(run, frame=frame, force=scale, **how)


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option(
    "--frame",
    type=int,
    multiple=True,
    help="Number of the frame; negative: from the end [default: the last].",
)
@click.option(
    "--camera",
    type=CAMERA,
    multiple=True,
    help="View: isometric, x, y, z, or a direction: 1,-1,1 [default: isometric].",
)
@panel_options
@click.option("--size", type=CommaList(float, "1000,900", count=2), help="Largest size of a panel [pixels]: width,height.")
@click.option("--columns", type=int, help="Number of panels in a row [default: all].")
@click.option("--fps", type=float, default=20.0, help="Frames a second of what moves.")
@click.option(
    "--out",
    type=FILE,
    help="File to write: .png, .pdf or .svg, or .gif or .mp4 that move [default: named after the first file].",
)
@force_option
def render(
    files: tuple[Path, ...],
    frame: tuple[int, ...],
    camera: tuple[Any, ...],
    scale: float | None,
    fps: float,
    out: Path | None,
    force: bool,
    what: str | None,
    **how: Any,
) -> None:
    """Draw a frame of a run, or all frames as a moving picture.

    No display is needed. Several files, frames or cameras give panels side by side; their numbers must agree. With --what
    layout the command also reports overlapping bodies, and links that exceed their reference length.
    """
    from lmgcpy.io.run import open_run
    from lmgcpy.view.layout import check
    from lmgcpy.view.pictures import render as draw

    target = Path(f"{files[0].stem}-{what or 'grains'}.png") if out is None else out
    check_target(target, force=force, name="--out", instead="give another name by --out, or --force to replace it")
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
    """No value as None, a single value by itself, several values as a list."""
    return list(values) if len(values) > 1 else next(iter(values), None)


@click.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option("--what", default="reaction", help="Curves: reaction, deviator, stress, energy or solver.")
@click.option("--out", type=FILE, help="File to write, .png, .svg or .pdf [default: named after the curves].")
@force_option
def plot(files: tuple[Path, ...], what: str, out: Path | None, force: bool) -> None:
    """Draw curves of one run or of several runs in one figure."""
    from lmgcpy.io.run import open_run
    from lmgcpy.view.curves import plot as draw

    target = Path(f"{what}.png") if out is None else out
    check_target(target, force=force, name="--out", instead="give another name by --out, or --force to replace it")
    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(file)) for file in files]
        click.echo(draw(runs, target, what=what))


COMMANDS = (view, render, plot)
