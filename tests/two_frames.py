"""A run of two frames, without a file: what measures of motion read."""

from typing import Any

import numpy as np

from lmgcpy.io.run import Run


class TwoFrames(Run):
    """Positions before and after, (n, d) each, of bodies of one size."""

    frame_count: Any = 2
    positions: Any = None
    extent: Any = None

    def __init__(self, before: Any, after: Any, extent: float = 0.1):
        self.positions = np.stack([before, after])
        self.extent = np.full(len(before), extent)

    def hidden(self, frame: int, *, in_step: bool = False) -> np.ndarray:
        """No body."""
        return np.zeros(self.extent.shape, dtype=bool)

    def __repr__(self) -> str:
        return "<two frames>"
