"""Reading of numbers from HDF5 files that are not trusted.

Data must lie in the file itself, plain or compressed by a filter of every HDF5 library. Links to other files, data in
other files, filters that would load code, and data sets larger than the file can hold are refused.
"""

from __future__ import annotations

import os
import stat
from typing import Any

import numpy as np

from lmgcpy.errors import file_path
from lmgcpy.io.hdf5 import h5py

FILTERS = (1, 2, 3, 32000)
"""Deflate, shuffle, Fletcher32, and the LZF that comes with h5py."""
PACKED = 1100
"""Largest ratio of compression: deflate stores at most 1032 bytes in one."""


def regular_file(path: str | os.PathLike, what: str) -> str:
    """The path of a regular file that can be read.

    Raises TypeError, FileNotFoundError, IsADirectoryError, PermissionError, and ValueError for a pipe or a device, because
    a read from it might never end.
    """
    path = file_path(path, "path")
    if not os.path.exists(path):
        raise FileNotFoundError(f"There is no file '{path}'.")
    mode = os.stat(path).st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"'{path}' is a folder, not {what}.")
    if not stat.S_ISREG(mode):
        raise ValueError(f"'{path}' is a pipe or a device, not {what}: write what comes from there into a file first.")
    if not os.access(path, os.R_OK):
        raise PermissionError(f"The file '{path}' may not be read: change its permissions.")
    return path


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
