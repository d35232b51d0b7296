"""Newton's law of impact with Coulomb friction."""

from __future__ import annotations

import math

from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.law import Parameter


class Restitution(Coulomb):
    """Where the gap is closed: ``0 <= u_n + e min(u_n^-, 0)  _|_  r_n >= 0`` and Coulomb's friction; else ``r = 0``.

    ``u_n^-`` is the normal velocity at the start of the step. In a collision of several bodies the law is certainly
    dissipative only if the coefficient is the same everywhere (Moreau).

    All shocks of a step happen at once: with ``e = 1`` a disk that meets a row of touching disks bounces off as from one
    block, and keeps the energy. A contact whose gap is open has no impulse in that step. So for shocks that follow one
    another, as in Newton's cradle, leave gaps of ``h v/e``, the travel of one step divided by the coefficient.
    """

    NAME = "restitution"
    PREPARED = ("bias", "friction")

    friction = Parameter("-", "coefficient of friction mu", minimum=0.0, default=0.0)
    restitution = Parameter("-", "coefficient of normal restitution e", minimum=0.0, maximum=1.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, restitution = parameters
        if gap > 0.0:
            return (math.inf, friction)
        return (restitution * min(velocity[0], 0.0), friction)
