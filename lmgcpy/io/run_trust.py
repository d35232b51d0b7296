"""Checks of run files: structure, types, sizes, checksums and digests.

Growing tables have HDF5's Fletcher32 checksum for each chunk. ``about`` and ``scene`` are written once and have a digest
each. Checkpoints and commits have checksums of their own. So damage is found when it is read; the error names the table
and its frames, and the rest of the file can be read. A malicious file can have correct sums. So structure, types, sizes
and codes are checked before they are used, and links, data in other files and filters that would load code are refused.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lmgcpy.io.hdf5 import h5py
from lmgcpy.io.untrusted import PACKED, check_size, check_storage, child

DIGEST = "digest"
"""Attribute of ``about`` and ``scene``; older files have none."""
DEPTH = 8
"""Largest depth of nested groups; a run file has three levels."""
ABOUT: Mapping[str, type] = {"created": str, "laws": list, "options": dict, "versions": dict}
"""Entries of ``about`` and their types."""
OPTIONS = ("time_step", "theta", "solver", "solver_fields", "on_unconverged", "every", "flush")


def check_structure(file: Any) -> None:
    """Raise ValueError or TypeError unless the file has only groups and plain data sets.

    The data must lie in the file itself, and no data set may be larger than the file can hold.
    """
    most = PACKED * file.id.get_filesize()
    for path, item in _items(file, ""):
        check_storage(item, path)
        if item.dtype.kind not in "biufSV" or item.shape is None:
            raise TypeError(f"'{path}' is of a type that no run has, {item.dtype}")
        check_size(item, item.shape, path, most)


def _items(group: Any, path: str) -> Iterator[tuple[str, Any]]:
    if path.count("/") > DEPTH:
        raise ValueError(f"'{path}' lies deeper than anything of a run")
    h5 = h5py()
    for name in group:
        inside = f"{path}/{name}".lstrip("/")
        item = child(group, name, inside)
        if isinstance(item, h5.Group):
            yield from _items(item, inside)
        elif isinstance(item, h5.Dataset):
            yield inside, item
        else:
            raise TypeError(f"'{inside}' is neither a group nor a data set")


def digest(group: Any) -> str:
    """SHA-256 of the names, types, shapes and numbers of a group."""
    total = hashlib.sha256()
    for path, item in sorted(_items(group, "")):
        total.update(f"{path}\0{item.dtype.str if item.dtype.names is None else item.dtype}\0{item.shape}\0".encode())
        total.update(np.ascontiguousarray(item[()]).tobytes())
    return total.hexdigest()


def check_digest(file: Any, name: str) -> None:
    """Raise ValueError if the digest of ``about`` or ``scene`` is wrong."""
    written = file[name].attrs.get(DIGEST)
    if written is not None and written != digest(file[name]):
        raise ValueError(f"'{name}' is not what was written, by its digest")


def read_group(file: Any, name: str) -> dict[str, Any]:
    """The tree of ``about`` or ``scene``; ValueError if its digest is wrong."""
    check_digest(file, name)
    return read_tree(file[name])


def read_tree(group: Any) -> dict[str, Any]:
    """The tree that :func:`write_tree` wrote."""
    tree: dict[str, Any] = {}
    for name, item in group.items():
        if not hasattr(item, "dtype"):
            tree[name] = read_tree(item)
        elif item.dtype.kind == "S":
            tree[name] = json.loads(item[()])
        else:
            tree[name] = item[()]
    return tree


def write_group(file: Any, name: str, tree: Mapping[str, Any]) -> None:
    """Write a tree and its digest."""
    group = file.create_group(name)
    write_tree(group, tree)
    group.attrs[DIGEST] = digest(group)


def write_tree(group: Any, tree: Mapping[str, Any]) -> None:
    """Write dictionaries as groups, arrays as data sets, and other values as JSON texts."""
    for name, value in tree.items():
        if isinstance(value, Mapping) and value:
            write_tree(group.create_group(name), value)
        elif isinstance(value, np.ndarray):
            group.create_dataset(name, data=value)
        else:
            group.create_dataset(name, data=np.bytes_(json.dumps(value)))


def check_about(about: Mapping[str, Any], observed: list[str]) -> None:
    """Raise ValueError if an entry of ``about`` is missing or has another type."""
    for name, kind in ABOUT.items():
        if not isinstance(about.get(name), kind):
            raise ValueError(f"'about/{name}' is missing or no {kind.__name__}")
    missing = [name for name in OPTIONS if name not in about["options"]]
    if missing:
        raise ValueError(f"'about/options' lacks {', '.join(missing)}")
    for name, least in (("time_step", 0.0), ("theta", 0.0), ("every", 1), ("flush", 0.0)):
        value = about["options"][name]
        if not isinstance(value, (int, float)) or not least <= value < np.inf:
            raise ValueError(f"'about/options/{name}' is {value!r}")
    if not all(isinstance(law, str) for law in about["laws"]):
        raise ValueError("'about/laws' are no words")
    if not isinstance(about.get("notes", {}), dict) or sorted(about.get("observed", [])) != sorted(observed):
        raise ValueError("'about/notes' or 'about/observed' are not those of the file")


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


def _start_of_last_chunk(table: Any, rows: int) -> int:
    return (rows - 1) // table.chunks[0] * table.chunks[0]


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


class DamagedRows(Exception):
    """Rows of a table that cannot be read; ``spans`` holds the first and last row of each part."""

    def __init__(self, spans: list[tuple[int, int]]):
        self.spans = spans
        super().__init__(spans)


def _without_checksum(table: Any, start: int) -> np.ndarray:
    raw = table.id.read_direct_chunk((start, *(0,) * (table.ndim - 1)))[1]
    shape = table.chunks
    return np.frombuffer(raw, dtype=table.dtype, count=int(np.prod(shape))).reshape(shape)
