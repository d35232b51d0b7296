"""The cases of a campaign, their names and results, and the folder that keeps them.

    campaign.json     what is computed
    cases.jsonl       a line for every case that ended, in the order in which they did, each with its sum
    curves/NAME.npz   the curves of a case
    cases/NAME/       the run files of a case, of a study with its study.json
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from statistics import mean
from typing import Any

import numpy as np

from lmgcpy.experiment.study.engine import Study
from lmgcpy.experiment.study.folder import KeptFolder
from lmgcpy.writing import FileLock, make_folder, write_bytes

FINISHED, FAILED, TO_COME = "finished", "failed", "to come"
"""Statuses of a case."""
LONGEST = 150
"""Most bytes of the name of a case, which also names its folder: file systems count bytes, and allow 255."""
Parameter = float | str | bool | None | tuple

FORMAT = "lmgcpy campaign 1"


@dataclass(frozen=True)
class CampaignCase:
    """One of the computations of a campaign."""

    name: str
    """Its parameters in words, which name its folder."""
    parameters: dict[str, Parameter]
    """The parameters by which it differs from the others."""
    work: Any
    """The study to be carried out, or the function to be called."""
    arguments: dict[str, Parameter]
    """All arguments of the function; empty for a study."""


def case_name(parameters: Mapping[str, Any]) -> str:
    """The parameters of a case in words that can name a folder: "bead_count=200,axes=z,seed=0"."""
    words = ",".join(f"{name}={in_words(value)}" for name, value in parameters.items()) or "case"
    name = re.sub(r"[^\w=,.+-]", "_", words)
    if len(name.encode()) > LONGEST:
        raise ValueError(f"The name of a case would have more than {LONGEST} bytes: '{name[:60]}...'. Vary less.")
    return name


def in_words(value: Any) -> str:
    """A parameter in words, with all its digits; the values of a tuple are joined by "+"."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, (tuple, list)):
        return "+".join(map(in_words, value))
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return str(value)


def is_text(word: str) -> bool:
    """Whether a file can hold it: not so of lone surrogates."""
    try:
        word.encode()
    except UnicodeEncodeError:
        return False
    return True


@dataclass(frozen=True, repr=False)
class CaseResult:
    """The result of a case."""

    name: str
    """Its parameters in words: "bead_count=200,axes=z,seed=0"."""
    parameters: dict[str, Any]
    """What was varied."""
    status: str
    """"finished", "failed" or "to come"."""
    seconds: float
    """Time of the clock [s], 0 for a case to come."""
    error: str
    """A sentence, empty if there was no error."""
    numbers: dict[str, float]
    """Results by name, with the unit in brackets at the end: "peak deviator [Pa]"."""
    curves: dict[str, dict[str, np.ndarray]]
    """By test ("" if there is only one): columns of one length, the first of them the abscissa."""
    versions: dict[str, str]
    """Versions of lmgcpy and of what the numbers depend on, from the worker that did the case."""

    def __repr__(self) -> str:
        how = f"{self.status} in {self.seconds:.3g} s" if self.seconds else self.status
        return f"<CaseResult '{self.name}': {how}{f', {self.error}' if self.error else ''}>"


@dataclass(frozen=True, repr=False)
class CampaignResults:
    """All cases of a campaign, in their order."""

    name: str
    """That of the folder."""
    cases: list[CaseResult]
    """In the order of the campaign."""
    left_out: int = 0
    """Lines of ``cases.jsonl`` that do not count: damaged, without their curves, or of cases that the campaign has not."""

    @property
    def finished(self) -> list[CaseResult]:
        """The finished cases."""
        return [case for case in self.cases if case.status == FINISHED]

    def expected_seconds(self, case: CampaignCase) -> tuple[float | None, str]:
        """Time of a case on one processor [s], None if nothing is known, and the source of that.

        It is the mean of the finished cases that differ from it in the fewest parameters, or else what the study expects.
        """
        if self.finished:
            differing = [sum(one.parameters.get(k) != v for k, v in case.parameters.items()) for one in self.finished]
            nearest = [one.seconds for one, n in zip(self.finished, differing, strict=True) if n == min(differing)]
            return mean(nearest), f"{len(nearest)} finished alike"
        seconds = case.work.expected_seconds() if isinstance(case.work, Study) else None
        return seconds, "unknown" if seconds is None else "table"

    def __repr__(self) -> str:
        counts = ", ".join(
            f"{sum(case.status == status for case in self.cases)} {status}" for status in (FINISHED, FAILED, TO_COME)
        )
        return f"<CampaignResults '{self.name}': {counts}>"


