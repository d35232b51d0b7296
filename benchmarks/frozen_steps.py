"""What `Auto` needs for the last digits: frozen steps of biaxial and triaxial tests, and of a TexSol study, to 1e-8.

The solver is as it comes but for its tolerance. Steps of the study are read from a folder of files, if one is given.

python benchmarks/frozen_steps.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

from table import report

import lmgcpy as lm
from lmgcpy.bench.cases import in_space, in_the_plane
from lmgcpy.bench.frontier import timed, warm

TOLERANCE = 1e-8


def main(folder: Path | None) -> None:
    steps = [(case.name, case.problem) for family in (in_the_plane(), in_space()) for case in family]
    if folder is not None:
        steps += [(path.stem, lm.io.fclib.read(path)) for path in sorted(folder.glob("texsol2d*.h5"))]
    rows = []
    for name, problem in steps:
        if name.startswith("box"):
            continue
        warm(problem)
        solution, seconds, _ = timed(problem, lm.Auto(tolerance=TOLERANCE))
        counts = solution.iterations, solution.factorisations
        rows.append([name, len(problem.mu), solution.status, f"{solution.residual:.0e}", *counts, f"{seconds:.2f}"])
    report("frozen_steps", ["step", "interactions", "status", "residual", "sweeps", "Newton steps", "s"], rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
