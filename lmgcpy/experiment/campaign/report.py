"""The report of a campaign: a page with counts, means over the seeds and errors, and figures of the curves."""

from __future__ import annotations

import math
import re
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lmgcpy.errors import LARGEST
from lmgcpy.experiment.campaign.cases import FAILED, FINISHED, TO_COME, CampaignResults, CaseResult, in_words
from lmgcpy.experiment.campaign.statistics import (
    CaseGroup,
    Estimate,
    MeanCurve,
    MeanCurves,
    groups,
    mean_and_interval,
    mean_curves,
)
from lmgcpy.experiment.campaign.tables import all_keys, name_and_unit
from lmgcpy.experiment.study.folder import ReportFolder, sections
from lmgcpy.view.figures import new_figure
from lmgcpy.writing import markdown_table, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8
"""Most curves of a figure."""
LONGEST_NAME = 200
"""Most characters of a name; systems allow 255 with the ending."""
WIDE = 88
"""Characters in a line of the title or of the legend."""
NONE = "–"
"""A parameter that a group does not have."""
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
    parts = [_counts_part(results), _failed_part(results.cases), _numbers_part(groups(results))]
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


def _counts_part(results: CampaignResults) -> str:
    cases = results.cases
    count = Counter(case.status for case in cases)
    ended = [case.seconds for case in cases if case.status != TO_COME]
    told = [f"{_many(len(cases))}: {count[FINISHED]} finished, {count[FAILED]} failed, {count[TO_COME]} to come."]
    if ended:
        mean = sum(ended) / len(ended)
        told.append(f"Those that ended took {sum(ended):.4g} s in all, {mean:.4g} s on the average.")
    if count[TO_COME] and count[FINISHED]:
        told.append("The campaign is not at its end: what follows is of the cases that are finished.")
    if count[TO_COME] and results.left_out:
        lines = "A line" if results.left_out == 1 else f"{results.left_out} lines"
        verb = "does" if results.left_out == 1 else "do"
        told.append(f"{lines} of cases.jsonl {verb} not count: cut short, damaged, or of another campaign's case.")
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


# ----------------------------------------------------------------------------------------------------------------- figures


def campaign_figures(of_column: MeanCurves) -> Iterator[tuple[str, Figure]]:
    """The figures of a column by names that are good for files: several if there are more than :data:`MOST` curves."""
    begin = "-".join(file_word(name_and_unit(name)[0]) or "curve" for name in (of_column.abscissa, of_column.column))
    for part, curves in parts(of_column.curves):
        words = [f"{name} = {value}" for name, value in part.items()]
        name = "-".join([begin, *(file_word(f"{name}={value}") for name, value in part.items())])
        yield name[:LONGEST_NAME], _figure(of_column, curves, words)


def parts(curves: Sequence[MeanCurve]) -> Iterator[tuple[dict[str, str], Sequence[MeanCurve]]]:
    """Curves in parts of at most :data:`MOST`, with what their parts have in common.

    There is a part for each value of the first parameter that varies, and so on. If only one varies, parts follow it.
    """
    if len(curves) <= MOST:
        if curves:
            yield {}, curves
        return
    name, *others = varying(curves)
    if not others:
        for k in range(0, len(curves), MOST):
            some = curves[k : k + MOST]
            yield {name: f"{_word(some[0], name)} to {_word(some[-1], name)}"}, some
        return
    for value in dict.fromkeys(_word(curve, name) for curve in curves):
        for further, some in parts([curve for curve in curves if _word(curve, name) == value]):
            yield {name: value, **further}, some


def varying(curves: Sequence[MeanCurve]) -> list[str]:
    """The parameters in which curves differ."""
    names = all_keys(curve.labels for curve in curves)
    return [name for name in names if len({_word(curve, name) for curve in curves}) > 1]


def _word(curve: MeanCurve, name: str) -> str:
    return curve.labels.get(name, NONE)


def _figure(of_column: MeanCurves, curves: Sequence[MeanCurve], part: Sequence[str]) -> Figure:
    names = varying(curves)
    counts = sorted({curve.band.count for curve in curves})
    texts = [", ".join(_word(curve, name) for name in names) for curve in curves]
    if len(counts) > 1:
        texts = [f"{text} ({_runs(curve.band.count)})" for text, curve in zip(texts, curves, strict=True)]
    columns = max(1, min(4, len(texts), WIDE // (8 + max(map(len, texts)))))
    figure = new_figure(7.0, 4.4 + 0.22 * -(-len(texts) // columns))
    axes = figure.subplots()
    for k, (curve, text) in enumerate(zip(curves, texts, strict=True)):
        one = len(curve.abscissa) == 1
        style: dict[str, Any] = {"color": f"C{k}", "linestyle": "-" if k % 2 == 0 else "--", "marker": "o" if one else ""}
        axes.plot(curve.abscissa, curve.band.mean, label=_label(text), **style)
        if curve.band.count > 1:
            axes.fill_between(curve.abscissa, curve.band.low, curve.band.high, color=f"C{k}", alpha=0.18, linewidth=0.0)
    axes.set_xlabel(of_column.abscissa)
    axes.set_ylabel(of_column.column)
    axes.margins(x=0.0 if len(curves[0].abscissa) > 1 else 0.05)
    axes.set_title(_filled("; ".join([*part, _told(counts)])), fontsize="medium")
    if names:
        figure.legend(
            title=_filled(", ".join(names)), frameon=False, ncols=columns, fontsize="medium", loc="outside lower center"
        )
    return figure


def _told(counts: Sequence[int]) -> str:
    """A sentence on the curves."""
    if counts == [1]:
        return "one run each"
    many = str(counts[0]) if len(counts) == 1 else "several"
    return f"mean of {many} runs, with the 95 % interval"


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"


def _label(text: str) -> str:
    """A text as a label; matplotlib leaves out those that are empty or begin with "_"."""
    return _filled(f" {text}" if text.startswith("_") else text or NONE)


def _filled(text: str) -> str:
    return textwrap.fill(text.replace("$", r"\$"), WIDE)  # matplotlib takes dollars for formulas


def file_word(text: str) -> str:
    """A text as a part of the name of a file: at most 80 letters, digits and ``.+=_-``."""
    return re.sub(r"[^\w.+=-]+", "-", text, flags=re.ASCII).strip("-.")[:80]
