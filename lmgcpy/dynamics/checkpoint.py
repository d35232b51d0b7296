"""All that the next step depends on, and the totals of the run so far: enough to go on bit for bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.memory import Memory
from lmgcpy.dynamics.energy import Energy


@dataclass(frozen=True)
class Checkpoint:
    """A simulation between two steps, as copies; n bodies."""

    positions: np.ndarray
    """(x, y, angle) [m, m, rad], (n, 3)."""
    velocities: np.ndarray
    """[m/s, m/s, rad/s], (n, 3)."""
    time: float
    """[s]."""
    steps: int
    """Made so far."""
    unconverged_steps: int
    """Of those, which the solver did not solve to its tolerance."""
    worst_residual: float
    """Largest residual of a step so far."""
    energy: Energy
    """Of the last step, and its totals."""
    memory: Memory
    """Impulses and states of the interactions, by identity."""
    predicted: np.ndarray
    """Gaps of the links by their laws at the end of the last step [m], (L,), NaN where not known."""

    def __repr__(self) -> str:
        return f"<Checkpoint of {len(self.positions)} bodies at t = {self.time:g} s, step {self.steps}>"
