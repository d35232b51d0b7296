"""Impact with a coefficient of restitution, and Coulomb friction: no contact ever makes energy.

The work of a contact in a step is ``r . (u^- + u^+)/2``, exactly, whatever else acts on its bodies. With
``phi = max(u_n^-, e u_n^-)``, which is ``e u_n^-`` for a contact that closes and ``u_n^-`` for one that opens, an impulse
r_n > 0 leaves ``u_n^+ = -phi``, and its work is

    r_n (u_n^- - phi)/2 = -(1 - e)/2 r_n max(-u_n^-, 0) <= 0.

So each contact dissipates by itself: for any masses, loads, coefficients side by side, and other laws of the scene.

* With ``e min(u_n^-, 0)`` instead, a contact that opens and is pressed shut by its neighbours ends at ``u_n^+ = 0``, and
  works ``r_n u_n^-/2 > 0``. Bodies wedged between others may even have no solution: for impulses s > 0 that balance each
  other, ``s . u = 0`` for every motion, so that ``u^+ >= -phi`` asks for ``s . phi >= 0``. This holds as ``phi >= u_n^-``
  everywhere.
* Moreau's ``0 <= u_n^+ + e u_n^- _|_ r_n >= 0`` dissipates ``(1 - e)/(2 (1 + e)) r . W r`` in all (no loads, no friction)
  if e is the same everywhere, and may gain if it is not. It is the same law for contacts that close, and for e = 1.

**Overlap that turning made** (``laws/signorini.py``) is taken back at ``|u_n^-|`` at most, as more would make energy. This
is enough if a contact goes round a circle ever faster, ``h |u_n^-| = 2 e - e' >= e``, and too little if it slows down. The
rest is kept, and taken back when the contact is faster again: a ball that swings in a bowl is never deeper than
``e = (h u_t)^2/(2 a)`` of its fastest point. (Without this it sank by half of that in every swing.)

An opening contact that is pressed shut returns at most with the velocity with which it opened: its gap is then as it was
one step before, so that it does not sink.

**Friction.** Coulomb's condition on ``u_t^+`` gains energy if a shock reverses the slip, as off the centre of a rod
(Kane, Levinson 1985: up to 19 %): a contact that sticks has the work ``r_t . u_t^-/2``, of either sign. Here friction
resists only slip that leaves the segment S from ``-u_t^-`` to 0,

    r_t in -mu r_n (subdifferential of the distance to S at u_t^+),

that is, outside of S friction is the whole ``mu r_n`` towards the nearest point of S, and at the ends of S it is as large
as it takes to stay there. As the distance is convex and zero on S, ``r_t . (u_t^+ + u_t^-) <= 0``. If friction resists the
slip before the step, at the end 0, it is Coulomb's, as it always is for a single disk or sphere. If ``u_t^- = 0``, S is the
point 0.

Poisson's law has no such bound: the friction of its second phase may do positive work on the velocity that this phase gives
back.
"""

from __future__ import annotations

import math

import numpy as np

from lmgcpy.laws.coulomb import Coulomb, react_in_plane, react_in_space
from lmgcpy.laws.law import Parameter
from lmgcpy.laws.signorini import taken_back


def resist_in_plane(W, q_n, q_t, before, friction):
    """Impulse (r_n, r_t) of a contact that slipped with ``before``: friction at the end 0 of S, or at the other end
    ``-before``, or no friction between."""
    r_n, r_t = react_in_plane(W, q_n, q_t, friction)
    if r_t * before <= 0.0:
        return (r_n, r_t)
    r_n, r_t = react_in_plane(W, q_n, q_t + before, friction)
    if r_t * before >= 0.0:
        return (r_n, r_t)
    return (max(0.0, -q_n / W[0][0]), 0.0)


