"""A 3D study in words and numbers."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from lmgcpy.experiment.texsol_3d import (
    TIGHTER,
    UPRIGHT,
    Study3D,
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
from lmgcpy.experiment.texsol_tests import Result, deviation, versions
from lmgcpy.experiment.triaxial import TriaxialRecord
from lmgcpy.sample.arguments import AXES
from lmgcpy.sample.wire_content import wire_content

STRAINS = (0.01, 0.02, 0.05, 0.10, 0.15, 0.20, 0.30)
"""At which tests are compared."""


def summary(result: Result, missing_pictures: str = "") -> str:
    """The study as Markdown; ``missing_pictures``: why there are none, or nothing."""
    parts = [_sample_part(result), _sand_part(result), _gain_part(result), _anisotropy_part(result)]
    parts += [_principal_part(result), _runs_part(result), _accuracy_part(result), missing_pictures]
    return "\n\n".join(["# TexSol in 3D: what layers of wire do to the sand", *filter(None, parts)]) + "\n"


def _table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    header = list(header)
    lines = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _wire_tests(result: Result) -> list[TriaxialRecord]:
    return [record for record in result.records.values() if record.law != "none"]


def _sand_of(result: Result, record: TriaxialRecord) -> TriaxialRecord | None:
    """The test of the sand along the same axis."""
    return result.records.get(f"none-{record.axis}")


def _sample_part(result: Result) -> str:
    study, relaxed, sample = result.study, result.compaction, result.sample
    rest, left = "at rest" if relaxed.at_rest else "NOT at rest", relaxed.unrest
    size = " x ".join(f"{1e3 * length:.1f}" for length in sample.box)
    fabric = ", ".join(f"{value:.3f}" for value in np.diag(relaxed.fabric))
    overlap = relaxed.penetration / (0.5 * sample.diameter)
    return (
        f"{len(sample.radii)} particles, {_wire_words(result)}, seed {study.seed}, in {size} mm, mean grain "
        f"{1e3 * sample.diameter:.2f} mm; compacted without friction to {1e-3 * study.pressure:g} kPa in {relaxed.steps} "
        f"steps ({rest}: loads balanced to {100 * left.imbalance:.1f} %, mean resultant force on a particle "
        f"{100 * left.force:.1f} % of p d², kinetic energy {left.kinetic:.0e} p d³ a particle, volume steady to "
        f"{left.volume_change:.0e}, deepest overlap {100 * overlap:.2f} % of a mean grain's radius).\n\n"
        f"Solid fraction one coarsest diameter from the walls **{relaxed.solid_fraction:.3f}**, coordination "
        f"**{relaxed.coordination:.2f}**, {100 * relaxed.rattlers:.1f} % of the grains rattlers; fabric along x, y, z: "
        f"{fabric}.\n\n"
        f"Tests: friction {study.friction:g}, at the platens {study.platen_friction:g}, inertial number "
        f"{study.inertial_number:g}, {100 * study.strain:g} % of crushing, no gravity. z is across the layers."
    )


def _wire_words(result: Result) -> str:
    sample = result.sample
    if not sample.wires:
        return "without wire"
    link = sample.reference_gap + 2.0 * float(sample.radii[0])
    length, volume = link * (sample.bead_count - len(sample.wires)), float(np.prod(sample.box))
    many = "one wire" if len(sample.wires) == 1 else f"{len(sample.wires)} wires"
    content = wire_content(length=length, volume=volume)
    return (
        f"{sample.bead_count} of them beads of {many} laid upward in layers, {content:.0f} km/m³ "
        f"({length * sample.diameter**2 / volume:.2f} when lengths are measured in mean grain diameters)"
    )


def _sand_part(result: Result) -> str:
    rows = []
    for record in result.records.values():
        if record.law != "none":
            continue
        strain, q, phi = peak(record)
        late_q, late_p = float(late(record, record.deviator)), float(late(record, record.mean_pressure))
        half_way = at(record, record.volume_change, 0.5 * record.strain[-1])
        rows.append(
            (
                record.axis,
                f"{1e-3 * q:.0f} kPa at {100 * strain:.1f} %",
                f"{phi:.1f}°",
                f"{1e-3 * late_q:.0f} kPa",
                f"{late_q / late_p:.2f}",
                f"{friction_angle(late_q, late_p):.1f}°",
                f"{100 * half_way:+.1f} %",
                f"{100 * late(record, record.volume_change):+.1f} %",
            )
        )
    if not rows:
        return ""
    header = ["along", "peak deviator", "angle there", "late deviator", "late q/p", "late angle"]
    told = "The same sample with no law between the beads; late is the last fifth of the test."
    return f"## The sand\n\n{told}\n\n" + _table([*header, "volume, half-way", "volume, late"], rows)


def _gain_part(result: Result) -> str:
    strains = [strain for strain in STRAINS if strain <= result.study.strain + 1e-9]
    rows = []
    for record in _wire_tests(result):
        sand = _sand_of(result, record)
        if sand is not None:
            ratios = [f"{ratio:.2f}" for _, ratio in gains(record, sand, strains)]
            rows.append((record.law, record.axis, *ratios, f"{1e-3 * cohesion(record, sand):+.1f} kPa"))
    if not rows:
        return ""
    header = ["law", "along", *(f"{100 * strain:g} %" for strain in strains), "cohesion, late"]
    return (
        "## By how much the wire strengthens the sand\n\n"
        "Deviator with the wire over that of the sand at equal crushing, and the cohesion that would raise the sand's "
        "deviator as much at its angle of friction:\n\n" + _table(header, rows)
    )


def _anisotropy_part(result: Result) -> str:
    tests = _wire_tests(result)
    if not tests:
        return ""
    rows = []
    for record in tests:
        wire = np.diag(late(record, record.stress["wire"]))
        within, across = (float(late(record, values)) for values in layer_parts(record))
        ratio = f"{across / within:.2f}" if within > 0.0 else "-"
        rows.append((record.law, record.axis, *(f"{1e-3 * value:.2f} kPa" for value in wire), ratio))
    header = ["law", "along", *(f"{axis}{axis}" for axis in AXES), "across / within the layers"]
    told = "## Layers make it anisotropic\n\nThe wire's part of the stress, traction positive, late in the test:"
    compared = [_across_against_along(result, law) for law in dict.fromkeys(record.law for record in tests)]
    return "\n\n".join([told, _table(header, rows), *filter(None, compared)])


def _across_against_along(result: Result, law: str) -> str:
    """What the wire adds where its layers are stretched both ways, and where they are compressed one way."""
    added = {}
    for axis in result.study.axes:
        record, sand = result.records[f"{law}-{axis}"], result.records.get(f"none-{axis}")
        if sand is not None:
            added[axis] = float(late(record, record.deviator) - late(sand, sand.deviator))
    along = [value for axis, value in added.items() if axis != UPRIGHT]
    if UPRIGHT not in added or not along:
        return ""
    across, mean = added[UPRIGHT], float(np.mean(along))
    stronger = "more" if across > mean else "less"
    return (
        f"Compressed across the layers, so that they are stretched both ways, the {law.replace('-', ' ')} adds "
        f"{1e-3 * across:.1f} kPa to the sand's late deviator; compressed along them {1e-3 * mean:.1f} kPa: **{stronger} "
        "across than along**."
    )


def _principal_part(result: Result) -> str:
    rows = []
    for record in _wire_tests(result):
        for part in ("wire", "sand", "total"):
            values, directions = principal_axes(late(record, record.stress[part])[None])
            tilt = np.degrees(np.arccos(np.clip(np.abs(directions[0][:, 2]), 0.0, 1.0)))
            angles = " / ".join(f"{angle:.0f}°" for angle in tilt)
            rows.append((record.law, record.axis, part, *(f"{1e-3 * value:.2f}" for value in values[0]), angles))
    if not rows:
        return ""
    header = ["law", "along", "part", "greatest [kPa]", "middle [kPa]", "smallest [kPa]", "angles to z"]
    return (
        "## Principal stresses by part\n\n"
        "Late in the test, traction positive, with the angles that the three directions make with the normal of the "
        "layers:\n\n" + _table(header, rows)
    )


def _runs_part(result: Result) -> str:
    header = ["test", "steps", "mean residual", "worst residual", "unconverged steps", "iterations a step"]
    header += ["interactions", "deepest overlap", "energy defect [J]", "stress against walls", "seconds"]
    rows = [
        (
            name,
            f"{len(record.strain)}",
            f"{record.residual.mean():.1e}",
            f"{record.residual.max():.1e}",
            f"{record.unconverged}",
            f"{record.iterations.mean():.0f}",
            f"{record.interactions.mean():.0f}",
            f"{100 * record.penetration.max() / result.sample.diameter:.1f} % of d",
            f"{np.abs(record.defect).max():.1e}",
            f"{100 * boundary_mismatch(record):.2f} %",
            f"{record.seconds:.0f}",
        )
        for name, record in result.records.items()
    ]
    return (
        f"## The runs\n\n{_table(header, rows)}\n\nCompaction: {result.compaction.seconds:.0f} s. "
        f"{result.seconds:.0f} s of steps in all, {result.study.threads} tests at once; {versions()}."
    )


def _accuracy_part(result: Result) -> str:
    study: Study3D = result.study
    if not result.checks:
        return ""
    rows = [
        (
            name,
            f"{100 * deviation(result.records[name], check):.1f} %",
            f"{check.tolerance:.0e}",
            f"{check.residual.mean():.1e}",
            f"{check.unconverged} of {len(check.strain)}",
            f"{check.seconds:.0f}",
        )
        for name, check in result.checks.items()
    ]
    header = ["test", "change", "tolerance", "mean residual there", "unconverged steps there", "seconds there"]
    return (
        "## How far the result is the solver's\n\n"
        f"Mean change of the reaction over the first {100 * min(study.check_strain, study.strain):g} % of crushing at a "
        f"{TIGHTER:g} times tighter tolerance:\n\n{_table(header, rows)}"
    )
