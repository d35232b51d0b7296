"""Links of fixed and of greatest length: the paper's rigid rod and rigid wire (section 2.2).

Both laws use the predicted elongation ``g + h u_n - g_ref``, not the velocity alone. With ``u_n = 0`` the length of a rod
would drift; with the bias its error stays of second order in the step.
"""

from __future__ import annotations

from lmgcpy.laws.law import Law


def pull_back(gap, reference_gap, time_step):
    """Velocity bias ``(g - g_ref)/h`` [m/s]: with ``u_n = -bias`` the link ends the step at its reference."""
    return (gap - reference_gap) / time_step


class RigidRod(Law):
    """``u_n + (g - g_ref)/h = 0``: tension or compression keeps the distance."""

    NAME = "rigid-rod"
    APPLIES_TO = "link"
    PREPARED = ("bias",)
    TRAITS = frozenset({"dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (pull_back(gap, reference_gap, time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (-(u[0] + prepared[0]) / W[0][0],)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / W[0][0],),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)


class RigidWire(Law):
    """``0 <= -(u_n + (g - g_ref)/h)  _|_  -r_n >= 0``: slack below the reference gap, inextensible at it."""

    NAME = "rigid-wire"
    APPLIES_TO = "link"
    PREPARED = ("bias",)
    TRAITS = frozenset({"pull", "dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (pull_back(gap, reference_gap, time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (min(0.0, -(u[0] + prepared[0]) / W[0][0]),)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / W[0][0] if u[0] + prepared[0] > 0.0 else 0.0,),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)
