"""Rows of growing tables, read with their checksums: HDF5's Fletcher32 of each chunk, and sums of the last ones.

Damage of a run file is described in a sentence.
"""

from __future__ import annotations

import os
import zlib
from contextlib import contextmanager
from typing import Any

import numpy as np

WRONG = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)
"""Exceptions that reading of damaged data may raise."""


class DamagedRows(Exception):
    """Rows of a table that cannot be read; ``spans`` holds the first and last row of each part."""

    def __init__(self, spans: list[tuple[int, int]]):
        self.spans = spans
        super().__init__(spans)


@contextmanager
def sentences_of_damage(path: str | os.PathLike):
    """Turn the errors of HDF5, numpy and the checks on a damaged file into a ValueError with a sentence."""
    try:
        yield
    except DamagedRows as error:
        rows = ", ".join(f"{first} to {last}" for first, last in error.spans)
        raise ValueError(f"'{path}' is damaged: rows {rows} of a table cannot be read.") from error
    except WRONG as error:
        what = str(error.args[0] if error.args else type(error).__name__)
        if what.startswith(f"'{path}'"):
            raise
        raise ValueError(f"'{path}' is truncated or damaged: {what.rstrip('.')}.") from error


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
