"""The folder of a column study: ``study.json`` says what is computed, ``runs`` holds a run file for each of its runs."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, fields
from pathlib import Path

from lmgcpy.experiment.column_study import ColumnStudy
from lmgcpy.io.recorder import versions
from lmgcpy.io.run_format import is_being_written

FORMAT = "lmgcpy column study"


class ColumnFolder:
    """Where a column study is kept; nothing is made before :meth:`begin`."""

    def __init__(self, path: str | os.PathLike):
        self.path = Path(path)
        self.study_file = self.path / "study.json"

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

    def begin(self, study: ColumnStudy) -> None:
        """Make the folder and write the study; the runs of a former study are taken away.

        Raises BlockingIOError where one of these is under way.
        """
        former = list((self.path / "runs").glob("*.h5*")) if self.study_file.exists() else []
        for file in former:
            if is_being_written(file):
                raise BlockingIOError(f"The study in '{self.path}' is under way: wait for its end, or give another folder.")
        for file in [*former, self.summary]:
            file.unlink(missing_ok=True)
        (self.path / "runs").mkdir(parents=True, exist_ok=True)
        about = {"format": FORMAT, "study": asdict(study), "versions": versions()}
        beside = self.study_file.with_suffix(".new")
        beside.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
        os.replace(beside, self.study_file)

    def read(self) -> ColumnStudy:
        """The study that the folder holds.

        Raises FileNotFoundError where there is none; ValueError where its file is damaged or of another version.
        """
        if not self.study_file.exists():
            raise FileNotFoundError(
                f"There is no study to go on with in '{self.path}': '{self.study_file}' is missing. Begin one by "
                f"lmgcpy column --out {self.path}."
            )
        anew = "Put it back as it was, or begin the study anew by --force without --resume."
        try:
            about = json.loads(self.study_file.read_text(encoding="utf-8"))
            form, given, made_with = about["format"], dict(about["study"]), about["versions"]["lmgcpy"]
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"'{self.study_file}' is damaged ({error}). {anew}") from error
        if form != FORMAT:
            raise ValueError(f"'{self.study_file}' is of another kind of study, '{form}': give another folder by --out.")
        known = {field.name for field in fields(ColumnStudy)}
        if known != given.keys():
            raise ValueError(
                f"'{self.study_file}' is of lmgcpy {made_with}, whose studies have other fields than those of this version "
                f"(they differ in {', '.join(sorted(known ^ given.keys()))}). Go on with that version, or begin the study "
                "anew by --force without --resume."
            )
        try:
            return ColumnStudy(**given)
        except (TypeError, ValueError) as error:
            raise ValueError(f"'{self.study_file}' is damaged: {error} {anew}") from error
