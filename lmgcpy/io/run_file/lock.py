"""The lock of a run file, which keeps two writers apart."""

from __future__ import annotations

import errno
import os


class FileLock:
    """A lock that tells other writers that a file is being written. The system releases it when the process ends.

    Readers are not locked out.
    """

    def __init__(self, path: str | os.PathLike, name: str | os.PathLike | None = None):
        self._handle: int | None = None
        try:
            import fcntl
        except ImportError:
            return  # this system has no such locks
        self._handle = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            fcntl.flock(self._handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError as error:
            self.release()
            busy = BlockingIOError(
                f"The file '{name or path}' is being written by another run: wait for its end, or give another file."
            )
            busy.errno = errno.EAGAIN
            raise busy from error

    def release(self) -> None:
        """Release the lock, so that others can write."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def is_being_written(path: str | os.PathLike) -> bool:
    """Whether a running process is writing the file."""
    try:
        FileLock(path).release()
    except BlockingIOError:
        return True
    except OSError:
        return False  # nobody writes a read-only file
    return False
