"""Import of h5py at the first use, writing that survives a full disk, and reading from files that are not trusted.

If HDF5 closes a data set and cannot write the rest of it, the process crashes, at once or at its end. If it closes a file
after a failed write, it marks the file as complete although its end is missing. So new files are made in memory. For files
that grow, all data sets are held open, so that a failed write raises an error; then the file is cut off before it is
closed.

Data that are read must lie in the file itself, plain or compressed by a filter of every HDF5 library. Links to other
files, data in other files, filters that would load code, and data sets larger than the file can hold are refused.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

FILTERS = (1, 2, 3, 32000)
"""Deflate, shuffle, Fletcher32, and the LZF that comes with h5py."""
PACKED = 1100
"""Largest ratio of compression: deflate stores at most 1032 bytes in one."""


def h5py() -> Any:
    """The module h5py; ImportError with a sentence if it is not installed."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("This file is HDF5: install h5py (pip install h5py) to read and write it.") from error
    return h5py


def in_memory(fill: Callable[[Any], None], libver: tuple[str, str]) -> memoryview:
    """The bytes of a new file with the content that ``fill`` writes."""
    memory = io.BytesIO()
    with h5py().File(memory, "w", libver=libver) as file:
        fill(file)
    return memory.getbuffer()


def data_sets(file: Any) -> list[Any]:
    """All data sets of a file. While they are held, closing another handle writes nothing."""
    found: list[Any] = []
    file.visititems(lambda name, item: found.append(item) if hasattr(item, "dtype") else None)
    return found


def cut_off(file: Any) -> None:
    """Redirect the file to the null device: later writes of HDF5 are lost, and the file on the disk stays unchanged.

    Call it before the data sets and the file are closed. On systems where HDF5 does not share its descriptors with Python
    it does nothing.
    """
    if os.name == "posix":
        with suppress(OSError, NotImplementedError, RuntimeError, ValueError):
            nowhere = os.open(os.devnull, os.O_RDWR)
            try:
                os.dup2(nowhere, file.id.get_vfd_handle(), inheritable=False)
            finally:
                os.close(nowhere)


class NumberReader:
    """Numbers of the data sets of an open file, by their paths in the file."""

    def __init__(self, file: Any):
        self._file = file
        self._most = PACKED * os.path.getsize(file.filename)

    def __contains__(self, path: str) -> bool:
        return self._item(path) is not None

    def reals(self, path: str) -> np.ndarray:
        """All numbers of a data set, (k,) float; ValueError or TypeError if it has none."""
        return self._read(path, "iuf", "numbers").astype(np.float64)

    def wholes(self, path: str) -> np.ndarray:
        """All numbers of a data set of whole numbers, (k,), of its own type; ValueError or TypeError if it has none."""
        return self._read(path, "iu", "whole numbers")

    def whole(self, path: str) -> int:
        """The number of a data set with only one number."""
        numbers = self.wholes(path)
        if len(numbers) != 1:
            raise ValueError(f"{path} must be one number, got {len(numbers)}")
        return int(numbers[0])

    def _item(self, path: str) -> Any:
        """The group or data set at a path, or None; ValueError for a link to another file."""
        item = self._file
        for name in path.split("/"):
            if not isinstance(item, h5py().Group) or not item.id.links.exists(name.encode()):
                return None
            item = child(item, name, path)
        return item

    def _read(self, path: str, kinds: str, what: str) -> np.ndarray:
        h5 = h5py()
        item = self._item(path)
        if item is None:
            raise ValueError(f"{path} is missing")
        if not isinstance(item, h5.Dataset):
            raise ValueError(f"{path} is no data set")
        if item.dtype.kind not in kinds:
            raise TypeError(f"{path} must be {what}, but is of type {item.dtype}")
        if item.shape is None:
            raise ValueError(f"{path} is empty")
        check_storage(item, path)
        check_size(item, item.shape, path, self._most)
        return np.asarray(item[()]).ravel()


def child(group: Any, name: str, path: str) -> Any:
    """The member of a group with that name; ValueError if it is a link to another file."""
    if group.id.links.get_info(name.encode()).type != h5py().h5l.TYPE_HARD:
        raise ValueError(f"{path} is a link to elsewhere: data must lie in the file itself")
    return group[name]


def check_storage(item: Any, path: str) -> None:
    """Raise ValueError if the numbers of a data set are in other files, or packed by a filter that is not built in."""
    properties = item.id.get_create_plist()
    if properties.get_external_count() or properties.get_layout() == h5py().h5d.VIRTUAL:
        raise ValueError(f"{path} has its numbers in other files: they must lie in the file itself")
    for k in range(properties.get_nfilters()):
        number = properties.get_filter(k)[0]
        if number not in FILTERS:
            raise ValueError(f"{path} is packed by filter {number}, which is not read: pack it by deflate, or not at all")


def check_size(item: Any, shape: tuple[int, ...], path: str, most: float) -> None:
    """Raise ValueError if a part of this shape of a data set, or one of its chunks, has more than ``most`` bytes."""
    chunk = np.prod(item.chunks, dtype=float) if item.chunks else 0.0
    if item.dtype.itemsize * max(np.prod(shape, dtype=float), chunk) > most:
        raise ValueError(f"{path} is said to have shape {shape}, more than a file of this size can hold")
