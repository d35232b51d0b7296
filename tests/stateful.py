"""Laws with an internal state, for tests."""

from __future__ import annotations

import lmgcpy as lm


class Brittle(lm.Law):
    """A rigid wire that breaks for good when its tension passes ``strength``."""

    NAME = "test-brittle"
    APPLIES_TO = "link"
    PREPARED = ("bias", "whole")
    TRAITS = frozenset({"pull"})

    strength = lm.Parameter("N", above=0.0)
    broken = lm.State("-")
    greatest = lm.State("N", "tension so far")

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, 1.0 - state[0])

    @staticmethod
    def react(W, u, prepared):
        bias, whole = prepared
        return (whole * min(0.0, -(u[0] + bias) / W[0][0]),)

    @staticmethod
    def slope(W, u, prepared):
        bias, whole = prepared
        return ((-whole / W[0][0] if u[0] + bias > 0.0 else 0.0,),)

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        broken, greatest = state
        tension = -impulse[0] / time_step
        return (1.0 if tension > parameters[0] else broken, max(greatest, tension))


class Touched(lm.Law):
    """Contact with friction that counts its steps and keeps what ``initial`` and ``commit`` are given."""

    NAME = "test-touched"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "friction")

    friction = lm.Parameter("-", minimum=0.0)
    born = lm.State("s")
    steps = lm.State("-")
    predicted = lm.State("m", "gap")
    pushed = lm.State("N")
    sheared = lm.State("N")

    @staticmethod
    def initial(gap, reference_gap, time, parameters):
        return (time, 0, gap, 0.0, 0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step, parameters[0])

    DIMENSIONS = (2,)
    react = staticmethod(lm.Coulomb.react)

    def rows(self, dimension: int) -> int:
        return dimension

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        pushed, sheared = impulse
        return (state[0], state[1] + 1, gap + time_step * velocity[0], pushed / time_step, sheared / time_step)
