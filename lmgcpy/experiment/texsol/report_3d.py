"""Output of ``lmgcpy texsol --dimension 3``: tables, figures, pictures and the summary of a study."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import lmgcpy.view.figures as figures
from lmgcpy.errors import AXES
from lmgcpy.experiment.study.folder import ReportFolder, StudyFolder, markdown, sections, texts
from lmgcpy.experiment.study.resolved import LateDifference
from lmgcpy.experiment.texsol.conclusions import (
    UPRIGHT,
    at,
    boundary_mismatch,
    cohesion,
    friction_angle,
    gains,
    late,
    layer_parts,
    peak,
    principal_axes,
)
from lmgcpy.experiment.texsol.pictures import draw_pictures, layers_figure, title
from lmgcpy.experiment.texsol.result import TexSolResult, late_gain
from lmgcpy.experiment.texsol.runs_report import RESOLVED, accuracy_part, prepared_words, runs_part, state_words
from lmgcpy.experiment.triaxial import TriaxialRecord
from lmgcpy.sample.wires import wire_content

STRAINS = (0.01, 0.02, 0.05, 0.10, 0.15, 0.20, 0.30)
"""Crushing at which tests are compared."""


def write_report(result: TexSolResult, folder: StudyFolder) -> list[Path]:
    """Write everything into the study's folder, which is made if it is missing; returns the files.

    The pictures are drawn from its run files.
    """
    report = ReportFolder(folder.path)
    records = list(result.records.values())
    titles = [title(record) for record in records]
    report.table("triaxial.csv", map(_triaxial_columns, records))
    report.table("stress.csv", map(_stress_columns, records))
    report.figure("deviator.png", figures.deviator_figure(records, titles))
    wires = [record for record in records if record.law != "none"]
    if wires:
        report.figure("stress.png", figures.stress_figure(*wires, names=[title(record) for record in wires]))
        report.figure("layers.png", layers_figure(wires))
    missing = draw_pictures(result, folder, report)
    report.text(folder.summary.name, summary(result, missing))
    return report.written


def _triaxial_columns(record: TriaxialRecord) -> Mapping[str, Any]:
    return {
        "law": [record.law] * len(record.strain),
        "axis": [record.axis] * len(record.strain),
        "crushing [%]": texts(100 * record.strain, ".6f"),
        "axial pressure [Pa]": texts(record.axial, ".6g"),
        "lateral pressure [Pa]": texts(record.lateral.mean(axis=1), ".6g"),
        "deviator [Pa]": texts(record.deviator, ".6g"),
        "mean deviator [Pa]": texts(record.smooth(record.deviator), ".6g"),
        "mean pressure [Pa]": texts(record.mean_pressure, ".6g"),
        "volume change [%]": texts(100 * record.volume_change, ".6f"),
        **{f"size {axis} [m]": texts(record.size[:, k], ".9g") for k, axis in enumerate(AXES)},
        "coordination": texts(record.coordination, ".4f"),
        **{f"fabric {axis}{axis}": texts(record.fabric[:, k, k], ".5f") for k, axis in enumerate(AXES)},
        "residual": texts(record.residual, ".3e"),
        "iterations": map(int, record.iterations),
    }


def _stress_columns(record: TriaxialRecord) -> Mapping[str, Any]:
    """The components of each part, and the principal values and directions of its running mean."""
    columns: dict[str, Any] = {
        "law": [record.law] * len(record.strain),
        "axis": [record.axis] * len(record.strain),
        "crushing [%]": texts(100 * record.strain, ".6f"),
    }
    for part, sigma in record.stress.items():
        for i, a in enumerate(AXES):
            columns |= {f"{part} {a}{b} [Pa]": texts(sigma[:, i, j], ".6g") for j, b in enumerate(AXES)}
        values, directions = principal_axes(record.smooth(sigma))
        for i, name in enumerate(("greatest", "middle", "smallest")):
            columns[f"{part} {name} [Pa]"] = texts(values[:, i], ".6g")
            columns |= {f"{part} {name} along {a}": texts(directions[:, i, j], ".4f") for j, a in enumerate(AXES)}
    return columns


# ----------------------------------------------------------------------------------------------------------- summary


def summary(result: TexSolResult, missing_pictures: str = "") -> str:
    """The study as Markdown; ``missing_pictures``: why there are none, or nothing."""
    overlap = ("deepest overlap", lambda record: f"{100 * record.penetration.max() / result.sample.diameter:.1f} % of d")
    compaction = f"Compaction: {result.compaction.seconds:.0f} s. "
    parts = [_sample_part(result), _sand_part(result), _gain_part(result), _anisotropy_part(result)]
    parts += [_principal_part(result), runs_part(result, "test", overlap, boundary_mismatch, compaction)]
    parts += [accuracy_part(result, "test"), missing_pictures]
    return sections("TexSol in 3D: what layers of wire do to the sand", parts)


def _wire_tests(result: TexSolResult) -> list[TriaxialRecord]:
    return [record for record in result.records.values() if record.law != "none"]


def _sand_of(result: TexSolResult, record: TriaxialRecord) -> TriaxialRecord | None:
    """The test of the sand along the same axis."""
    return result.records.get(f"none-{record.axis}")


def _sample_part(result: TexSolResult) -> str:
    study, relaxed, sample = result.study, result.compaction, result.sample
    rest, left = "at rest" if relaxed.at_rest else "NOT at rest", relaxed.unrest
    size = " x ".join(f"{1e3 * length:.1f}" for length in sample.box)
    overlap = relaxed.penetration / (0.5 * sample.diameter)
    return (
        f"{len(sample.radii)} particles, {_wire_words(result)}, seed {study.seed}, in {size} mm, mean grain "
        f"{1e3 * sample.diameter:.2f} mm; {prepared_words(result)} to {1e-3 * study.pressure:g} kPa in "
        f"{relaxed.steps} steps ({rest}: loads balanced to {100 * left.imbalance:.1f} %, mean resultant force on a "
        f"particle {100 * left.force:.1f} % of p d², kinetic energy {left.kinetic:.0e} p d³ a particle, volume steady to "
        f"{left.volume_change:.0e}, deepest overlap {100 * overlap:.2f} % of a mean grain's radius).\n\n"
        f"{state_words(result)}\n\n"
        f"Tests: friction {study.friction:g}, at the platens {study.platen_friction:g}, inertial number "
        f"{study.inertial_number:g}, {100 * study.strain:g} % of crushing, no gravity. z is across the layers."
    )


def _wire_words(result: TexSolResult) -> str:
    sample = result.sample
    if not sample.wires:
        return "without wire"
    length, volume = sample.wire_length, float(np.prod(sample.box))
    many = "one wire" if len(sample.wires) == 1 else f"{len(sample.wires)} wires"
    what = f"beads of {many}"
    if sample.thread:
        distance = max(lengths.max() for lengths in sample.link_lengths) / sample.diameter
        thick = 2e3 * float(sample.radii[0])
        what = f"nodes of {many}, smooth, {thick:.2f} mm thick, at most {distance:.2f} mean grain diameters apart,"
    content = wire_content(length=length, volume=volume)
    return (
        f"{sample.bead_count} of them {what} laid upward in layers, {content:.0f} km/m³ "
        f"({length * sample.diameter**2 / volume:.2f} when lengths are measured in mean grain diameters)"
    )


def _sand_part(result: TexSolResult) -> str:
    rows = []
    for record in result.records.values():
        if record.law != "none":
            continue
        strain, q, phi = peak(record)
        late_q, late_p = float(late(record, record.deviator)), float(late(record, record.mean_pressure))
        half_way = at(record, record.volume_change, 0.5 * record.strain[-1])
        rows.append(
            {
                "along": record.axis,
                "peak deviator": f"{1e-3 * q:.0f} kPa at {100 * strain:.1f} %",
                "angle there": f"{phi:.1f}°",
                "late deviator": f"{1e-3 * late_q:.0f} kPa",
                "late q/p": f"{late_q / late_p:.2f}",
                "late angle": f"{friction_angle(late_q, late_p):.1f}°",
                "volume, half-way": f"{100 * half_way:+.1f} %",
                "volume, late": f"{100 * late(record, record.volume_change):+.1f} %",
            }
        )
    if not rows:
        return ""
    told = "The same sample with no law between the beads; late is the last fifth of the test."
    return f"## The sand\n\n{told}\n\n{markdown(rows)}"


def _gain_part(result: TexSolResult) -> str:
    strains = [strain for strain in STRAINS if strain <= result.study.strain + 1e-9]
    rows = []
    for record in _wire_tests(result):
        sand = _sand_of(result, record)
        if sand is not None:
            ratios = dict(gains(record, sand, strains))
            found = {f"{100 * strain:g} %": f"{ratios[strain]:.2f}" if strain in ratios else "" for strain in strains}
            added = f"{1e-3 * cohesion(record, sand):+.1f} kPa"
            gain = _gain_of(result, record, sand).words(1e3)
            late_columns = {"late gain [kPa]": gain, "cohesion, late": added}
            rows.append({"law": record.law, "along": record.axis, **found, **late_columns})
    if not rows:
        return ""
    return (
        "## Does the wire strengthen the sand?\n\n"
        "Deviator with the wire over that of the sand at equal crushing, their difference late in the test, and the "
        f"cohesion that would raise the sand's deviator as much at its angle of friction:\n\n{markdown(rows)}\n\n{RESOLVED}"
    )


def _anisotropy_part(result: TexSolResult) -> str:
    tests = _wire_tests(result)
    if not tests:
        return ""
    rows = []
    for record in tests:
        wire = np.diag(late(record, record.stress["wire"]))
        within, across = (float(late(record, values)) for values in layer_parts(record))
        ratio = f"{across / within:.2f}" if within > 0.0 else "-"
        parts = {f"{axis}{axis}": f"{1e-3 * value:.2f} kPa" for axis, value in zip(AXES, wire, strict=True)}
        rows.append({"law": record.law, "along": record.axis, **parts, "across / within the layers": ratio})
    told = "## Do layers make it anisotropic?\n\nThe wire's part of the stress, traction positive, late in the test:"
    compared = [_across_against_along(result, law) for law in dict.fromkeys(record.law for record in tests)]
    return "\n\n".join([told, markdown(rows), *filter(None, compared)])


def _across_against_along(result: TexSolResult, law: str) -> str:
    """Words on the strength added by the wire if its layers are stretched both ways, and if they are compressed one way."""
    added: dict[str, LateDifference] = {}
    for axis in result.study.axes:
        record, sand = result.records[f"{law}-{axis}"], result.records.get(f"none-{axis}")
        if sand is not None:
            added[axis] = _gain_of(result, record, sand)
    along = [gain for axis, gain in added.items() if axis != UPRIGHT]
    if UPRIGHT not in added or not along:
        return ""
    across = added[UPRIGHT]
    mean = LateDifference(float(np.mean([gain.value for gain in along])), max(gain.bound for gain in along))
    more = across.minus(mean)
    verdict = ("more" if more.value > 0.0 else "less") + " across than along" if more.resolved else "not resolved"
    return (
        f"Compressed across the layers, so that they are stretched both ways, the {law.replace('-', ' ')} adds "
        f"{across.words(1e3)} kPa to the sand's late deviator; compressed along them {mean.words(1e3)} kPa. The difference "
        f"is {more.value / 1e3:+.1f} ± {more.bound / 1e3:.1f} kPa: **{verdict}**."
    )


def _gain_of(result: TexSolResult, record: TriaxialRecord, sand: TriaxialRecord) -> LateDifference:
    """By how much the wire raises the late deviator [Pa]."""
    return late_gain(result, record, sand, lambda one: one.deviator)


def _principal_part(result: TexSolResult) -> str:
    rows = []
    for record in _wire_tests(result):
        for part in ("wire", "sand", "total"):
            values, directions = principal_axes(late(record, record.stress[part])[None])
            tilt = np.degrees(np.arccos(np.clip(np.abs(directions[0][:, 2]), 0.0, 1.0)))
            angles = " / ".join(f"{angle:.0f}°" for angle in tilt)
            greatest, middle, smallest = (f"{1e-3 * value:.2f}" for value in values[0])
            row = {"law": record.law, "along": record.axis, "part": part, "greatest [kPa]": greatest}
            rows.append({**row, "middle [kPa]": middle, "smallest [kPa]": smallest, "angles to z": angles})
    if not rows:
        return ""
    return (
        "## Principal stresses by part\n\n"
        "Late in the test, traction positive, with the angles that the three directions make with the normal of the "
        "layers:\n\n" + markdown(rows)
    )
