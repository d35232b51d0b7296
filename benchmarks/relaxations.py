"""How exactly a relaxation has to be solved: residual against error of force, for beads and threads: docs/texsol_3d.md.

Samples of the TexSol study in 3D are relaxed with and without friction. "Straight" is the distance of the ends over the
length of wire, over ten beads or their length of thread.

    python benchmarks/relaxations.py [GRAINS [SEEDS]]
"""

from __future__ import annotations

import sys
import tempfile
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.experiment import Sample, Study3D, compact

BOUNDS = ({"tolerance": 1e-3, "force": 1.0}, *({"tolerance": 1e-2, "force": f} for f in (5e-3, 1e-2, 2e-2)))
HEADER = ["wire", "relaxed", "seed", "residual", "force", "steps", "sweeps a step", "unsolved", "solid fraction"]
HEADER += ["coordination", "rattlers", "deepest overlap [d]", "straight", "processor s"]


def straight(sample: Sample, links: int) -> float:
    """Mean distance of nodes so many links apart, over the length of the links."""
    nodes = sample.positions[: sample.wires[0]]
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(length)])
    return float(np.mean(np.linalg.norm(nodes[links:] - nodes[:-links], axis=1) / (along[links:] - along[:-links])))


def rows(study: Study3D) -> list[list]:
    """The rows of one sample."""
    laid = study.lay_sample()
    options = study.compaction(laid)
    found = []
    for bound in BOUNDS:
        begin = time.process_time()
        solver = replace(options["solver"], **bound)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "run.h5"
            options |= {"solver": solver, "file": file}
            compacted = compact(laid, **options)
            with lm.io.open_run(file) as run:
                sweeps = run.history[:]["iterations"]
        seconds = time.process_time() - begin
        row = [study.wire, study.preparation, study.seed, f"{bound['tolerance']:g}"]
        row += ["" if bound["force"] == 1.0 else f"{bound['force']:g}", compacted.steps, f"{sweeps.mean():.0f}"]
        row += [compacted.unconverged, f"{compacted.solid_fraction:.4f}", f"{compacted.coordination:.2f}"]
        row += [f"{compacted.rattlers:.3f}", f"{compacted.penetration / laid.diameter:.1e}"]
        found.append([*row, f"{straight(compacted.sample, 10 if study.wire == 'beads' else 3):.3f}", f"{seconds:.0f}"])
        print(*found[-1], sep=" | ", file=sys.stderr, flush=True)
    return found


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # beads that are squeezed out move fast at first
    grains = int(sys.argv[1]) if len(sys.argv) > 1 else 800
    seeds = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    told = []
    for wire in ("beads", "thread"):
        for preparation in ("loose", "dense"):
            for seed in range(seeds):
                sizes = {"grain_count": grains, "bead_count": grains * 35 // 65}
                study = Study3D(**sizes, seed=seed, wire=wire, preparation=preparation)
                told += rows(study)
    report("relaxations", HEADER, told)
