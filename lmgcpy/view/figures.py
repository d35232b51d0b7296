"""Figures of the mechanical tests, after figures 3 to 5 of the paper.

Nothing here touches matplotlib's global state, so that it works without a display and from threads.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.view.palette import BEAD, CONTACT, CURVES, PUSHING, SAND, WIRE
from lmgcpy.view.recorded import Tested
from lmgcpy.writing import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lmgcpy.experiment.biaxial import Frame


def new_figure(width: float = 7.0, height: float = 4.6) -> Figure:
    """An empty figure [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write a figure: as PNG, or as what the path ends in; raises as :func:`lmgcpy.writing.new_file`."""
    memory = io.BytesIO()  # where writing a PDF fails, matplotlib raises an AttributeError
    kind = path.suffix[1:] or "png"
    figure.savefig(memory, format=kind, dpi=160, bbox_inches="tight", pad_inches=0.08)  # or titles are cut off
    write_bytes(path, memory.getbuffer())


def reaction_figure(records: Sequence[Tested], names: Sequence[str] | None = None) -> Figure:
    """Support reaction against crushing percentage, one curve a test (fig. 3): running means, and faintly the steps.

    Where one bears many times what another does, a second panel shows all on a logarithmic scale, and the first one
    keeps to those that compare. ``names``: of the tests, by default those of their laws.
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
    if two:
        panels[0].set_title("laws that compare", fontsize="medium")
        panels[1].set_title("all, on a logarithmic scale", fontsize="medium")
        panels[1].set_yscale("log")
    panels[-1].legend(frameon=False)
    return figure


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
    traction positive. A panel a test."""
    names = names_of(records) if names is None else names
    figure = new_figure(7.0 * len(records))
    panels = figure.subplots(1, len(records), squeeze=False, sharey=True)[0]
    for axes, record, name in zip(panels, records, names, strict=True):
        smooth = {part: record.smooth(sigma) for part, sigma in record.stress.items()}
        draw_principal(axes, 100.0 * record.strain, smooth)
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(left=0.0)
        axes.set_title(f"Weber stress with {name}")
        axes.legend(frameon=False, fontsize="small", ncols=3, loc="upper left")
    low, high = panels[0].get_ylim()
    panels[0].set_ylim(low, high + 0.15 * (high - low))  # where the legends are
    panels[0].set_ylabel("principal stress, traction positive [kPa]")
    return figure


def draw_principal(axes: Axes, abscissa: np.ndarray, stress: dict[str, np.ndarray]) -> None:
    """Greatest and smallest principal value of each part [Pa] over the abscissa, in kPa; without a wire only the whole."""
    parts = [("total", "black", "whole sample"), ("sand", CURVES["none"], "sand part"), ("wire", WIRE, "wire part")]
    for part, color, label in parts if stress["wire"].any() else parts[:1]:
        values = 1e-3 * principal_values(stress[part])
        axes.plot(abscissa, values[:, 0], color=color, linestyle="--", label=f"{label}, greatest")
        axes.plot(abscissa, values[:, -1], color=color, label=f"{label}, smallest")
    axes.axhline(0.0, color="grey", linewidth=0.5)


def draw_curve(axes: Axes, record: Tested, values: np.ndarray, name: str, color: str | None) -> None:
    """The running mean of something against crushing, and faintly its steps."""
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


def chains_figure(left: tuple[str, Frame], right: tuple[str, Frame], radii: np.ndarray, bead_count: int) -> Figure:
    """Two samples with their forces as lines as wide as the force, at one scale (fig. 4)."""
    figure = new_figure(11.0, 5.8)
    unit = max(float(np.quantile(np.abs(frame.forces), 0.999)) for _, frame in (left, right) if len(frame.forces))
    for axes, (title, frame) in zip(figure.subplots(1, 2), (left, right), strict=True):
        _draw_particles(axes, frame.positions, radii, bead_count, faint=True)
        pushing = frame.forces > 0.0
        for chosen, color in (
            (pushing & ~frame.in_wire, CONTACT),
            (frame.in_wire & ~pushing, WIRE),
            (frame.in_wire & pushing, PUSHING),
        ):
            _draw_forces(axes, frame.lines[chosen], frame.forces[chosen] / unit, color)
        _draw_box(axes, *frame.walls)
        axes.set_title(
            f"{title}\n{100 * frame.strain:.1f} % crushing, {1e-3 * frame.top_force:.0f} kN/m on top", fontsize="medium"
        )
        axes.set_aspect("equal")
        axes.set_axis_off()
    _legend_of_forces(figure, any((f.in_wire & (f.forces > 0)).any() for _, f in (left, right)))
    return figure


def sample_figure(sample: Any) -> Figure:
    """The sample in 2D, its wires drawn through the beads."""
    figure = new_figure(6.0, 6.2)
    axes = figure.subplots()
    _draw_particles(axes, sample.positions, sample.radii, sample.bead_count, faint=False)
    for chain in sample.chains:
        axes.plot(*sample.positions[chain].T, color=WIRE, linewidth=0.8)
    _draw_box(axes, 0.0, sample.width, 0.0, sample.height)
    axes.set_title(f"{len(sample.radii)} particles, {sample.bead_count} of them beads of the wire", fontsize="medium")
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def name_of(law: str) -> str:
    """A law as a legend calls it."""
    return "sand (no law)" if law == "none" else law.replace("-", " ")


def names_of(records: Sequence[Tested]) -> list[str]:
    """Tests by the names of their laws."""
    return [name_of(record.law) for record in records]


def color_of(records: Sequence[Tested], k: int) -> str | None:
    """That of the law of a test; None, so that matplotlib chooses, where another test has the same law."""
    law = records[k].law
    return CURVES.get(law) if sum(record.law == law for record in records) == 1 else f"C{k}"


def _draw_particles(axes: Axes, positions: np.ndarray, radii: np.ndarray, bead_count: int, faint: bool) -> None:
    from matplotlib.collections import EllipseCollection

    colors = np.array([SAND] * len(radii), dtype=object)
    colors[:bead_count] = BEAD
    size = 2.0 * radii
    disks = EllipseCollection(
        size,
        size,
        np.zeros(len(radii)),
        units="x",
        offsets=positions,
        offset_transform=axes.transData,
        facecolors=colors.tolist(),
        edgecolors="none" if faint else "#6b6b6b",
        linewidths=0.2,
        alpha=0.35 if faint else 1.0,
    )
    axes.add_collection(disks)


def _draw_box(axes: Axes, left: float, right: float, bottom: float, top: float) -> None:
    axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color="black", linewidth=1.0)
    margin = 0.02 * (right - left)
    axes.set_xlim(left - margin, right + margin)
    axes.set_ylim(bottom - margin, top + margin)


def _draw_forces(axes: Axes, lines: np.ndarray, width: np.ndarray, color: str) -> None:
    from matplotlib.collections import LineCollection

    axes.add_collection(
        LineCollection(list(lines), linewidths=4.0 * np.abs(width), colors=color, capstyle="round", zorder=3)
    )


def _legend_of_forces(figure: Figure, compressed: bool) -> None:
    from matplotlib.lines import Line2D

    entries = [(CONTACT, "contact reaction"), (WIRE, "wire in tension")]
    if compressed:
        entries.append((PUSHING, "rod in compression"))
    handles = [Line2D([], [], color=color, linewidth=3) for color, _ in entries]
    figure.legend(handles, [label for _, label in entries], loc="outside lower center", ncols=3, frameon=False)
