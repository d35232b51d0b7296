"""Reading of an HDF5 file whose writer was killed, as if the writer had closed it.

HDF5 marks a file that is being written, and reads it in shared mode only. In this mode it takes wrong data for a write in
progress and tries again after ever longer times; with a truncated file it would never end. If no process writes the file
any more, waiting is useless. So the mark is removed from the bytes that HDF5 reads; the file itself does not change.
"""

from __future__ import annotations

import io
import os
import struct

SUPERBLOCK = 48
"""Size in bytes of the superblock of versions 2 and 3 with addresses of 8 bytes. The flags are at byte 11, the end of the
file at 28, the checksum at 44."""
WORD = 0xFFFFFFFF


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


def is_unclosed(path: str | os.PathLike, head: bytes) -> bool:
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
