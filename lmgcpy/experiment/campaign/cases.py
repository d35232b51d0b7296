"""The cases of a campaign, their names, and their results."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import mean
from typing import Any

import numpy as np

from lmgcpy.experiment.study.engine import Study

FINISHED, FAILED, TO_COME = "finished", "failed", "to come"
"""Statuses of a case."""
LONGEST = 150
"""Most bytes of the name of a case, which also names its folder: file systems count bytes, and allow 255."""
Parameter = float | str | bool | None | tuple


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
