"""Output of ``lmgcpy texsol`` in 2D: tables, figures and the summary of a study."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import lmgcpy.view.figures as figures
from lmgcpy.experiment.biaxial import BiaxialRecord
from lmgcpy.experiment.compression import RAMP
from lmgcpy.experiment.study.folder import ReportFolder, StudyFolder, markdown, sections, texts
from lmgcpy.experiment.texsol.conclusions import (
    LinkDirections,
    column,
    compressed_share,
    compression_in_links,
    cone_ratio,
    extended_cone,
    frames_of_column,
    link_directions,
    stiffening,
)
from lmgcpy.experiment.texsol.pictures import draw_flat_pictures, links_figure
from lmgcpy.experiment.texsol.result import TexSolResult, late_gain
from lmgcpy.experiment.texsol.runs_report import RESOLVED, accuracy_part, prepared_words, runs_part, state_words

NEAR_ZERO = 0.2
"""A principal stress counts as near zero if its ratio to the other one is below this."""
LATE = 0.5
"""The wire's stress is taken beyond this share of the crushing."""


def write_report(result: TexSolResult, folder: StudyFolder) -> list[Path]:
    """Write everything into the study's folder, which is made if it is missing; returns the files."""
    report = ReportFolder(folder.path)
    records = list(result.records.values())
    wires = [record for record in records if record.law != "none"]
    report.table("reaction.csv", map(_reaction_columns, records))
    report.figure("reaction.png", figures.reaction_figure(records, pressure=result.study.pressure))
    report.table("stress.csv", map(_stress_columns, records))
    if wires:
        rigid = [record for record in wires if record.law.startswith("rigid")]
        report.figure("stress.png", figures.stress_figure(*(rigid or wires)))
    found = directions(result)
    if found:
        report.table("links.csv", (_link_columns(law, links) for law, links in found.items()))
        report.figure("links.png", links_figure(found, {law: extended_cone(result.records[law], 0.0) for law in found}))
    missing = draw_flat_pictures(result, report)
    report.text(folder.summary.name, summary(result, missing))
    return report.written


def _reaction_columns(record: BiaxialRecord) -> Mapping[str, Any]:
    return {
        "law": [record.law] * len(record.strain),
        "crushing [%]": texts(100 * record.strain, ".6f"),
        "support reaction [N/m]": texts(record.reaction, ".6g"),
        "mean support reaction [N/m]": texts(record.smooth(record.reaction), ".6g"),
        "upper force [N/m]": texts(record.top_force, ".6g"),
        "width [m]": texts(record.size[:, 0], ".9g"),
        "height [m]": texts(record.size[:, 1], ".9g"),
        "residual": texts(record.residual, ".3e"),
        "iterations": map(int, record.iterations),
    }


def _stress_columns(record: BiaxialRecord) -> Mapping[str, Any]:
    columns: dict[str, Any] = {
        "law": [record.law] * len(record.strain),
        "crushing [%]": texts(100 * record.strain, ".6f"),
    }
    for part, sigma in record.stress.items():
        greater, smaller = figures.principal_series(record, part).T
        columns |= {f"{part} greater [Pa]": texts(greater, ".6g"), f"{part} smaller [Pa]": texts(smaller, ".6g")}
        for component in ("xx", "yy", "xy", "yx"):
            i, j = map("xy".index, component)
            columns[f"{part} {component} [Pa]"] = texts(sigma[:, i, j], ".6g")
    return columns


def _link_columns(law: str, found: LinkDirections) -> Mapping[str, Any]:
    degrees = np.degrees(found.edges)
    return {
        "law": [law] * len(found.links),
        "angle to x from [degrees]": texts(degrees[:-1], ".4g"),
        "to [degrees]": texts(degrees[1:], ".4g"),
        "links": map(int, found.links),
        "links that pull": map(int, found.taut),
        "tension x length [N m]": texts(found.pulled, ".6g"),
        "compression x length [N m]": texts(found.pushed, ".6g"),
    }


# ----------------------------------------------------------------------------------------------------------- summary


