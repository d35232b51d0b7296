"""Figures of the mechanical tests: curves, after figures 3 and 5 of the paper.

Nothing here touches matplotlib's global state, so that it works without a display and from threads.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.view.drawing import CURVES, WIRE
from lmgcpy.view.recorded import Tested
from lmgcpy.writing import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def new_figure(width: float = 7.0, height: float = 4.6) -> Figure:
    """An empty figure [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the path's suffix, by default PNG; raises as :func:`lmgcpy.writing.new_file`."""
    memory = io.BytesIO()  # if it fails to write a PDF to a file, matplotlib raises an AttributeError
    kind = path.suffix[1:] or "png"
    figure.savefig(memory, format=kind, dpi=160, bbox_inches="tight", pad_inches=0.08)  # or titles are cut off
    write_bytes(path, memory.getbuffer())


def reaction_figure(
    records: Sequence[Tested], names: Sequence[str] | None = None, *, pressure: float | None = None
) -> Figure:
    """Support reaction against crushing percentage, one curve a test (fig. 3): running means, and faintly the steps.

    If one test bears many times the load of another, a second panel shows all tests on a logarithmic scale, and the first
    panel shows tests of similar size. ``names``: names of the tests, by default the names of their laws.

    With the ``pressure`` [Pa] on the lateral walls the figure shows the isotropic load, under which the sample was at rest,
    as a line, and q/p on an axis at the right, from this pressure and the reaction over the section at the start.
    """
    names = names_of(records) if names is None else names
    tops = [float(record.smooth(record.reaction).max()) for record in records]
    limit = 3.0 * min(tops)
    two = max(tops) > 2.0 * limit
    figure = new_figure(11.0 if two else 7.0)
    comparable = [k for k, top in enumerate(tops) if not two or top <= 2.0 * limit]
    panels = figure.subplots(1, 2 if two else 1, squeeze=False)[0]
    for axes, shown in zip(panels, (comparable, range(len(records))), strict=False):
        for k in shown:
            draw_curve(axes, records[k], 1e-3 * records[k].reaction, names[k], color_of(records, k))
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(left=0.0)
    flat = records[0].size.shape[1] == 2
    panels[0].set_ylabel("support reaction " + ("[kN per m of depth]" if flat else "[kN]"))
    panels[0].set_ylim(0.0, 1.15e-3 * max(tops[k] for k in comparable))
    if pressure is not None:
        _draw_isotropic(panels, records[0], pressure)
    if two:
        panels[0].set_title("laws that compare", fontsize="medium")
        panels[1].set_title("all, on a logarithmic scale", fontsize="medium")
        panels[1].set_yscale("log")
    panels[-1].legend(frameon=False)
    return figure


def _draw_isotropic(panels: Sequence[Axes], record: Tested, pressure: float) -> None:
    """Draw the isotropic load of a ``pressure`` [Pa] as a line, and q/p of reactions on an axis of the first panel."""
    from matplotlib.ticker import MaxNLocator

    flat = record.size.shape[1] == 2
    load = 1e-3 * pressure * float(np.prod(record.size[0])) / height_of(record)
    for axes in panels:
        axes.axhline(load, color="black", linestyle=":", linewidth=1.0, label="isotropic load")
    parts = 2.0 if flat else 3.0  # p is the mean of the principal stresses

    def ratio(reaction: Any) -> Any:
        axial = np.asarray(reaction) / load
        return parts * (axial - 1.0) / (axial + parts - 1.0)

    def reaction(ratio: Any) -> Any:
        ratio = np.minimum(np.asarray(ratio), 0.999 * parts)
        return load * (parts + (parts - 1.0) * ratio) / (parts - ratio)

    scale = panels[0].secondary_yaxis("right", functions=(ratio, reaction))
    scale.set_ylabel("q/p")
    top = float(ratio(panels[0].get_ylim()[1]))
    scale.set_yticks([tick for tick in MaxNLocator(6).tick_values(0.0, top) if 0.0 <= tick <= top])


def height_of(record: Tested) -> float:
    """Size of the sample along the axis of crushing at the start [m]: the one that the crushing changes."""
    crushed = np.abs(record.size - record.size[0] * (1.0 - record.strain[:, None])).max(axis=0)
    return float(record.size[0, int(np.argmin(crushed / record.size[0]))])


def deviator_figure(records: Sequence[Tested], names: Sequence[str] | None = None) -> Figure:
    """Deviator of the Weber stress and change of volume against crushing percentage, one curve a test."""
    names = names_of(records) if names is None else names
    figure = new_figure(7.0, 6.4)
    above, below = figure.subplots(2, 1, sharex=True)
    for k, record in enumerate(records):
        color = color_of(records, k)
        draw_curve(above, record, 1e-3 * deviator(record.stress["total"]), names[k], color)
        volume = np.prod(record.size, axis=1)
        below.plot(100.0 * record.strain, 100.0 * (volume / volume[0] - 1.0), color=color, label=names[k])
    above.set_ylabel("deviator [kPa]")
    above.set_ylim(bottom=0.0)
    below.set_ylabel("change of volume, dilation positive [%]")
    below.axhline(0.0, color="grey", linewidth=0.5)
    below.set_xlabel("crushing [%]")
    below.set_xlim(left=0.0)
    above.legend(frameon=False)
    return figure


def stress_figure(*records: Tested, names: Sequence[str] | None = None) -> Figure:
    """Greatest and smallest principal value of the Weber stress against crushing: total, wire part, sand part (fig. 5);
    traction positive. A panel a test, all with one scale, unless one test bears more than three times another's load. In 3D
    the wire bears a small part, and has an axis of its own at the right."""
    names = names_of(records) if names is None else names
    figure = new_figure(5.0 * len(records) if len(records) > 1 else 7.0)
    smoothed = [{part: record.smooth(sigma) for part, sigma in record.stress.items()} for record in records]
    sizes = [max(float(np.abs(sigma).max()) for sigma in smooth.values()) for smooth in smoothed]
    one_scale = max(sizes) <= 3.0 * min(sizes)
    panels = figure.subplots(1, len(records), squeeze=False, sharey=one_scale)[0]
    own: list[Axes] = []
    for axes, record, smooth, name in zip(panels, records, smoothed, names, strict=True):
        apart = record.size.shape[1] == 3 and bool(smooth["wire"].any())
        if apart:
            own.append(axes.twinx())
        draw_principal(axes, 100.0 * record.strain, smooth, own[-1] if apart else axes)
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(left=0.0)
        axes.set_title(f"Weber stress with {name}")
    lines, words = max((axes.get_legend_handles_labels() for axes in panels), key=lambda known: len(known[0]))
    if own:
        _share_scale(own)
        more = own[0].get_legend_handles_labels()
        lines, words = lines + more[0], words + more[1]
    figure.legend(lines, words, frameon=False, ncols=3, loc="outside upper center")  # sand alone has fewer
    panels[0].set_ylabel("principal stress, traction positive [kPa]")
    return figure


def _share_scale(own: Sequence[Axes]) -> None:
    """Give the axes of the wire one scale, from zero or below to the greatest of all, and a label at the last."""
    low, high = min(axes.get_ylim()[0] for axes in own), max(axes.get_ylim()[1] for axes in own)
    for axes in own:
        axes.set_ylim(min(low, 0.0), max(high, 0.0))
        axes.tick_params(axis="y", colors=WIRE)
    own[-1].set_ylabel("of the wire [kPa]", color=WIRE)


def draw_principal(axes: Axes, abscissa: np.ndarray, stress: dict[str, np.ndarray], wire: Axes | None = None) -> None:
    """Draw the greatest and smallest principal value of each part [Pa] in kPa; without a wire only of the whole. ``wire``:
    the axes of the wire's part, by default the same."""
    parts = [("total", "black", "whole sample"), ("sand", CURVES["none"], "sand part"), ("wire", WIRE, "wire part")]
    for part, color, label in parts if stress["wire"].any() else parts[:1]:
        values, where = 1e-3 * principal_values(stress[part]), axes
        if part == "wire" and wire is not None and wire is not axes:
            where, label = wire, f"{label} (axis at the right)"
        where.plot(abscissa, values[:, 0], color=color, linestyle="--", label=f"{label}, greatest")
        where.plot(abscissa, values[:, -1], color=color, label=f"{label}, smallest")
    axes.axhline(0.0, color="grey", linewidth=0.5)


def draw_curve(axes: Axes, record: Tested, values: np.ndarray, name: str, color: str | None) -> None:
    """Draw the running mean of values against crushing, and faintly the values of the steps."""
    percent = 100.0 * record.strain
    (line,) = axes.plot(percent, record.smooth(values), color=color, label=name)
    axes.plot(percent, values, color=line.get_color(), linewidth=0.4, alpha=0.35)


def principal_values(stress: np.ndarray) -> np.ndarray:
    """Principal values of the symmetric part of stresses (s, d, d), greatest first [Pa], (s, d)."""
    return np.linalg.eigvalsh(0.5 * (stress + stress.transpose(0, 2, 1)))[:, ::-1]


def deviator(stress: np.ndarray) -> np.ndarray:
    """Deviators of stresses (s, d, d) [Pa], (s,): in 2D the difference of the principal values; in 3D
    ``sqrt(3/2 s:s)``, which is that difference in a triaxial test."""
    values = principal_values(stress)
    spread = values - values.mean(axis=1, keepdims=True)
    factor = 2.0 if stress.shape[1] == 2 else 1.5
    return np.sqrt(factor * (spread**2).sum(axis=1))


def principal_series(record: Tested, part: str) -> np.ndarray:
    """Principal values of the running mean of a part of the stress, greatest first [Pa], (s, d)."""
    return principal_values(record.smooth(record.stress[part]))


def name_of(law: str) -> str:
    """Name of a law in a legend."""
    return "sand (no law)" if law == "none" else law.replace("-", " ")


def names_of(records: Sequence[Tested]) -> list[str]:
    """Names of the laws of the tests."""
    return [name_of(record.law) for record in records]


def color_of(records: Sequence[Tested], k: int) -> str | None:
    """Colour of the law of a test; the k-th colour of matplotlib if another test has the same law."""
    law = records[k].law
    return CURVES.get(law) if sum(record.law == law for record in records) == 1 else f"C{k}"
