"""Laws that are wrong on purpose, each in one way, beside the sound law that it spoils."""

from __future__ import annotations

import math

import numpy as np

import lmgcpy as lm

coulomb = lm.Coulomb.react

# ---------------------------------------------------------------------------------------------------------- contacts


class Dilating(lm.Law):
    """Associated friction: exact, in its cone, dissipative, but a contact that slides parts at ``u_n = mu |u_t|``."""

    NAME = "test-dilating"
    APPLIES_TO = "contact"
    DIMENSIONS = (2,)
    PREPARED = ("bias", "friction")
    TRAITS = frozenset({"push", "cone", "dissipative"})

    friction = lm.Parameter("-", minimum=0.0)

    def rows(self, dimension: int) -> int:
        return dimension

    prepare = staticmethod(lm.Coulomb.prepare)

    @staticmethod
    def react(W, u, prepared):
        """The impulse of least ``r . W r / 2 + r . u`` in the cone: inside, on one of its edges, or none."""
        bias, friction = prepared
        (w_nn, w_nt), (_, w_tt) = W
        q_n, q_t = u[0] + bias, u[1]
        determinant = w_nn * w_tt - w_nt * w_nt
        r_n = (w_nt * q_t - w_tt * q_n) / determinant
        r_t = (w_nt * q_n - w_nn * q_t) / determinant
        if r_n >= 0.0 and abs(r_t) <= friction * r_n:
            return (r_n, r_t)
        least = 0.0
        chosen = (0.0, 0.0)
        for slope in (friction, -friction):
            curvature = w_nn + 2.0 * slope * w_nt + slope * slope * w_tt
            along = -(q_n + slope * q_t) / curvature
            if along > 0.0 and -0.5 * curvature * along * along < least:
                least = -0.5 * curvature * along * along
                chosen = (along, slope * along)
        return chosen


class Bouncing(lm.Restitution):
    """Restitution beyond one: an impact gives energy."""

    NAME = "test-bouncing"
    restitution = lm.Parameter("-", minimum=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, restitution = parameters
        return (math.inf if gap > 0.0 else restitution * min(velocity[0], 0.0), friction, 0.0, 0.0)


class NoNumberAtZero(lm.Signorini):
    """The bias of a closed gap is none."""

    NAME = "test-no-number"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        share = math.nan if gap == 0.0 else max(gap, 0.0) / gap
        return (share * gap / time_step,)


class DividingByGap(lm.Signorini):
    """Python raises at a gap of zero."""

    NAME = "test-dividing"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / gap * gap / time_step,)


CALLS = [0.0]


class Counting(lm.Signorini):
    """Wears down with every call of react, in a global list."""

    NAME = "test-counting"
    TRAITS = frozenset({"push"})

    @staticmethod
    def react(W, u, prepared):
        CALLS[0] += 1.0
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]) / (1.0 + 1e-3 * CALLS[0]),)


class Scattered(lm.ElasticRod):
    """A stiffness with scatter from a generator without a seed: another one at each call of table."""

    NAME = "test-scattered"

    def table(self, reference_length):
        return super().table(reference_length) * np.random.default_rng().uniform(0.9, 1.1, (len(reference_length), 1))


class BeyondItsCone(lm.Coulomb):
    """Holds with a tenth more than its friction."""

    NAME = "test-beyond"

    @staticmethod
    def react(W, u, prepared):
        return coulomb(W, u, (prepared[0], 1.1 * prepared[1]))


class OneWay(lm.Coulomb):
    """Slides more easily to the left."""

    NAME = "test-one-way"
    conic = None

    @staticmethod
    def react(W, u, prepared):
        bias, friction = prepared
        if len(u) == 1:
            return coulomb(W, u, prepared)
        either = coulomb(W, u, prepared)
        return either if either[1] >= 0.0 else coulomb(W, u, (bias, 0.5 * friction))


class Boxed(lm.Coulomb):
    """Bounds the components of the friction one by one: it holds better along the diagonals of its frame."""

    NAME = "test-boxed"
    DIMENSIONS = (3,)

    @staticmethod
    def react(W, u, prepared):
        if len(u) == 1:
            return coulomb(W, u, prepared)
        (normal,) = coulomb(((W[0][0],),), (u[0],), prepared)
        limit = prepared[1] * normal
        return (normal, min(limit, max(-limit, -u[1] / W[1][1])), min(limit, max(-limit, -u[2] / W[2][2])))


class DiagonalOnly(lm.Coulomb):
    """Solves as if W did not couple normal and tangent."""

    NAME = "test-diagonal"
    DIMENSIONS = (2,)

    @staticmethod
    def react(W, u, prepared):
        if len(u) == 1:
            return coulomb(W, u, prepared)
        return coulomb(((W[0][0], 0.0), (0.0, W[1][1])), u, prepared)


class Hesitating(lm.Signorini):
    """Gives nine tenths of the impulse, as an iteration that was ended early."""

    NAME = "test-hesitating"
    conic = None

    @staticmethod
    def react(W, u, prepared):
        return (0.9 * max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


class HiddenLength(lm.Signorini):
    """Touches at a micrometre, which is none in other units."""

    NAME = "test-hidden-length"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap - 1e-6, 0.0) / time_step,)


class Pulling(lm.Signorini):
    """Sticks, but declares that it pushes."""

    NAME = "test-pulling"
    conic = None

    @staticmethod
    def react(W, u, prepared):
        return (-(u[0] + prepared[0]) / W[0][0],)


