"""A wire of crimped fibres: soft until they are straight, then stiff; implicit, by a Newton iteration in each link.

A wire is a bundle of fibres that are wavy to different degrees. A fibre pulls, linearly, from where it is straight
(Kastelic, Palley and Baer, J. Biomech. 13, 1980; Lanir, J. Biomech. 12, 1979). If the elongation at which a fibre
becomes straight is distributed exponentially with mean d, the stiffness at an elongation e, which is that of the
straight ones, is

    T'(e) = k0 + (k1 - k0) (1 - exp(-e/d)),

k0 of those that are straight from the start, k1 of all. Hence tension and stored energy, for e > 0,

    T(e) = k0 e + (k1 - k0) d R_2(e/d),      E(e) = k0 e^2/2 + (k1 - k0) d^2 R_3(e/d),

with R_n the remainder of the exponential series after n terms,

    R_1 = 1 - exp(-x),      R_2 = exp(-x) - 1 + x,      R_3 = 1 - x + x^2/2 - exp(-x),

each the derivative of the next. For e >> d the wire pulls like a straight one that is longer by the slack
(1 - k0/k1) d. There is no tension for e <= 0.

The local problem, implicit in the elongation e = g + h u_n - g_ref at the end of the step, is r = -h T(e) with
u_n = q + W r. With v = q + (g - g_ref)/h > 0 (else r = 0), s = d/h and x = e/d it reads

    (1 + W A) x + W B R_2(x) = v/s,          A = h^2 k0,  B = h^2 (k1 - k0),

convex and increasing in x: :func:`straightened` solves it.
"""

from __future__ import annotations

import math

import numpy as np

import lmgcpy as lm
from lmgcpy.laws.rigid import pull_back

STEPS = 12
"""Bound on the Newton steps of one solve; five do for any stiffness, the others guard."""


def remainder(x, order):
    """``R_n(x) = (-1)^n (exp(-x) - sum_{j<n} (-x)^j/j!)`` for x >= 0 and n = 1, 2, 3, without cancellation.

    Below 1/2 by its own series ``x^n/n! (1 - x/(n+1) (1 - x/(n+2) (...)))``, of which 16 factors leave 1e-17.
    """
    if x > 0.5:
        if order == 1:
            return -math.expm1(-x)
        if order == 2:
            return x + math.expm1(-x)
        return 0.5 * x * x - (x + math.expm1(-x))
    series = 1.0
    for n in range(order + 16, order, -1):
        series = 1.0 - series * x / n
    for n in range(1, order + 1):
        series *= x / n
    return series


def straightened(load, gain):
    """The x >= 0 with ``x + gain R_2(x) = load``, for load >= 0 and gain >= 0, to round-off.

    ``exp(-x) >= (2 - x)/(2 + x)`` gives ``R_2(x) >= x^2/(2 + x)``, at most an eighth less, and with it a quadratic
    equation whose root is no smaller than x. From there Newton's method comes down to x without passing it, as the
    function is convex; it is over when a step leads up, which only round-off can do.
    """
    b = load - 2.0
    root = math.hypot(b, math.sqrt(8.0 * load * (1.0 + gain)))
    x = 0.5 * (b + root) / (1.0 + gain) if b > 0.0 else 4.0 * load / (root - b)
    for _ in range(STEPS):
        lower = x - (x + gain * remainder(x, 2) - load) / (1.0 + gain * remainder(x, 1))
        if not lower < x:
            break
        x = max(lower, 0.0)
    return x


def tension(elongation, parameters):
    """Tension [N] at an elongation [m], for ``parameters`` (k0 [N/m], k1 - k0 [N/m], d [m]); the quasi-static curve."""
    toe, rise, crimp = parameters
    e = max(elongation, 0.0)
    return toe * e + rise * crimp * remainder(e / crimp, 2)


def elongation(force, parameters):
    """Elongation [m] at a tension [N] >= 0, the inverse of :func:`tension`; needs k0 > 0."""
    toe, rise, crimp = parameters
    return crimp * straightened(force / (toe * crimp), rise / toe)


class HardeningWire(lm.Law):
    """``r_n = -h T(g+ - g_ref)``, g+ = g + h u_n, with a tension T that rises slowly at first and then steeply.

    The stiffness of a link of reference length l0 rises from ``toe_rigidity / l0`` to ``axial_rigidity / l0`` over an
    elongation of the order of ``crimp l0``, so that a wire answers alike however many beads stand for it.
    """

    NAME = "hardening-wire"
    APPLIES_TO = "link"
    PREPARED = ("bias", "toe", "rise", "scale")
    TRAITS = frozenset({"potential", "pull"})

    axial_rigidity = lm.Parameter("N", "force per strain once straight, EA", above=0.0)
    toe_rigidity = lm.Parameter("N", "force per strain at the start, at most axial_rigidity", minimum=0.0)
    crimp = lm.Parameter("-", "mean strain at which a fibre becomes straight", above=0.0)

    def validate(self) -> None:
        if self.toe_rigidity > self.axial_rigidity:
            raise ValueError(
                f"toe_rigidity of law '{self.NAME}' must be at most axial_rigidity, {self.axial_rigidity:g} N, got "
                f"{self.toe_rigidity:g} N: the wire stiffens as its fibres straighten."
            )

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """k0 [N/m], k1 - k0 [N/m] and d [m] of each link, shape (count, 3)."""
        length = np.asarray(reference_length, dtype=float)
        rise = self.axial_rigidity - self.toe_rigidity
        return np.column_stack([self.toe_rigidity / length, rise / length, self.crimp * length])

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        toe, rise, crimp = parameters
        square = time_step * time_step
        return (pull_back(gap, reference_gap, time_step), square * toe, square * rise, crimp / time_step)

    @staticmethod
    def react(W, u, prepared):
        bias, toe, rise, scale = prepared
        speed = u[0] + bias
        if speed <= 0.0:
            return (0.0,)
        inertia = 1.0 + W[0][0] * toe
        x = straightened(speed / scale / inertia, W[0][0] * rise / inertia)
        return (-scale * (toe * x + rise * remainder(x, 2)),)

    @staticmethod
    def slope(W, u, prepared):
        """With K = A + B R_1(x) the derivative of -r by e/h: ``dr/dq = -K/(1 + W K)``, by the implicit function
        theorem."""
        bias, toe, rise, scale = prepared
        speed = u[0] + bias
        if speed <= 0.0:
            return ((0.0,),)
        inertia = 1.0 + W[0][0] * toe
        x = straightened(speed / scale / inertia, W[0][0] * rise / inertia)
        tangent = toe + rise * remainder(x, 1)
        return ((-tangent / (1.0 + W[0][0] * tangent),),)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        toe, rise, crimp = parameters
        e = max(gap - reference_gap, 0.0)
        return 0.5 * toe * e * e + rise * crimp * crimp * remainder(e / crimp, 3)
