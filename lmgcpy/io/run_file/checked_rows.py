"""Rows of growing tables, read with their checksums: HDF5's Fletcher32 of each chunk, and sums of the last ones."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np

from lmgcpy.io.run_file.damage import DamagedRows


def rows_of(table: Any, key: Any, rows: int, *, field: str | None, tail: int | None) -> np.ndarray:
    """Part of the first ``rows`` rows of a growing table; raises :class:`DamagedRows` if a checksum is wrong.

    ``tail`` is the :func:`tail_sum` in a file that its writer did not close or still writes. There the last chunk is
    rewritten as it grows, so that its checksum may belong to an earlier or later content; the committed rows do not change.
    """
    try:
        return (table if field is None else table.fields(field))[key]
    except (OSError, RuntimeError) as error:
        first, last = (key, key + 1) if isinstance(key, int) else (key.start, min(key.stop, rows))
        step = table.chunks[0]
        moved = first // step * step
        parts, damaged = [], []
        for start in range(moved, last, step):
            stop = min(start + step, rows)
            try:
                parts.append(table[start:stop])
            except (OSError, RuntimeError):
                part = _without_checksum(table, start)[: stop - start]
                if stop == rows and tail is not None and _sum(part) == tail:
                    parts.append(part)
                else:
                    damaged.append((start, stop - 1))
        if damaged:
            raise DamagedRows(damaged) from error
        found = np.concatenate(parts)
        found = found[key - moved if isinstance(key, int) else slice(key.start - moved, key.stop - moved, key.step)]
        return found if field is None else found[field]


def tail_sum(table: Any, rows: int) -> int:
    """Checksum of the committed rows in the last chunk of a growing table."""
    return _sum(table[start_of_last_chunk(table, rows) : rows]) if rows else 0


def _sum(rows: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(rows).tobytes())


def start_of_last_chunk(table: Any, rows: int) -> int:
    """First row of the chunk that holds the last of ``rows`` rows."""
    return (rows - 1) // table.chunks[0] * table.chunks[0]


def _without_checksum(table: Any, start: int) -> np.ndarray:
    raw = table.id.read_direct_chunk((start, *(0,) * (table.ndim - 1)))[1]
    shape = table.chunks
    return np.frombuffer(raw, dtype=table.dtype, count=int(np.prod(shape))).reshape(shape)
