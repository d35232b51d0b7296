"""Figures and pictures of the TexSol studies that no other study has.

A 2D test keeps particles and forces of some steps and no scene, so that drawings of its particles, wire and force chains
(figures 3 and 4 of the paper) are made here and not by :func:`lmgcpy.view.compose.compose`. Colours, forces and everything
after the drawing are the same.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import lmgcpy.view.figures as figures
from lmgcpy.errors import AXES
from lmgcpy.experiment.biaxial import Frame
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.study.folder import ReportFolder, StudyFolder
from lmgcpy.experiment.texsol.conclusions import LinkDirections, frames_at_equal_force, frames_of_column
from lmgcpy.experiment.texsol.result import TexSolResult
from lmgcpy.experiment.triaxial import TriaxialRecord
from lmgcpy.io.run import open_run
from lmgcpy.view.boundary import edges
from lmgcpy.view.compose import PALE, Panel, force_tubes
from lmgcpy.view.drawing import BEAD, PUSHING, SAND, WIRE, Balls, Drawing, Paint, Tubes, in_space
from lmgcpy.view.film import Film
from lmgcpy.view.pictures import write_film
from lmgcpy.view.style import Camera

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (700, 700)
"""Largest size of a panel [pixels]. Two panels are read at 60 % of it, on a page or a screen."""

THIN = 0.12
"""Radius of a wire in radii of its beads, so that the beads are seen behind it."""


def title(record: TriaxialRecord) -> str:
    """The name of a test in a legend."""
    return f"{figures.name_of(record.law)} along {record.axis}"


def layers_figure(records: Sequence[TriaxialRecord]) -> Figure:
    """The wire's part of the stress within the layers and across them against crushing, a panel a test."""
    drawn = figures.new_figure(max(7.0, 5.0 * len(records)))
    panels = drawn.subplots(1, len(records), squeeze=False, sharey=True)[0]
    for axes, record in zip(panels, records, strict=True):
        percent = 100.0 * record.strain
        for k, axis in enumerate(AXES):
            component = 1e-3 * record.smooth(record.stress["wire"][:, k, k], 0.005)
            compressed = ", compressed" if axis == record.axis else ""
            within = "within the layers" if axis != "z" else "across the layers"
            style = "-" if axis != "z" else "--"
            axes.plot(percent, component, label=f"{axis}{axis}, {within}{compressed}", linestyle=style)
        axes.axhline(0.0, color="grey", linewidth=0.5)
        axes.set_title(title(record), fontsize="medium")
        axes.set_xlabel("crushing [%]")
        axes.set_xlim(left=0.0)
        axes.legend(frameon=False, fontsize="small")
    panels[0].set_ylabel("wire's part of the stress, traction positive [kPa]")
    return drawn


def links_figure(directions: Mapping[str, LinkDirections], bounds: Mapping[str, float]) -> Figure:
    """Share of the links that pull, and the forces that links bear, by their angle to x; a panel a law.

    ``bounds``: the angle up to which directions are extended [rad], by law.
    """
    drawn = figures.new_figure(max(7.0, 5.0 * len(directions)))
    panels = drawn.subplots(1, len(directions), squeeze=False, sharey=True)[0]
    for axes, (law, found) in zip(panels, directions.items(), strict=True):
        degrees = np.degrees(found.edges)
        share = 100.0 * np.nan_to_num(found.taut_share)
        axes.stairs(share, degrees, fill=True, color="lightgrey", label="links that pull")
        borne = max(found.pulled.max(), found.pushed.max()) or 1.0
        axes.stairs(100.0 * found.pulled / borne, degrees, color=WIRE, linewidth=2.0, label="sum of tension x length")
        if found.pushed.any():
            axes.stairs(
                100.0 * found.pushed / borne, degrees, color=PUSHING, linewidth=2.0, label="of compression x length"
            )
        axes.axvline(np.degrees(bounds[law]), color="black", linestyle=":", label="directions left of it are extended")
        axes.set_title(figures.name_of(law), fontsize="medium")
        axes.set_xlabel("angle of the link to x [degrees]")
        axes.set_xlim(0.0, 90.0)
        axes.set_ylim(0.0, 130.0)
        axes.legend(framealpha=1.0, edgecolor="none", fontsize="small", loc="upper right")  # over the dotted line
    panels[0].set_ylabel("share of the links; share of the greatest sum [%]")
    return drawn


def reason_without_pictures() -> str:
    """A sentence that says why there can be no pictures of the sample, or nothing."""
    try:
        import pyvista  # noqa: F401
    except ImportError:
        return 'There are no pictures of the sample, as pyvista is not installed: pip install "lmgcpy[view]" brings it.'
    from lmgcpy.view.painter import NoOpenGL, Painter

    try:
        Painter(off_screen=True).close()
    except NoOpenGL as error:
        return f"There are no pictures of the sample. {error}"
    return ""


def draw_flat_pictures(result: TexSolResult, report: ReportFolder) -> str:
    """Draw the sample of a 2D study, and for each test with a wire its force chains beside the sand's (figure 4).

    Returns a sentence on why there are no pictures, or an empty one.
    """
    reason = reason_without_pictures()
    if reason:
        return reason
    sample, sand = result.sample, result.records.get("none")
    draw_sample(report.file("sample.png"), sample)
    for law, record in result.records.items():
        if law != "none" and sand is not None:
            with_wire, without = frames_at_equal_force(record, sand)
            path = report.file(f"chains-{law}.png")
            draw_chains(path, (figures.name_of(law), with_wire), ("sand", without), sample.radii, sample.bead_count)
    wire = result.records.get("rigid-wire")
    for law, record in result.records.items():
        frames = frames_of_column(record, wire) if law.endswith("rod") and wire is not None else None
        if frames is not None:
            before, at = ((figures.name_of(law), frame) for frame in frames)
            draw_chains(report.file(f"column-{law}.png"), before, at, sample.radii, sample.bead_count)
    return ""


