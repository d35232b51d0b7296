"""The report of a campaign: a page with counts, means over the seeds and errors, and figures of the curves."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from lmgcpy.errors import LARGEST
from lmgcpy.experiment.campaign.curve_means import mean_curves
from lmgcpy.experiment.campaign.figures import NONE, campaign_figures
from lmgcpy.experiment.campaign.results import FAILED, FINISHED, TO_COME, CampaignResults, CaseResult
from lmgcpy.experiment.campaign.statistics import CaseGroup, Estimate, groups, mean_and_interval
from lmgcpy.experiment.campaign.tables import all_keys
from lmgcpy.experiment.campaign.words import in_words
from lmgcpy.experiment.study.report import ReportFolder, sections
from lmgcpy.writing import markdown_table, write_text

NONE_FINISHED = "No case is finished yet: there are no results and no figures."
ON_INTERVALS = (
    "Each mean is over the finished cases that differ by their seed only; their number stands beside it. The standard "
    "error is s / √n. The interval is the percentile bootstrap interval of the mean. That of few seeds is too narrow: of 5 "
    "normal values it holds the true mean in 84 % of all samples, of 10 in 90 %, of 30 in 94 %."
)


def write_report(results: CampaignResults, folder: Path) -> list[Path]:
    """Write ``report.md`` and the figures of the curves into a folder, which is made if it is missing; returns the files.

    The campaign may still be under way; files of a former report are replaced.
    """
    report = ReportFolder(folder)
    report.file("report.md")  # the first of the files, though it is written last: it shows the figures
    shown, left_out = _write_figures(results, report)
    parts = [_counts_part(results.cases), _failed_part(results.cases), _numbers_part(groups(results))]
    parts += [_figures_part(shown, left_out), _versions_part(results.cases)]
    page, *_ = report.written
    write_text(page, sections(escaped(f"Campaign {results.name}"), parts))
    return report.written


def _write_figures(results: CampaignResults, report: ReportFolder) -> tuple[list[str], list[str]]:
    """Write the figures; returns their files, and sentences on the curves that they lack."""
    files: list[str] = []
    left_out: list[str] = []
    for of_column in mean_curves(results):
        left_out += of_column.left_out
        for name, drawn in campaign_figures(of_column):
            files.append(_new_name(name, files))
            report.figure(files[-1], drawn)
    return files, left_out


def _new_name(name: str, taken: Sequence[str]) -> str:
    """A file that is not taken, on systems either that do not tell capitals."""
    small = {file.lower() for file in taken}
    number, file = 2, f"{name}.png"
    while file.lower() in small:
        file, number = f"{name}-{number}.png", number + 1
    return file


# ----------------------------------------------------------------------------------------------------------------- parts


def _counts_part(cases: Sequence[CaseResult]) -> str:
    count = Counter(case.status for case in cases)
    ended = [case.seconds for case in cases if case.status != TO_COME]
    told = [f"{_many(len(cases))}: {count[FINISHED]} finished, {count[FAILED]} failed, {count[TO_COME]} to come."]
    if ended:
        mean = sum(ended) / len(ended)
        told.append(f"Those that ended took {sum(ended):.4g} s in all, {mean:.4g} s on the average.")
    if count[TO_COME] and count[FINISHED]:
        told.append("The campaign is not at its end: what follows is of the cases that are finished.")
    return " ".join(told) + ("" if count[FINISHED] else f"\n\n{NONE_FINISHED}")


def _failed_part(cases: Sequence[CaseResult]) -> str:
    rows = [[case.name, case.error] for case in cases if case.status == FAILED]
    return f"## Cases that failed\n\n{table(['case', 'error'], rows)}" if rows else ""


def _numbers_part(found: Sequence[CaseGroup]) -> str:
    names = all_keys(case.numbers for group in found for case in group.cases)
    tables = [f"### {escaped(name)}\n\n{_number_table(name, found)}" for name in names]
    return "\n\n".join(["## Results", ON_INTERVALS, *tables]) if tables else ""


def _number_table(name: str, found: Sequence[CaseGroup]) -> str:
    parameters = all_keys(group.parameters for group in found)
    rows = []
    for group in found:
        values = [case.numbers[name] for case in group.cases if abs(case.numbers.get(name, math.nan)) <= LARGEST]
        if values:
            words = [in_words(group.parameters[each]) if each in group.parameters else NONE for each in parameters]
            rows.append([*words, str(len(values)), *estimate_words(mean_and_interval(values))])
    if not rows:
        return "No case has a finite value."
    return table([*parameters, "seeds", "mean", "standard error", "95 % interval"], rows)


def _figures_part(files: Sequence[str], left_out: Sequence[str]) -> str:
    if not files and not left_out:
        return ""
    on = "Means over the seeds where all runs of a group have values, with the interval at each place for itself."
    pictures = [f"![{file.removesuffix('.png')}]({file})" for file in files]
    missing = ["Curves that are left out:\n\n" + "\n".join(f"* {escaped(line)}" for line in left_out)] if left_out else []
    return "\n\n".join(["## Curves", *([on] if files else []), *pictures, *missing])


def _versions_part(cases: Sequence[CaseResult]) -> str:
    rows = []
    for name in all_keys(case.versions for case in cases):
        count = Counter(case.versions[name] for case in cases if name in case.versions)
        rows += [[name, version, str(many)] for version, many in count.items()]
    return f"## Versions\n\n{table(['of', 'version', 'cases'], rows)}" if rows else ""


def _many(count: int) -> str:
    return "1 case" if count == 1 else f"{count} cases"


# -------------------------------------------------------------------------------------------------------------- in words


def estimate_words(estimate: Estimate) -> list[str]:
    """Mean, standard error and interval, to the second digit of the standard error."""
    if estimate.count == 1:
        return [f"{estimate.mean:.6g}", NONE, NONE]
    if not estimate.error > 1e-12 * abs(estimate.mean):  # equal but for round-off
        return [f"{estimate.mean:.6g}", "0", f"{estimate.low:.6g} to {estimate.high:.6g}"]
    last = math.floor(math.log10(estimate.error)) - 1
    mean, error, low, high = (
        to_digit(value, last) for value in (estimate.mean, estimate.error, estimate.low, estimate.high)
    )
    return [mean, error, f"{low} to {high}"]


def to_digit(value: float, last: int) -> str:
    """A number to the digit of ``10**last``: with a decimal point if that is short, else with an exponent."""
    if last > -8 and abs(value) < 1e8:
        return f"{round(value, -last) + 0.0:.{max(0, -last)}f}"  # no -0.00
    digits = math.floor(math.log10(abs(value))) - last if value else 0
    return f"{value:.{max(0, digits)}e}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown, with all entries as they read."""
    return "\n".join(markdown_table(map(escaped, head), [map(escaped, row) for row in rows]))


def escaped(text: str) -> str:
    r"""A text in one line whose ``|``, ``<``, ``*`` and so on are no signs of Markdown; ``_`` within a word is none."""
    line = re.sub(r"([\\|<*`])", r"\\\1", " ".join(text.split()))
    return re.sub(r"(?<!\w)_+|_+(?!\w)", lambda found: r"\_" * len(found[0]), line)
