"""The command ``lmgcpy continuum``: the continuous model beside the runs of a study."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folders", type=click.Path(path_type=Path, file_okay=False), nargs=-1, required=True)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    show_default="continuum in the first folder",
    help="Folder to write.",
)
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def continuum(folders: tuple[Path, ...], out: Path | None, force: bool) -> None:
    """Predict the tests of a TexSol study with a wire from the one without, by the continuous model.

    FOLDERS are the folders of a study with the laws none and elastic-wire or rigid-wire, and of the same study with other
    seeds, as lmgcpy texsol and the cases of lmgcpy campaign write them. The sand is fitted to the test without a wire; the
    wire is taken as it lies. The command writes figures of prediction over run, tables, and the page continuum.md, with the
    local model, in which every link follows the mean strain, and one in which the wire is held by the sand.
    """
    from lmgcpy.experiment.continuum.comparison import compare
    from lmgcpy.experiment.continuum.report import page, write_comparison
    from lmgcpy.io.csv_tables import folder_for

    found = compare(folders, lambda text: click.echo(text, err=True))
    written = write_comparison(found, folder_for(folders[0] / "continuum" if out is None else out, force))
    click.echo(page(found))
    for path in written:
        click.echo(path)
