"""How often the solvers solve a step of a dense sample of rough spheres: many samples of each size, failures shown.

With friction, how long the way to a solution is hangs on chance, and one sample tells little. Every sample is a deposit of
its own, pressed as that of tests/hard is; its 41st step is solved to 1e-8 from the impulses of the 40th.

python benchmarks/compactions.py [SAMPLES]
"""

from __future__ import annotations

import sys
from pathlib import Path
from statistics import median

from table import report

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "hard"))

from case import SOLVERS
from compaction import pressed

SPHERES = (100, 150, 200, 300)
FRICTION = 0.3
TOLERANCE = 1e-8


def main(samples: int) -> None:
    rows = []
    for spheres in SPHERES:
        reports = {name: [] for name in SOLVERS}
        for seed in range(samples):
            sim = pressed(spheres, FRICTION, 40, seed)
            start = sim.checkpoint()
            for name, solver in SOLVERS.items():
                sim.restore(start)
                sim.solver = solver(tolerance=TOLERANCE)
                sim.run(steps=1)
                reports[name].append(sim.report)
                print(f"{spheres} spheres, seed {seed}, {name}: {sim.report}", file=sys.stderr)
        for name, told in reports.items():
            solved = sum(report.status == "converged" for report in told)
            rows.append(
                [
                    spheres,
                    round(median(report.interactions for report in told)),
                    name,
                    f"{solved} of {samples}",
                    f"{max(report.residual for report in told):.0e}",
                    round(median(report.iterations for report in told)),
                    round(median(report.factorisations for report in told)),
                    f"{median(report.seconds for report in told):.2f}",
                ]
            )
    header = ["spheres", "interactions", "solver", "solved", "worst residual", "sweeps", "Newton steps", "seconds"]
    report("compactions", header, rows)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 16)
