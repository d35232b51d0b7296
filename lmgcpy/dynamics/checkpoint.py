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
    unconverged_steps: int
    worst_residual: float
    """Largest residual of a step so far."""
    energy: Energy
    memory: Memory
