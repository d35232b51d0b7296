"""Figures of the biaxial study, after figures 3 to 5 of the paper.

Nothing here touches matplotlib's global state, so that it works without a display and from threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lmgcpy.experiment.biaxial import BiaxialRecord, Frame
    from lmgcpy.experiment.box_2d import Sample

SAND, CONTACT, WIRE, PUSHING = "#d9cba3", "#b2182b", "#1b4f9c", "#e08214"
"""Grains, contact reactions, wires in tension, rods in compression."""
CURVES = {
    "none": "#8c6d31",
    "rigid-wire": "#1b4f9c",
    "rigid-rod": "#b2182b",
    "elastic-wire": "#35978f",
    "elastic-rod": "#762a83",
}


def new_figure(width: float = 7.0, height: float = 4.6) -> Figure:
    """An empty figure [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG."""
    figure.savefig(path, dpi=160)


def reaction_figure(records: Sequence[BiaxialRecord]) -> Figure:
    """Support reaction against crushing percentage, one curve a law (fig. 3): running means, and faintly the steps.

    Where one law bears many times what another does, a second panel shows all on a logarithmic scale, and the first one
    keeps to those that compare.
    """
    tops = {record.law: float(record.smooth(record.reaction).max()) for record in records}
    limit = 3.0 * min(tops.values())
    two = max(tops.values()) > 2.0 * limit
    figure = new_figure(11.0 if two else 7.0)
    comparable = [record for record in records if not two or tops[record.law] <= 2.0 * limit]
    panels = figure.subplots(1, 2 if two else 1, squeeze=False)[0]
    for axes, shown in zip(panels, (comparable, records), strict=False):
        for record in shown:
            color = CURVES.get(record.law)
            percent = 100.0 * record.strain
            (line,) = axes.plot(percent, 1e-3 * record.smooth(record.reaction), color=color, label=name_of(record.law))
            axes.plot(percent, 1e-3 * record.reaction, color=line.get_color(), linewidth=0.4, alpha=0.35)
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(left=0.0)
    panels[0].set_ylabel("support reaction [kN per m of depth]")
    panels[0].set_ylim(0.0, 1.15e-3 * max(tops[record.law] for record in comparable))
    if two:
        panels[0].set_title("laws that compare", fontsize="medium")
        panels[1].set_title("all, on a logarithmic scale", fontsize="medium")
        panels[1].set_yscale("log")
    panels[-1].legend(frameon=False)
    return figure


def stress_figure(record: BiaxialRecord) -> Figure:
    """Principal stresses of the Weber tensor against crushing: total, wire part, sand part (fig. 5); traction positive."""
    figure = new_figure()
    axes = figure.subplots()
    percent = 100.0 * record.strain
    for part, color, label in (
        ("total", "black", "TexSol"),
        ("sand", CURVES["none"], "sand part"),
        ("wire", WIRE, "wire part"),
    ):
        values = 1e-3 * principal_series(record, part)
        axes.plot(percent, values[:, 0], color=color, linestyle="--", label=f"{label}, greater")
        axes.plot(percent, values[:, 1], color=color, label=f"{label}, smaller")
    axes.axhline(0.0, color="grey", linewidth=0.5)
    axes.set_xlabel("crushing [%]")
    axes.set_ylabel("principal stress, traction positive [kPa]")
    axes.set_xlim(left=0.0)
    axes.set_title(f"Weber stress with {name_of(record.law)}")
    axes.legend(frameon=False, fontsize="small", ncols=3)
    return figure


def principal_series(record: BiaxialRecord, part: str) -> np.ndarray:
    """Principal values of the running mean of a part of the stress, greater first [Pa], (s, 2)."""
    sigma = record.smooth(record.stress[part])
    return np.linalg.eigvalsh(0.5 * (sigma + sigma.transpose(0, 2, 1)))[:, ::-1]


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
            f"{title} at {100 * frame.strain:.1f} % crushing, {1e-3 * frame.top_force:.0f} kN/m on top", fontsize="medium"
        )
        axes.set_aspect("equal")
        axes.set_axis_off()
    _legend_of_forces(figure, any((f.in_wire & (f.forces > 0)).any() for _, f in (left, right)))
    return figure


def sample_figure(sample: Sample) -> Figure:
    """The sample, its wire drawn through the beads."""
    figure = new_figure(6.0, 6.2)
    axes = figure.subplots()
    _draw_particles(axes, sample.positions, sample.radii, sample.bead_count, faint=False)
    wire = sample.positions[: sample.bead_count]
    axes.plot(wire[:, 0], wire[:, 1], color=WIRE, linewidth=0.8)
    _draw_box(axes, 0.0, sample.width, 0.0, sample.height)
    axes.set_title(f"{len(sample.radii)} particles, {sample.bead_count} of them beads of the wire", fontsize="medium")
    axes.set_aspect("equal")
    axes.set_axis_off()
    return figure


def name_of(law: str) -> str:
    """A law as a legend calls it."""
    return "sand (no law)" if law == "none" else law.replace("-", " ")


def _draw_particles(axes: Axes, positions: np.ndarray, radii: np.ndarray, bead_count: int, faint: bool) -> None:
    from matplotlib.collections import EllipseCollection

    colors = np.array([SAND] * len(radii), dtype=object)
    colors[:bead_count] = "#9ab7dd"
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
