"""A wire as the generators lay it: a chain of beads, in the order of the chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, repr=False)
class Wire:
    """A chain of beads, and whether it had to be cut (paper, section 4: "sometimes it is impossible to define a bead
    position, so the wire is cut").
    """

    positions: np.ndarray
    """Centres of the beads [m], shape (bead_count, d)."""

    radii: np.ndarray
    """Radii of the beads [m], shape (bead_count,)."""

    interstice: float
    """Gap between the surfaces of consecutive beads [m]: the reference gap of the links."""

    requested_count: int
    """Number of beads asked for."""

    @property
    def bead_count(self) -> int:
        """Number of beads laid."""
        return len(self.positions)

    @property
    def cut(self) -> bool:
        """Whether the wire ends before the requested number of beads, as the next bead fitted nowhere."""
        return self.bead_count < self.requested_count

    @property
    def length(self) -> float:
        """Laid length from the first to the last centre [m]."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())

    def __str__(self) -> str:
        laid = f"wire of {self.bead_count} beads, {self.length:.3g} m long"
        if not self.cut:
            return laid
        return f"{laid}, cut: there was no place for bead {self.bead_count + 1} of {self.requested_count}"

    def __repr__(self) -> str:
        return f"<{self}>"
