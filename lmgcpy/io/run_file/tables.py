"""The tables that grow with a run: their types, whether a file holds them, and their rows, read with checksums.

The checksums are HDF5's Fletcher32 of each chunk, and sums of the last chunks. Damage of a run file is described in a
sentence.
"""

from __future__ import annotations

import os
import zlib
from contextlib import contextmanager
from typing import Any

import numpy as np

from lmgcpy.laws.law import ROLLING_ROWS

WRONG = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)
"""Exceptions that reading of damaged data may raise."""

GROWING = ("frames/index", "frames/positions", "frames/velocities", "interactions", "history")
"""Growing tables of every file; each observation adds one."""
OBSERVED = "observed/"

INDEX = np.dtype([("time", "f8"), ("step", "i8"), ("first", "i8"), ("count", "i8")])


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
    return _sum(table[_start_of_last_chunk(table, rows) : rows]) if rows else 0


def _sum(rows: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(rows).tobytes())


def _start_of_last_chunk(table: Any, rows: int) -> int:
    """First row of the chunk that holds the last of ``rows`` rows."""
    return (rows - 1) // table.chunks[0] * table.chunks[0]


def _without_checksum(table: Any, start: int) -> np.ndarray:
    raw = table.id.read_direct_chunk((start, *(0,) * (table.ndim - 1)))[1]
    shape = table.chunks
    return np.frombuffer(raw, dtype=table.dtype, count=int(np.prod(shape))).reshape(shape)


def interaction_type(dimension: int, moments: int = 0) -> np.dtype:
    """Type of a row of ``interactions``: ids, code of the law, gap [m], normal, contact point [m], impulse [N s], and in
    scenes with rolling friction a number ``moments`` of moments [N m s].

    The impulse is in the local frame, and so are the moments.
    """
    vector = ("f8", (dimension,))
    rolling = [("moment", "f8", (moments,))] if moments else []
    return np.dtype(
        [
            ("candidate", "i4"),
            ("antagonist", "i4"),
            ("law", "i2"),
            ("gap", "f8"),
            ("normal", *vector),
            ("point", *vector),
            ("impulse", *vector),
            *rolling,
        ]
    )


def history_type(law_count: int) -> np.dtype:
    """Type of a row of ``history``; energies in [J], ``work`` and ``stored`` by law."""
    fields: list[Any] = [("step", "i8"), ("time", "f8"), ("iterations", "i4"), ("residual", "f8"), ("status", "i1")]
    fields += [("interactions", "i4"), ("seconds", "f8"), ("step_seconds", "f8"), ("slip", "f8")]
    fields += [("stretch", "f8"), ("made", "f8")]
    fields += [(name, "f8") for name in ("kinetic", "loads", "drives", "drag", "unbalanced", "defect")]
    return np.dtype(fields + [(name, "f8", (law_count,)) for name in ("work", "stored") if law_count])


def growing_tables(file: Any) -> list[str]:
    """Names of the tables that grow with the run."""
    return [*GROWING, *(OBSERVED + name for name in file.get(OBSERVED[:-1], ()))]


def table_types(file: Any, laws: list[str]) -> dict[str, np.dtype]:
    """Type and shape of the rows of each growing table. The number of velocity components gives the dimension."""
    bodies, components = file["frames/velocities"].shape[1:]
    if components not in (3, 6):
        raise ValueError(f"'frames/velocities' has {components} components, not 3 or 6")
    dimension, shape = 2 if components == 3 else 3, file["frames/positions"].shape
    width = shape[-1]
    if len(shape) != 3 or (width != 3 and (dimension, width) != (3, 7)):
        raise ValueError(f"'frames/positions' is of shape {shape}, where 3 numbers a body were written, or 7 in 3D")
    vectors = np.dtype(("f8", (bodies, width))), np.dtype(("f8", (bodies, components)))
    rolling = (
        ROLLING_ROWS.get(dimension, dimension) - dimension if "moment" in (file["interactions"].dtype.names or ()) else 0
    )
    kinds = INDEX, *vectors, interaction_type(dimension, rolling), history_type(len(laws))
    types = dict(zip(GROWING, kinds, strict=True))
    for name in growing_tables(file):
        if name not in types:
            kind = np.dtype((file[name].dtype, file[name].shape[1:]))
            if kind.base.kind not in "biuf":
                raise ValueError(f"'{name}' holds no numbers")
            types[name] = kind
    return types


def check_table(file: Any, name: str, kind: np.dtype, rows: int) -> None:
    """Raise ValueError if a growing table has another type, or if the file holds fewer than ``rows`` rows of it."""
    table = file[name]
    if not hasattr(table, "chunks") or not table.chunks:
        raise ValueError(f"'{name}' is no growing table")
    fields = table.dtype.names
    if fields is not None and kind.names is not None and name == "history":  # older files have fewer columns
        kind = np.dtype([(field, kind[field]) for field in kind.names if field in fields])
    if table.dtype != kind.base or table.shape[1:] != kind.shape:
        raise ValueError(f"'{name}' is of type {table.dtype} and shape {table.shape}, not of {kind}")
    if not 0 <= rows <= len(table):
        raise ValueError(f"'{name}' lacks entries")
    row = kind.itemsize
    if rows and table.id.get_storage_size() < rows * row:
        raise ValueError(f"'{name}' lacks entries")
    if rows and not _is_inside(table, rows):
        raise ValueError(f"'{name}' lacks entries")


def _is_inside(table: Any, rows: int) -> bool:
    """Whether the file contains the chunk of the last of ``rows`` rows."""
    chunk = table.id.get_chunk_info_by_coord((_start_of_last_chunk(table, rows), *(0,) * (table.ndim - 1)))
    return chunk.byte_offset is not None and chunk.byte_offset + chunk.size <= table.file.id.get_filesize()
