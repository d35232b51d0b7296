"""Figures of a campaign: mean curves with their intervals, by group of parameters."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lmgcpy.experiment.campaign.curve_means import MeanCurve, MeanCurves
from lmgcpy.experiment.campaign.tables import all_keys
from lmgcpy.experiment.campaign.words import file_word, name_and_unit
from lmgcpy.view.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 8
"""Most curves of a figure."""
LONGEST = 200
"""Most characters of a name; systems allow 255 with the ending."""
WIDE = 88
"""Characters in a line of the title or of the legend."""
NONE = "–"
"""A parameter that a group does not have."""


def campaign_figures(of_column: MeanCurves) -> Iterator[tuple[str, Figure]]:
    """The figures of a column by names that are good for files: several if there are more than :data:`MOST` curves."""
    begin = "-".join(file_word(name_and_unit(name)[0]) or "curve" for name in (of_column.abscissa, of_column.column))
    for part, curves in parts(of_column.curves):
        words = [f"{name} = {value}" for name, value in part.items()]
        name = "-".join([begin, *(file_word(f"{name}={value}") for name, value in part.items())])
        yield name[:LONGEST], _figure(of_column, curves, words)


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
