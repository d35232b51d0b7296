"""h5py, imported when a file is first needed, and what HDF5 must be spared: it does not survive a write that fails.

A data set that cannot write what is left of it when it is closed brings the process down, then or at its end; and a file
that is closed after a write that failed is marked as whole, with an end that it has not. Hence new files are made in
memory; files that grow have all their data sets held open, so that what fails fails where it is told; and the file is cut
off before it is closed.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any


def h5py() -> Any:
    """The module; ImportError with a sentence where it is not installed."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("This file is HDF5: install h5py (pip install h5py) to read and write it.") from error
    return h5py


def in_memory(fill: Callable[[Any], None], libver: tuple[str, str]) -> memoryview:
    """The bytes of a new file of what ``fill`` puts into it."""
    memory = io.BytesIO()
    with h5py().File(memory, "w", libver=libver) as file:
        fill(file)
    return memory.getbuffer()


def data_sets(file: Any) -> list[Any]:
    """All data sets of a file: while they are held, no other handle writes when it is closed."""
    found: list[Any] = []
    file.visititems(lambda name, item: found.append(item) if hasattr(item, "dtype") else None)
    return found


def cut_off(file: Any) -> None:
    """Leave the file on the disk as it is, as if its writer had been killed: what HDF5 still writes goes nowhere.

    It must be called before the data sets and the file are closed. Where HDF5 does not share its descriptors with Python
    nothing happens.
    """
    if os.name == "posix":
        with suppress(OSError, NotImplementedError, RuntimeError, ValueError):
            nowhere = os.open(os.devnull, os.O_RDWR)
            try:
                os.dup2(nowhere, file.id.get_vfd_handle(), inheritable=False)
            finally:
                os.close(nowhere)
