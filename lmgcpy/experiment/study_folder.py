"""The folder of a study: ``study.json`` says what is computed, ``runs`` holds a run file for each of its runs."""

from __future__ import annotations

import json
import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from lmgcpy.io.recorder import versions
from lmgcpy.io.run_format import is_being_written
from lmgcpy.io.untrusted import regular_file
from lmgcpy.writing import flush, make_folder, new_file

Study = TypeVar("Study")


class Folder(ABC, Generic[Study]):
    """Where a study is kept; nothing is made before :meth:`begin`."""

    COMMAND: ClassVar[str]
    """Of ``lmgcpy``, which makes such studies."""

    def __init__(self, path: str | os.PathLike):
        self.path = Path(path)
        self.study_file = self.path / "study.json"

    @property
    def _format(self) -> str:
        return f"lmgcpy {self.COMMAND} study"

    def run_file(self, name: str) -> Path:
        """The run file of that name."""
        return self.path / "runs" / f"{name}.h5"

    @property
    def summary(self) -> Path:
        """Written last, when the study is complete."""
        return self.path / "summary.md"

    @property
    def interrupted(self) -> bool:
        """Whether it holds a study that is not complete."""
        return self.study_file.exists() and not self.summary.exists()

    def begin(self, study: Study) -> None:
        """Make the folder and write the study; the runs of a former study are taken away.

        Raises BlockingIOError where one of these is under way, OSError where the study cannot be written; the former one is
        then as it was.
        """
        former = list((self.path / "runs").glob("*.h5*")) if self.study_file.exists() else []
        for file in former:
            if is_being_written(file):
                raise BlockingIOError(f"The study in '{self.path}' is under way: wait for its end, or give another folder.")
        make_folder(self.path / "runs")
        given: Any = study
        about = {"format": self._format, **self.told_beside(study), "study": asdict(given), "versions": versions()}
        with new_file(self.study_file) as new:
            new.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
            flush(new)  # from here on there is room for it: the former study may go
            for file in [*former, self.summary]:
                file.unlink(missing_ok=True)

    def read(self) -> Study:
        """The study that the folder holds.

        Raises FileNotFoundError where there is none; ValueError where its file is damaged, a pipe, or of another version.
        """
        if not self.study_file.exists():
            raise FileNotFoundError(
                f"There is no study to go on with in '{self.path}': '{self.study_file}' is missing. Begin one by "
                f"lmgcpy {self.COMMAND} --out {self.path}."
            )
        anew = "Put it back as it was, or begin the study anew by --force without --resume."
        file = Path(regular_file(self.study_file, "the file of a study"))
        try:
            about = json.loads(file.read_text(encoding="utf-8"))
            form, given, made_with = about["format"], dict(about["study"]), about["versions"]["lmgcpy"]
            kind: Any = self.kind_of(about) if form == self._format else None
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"'{self.study_file}' is damaged ({error}). {anew}") from error
        if kind is None:
            raise ValueError(f"'{self.study_file}' is of another kind of study, '{form}': give another folder by --out.")
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

    def told_beside(self, study: Study) -> dict[str, Any]:
        """What the file says beside the fields of the study."""
        return {}

    @abstractmethod
    def kind_of(self, about: dict[str, Any]) -> Callable[..., Study]:
        """The class of the study that the file tells of; KeyError where there is none."""
