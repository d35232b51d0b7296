"""The hard cases of tests/hard with every solver: numbers, residual, energy, seconds; failures are shown.

python benchmarks/hard_cases.py [--long]
"""

from __future__ import annotations

import sys
from pathlib import Path

from table import report

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "hard"))

from cases import CASES


def main(long: bool) -> None:
    rows = []
    for case in CASES:
        form = long and case.long
        for solver in case.solvers:
            result = case.run(solver, form)
            print(f"{case.name}, {solver}: {result}", file=sys.stderr)
            numbers = ", ".join(f"{number} (of {number.bound:.0e})" for number in result.numbers)
            rows.append(
                [
                    case.name,
                    case.others,
                    solver,
                    "holds" if result.holds else "**fails**",
                    numbers,
                    f"{case.tolerance:.0e}",
                    f"{result.residual:.0e}",
                    f"{result.energy:.0e}",
                    f"{result.seconds:.2f}",
                ]
            )
    header = [
        "case",
        "other codes",
        "solver",
        "",
        "numbers (and what they may be)",
        "tolerance",
        "residual",
        "energy made",
        "seconds",
    ]
    report("hard_cases_long" if long else "hard_cases", header, rows)


if __name__ == "__main__":
    main("--long" in sys.argv[1:])
