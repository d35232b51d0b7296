"""Opening a run file: to read, even one that is being written or was left by a kill, and to append to it.

HDF5 marks a file that is being written, and reads it in shared mode only. In this mode it takes wrong data for a write in
progress and tries again after ever longer times; with a truncated file it would never end. If no process writes the file
any more, waiting is useless. So the mark is removed from the bytes that HDF5 reads; the file itself does not change.
"""

from __future__ import annotations

import io
import os
import struct
from contextlib import contextmanager
from typing import Any

import numpy as np

from lmgcpy.errors import regular_file, shown
from lmgcpy.io.hdf5 import cut_off, data_sets, h5py
from lmgcpy.io.run_file.tables import sentences_of_damage
from lmgcpy.io.run_file.trees import check_structure

SUPERBLOCK = 48
"""Size in bytes of the superblock of versions 2 and 3 with addresses of 8 bytes. The flags are at byte 11, the end of the
file at 28, the checksum at 44."""
WORD = 0xFFFFFFFF

FORMAT = "lmgcpy run"
VERSION = 1


class UnclosedFile(io.RawIOBase):
    """A file to read, with a corrected superblock: it marks the file as closed and gives its true end."""

    _descriptor = -1

    def __init__(self, path: str | os.PathLike):
        self._descriptor = os.open(path, os.O_RDONLY)
        self._size = os.fstat(self._descriptor).st_size
        self._at = 0
        head = bytearray(os.pread(self._descriptor, SUPERBLOCK, 0))
        head[11] = 0
        head[28:36] = self._size.to_bytes(8, "little")
        head[44:48] = lookup3(bytes(head[:44])).to_bytes(4, "little")
        self._head = bytes(head)

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        return self._at

    def tell(self) -> int:
        return self._at

    def readinto(self, buffer) -> int:
        data = os.pread(self._descriptor, len(buffer), self._at)
        data = self._head[self._at :][: len(data)] + data[max(0, SUPERBLOCK - self._at) :]
        buffer[: len(data)] = data
        self._at += len(data)
        return len(data)

    def close(self) -> None:
        if not self.closed and self._descriptor >= 0:
            os.close(self._descriptor)
        super().close()


def _is_unclosed(path: str | os.PathLike, head: bytes) -> bool:
    """Whether a file with the superblock ``head`` is marked as being written but no process writes it."""
    if head[8] not in (2, 3) or head[9] != 8 or head[11] == 0:
        return False
    try:
        import fcntl
    except ImportError:
        return False  # without file locks nobody can know
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


def lookup3(data: bytes) -> int:
    """Checksum of HDF5's metadata: Bob Jenkins' hash lookup3 (2006), of at least 1 byte."""
    a = b = c = (0xDEADBEEF + len(data)) & WORD
    while len(data) > 12:
        x, y, z = struct.unpack("<3I", data[:12])
        a, b, c, data = a + x & WORD, b + y & WORD, c + z & WORD, data[12:]
        for turn in (4, 6, 8, 16, 19, 4):
            a = (a - c & WORD) ^ _turned(c, turn)
            a, b, c = b, c + b & WORD, a  # the next round rotates the three names
    x, y, z = struct.unpack("<3I", data.ljust(12, b"\0"))
    a, b, c = a + x & WORD, b + y & WORD, c + z & WORD
    for turn in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - _turned(b, turn) & WORD
        a, b, c = b, c, a
    return b


def _turned(x: int, by: int) -> int:
    return (x << by | x >> 32 - by) & WORD


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
        file = h5py().File(UnclosedFile(path), "r") if _is_unclosed(path, head) else _open_shared(path)
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
