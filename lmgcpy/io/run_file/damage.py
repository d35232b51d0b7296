"""Damage of a run file, described in a sentence."""

from __future__ import annotations

import os
from contextlib import contextmanager

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
