"""Output of ``lmgcpy continuum``: a page, a table of the errors of the models, curves, and a figure for every test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.continuum import Directions
from lmgcpy.errors import AXES
from lmgcpy.experiment.continuum.comparison import Comparison, Miss, Prediction, mean_curves, miss
from lmgcpy.experiment.study.folder import ReportFolder, made_with, markdown, sections, texts
from lmgcpy.view.figures import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MODELS = {
    "local": "local model",
    "anchored": "anchored wire",
    "stronger": "anchored in stronger sand",
    "coulomb": "the same after Mohr and Coulomb",
}
"""The models by their field in a prediction. The last is for samples in space: in the plane it is the one before."""
COLORS = {
    "sand": "tab:olive",
    "run": "black",
    "local": "tab:red",
    "anchored": "tab:blue",
    "stronger": "tab:green",
    "coulomb": "tab:purple",
}
HIGHEST = 1.6
"""Greatest ordinate of a figure over the greatest ordinate of the run: the local model leaves the figure."""


def write_comparison(found: Comparison, path: Path) -> list[Path]:
    """Write the report into a folder; returns the paths, the page last."""
    folder = ReportFolder(path)
    for name, many in found.predictions.items():
        folder.figure(f"prediction-{name}.png", figure(name, many))
    folder.table("curves.csv", [columns(name, one) for name, many in found.predictions.items() for one in many])
    folder.table("errors.csv", [error_columns(found)])
    folder.text("continuum.md", page(found))
    return folder.written


def models_of(many: list[Prediction]) -> dict[str, str]:
    """The models of a test, by their field in its predictions."""
    return {kind: words for kind, words in MODELS.items() if getattr(many[0], kind) is not None}


def columns(name: str, one: Prediction) -> dict[str, list[str]]:
    """Columns of the curves of a test: the run, the sand, both models."""
    moments = np.linspace(0.0, float(one.run.crushing[-1]), 101)[1:]
    table = {"test": [name] * 100, "seed": [str(one.seed)] * 100, "crushing": texts(moments, ".5g")}
    for kind in ("run", "sand", *models_of([one])):
        there = getattr(one, kind).at(moments)
        table[f"{kind}: deviator [Pa]"] = texts(there.deviator, ".5g")
        table[f"{kind}: change of volume"] = texts(there.volume, ".4g")
        for k, column in enumerate(there.wire.T):
            table[f"{kind}: wire's part along {AXES[k]} [Pa]"] = texts(column, ".4g")
    return table


def errors_of(found: Comparison) -> list[tuple[str, str, list[Miss]]]:
    """Test, model, and how far it is off in each study."""
    return [
        (name, model, [miss(one, getattr(one, model)) for one in many])
        for name, many in found.predictions.items()
        for model in models_of(many)
    ]


def error_columns(found: Comparison) -> dict[str, list[str]]:
    """The table of errors by study."""
    rows = [
        (name, model, str(study.seed), f"{one.deviator:.4g}", f"{one.volume:.4g}", *(f"{part:.4g}" for part in one.wire))
        for name, model, misses in errors_of(found)
        for study, one in zip(found.studies, misses, strict=True)
    ]
    wire = [f"wire's part along {axis} [Pa]" for axis, _ in zip(AXES, found.wires[0].direction.T, strict=False)]
    head = ["test", "model", "seed", "deviator, relative", "change of volume", *wire]
    return {title: [row[k] for row in rows] for k, title in enumerate(head)}


def page(found: Comparison) -> str:
    """The page in Markdown."""
    return sections(
        "The continuous model beside the runs", [setting(found), table_of_errors(found), table_of_wire(found), made_with()]
    )


def setting(found: Comparison) -> str:
    """Words on the studies compared and on the quantities measured."""
    seeds = ", ".join(str(study.seed) for study in found.studies)
    d = len(found.wires[0].direction.T)
    size, width = np.mean(found.diameters), np.mean([wire.width for wire in found.wires])
    at, several, power = found.source or found, len(found.studies) > 1, "d" if d == 2 else "d^2"
    spans = np.array([one.span for one in at.anchorages]) / at.diameters
    first, last = (np.array([one.strength[k] for one in at.anchorages]) / size ** (d - 1) for k in (0, -1))
    slip = np.mean([one.slip[-1] for one in at.anchorages])
    test, others = f"the test {at.measured_in}", ""
    if found.source is not None:
        wide = np.mean([one.width for one in at.anchorages])
        test += f" of {len(at.studies)} samples that are {wide / np.mean(at.diameters):.1f} grains wide"
        use = f"here, by the square of the width, {(width / wide) ** 2:.2f} times as much (too much beyond 18 grains)"
    elif several:
        use, others = "each prediction uses the mean of the other seeds", " of the other seeds"
    else:
        use = "so that this test is no prediction for it"
    gains = ", ".join(f"{_mean(np.array(at.gains[name]), '.3f')} in {name}" for name in found.gains)
    fabric = np.mean([Directions(wire.direction, wire.length).fabric.diagonal() for wire in found.wires], axis=0)
    return (
        f"Seed{'s' if several else ''} {seeds}. The sand is fitted to the test without a wire along the same axis, nothing "
        f"else is fitted. Grains of {1e3 * size:.3g} mm, {width / size:.1f} across the sample; content of wire "
        f"(length x {power} / volume) {found.content:.3g}; mean squares of the direction of its "
        f"links along {', '.join(AXES[:d])}: {', '.join(f'{value:.3f}' for value in fabric)}.\n\n"
        f"The anchored wire: spans of {_mean(spans, '.1f', ' d')} that share a tension of at most "
        f"{_mean(first, '.2f', f' p {power}')} at first and {_mean(last, '.2f', f' p {power}')} after a mean slip of "
        f"{100 * slip:.1f} %, p the pressure of the sand, measured in {test}; {use}.\n\n"
        f"The stronger sand: beside the wire its q/p changes by a factor of {gains}, measured in that test{others}; "
        "all that it gains goes into dilation."
    )


def _mean(values: np.ndarray, form: str, unit: str = "") -> str:
    """The mean of several, and their standard deviation in brackets."""
    spread = f" (standard deviation {format(values.std(ddof=1), form)})" if len(values) > 1 else ""
    return f"{format(values.mean(), form)}{unit}{spread}"


def table_of_errors(found: Comparison) -> str:
    """How far the models are off, beside the scatter of the runs."""
    rows = []
    for name, many in found.predictions.items():
        mean, scatter = mean_curves([one.run for one in many])
        bare, _ = mean_curves([one.sand for one in many])
        late = slice(int(0.8 * len(mean.crushing)), None)
        row = {
            "test": name,
            "sand late [kPa]": f"{1e-3 * bare.deviator[late].mean():.0f}",
            "run late [kPa]": f"{1e-3 * mean.deviator[late].mean():.0f}",
            "scatter of seeds": f"{100 * scatter.deviator[late].mean() / mean.deviator[late].mean():.0f} %"
            if many[1:]
            else "",
        }
        for model, words in {"sand": "sand alone", **models_of(many)}.items():
            misses = [miss(one, getattr(one, model)) for one in many]
            deviator = np.array([one.deviator for one in misses])
            row[f"{words}: deviator off by"] = _percent(deviator)
            row[f"{words}: volume off by"] = _percent(np.array([one.volume for one in misses]), 2)
        rows.append(row)
    return (
        "## Deviator and volume\n\nMean distance from the run over the test after its first tenth: of the deviator "
        "relative to its mean, of the change of volume in points; mean of the seeds. Late is the last fifth.\n\n"
        f"{markdown(rows)}"
    )


def _percent(values: np.ndarray, digits: int = 0) -> str:
    if np.isinf(values).any():
        return "no solution"
    return f"{100 * values.mean():.{digits}f} %"


def table_of_wire(found: Comparison) -> str:
    """The wire's part of the stress, by component, in the last fifth of the tests."""
    rows = []
    for name, many in found.predictions.items():
        for kind, words in (("run", "run"), *models_of(many).items()):
            mean, scatter = mean_curves([getattr(one, kind) for one in many])
            late = slice(int(0.8 * len(mean.crushing)), None)
            parts = [
                f"{1e-3 * part:.1f}" + (f" ± {1e-3 * error:.1f}" if many[1:] else "")
                for part, error in zip(mean.wire[late].mean(axis=0), scatter.wire[late].mean(axis=0), strict=True)
            ]
            heads = [f"along {axis} [kPa]" for axis, _ in zip(AXES, parts, strict=False)]
            rows.append({"test": name, "": words, **dict(zip(heads, parts, strict=True))})
    return (
        "## The wire's part of the stress\n\nNormal components in the last fifth, traction positive"
        f"{', with the standard deviation of the seeds' if len(found.studies) > 1 else ''}.\n\n{markdown(rows)}"
    )


