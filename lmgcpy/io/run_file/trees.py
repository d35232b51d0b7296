"""``about`` and ``scene``: trees that are written once, with a digest each; and the structure of the file.

A malicious file can have correct sums. So structure, types, sizes and codes are checked before they are used, and links,
data in other files and filters that would load code are refused.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lmgcpy.io.hdf5 import PACKED, check_size, check_storage, child, h5py

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
    columns = about.get("columns", {})  # older files have none
    if not (isinstance(columns, dict) and all(isinstance(names, list) for names in columns.values())):
        raise ValueError("'about/columns' are no names")