def resist_in_space(W, q_n, q_t, q_s, before, friction):
    """The impulse (r_n, r_t, r_s) in space; beside S friction is at right angles to it."""
    b_t, b_s = before
    r_n, r_t, r_s = react_in_space(W, q_n, q_t, q_s, friction)
    if r_t * b_t + r_s * b_s <= 0.0:
        return (r_n, r_t, r_s)
    r_n, r_t, r_s = react_in_space(W, q_n, q_t + b_t, q_s + b_s, friction)
    if r_t * b_t + r_s * b_s >= 0.0:
        return (r_n, r_t, r_s)
    # p: unit tangent at right angles to S; the contact in the plane of n and p
    size = math.hypot(b_t, b_s)
    p_t, p_s = -b_s / size, b_t / size
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    w_np = p_t * w_nt + p_s * w_ns
    w_pp = p_t * p_t * w_tt + 2.0 * p_t * p_s * w_ts + p_s * p_s * w_ss
    r_n, r_p = react_in_plane(((w_nn, w_np), (w_np, w_pp)), q_n, p_t * q_t + p_s * q_s, friction)
    return (r_n, p_t * r_p, p_s * r_p)


class Restitution(Coulomb):
    """If the gap is closed: ``0 <= u_n + max(u_n^-, e u_n^-)  _|_  r_n >= 0`` and friction; else ``r = 0``.

    ``u_n^-`` is the normal velocity at the start of the step. No contact makes energy, in any scene
    (``laws/restitution.py``). Friction is Coulomb's, except in shocks that reverse the slip: then it does not act until the
    contact slips back faster than it slipped before.

    All shocks of a step happen at once: with ``e = 1`` a disk that meets a row of touching disks bounces off as from one
    block, and keeps the energy. A contact whose gap is open has no impulse in that step. So for shocks that follow one
    another, as in Newton's cradle, leave gaps of ``h v/e``, the travel of one step divided by the coefficient.

    ``conic`` has plain Coulomb friction. Newton steps resist the end of S at which the impulses are when they start, and no
    slip between the ends; this law decides whether a step is solved.

    A ball leaves a wall with half of its speed:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2)
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.15), mass=1.0, velocity=(0.0, -2.0)))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Restitution(restitution=0.5))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.1)
    >>> ball.velocity
    array([0., 1.])
    """

    NAME = "restitution"
    TAKES_BACK_LATER = True
    PREPARED = ("bias", "friction", "slip_t", "slip_s")

    friction = Parameter("-", "coefficient of friction mu", minimum=0.0, default=0.0)
    restitution = Parameter("-", "coefficient of normal restitution e", minimum=0.0, maximum=1.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, restitution = parameters
        normal = velocity[0]
        slip_t = velocity[1] if len(velocity) > 1 else 0.0
        slip_s = velocity[2] if len(velocity) > 2 else 0.0
        if gap > 0.0:
            return (math.inf, friction, slip_t, slip_s)
        # phi, or less if turning closed the gap, but not below u_n^-
        back = taken_back(gap, reference_gap, normal, time_step)
        return (max(normal, min(restitution * normal, -back)), friction, slip_t, slip_s)

    @staticmethod
    def react(W, u, prepared):
        bias, friction, slip_t, slip_s = prepared
        if len(u) == 1:
            return (max(0.0, -(u[0] + bias) / W[0][0]),)
        if len(u) == 2:
            return resist_in_plane(W, u[0] + bias, u[1], slip_t, friction)
        return resist_in_space(W, u[0] + bias, u[1], u[2], (slip_t, slip_s), friction)

    @staticmethod
    def conic(prepared):
        return (prepared[0], prepared[1], 0.0)

    @staticmethod
    def resisted(prepared, a, w):
        _, friction, slip_t, slip_s = prepared
        slip = np.array([slip_t, slip_s])[: len(a) - 1]
        along = (a[1:] * slip).sum(axis=0)  # Coulomb's friction at the end 0 works along the slip if this is positive
        beyond = along * w >= (slip * slip).sum(axis=0)  # and at the other end it does not, from here on
        return (np.where((along > 0.0) & ~beyond, 0.0, friction), np.where((along > 0.0) & beyond, slip, 0.0))
