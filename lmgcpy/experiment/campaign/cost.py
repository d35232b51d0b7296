"""The cost of the cases of a campaign, estimated before anybody pays for it."""

from __future__ import annotations

from statistics import mean
from typing import Any

from lmgcpy.experiment.campaign.description import CampaignCase
from lmgcpy.experiment.campaign.results import CampaignResults
from lmgcpy.experiment.texsol.study import TexSolStudy

PER_PARTICLE_AND_STEP = {2: 2.7 * 1000 * 15e-9, 3: 3.8 * 500 * 20e-9}
"""Seconds of one processor: interactions a particle, sweeps a step, and seconds an interaction and sweep, as measured on
the default studies (docs/texsol.md, docs/texsol_3d.md, docs/benchmarks.md). Jammed rods take several times as much."""
RELAXATION = 0.5
"""Cost of a relaxation, in tests to 10 % of crushing."""


def seconds_of(case: CampaignCase, so_far: CampaignResults) -> tuple[float | None, str]:
    """Expected seconds of a case on one processor, None if nothing is known, and their source.

    They are the mean of the finished cases that differ from it in the fewest parameters; else, of a TexSol study, the
    number of tests, steps and particles times the cost of each so far.
    """
    finished = so_far.finished
    if finished:
        differing = [sum(one.parameters.get(k) != v for k, v in case.parameters.items()) for one in finished]
        nearest = [one.seconds for one, n in zip(finished, differing, strict=True) if n == min(differing)]
        return mean(nearest), f"{len(nearest)} finished alike"
    if isinstance(case.work, TexSolStudy):
        return _of_study(case.work), "table"
    return None, "unknown"


def _of_study(study: Any) -> float:
    """A test to a strain takes ``strain / (0.2 I)`` steps, I the inertial number: the velocity is I H/t, the step t/5."""
    particles = study.grain_count + study.bead_count
    tests = [(one.strain, study.inertial_number) for one in [*study.planned, *study.checks]]
    steps = sum(strain / (0.2 * inertial) for strain, inertial in tests) + RELAXATION * 0.1 / (0.2 * study.inertial_number)
    return steps * particles * PER_PARTICLE_AND_STEP[study.DIMENSION]
