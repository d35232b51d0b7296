"""The one way to write a file: beside its place, flushed to the disk, then put in its place.

So whoever looks finds the old file or the new one, both whole, whatever happens meanwhile: a full disk, Ctrl-C, a kill, a
power cut. What fails leaves nothing behind and names the file. A file that is replaced keeps its permissions, and a
symbolic link goes on leading to it; a hard link keeps the old content. What is no file, such as a device, is written in
place.
"""

from __future__ import annotations

import csv
import os
import stat
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lmgcpy.errors import place, system_error

REMEDY = "Make room, or give another place."


def check_target(
    path: Any, *, force: bool, name: str = "path", instead: str = "give another name, or force=True to replace it"
) -> str:
    """The path of a file that may be written, or a sentence before any work is done for it.

    Raises TypeError, ValueError, FileNotFoundError where its folder is not there, IsADirectoryError, PermissionError, and
    FileExistsError where there is one already, unless ``force``; ``instead``: what to do then.
    """
    path = place(path, name)
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
    """An empty file to write to within the block, of the same suffix, that takes the place of ``path`` at its end.

    Where the block raises, what was there stays. An OSError becomes a sentence that names the file, with the number of its
    cause; those of :func:`check_target` are raised before.
    """
    check_target(path, force=True)
    try:
        with beside(path) as new:
            yield new
    except OSError as error:
        raise system_error(f"'{os.fspath(path)}' could not be written", error, REMEDY) from error


@contextmanager
def beside(path: str | os.PathLike, *, flushed: bool = True) -> Iterator[Path]:
    """As :func:`new_file`, with the errors of the system as they are; ``flushed=False``: faster, for what may be lost in a
    power cut."""
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
        put_in_place(new, target, flushed=flushed)
    except BaseException:
        with suppress(OSError):
            os.remove(new)
        raise


def put_in_place(new: str | os.PathLike, path: str | os.PathLike, *, flushed: bool = True) -> None:
    """Give a file that is whole its name; raises OSError."""
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
    """Write a file; raises as :func:`new_file`."""
    with new_file(path) as new:
        new.write_bytes(data)


def write_text(path: str | os.PathLike, text: str) -> None:
    """Write a file in UTF-8; raises as :func:`new_file`."""
    with new_file(path) as new:
        new.write_text(text, encoding="utf-8")


def write_table(path: str | os.PathLike, head: Iterable[Any], rows: Iterable[Iterable[Any]]) -> None:
    """Write a table as CSV; raises as :func:`new_file`."""
    with new_file(path) as new, open(new, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def make_folder(path: str | os.PathLike) -> Path:
    """A folder, made with those above it if it is not there.

    Raises FileExistsError where a file has its name, OSError with a sentence where it cannot be made.
    """
    folder = Path(place(path, "folder"))
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"'{path}' is a file: give the name of a folder.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise system_error(f"The folder '{path}' could not be made", error, "Give another place.") from error
    return folder
