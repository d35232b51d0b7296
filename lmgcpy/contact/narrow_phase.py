"""Narrow phase of contacts in 2D: gap, local frame, levers and local block of W of every interaction."""

from __future__ import annotations

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.meeting import FOREIGN, is_sound, meet, normal_sign

CENTRAL = True
"""Whether all contact points lie on the normals through both centres; given by the specialisation."""


def translation_block(n_x, n_y, x, y):
    """``(W_nn, W_tt, W_nt)`` of two bodies that do not turn; ``x``, ``y``: sums of their inverse masses [1/kg]."""
    return n_x * n_x * x + n_y * n_y * y, n_y * n_y * x + n_x * n_x * y, n_x * n_y * (y - x)


@kernel
def detect_contacts(
    pairs, first, first_slot, alert, contactors, body, shapes, stride, bodies, inverse_mass, result: Interactions
):
    """Narrow phase of one group: write interactions from row ``first`` on.

    Returns (row after the last, whether all local blocks of W are diagonal). If the answer of a foreign narrow phase is
    wrong, the first number is ``-1 - p``, p the index of the pair.
    """
    m = first
    diagonal = True
    for p in range(pairs.shape[0]):
        k_c = pairs[p, 0]
        k_a = pairs[p, 1]
        gap, n, (p_x, p_y) = meet(k_c, k_a, contactors, shapes, stride)
        if FOREIGN and not is_sound(gap, n):
            return -1 - p, False
        if gap > alert:
            continue
        n_x = normal_sign() * n[0]
        n_y = normal_sign() * n[1]
        c = body[k_c]
        a = body[k_a]
        inverse_c = inverse_mass[c, 2]
        inverse_a = inverse_mass[a, 2]
        # normal part of the levers, positive from each centre to the contact point: it turns spin into u_t
        arm_c = n_x * (bodies[c, 0] - p_x) + n_y * (bodies[c, 1] - p_y)
        arm_a = n_x * (p_x - bodies[a, 0]) + n_y * (p_y - bodies[a, 1])
        # W = H^T M^-1 H: first the part of the translations, then the part of the levers
        x = inverse_mass[c, 0] + inverse_mass[a, 0]
        y = inverse_mass[c, 1] + inverse_mass[a, 1]
        w_nn, w_tt, w_nt = translation_block(n_x, n_y, x, y)
        w_tt = w_tt + arm_c * arm_c * inverse_c + arm_a * arm_a * inverse_a
        if not CENTRAL:
            # tangential part of the levers: it turns spin into u_n
            lateral_c = n_x * (p_y - bodies[c, 1]) - n_y * (p_x - bodies[c, 0])
            lateral_a = n_x * (p_y - bodies[a, 1]) - n_y * (p_x - bodies[a, 0])
            result.lateral[m, 0] = lateral_c
            result.lateral[m, 1] = lateral_a
            w_nn += lateral_c * lateral_c * inverse_c + lateral_a * lateral_a * inverse_a
            w_nt += arm_c * lateral_c * inverse_c - arm_a * lateral_a * inverse_a
        elif result.lateral.shape[0] > 0:  # other groups need it, and the arrays still hold older values
            result.lateral[m, 0] = 0.0
            result.lateral[m, 1] = 0.0
        if w_nn <= 0.0:  # neither body can move along the normal: no impulse changes anything
            continue
        if w_tt <= 0.0:  # both are held along the tangent: friction moves nothing, and any positive weight gives it
            w_tt = w_nn
        if w_nt != 0.0:
            diagonal = False
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        result.normal[m, 0] = n_x
        result.normal[m, 1] = n_y
        result.arm[m, 0] = arm_c
        result.arm[m, 1] = arm_a
        result.delassus[m, 0] = w_nn
        result.delassus[m, 1] = w_tt
        result.coupling[m] = w_nt
        for k in range(result.weight.shape[1]):  # other groups need them, and the arrays still hold older values
            result.weight[m, k] = 0.0
        result.slot[m] = first_slot + p
        m += 1
    return m, diagonal
