"""The display of the cases that run: on a terminal a bar for each and one for all, else a line at the end of each."""

from __future__ import annotations

import json
import sys
import time as clock
from typing import Any, TextIO

from lmgcpy.experiment.campaign.cases import FAILED, CampaignCase, CaseResult
from lmgcpy.experiment.campaign.folder import CampaignFolder

SHOWN = 16
"""Most cases that have a bar of their own."""


class ProgressView:
    """Shows how many cases are finished, have failed and are to come, the time to go, and those that run."""

    def __init__(
        self, folder: CampaignFolder, cases: list[CampaignCase], done: set[str], on: bool, stream: TextIO | None = None
    ):
        self._folder = folder
        self._stream = sys.stderr if stream is None else stream
        self._names = [case.name for case in cases if case.name not in done]
        self._total, self._before = len(cases), len(done)
        self._ended = self._failed = 0
        self._on = on
        self._terminal = on and self._stream.isatty()
        self._begin = clock.perf_counter()
        self._bar: Any = None
        self._bars: dict[str, Any] = {}

    def __enter__(self) -> ProgressView:
        if self._terminal:
            self._bar = self._new_bar(self._total, "campaign", "case", self._before)
        return self

    def __exit__(self, *_: object) -> None:
        for bar in [*self._bars.values(), *([self._bar] if self._bar is not None else [])]:
            bar.close()

    def ended(self, result: CaseResult) -> None:
        """A case has ended."""
        self._ended += 1
        self._failed += result.status == FAILED
        if self._on and not self._terminal:
            what = f"{result.status}, {result.seconds:.1f} s" + (f": {result.error}" if result.error else "")
            print(f"{self._before + self._ended} of {self._total}: {result.name}: {what}", file=self._stream, flush=True)

    def look(self) -> None:
        """Show what runs now."""
        if not self._terminal:
            return
        self._bar.n = self._before + self._ended
        self._bar.set_postfix_str(f"{self._failed} failed, {self._total - self._bar.n} to come", refresh=True)
        told = self._told()
        for name in [name for name in self._bars if name not in told]:
            self._bars.pop(name).close()
        for name, (stage, steps, total) in list(told.items())[:SHOWN]:
            if name not in self._bars:
                self._bars[name] = self._new_bar(total, name, "step", 0)
            bar = self._bars[name]
            bar.total, bar.n = total, steps
            bar.set_postfix_str(stage, refresh=True)

    def _told(self) -> dict[str, tuple[str, int, int]]:
        """Progress of the cases that run, as the workers report it: stage, steps done, steps in all."""
        told: dict[str, tuple[str, int, int]] = {}
        for file in sorted(self._folder.cases.glob("*.progress")):
            try:
                about = json.loads(file.read_text(encoding="utf-8"))
                told[file.stem] = str(about["stage"]), int(about["done"]), int(about["total"])
            except (OSError, ValueError, KeyError, TypeError):
                continue  # replaced or removed meanwhile
        return told

    def _new_bar(self, total: int, name: str, unit: str, begin: int) -> Any:
        from tqdm import tqdm

        return tqdm(total=total, initial=begin, desc=name, unit=unit, file=self._stream, leave=name == "campaign")
