"""An elastic wire that breaks at its strength, implicit like lmgcpy's elastic laws.

A whole link pulls by

    -r_n / h = min(k max(g+ - g_ref, 0), F),       g+ = g + h u_n,

``F`` its strength: elastic up to it, and never more. A link that has reached it is broken from the next step on, for
good. In the step in which it breaks it therefore pulls by ``F``, exactly. Two other ways were not taken. To drop the
force to zero within the step makes a relation that falls: an impulse and no impulse may then both satisfy it, or
neither. To let the elastic force stand and break the link afterwards lets the tension exceed the strength by as much
as the step is long.

The relation is monotone, so that a wire of such links has one answer. With ``C = 1/(h^2 k)`` and
``b = (g - g_ref)/h`` it is

    r_n = -min(max((u_n + b)/(W + C), 0), h F)      where u_n is the velocity without r_n.

LMGC90 knows a law of this kind as BRITTLE_ELASTIC_WIRE.
"""

from __future__ import annotations

import numpy as np

import lmgcpy as lm
from lmgcpy.laws.elastic import AxialLink
from lmgcpy.laws.rigid import pull_back

REACHED = 1.0 - 1e-9
"""Part of the strength at which a link counts as having reached it: solvers add impulses up, which leaves round-off."""


class BrittleWire(AxialLink):
    """``r_n = -h min(k max(g+ - g_ref, 0), F)`` until the tension has reached the strength F, nothing from then on."""

    NAME = "brittle-wire"
    PREPARED = ("bias", "compliance", "hold")
    TRAITS = frozenset({"potential", "pull"})
    conic = None  # type: ignore[assignment]

    strength = lm.Parameter("N", "tension at which a link breaks, F", above=0.0)
    broken = lm.State("-", "1 where the link is broken, 0 where it is whole")

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """Stiffness [N/m] and strength [N] of each link, shape (count, 2)."""
        stiffness = super().table(reference_length)
        return np.hstack([stiffness, np.full_like(stiffness, self.strength)])

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        stiffness, strength = parameters
        hold = 0.0 if state[0] > 0.0 else time_step * strength
        return (pull_back(gap, reference_gap, time_step), 1.0 / (time_step * time_step * stiffness), hold)

    @staticmethod
    def react(W, u, prepared):
        bias, compliance, hold = prepared
        return (-min(max((u[0] + bias) / (W[0][0] + compliance), 0.0), hold),)

    @staticmethod
    def slope(W, u, prepared):
        bias, compliance, hold = prepared
        pull = (u[0] + bias) / (W[0][0] + compliance)
        return ((-1.0 / (W[0][0] + compliance) if 0.0 < pull < hold else 0.0,),)

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        tension = -impulse[0] / time_step
        return (1.0 if tension >= REACHED * parameters[1] else state[0],)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        """``k e^2/2`` up to the elongation of breaking ``F/k``, linear beyond; 0 of a broken link."""
        stiffness, strength = parameters
        elongation = max(gap - reference_gap, 0.0)
        taken = min(elongation, strength / stiffness)
        whole = 0.5 * stiffness * taken * taken + strength * (elongation - taken)
        return 0.0 if state[0] > 0.0 else whole
