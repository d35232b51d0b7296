"""Whether `Auto` is the best choice: its time to a true error over that of the fastest solver of the family.

Steps of settling and compressed samples in 2D and 3D, without and with wires, each from the impulses of the step before
("warm") and from none ("cold"). Errors are those of `lmgcpy bench`, by two references: docs/frontier.md.

python benchmarks/auto_choice.py [PART-OF-A-NAME [SEED]]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.bench.cases import Case, in_space, in_the_plane
from lmgcpy.bench.frontier import Judged, judge
from lmgcpy.solve.solvers import SOLVERS

TARGETS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""True errors of the velocities to reach."""
FEW, MANY = 1.3, 3.0
"""Times the fastest solver's time, within which the choice is as good as the best, and beyond which it is a bad one."""


def settling(seed: int, grains: int = 600) -> Iterator[Case]:
    """Steps of disks that settle in a box: the second one, in the middle, and near rest."""
    radii = lm.sample.grading(grains, minimum=0.005, maximum=0.01, by="diameter", seed=seed)
    scene = lm.Scene(dimension=2, gravity=(0.5, -9.81))
    sand = lm.Material("sand", density=2600.0)
    for radius, place in zip(radii, lm.sample.deposit(radii, box=(0.25, None), seed=seed), strict=True):
        scene.add(lm.disk(radius=radius, position=place, material=sand))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.25, 0), (-1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.4))
    sweeps = lm.AcceleratedGaussSeidel(tolerance=1e-3, max_iterations=3000)
    sim = lm.Simulation(scene, time_step=5e-4, solver=sweeps, on_unconverged="ignore", overlap="ignore")
    for steps in (2, 60, 200):
        sim.run(steps=steps - sim.steps)
        yield Case(f"settling-{steps}", "settling 2D", sim.problem())


def cases(seed: int) -> Iterator[Case]:
    """Every step, warm and cold."""
    for family in (settling(seed), in_the_plane(seed=seed), in_space(seed=seed)):
        for case in family:
            yield replace(case, name=f"{case.name}, warm")
            nothing = np.zeros_like(case.problem.guess)
            yield replace(case, name=f"{case.name}, cold", problem=replace(case.problem, guess=nothing))


def ratios(judged: Judged) -> list[float]:
    """Time of `Auto` over that of the fastest solver, for each target that the references can tell and a solver reaches;
    infinite if `Auto` does not."""
    found = []
    for target in TARGETS:
        if judged.reference.floor > target:
            continue
        best = {run.solver: run.seconds for run in (judged.best(name, target) for name in SOLVERS) if run}
        if best:
            found.append(best.get("auto", np.inf) / min(best.values()))
    return found


def main(part: str, seed: int) -> None:
    by_family: dict[str, list[float]] = {}
    rows, sample = [], f"_{seed}" if seed else ""
    for case in cases(seed):
        judged = judge(case) if part in case.name else None
        if judged is None:
            continue
        mine = ratios(judged)
        by_family.setdefault(case.family, []).extend(mine)
        rows.append([case.name, case.interactions, f"{judged.reference.distance:.0e}", *(f"{ratio:.2f}" for ratio in mine)])
        rows[-1] += [""] * (3 + len(TARGETS) - len(rows[-1]))
        print(*rows[-1], sep=", ", flush=True)
    head = ["step", "interactions", "references", *(f"to {target:g}" for target in TARGETS)]
    report(f"auto_choice_steps{sample}", head, rows)
    rows = []
    by_family["all"] = [ratio for found in by_family.values() for ratio in found]
    for family, found in by_family.items():
        share = [f"{100.0 * np.mean(np.array(found) <= most):.0f} %" for most in (FEW, MANY)]
        rows.append([family, len(found), *share, f"{np.median(found):.2f}", int(np.isinf(found).sum())])
    head = ["family", "errors judged", f"within {FEW:g} times", f"within {MANY:g} times", "median", "not reached"]
    report(f"auto_choice{sample}", head, rows)


if __name__ == "__main__":
    given = sys.argv[1:]
    main(given[0] if given else "", int(given[1]) if len(given) > 1 else 0)
