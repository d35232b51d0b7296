"""Which length of a sample with a thread decides its strength, that of the layers or the height? docs/texsol_3d.md.

Loose samples with the content of ``thread_by_size.py``, tested in the same way across the layers, without the thread and
with a rigid one: as wide as those of 2000 grains and as high as those of 6500, as high as the former and as wide as the
latter, and as high as the former and 25 grains wide.

    python benchmarks/thread_by_shape.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

from strength import results_of
from table import report
from thread_by_size import CRUSHINGS, compare, each, ratios, study_of

from lmgcpy.experiment import Campaign, CampaignResults

SHAPES = {4400: 0.674, 7850: 0.504, 2970: 1.5}
"""Slenderness by the number of grains."""
TESTS = ("none-z", "rigid-wire-z")


def campaign(seeds: int) -> Campaign:
    """A case for each sample, seed by seed."""
    shapes = [{"grains": grains, "slenderness": slenderness} for grains, slenderness in SHAPES.items()]
    return Campaign(compare, fixed={"tests": TESTS}, cases=[{**shape, "seed": k} for k in range(seeds) for shape in shapes])


def tables(results: CampaignResults) -> None:
    """Print the table of docs/texsol_3d.md; widths and heights are those of the first sample as it is laid."""
    rows = []
    for grains, slenderness in SHAPES.items():
        numbers = [case.numbers for case in results.finished if case.parameters["grains"] == grains]
        if numbers:
            laid = study_of(grains, slenderness=slenderness).lay_sample()
            sizes = [f"{length / laid.diameter:.1f}" for length in laid.box[[0, 2]]]
            sand, rigid = ([one[f"{test}: late deviator [Pa]"] / 1e3 for one in numbers] for test in TESTS)
            gain = [b - a for a, b in zip(sand, rigid, strict=True)]
            wire = [sum(one[f"rigid-wire-z: the wire's part, {axis} [Pa]"] for axis in "xy") / 2e3 for one in numbers]
            rows.append([grains, *sizes, each(sand, ".0f"), each(gain, ".0f"), each(wire, ".1f"), *ratios(numbers)])
    header = ["grains", "width [d]", "height [d]", "sand late [kPa]", "gain [kPa]", "wire, mean of xx and yy [kPa]"]
    report("thread_by_shape", [*header, *(f"ratio at {at:.0%}" for at in CRUSHINGS)], rows)


if __name__ == "__main__":
    tables(results_of(campaign))
