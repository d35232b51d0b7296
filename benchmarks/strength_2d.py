"""Strength of TexSol in 2D: sand, wire and rods, loose and dense, eight samples of each: docs/strength.md.

    python benchmarks/strength_2d.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

from strength import results_of, words
from table import report

from lmgcpy.experiment import Campaign, CampaignResults, Study2D

LAWS = ("rigid-wire", "rigid-rod")
PREPARATIONS = ("loose", "dense")


def campaign(seeds: int) -> Campaign:
    """Biaxial tests of 600 grains and 106 beads, as dense in wire as the default study."""
    study = Study2D(grain_count=600, bead_count=106, strain=0.08, check_strain=0.0, laws=("none", *LAWS))
    cases = [{"seed": seed, "preparation": preparation} for seed in range(seeds) for preparation in PREPARATIONS]
    return Campaign(study, cases=cases)


def tables(results: CampaignResults) -> None:
    """Print the tables of docs/strength.md."""
    rows = []
    for preparation in PREPARATIONS:
        cases = [case.numbers for case in results.finished if case.parameters["preparation"] == preparation]
        for law in ("none", *LAWS):
            row = [preparation, law, len(cases)]
            for when in ("peak", "late"):
                row.append(words([one[f"{law}: {when} friction angle [deg]"] for one in cases], form=".1f"))
                name = f"{law}: gain of the {when} friction angle [deg]"
                row.append("" if law == "none" else words([one[name] for one in cases], form=".1f"))
            unsolved = sum(one[f"{law}: unsolved steps"] for one in cases) / sum(one[f"{law}: steps"] for one in cases)
            rows.append([*row, f"{100.0 * unsolved:.1f}"])
    header = ["preparation", "law", "samples", "peak angle [deg]", "gain [deg]", "late angle [deg]", "gain [deg]"]
    report("strength_2d", [*header, "steps not solved [%]"], rows)


if __name__ == "__main__":
    tables(results_of(campaign))
