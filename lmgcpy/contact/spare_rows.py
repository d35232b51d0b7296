"""Arrays whose length changes a little from step to step."""

from __future__ import annotations

from typing import Any

import numpy as np

FEW = 64
"""Arrays of at most this many rows get no spare rows: memory for them fits in any hole."""


def with_spare_rows(*shape: int, fill: float | None = None, dtype: Any = float) -> np.ndarray:
    """An array of this shape, a view of the first rows of an array with up to an eighth more rows.

    An array that is slightly longer than the last does not fit into the memory that the last has freed, and such holes
    let the memory of a process grow: by 400 bytes a body at 100 000 spheres. With spare rows lengths repeat.
    """
    count = shape[0]
    if count <= FEW:
        array = np.empty(shape, dtype)
        if fill is not None:
            array.fill(fill)
        return array
    step = max(64, 1 << max(count.bit_length() - 4, 0))
    array = np.empty((-(-count // step) * step, *shape[1:]), dtype)[:count]
    if fill is not None:
        array[:] = fill
    return array
