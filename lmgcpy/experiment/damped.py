"""A simulation in a viscous medium: the drag that brings a sample to rest without hammering it."""

from __future__ import annotations

import math

from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.report import Report


class DampedSimulation(Simulation):
    """Before every step all velocities decay by ``exp(-h / drag_time)``: the exact answer to a drag ``-(m / drag_time) v``.

    The drag does not act within the step, so that it does not change impulses at rest. ``drag_time`` [s].
    """

    _kept = 1.0
    """Part of the velocities that is left after a step."""

    def __init__(self, scene, *, drag_time: float, **options):
        super().__init__(scene, **options)
        self._kept = math.exp(-self.time_step / drag_time)

    def step(self) -> Report:
        """Make one step, see :meth:`lmgcpy.Simulation.step`."""
        before, steps = self.state.velocities.copy(), self.steps
        self.state.velocities *= self._kept
        try:
            return super().step()
        except BaseException:
            if self.steps == steps:  # else the step was made, and the error is about its result
                self.state.velocities[:] = before
            raise
