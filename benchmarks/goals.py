"""The frontier in four tables of goals: published problems, steps of TexSol samples, chains.

Published problems lie in ``fclib`` of the folder given, with ``index.csv``, which holds the best published times; steps of
TexSol samples and of settling spheres beside it. Times are of the solver alone, warm, the median of several where short.

    python benchmarks/goals.py FOLDER
"""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from scipy.linalg import eigh_tridiagonal
from table import report

import lmgcpy as lm
from lmgcpy.bench import load
from lmgcpy.bench.cases import chains
from lmgcpy.bench.frontier import timed, warm
from lmgcpy.solve.solve_to_measure import solve_to_measure

NO_FORCE = 1e-10
"""Problems with a smaller |q| hold nothing but round-off."""
MINUTE = 60.0


def to_fclib(problem: lm.Problem, solver, tolerance: float) -> tuple[str, float, float]:
    """(status, error, seconds) of a solver in the measure of published solvers."""
    solved = [solve_to_measure(problem, replace(solver, tolerance=tolerance), measure="fclib")]
    if solved[0].seconds < 0.2:
        solved += [solve_to_measure(problem, replace(solver, tolerance=tolerance), measure="fclib") for _ in range(4)]
    return solved[0].status, solved[0].error, median(each.seconds for each in solved)


def published(folder: Path) -> None:
    rows, missed, ratios = [], [], {"1e-06": [], "1e-08": []}
    with (folder / "index.csv").open() as file:
        index = list(csv.DictReader(file))
    for entry in index:
        problem = lm.io.fclib.read(folder / f"{entry['name']}.h5")
        if np.linalg.norm(problem.q) <= NO_FORCE:
            continue
        warm(problem)
        row = [entry["name"], len(problem.mu)]
        for target in ratios:
            status, error, seconds = to_fclib(problem, lm.Auto(), float(target))
            best = entry[f"best_seconds_scaled_{target}"]
            if status != "converged" or seconds > MINUTE:
                missed.append(f"{entry['name']} to {target}")
            elif best and len(problem.mu) >= 20:
                ratios[target].append(seconds / float(best))
            row += [f"{error:.1e}", f"{seconds:.2g}", best or "none"]
        rows.append(row)
    heads = [f"Auto to {target}: {what}" for target in ratios for what in ("error", "s", "best published s")]
    report("goals_published", ["problem", "contacts", *heads], rows)
    print(f"\n(a) not solved by Auto within a minute: {', '.join(missed) or 'none'}")
    for target, each in ratios.items():
        print(f"(b) to {target}: median of Auto's time over the best published {median(each):.2f}, {len(each)} problems")


def samples(folder: Path) -> None:
    rows = []
    for name in ("texsol2d-rigid-wire", "texsol2d-rigid-rod", "spheres3d-settling"):
        problem = lm.io.fclib.read(folder / f"{name}.h5")
        warm(problem)
        for label, solver in (
            ("Auto", lm.Auto(tolerance=1e-6, max_iterations=100_000, max_factorisations=400)),
            ("Newton", lm.Newton(tolerance=1e-6, max_iterations=100_000)),
            ("accelerated", lm.AcceleratedGaussSeidel(tolerance=1e-6, max_iterations=100_000)),
            ("Gauss-Seidel", lm.GaussSeidel(tolerance=1e-6, max_iterations=100_000)),
        ):
            solution, seconds, _ = timed(problem, solver)
            counts = [solution.iterations, solution.factorisations]
            rows.append([name, label, solution.status, f"{solution.residual:.1e}", *counts, f"{seconds:.2f}"])
    report("goals_samples", ["step", "solver", "status", "residual", "sweeps", "Newton steps", "s"], rows)


def hanging_chains() -> None:
    """Error of the impulses against extended precision, beside condition times round-off."""
    rows = []
    for case in chains():
        problem, exact = case.problem, case.exact
        warm(problem)
        solution, seconds, _ = timed(problem, lm.Auto(tolerance=1e-8))
        error = np.abs(solution.impulses - exact).max() / np.abs(exact).max()
        taut = exact[:, 0] != 0.0
        first = 2 * np.arange(len(taut))
        diagonal = np.where(taut, problem.W[first, first], problem.W[0, 0])
        beside = np.where(taut[:-1] & taut[1:], problem.W[first[:-1], first[1:]], 0.0)
        ends = [eigh_tridiagonal(diagonal, beside, eigvals_only=True, select="i", select_range=(k, k))[0] for k in
                (0, len(taut) - 1)]  # fmt: skip
        bound = 2.0**-52 * ends[1] / ends[0]
        per = 1e3 * seconds * 10_000 / case.interactions
        cells = [f"{error:.1e}", f"{bound:.1e}", solution.iterations, f"{1e3 * seconds:.3f}", f"{per:.1f}"]
        rows.append([case.name, solution.status, *cells])
    report("goals_chains", ["chain", "status", "error of r", "cond eps", "sweeps", "ms", "ms per 10 000 links"], rows)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("Give the folder of problems: python benchmarks/goals.py FOLDER")
    folder = Path(sys.argv[1])
    print(f"load of the machine: {load()}")
    hanging_chains()
    samples(folder)
    published(folder / "fclib")


if __name__ == "__main__":
    main()
