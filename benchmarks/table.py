"""A benchmark's table: printed, with machine and versions, and written as CSV."""

from __future__ import annotations

import csv
from pathlib import Path

from lmgcpy.bench.machine import machine

RESULTS = Path(__file__).parent / "results"


def report(name: str, header: list[str], rows: list[list]) -> None:
    """Print the table as Markdown and write ``results/<name>.csv``."""
    print(f"\n{name}: {machine()}\n")
    print("| " + " | ".join(header) + " |")
    print("|---" * len(header) + "|")
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |")
    RESULTS.mkdir(exist_ok=True)
    with (RESULTS / f"{name}.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*header, "machine"])
        writer.writerows([*row, machine()] for row in rows)
