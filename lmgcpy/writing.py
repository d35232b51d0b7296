"""Writing of files: every file is written under another name in its folder, flushed to the disk, and then renamed.

So a reader finds the old file or the new one, both complete, even after a full disk, Ctrl-C, a kill or a power cut. A
write that fails leaves nothing behind and names the file. A replaced file keeps its permissions; a symbolic link leads to
the new file, and a hard link keeps the old content. A path that is no file, such as a device, is written directly.

A file that grows cannot be written so; a lock keeps its writers apart.
"""

from __future__ import annotations

import csv
import errno
import os
import stat
import sys
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import file_path, system_error

REMEDY = "Make room, or give another path."


def check_target(
    path: Any, *, force: bool, name: str = "path", instead: str = "give another name, or force=True to replace it"
) -> str:
    """The path of a file that may be written; it is checked before any work is done for it.

    Raises TypeError, ValueError, FileNotFoundError if its folder is missing, IsADirectoryError, PermissionError, and
    FileExistsError if the file exists, unless ``force``. ``instead`` ends that sentence: it says what to do.
    """
    path = file_path(path, name)
    folder = os.path.dirname(os.path.realpath(path))
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"There is no folder '{folder}' to write '{path}' into: make it first.")
    if os.path.isdir(path):
        raise IsADirectoryError(f"'{path}' is a folder: give the name of a file.")
    if os.path.exists(path):
        if not force:
            raise FileExistsError(f"The file '{path}' exists: {instead}.")
        if not os.access(path, os.W_OK):
            raise PermissionError(f"The file '{path}' is read-only: give another name or change its permissions.")
        if not os.path.isfile(path):
            return path
    if not os.access(folder, os.W_OK):
        raise PermissionError(f"The folder '{folder}' is read-only: '{path}' cannot be written there.")
    return path


@contextmanager
def new_file(path: str | os.PathLike) -> Iterator[Path]:
    """An empty file with the suffix of ``path``, to be written within the block; at its end it replaces ``path``.

    If the block raises, the old file stays. An OSError becomes a sentence that names the file, with the error number of its
    cause. The errors of :func:`check_target` are raised first.
    """
    check_target(path, force=True)
    try:
        with beside(path) as new:
            yield new
    except OSError as error:
        raise system_error(f"'{os.fspath(path)}' could not be written", error, REMEDY) from error


@contextmanager
def beside(path: str | os.PathLike, *, flushed: bool = True) -> Iterator[Path]:
    """The same as :func:`new_file`, but errors of the system pass unchanged.

    ``flushed=False`` is faster; a power cut may then lose the file.
    """
    target = Path(os.path.realpath(path))
    mode = _mode(target)
    if mode is not None and not stat.S_ISREG(mode):
        yield target
        return
    new = target.with_name(f".{uuid.uuid4().hex}{Path(path).suffix[:16]}")
    os.close(os.open(new, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    try:
        yield new
        if mode is not None:
            os.chmod(new, stat.S_IMODE(mode))
        replace_file(new, target, flushed=flushed)
    except BaseException:
        with suppress(OSError):
            os.remove(new)
        raise


def replace_file(new: str | os.PathLike, path: str | os.PathLike, *, flushed: bool = True) -> None:
    """Rename the complete file ``new`` to ``path``; raises OSError."""
    if flushed:
        flush(new)
    os.replace(new, path)
    if flushed and os.name == "posix":  # elsewhere folders cannot be opened
        with suppress(OSError):  # some file systems do not flush folders
            flush(os.path.dirname(os.path.abspath(path)))


def flush(path: str | os.PathLike) -> None:
    """Wait until a file or folder is on the disk; raises OSError."""
    handle = os.open(path, os.O_RDONLY if os.path.isdir(path) else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _mode(path: Path) -> int | None:
    try:
        return os.stat(path).st_mode
    except FileNotFoundError:
        return None


def write_bytes(path: str | os.PathLike, data: Any) -> None:
    """Write a file; raises the errors of :func:`new_file`."""
    with new_file(path) as new:
        new.write_bytes(data)


def write_text(path: str | os.PathLike, text: str) -> None:
    """Write a file in UTF-8; raises the errors of :func:`new_file`."""
    with new_file(path) as new:
        new.write_text(text, encoding="utf-8")


def write_table(path: str | os.PathLike, head: Iterable[Any], rows: Iterable[Iterable[Any]]) -> None:
    """Write a table as CSV; raises the errors of :func:`new_file`."""
    with new_file(path) as new, open(new, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def markdown_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """The lines of a table in Markdown."""
    head = list(head)
    first, *others = ("| " + " | ".join(entries) + " |" for entries in (head, *rows))
    return [first, "|---" * len(head) + "|", *others]


def make_folder(path: str | os.PathLike) -> Path:
    """A folder; it is made, with its parents, if it does not exist.

    Raises FileExistsError if a file has its name, and OSError with a sentence if it cannot be made.
    """
    folder = Path(file_path(path, "folder"))
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"'{path}' is a file: give the name of a folder.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise system_error(f"The folder '{path}' could not be made", error, "Give another path.") from error
    return folder


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


def dataframe(columns: Mapping[str, Any]) -> Any:
    """A pandas.DataFrame of columns by name; ImportError with a sentence if pandas is missing."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("to_dataframe needs pandas, which is not installed: pip install pandas.") from error
    return pandas.DataFrame(columns)


FEW = 9
"""Numbers of an array that a notebook shows; of a longer one it shows the shape."""


def html_table(title: str, head: Iterable[str], rows: Iterable[Iterable[Any]], note: str = "") -> str:
    """A table for a notebook, with a line above it, and a ``note`` below."""
    from html import escape  # slow to import

    names = "".join(f"<th>{escape(word)}</th>" for word in head)
    lines = "".join("<tr>" + "".join(f"<td>{escape(in_short(value))}</td>" for value in row) + "</tr>" for row in rows)
    header = f"<thead><tr>{names}</tr></thead>" if names else ""
    below = f"<div>{escape(note)}</div>" if note else ""
    return f"<div><b>{escape(title)}</b></div><table>{header}<tbody>{lines}</tbody></table>{below}"


def html_of_fields(thing: Any) -> str:
    """The fields of a dataclass as a table for a notebook."""
    values = ((field.name, getattr(thing, field.name)) for field in fields(thing))
    return html_table(type(thing).__name__, (), ((name, value) for name, value in values if value is not None))


def in_short(value: Any) -> str:
    """A value in a few characters: numbers to six digits, of a long array the shape."""
    if isinstance(value, Mapping):
        return "; ".join(f"{name}: {in_short(part)}" for name, part in value.items())
    if isinstance(value, (tuple, list)) and any(np.ndim(part) for part in value):
        return "; ".join(map(in_short, value))
    if isinstance(value, (np.ndarray, tuple, list)):
        array = np.asarray(value)
        if array.size > FEW:
            return f"array of shape {array.shape}"
        return np.array2string(array, precision=6) if array.dtype.kind in "fiub" else ", ".join(map(str, array.ravel()))
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)


def in_notebook() -> bool:
    """Whether the program runs in a notebook, which shows pictures, tables and a bar of progress."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")
