"""Unilateral contact with Coulomb friction (Jean 1999), non-associated: sliding does not dilate."""

from __future__ import annotations

import math

from lmgcpy.laws.law import Law, Parameter
from lmgcpy.laws.signorini import approach


def react_in_plane(W, q_n, q_t, friction):
    """Impulse (r_n, r_t) of ``0 <= u_n _|_ r_n >= 0``, ``|r_t| <= mu r_n``, opposing ``u_t``, for ``u = q + W r``.

    Statuses are tried in the order open, stick, slide. For a symmetric positive definite ``W`` a solution exists; with
    strong coupling, ``mu |W_nt| > W_nn``, there may be several, and this order is the rule that picks one.
    """
    (w_nn, w_nt), (w_tn, w_tt) = W
    if q_n >= 0.0:
        return (0.0, 0.0)
    if w_nt == 0.0 and w_tn == 0.0:
        r_n = -q_n / w_nn
        limit = friction * r_n
        return (r_n, min(limit, max(-limit, -q_t / w_tt)))
    determinant = w_nn * w_tt - w_nt * w_tn
    r_n = (w_nt * q_t - w_tt * q_n) / determinant
    r_t = (w_tn * q_n - w_nn * q_t) / determinant
    if r_n >= 0.0 and abs(r_t) <= friction * r_n:
        return (r_n, r_t)
    # Sliding with r_t = side mu r_n, u_n = 0, and u_t on the other side. Both sides fail by round-off only: then the
    # one that fails by less is taken.
    best = -1.0
    chosen = (0.0, 0.0)
    for side in (1.0, -1.0):
        slope = w_nn + side * friction * w_nt
        if slope > 0.0:
            normal = -q_n / slope
            wrong = max(side * (q_t + (w_tn + side * friction * w_tt) * normal), 0.0)
            if best < 0.0 or wrong < best:
                best = wrong
                chosen = (normal, side * friction * normal)
    return chosen


def slide_at(slowness, w_nn, q_n, coupling, shear, free):
    """``(|r_t|, r_n, r_t)`` of a contact that slides with ``u_n = 0`` and ``u_t = -slowness r_t``.

    ``coupling``: (W_nt, W_ns); ``shear``: (S_tt, S_ts, S_ss), what is left of W once r_n is eliminated; ``free``: q_t
    likewise. Then ``(S + slowness I) r_t = -free`` and ``r_n = -(q_n + W_nt . r_t)/W_nn``.
    """
    a = shear[0] + slowness
    b = shear[2] + slowness
    determinant = a * b - shear[1] * shear[1]
    r_t = (shear[1] * free[1] - b * free[0]) / determinant
    r_s = (shear[1] * free[0] - a * free[1]) / determinant
    r_n = -(q_n + coupling[0] * r_t + coupling[1] * r_s) / w_nn
    return math.sqrt(r_t * r_t + r_s * r_s), r_n, r_t, r_s


def react_in_space(W, q_n, q_t, q_s, friction):
    """Impulse (r_n, r_t, r_s) of ``0 <= u_n _|_ r_n >= 0``, ``|r_t| <= mu r_n``, opposing ``u_t``, for ``u = q + W r``."""
    if q_n >= 0.0:
        return (0.0, 0.0, 0.0)
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    if w_nt == 0.0 and w_ns == 0.0 and w_ts == 0.0 and w_tt == w_ss:
        r_n = -q_n / w_nn
        limit = friction * r_n
        length = math.sqrt(q_t * q_t + q_s * q_s) / w_tt
        factor = -1.0 / w_tt if length <= limit else -limit / (length * w_tt)
        return (r_n, factor * q_t, factor * q_s)
    return react_to_full_block(W, q_n, q_t, q_s, friction)


def react_to_full_block(W, q_n, q_t, q_s, friction):
    """The same for ``q_n < 0`` and any symmetric positive definite block; a function of its own, so that the compiler can
    make :func:`react_in_space` part of the sweep.

    Statuses are tried in the order open, stick, slide. A contact that slides has ``u_t = -l r_t``, l > 0: as l grows from
    0, where it sticks, ``|r_t| - mu r_n`` goes from above zero to ``mu q_n / W_nn < 0``, so that for every block there is a
    root, by regula falsi in a bracket. Where W couples n strongly with t there may be several; the bracket's is taken.
    """
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    coupling = (w_nt, w_ns)
    shear = (w_tt - w_nt * w_nt / w_nn, w_ts - w_nt * w_ns / w_nn, w_ss - w_ns * w_ns / w_nn)
    free = (q_t - w_nt * q_n / w_nn, q_s - w_ns * q_n / w_nn)
    size, r_n, r_t, r_s = slide_at(0.0, w_nn, q_n, coupling, shear, free)
    if size <= friction * r_n:
        return (r_n, r_t, r_s)
    low = 0.0
    above = size - friction * r_n
    high = w_tt + w_ss
    size, r_n, r_t, r_s = slide_at(high, w_nn, q_n, coupling, shear, free)
    below = size - friction * r_n
    for _ in range(200):  # doublings; one or two where friction is not nearly zero
        if below <= 0.0:
            break
        low = high
        above = below
        high *= 4.0
        size, r_n, r_t, r_s = slide_at(high, w_nn, q_n, coupling, shear, free)
        below = size - friction * r_n
    side = 0
    for _ in range(200):
        # regula falsi that halves the end which stays (Illinois), a bisection where that does not shrink the bracket
        middle = (low * below - high * above) / (below - above)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        size, r_n, r_t, r_s = slide_at(middle, w_nn, q_n, coupling, shear, free)
        there = size - friction * r_n
        if abs(there) <= 4e-16 * (size + abs(friction * r_n)) or high - low <= 4e-16 * high:
            break
        if there > 0.0:
            low = middle
            above = there
            if side == 1:
                below *= 0.5
            side = 1
        else:
            high = middle
            below = there
            if side == -1:
                above *= 0.5
            side = -1
    if r_n <= 0.0:
        return (0.0, 0.0, 0.0)
    limit = friction * r_n
    factor = limit / size if size > 0.0 else 0.0  # on the cone to the last digit
    return (r_n, factor * r_t, factor * r_s)


class Coulomb(Law):
    """Signorini's condition, and ``r_t`` in the disk of radius ``mu r_n``, opposing ``u_t`` when sliding."""

    NAME = "coulomb"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "friction")
    TRAITS = frozenset({"push", "cone", "dissipative", "rigid"})

    friction = Parameter("-", "coefficient of friction mu", minimum=0.0)

    def rows(self, dimension: int) -> int:
        """A frictionless contact has one row."""
        return dimension if self.friction > 0.0 else 1

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        (friction,) = parameters
        return (approach(gap, time_step), friction)

    @staticmethod
    def react(W, u, prepared):
        bias, friction = prepared
        if len(u) == 1:
            return (max(0.0, -(u[0] + bias) / W[0][0]),)
        if len(u) == 2:
            return react_in_plane(W, u[0] + bias, u[1], friction)
        return react_in_space(W, u[0] + bias, u[1], u[2], friction)

    @staticmethod
    def conic(prepared):
        return (prepared[0], prepared[1], 0.0)
