"""Pairs of bodies that never meet, whatever the visibility table says: linked neighbours whose link leaves no gap.

They are left out of the lists of neighbours when these are made, so that a step pays nothing for them.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel


@kernel
def _keep(pairs, body, first, others, left):
    """Write the pairs of contactors whose bodies may meet, in their order; returns their number."""
    count = 0
    for p in range(pairs.shape[0]):
        lower = min(body[pairs[p, 0]], body[pairs[p, 1]])
        higher = max(body[pairs[p, 0]], body[pairs[p, 1]])
        meet = True
        for k in range(first[lower], first[lower + 1]):
            meet = meet and others[k] != higher
        if meet:
            left[count, 0] = pairs[p, 0]
            left[count, 1] = pairs[p, 1]
            count += 1
    return count


class ExcludedPairs:
    """Pairs of bodies that never meet: for each body the bodies of a higher row that it never meets."""

    def __init__(self, pairs: np.ndarray, body_count: int):
        """``pairs``: rows of the bodies, (p, 2), the lower first, sorted."""
        self._others = np.ascontiguousarray(pairs[:, 1])
        self._first = np.searchsorted(pairs[:, 0], np.arange(body_count + 1))
        self._count = body_count
        self._keys = self._key(pairs[:, 0], pairs[:, 1])

    def _key(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        return np.minimum(one, other).astype(np.int64) * self._count + np.maximum(one, other)

    def contain(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Whether bodies never meet others, of the shape to which both are broadcast."""
        return np.isin(self._key(one, other), self._keys)

    def left_out_of(self, pairs: np.ndarray, body: np.ndarray) -> np.ndarray:
        """The pairs of contactors (p, 2) whose bodies may meet, in their order; ``body``: body of each contactor, (k,)."""
        if not len(self._others) or not len(pairs):
            return pairs
        left = np.empty_like(pairs)
        return left[: _keep(pairs, body, self._first, self._others, left)]
