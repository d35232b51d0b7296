"""Steps of small scenes as plain Python, while another process compiles their kernels.

With an empty cache the kernels of a step take the compiler ten to thirty seconds. Ten grains take plain Python some
milliseconds a step, with the same bits. So a step that lacks a kernel is made as plain Python, and a copy of the process
makes the same step as well, which compiles the kernels and puts them into the cache. Once the copy has ended, steps load
them from there. A later step that lacks another kernel, as when first contacts come, begins anew.

The copy is a fork: it has the scene with all its laws. It closes all files at once, since this process has locked its run
files, and makes only the step. It goes on if this process ends before it. A fork needs a process of one thread, and a
second processor is needed for it to help. Otherwise kernels are compiled first: in a notebook, on other systems than Linux,
for scenes of more than :data:`MOST` bodies, and if :data:`COMPILE_FIRST` is set in the environment.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time as clock
import warnings
from collections.abc import Callable
from typing import TypeVar

from lmgcpy.compiled.ahead import COMPILE_FIRST, ahead
from lmgcpy.compiled.cache import CacheWarning
from lmgcpy.compiled.mode import INTERPRETED, NotCompiled, mode
from lmgcpy.compiled.waiting import told_to_wait

MOST = 40
"""Most bodies of a scene whose steps may be made as plain Python: 12 grains take 6 to 30 ms a step."""
LONG = 1.0
"""A step of plain Python that took longer [s] is the last one until the kernels are there."""
COPIES = 6
"""Most copies of a process: kernels that are still lacking after these are compiled here."""
LOOK = 0.05
"""Interval at which the end of the copy is looked for by a process that waits for it [s]."""

Result = TypeVar("Result")


class _Meanwhile:
    """The copy of this process that compiles, and the work until then."""

    def __init__(self) -> None:
        self._copy = 0
        """Number of the process that compiles; 0 if there is none."""
        helps = sys.platform == "linux" and ahead.has_processors() and not INTERPRETED
        self._left = COPIES if helps and not os.environ.get(COMPILE_FIRST) else 0
        """How many more may follow."""

    def stop(self) -> None:
        """Compile from now on what is lacking, before it is used."""
        self._left = 0

    def do(self, work: Callable[[], Result], copied: bool) -> Result:
        """``work()``, as plain Python if it lacks a kernel. It is called again if it raised :class:`NotCompiled`, and must
        then find everything as before. ``copied``: whether a copy of the process is to compile what it lacks; otherwise
        nothing is compiled."""
        waits = self._copy and not self._has_ended()
        # all threads share the mode of the kernels, and a fork has one of them
        if not (waits or self._left) or threading.active_count() > 1:
            return work()
        if waits:
            return self._plainly(work)
        mode.loads_only = True
        try:
            return work()
        except NotCompiled:
            pass
        finally:
            mode.loads_only = False
        if copied and not self._copied(work):
            return work()
        return self._plainly(work)

    def _plainly(self, work: Callable[[], Result]) -> Result:
        begin = clock.perf_counter()
        with mode.as_plain_python():
            result = work()
        if clock.perf_counter() > begin + LONG:
            self.wait()
        return result

    def wait(self) -> None:
        """Wait for the copy, if there is one."""
        if self._copy:
            with told_to_wait():
                while not self._has_ended():
                    clock.sleep(LOOK)

    def _has_ended(self) -> bool:
        """Whether the copy has ended. If it failed there is no other: the error that it met will be met here as well."""
        try:
            number, status = os.waitpid(self._copy, os.WNOHANG)
        except ChildProcessError:  # somebody else has waited for it
            number, status = self._copy, 0
        if not number:
            return False
        self._copy = 0
        if status:
            self.stop()
        return True

    def _copied(self, work: Callable[[], object]) -> bool:
        """Start a copy of this process that does the work with compiled kernels; returns whether there is one."""
        self._left -= 1
        reading, writing = os.pipe()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # of threads of libraries, which rest
                self._copy = os.fork()
        except OSError:  # a system that starts no processes
            os.close(reading)
            os.close(writing)
            self.stop()
            return False
        if self._copy:
            os.close(writing)
            os.read(reading, 1)  # returns once the copy has closed its files
            os.close(reading)
            return True
        try:  # this is the copy
            nowhere = os.open(os.devnull, os.O_RDWR)
            for stream in range(3):
                os.dup2(nowhere, stream)
            os.closerange(3, os.sysconf("SC_OPEN_MAX"))
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is compiled serves the next run
            self.stop()
            warnings.simplefilter("error", CacheWarning)  # what cannot be kept serves nobody
            work()
            os._exit(0)
        finally:
            os._exit(1)


meanwhile = _Meanwhile()
