"""Turns of processes that need the same kernel at once: one of them compiles it, and the others wait for its file.

A process that compiles a kernel locks a byte of a file beside the kernels; the name of the kernel's file says which byte.
The system unlocks it when the process ends, in any way, and no copy of a process inherits it. The lock file is never
removed: otherwise processes that use the old file and later ones would not see each other's locks. Without locks every
process compiles by itself.

A process has at most one turn, and ends it before it waits for another: so no two can wait for each other, even if the
compilation of one kernel calls another. numba's lock is held when these functions are called: one thread of a process.

Who waits for the compiler at a terminal gets a line that goes away. Elsewhere, as in a notebook or a log, it is one line
for each program.
"""

from __future__ import annotations

import errno
import os
import sys
import threading
import time as clock
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

PATIENCE = 1.0
"""Time of compiling after which the user sees a message [s]."""


ONCE = "lmgcpy compiles kernels, which takes some seconds and happens once: they are kept for the next time."
"""The line of a program without a terminal."""


class _Waiting:
    """Number of kernels that this process has compiled so far, and the time this took [s]."""

    def __init__(self) -> None:
        self.count = 0
        self.seconds = 0.0
        self.is_said = False


_so_far = _Waiting()


@contextmanager
def told_to_wait() -> Iterator[None]:
    """While one kernel is compiled: a line on standard error says so as soon as this process has compiled for more than a
    second. On a terminal it goes away with the kernel; elsewhere there is one, of the first process of a program."""
    from multiprocessing import parent_process  # slow to import

    begin, terminal = clock.perf_counter(), sys.stderr is not None and sys.stderr.isatty()
    once = not terminal and sys.stderr is not None and not _so_far.is_said and parent_process() is None
    _so_far.count += 1
    line = f"compiling kernels (once): {_so_far.count}, {_so_far.seconds:.0f} s so far"
    shown = threading.Event()

    def show() -> None:
        if once:
            _so_far.is_said = True
            print(ONCE, file=sys.stderr, flush=True)
            return
        shown.set()
        print(line, end="\r", file=sys.stderr, flush=True)

    timer = threading.Timer(max(0.0, PATIENCE - _so_far.seconds), show)
    timer.daemon = True
    if terminal or once:
        timer.start()
    try:
        yield
    finally:
        if terminal or once:
            timer.cancel()
            timer.join()
        if shown.is_set():
            print(" " * len(line), end="\r", file=sys.stderr, flush=True)
        _so_far.seconds += clock.perf_counter() - begin


LONGEST = 120.0
"""Who has waited so long for a kernel compiles it, and waits for no other any more: on this file system, locks may not work
as they should [s]."""
PAUSE = 0.01
"""Between two looks at a lock [s]."""


class Turn:
    """The turn of this process."""

    def __init__(self) -> None:
        self._handle: int | None = None
        """The lock file, open as long as the turn lasts: to close it unlocks the byte."""
        self._is_patient = True

    def take(self, kernel: Path, worth_waiting: Callable[[], bool]) -> None:
        """Take the turn for a kernel's file, or wait for the process that has it, and then take none.

        After waiting the file exists, or the kernel cannot be kept or compiled: then nobody should wait again.
        ``worth_waiting`` is called if another process has the turn: whether the compiled code will be kept.
        """
        self.end()  # a turn that an interruption has left, or the turn of a kernel whose compilation calls this one
        taken = False
        try:
            self._handle = _open_lock_file(kernel)
            if self._handle is not None:
                byte = zlib.crc32(kernel.name.encode()) >> 1  # 31 bits, which every system has
                taken = _lock(self._handle, byte)
                if not taken and self._is_patient and worth_waiting():
                    self._is_patient = _wait(self._handle, byte)
        except OSError:
            pass  # no directory, not ours to write, no locks on this file system
        finally:
            if not taken:
                self.end()

    def end(self) -> None:
        """End the turn, if there is one."""
        if self._handle is not None:
            handle, self._handle = self._handle, None
            os.close(handle)


turn = Turn()


def have_locks() -> bool:
    """Whether the system has locks of bytes."""
    try:
        import fcntl  # noqa: F401
    except ImportError:
        return False
    return True


def _open_lock_file(kernel: Path) -> int | None:
    """The lock file of a directory of kernels, beside it; None on systems without locks of bytes."""
    if not have_locks():
        return None
    folder = kernel.parent
    folder.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    return os.open(folder.with_name(f"{folder.name}.lock"), os.O_RDWR | os.O_CREAT, 0o666)


def _lock(handle: int, byte: int) -> bool:
    """Lock a byte unless another process has locked it; raises OSError if the system has no locks."""
    import fcntl

    try:
        fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, byte)
    except OSError as error:
        if error.errno in (errno.EAGAIN, errno.EACCES):
            return False
        raise
    return True


def _wait(handle: int, byte: int) -> bool:
    """Wait until a byte is free, and whether it was in time."""
    end = clock.monotonic() + LONGEST
    with told_to_wait():
        while not _lock(handle, byte):
            if clock.monotonic() > end:
                return False
            _pause()
    return True


def _pause() -> None:
    clock.sleep(PAUSE)