class FarReaching(lm.Law):
    """Pulls at a distance that it does not declare."""

    NAME = "test-far-reaching"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "hold")

    strength = lm.Parameter("N", above=0.0)
    length = lm.Parameter("m", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        strength, length = parameters
        return (max(gap, 0.0) / time_step, time_step * strength if gap <= length else 0.0)

    @staticmethod
    def react(W, u, prepared):
        bias, hold = prepared
        return (max(-hold, -(u[0] + bias) / W[0][0]),)


class Uncompilable(lm.Signorini):
    """Asks max for a key, which Python knows and numba does not."""

    NAME = "test-uncompilable"

    @staticmethod
    def react(W, u, prepared):
        return (max((0.0, -(u[0] + prepared[0]) / W[0][0]), key=lambda impulse: impulse),)


class Overflowing(lm.Signorini):
    """Counts in whole numbers, which are of any size in Python and of 64 bits compiled."""

    NAME = "test-overflowing"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        large = 2
        for _ in range(7):
            large *= large
        return (max(gap, 0.0) / time_step * (large / 2.0**128),)


# ------------------------------------------------------------------------------------------------------------- links


class PushingWire(lm.RigidWire):
    """A wire that pushes when it is slack."""

    NAME = "test-pushing"
    react = staticmethod(lm.RigidRod.react)
    slope = staticmethod(lm.RigidRod.slope)


class WrongPowerOfStep(lm.ElasticRod):
    """Compliance 1/(h k) instead of 1/(h^2 k)."""

    NAME = "test-wrong-power"
    TRAITS = frozenset()

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, 1.0 / (time_step * parameters[0]))


class ForceForImpulse(lm.RigidWire):
    """Yields at a strength [N] that it compares with an impulse [N s]."""

    NAME = "test-force-for-impulse"
    PREPARED = ("bias", "strength")
    TRAITS = frozenset({"pull"})
    conic = None
    slope = None

    strength = lm.Parameter("N", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, parameters[0])

    @staticmethod
    def react(W, u, prepared):
        return (-min(max((u[0] + prepared[0]) / W[0][0], 0.0), prepared[1]),)


class UnreadableUnit(lm.ElasticRod):
    """A stiffness in kilopounds per furlong."""

    NAME = "test-unreadable"
    stiffness = lm.Parameter("kip/furlong", above=0.0)
    axial_rigidity = lm.Parameter("N", above=0.0, default=None)


class WrongSlope(lm.ElasticWire):
    """The slope of the rigid wire."""

    NAME = "test-wrong-slope"
    slope = staticmethod(lm.RigidWire.slope)


class SlopeOverTheKink(lm.ElasticWire):
    """Right but at the kink, where it is twice that of either side."""

    NAME = "test-kink-slope"

    @staticmethod
    def slope(W, u, prepared):
        stretch = u[0] + prepared[0]
        if abs(stretch) <= 1e-12 * (abs(u[0]) + abs(prepared[0])):
            return ((-2.0 / (W[0][0] + prepared[1]),),)
        return ((-1.0 / (W[0][0] + prepared[1]) if stretch > 0.0 else 0.0,),)


class WrongEnergy(lm.ElasticRod):
    """Without the half."""

    NAME = "test-wrong-energy"

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        return parameters[0] * (gap - reference_gap) ** 2


class Driving(lm.Law):
    """Pulls the more the faster it goes, and declares that it takes energy."""

    NAME = "test-driving"
    APPLIES_TO = "link"
    PREPARED = ("bias", "drive")
    TRAITS = frozenset({"dissipative"})

    force = lm.Parameter("N", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, time_step * parameters[0])

    @staticmethod
    def react(W, u, prepared):
        return (prepared[1],)


class CompliantRigid(lm.ElasticRod):
    """Elastic, and declares that it is rigid."""

    NAME = "test-compliant"
    TRAITS = frozenset({"rigid"})


class WrongConic(lm.ElasticWire):
    """A conic form without the compliance."""

    NAME = "test-wrong-conic"

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)


class Forgetful(lm.RigidWire):
    """Two states, of which commit gives one."""

    NAME = "test-forgetful"

    longest = lm.State("m")
    shortest = lm.State("m")

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return (max(state[0], gap),)


class DivergingState(lm.RigidWire):
    """A state that is infinite after a step at rest."""

    NAME = "test-diverging"

    rate = lm.State("1/s")

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return (math.inf if impulse[0] == 0.0 else state[0],)


class Overshooting(lm.RigidRod):
    """Answers with two and a half times what is right, so that links that share a bead never settle."""

    NAME = "test-overshooting"
    TRAITS = frozenset()
    conic = None

    @staticmethod
    def react(W, u, prepared):
        return (-2.5 * (u[0] + prepared[0]) / W[0][0],)

    @staticmethod
    def slope(W, u, prepared):
        return ((-2.5 / W[0][0],),)


class StressAsForce(lm.RigidWire):
    """Yields at a stress [Pa] as if it were a force, neither in space nor in the plane."""

    NAME = "test-stress-as-force"
    PREPARED = ("bias", "hold")
    TRAITS = frozenset({"pull"})
    conic = None
    slope = None

    stress = lm.Parameter("Pa", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, time_step * parameters[0])

    react = staticmethod(ForceForImpulse.react)
