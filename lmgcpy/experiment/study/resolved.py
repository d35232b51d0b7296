"""Whether a difference of two curves can be told from their noise: what is smaller is "not resolved".

The late part of a test is cut into B = 5 pieces. Their means scatter about a straight line by s, with B - 2 degrees of
freedom; the mean of the whole is then known to ``s / sqrt(B)``, and the difference of two such means, at 95 %, to

    2.45 sqrt((s_1^2 + s_2^2) / B),        Student's t of 2 (B - 2) = 6 degrees of freedom.

A trend is no noise. If the curve remembers a quarter of a piece, 9 % of all differences of noise are taken for resolved
instead of 5 %. The noise of one sample says nothing of another one: intervals over seeds are larger.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

PIECES = 5
STUDENT = 2.4469
"""Student's t of 6 degrees of freedom at 95 %, both sides."""


class LateDifference(NamedTuple):
    """A difference, and the bound below which it is not resolved, in the same unit."""

    value: float
    bound: float

    @property
    def resolved(self) -> bool:
        """Whether it is more than its bound."""
        return abs(self.value) > self.bound

    def minus(self, other: LateDifference) -> LateDifference:
        """The difference of two independent differences."""
        return LateDifference(self.value - other.value, math.hypot(self.bound, other.bound))

    def words(self, unit: float = 1.0) -> str:
        """Value and bound in a unit: "+3.1 ± 1.2", "+0.3 ± 1.2, not resolved"."""
        told = f"{self.value / unit:+.1f} ± {self.bound / unit:.1f}"
        return told if self.resolved else f"{told}, not resolved"


def noise(values: np.ndarray) -> float:
    """Standard error of the mean of a curve, (s,); infinite for less than two values a piece."""
    if len(values) < 2 * PIECES:
        return math.inf
    means = np.array([piece.mean() for piece in np.array_split(np.asarray(values, dtype=float), PIECES)])
    place = np.arange(PIECES) - 0.5 * (PIECES - 1)
    left = means - means.mean() - place * (place @ means) / (place @ place)
    return float(np.sqrt(left @ left / (PIECES - 2) / PIECES))


def difference(one: np.ndarray, other: np.ndarray, change: float = 0.0) -> LateDifference:
    """Difference of the means of two curves over the same part of a test. ``change``: what is known from elsewhere to move
    it, such as a tighter tolerance."""
    bound = STUDENT * math.hypot(noise(one), noise(other))
    return LateDifference(float(np.mean(one) - np.mean(other)), max(bound, change))