def summary(result: TexSolResult, missing: str = "") -> str:
    """The study in words and numbers, as Markdown; ``missing``: why there are no pictures of the sample."""
    inertial_number = ("inertial number", lambda record: f"{record.inertial_number:.1e}")
    parts = [_sample_part(result), _stiffening_part(result), _column_part(result), _wire_stress_part(result)]
    parts += [runs_part(result, "law", inertial_number, boundary_mismatch), accuracy_part(result, "law"), missing]
    return sections("TexSol in 2D: what the wire does to the sand", parts)


def _sample_part(result: TexSolResult) -> str:
    study, relaxed, sample = result.study, result.compaction, result.sample
    rest = "at rest" if relaxed.at_rest else "NOT at rest"
    return (
        f"{len(sample.radii)} particles, {sample.bead_count} of them beads of one wire, seed {study.seed}, in "
        f"{sample.width:.3f} m x {sample.height:.3f} m, {prepared_words(result)} to {1e-3 * study.pressure:g} kPa in "
        f"{relaxed.steps} steps ({rest}: loads balanced to {100 * relaxed.unrest.imbalance:.1f} %, deepest overlap "
        f"{relaxed.penetration:.1e} m).\n\n{state_words(result)}\n\n"
        f"Test: friction {study.friction:g}, at the platens {study.platen_friction:g}, "
        f"{100 * study.strain:g} % of crushing, no gravity."
    )


def _stiffening_part(result: TexSolResult) -> str:
    sand = result.records.get("none")
    if sand is None:
        return ""
    strains = [strain for strain in (0.005, 0.01, 0.02, 0.05, 0.10) if strain <= result.study.strain + 1e-9]
    rows = []
    for law, record in result.records.items():
        if law != "none":
            ratios = dict(stiffening(record, sand, strains))
            found = {f"{100 * strain:g} %": f"{ratios[strain]:.2f}" if strain in ratios else "" for strain in strains}
            gain = late_gain(result, record, sand, lambda one: one.reaction).words(1e3)
            rows.append({"law": law, **found, "late gain [kN/m]": gain})
    if not rows:
        return ""
    told = "Support reaction with the wire over that of the sand at equal crushing, and their difference late in the test:"
    return f"## Does the wire stiffen the sand?\n\n{told}\n\n{markdown(rows)}\n\n{RESOLVED}\n\n{_start_words(result)}"


def _start_words(result: TexSolResult) -> str:
    """How the curves begin beside the isotropic load."""
    load = 1e-3 * result.study.pressure * float(result.compaction.sample.box[0])
    records = result.records.items()
    begin = ", ".join(f"{1e-3 * record.smooth(record.reaction)[0]:.1f} ({figures.name_of(law)})" for law, record in records)
    return (
        f"Before the test the sample is at rest under the isotropic load, {load:.1f} kN/m (dotted in `reaction.png`). The "
        f"curves, running means over 0.25 % of crushing, begin at {begin} kN/m. The platen takes up its speed in "
        f"the first {100.0 * RAMP:g} % of the time, and rigid grains have no elastic strain in which the load would rise "
        "slowly."
    )


def _column_part(result: TexSolResult) -> str:
    rods = [record for law, record in result.records.items() if law.endswith("rod")]
    wire = result.records.get("rigid-wire")
    if not rods:
        return ""
    lines = ["## Did the rods form a compression column?", ""]
    for rod in rods:
        share, at = compression_in_links(rod)
        text = (
            f"{rod.law}: compressed links carry up to {100 * share:.0f} % of the vertical load "
            f"(at {100 * at:.1f} % of crushing); those of a wire carry none."
        )
        if wire is not None:
            where, ratio = column(rod, wire)
            if where is None:
                text += f" **No**: the reaction does not exceed twice the rigid wire's; it is {ratio:.1f} times at most."
            else:
                text += (
                    f" **Yes**: from {100 * where:.1f} % of crushing on the reaction exceeds twice the rigid wire's, "
                    f"which has no such jump; at the most it is {ratio:.1f} times."
                )
            frames = frames_of_column(rod, wire)
            if frames is not None:
                share = compressed_share(frames[1])
                borne = "links" if share > 0.5 else "grains, which taut rods hold from the side"
                text += (
                    f" Where the load is greatest, at {100 * frames[1].strain:.1f} %, compressed links carry "
                    f"{100 * share:.0f} % of it: the column is one of {borne}."
                )
        lines.append(text)
    return "\n".join(lines)


