"""What detection carries from one step to the next, apart from any place in an array."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.compiled.kernel import kernel


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


@kernel
def recall(slots, known, values, result):
    """Rows of ``values`` that belong to the slots ``known``, into ``result`` where its ``slots`` are the same; both
    ascend."""
    k = 0
    for i in range(slots.shape[0]):
        while k < known.shape[0] and known[k] < slots[i]:
            k += 1
        if k < known.shape[0] and known[k] == slots[i]:
            for column in range(values.shape[1]):
                result[i, column] = values[k, column]


@kernel
def carry(old, old_rank, remembered, new, new_rank, source):
    """From the places of one list of pairs to those of another: what is ``remembered`` at a pair of the old one, if not
    below zero, goes into ``source`` at the same pair of the new one. ``rank``: places of the pairs taken by ids."""
    k = 0
    for p in range(old_rank.shape[0]):
        place = old_rank[p]
        if remembered[place] < 0:
            continue
        c = old[place, 0]
        a = old[place, 1]
        while k < new_rank.shape[0]:
            there = new_rank[k]
            if new[there, 0] > c or (new[there, 0] == c and new[there, 1] >= a):
                if new[there, 0] == c and new[there, 1] == a:
                    source[there] = remembered[place]
                break
            k += 1
