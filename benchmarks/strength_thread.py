"""Strength of sand with a smooth thread of its own mass, by content, thickness, friction and stiffness: docs/strength.md.

Samples as in ``strength.py``, 1500 dense grains, with a thread in place of the beads. Nodes are 0.64 grain diameters apart,
0.16 diameters thick, of 167 dtex. They are tested across the layers, for contents of 0.1, 0.2 and 0.3, and along them; at
0.2 one property after another is changed. Gains are over the same sample without the thread, seed by seed.

    python benchmarks/strength_thread.py FOLDER [SEEDS [WORKERS]]      # 0 workers: the tables of what is there
"""

from __future__ import annotations

from collections import defaultdict

from strength import CONTENT, GRAINS, results_of, words
from table import report

from lmgcpy.experiment import Campaign, CampaignResults, Study3D

FRICTION = 0.4
USUAL = {
    "bead_count": 800,
    "axes": ("z",),
    "wire_friction": (FRICTION, FRICTION),
    "thread_diameter": 0.16e-3,
    "laws": ("none", "rigid-wire"),
}
CHANGES: dict[str, dict] = {
    "content 0.1": {"bead_count": 400},
    "content 0.2": {},
    "content 0.3": {"bead_count": 1200},
    "half as thick": {"thread_diameter": 0.08e-3},
    "friction 0.2": {"wire_friction": (0.2, 0.2)},
    "friction 0.8": {"wire_friction": (0.8, 0.8)},
    "EA = 100 p d²": {"laws": ("none", "elastic-wire"), "axial_rigidity": 10.0},
    "content 0.2, along the layers": {"axes": ("x",)},
    "content 0.3, along the layers": {"axes": ("x",), "bead_count": 1200},
}


def campaign(seeds: int) -> Campaign:
    """All tests, seed after seed."""
    study = Study3D(grain_count=GRAINS, wire="thread", preparation="dense")
    cases = [{**USUAL, **change, "seed": seed} for seed in range(seeds) for change in CHANGES.values()]
    return Campaign(study, cases=cases)


def tables(results: CampaignResults) -> None:
    """Print the table of docs/strength.md."""
    found = defaultdict(list)
    for case in results.finished:
        own = {name: value for name, value in case.parameters.items() if name != "seed"}
        for name, change in CHANGES.items():
            if all(same(own[key], value) for key, value in {**USUAL, **change}.items() if key in own):
                found[name].append(case.numbers)
    rows = []
    for name, change in CHANGES.items():
        wanted = {**USUAL, **change}
        test, cases = f"{wanted['laws'][1]}-{wanted['axes'][0]}", found[name]
        row = [name, f"{CONTENT * wanted['bead_count']:.2f}", len(cases)]
        for what, unit in (("deviator [Pa]", 1e3), ("friction angle [deg]", 1.0)):
            for when in ("peak", "late"):
                row.append(words([one[f"{test}: gain of the {when} {what}"] for one in cases], unit) if cases else "")
        stress, unsolved, steps = (
            [one[f"{test}: {quantity}"] for one in cases]
            for quantity in ("late mean stress of the wire [Pa]", "unsolved steps", "steps")
        )
        rows.append([*row, words(stress, 1e3) if cases else "", f"{sum(unsolved):.0f} of {sum(steps):.0f}"])
    header = ["thread", "content", "samples", "gain at the peak [kPa]", "late [kPa]", "at the peak [deg]", "late [deg]"]
    report("strength_thread", [*header, "its mean stress, late [kPa]", "unsolved steps"], rows)


def same(one, other) -> bool:
    return tuple(one) == tuple(other) if isinstance(other, tuple) else one == other


if __name__ == "__main__":
    tables(results_of(campaign))
