"""h5py, imported when a file is first needed: importing lmgcpy does without it."""

from __future__ import annotations

from typing import Any


def h5py() -> Any:
    """The module; ImportError with a sentence where it is not installed."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("This file is HDF5: install h5py (pip install h5py) to read and write it.") from error
    return h5py
