"""Tension along a wire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.measure.moment import Source, moment
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class WireTension(Table):
    """The l links of a chain, from its first body to its last."""

    along: np.ndarray
    """Length of wire up to the middle of each link [m], (l,)."""
    tension: np.ndarray
    """Tension, a push negative [N], (l,)."""
    pairs: np.ndarray
    """Ids of candidate and antagonist, (l, 2)."""


@named_arguments
def wire_tension(sim: Source, chain: int = 0, *, frame: int | None = None) -> WireTension:
    """Tension along chain number ``chain`` in the last step of a simulation, or in that of a ``frame`` of an open run.

    Raises ValueError where there is no such chain, or no step yet.
    """
    now = moment(sim, frame, "wire_tension")
    counts = now.scene["chains"]["link_count"]
    number = whole(chain, "chain", minimum=0)
    if number >= len(counts):
        raise ValueError(f"There is no chain {number}: the scene has {len(counts)}, counted from 0.")
    first = int(counts[:number].sum())
    part = slice(first, first + int(counts[number]))
    if len(now.net) < part.stop:
        raise ValueError("There is no step yet, and so no tension: run the simulation first.")
    pairs = np.column_stack([now.net.candidate, now.net.antagonist])[part]
    length = np.linalg.norm(now.positions[pairs[:, 0]] - now.positions[pairs[:, 1]], axis=1)
    return WireTension(np.cumsum(length) - 0.5 * length, 0.0 - now.net.force[part, 0], pairs)  # slack: 0, not -0
