"""Loose samples of two sizes with a smooth thread, rigid and elastic, several seeds: docs/texsol_3d.md.

2000 and 6500 grains, twelve and eighteen across, relaxed with friction, with a thread of content 0.18 as in the 3D study. A
sample is compressed across its layers to 15 % without the thread, with a rigid and with an elastic one of EA = 120 N, and
along its layers to 8 % without and with a rigid one. Steps are solved to an error of force of 4e-3. The gains are over the
same sample without the thread.

    python benchmarks/thread_by_size.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

from typing import Any

import numpy as np
from strength import results_of
from table import report

from lmgcpy.experiment import Campaign, CampaignResults, Study3D
from lmgcpy.experiment.texsol.conclusions import late
from lmgcpy.experiment.texsol.result import TexSolResult, measures
from lmgcpy.experiment.texsol.study import PlannedTest

GRAINS = (2000, 6500)
FORCE_ERROR = 4e-3
TESTS = {"none-z": 0.15, "rigid-wire-z": 0.15, "none-x": 0.08, "rigid-wire-x": 0.08, "elastic-wire-z": 0.15}
"""Crushing by the test's law and axis."""
CRUSHINGS = (0.01, 0.02, 0.05, 0.10, 0.15)


def study_of(grains: int, seed: int = 0, slenderness: float = 1.0) -> Study3D:
    """The study of a sample with the usual content."""
    content: dict[str, Any] = {"grain_count": grains, "bead_count": grains * 35 // 65, "slenderness": slenderness}
    return Study3D(wire="thread", seed=seed, force_error=FORCE_ERROR, **content)


def compare(
    site: Any, grains: int = 6500, seed: int = 0, slenderness: float = 1.0, tests: tuple[str, ...] = tuple(TESTS)
) -> dict[str, float]:
    """Numbers of the tests of one sample, which begin with the law and the axis."""
    study = study_of(grains, seed, slenderness)
    compacted = study.prepare(study.lay(site), site)
    records: dict[str, Any] = {}
    for name in tests:
        strain = TESTS[name]
        law, axis = name.rsplit("-", 1)
        planned = PlannedTest(law, axis, strain, study.FRAMES)
        test = study.test(compacted.sample, planned)
        records[name] = site.run(name, name, test.step_count(strain), test.run, strain, frames=planned.frames)
    found, _ = measures(TexSolResult(study, compacted, records, {}))
    for name, record in records.items():
        found[f"{name}: sweeps"] = float(record.iterations.mean())
        for axis, stress in zip("xyz", np.diagonal(late(record, record.stress["wire"])), strict=True):
            found[f"{name}: the wire's part, {axis} [Pa]"] = float(stress)
        for crushing in CRUSHINGS:
            if crushing <= TESTS[name]:
                values = record.smooth(record.deviator)
                found[f"{name}: deviator at {crushing:.0%} [Pa]"] = float(np.interp(crushing, record.strain, values))
    return found


def campaign(seeds: int) -> Campaign:
    """A case for each sample, the small ones first."""
    return Campaign(compare, cases=[{"grains": grains, "seed": seed} for grains in GRAINS for seed in range(seeds)])


def each(values: list[float], form: str) -> str:
    """The mean, and the values of the samples."""
    return f"{np.mean(values):{form}} ({', '.join(f'{value:{form}}' for value in values)})"


def ratios(numbers: list[dict[str, float]]) -> list[str]:
    """Deviators with the rigid thread over those of the sand, across the layers, at the crushings."""
    told = []
    for at in CRUSHINGS:
        tests = "rigid-wire-z", "none-z"
        rigid, sand = ([one[f"{test}: deviator at {at:.0%} [Pa]"] for one in numbers] for test in tests)
        told.append(each([a / b for a, b in zip(rigid, sand, strict=True)], ".2f"))
    return told


def tables(results: CampaignResults) -> None:
    """Print the tables of docs/texsol_3d.md."""
    rows, growth = [], []
    for grains in GRAINS:
        numbers = [case.numbers for case in results.finished if case.parameters["grains"] == grains]
        for name in TESTS:

            def told(quantity: str, unit: float = 1e3, name: str = name, numbers: list = numbers) -> str:
                found = [one[f"{name}: {quantity}"] / unit for one in numbers if f"{name}: {quantity}" in one]
                return each(found, ".1f") if found else ""

            row = [grains, name, *map(told, ("late deviator [Pa]", "gain of the late deviator [Pa]"))]
            row += [told("late friction angle [deg]", 1.0), told("late change of volume", 1e-2)]
            row += [told(f"the wire's part, {axis} [Pa]") for axis in "xyz"]
            row += [told("sweeps", 1.0), f"{sum(one[f'{name}: unsolved steps'] for one in numbers):.0f}"]
            rows.append(row)
        growth.append([grains, *ratios(numbers)])
    header = ["grains", "test", "late deviator [kPa]", "gain [kPa]", "late angle [deg]", "volume [%]"]
    report("thread_by_size", [*header, "wire xx [kPa]", "yy", "zz", "sweeps a step", "unsolved"], rows)
    report("thread_by_size_ratio", ["grains", *(f"{at:.0%}" for at in CRUSHINGS)], growth)


if __name__ == "__main__":
    tables(results_of(campaign))
