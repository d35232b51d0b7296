"""A benchmark's table: printed, with machine and versions, and written as CSV. What is timed is compiled first."""

from __future__ import annotations

from pathlib import Path

from lmgcpy.bench import machine
from lmgcpy.compiled.meanwhile import meanwhile
from lmgcpy.writing import markdown_table, write_table

RESULTS = Path(__file__).parent / "results"

meanwhile.stop()


def report(name: str, header: list[str], rows: list[list]) -> None:
    """Print the table as Markdown and write ``results/<name>.csv``."""
    print(f"\n{name}: {machine()}\n")
    print(*markdown_table(header, [[str(cell) for cell in row] for row in rows]), sep="\n")
    RESULTS.mkdir(exist_ok=True)
    write_table(RESULTS / f"{name}.csv", [*header, "machine"], [[*row, machine()] for row in rows])
