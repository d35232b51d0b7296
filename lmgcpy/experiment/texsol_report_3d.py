"""What ``lmgcpy texsol --dimension 3`` writes: tables, figures, pictures and the summary of a study."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import lmgcpy.view.figures as figures
from lmgcpy.experiment.compression import PARTS
from lmgcpy.experiment.report_files import ReportFolder
from lmgcpy.experiment.texsol_3d import principal_axes
from lmgcpy.experiment.texsol_folder import StudyFolder
from lmgcpy.experiment.texsol_pictures import draw_pictures
from lmgcpy.experiment.texsol_summary_3d import summary
from lmgcpy.experiment.texsol_tests import Result
from lmgcpy.experiment.triaxial import TriaxialRecord
from lmgcpy.sample.arguments import AXES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_report_3d(result: Result, folder: StudyFolder) -> list[Path]:
    """Write everything into the study's folder, which is made; returns the files. Pictures are of its run files."""
    report = ReportFolder(folder.path)
    records = list(result.records.values())
    titles = [title(record) for record in records]
    report.table("triaxial.csv", *_triaxial_table(records))
    report.table("stress.csv", *_stress_table(records))
    report.figure("deviator.png", figures.deviator_figure(records, titles))
    wires = [record for record in records if record.law != "none"]
    if wires:
        report.figure("stress.png", figures.stress_figure(*wires, names=[title(record) for record in wires]))
        report.figure("layers.png", layers_figure(wires))
    missing = draw_pictures(result, folder, report)
    report.text("summary.md", summary(result, missing))
    return report.written


def title(record: TriaxialRecord) -> str:
    """What a test is called in a legend."""
    return f"{figures.name_of(record.law)} along {record.axis}"


def layers_figure(records: list[TriaxialRecord]) -> Figure:
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


def _triaxial_table(records: list[TriaxialRecord]) -> tuple[list[str], list[list]]:
    header = ["law", "axis", "crushing [%]", "axial pressure [Pa]", "lateral pressure [Pa]", "deviator [Pa]"]
    header += ["mean deviator [Pa]", "mean pressure [Pa]", "volume change [%]"]
    header += [f"size {axis} [m]" for axis in AXES]
    header += ["coordination", *(f"fabric {axis}{axis}" for axis in AXES), "residual", "iterations"]
    rows = []
    for record in records:
        lateral, deviator, pressure = record.lateral.mean(axis=1), record.deviator, record.mean_pressure
        mean = record.smooth(deviator)
        for k in range(len(record.strain)):
            row = [record.law, record.axis, f"{100 * record.strain[k]:.6f}"]
            row += [f"{value[k]:.6g}" for value in (record.axial, lateral, deviator, mean, pressure)]
            row += [f"{100 * record.volume_change[k]:.6f}", *(f"{size:.9g}" for size in record.size[k])]
            row += [f"{record.coordination[k]:.4f}", *(f"{record.fabric[k, i, i]:.5f}" for i in range(3))]
            rows.append([*row, f"{record.residual[k]:.3e}", int(record.iterations[k])])
    return header, rows


def _stress_table(records: list[TriaxialRecord]) -> tuple[list[str], list[list]]:
    """Of each part its components as they are, and principal values and directions of their running mean."""
    header = ["law", "axis", "crushing [%]"]
    for part in PARTS:
        header += [f"{part} {a}{b} [Pa]" for a in AXES for b in AXES]
        for name in ("greatest", "middle", "smallest"):
            header += [f"{part} {name} [Pa]", *(f"{part} {name} along {axis}" for axis in AXES)]
    rows = []
    for record in records:
        axes = {part: principal_axes(record.smooth(sigma)) for part, sigma in record.stress.items()}
        for k in range(len(record.strain)):
            row = [record.law, record.axis, f"{100 * record.strain[k]:.6f}"]
            for part in PARTS:
                row += [f"{value:.6g}" for value in record.stress[part][k].ravel()]
                values, directions = axes[part][0][k], axes[part][1][k]
                for value, direction in zip(values, directions, strict=True):
                    row += [f"{value:.6g}", *(f"{x:.4f}" for x in direction)]
            rows.append(row)
    return header, rows
