"""Laws that are right, each in a way that a clumsy test would take for wrong."""

from __future__ import annotations

import lmgcpy as lm
from lmgcpy.laws.coulomb import react_in_plane


class Softening(lm.Law):
    """A reversible wire whose tension rises to ``k a`` at an elongation a, and falls to none at b > a.

    At a large W, ``h^2 k a W > b - a``, there are several answers; the stiffest one is taken.
    """

    NAME = "test-softening"
    APPLIES_TO = "link"
    PREPARED = ("elongation_rate", "time_step", "stiffness", "peak", "end")
    TRAITS = frozenset({"pull", "potential"})

    stiffness = lm.Parameter("N/m", above=0.0)
    peak = lm.Parameter("m", above=0.0)
    end = lm.Parameter("m", above=0.0)

    def validate(self) -> None:
        if self.end <= 1.1 * self.peak:
            raise ValueError("end must be beyond peak")

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        stiffness, peak, end = parameters
        return ((gap - reference_gap) / time_step, time_step, stiffness, peak, end)

    @staticmethod
    def react(W, u, prepared):
        rate, h, stiffness, peak, end = prepared
        elongation = h * (u[0] + rate)
        c = W[0][0] * h * h * stiffness
        if elongation <= 0.0 or elongation >= max(end, (1.0 + c) * peak):
            return (0.0,)
        if elongation <= (1.0 + c) * peak:
            return (-h * stiffness * elongation / (1.0 + c),)
        fall = c * peak / (end - peak)
        return (-h * stiffness * peak * (end - elongation) / (end - peak) / (1.0 - fall),)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        stiffness, peak, end = parameters
        elongation = min(max(gap - reference_gap, 0.0), end)
        rising = min(elongation, peak)
        beyond = max(elongation, peak) - peak
        return 0.5 * stiffness * (rising * rising + peak * beyond * (2.0 - beyond / (end - peak)))


class TangentialSpring(lm.Law):
    """Rigid contact with friction through a spring: what it keeps turns round with the tangent."""

    NAME = "test-tangential-spring"
    APPLIES_TO = "contact"
    DIMENSIONS = (2,)
    PREPARED = ("bias", "friction", "stretch_rate", "compliance")
    TRAITS = frozenset({"push", "cone"})

    friction = lm.Parameter("-", above=0.0)
    stiffness = lm.Parameter("N/m", above=0.0)
    stretch = lm.State("m", "of the spring")

    def rows(self, dimension: int) -> int:
        return dimension

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, stiffness = parameters
        compliance = 1.0 / (time_step * time_step * stiffness)
        return (max(gap, 0.0) / time_step, friction, state[0] / time_step, compliance)

    @staticmethod
    def react(W, u, prepared):
        bias, friction, stretch_rate, compliance = prepared
        softer = (W[0], (W[1][0], W[1][1] + compliance))
        return react_in_plane(softer, u[0] + bias, u[1] + stretch_rate, friction)

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return (-impulse[1] / (time_step * parameters[1]),)


class Hertz(lm.Law):
    """``r_n = h K max(-g+, 0)^1.5``, by iteration."""

    NAME = "test-hertz"
    APPLIES_TO = "contact"
    PREPARED = ("gap", "time_step", "modulus")
    TRAITS = frozenset({"push", "potential"})

    modulus = lm.Parameter("N/m^1.5", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (gap, time_step, parameters[0])

    @staticmethod
    def react(W, u, prepared):
        gap, h, modulus = prepared
        depth = -(gap + h * u[0])
        if depth <= 0.0:
            return (0.0,)
        c = W[0][0] * h * h * modulus
        root = min(depth**0.5, (depth / c) ** (1.0 / 3.0))  # of the depth with the impulse, from above
        for _ in range(100):
            step = (root * root * (1.0 + c * root) - depth) / (root * (2.0 + 3.0 * c * root))
            root -= step
            if abs(step) <= 1e-16 * root:
                break
        return (h * modulus * root**3,)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        return 0.4 * parameters[0] * max(-gap, 0.0) ** 2.5


class Yielding(lm.Law):
    """An elastic wire that yields at a stress over a cross-section, and keeps its plastic length."""

    NAME = "test-yielding"
    APPLIES_TO = "link"
    PREPARED = ("bias", "compliance", "hold")
    TRAITS = frozenset({"pull"})

    stiffness = lm.Parameter("N/m", above=0.0)
    stress = lm.Parameter("Pa", above=0.0)
    section = lm.Parameter("m^2", above=0.0)
    plastic = lm.State("m", "elongation")

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        stiffness, stress, section = parameters
        bias = (gap - reference_gap - state[0]) / time_step
        return (bias, 1.0 / (time_step * time_step * stiffness), time_step * stress * section)

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
        stiffness, stress, section = parameters
        elongation = gap + time_step * velocity[0] - reference_gap
        return (max(state[0], elongation - stress * section / stiffness),)


class Gluey(lm.Law):
    """Holds closed contacts by a stress over a length: a force per metre of depth."""

    NAME = "test-gluey"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "hold")

    stress = lm.Parameter("Pa", minimum=0.0)
    length = lm.Parameter("m", minimum=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        stress, length = parameters
        return (max(gap, 0.0) / time_step, stress * length * time_step if gap <= 0.0 else 0.0)

    @staticmethod
    def react(W, u, prepared):
        bias, hold = prepared
        return (max(-hold, -(u[0] + bias) / W[0][0]),)
