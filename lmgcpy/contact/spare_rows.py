"""Arrays whose length changes a little from step to step."""

from __future__ import annotations

from typing import Any

import numpy as np


def room(*shape: int, fill: float | None = None, dtype: Any = float) -> np.ndarray:
    """An array of a shape, at the beginning of one that has up to an eighth more rows.

    Of arrays of slightly different lengths none fits into the place that another has left, and the memory of a
    process grows by what lies between them: by 400 bytes a body at 100 000 spheres.
    """
    count = shape[0]
    step = max(64, 1 << max(count.bit_length() - 4, 0))
    array = np.empty((-(-count // step) * step, *shape[1:]), dtype)[:count]
    if fill is not None:
        array[:] = fill
    return array
