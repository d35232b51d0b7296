"""What detection carries from one step to the next, apart from any place in an array."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Memory:
    """What the last step left, by identity, and where the list of neighbours was made; m interactions, c contactors.

    A list made anew from ``listed_at`` and ``reach`` is the same list, so that a simulation that goes on from here makes
    the same numbers to the last bit.
    """

    identity: np.ndarray
    """Table (the chain, or the number of chains plus the row of the visibility table), and there the two contactors, or
    the link and -1; (m, 3) int64."""
    impulse: np.ndarray
    """In the local frame, normal first [N s], (m, d)."""
    state: np.ndarray
    """What the laws keep for each interaction, (m, k) with k the longest of the scene; NaN beyond a law's own."""
    listed: bool
    """Whether there is a list of neighbours; none before the first step."""
    listed_at: np.ndarray
    """Positions and angles of the contactors then [m, rad], (c, 3)."""
    reach: float
    """Distance between surfaces up to which pairs are in the list [m]."""
    rebuilds: int
    """How many lists were made so far."""
