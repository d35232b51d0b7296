"""Figures and pictures of the TexSol studies that no other study has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import numpy as np

import lmgcpy.view.figures as figures
from lmgcpy.errors import AXES
from lmgcpy.experiment.study.folder import ReportFolder, StudyFolder
from lmgcpy.experiment.texsol.conclusions import LinkDirections, frames_at_equal_force, frames_of_column
from lmgcpy.experiment.texsol.result import TexSolResult
from lmgcpy.experiment.triaxial import TriaxialRecord
from lmgcpy.io.run import open_run
from lmgcpy.view.drawing import PUSHING, WIRE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    from lmgcpy.view.force_chains import draw_chains, draw_sample

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