def figure(name: str, many: list[Prediction]) -> Figure:
    """Deviator, change of volume and the wire's part of the stress: runs, and what the models say."""
    drawn = new_figure(12.0, 4.2)
    panels = drawn.subplots(1, 3)
    d = many[0].run.wire.shape[1]
    across = [k for k in range(d) if AXES[k] != many[0].axis]
    quantities = (
        ("deviator [kPa]", lambda one: 1e-3 * one.deviator),
        ("change of volume, dilation positive [%]", lambda one: 100.0 * one.volume),
        ("wire's part, mean across the axis [kPa]", lambda one: 1e-3 * one.wire[:, across].mean(axis=1)),
    )
    for axes, (words, of) in zip(panels, quantities, strict=True):
        _draw(axes, many, of)
        axes.set_xlabel("crushing, logarithmic [%]")
        axes.set_ylabel(words)
        axes.set_xlim(left=0.0)
    drawn.suptitle(f"{name}: run and prediction" + (f", {len(many)} seeds" if many[1:] else ""))
    drawn.legend(*panels[0].get_legend_handles_labels(), frameon=False, ncols=4, loc="outside lower center")
    return drawn


def _draw(axes: Axes, many: list[Prediction], of) -> None:
    """Curves of a panel, means over the seeds with a band of one standard deviation for the run."""
    models = models_of(many)
    labels = {"sand": "sand, run", "run": "with the wire, run", **{k: f"{v}, predicted" for k, v in models.items()}}
    low, high = np.inf, -np.inf
    for kind, label in labels.items():
        mean, _ = mean_curves([getattr(one, kind) for one in many])
        values = of(mean)
        percent = 100.0 * mean.crushing
        style = ":" if kind == "coulomb" else "--" if kind in models else "-"
        axes.plot(percent, values, color=COLORS[kind], label=label, linestyle=style)
        if kind == "run" and many[1:]:
            spread = np.std([of(one.run.at(mean.crushing)) for one in many], axis=0, ddof=1)
            axes.fill_between(percent, values - spread, values + spread, color="black", alpha=0.15, linewidth=0)
        if kind != "local":
            low, high = min(low, float(np.nanmin(values))), max(high, float(np.nanmax(values)))
    room = HIGHEST - 1.0
    axes.set_ylim(low - 0.1 * room * (high - low), high + room * (high - low))
