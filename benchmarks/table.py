"""A benchmark's table: printed, with machine and versions, and written as CSV."""

from __future__ import annotations

import csv
import platform
from pathlib import Path

import numba
import numpy as np
import scipy

import lmgcpy

RESULTS = Path(__file__).parent / "results"


def machine() -> str:
    """Processor, system and versions in one line."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        lines = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        model = lines[0].split(":")[1].strip() + f", {len(lines)} cores" if lines else model
    return (
        f"{model}; {platform.system()}; Python {platform.python_version()}, numpy {np.__version__}, "
        f"scipy {scipy.__version__}, numba {numba.__version__}, lmgcpy {lmgcpy.__version__}"
    )


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
