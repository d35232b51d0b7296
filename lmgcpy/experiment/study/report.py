"""The parts of every report: the files in its folder, tables as CSV and as Markdown, and the versions used."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from lmgcpy.view import figures
from lmgcpy.writing import make_folder, markdown_table, write_table, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class ReportFolder:
    """A folder, which is made if it is missing, and the files that were written into it."""

    def __init__(self, path: Path):
        self.path = path
        self.written: list[Path] = []
        make_folder(path)

    def file(self, name: str) -> Path:
        """The path of a file that is written now."""
        self.written.append(self.path / name)
        return self.written[-1]

    def figure(self, name: str, drawn: Figure) -> None:
        """Write a figure."""
        figures.save(drawn, self.file(name))

    def table(self, name: str, parts: Iterable[Mapping[str, Iterable[Any]]]) -> None:
        """Write a table as CSV: columns by their headings, part after part; all parts have the headings of the first."""
        parts = list(parts)
        rows = (row for part in parts for row in zip(*part.values(), strict=True))
        write_table(self.file(name), list(parts[0]) if parts else [], rows)

    def text(self, name: str, text: str) -> None:
        """Write a text."""
        write_text(self.file(name), text)


def texts(values: Iterable[Any], form: str) -> list[str]:
    """The entries of a column, each in this format, such as ".6g"."""
    return [format(value, form) for value in values]


def markdown(rows: Sequence[Mapping[str, str]]) -> str:
    """A table in Markdown: entries by their headings, row after row; all rows have the headings of the first."""
    return "\n".join(markdown_table(rows[0], [row.values() for row in rows]))


def sections(title: str, parts: Iterable[str]) -> str:
    """A page in Markdown: its title, and the parts that are not empty."""
    return "\n\n".join([f"# {title}", *filter(None, parts)]) + "\n"


def versions() -> str:
    """Python, libraries and processor, for a report."""
    return (
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}, "
        f"{platform.system()} on {platform.machine()}"
    )
