"""How far dry columns run out, by their height over their radius: docs/column.md.

Columns of lmgcpy's study of columns, without wire, settled in their mould and released on a rough ground. The run-out is
``(R_f - R)/R`` by the radius R_f that holds 95 % and 99 % of the sand and by the front of the ground that is covered
without a break. Round columns of sand run out by ``1.24 a`` up to an aspect a of 1.7, and by ``1.6 a^(1/2)`` beyond (Lube,
Huppert, Sparks, Hallworth 2004, J. Fluid Mech. 508, 175-199). Exponents are slopes of straight lines through the
logarithms of the means.

    python benchmarks/column_run_out.py [SEEDS [GRAINS [WORKERS]]]
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context

import numpy as np
from table import report

from lmgcpy.experiment.column.course import LEAST, POUR, RELEASE, SandColumn, dry_run_out, let_go, time_unit
from lmgcpy.experiment.column.sample import lay_column
from lmgcpy.experiment.column.study import GROUND_MARGIN

ASPECTS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0)
BREAK = 1.7
"""Aspect at which the published law changes."""
SEEDS, GRAINS, WORKERS = 2, 1000, 2


def fallen(case: tuple[float, int, int]) -> list[float]:
    """Run-outs by 95 %, 99 % and the front, height at the end over R, width in grains, whether at rest, part unsolved."""
    aspect, seed, grains = case
    laid = lay_column(grain_count=grains, aspect=aspect, seed=seed)
    unit, radius = time_unit(laid), laid.mould.radius
    reach = GROUND_MARGIN * (1.0 + dry_run_out(aspect)) * radius
    common = {"friction": 0.5, "reach": reach, "seed": seed}
    pour = let_go(SandColumn(laid, mould=True, **common), duration=POUR * unit, travel=1.0)
    free = SandColumn(laid, mould=False, state=pour.end, **common)
    release = let_go(free, duration=RELEASE * unit, least=LEAST * unit, travel=1.0)
    run_out = release.spread[-1] / radius - 1.0
    height = float(release.height[-1, 0]) / radius
    unsolved = release.unconverged / len(release.time)
    return [*run_out, height, laid.mould.side / laid.diameter, float(release.at_rest), unsolved]


def main() -> None:
    """Print the table and the exponents."""
    seeds, grains, workers = [*map(int, sys.argv[1:]), *(SEEDS, GRAINS, WORKERS)[len(sys.argv) - 1 :]]
    cases = list(product(ASPECTS[::-1], range(seeds), [grains]))
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        found = dict(zip(cases, pool.map(fallen, cases), strict=True))
    rows, means = [], []
    for aspect in ASPECTS:
        of_aspect = np.array([found[aspect, seed, grains] for seed in range(seeds)])
        mean, spread = of_aspect.mean(axis=0), of_aspect.std(axis=0, ddof=1) if seeds > 1 else np.zeros(7)
        means.append(mean)
        told = [f"{m:.2f} ± {s:.2f}" for m, s in zip(mean[:4], spread[:4], strict=True)]
        rest = f"{of_aspect[:, 5].sum():.0f} of {seeds}"
        rows.append([aspect, f"{mean[4]:.1f}", *told, f"{dry_run_out(aspect):.2f}", rest, f"{100.0 * mean[6]:.0f}"])
    header = ["aspect", "grains wide", "run-out of 95 %", "of 99 %", "of the front", "height at the end / R", "published"]
    report("column_run_out", [*header, "came to rest", "unsolved steps [%]"], rows)
    run_outs, aspects, exponents = np.array(means)[:, :3], np.array(ASPECTS), []
    for name, part in (("up to 1.7", aspects < BREAK), ("beyond", aspects > BREAK)):
        slopes = [np.polyfit(np.log(aspects[part]), np.log(run_outs[part, k]), 1)[0] for k in range(3)]
        exponents.append([name, *(f"{slope:.2f}" for slope in slopes), 1.0 if name == "up to 1.7" else 0.5])
    report("column_exponents", ["aspect", "exponent of 95 %", "of 99 %", "of the front", "published"], exponents)


if __name__ == "__main__":
    main()
