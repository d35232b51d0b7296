"""Strength of TexSol against content and stiffness of the wire, across and along its layers: docs/strength.md.

Small dense samples in 3D, eight of each, as a campaign. It goes on where it was interrupted:

    python benchmarks/strength.py FOLDER [SEEDS [WORKERS]]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lmgcpy.experiment import Campaign, Study3D

GRAINS = 1500
BEADS = (200, 400, 800, 1200)
"""Contents of 0.05, 0.1, 0.2 and 0.3: length of the wire times d^2 over the volume."""
STIFF, SOFT = 100.0, 10.0
"""EA of the elastic wires [N]: 1000 and 100 times p d^2."""


def campaign(seeds: int) -> Campaign:
    """All tests: sand without beads, and samples with beads as sand, with a rigid wire, and with two elastic ones."""
    study = Study3D(grain_count=GRAINS, bead_count=0, laws=("none",), preparation="dense", axes=("z", "x"))
    cases: list[dict] = []
    for seed in range(seeds):
        cases.append({"bead_count": 0, "laws": ("none",), "axial_rigidity": STIFF, "seed": seed})
        for beads in BEADS:
            laws = "none", "rigid-wire", "elastic-wire"
            cases.append({"bead_count": beads, "laws": laws, "axial_rigidity": STIFF, "seed": seed})
            cases.append({"bead_count": beads, "laws": ("elastic-wire",), "axial_rigidity": SOFT, "seed": seed})
    return Campaign(study, cases=cases)


if __name__ == "__main__":
    folder, *counts = sys.argv[1:]
    seeds, workers = [*map(int, counts), *[8, 2][len(counts) :]]
    there = (Path(folder) / "campaign.json").exists()
    results = campaign(seeds).run(folder, workers=workers, resume=there, progress=True)
    print(results)
