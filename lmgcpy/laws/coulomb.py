"""Unilateral contact with Coulomb friction (Jean 1999), non-associated: sliding does not dilate."""

from __future__ import annotations

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
        return react_in_plane(W, u[0] + bias, u[1], friction)

    @staticmethod
    def conic(prepared):
        return (prepared[0], prepared[1], 0.0)
