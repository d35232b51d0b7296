"""Unilateral contact without friction (paper, equation 2, as a quasi-inelastic shock)."""

from __future__ import annotations

from lmgcpy.laws.law import Law


def approach(gap, time_step):
    """Velocity that closes an open gap within the step [m/s]; an old penetration is left alone."""
    return max(gap, 0.0) / time_step


class Signorini(Law):
    """``0 <= u_n + max(g, 0)/h  _|_  r_n >= 0``."""

    NAME = "signorini"
    APPLIES_TO = "contact"
    PREPARED = ("bias",)
    TRAITS = frozenset({"push", "dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (approach(gap, time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)
