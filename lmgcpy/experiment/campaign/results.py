"""The results of the cases of a campaign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

FINISHED, FAILED, TO_COME = "finished", "failed", "to come"
"""Statuses of a case."""


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

    def __repr__(self) -> str:
        counts = ", ".join(
            f"{sum(case.status == status for case in self.cases)} {status}" for status in (FINISHED, FAILED, TO_COME)
        )
        return f"<CampaignResults '{self.name}': {counts}>"
