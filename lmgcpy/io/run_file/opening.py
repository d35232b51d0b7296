"""Opening a run file: to read, even one that is being written or was left by a kill, and to append to it."""

from __future__ import annotations

import os
from contextlib import contextmanager
from typing import Any

import numpy as np

from lmgcpy.errors import shown
from lmgcpy.io.hdf5 import cut_off, data_sets, h5py
from lmgcpy.io.run_file.checked_rows import sentences_of_damage
from lmgcpy.io.run_file.trees import check_structure
from lmgcpy.io.run_file.unclosed_file import UnclosedFile, is_unclosed
from lmgcpy.io.untrusted import regular_file

FORMAT = "lmgcpy run"
VERSION = 1


def open_to_read(path: str | os.PathLike) -> Any:
    """The HDF5 file of a run, even one that is being written or whose writer was killed.

    Raises FileNotFoundError, IsADirectoryError, PermissionError or ValueError with a sentence.
    """
    path = regular_file(path, "a run file")
    if os.path.getsize(path) == 0:
        raise ValueError(f"'{path}' is empty: no lmgcpy run.")
    with open(path, "rb") as raw:
        head = raw.read(48)
    if head[:8] != b"\x89HDF\r\n\x1a\n":
        raise ValueError(f"'{path}' is no HDF5 file, hence no lmgcpy run.")
    # HDF5's shared mode does not check the end of the file
    closed = len(head) == 48 and head[8] in (2, 3) and head[11] == 0
    if len(head) < 48 or (closed and os.path.getsize(path) < int.from_bytes(head[28:36], "little")):
        raise ValueError(f"'{path}' is truncated: its end is missing. Take a complete copy.")
    try:
        if closed:
            _visit_chunks(path)
        file = h5py().File(UnclosedFile(path), "r") if is_unclosed(path, head) else _open_shared(path)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise ValueError(f"'{path}' is truncated or damaged: HDF5 cannot open it ({error}).") from error
    try:
        _check_format(path, file)
        with sentences_of_damage(path):
            check_structure(file)
    except BaseException:
        file.close()
        raise
    return file


def _visit_chunks(path: str | os.PathLike) -> None:
    """Read the index of all chunks. Damage there raises an error, while the shared mode would try again without end."""

    def look(name: str, item: Any) -> None:
        if getattr(item, "chunks", None):
            item.id.get_num_chunks()

    with h5py().File(path, "r", locking=False) as file:
        file.visititems(look)


def _open_shared(path: str | os.PathLike) -> Any:
    try:
        return h5py().File(path, "r", swmr=True, locking=False)
    except (OSError, ValueError):
        return h5py().File(path, "r", locking=False)  # files of other programs may not support the shared mode


def _check_format(path: str | os.PathLike, file: Any) -> None:
    with sentences_of_damage(path):
        written_by, version = file.attrs.get("format"), file.attrs.get("format_version")
    if not isinstance(written_by, str) or written_by != FORMAT or version is None:
        raise ValueError(f"'{path}' is an HDF5 file, but no lmgcpy run.")
    if not isinstance(version, (int, np.integer)) or version < 1:
        raise ValueError(
            f"'{path}' is of format version {shown(version)}, older than what lmgcpy reads (from 1 on): make the run anew."
        )
    if version > VERSION:
        raise ValueError(
            f"'{path}' is of format version {int(version)}; this lmgcpy reads up to {VERSION}: install a newer lmgcpy."
        )


def open_to_append(path: str | os.PathLike) -> Any:
    """The file in writing mode, marked as shared at once; OSError if its last writer did not close it."""
    h5 = h5py()
    access = h5.h5p.create(h5.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5.h5f.LIBVER_V110, h5.h5f.LIBVER_V110)
    access.set_file_locking(False, True)
    handle = h5.h5f.open(os.fsencode(path), h5.h5f.ACC_RDWR | h5.h5f.ACC_SWMR_WRITE, fapl=access)
    return h5.File(handle)


@contextmanager
def writing(path: str | os.PathLike):
    """The file in writing mode, closed at the end; if a write fails, the file stays unchanged."""
    file = open_to_append(path)
    held = data_sets(file)
    try:
        yield file
        file.flush()
    except BaseException:
        cut_off(file)
        raise
    finally:
        held.clear()
        file.close()
