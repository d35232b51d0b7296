"""Run files read without trust: what they are made of, whether it is what was written, and where it is not.

Growing tables carry HDF5's Fletcher32 checksum by chunk; ``about`` and ``scene``, which are written once, a digest each;
checkpoints and commits checksums of their own. So damage is found where it is read, and told by table and frames, and what
is undamaged can be read. A file made on purpose can have the right sums: its structure, types, sizes and codes are checked
before anything relies on them, and links, data in other files and filters that would load code are refused.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lmgcpy.io.foreign import PACKED, check_size, check_storage, child
from lmgcpy.io.hdf5 import h5py

DIGEST = "digest"
"""Attribute of ``about`` and ``scene``; files from before it have none."""
DEPTH = 8
"""So deep groups may lie in each other; those of a run lie three deep."""
CHECKSUM = 4
"""Bytes of the checksum at the end of a chunk."""
WORDS: Mapping[str, type] = {"created": str, "laws": list, "options": dict, "versions": dict}
"""What ``about`` must hold."""
OPTIONS = ("time_step", "theta", "solver", "solver_fields", "on_unconverged", "every", "flush")


def check_structure(file: Any) -> None:
    """ValueError or TypeError where something in the file is neither a group nor a plain data set in the file itself, or
    larger than what fits into the file."""
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
    """SHA-256 of all names, types, shapes and numbers of a group."""
    total = hashlib.sha256()
    for path, item in sorted(_items(group, "")):
        total.update(f"{path}\0{item.dtype.str if item.dtype.names is None else item.dtype}\0{item.shape}\0".encode())
        total.update(np.ascontiguousarray(item[()]).tobytes())
    return total.hexdigest()


def check_digest(file: Any, name: str) -> None:
    """ValueError where ``about`` or ``scene`` is not what was written."""
    written = file[name].attrs.get(DIGEST)
    if written is not None and written != digest(file[name]):
        raise ValueError(f"'{name}' is not what was written, by its digest")


def read_group(file: Any, name: str) -> dict[str, Any]:
    """The tree of ``about`` or ``scene``; ValueError where it is not what was written."""
    check_digest(file, name)
    return read_tree(file[name])


def read_tree(group: Any) -> dict[str, Any]:
    """What :func:`write_tree` wrote."""
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
    """A tree and its digest."""
    group = file.create_group(name)
    write_tree(group, tree)
    group.attrs[DIGEST] = digest(group)


def write_tree(group: Any, tree: Mapping[str, Any]) -> None:
    """Dictionaries as groups, arrays as data sets, all else as JSON texts."""
    for name, value in tree.items():
        if isinstance(value, Mapping) and value:
            write_tree(group.create_group(name), value)
        elif isinstance(value, np.ndarray):
            group.create_dataset(name, data=value)
        else:
            group.create_dataset(name, data=np.bytes_(json.dumps(value)))


def check_about(about: Mapping[str, Any], observed: list[str]) -> None:
    """ValueError where ``about`` lacks something, or something in it is of another type."""
    for name, kind in WORDS.items():
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
    """ValueError where a growing table is of another type, or so many rows of it are not in the file."""
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
    """Whether the file does not end before the last of so many rows."""
    place = table.id.get_chunk_info_by_coord((_first_of_last(table, rows), *(0,) * (table.ndim - 1)))
    return place.byte_offset is not None and place.byte_offset + place.size <= table.file.id.get_filesize()


def _first_of_last(table: Any, rows: int) -> int:
    return (rows - 1) // table.chunks[0] * table.chunks[0]


def rows_of(table: Any, key: Any, rows: int, *, field: str | None, tail: int | None) -> np.ndarray:
    """Part of the first ``rows`` of a growing table; :class:`DamagedRows` where a checksum is wrong.

    ``tail``: in a file whose writer did not close it, or is at work, the :func:`tail_sum`: the last chunk is written again
    as it grows, so that its checksum may be that of another moment; what counts in it does not change.
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
    """Sum of what counts in the last chunk of a growing table."""
    return _sum(table[_first_of_last(table, rows) : rows]) if rows else 0


def _sum(rows: np.ndarray) -> int:
    return zlib.crc32(np.ascontiguousarray(rows).tobytes())


class DamagedRows(Exception):
    """``spans``: first and last row of each part of a table that cannot be read."""

    def __init__(self, spans: list[tuple[int, int]]):
        self.spans = spans
        super().__init__(spans)


def _without_checksum(table: Any, start: int) -> np.ndarray:
    raw = table.id.read_direct_chunk((start, *(0,) * (table.ndim - 1)))[1]
    shape = table.chunks
    return np.frombuffer(raw, dtype=table.dtype, count=int(np.prod(shape))).reshape(shape)
