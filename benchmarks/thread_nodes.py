"""Node distance of a thread in a sample of TexSol, and a wire of beads beside it: docs/texsol_3d.md.

Samples of the study in 3D with few grains, relaxed with friction and crushed along z by 10 %, across the layers of the
wire. The thread has a node at every bead's place, at every second or at every third, and the mass of a thread of 167
dtex, and beads have theirs of it. Means over the second half of the test;
"tension" is the mean of all links, "taut" the share of links above a hundredth of the greatest tension.

    python benchmarks/thread_nodes.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Study3D, compact
from lmgcpy.experiment.texsol.study import DENSITY, PlannedTest

STRAIN = 0.10
WIRES = {
    "beads": {"wire": "beads", "bead_mass": "own"},
    "thread": {"wire": "thread", "node_distance": 0.4},
    "thread ": {"wire": "thread", "node_distance": 0.7},
    "thread  ": {"wire": "thread", "node_distance": 1.0},
}
HEADER = ["law", "wire", "spacing [d]", "seed", "particles", "deviator [kPa]", "dilation [%]", "wire xx, yy, zz [kPa]"]
HEADER += ["tension [mN]", "taut", "deepest overlap [d]", "sweeps a step", "unsolved", "processor s"]


def crushed(study: Study3D, sample, law: str) -> list:
    """The columns of one test from the deviator on."""
    test = study.test(sample, PlannedTest(law, "z", STRAIN, 0))
    pulls, taut = [], []
    observed = test.observed

    def with_tension():
        def tension(sim: lm.Simulation) -> float:
            links = lm.measure.wire_links(sim).tension
            pulls.append(links.mean())
            taut.append((links > 0.01 * links.max()).mean() if links.max() > 0.0 else 0.0)
            return float(pulls[-1])

        return {**observed(), "tension": tension} if law != "none" else observed()

    test.observed = with_tension
    record = test.run(STRAIN, frames=0)
    late = record.strain > 0.5 * STRAIN
    half = slice(len(pulls) // 2, None)
    wire = ", ".join(f"{x / 1e3:.1f}" for x in np.diag(record.stress["wire"][late].mean(axis=0)))
    tension = (f"{1e3 * np.mean(pulls[half]):.2f}", f"{np.mean(taut[half]):.2f}") if pulls else ("", "")
    cost = f"{record.iterations.mean():.0f}", record.unconverged, f"{record.seconds:.0f}"
    mean, dilation = record.deviator[late].mean() / 1e3, 100.0 * record.volume_change[late].mean()
    return [f"{mean:.1f}", f"{dilation:+.2f}", wire, *tension, f"{record.penetration.max() / sample.diameter:.1e}", *cost]


def main(seeds: int = 3, grains: int = 800) -> None:
    """All cases, one after the other."""
    rows = []
    for seed in range(seeds):
        for name, options in WIRES.items():
            study = Study3D(grain_count=grains, bead_count=grains * 35 // 65, seed=seed, **options)
            laid = study.lay_sample()
            relaxation = {**study.relaxation(laid), "friction": study.friction, **study.of_wire}
            sample = compact(laid, pressure=study.pressure, density=DENSITY, **relaxation).sample
            for law in ("none", "rigid-wire"):
                found = crushed(replace(study, laws=(law,)), sample, law)
                spacing = f"{max(lengths.max() for lengths in sample.link_lengths) / sample.diameter:.2f}"
                rows.append([law, name.strip(), spacing, seed, len(sample.radii), *found])
                print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    report("thread_nodes", HEADER, rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # light nodes move fast now and then
    main(*map(int, sys.argv[1:]))
