"""The command ``lmgcpy example``."""

from __future__ import annotations

from pathlib import Path

import click

from lmgcpy.examples import EXAMPLES, GROUPS, named, run


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "every", is_flag=True, help="Run all examples.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("."),
    show_default="the current folder",
    help="Folder in which each example makes its own.",
)
def example(names: tuple[str, ...], every: bool, out: Path) -> None:
    """List the examples, or run those that are named.

    An example is a script of at most a page: a geotechnical test, a machine, a net. It prints what it finds beside what is
    known beforehand. Its folder, of its name, holds a copy of the script to change, and a picture if pyvista is installed.
    """
    if every and names:
        raise click.UsageError("--all runs every example: leave out the names.")
    if not (every or names):
        width = max(map(len, EXAMPLES))
        for title, group in GROUPS.items():
            click.echo(f"{title}\n" + "".join(f"  {one.name:<{width}}  {one.line}\n" for one in group))
        click.echo("lmgcpy example NAME runs one, in a folder of its name.")
        return
    for one in [named(name) for name in names] or EXAMPLES.values():
        click.echo(one.line)
        try:
            picture = run(one, out / one.name)
        except ImportError as error:
            click.echo(f"No picture was drawn: {error}", err=True)
            picture = None
        click.echo(f"Written: {out / one.name / one.file}" + (f", {picture.name}" if picture else ""))
