"""Which length of a sample with a thread decides its strength, that of the layers or the height? docs/texsol_3d.md.

Loose samples with the content of ``thread_by_size.py``, tested in the same way across the layers, without the thread and
with a rigid one: as wide as those of 2000 grains and as high as those of 6500, as high as the former and as wide as the
latter, and as high as the former and 25 grains wide.

    python benchmarks/thread_by_shape.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

from strength import results_of
from table import report
from thread_by_size import CRUSHINGS, compare, each

from lmgcpy.experiment import Campaign, CampaignResults

SHAPES = {(4400, 0.674): (18.6, 12.8), (7850, 0.504): (24.8, 12.6), (2970, 1.5): (12.5, 18.9)}
"""Width and height [mean diameters] by the number of grains and the slenderness."""
TESTS = ("none-z", "rigid-wire-z")


def campaign(seeds: int) -> Campaign:
    """A case for each sample, seed by seed."""
    cases = [
        {"grains": grains, "slenderness": slenderness, "seed": seed}
        for seed in range(seeds)
        for grains, slenderness in SHAPES
    ]
    return Campaign(compare, fixed={"tests": TESTS}, cases=cases)


def tables(results: CampaignResults) -> None:
    """Print the table of docs/texsol_3d.md."""
    rows = []
    for (grains, _), (width, height) in SHAPES.items():
        numbers = [case.numbers for case in results.finished if case.parameters["grains"] == grains]
        if not numbers:
            continue
        sand, rigid = ([one[f"{test}: late deviator [Pa]"] / 1e3 for one in numbers] for test in TESTS)
        wire = [[one[f"rigid-wire-z: the wire's part, {axis} [Pa]"] / 1e3 for axis in "xy"] for one in numbers]
        ratios = [
            [one[f"rigid-wire-z: deviator at {at:.0%} [Pa]"] / one[f"none-z: deviator at {at:.0%} [Pa]"] for one in numbers]
            for at in CRUSHINGS
        ]
        gain = [b - a for a, b in zip(sand, rigid, strict=True)]
        row = [grains, width, height, each(sand, ".0f"), each(gain, ".0f"), each([sum(pair) / 2 for pair in wire], ".1f")]
        rows.append([*row, *(each(ratio, ".2f") for ratio in ratios)])
    header = ["grains", "width [d]", "height [d]", "sand late [kPa]", "gain [kPa]", "wire, mean of xx and yy [kPa]"]
    report("thread_by_shape", [*header, *(f"ratio at {at:.0%}" for at in CRUSHINGS)], rows)


if __name__ == "__main__":
    tables(results_of(campaign))
