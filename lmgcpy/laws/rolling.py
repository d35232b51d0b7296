"""Unilateral contact with Coulomb friction and rolling friction (Estrada, Taboada, Radjai 2008)."""

from __future__ import annotations

import numpy as np

from lmgcpy.laws.law import ROLLING_ROWS, Law, Parameter
from lmgcpy.laws.rolling_in_space import react_rolling_in_space
from lmgcpy.laws.signorini import approach


def react_rolling_in_plane(W, q, friction, rolling):
    """Impulse (r_n, r_t, r_r) of ``0 <= u_n _|_ r_n >= 0``, ``|r_t| <= mu r_n`` and ``|r_r| <= mu_r r_n``, each opposing
    its velocity if it is at its bound, for ``u = q + W r``.

    Statuses are tried in the order open, sticks and holds, sticks and rolls, slides and holds, slides and rolls. If the
    contact point lies between the centres, r_n does not depend on the other components; these then minimise a strictly
    convex function in a rectangle, and the solution is unique. For any symmetric positive definite W one exists: with
    the bounds frozen at a given s in place of r_n, the problem is convex and its r_n depends continuously on s; r_n is
    ``-q_n / W_nn > 0`` at s = 0 and does not grow with s in the end. If n couples strongly with the other rows, there may
    be several solutions, and the order is the rule that picks one.
    """
    # open: u = q satisfies the law with r = 0
    if q[0] >= 0.0 or W[0][0] <= 0.0:
        return (0.0, 0.0, 0.0)
    best, chosen = status_in_plane(W, q, friction, rolling, 0.0, 0.0)
    # statuses by number: three signs of sliding, three of rolling; 0 is sticks and holds
    for k in range(1, 9):
        if best == 0.0:
            break
        slides = SIGNS[k // 3]
        rolls = SIGNS[k % 3]
        wrong, impulse = status_in_plane(W, q, friction, rolling, slides, rolls)
        # all can fail by round-off; the one that fails by less is kept
        if wrong < best:
            best = wrong
            chosen = impulse
    return chosen


SIGNS = (0.0, 1.0, -1.0)
NEVER = 1e300
"""How wrong a status is that has no impulse."""


def status_in_plane(W, q, friction, rolling, slides, rolls):
    """(violation of a status [m/s], its impulse); the violation is 0 if the status is right.

    ``slides``: 0 for u_t = 0, else the sign of ``r_t = +-mu r_n``; ``rolls``: the same for u_r and r_r. With u_n = 0 there
    are three linear equations.
    """
    (w_nn, w_nt, w_nr), (_, w_tt, w_tr), (_, _, w_rr) = W
    # rows of the equations for t and r: a velocity of zero, or an impulse at its bound
    a, b, c, f = w_nt, w_tt, w_tr, -q[1]
    if slides != 0.0:
        a, b, c, f = -slides * friction, 1.0, 0.0, 0.0
    d, e, g, h = w_nr, w_tr, w_rr, -q[2]
    if rolls != 0.0:
        d, e, g, h = -rolls * rolling, 0.0, 1.0, 0.0
    # Cramer's rule
    minor = b * g - c * e
    determinant = w_nn * minor - w_nt * (a * g - c * d) + w_nr * (a * e - b * d)
    size = w_nn * b * g
    if not determinant > SINGULAR * size:
        return NEVER, (max(0.0, -q[0] / w_nn), 0.0, 0.0)
    r_n = (-q[0] * minor - w_nt * (f * g - c * h) + w_nr * (f * e - b * h)) / determinant
    r_t = (w_nn * (f * g - c * h) + q[0] * (a * g - c * d) + w_nr * (a * h - f * d)) / determinant
    r_r = (w_nn * (b * h - f * e) - w_nt * (a * h - f * d) - q[0] * (a * e - b * d)) / determinant
    if not r_n >= 0.0:
        return NEVER, (0.0, 0.0, 0.0)
    # the impulse is exactly in its cone; violation: velocity along a sliding impulse, or impulse beyond its bound
    if slides != 0.0:
        r_t = slides * friction * r_n
        wrong = max(0.0, slides * (q[1] + w_nt * r_n + w_tt * r_t + w_tr * r_r))
    else:
        within = min(friction * r_n, max(-friction * r_n, r_t))
        wrong = w_tt * abs(r_t - within)
        r_t = within
    if rolls != 0.0:
        r_r = rolls * rolling * r_n
        wrong = max(wrong, rolls * (q[2] + w_nr * r_n + w_tr * r_t + w_rr * r_r))
    else:
        within = min(rolling * r_n, max(-rolling * r_n, r_r))
        wrong = max(wrong, w_rr * abs(r_r - within))
        r_r = within
    return wrong, (r_n, r_t, r_r)


SINGULAR = 1e-14
"""A determinant that is no larger than this part of the product of its diagonal counts as zero."""


class RollingCoulomb(Law):
    """Coulomb friction, and a moment at the contact that opposes the relative spin, up to ``mu_r R r_n``.

    R is the effective radius of the two bodies, ``1/R = 1/R_c + 1/R_a``; at a wall it is the radius of the body. In 2D the
    last row of the interaction is the rolling velocity ``u_r = R (spin_c - spin_a)`` [m/s] with the impulse ``r_r = m / R``
    [N s], m being the moment's impulse on the candidate [N m s]. So ``|m| <= mu_r R r_n`` reads ``|r_r| <= mu_r r_n``, and
    rolling friction is a number without unit, as friction is. On an incline a disk or a sphere at rest starts to roll when
    the tangent of the angle exceeds mu_r, if friction is larger.

    In 3D the rolling velocity ``R (spin_c - spin_a) x n`` is a vector of the tangent plane, rows 4 and 5, and the rolling
    impulse is in the disk of radius ``mu_r r_n``. Row 6 is torsion, ``u_z = R n . (spin_c - spin_a)``, with
    ``|r_z| <= mu_z r_n``. A contact face of radius a, on which the normal force may shift by a, resists rolling up to
    ``a r_n``, so that ``a = mu_r R``; with friction mu and a uniform pressure it resists torsion up to ``2/3 mu a r_n``.
    Hence the default of ``torsion_friction``: ``2/3 mu mu_r``.

    A ball that rolls is slowed down by 2/3 mu_r g and comes to rest:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(0.3, 0.0), spin=-3.0))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.RollingCoulomb(friction=0.5, rolling_friction=0.1))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    >>> ball.position.round(6)
    array([0.0675, 0.1   ])
    """

    NAME = "rolling-coulomb"
    APPLIES_TO = "contact"
    KEEPS_GAP = True
    PREPARED = ("bias", "friction", "rolling_friction", "torsion_friction")
    TRAITS = frozenset({"push", "cone", "dissipative", "rigid"})

    friction = Parameter("-", "coefficient of friction mu", minimum=0.0)
    rolling_friction = Parameter("-", "coefficient of rolling friction mu_r", minimum=0.0)
    torsion_friction = Parameter(
        "-", "coefficient of torsion friction mu_z, 3D only; 2/3 mu mu_r if not given", minimum=0.0, default=None
    )

    def rows(self, dimension: int) -> int:
        """Normal, tangential and rolling components, and torsion in 3D."""
        return ROLLING_ROWS[dimension]

    def table(self, reference_length: np.ndarray) -> np.ndarray:
        """The three coefficients, shape (count, 3)."""
        torsion = self.torsion_friction
        if torsion is None:
            torsion = 2.0 / 3.0 * self.friction * self.rolling_friction
        return np.tile([self.friction, self.rolling_friction, torsion], (len(reference_length), 1))

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, rolling_friction, torsion_friction = parameters
        return (approach(gap, reference_gap, velocity[0], time_step), friction, rolling_friction, torsion_friction)

    @staticmethod
    def react(W, u, prepared):
        bias, friction, rolling, torsion = prepared
        if len(u) == 3:
            return react_rolling_in_plane(W, (u[0] + bias, u[1], u[2]), friction, rolling)
        return react_rolling_in_space(W, (u[0] + bias, u[1], u[2], u[3], u[4], u[5]), friction, rolling, torsion)

    @staticmethod
    def conic(prepared):
        bias, friction, rolling, torsion = prepared
        return (bias, friction, 0.0, rolling, torsion)
