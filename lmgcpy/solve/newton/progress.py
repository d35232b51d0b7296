"""When to give up a step: the cost of a solve so far, compared with its cost at the last gain.

In jammed samples with friction neither sweeps nor Newton steps need come to an end: impulses drift along self-
stresses, and contacts go on changing their statuses, while the residual stays the same. Work spent then is lost. So a
solve ends when it has cost :data:`TWICE` as much as when its least residual last fell by a tenth, plus a grace. Costs
are counted in sweeps, never read off a clock.

The grace is taken from successful solves. (Of 31 solves to 1e-6 and 1e-8, steps of packs of 100 to 200 rough spheres,
the two TexSol steps and 2000 settling spheres, the longest wait for a gain was 9.9e7 visits beyond twice; eight
waited for more than 2e7. A step of 500 rough spheres to 1e-4 needs more than 1e8.) It is at least the cost of a first
attempt with Newton steps.
"""

from __future__ import annotations

from math import ceil

TWICE = 2.0
GAIN = 0.9
"""A residual is a gain if it is below this share of the residual at the last gain."""
GRACE = 1.5e8
"""Number of visits of interactions that a solve may always spend without a gain: six to fifteen seconds."""


class Progress:
    """The cost of a solve so far, and its cost at the last gain, in sweeps over ``interactions`` interactions."""

    def __init__(self, interactions: int, step: float, patience: int):
        self._step = step
        self._grace = max(GRACE / max(interactions, 1), patience * step)
        self._spent = self._gained = 0.0
        self._least = float("inf")

    def add(self, residual: float, *, sweeps: int = 0, newton: int = 0) -> None:
        """Add the cost of sweeps or Newton steps, and the residual to which they led."""
        self._spent += sweeps + newton * self._step
        if residual < GAIN * self._least:
            self._least, self._gained = residual, self._spent

    @property
    def sweeps_left(self) -> int:
        """Sweeps that may go by from here without a gain."""
        return max(0, ceil(TWICE * self._gained + self._grace - self._spent))

    @property
    def newton_left(self) -> int:
        """Newton steps that may go by from here without a gain."""
        return ceil(self.sweeps_left / self._step)