def draw_pictures(result: TexSolResult, folder: StudyFolder, report: ReportFolder) -> str:
    """Draw wire, sample and force chains of a 3D study from its run files (figures 6 and 7 of the paper).

    Returns a sentence that says why there are no pictures, or nothing.
    """
    reason = reason_without_pictures()
    if reason:
        return reason
    import lmgcpy.view as view

    with ExitStack() as stack:
        relaxation = stack.enter_context(open_run(folder.run_file("compaction")))
        if result.sample.wires:
            view.render(
                relaxation,
                report.file("wire.png"),
                what="layout",
                frame=0,
                grains="hidden",
                wires="length",
                camera=["isometric", "x"],
                title=["wire as laid", "seen along x"],
            )
            view.render(
                relaxation,
                report.file("sample.png"),
                what="layout",
                frame=-1,
                grains=["hidden", "plain"],
                wires="layer",
                clip=[None, "y"],
                opacity=1.0,
                title=["wire in the compacted sample", "the same with its grains, cut open"],
            )
        for axis in result.study.axes:
            names = [f"{law}-{axis}" for law in result.study.laws]
            runs = [stack.enter_context(open_run(folder.run_file(name))) for name in names]
            titles = ["sand" if law == "none" else law.replace("-", " ") for law in result.study.laws]
            percent = f"{100.0 * result.study.strain:g} % along {axis}"
            view.render(
                runs,
                report.file(f"chains-{axis}.png"),
                what="forces",
                grains="hidden",
                camera="y",
                title=[f"{name} at {percent}" for name in titles],
            )
    return ""


def draw_chains(
    path: str | os.PathLike,
    left: tuple[str, Frame],
    right: tuple[str, Frame],
    radii: np.ndarray,
    bead_count: int,
    *,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Draw two frames with their forces side by side, at one scale of forces, into a PNG file (fig. 4).

    Each frame comes with its name. ``radii`` [m], (n,); the first ``bead_count`` particles are beads.
    """
    panels = [
        _panel(
            chains_drawing(frame, radii, bead_count),
            f"{name} at {100.0 * frame.strain:.1f} % crushing, {1e-3 * frame.top_force:.0f} kN/m on top",
        )
        for name, frame in (left, right)
    ]
    return write_film(Film(panels, size=size), Path(path))


def draw_sample(path: str | os.PathLike, sample: Sample, *, size: tuple[int, int] = SIZE) -> Path:
    """Draw a sample into a PNG file, its wires through the beads."""
    title = f"{len(sample.radii)} particles, {sample.bead_count} of them beads of the wire"
    return write_film(Film([_panel(sample_drawing(sample), title)], size=size), Path(path))


def chains_drawing(frame: Frame, radii: np.ndarray, bead_count: int) -> Drawing:
    """Pale particles below the forces of a frame."""
    legend: list[tuple[str, str]] = []
    ends = in_space(frame.lines)
    return Drawing(
        flat=True,
        balls=_particles(frame.positions, radii, bead_count, PALE),
        tubes=force_tubes(ends[:, 0], ends[:, 1], frame.forces, frame.in_wire, legend),
        grain=_mean_grain_radius(radii, bead_count),
        legend=legend,
        **_box(*frame.walls),
    )


def sample_drawing(sample: Sample) -> Drawing:
    """Particles of a sample, and its wires."""
    points = in_space(sample.positions)
    a = np.concatenate([np.zeros(0, np.int64), *(chain[:-1] for chain in sample.chains)])
    b = np.concatenate([np.zeros(0, np.int64), *(chain[1:] for chain in sample.chains)])
    thickness = THIN * np.minimum(sample.radii[a], sample.radii[b])
    return Drawing(
        flat=True,
        balls=_particles(sample.positions, sample.radii, sample.bead_count, 1.0),
        tubes=[Tubes(points[a], points[b], thickness, Paint(WIRE))] if len(a) else [],
        grain=_mean_grain_radius(sample.radii, sample.bead_count),
        **_box(0.0, float(sample.box[0]), 0.0, float(sample.box[1])),
    )


def _panel(drawing: Drawing, title: str) -> Panel:
    camera = Camera.looking((0.0, 0.0, 1.0))
    return Panel([lambda: drawing], camera, dimension=2, title=title, shows_forces=True)


def _particles(positions: np.ndarray, radii: np.ndarray, bead_count: int, opacity: float) -> list[Balls]:
    everything = Balls(in_space(positions), np.asarray(radii), Paint(SAND), opacity, rim=True)
    bead = np.arange(len(positions)) < bead_count
    beads = Balls(everything.centres, everything.radii, Paint(BEAD), opacity, rim=True)
    return [everything.take(~bead), beads.take(bead)]


def _mean_grain_radius(radii: np.ndarray, bead_count: int) -> float:
    """Mean radius of the grains [m]; mean radius of the beads if there are no grains."""
    grains = radii[bead_count:]
    return float(np.mean(grains if len(grains) else radii))


def _box(left: float, right: float, bottom: float, top: float) -> dict[str, Any]:
    """Fields of a drawing that show the four walls."""
    corners = in_space(np.array([[left, bottom], [right, bottom], [right, top], [left, top]]))
    walls = list(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    return {"walls": walls, "lines": edges(walls)}
