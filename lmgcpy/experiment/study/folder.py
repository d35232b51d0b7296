"""The folder of a study: ``study.json`` describes the study, ``runs`` holds the run file of each of its runs.

``runs/.names`` lists the runs that have begun: what else is there is none of the study's, and stays.

Beside them is the report of the study: files, tables as CSV and as Markdown, and the versions used.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from lmgcpy.errors import regular_file, system_error
from lmgcpy.version import versions
from lmgcpy.view import figures
from lmgcpy.writing import REMEDY, flush, is_being_written, make_folder, markdown_table, new_file, write_table, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class RunNames:
    """The names of the runs that have begun in a folder, a line each; threads and processes may enter names at once."""

    def __init__(self, runs: Path):
        self.file = runs / ".names"

    def __repr__(self) -> str:
        return f"<RunNames in '{self.file}'>"

    def listed(self) -> set[str]:
        """The names; none that leads out of the folder, whatever is in the file."""
        if not self.file.is_file():
            return set()
        lines = self.file.read_text(encoding="utf-8", errors="replace").splitlines()
        return {name for name in lines if name and "\0" not in name and Path(name).name == name}

    def enter(self, name: str, file: Path) -> None:
        """Note that a run begins in this file, or goes on; FileExistsError if there is one that is not the study's."""
        if name in self.listed():
            return
        if file.exists():
            raise FileExistsError(f"'{file}' is no file of this study: move it, or give the study another folder.")
        self._write([name])

    def take_up(self, files: Iterable[Path]) -> None:
        """Take these files for the study's, unless there are names: versions before 0.2 wrote none."""
        if not self.file.exists():
            self._write([file.stem for file in files])

    def _write(self, names: Iterable[str]) -> None:
        make_folder(self.file.parent)
        try:
            with self.file.open("a", encoding="utf-8") as file:  # what is appended at once is in one piece
                file.write("".join(f"\n{name}\n" for name in names))  # after a line that a power cut has left
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise system_error(f"'{self.file}' could not be written", error, REMEDY) from error


class KeptFolder:
    """A folder in which a computation is kept. A file describes what is computed, before anything else is there."""

    def __init__(self, path: str | os.PathLike, computation: str):
        """``computation``: the word for it, "study" or "campaign", by which the file is named."""
        self.path = Path(path)
        self.description_file = self.path / f"{computation}.json"
        self._what = f"the file of a {computation}"

    def describe(self, about: Mapping[str, Any], then: Callable[[], None] = lambda: None) -> None:
        """Write what is computed, and the versions, in place of a former description.

        ``then`` is called as soon as there is room for it: what the former computation left may go.
        """
        with new_file(self.description_file) as new:
            new.write_text(json.dumps({**about, "versions": versions()}, indent=2) + "\n", encoding="utf-8")
            flush(new)
            then()

    def description(self) -> Any:
        """What is in the file; ValueError or RecursionError if it is no JSON."""
        return json.loads(Path(regular_file(self.description_file, self._what)).read_text(encoding="utf-8"))


class StudyFolder(KeptFolder):
    """The folder in which a study is kept; it is not made before :meth:`begin`.

    ``kind``: the class of the study, or one above those that the folder may hold, a subclass of
    :class:`lmgcpy.experiment.study.engine.Study`.
    """

    def __init__(self, path: str | os.PathLike, kind: Any):
        super().__init__(path, "study")
        self.kind = kind
        self.study_file = self.description_file
        self.runs = self.path / "runs"
        self.run_names = RunNames(self.runs)
        self._format = f"lmgcpy {kind.COMMAND} study"

    def __repr__(self) -> str:
        return f"<StudyFolder '{self.path}' of {self.kind.__name__}>"

    def run_file(self, name: str) -> Path:
        """The run file of that name."""
        return self.runs / f"{name}.h5"

    @property
    def summary(self) -> Path:
        """The summary, which is written last, when the study is complete."""
        return self.path / "summary.md"

    @property
    def interrupted(self) -> bool:
        """Whether it holds a study that is not complete."""
        return self.study_file.exists() and not self.summary.exists()

    def begin(self, study: Any) -> None:
        """Make the folder and write the study; the runs of a former study are deleted, and nothing else.

        Raises BlockingIOError if one of these is under way, OSError if the study cannot be written; the former study is
        unchanged then.
        """
        former = [self.run_file(name) for name in sorted(self.run_names.listed())]
        for file in filter(Path.exists, former):
            if is_being_written(file):
                raise BlockingIOError(f"The study in '{self.path}' is under way: wait for its end, or give another folder.")
        make_folder(self.runs)
        copies = [file.with_name(f"{file.name}.mending") for file in former]  # which a kill has left

        def forget() -> None:
            for file in [*former, *copies, self.run_names.file, self.summary]:
                file.unlink(missing_ok=True)

        self.describe({"format": self._format, **study.kind(), "study": asdict(study)}, forget)

    def read(self) -> Any:
        """The study that the folder holds.

        Raises FileNotFoundError if there is none; ValueError if its file is damaged, a pipe, or of another version.
        """
        if not self.study_file.exists():
            raise FileNotFoundError(
                f"There is no study to go on with in '{self.path}': '{self.study_file}' is missing. Begin one by "
                f"lmgcpy {self.kind.COMMAND} --out {self.path}."
            )
        anew = "Put it back as it was, or begin the study anew by --force without --resume."
        try:
            about = self.description()
            form, given, made_with = about["format"], dict(about["study"]), about["versions"]["lmgcpy"]
            kind: Any = self.kind.class_of(about) if form == self._format else None
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"'{self.study_file}' is damaged ({error}). {anew}") from error
        if kind is None:
            raise ValueError(f"'{self.study_file}' is of another kind of study, '{form}': give another folder by --out.")
        given = {**kind.FORMER, **given}
        known = {field.name for field in fields(kind)}
        if known != given.keys():
            raise ValueError(
                f"'{self.study_file}' is of lmgcpy {made_with}, whose studies have other fields than those of this version "
                f"(they differ in {', '.join(sorted(known ^ given.keys()))}). Go on with that version, or begin the study "
                "anew by --force without --resume."
            )
        try:
            return kind(**{name: tuple(value) if isinstance(value, list) else value for name, value in given.items()})
        except (TypeError, ValueError) as error:
            raise ValueError(f"'{self.study_file}' is damaged: {error} {anew}") from error


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


def made_with() -> str:
    """Python, libraries and processor, for a report."""
    return (
        f"Python {platform.python_version()}, numpy {np.__version__}, numba {numba.__version__}, "
        f"{platform.system()} on {platform.machine()}"
    )
