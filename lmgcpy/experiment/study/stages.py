"""Progress of long studies: a bar for every stage on a terminal, otherwise one line for every finished one.

Cases of a campaign, in other processes, tell their stages by files, and the campaign shows these as bars.
"""

from __future__ import annotations

import json
import os
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol, TextIO

TOLD_EVERY = 0.5
"""Shortest time between two words on the progress of a case [s]."""
SHOWN = 16
"""Most cases that have a bar of their own."""


class Tick(Protocol):
    """Tells a stage how many of its steps are done."""

    def __call__(self, done: int) -> None: ...


class Stages:
    """Shows the stages of a study on ``stream``; if ``quiet``, nothing is shown.

    In another process, a pickled copy writes the lines to that process' standard error and there are no bars.
    """

    def __init__(self, stream: TextIO | None = None, *, quiet: bool = False):
        self.stream = sys.stderr if stream is None else stream
        self.quiet = quiet
        self.terminal = self.stream.isatty() and not quiet

    def __repr__(self) -> str:
        return f"<Stages: {'quiet' if self.quiet else 'bars' if self.terminal else 'lines'}>"

    def __getstate__(self) -> bool:
        return self.quiet

    def __setstate__(self, quiet: bool) -> None:
        self.stream, self.quiet, self.terminal = sys.stderr, quiet, False

    @contextmanager
    def stage(self, name: str, total: int) -> Iterator[Tick]:
        """A stage of at most ``total`` steps; several stages may be under way at once."""
        begin = clock.perf_counter()
        with new_bar(total, name, self.stream, disable=not self.terminal) as bar:

            def tick(done: int) -> None:
                bar.update(done - bar.n)

            yield tick
        if not self.terminal and not self.quiet:
            print(f"{name}: {clock.perf_counter() - begin:.1f} s", file=self.stream, flush=True)


class ToldStages(Stages):
    """Stages of a case of a campaign, which reads them in a file: {"stage": ..., "done": ..., "total": ...}."""

    def __init__(self, file: Path | None):
        super().__init__(quiet=True)
        self._file = file
        self._last = 0.0

    @contextmanager
    def stage(self, name: str, total: int) -> Iterator[Tick]:
        """A stage of at most ``total`` steps."""

        def tick(done: int) -> None:
            now = clock.monotonic()
            if self._file is not None and (now > self._last + TOLD_EVERY or done == 0):
                self._last = now
                with suppress(OSError):  # nobody's result depends on it
                    new = self._file.with_suffix(f".{os.getpid()}")
                    new.write_text(json.dumps({"stage": name, "done": done, "total": total}), encoding="utf-8")
                    new.replace(self._file)

        tick(0)
        yield tick

    def end(self) -> None:
        """Remove the file."""
        if self._file is not None:
            with suppress(OSError):
                self._file.unlink(missing_ok=True)


class CaseStages(Stages):
    """Shows how many cases of a campaign have ended and failed, the time to go, and the stages of those that run.

    ``told``: the folder in which :class:`ToldStages` write their files.
    """

    def __init__(self, told: Path, total: int, done: int, stream: TextIO | None = None, *, quiet: bool = False):
        """``done``: number of cases of the ``total`` that had ended before."""
        super().__init__(stream, quiet=quiet)
        self._folder, self._total, self._ended, self._failed = told, total, done, 0
        self._bar: Any = None
        self._bars: dict[str, Any] = {}

    def __enter__(self) -> CaseStages:
        if self.terminal:
            self._bar = new_bar(self._total, "campaign", self.stream, unit="case", initial=self._ended)
        return self

    def __exit__(self, *_: object) -> None:
        for bar in [*self._bars.values(), *([self._bar] if self._bar is not None else [])]:
            bar.close()

    def ended(self, name: str, words: str, failed: bool) -> None:
        """A case has ended; ``words`` say how."""
        self._ended += 1
        self._failed += failed
        if not self.terminal and not self.quiet:
            print(f"{self._ended} of {self._total}: {name}: {words}", file=self.stream, flush=True)

    def look(self) -> None:
        """Show what runs now."""
        if not self.terminal:
            return
        self._bar.n = self._ended
        self._bar.set_postfix_str(f"{self._failed} failed, {self._total - self._ended} to come", refresh=True)
        told = self._told()
        for name in [name for name in self._bars if name not in told]:
            self._bars.pop(name).close()
        for name, (stage, steps, total) in list(told.items())[:SHOWN]:
            if name not in self._bars:
                self._bars[name] = new_bar(total, name, self.stream, leave=False)
            bar = self._bars[name]
            bar.total, bar.n = total, steps
            bar.set_postfix_str(stage, refresh=True)

    def _told(self) -> dict[str, tuple[str, int, int]]:
        """Progress of the cases that run: stage, steps done, steps in all."""
        told: dict[str, tuple[str, int, int]] = {}
        for file in sorted(self._folder.glob("*.progress")):
            try:
                about = json.loads(file.read_text(encoding="utf-8"))
                told[file.stem] = str(about["stage"]), int(about["done"]), int(about["total"])
            except (OSError, ValueError, KeyError, TypeError):
                continue  # replaced or removed meanwhile
        return told


def new_bar(total: int, name: str, stream: TextIO, *, unit: str = "step", **options: Any) -> Any:
    """A bar on a terminal."""
    from tqdm import tqdm

    return tqdm(total=total, desc=name, file=stream, unit=unit, **options)
