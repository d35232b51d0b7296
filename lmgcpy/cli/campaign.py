"""The command ``lmgcpy campaign``: many cases of a study on many workers, and the report of their results."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click


class FileOrReport(click.Group):
    """``lmgcpy campaign FILE.toml`` runs a campaign; ``lmgcpy campaign report FOLDER`` reports."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in self.commands and args[0] not in ("-h", "--help"):
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group(cls=FileOrReport)
def campaign() -> None:
    """Many cases of a study on many workers.

    `lmgcpy campaign FILE.toml --out FOLDER` carries a campaign out; `lmgcpy campaign report FOLDER` writes what it gave so
    far.
    """


@campaign.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder to write.  [default: that of FILE]")
@click.option("--workers", type=click.IntRange(1), help="Processes of this machine.  [default: one a processor]")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers do the cases, such as tcp://host:8786.")
@click.option("--scheduler-file", type=click.Path(exists=True, dir_okay=False), help="File that the scheduler has written.")
@click.option("--case-timeout", type=float, metavar="SECONDS", help="Kill a case that takes longer; it has failed.")
@click.option(
    "--resume", is_flag=True, help="Go on with the campaign in the folder, also with more cases; what failed is done again."
)
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
@click.option("--dry-run", is_flag=True, help="Print the cases and what they will cost, and do nothing.")
def run(
    file: Path, out: Path | None, case_timeout: float | None, dry_run: bool, resume: bool, force: bool, **where: Any
) -> None:
    """Carry out the campaign that a TOML file describes.

    Every case has a folder with its run files. Interrupted by Ctrl-C, or killed, the campaign goes on by --resume.
    """
    from lmgcpy.experiment.campaign.campaign import read_campaign

    campaign = read_campaign(file)
    if case_timeout is not None:
        campaign = replace(campaign, case_timeout=case_timeout)
    folder = out or file.with_suffix("")
    if dry_run:
        tell_cost(campaign, folder, where["workers"])
        return
    if where["workers"] is not None and (where["scheduler"] or where["scheduler_file"]):
        raise click.UsageError("--workers are processes of this machine: leave it out with --scheduler.")
    try:
        results = campaign.run(folder, resume=resume, force=force, progress=True, **where)
    except KeyboardInterrupt:
        click.echo(f"Interrupted; go on with: lmgcpy campaign {file} --out {folder} --resume", err=True)
        sys.exit(130)
    write(results, folder)
    failed = [case for case in results.cases if case.status == "failed"]
    if failed:
        first = f"{failed[0].name}: {failed[0].error}"
        click.echo(f"{len(failed)} of {len(results.cases)} cases failed, the first: {first}", err=True)
        sys.exit(1)


@campaign.command()
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False, exists=True))
def report(folder: Path) -> None:
    """Write tables, figures and a page of what a campaign gave so far; it may still run."""
    from lmgcpy.experiment.campaign.cases import CampaignFolder

    write(CampaignFolder(folder).results(), folder)


def write(results: Any, folder: Path) -> None:
    """Write tables and report, and print which files were written."""
    from lmgcpy.experiment.campaign.report import write_report
    from lmgcpy.experiment.campaign.tables import write_tables

    for path in [*write_tables(results, folder), *write_report(results, folder)]:
        click.echo(path)


def tell_cost(campaign: Any, path: Path, workers: int | None) -> None:
    """Print the cases, what each will cost, and all of them."""
    from lmgcpy.experiment.campaign.cases import CampaignFolder, CampaignResults
    from lmgcpy.experiment.campaign.workers import processors

    folder, cases = CampaignFolder(path), campaign.all_cases()
    so_far = folder.results(cases) if folder.description_file.exists() else CampaignResults(path.name, [])
    done = {case.name for case in so_far.finished}
    total, unknown = 0.0, 0
    for case in cases:
        if case.name in done:
            click.echo(f"{case.name}: finished")
            continue
        seconds, source = so_far.expected_seconds(case)
        total, unknown = total + (seconds or 0.0), unknown + (seconds is None)
        click.echo(f"{case.name}: {'unknown' if seconds is None else f'{seconds:.3g} s ({source})'}")
    to_come, count = len(cases) - len(done), workers or processors()
    least = "at least " if unknown else ""
    known = f": {least}{total:.3g} s of one processor, {least}{total / count:.3g} s on {count} workers"
    click.echo(
        f"{to_come} of {len(cases)} cases to come"
        + (known if unknown < to_come or not to_come else "")
        + (f"; the cost of {unknown} is unknown" if unknown else "")
    )
