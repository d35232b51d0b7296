"""A file whose writer was killed, read as if it had been closed.

HDF5 marks a file that is being written, and reads it in a shared mode only, in which it takes what looks wrong for a write
under way and looks again, after ever longer times: in a file that was cut it would do so for ever. Where nobody writes any
more there is nothing to wait for. Here the mark is taken off, in what is read, not in the file.
"""

from __future__ import annotations

import io
import os
import struct

SUPERBLOCK = 48
"""Bytes of the superblock of versions 2 and 3 with addresses of 8 bytes: flags at 11, end of the file at 28, checksum at
44."""
WORD = 0xFFFFFFFF


class DeadFile(io.RawIOBase):
    """A file to read, with a superblock that says that it is closed and ends where it ends."""

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


def is_dead(path: str | os.PathLike, head: bytes) -> bool:
    """Whether a file, of which ``head`` is the superblock, is marked as being written and nobody does so."""
    if head[8] not in (2, 3) or head[9] != 8 or head[11] == 0:
        return False
    try:
        import fcntl
    except ImportError:
        return False  # it cannot be told
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


def lookup3(data: bytes) -> int:
    """Checksum of HDF5's metadata: Bob Jenkins' hash lookup3 (2006), of 1 byte at least."""
    a = b = c = (0xDEADBEEF + len(data)) & WORD
    while len(data) > 12:
        x, y, z = struct.unpack("<3I", data[:12])
        a, b, c, data = a + x & WORD, b + y & WORD, c + z & WORD, data[12:]
        for turn in (4, 6, 8, 16, 19, 4):
            a = (a - c & WORD) ^ _turned(c, turn)
            a, b, c = b, c + b & WORD, a  # the next round has the names moved on by one
    x, y, z = struct.unpack("<3I", data.ljust(12, b"\0"))
    a, b, c = a + x & WORD, b + y & WORD, c + z & WORD
    for turn in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - _turned(b, turn) & WORD
        a, b, c = b, c, a
    return b


def _turned(x: int, by: int) -> int:
    return (x << by | x >> 32 - by) & WORD