class CampaignFolder(KeptFolder):
    """The folder in which a campaign is kept."""

    def __init__(self, path: str | os.PathLike):
        super().__init__(path, "campaign")
        self.ledger = self.path / "cases.jsonl"
        self.curves = self.path / "curves"
        self.cases = self.path / "cases"
        self.lock_file = self.path / ".lock"

    def __repr__(self) -> str:
        return f"<CampaignFolder '{self.path}'>"

    def check(self, described: Mapping[str, Any], *, resume: bool, force: bool) -> None:
        """See that the folder may be used for a campaign that is ``described`` so; writes nothing.

        If it is to be resumed, the folder must hold this campaign, or the same with fewer cases.

        Raises FileExistsError if it is not empty and neither ``resume`` nor ``force`` is given, FileNotFoundError if there
        is nothing to resume, and ValueError if it holds another campaign.
        """
        if resume:
            there, here = self.described(), json.loads(json.dumps(described))
            missing = [case for case in there["cases"] if case not in here["cases"]]
            if missing or {**there, "cases": here["cases"]} != here:
                raise ValueError(
                    f"The folder '{self.path}' holds another campaign{_difference(there, here)}: resume that one as "
                    "it was or with more cases, or give another folder."
                )
            return
        if self.path.exists() and any(there != self.lock_file for there in self.path.iterdir()):
            known = self.description_file.exists()
            if not force:
                held = "holds a campaign: go on with resume" if known else "is not empty: give another"
                raise FileExistsError(f"The folder '{self.path}' {held}, or force to write there.")

    def begin(self, described: Mapping[str, Any]) -> None:
        """Write the description of a campaign in place of the description of a former one, whose files are removed; the
        folder is held."""
        with suppress(ValueError, FileNotFoundError):  # of a damaged description no case is known: its files stay
            for name in (case_name(parameters) for parameters in self.described()["cases"]):
                shutil.rmtree(self.cases / name, ignore_errors=True)
                for file in (self.curves / f"{name}.npz", self.cases / f"{name}.progress"):
                    file.unlink(missing_ok=True)
        self.ledger.unlink(missing_ok=True)
        make_folder(self.cases)
        self.describe({"format": FORMAT, **described})

    def enlarge(self, described: Mapping[str, Any]) -> None:
        """Take in the cases that a campaign has now and had not when the folder was written."""
        if len(described["cases"]) > len(self.described()["cases"]):
            self.describe({"format": FORMAT, **described})

    def described(self) -> dict[str, Any]:
        """The description of the campaign that the folder holds; FileNotFoundError or ValueError if there is none."""
        if not self.description_file.exists():
            raise FileNotFoundError(f"There is no campaign in '{self.path}': '{self.description_file}' is missing.")
        try:
            about = self.description()
            if about["format"] != FORMAT:
                raise ValueError(f"its format is {about['format']!r}")
            found = {name: about[name] for name in ("work", "study", "fixed", "cases")}
            if not all(isinstance(mapping, dict) for mapping in (found["study"], found["fixed"], *found["cases"])):
                raise ValueError("parameters are not given by name")
            return found
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise ValueError(f"'{self.description_file}' is damaged or of another version ({error}).") from error

    @contextmanager
    def held(self) -> Iterator[None]:
        """Keep another campaign out of the folder meanwhile (BlockingIOError). The lock is a file that nobody replaces."""
        make_folder(self.path)
        try:
            self.lock_file.touch()
            lock = FileLock(self.lock_file)
        except BlockingIOError as error:
            raise BlockingIOError(
                f"The campaign in '{self.path}' is under way: wait for its end, or give another folder."
            ) from error
        try:
            yield
        finally:
            lock.release()

    def enter(self, result: CaseResult) -> None:
        """Write what became of a case. Its curves come first: a line of the ledger counts only with them."""
        of_curves = ""
        if result.curves:
            make_folder(self.curves)
            flat = {f"{test}|{column}": values for test, curve in result.curves.items() for column, values in curve.items()}
            packed = io.BytesIO()
            np.savez_compressed(packed, **flat)  # type: ignore[arg-type]
            write_bytes(self.curves / f"{result.name}.npz", packed.getvalue())
            of_curves = _sum(packed.getvalue())
        line = {name: getattr(result, name) for name in ("name", "parameters", "status", "seconds", "error", "numbers")}
        text = json.dumps({**line, "versions": result.versions, "curves": of_curves})
        text = f"{text} {_sum(text.encode())}"
        with self.ledger.open("a+b") as file:
            if file.tell() and (file.seek(-1, os.SEEK_END), file.read(1))[1] != b"\n":
                file.write(b"\n")  # after a line that a kill has cut short
            file.write(text.encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())

    def results(self, cases: list[CampaignCase] | None = None) -> CampaignResults:
        """The results of all cases so far: of these cases, or of the cases that the description names."""
        if cases is None:
            listed = [{name: _tupled(v) for name, v in case.items()} for case in self.described()["cases"]]
            wanted = {case_name(parameters): parameters for parameters in listed}
        else:
            wanted = {case.name: case.parameters for case in cases}
        found, left_out = self._entered(wanted)
        to_come = {name: CaseResult(name, dict(p), TO_COME, 0.0, "", {}, {}, {}) for name, p in wanted.items()}
        return CampaignResults(self.path.name, list({**to_come, **found}.values()), left_out)

    def _entered(self, wanted: Mapping[str, Mapping[str, Any]]) -> tuple[dict[str, CaseResult], int]:
        """The last entry of each case, and the number of lines that do not count. A line that was cut short or damaged does
        not, nor one without its curves: the case is done again."""
        found: dict[str, CaseResult] = {}
        left_out = 0
        if not self.ledger.exists():
            return found, left_out
        for line in self.ledger.read_bytes().splitlines():
            text, _, told = line.decode("utf-8", "replace").rpartition(" ")
            about = _entry(text) if told == _sum(text.encode()) else None
            if about is None or about["name"] not in wanted:
                left_out += 1
                continue
            name = about.pop("name")
            try:
                curves = self._read_curves(name, about.pop("curves"))
            except (OSError, ValueError):
                found.pop(name, None)
                left_out += 1
                continue
            found[name] = CaseResult(name=name, **{**about, "parameters": dict(wanted[name]), "curves": curves})
        return found, left_out

    def _read_curves(self, name: str, of_curves: str) -> dict[str, dict[str, np.ndarray]]:
        """The curves of a case, whose file has this sum, "" for none; OSError or ValueError if the file has changed."""
        curves: dict[str, dict[str, np.ndarray]] = {}
        if not of_curves:
            return curves
        content = (self.curves / f"{name}.npz").read_bytes()
        if _sum(content) != of_curves:
            raise ValueError(f"The curves of '{name}' are damaged.")
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            for key in file.files:
                test, _, column = key.partition("|")
                curves.setdefault(test, {})[column] = file[key]
        return curves


