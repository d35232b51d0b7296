"""Cohesive contact: Mohr and Coulomb's criterion while the contact is bonded, Coulomb's friction afterwards.

A bonded contact holds a pull of at most c, its adhesion, and slides under a tangential force of mu times what it is
short of it:

    r_n >= -h c,        |r_t| <= mu (r_n + h c),

a cone whose tip lies at the pull c. With s = r_n + h c, and q' = q - h c W n, the free velocity under the pull alone,
u = q' + W (s, r_t), and this is Coulomb's law for (s, r_t):

    0 <= u_n + max(g, 0)/h  _|_  s >= 0,        |r_t| <= mu s, opposing u_t when sliding,

So the local solve is lmgcpy's own for Coulomb's law at q', exact for any W and mu. Where the contact sticks the
impulse is -W^-1 (q + b), in which c does not appear: then it is taken from there, and has all its digits however
large c is.

**Bonds.** A contact is bonded if it is there when the simulation begins, with a gap of at most ``reach``. As long as
the gap stays within ``reach`` the bond pulls with c; beyond, it is lost for good. To break a bond takes the work c
``reach``, as with a cohesive zone of constant traction (Dugdale). Sliding does not break a bond: cohesion is ductile
in shear, as of a clay or a wet sand, and brittle in tension. New contacts are never bonded. LMGC90 knows a law of
this kind as IQS_MOHR_DS_CLB.
"""

from __future__ import annotations

import lmgcpy as lm

coulomb = lm.Coulomb.react


def pulled(W, u, hold):
    """Free velocity with a pull of ``hold`` [N s] on the candidate along -n."""
    if len(u) == 2:
        return (u[0] - hold * W[0][0], u[1] - hold * W[1][0])
    return (u[0] - hold * W[0][0], u[1] - hold * W[1][0], u[2] - hold * W[2][0])


def sticking(W, q_n, q_t):
    """Impulse under which ``q + W r = 0``, two rows."""
    (w_nn, w_nt), (w_tn, w_tt) = W
    determinant = w_nn * w_tt - w_nt * w_tn
    return ((w_nt * q_t - w_tt * q_n) / determinant, (w_tn * q_n - w_nn * q_t) / determinant)


class Cohesive(lm.Law):
    """``0 <= u_n + max(g, 0)/h _|_ r_n + h c >= 0``, ``|r_t| <= mu (r_n + h c)``; c = 0 where the bond is lost."""

    NAME = "cohesive"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "friction", "hold")
    TRAITS = frozenset({"dissipative"})

    adhesion = lm.Parameter("N", "greatest pull c of a bonded contact", minimum=0.0)
    friction = lm.Parameter("-", "coefficient of friction mu", minimum=0.0)
    reach = lm.Parameter("m", "gap beyond which a bond is lost; well above what the solver's tolerance leaves", above=0.0)

    bonded = lm.State("-", "1 where the contact is bonded, else 0")

    def rows(self, dimension: int) -> int:
        """A frictionless contact has one row."""
        return dimension if self.friction > 0.0 else 1

    @staticmethod
    def initial(gap, reference_gap, time, parameters):
        return (1.0 if time == 0.0 and gap <= parameters[2] else 0.0,)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        adhesion, friction, _ = parameters
        return (max(gap, 0.0) / time_step, friction, state[0] * time_step * adhesion)

    @staticmethod
    def react(W, u, prepared):
        bias, friction, hold = prepared
        if len(u) == 1:
            return (max(-hold, -(u[0] + bias) / W[0][0]),)
        free = pulled(W, u, hold)
        if len(u) == 2 and hold > 0.0 and free[0] + bias < 0.0:
            r_n, r_t = sticking(W, u[0] + bias, u[1])
            if r_n >= -hold and abs(r_t) <= friction * (r_n + hold):
                return (r_n, r_t)
        impulse = coulomb(W, free, (bias, friction))
        return (impulse[0] - hold, *impulse[1:])

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return (0.0 if gap + time_step * velocity[0] > parameters[2] else state[0],)

    @staticmethod
    def energy(gap, reference_gap, parameters, state):
        """Work done against the pull so far, ``c max(g, 0)``; a bond that is lost keeps none."""
        adhesion, _, reach = parameters
        return state[0] * adhesion * min(max(gap, 0.0), reach)
