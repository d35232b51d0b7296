"""The command ``lmgcpy continuum``: the continuous model beside the runs of a study."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folders", type=click.Path(path_type=Path, file_okay=False), nargs=-1, required=True)
@click.option(
    "--measured-in",
    type=click.Path(path_type=Path, file_okay=False),
    multiple=True,
    help="Folder of a study of another size or content, in which the wire's anchorage is measured; may be repeated.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    show_default="continuum in the first folder",
    help="Folder to write.",
)
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
def continuum(folders: tuple[Path, ...], measured_in: tuple[Path, ...], out: Path | None, force: bool) -> None:
    """Predict the tests of a TexSol study with a wire from the one without, by the continuous model.

    FOLDERS are the folders of a study with the laws none and elastic-wire or rigid-wire, and of the same study with other
    seeds, as lmgcpy texsol and the cases of lmgcpy campaign write them. The sand is fitted to the test without a wire; the
    wire is taken as it lies. The command writes figures of prediction over run, tables, and the page continuum.md, with the
    local model, in which every link follows the mean strain, and one in which the wire is held by the sand. How it is held
    is measured in the tests of the other seeds, or in samples of another size.
    """
    from lmgcpy.experiment.continuum.comparison import compare
    from lmgcpy.experiment.continuum.report import page, write_comparison
    from lmgcpy.io.csv_tables import folder_for

    def tell(text: str) -> None:
        click.echo(text, err=True)

    source = compare(measured_in, tell) if measured_in else None
    found = compare(folders, tell, source)
    written = write_comparison(found, folder_for(folders[0] / "continuum" if out is None else out, force))
    click.echo(page(found))
    for path in written:
        click.echo(path)