def _sum(content: bytes) -> str:
    """By which damage to a line of the ledger or to curves is seen."""
    return hashlib.sha256(content).hexdigest()[:16]


def _entry(text: str) -> dict[str, Any] | None:
    """A line of the ledger, or None if it is not the result of a case, whatever its sum."""
    try:
        about = json.loads(text)
    except (ValueError, RecursionError):
        return None
    number = (int, float)
    kinds: dict[str, Any] = {"name": str, "parameters": dict, "status": str, "seconds": number, "error": str}
    kinds |= {"numbers": dict, "versions": dict, "curves": str}
    sound = (
        isinstance(about, dict)
        and about.keys() == kinds.keys()
        and all(isinstance(about[name], kind) for name, kind in kinds.items())
        and about["status"] in (FINISHED, FAILED)
        and all(type(value) in (int, float) for value in (about["seconds"], *about["numbers"].values()))
        and all(isinstance(value, str) for value in about["versions"].values())
    )
    return about if sound else None


def _tupled(value: Any) -> Any:
    return tuple(_tupled(item) for item in value) if isinstance(value, list) else value


def _difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str:
    """The differences of two descriptions, in a clause."""
    differs = next((name for name in ("work", "study", "fixed", "cases") if there[name] != here[name]), "")
    if differs == "work":
        return f", of {there['work']} and not of {here['work']}"
    if differs in ("study", "fixed"):
        names = sorted(n for n in {*there[differs], *here[differs]} if there[differs].get(n) != here[differs].get(n))
        return f", with another {' and '.join(names[:3])}" if names else ""
    return ", with cases that are not among these"
