"""Where the time of a step goes: detection and bookkeeping against the solver, in the default biaxial test.

python benchmarks/step_budget.py
"""

from __future__ import annotations

import numpy as np
from table import report

from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample
from lmgcpy.experiment.texsol.study import DENSITY, LAWS, Study2D
from lmgcpy.simulation import Simulation

STEPS = 60


def measure(law: str, study: Study2D, sample) -> list:
    made = LAWS[law](study.axial_rigidity)
    biaxial = Biaxial(sample, made, pressure=study.pressure, density=DENSITY, solver=study.solver_of_tests())
    sim = biaxial.simulation = Simulation(biaxial.box.scene, time_step=biaxial.time_step, solver=biaxial.solver)
    sim.run(steps=5)
    reports = [sim.step() for _ in range(STEPS)]
    solve = np.array([r.seconds for r in reports])
    rest = np.array([r.step_seconds for r in reports]) - solve
    return [
        law,
        reports[-1].interactions,
        f"{np.mean([r.iterations for r in reports]):.0f}",
        f"{np.mean([r.residual for r in reports]):.1e}",
        f"{1e3 * np.median(solve):.1f}",
        f"{1e3 * np.median(rest):.2f}",
        f"{100 * rest.sum() / (rest.sum() + solve.sum()):.1f} %",
    ]


if __name__ == "__main__":
    study = Study2D()
    sample = compact(lay_sample(study.grain_count, study.bead_count), pressure=study.pressure, density=DENSITY).sample
    header = ["law", "interactions", "iterations", "residual", "solver [ms]", "the rest [ms]", "its part (goal 20 %)"]
    report("step_budget", header, [measure(law, study, sample) for law in study.laws])
