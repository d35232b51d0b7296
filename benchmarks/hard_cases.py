"""The hard cases of tests/hard with every solver: numbers, residual, energy, seconds; failures are shown.

python benchmarks/hard_cases.py [--long | --tables]

``--tables`` prints the two tables of docs/hard_cases.md once more, from results/hard_cases.csv.
"""

from __future__ import annotations

import csv
import re
import sys
from pathlib import Path

from table import RESULTS, report

from lmgcpy.writing import markdown_table

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
    name = "hard_cases_long" if long else "hard_cases"
    report(name, header, rows)
    print_tables(name)


def print_tables(name: str) -> None:
    """What a page shows: which solver holds, in seconds, and the numbers of ``Auto``, a row each."""
    with open(RESULTS / f"{name}.csv", newline="") as file:
        _, *rows = csv.reader(file)
    solvers = ("GaussSeidel", "Newton", "Auto")
    cases: dict[str, dict[str, list[str]]] = {}
    for case, _, solver, *cells in rows:
        cases.setdefault(case, {})[solver] = cells
    held, numbers = [], []
    for case, by_solver in cases.items():
        cells = [f"{by_solver[s][0]},\N{NO-BREAK SPACE}{by_solver[s][5]}" if s in by_solver else "–" for s in solvers]
        held.append([case, by_solver["Auto"][2], *cells])
        found = re.findall(r"(?:^|, )(.*?) (-?\d\S*) \(of (\S+)\)", by_solver["Auto"][1])
        for k, (what, value, bound) in enumerate(found):
            numbers.append(["" if k else case, what, value, bound])
    print("", *markdown_table(["case", "tolerance", *(f"{s} [s]" for s in solvers)], held), sep="\n")
    print("", *markdown_table(["case", "error of `Auto`", "found", "may be"], numbers), sep="\n")


if __name__ == "__main__":
    if "--tables" in sys.argv[1:]:
        print_tables("hard_cases")
    else:
        main("--long" in sys.argv[1:])
