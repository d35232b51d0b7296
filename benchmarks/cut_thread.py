"""Short fibres beside the continuous thread at equal weight: the thread of a sample is cut in pieces: docs/strength.md.

Samples of 1500 dense grains with a thread of content 0.3, as in ``strength_thread.py``, are relaxed with the whole thread.
Each is compressed across the layers without the thread, with it, and with the same thread cut in pieces of 32 and of 16
nodes, 0.64 grain diameters apart. A cut takes one segment out. Gains are over the same sample without the thread.

    python benchmarks/cut_thread.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the table of what is there
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from strength import GRAINS, results_of, words
from strength_thread import USUAL
from table import report

from lmgcpy.experiment import Campaign, CampaignResults, Sample, Study3D
from lmgcpy.experiment.texsol.result import TexSolResult, measures
from lmgcpy.experiment.texsol.study import PlannedTest

PIECES = (32, 16)
"""Nodes of a piece."""


def cut(sample: Sample, nodes: int) -> Sample:
    """The sample with its thread in pieces of ``nodes`` nodes; the last takes what is left."""
    (count,), (gaps,) = sample.wires, sample.link_gaps
    starts = np.arange(0, count - nodes + 1, nodes)
    ends = np.append(starts[1:], count)
    kept = [gaps[start : end - 1] for start, end in zip(starts, ends, strict=True)]
    return replace(sample, wires=tuple((ends - starts).tolist()), reference_gap=np.concatenate(kept))


def compare(site: Any, seed: int = 0) -> dict[str, float]:
    """Numbers of the tests of one sample, which begin with the nodes of a piece, or with "whole"."""
    study = Study3D(grain_count=GRAINS, wire="thread", preparation="dense", seed=seed, **{**USUAL, "bead_count": 1200})
    compacted = study.prepare(study.lay(site), site)

    def crush(name: str, law: str, sample: Sample) -> Any:
        test = study.test(sample, PlannedTest(law, "z", study.strain, 0))
        return site.run(name, f"triaxial test, {name}", test.step_count(study.strain), test.run, study.strain, frames=0)

    sand = crush("sand", "none", compacted.sample)
    found: dict[str, float] = {}
    for pieces in ("whole", *PIECES):
        sample = compacted.sample if pieces == "whole" else cut(compacted.sample, int(pieces))
        records = {"none-z": sand, "rigid-wire-z": crush(f"thread-{pieces}", "rigid-wire", sample)}
        numbers, _ = measures(TexSolResult(study, compacted, records, {}))
        of_thread = {name.split(": ", 1)[1]: value for name, value in numbers.items() if name.startswith("rigid-wire-z: ")}
        of_thread["length of a piece [d]"] = sample.wire_length / len(sample.wires) / sample.diameter
        of_thread["length left"] = sample.wire_length / compacted.sample.wire_length
        found |= {f"{pieces}: {name}": value for name, value in of_thread.items()}
    return found


def campaign(seeds: int) -> Campaign:
    """A case for each sample."""
    return Campaign(compare, cases=[{"seed": seed} for seed in range(seeds)])


def tables(results: CampaignResults) -> None:
    """Print the table of docs/strength.md."""
    rows = []
    for pieces in ("whole", *PIECES):
        numbers = [
            {name.split(": ", 1)[1]: value for name, value in case.numbers.items() if name.startswith(f"{pieces}: ")}
            for case in results.finished
        ]

        def told(quantity: str, unit: float = 1.0, numbers: list[dict[str, float]] = numbers) -> str:
            return words([one[quantity] for one in numbers], unit)

        sizes = (np.mean([one[name] for one in numbers]) for name in ("length of a piece [d]", "length left"))
        row = [pieces, *map("{:.2f}".format, sizes)]
        row += [told("gain of the peak deviator [Pa]", 1e3), told("gain of the late deviator [Pa]", 1e3)]
        row += [told("gain of the peak friction angle [deg]"), told("gain of the late friction angle [deg]")]
        unsolved, steps = (sum(one[name] for one in numbers) for name in ("unsolved steps", "steps"))
        rows.append([*row, told("late mean stress of the wire [Pa]", 1e3), f"{unsolved:.0f} of {steps:.0f}"])
    header = ["nodes of a piece", "its length [d]", "length left", "gain at the peak [kPa]", "late [kPa]"]
    header += ["at the peak [deg]", "late [deg]", "mean stress of the thread, late [kPa]", "unsolved steps"]
    report("cut_thread", header, rows)


if __name__ == "__main__":
    tables(results_of(campaign))
