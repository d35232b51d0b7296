"""A line on the terminal for who waits for the compiler."""

from __future__ import annotations

import sys
import threading
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 1.0
"""Time of compiling after which the user sees a message [s]."""


class _Waiting:
    """Number of kernels that this process has compiled so far, and the time this took [s]."""

    def __init__(self) -> None:
        self.count = 0
        self.seconds = 0.0


_so_far = _Waiting()


@contextmanager
def told_on_a_terminal() -> Iterator[None]:
    """While one kernel is compiled: where standard error is a terminal, a line says so as soon as this process has compiled
    for more than a second, and goes away with the kernel."""
    begin, terminal = clock.perf_counter(), sys.stderr is not None and sys.stderr.isatty()
    _so_far.count += 1
    line = f"compiling kernels (once): {_so_far.count}, {_so_far.seconds:.0f} s so far"
    shown = threading.Event()

    def show() -> None:
        shown.set()
        print(line, end="\r", file=sys.stderr, flush=True)

    timer = threading.Timer(max(0.0, PATIENCE - _so_far.seconds), show)
    timer.daemon = True
    if terminal:
        timer.start()
    try:
        yield
    finally:
        if terminal:
            timer.cancel()
            timer.join()
        if shown.is_set():
            print(" " * len(line), end="\r", file=sys.stderr, flush=True)
        _so_far.seconds += clock.perf_counter() - begin
