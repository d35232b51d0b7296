"""Strength of TexSol against content and stiffness of the wire, across and along its layers: docs/strength.md.

Small dense samples in 3D, eight of each, as a campaign. It goes on where it was interrupted:

    python benchmarks/strength.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import numpy as np
from table import report

from lmgcpy.experiment import Campaign, CampaignFolder, CampaignResults, Study3D
from lmgcpy.experiment.campaign.statistics import mean_and_interval
from lmgcpy.experiment.texsol.conclusions import envelope

GRAINS = 1500
BEADS = (200, 400, 800, 1200)
"""Contents of 0.05, 0.1, 0.2 and 0.3: length of the wire times d^2 over the volume."""
CONTENT = 2.5e-4
"""Of a bead."""
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


def strengths(results: CampaignResults) -> dict[tuple, dict[int, dict[str, float]]]:
    """Numbers of each test by (beads, law, axis) and seed; of a soft elastic wire the law is "soft"."""
    found: dict[tuple, dict[int, dict[str, float]]] = defaultdict(lambda: defaultdict(dict))
    for case in results.finished:
        beads, seed, stiff = (case.parameters[name] for name in ("bead_count", "seed", "axial_rigidity"))
        for name, value in case.numbers.items():
            test, quantity = name.split(": ", 1)
            law, axis = test.rsplit("-", 1)
            of_wire = {"elastic-wire": "stiff" if stiff == STIFF else "soft"}.get(law, law)
            found[beads, of_wire, axis][seed][quantity] = value
    return found


def words(values: list[float], unit: float = 1.0, form: str = ".1f") -> str:
    """Mean and 95 % interval of the mean."""
    told = mean_and_interval(np.array(values) / unit)
    return f"{told.mean:{form}} [{told.low:{form}}, {told.high:{form}}]"


def gains(found: dict, beads: int, law: str, axis: str) -> list[str]:
    """Gains over the same samples without the wire's law: deviator and angle, at the peak and late."""
    wire, sand = found[beads, law, axis], found[beads, "none", axis]
    row = []
    for what, unit, form in (("deviator [Pa]", 1e3, ".1f"), ("friction angle [deg]", 1.0, ".2f")):
        for when in ("peak", "late"):
            name = f"{when} {what}"
            row.append(words([wire[seed][name] - sand[seed][name] for seed in wire if seed in sand], unit, form))
    return row


def cohesion(found: dict, beads: int, axis: str, when: str) -> tuple[list[float], list[float]]:
    """Apparent cohesion [EA/(1000 d^2)] and angle [degrees] of an elastic wire from two pressures, by seed.

    With rigid grains only EA/(p d^2) matters: a wire a tenth as stiff is the same wire at ten times the pressure, which is
    1 in units of EA/(1000 d^2) for the stiff one.
    """
    name, stiff, soft = f"{when} friction angle [deg]", found[beads, "stiff", axis], found[beads, "soft", axis]
    lines = [envelope((stiff[s][name], soft[s][name]), (1.0, STIFF / SOFT)) for s in stiff if s in soft]
    return [c for c, _ in lines], [phi for _, phi in lines]


def tables(results: CampaignResults) -> None:
    """Print the tables of docs/strength.md."""
    found = strengths(results)
    rows = []
    for axis in ("z", "x"):
        for beads in (0, *BEADS):
            of_sand = found[beads, "none", axis].values()
            angles = ([one[f"{when} friction angle [deg]"] for one in of_sand] for when in ("peak", "late"))
            rows.append([axis, f"{CONTENT * beads:.2f}", len(of_sand), *(words(values, form=".2f") for values in angles)])
    report("strength_sand", ["along", "content of beads", "samples", "peak angle [deg]", "late angle [deg]"], rows)
    header = ["wire", "along", "content", "samples", "gain at the peak [kPa]", "late [kPa]"]
    rows = [
        [law, axis, f"{CONTENT * beads:.2f}", len(found[beads, law, axis]), *gains(found, beads, law, axis)]
        for law in ("rigid-wire", "stiff", "soft")
        for axis in ("z", "x")
        for beads in BEADS
    ]
    report("strength_gains", [*header, "at the peak [deg]", "late [deg]"], rows)
    rows = []
    for axis in ("z", "x"):
        for beads in BEADS:
            row = [axis, f"{CONTENT * beads:.2f}"]
            for when in ("peak", "late"):
                c, phi = cohesion(found, beads, axis, when)
                row += [words(c, 1e-3, ".0f"), words(phi, form=".2f")]
            rows.append(row)
    header = ["along", "content", "peak: cohesion [1e-3 EA/(1000 d^2)]", "angle [deg]", "late: cohesion", "angle [deg]"]
    report("strength_cohesion", header, rows)


def figure(results: CampaignResults) -> None:
    """Draw the gain of the friction angle over the content into results/strength.png."""
    import matplotlib.pyplot as plt

    found = strengths(results)
    drawn, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
    looks = (
        ("rigid-wire", "rigid", "#164f9c", -0.003),
        ("stiff", "EA = 1000 p d²", "#c8711b", 0.0),
        ("soft", "EA = 100 p d²", "#6d9a3a", 0.003),
    )
    for panel, when in zip(axes, ("peak", "late"), strict=True):
        for law, words_of, color, shift in looks:
            for axis, dash, what in (("z", "-", "across"), ("x", ":", "along")):
                told = []
                for beads in BEADS:
                    wire, sand = found[beads, law, axis], found[beads, "none", axis]
                    name = f"{when} friction angle [deg]"
                    told.append(mean_and_interval([wire[s][name] - sand[s][name] for s in wire if s in sand]))
                at, mean = CONTENT * np.array(BEADS) + shift, np.array([one.mean for one in told])
                bars = np.abs([[one.mean - one.low, one.high - one.mean] for one in told]).T
                look = {"color": color, "linestyle": dash, "marker": "o", "markersize": 3, "capsize": 2}
                panel.errorbar(at, mean, bars, label=f"{words_of}, {what} the layers", **look)
        panel.axhline(0.0, color="0.6", linewidth=0.8)
        panel.set(title="at the peak" if when == "peak" else "late", xlabel="content of wire, length x d² / volume")
    axes[0].set_ylabel("gain of the friction angle [degrees]")
    axes[0].legend(fontsize=8)
    drawn.savefig(Path(__file__).parent / "results" / "strength.png", dpi=120)


def results_of(campaign: Callable[[int], Campaign]) -> CampaignResults:
    """The results of the campaign of so many seeds in the folder that the command line names, carried out as far as it is
    to come, unless by no workers."""
    folder, *counts = sys.argv[1:]
    seeds, workers = [*map(int, counts), *[8, 2][len(counts) :]]
    kept = CampaignFolder(folder)
    if workers:
        campaign(seeds).run(folder, workers=workers, resume=kept.description_file.exists(), progress=True)
    return kept.results()


if __name__ == "__main__":
    found = results_of(campaign)
    tables(found)
    figure(found)
