"""Unilateral contact without friction (paper, equation 2, as a quasi-inelastic shock).

**Overlap that turning made.** The gap is linear in the velocities only to first order. A contact that moves by ``h u_t``
along a path of radius a, as a ball in a pipe, ends the step ``e = (h u_t)^2/(2 a)`` below the gap that its law predicted.
If this overlap were kept, as an overlap of the start is, the ball would sink by e at every step, without bound. So the
next step takes it back, ``u_n >= e/h``, as rigid links do with their stretch.

On a circle ``u_n^- = e'/h - 2 e/h``, if the step before took back e'. With ``r u`` at the mean velocity the work is

    r (u_n^- + u_n^+)/2 = r (e' - e)/(2 h)

so that steady motion makes no energy and loses none (a law that leaves e alone takes ``r e/h`` a step: the ball slows down
in first order). The speed ``e/h`` is bounded by twice the closing speed of the contact, a bound that it never exceeds on a
circle: so a gap that jumps for another reason does not throw bodies out.
"""

from __future__ import annotations

from lmgcpy.laws.law import Law


def taken_back(gap, reference_gap, normal_velocity, time_step):
    """Velocity [m/s] that takes back the overlap that turning made in the last step, ``(g_ref - g)/h``, at most
    ``2 |u_n^-|``; ``g_ref``: the gap that the last step predicted, at most 0."""
    return max(0.0, min((reference_gap - gap) / time_step, -2.0 * normal_velocity))


def approach(gap, reference_gap, normal_velocity, time_step):
    """Velocity bias [m/s]: it closes an open gap within the step, or takes back the overlap that turning made; an older
    overlap is kept."""
    return gap / time_step if gap > 0.0 else -taken_back(gap, reference_gap, normal_velocity, time_step)


class Signorini(Law):
    """``0 <= u_n + b  _|_  r_n >= 0``, with ``b = g/h`` if ``g > 0``; else b takes back the overlap that turning made.

    A ball that slides on a floor without friction is not slowed down:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(1.0, 0.0)))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Signorini())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    >>> ball.position.round(12), ball.spin
    (array([0.5, 0.1]), 0.0)
    """

    NAME = "signorini"
    APPLIES_TO = "contact"
    KEEPS_GAP = True
    PREPARED = ("bias",)
    TRAITS = frozenset({"push", "dissipative", "rigid"})

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (approach(gap, reference_gap, velocity[0], time_step),)

    @staticmethod
    def react(W, u, prepared):
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)

    @staticmethod
    def conic(prepared):
        return (prepared[0], 0.0, 0.0)
