"""Sweeps that a residual costs, with and without momentum: frozen steps of the biaxial test and of a relaxation.

Each step is taken out of a run, as a problem of its own with the impulses it started from, and solved anew to three
tolerances. Sweeps are counted; "-" where 12 000 do not do. The steps are those of this run on this machine: counts move
by some tens of percent from one step to the next.

    python benchmarks/momentum.py
"""

from __future__ import annotations

from table import report

import lmgcpy as lm
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import Box
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.texsol.sample import lay_sample
from lmgcpy.experiment.texsol.study import DENSITY

PRESSURE, MOST = 1e5, 12_000
TOLERANCES = (1e-1, 1e-2, 1e-3)
SOLVERS = {"Gauss-Seidel": lm.GaussSeidel, "with momentum": lm.AcceleratedGaussSeidel}


def count(name: str, problem: lm.Problem) -> list:
    row = [name, len(problem.mu)]
    for solver in SOLVERS.values():
        sweeps = []
        for tolerance in TOLERANCES:
            solution = lm.solve(problem, solver=solver(tolerance=tolerance, max_iterations=MOST))
            sweeps.append(str(solution.iterations) if solution.status == "converged" else "-")
            if solution.status != "converged":
                break
        row.append(" / ".join(sweeps + ["-"] * (len(TOLERANCES) - len(sweeps))))
    return row


def main() -> None:
    laid = lay_sample(1700, 300, seed=0)
    sample = compact(laid, pressure=PRESSURE, density=DENSITY).sample
    rows = []
    for law in (None, lm.RigidWire(), lm.RigidRod()):
        for strain in (0.01, 0.03):
            solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=3000)
            biaxial = Biaxial(sample, law, pressure=PRESSURE, density=DENSITY, solver=solver)
            biaxial.run(strain, frames=0)
            name = "sand" if law is None else law.NAME
            rows.append(count(f"{name}, {100 * strain:g} %", biaxial.simulation.problem()))
    box = Box(laid, density=DENSITY, friction=0.0, law=lm.RigidWire())
    box.load_laterally(PRESSURE)
    box.load_top(PRESSURE)
    sim = lm.Simulation(
        box.scene, time_step=5e-4, solver=lm.AcceleratedGaussSeidel(tolerance=1e-2), on_unconverged="ignore"
    )
    rows.append(count("relaxation, no friction", sim.run(steps=100).problem()))
    report("momentum", ["step", "interactions", *(f"{name}: to 1e-1 / 1e-2 / 1e-3" for name in SOLVERS)], rows)


if __name__ == "__main__":
    main()
