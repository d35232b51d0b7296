"""Parts of the report that the studies in 2D and 3D share: the sample, the runs, their change at a tighter tolerance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.errors import AXES
from lmgcpy.experiment.study.folder import made_with, markdown
from lmgcpy.experiment.study.unsolved import unsolved_words
from lmgcpy.experiment.texsol.result import TexSolResult, deviation
from lmgcpy.measure.wire_shape import wire_shape


def runs_part(
    result: TexSolResult,
    test: str,
    own: tuple[str, Callable[[Any], str]],
    mismatch: Callable[[Any], float],
    compaction: str = "",
) -> str:
    """Table of the cost and the accuracy of every run.

    ``test``: heading of the tests' names; ``own``: heading and entry (a function of a record) of a column for this
    dimension; ``mismatch``: relative difference of the Weber stress and the walls' forces; ``compaction``: a sentence on
    the compaction.
    """
    heading, entry = own
    rows = [
        {
            test: name,
            "steps": f"{len(record.strain)}",
            "mean residual": f"{record.residual.mean():.1e}",
            "worst residual": f"{record.residual.max():.1e}",
            "unconverged steps": f"{record.unconverged}",
            "iterations a step": f"{record.iterations.mean():.0f}",
            "interactions": f"{record.interactions.mean():.0f}",
            heading: entry(record),
            "energy defect [J]": f"{np.abs(record.defect).max():.1e}",
            "stress against walls": f"{100 * mismatch(record):.2f} %",
            "seconds": f"{record.seconds:.0f}",
        }
        for name, record in result.records.items()
    ]
    study, relaxed = result.study, result.compaction
    unsolved = unsolved_words(result.records, tolerance=study.tolerance, max_iterations=study.max_iterations)
    if relaxed.unconverged:
        told = f"{relaxed.unconverged} of the {relaxed.steps} steps of the compaction were not solved to its tolerance."
        unsolved = f"{unsolved} {told}".strip()
    took = f"{compaction}{result.seconds:.0f} s of steps in all, {result.study.threads} tests at once; {made_with()}."
    return "\n\n".join(filter(None, ["## The runs", markdown(rows), ended_words(result), unsolved, took]))


def prepared_words(result: TexSolResult) -> str:
    """How the sample was relaxed: "relaxed with friction 0.4", "relaxed without friction"."""
    study = result.study
    return "relaxed " + (f"with friction {study.friction:g}" if study.preparation == "loose" else "without friction")


def state_words(result: TexSolResult) -> str:
    """Solid fraction, coordination, rattlers, fabric, and the shape of the wire at the start of the tests."""
    relaxed, sample = result.compaction, result.sample
    axes = AXES[: sample.dimension]
    fabric = ", ".join(f"{value:.3f}" for value in np.diag(relaxed.fabric))
    text = (
        f"Solid fraction one coarsest diameter from the walls **{relaxed.solid_fraction:.3f}**, coordination "
        f"**{relaxed.coordination:.2f}**, {100 * relaxed.rattlers:.1f} % of the grains rattlers; fabric along "
        f"{', '.join(axes)}: {fabric}."
    )
    if max(sample.wires, default=0) < 3:
        return text
    shape = wire_shape(sample.positions, sample.chains)
    return (
        f"{text} The wire, laid with turns up to {result.study.theta_max:g} rad, has a persistence length of "
        f"{shape.persistence_length / sample.diameter:.1f} mean diameters, "
        f"{shape.persistence_length / sample.width:.2f} of the sample's width; the directions of its links have the "
        f"anisotropy {shape.anisotropy:.2f}."
    )


def ended_words(result: TexSolResult) -> str:
    """Sentences on the tests that ended before their strain, and why; empty if none did."""
    study, told = result.study, []
    for name, record in result.records.items():
        at = f"{100 * record.strain[-1]:.2f} % of crushing"
        if record.ended == "locked":
            told.append(f"{name} is locked at {at}: no motion of the platen is compatible with the sample's constraints.")
        elif record.ended:
            told.append(f"{name} ends at {at}, where the reaction exceeds {study.greatest_reaction:g} pressure x area.")
    return "\n".join(told)


def accuracy_part(result: TexSolResult, test: str) -> str:
    """The change of every checked test at the tighter tolerance; nothing if no test was checked."""
    study = result.study
    if not result.checks:
        return ""
    rows = [
        {
            test: name,
            "change": f"{100 * deviation(result.records[name], check):.1f} %",
            "tolerance": f"{check.tolerance:.0e}",
            "mean residual there": f"{check.residual.mean():.1e}",
            "unconverged steps there": f"{check.unconverged} of {len(check.strain)}",
            "seconds there": f"{check.seconds:.0f}",
        }
        for name, check in result.checks.items()
    ]
    return (
        "## How far the result is the solver's\n\n"
        f"Mean change of the reaction over the first {100 * min(study.check_strain, study.strain):g} % of crushing at a "
        f"{study.TIGHTER:g} times tighter tolerance:\n\n{markdown(rows)}"
    )


RESOLVED = (
    "± is what the noise of the curves leaves of a late difference (95 %), or its change by a tighter tolerance if that is "
    "more. Other samples differ by more: `lmgcpy campaign` gives intervals over seeds."
)
"""The meaning of resolved, below a table of differences."""
