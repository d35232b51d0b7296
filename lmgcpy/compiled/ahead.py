"""A second process that compiles the solver's kernels with an empty cache, while this process compiles detection's.

To a user who waits for the first step they are one long chain of kernels; of two halves that do not need each other, each
takes a processor. The second process puts its kernels into the cache, as every process does, and this one waits for those
that are still on their way (:mod:`lmgcpy.compiled.waiting`). Without such waiting, or with one processor, there is no
second process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading

from lmgcpy.compiled.waiting import have_locks

COMPILE_FIRST = "LMGCPY_COMPILE_FIRST"
"""Variable of the environment that has all kernels compiled before they are used, see :mod:`lmgcpy.compiled.meanwhile`."""


class _Ahead:
    """The second process of this process."""

    def __init__(self) -> None:
        self._statement: str | None = None
        # whether none is to be started any more
        self.is_over = not (have_locks() and self.has_processors() and sys.executable) or getattr(sys, "frozen", False)

    @staticmethod
    def has_processors() -> bool:
        """Whether there is a processor for another process."""
        return _processors() > 1

    def would_need(self, statement: str) -> None:
        """Say by which statement of Python, in a new process, kernels are compiled that will be needed if any are."""
        self._statement = statement

    def begin(self) -> None:
        """Start the process, if there was none, as the first kernel is compiled."""
        if self.is_over or self._statement is None:
            return
        self.is_over = True
        alone = "from lmgcpy.compiled.ahead import ahead; ahead.is_over = True"
        program = f"import sys; sys.path[:] = {sys.path!r}; {alone}; {self._statement}"
        silent = subprocess.DEVNULL
        try:
            process = subprocess.Popen(
                [sys.executable, "-c", program],
                stdin=silent,
                stdout=silent,
                stderr=silent,
                env={**os.environ, COMPILE_FIRST: "1"},
            )
        except OSError:  # a system that starts no processes: then all is compiled here
            return
        threading.Thread(target=process.wait, daemon=True).start()  # takes note of its end


def _processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


ahead = _Ahead()
