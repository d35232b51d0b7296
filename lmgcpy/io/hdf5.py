"""Import of h5py at the first use, and writing that survives a full disk, which HDF5 itself does not.

If HDF5 closes a data set and cannot write the rest of it, the process crashes, at once or at its end. If it closes a file
after a failed write, it marks the file as complete although its end is missing. So new files are made in memory. For files
that grow, all data sets are held open, so that a failed write raises an error; then the file is cut off before it is
closed.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any


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
