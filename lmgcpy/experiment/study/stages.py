"""Progress of a long study: a bar for every stage on a terminal, otherwise one line for every finished stage."""

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
        from tqdm import tqdm

        begin = clock.perf_counter()
        with tqdm(total=total, desc=name, file=self.stream, disable=not self.terminal, unit="step") as bar:

            def tick(done: int) -> None:
                bar.update(done - bar.n)

            yield tick
        if not self.terminal and not self.quiet:
            print(f"{name}: {clock.perf_counter() - begin:.1f} s", file=self.stream, flush=True)