def _wire_stress_part(result: TexSolResult) -> str:
    rows, verdicts = [], []
    for law, found in directions(result).items():
        record = result.records[law]
        late = record.strain > LATE * record.strain[-1]
        greater, smaller = figures.principal_series(record, "wire")[late].mean(axis=0)
        if greater <= 0.0:
            verdicts.append(f"* {law}: the links bore no tension in the second half of the test.")
            continue
        ratio, bound = smaller / greater, extended_cone(record, 0.0)
        rows.append(
            {
                "law": law,
                "greater [kPa]": f"{1e-3 * greater:.1f}",
                "smaller [kPa]": f"{1e-3 * smaller:.1f}",
                "ratio": f"{ratio:.2f}",
                "taut links": f"{100 * found.taut.sum() / max(1.0, found.links.sum()):.0f} %",
                "ratio at equal tensions": f"{found.equal:.2f}",
                "directions extended up to": f"{math.degrees(bound):.0f}°",
                "ratio of such a cone": f"{cone_ratio(bound):.2f}",
            }
        )
        one_sided = abs(ratio) < NEAR_ZERO
        verdict = "one tensile principal stress and one near zero" if one_sided else "not one tensile and one near zero"
        verdicts.append(
            f"* {law}: the second principal stress is {ratio:.2f} times the first: **{verdict}** (below {NEAR_ZERO:g} "
            f"times). {_why(found, ratio, bound)}"
        )
    if not verdicts:
        return ""
    told = (
        "Principal values of the wire's part in the second half of the test, traction positive, beside what the directions "
        "of its links explain: the ratio that the taut links would leave at equal tensions, and that of links in all "
        "directions in which the sample has become longer since the start (0.22 for 45°)."
    )
    parts = ["## The wire's part of the stress", told, *([markdown(rows)] if rows else []), "\n".join(verdicts)]
    return "\n\n".join(parts)


def _why(found: LinkDirections, ratio: float, bound: float) -> str:
    """Words on the parts of a ratio that the directions of the taut links explain, and that their forces explain."""
    share = found.taut_share
    low, high = (float(np.nanmean(part)) for part in (share[: len(share) // 3], share[-(len(share) // 3) :]))
    text = f"{100 * low:.0f} % of the links within 30° of x are taut, {100 * high:.0f} % of those beyond 60°; "
    if found.pushed.any():
        pushed = found.pushed.sum() / (found.pushed.sum() + found.pulled.sum())
        text += f"links in compression have {100 * pushed:.0f} % of the sum of |f| l and take from the second value; "
    tensions = "greater along x than across it" if ratio < found.equal else "not greater along x than across it"
    return text + f"equal tensions in the taut links would leave {found.equal:.2f}, so that tensions are {tensions}."


def directions(result: TexSolResult) -> dict[str, LinkDirections]:
    """Directions of the links in the second half of each test with a wire, by law."""
    chains, found = result.sample.chains, {}
    for law, record in result.records.items():
        frames = [frame for frame in record.frames if frame.strain > LATE * record.strain[-1]]
        if law != "none" and frames:
            found[law] = link_directions(frames, chains)
    return found


def boundary_mismatch(record: BiaxialRecord) -> float:
    """Relative difference of the mean Weber stress and the mean forces on the walls over their area, the worse axis."""
    width, height = record.size[:, 0], record.size[:, 1]
    vertical = -(record.stress["total"][:, 1, 1] * width).mean()
    lateral = -(record.stress["total"][:, 0, 0] * height).mean()
    platens = 0.5 * (record.reaction + record.top_force).mean()
    return float(max(abs(vertical / platens - 1.0), abs(lateral / record.lateral.mean() - 1.0)))
