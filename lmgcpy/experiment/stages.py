"""How far a long study is: a bar per stage on a terminal, one line per finished stage otherwise."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO


class Tick(Protocol):
    """Tells a stage how many of its steps are done."""

    def __call__(self, done: int) -> None: ...


class Stages:
    """Stages of a study, told on ``stream``; ``quiet`` says nothing."""

    def __init__(self, stream: TextIO | None = None, *, quiet: bool = False):
        self.stream = sys.stderr if stream is None else stream
        self.quiet = quiet
        self.terminal = self.stream.isatty() and not quiet

    @contextmanager
    def stage(self, name: str, total: int) -> Iterator[Tick]:
        """A stage of ``total`` steps at the most; several may be under way at once."""
        from tqdm import tqdm

        begin = clock.perf_counter()
        with tqdm(total=total, desc=name, file=self.stream, disable=not self.terminal, unit="step") as bar:

            def tick(done: int) -> None:
                bar.update(done - bar.n)

            yield tick
        if not self.terminal and not self.quiet:
            print(f"{name}: {clock.perf_counter() - begin:.1f} s", file=self.stream, flush=True)
