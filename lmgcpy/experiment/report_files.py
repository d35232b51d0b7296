"""The files of a report: figures, tables, text, in one folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from lmgcpy.view import figures
from lmgcpy.writing import make_folder, write_table, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class ReportFolder:
    """A folder, made if need be, and what was written into it."""

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

    def table(self, name: str, header: Iterable[str], rows: Iterable[Iterable]) -> None:
        """Write a table as CSV."""
        write_table(self.file(name), header, rows)

    def text(self, name: str, text: str) -> None:
        """Write a text."""
        write_text(self.file(name), text)
