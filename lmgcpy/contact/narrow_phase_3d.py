"""Narrow phase of contacts in 3D: gap, local frame, levers and local block of W of every interaction.

If CENTRAL, contact points lie on the line along the normal through both centres; otherwise bodies turn, with spins along
their own axes, and levers are those of the form ``lever_in_space``. :func:`lmgcpy.contact.frames.tangent_of` gives the
tangent.
"""

from __future__ import annotations

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.frames import cross, tangent_of
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.meeting import FOREIGN, is_sound, meet, normal_sign
from lmgcpy.contact.positions import quaternion_of, turned_back

CENTRAL = True
"""Whether all contact points lie on the normals through both centres; given by the specialisation."""


def weighted(x, diagonal, y):
    """``x . D y`` with a diagonal matrix D."""
    return x[0] * diagonal[0] * y[0] + x[1] * diagonal[1] * y[1] + x[2] * diagonal[2] * y[2]


def moves(c, a, inverse_mass):
    """Diagonal of the mobility of two bodies under a force between them, along x, y, z [1/kg]."""
    return (
        inverse_mass[c, 0] + inverse_mass[a, 0],
        inverse_mass[c, 1] + inverse_mass[a, 1],
        inverse_mass[c, 2] + inverse_mass[a, 2],
    )


def turns(c, a, arm_c, arm_a, inverse_mass):
    """Diagonal of the mobility of their rotation about x, y, z, times the levers squared [1/kg]."""
    square_c = arm_c * arm_c
    square_a = arm_a * arm_a
    return (
        square_c * inverse_mass[c, 3] + square_a * inverse_mass[a, 3],
        square_c * inverse_mass[c, 4] + square_a * inverse_mass[a, 4],
        square_c * inverse_mass[c, 5] + square_a * inverse_mass[a, 5],
    )


def local_block(n, t, moving, turning):
    """The local block of W: its diagonal, W_nt, (W_ns, W_ts), and whether it is diagonal.

    With masses and inertias that are the same in all directions it is ``diag(w, w + l, w + l)``, l the part of rotation.

    The arguments are numbers, not the arrays of :class:`Interactions`: these are a hundred words, which the compiler pushed
    on the stack at every interaction, at twice the cost of all the rest.
    """
    if moving[0] == moving[1] == moving[2] and turning[0] == turning[1] == turning[2]:
        w = moving[0]
        return (w, w + turning[0], w + turning[0]), 0.0, (0.0, 0.0), True
    s = cross(n, t)
    # diagonal: an impulse along t turns about s, and one along s about t
    w_nn = weighted(n, moving, n)
    w_tt = weighted(t, moving, t) + weighted(s, turning, s)
    w_ss = weighted(s, moving, s) + weighted(t, turning, t)
    if w_tt <= 0.0:  # both are held along a tangent: friction moves nothing, and any positive weight gives it
        w_tt = w_nn
    if w_ss <= 0.0:
        w_ss = w_nn
    # W_nt, W_ns, W_ts: a lever along n turns spin into no u_n
    w_nt = weighted(n, moving, t)
    w_ns = weighted(n, moving, s)
    w_ts = weighted(t, moving, s) - weighted(s, turning, t)
    return (w_nn, w_tt, w_ss), w_nt, (w_ns, w_ts), False


def times(x, v):
    """``x v``."""
    return x * v[0], x * v[1], x * v[2]


def seen_from(b, bodies, point):
    """The point as seen from the centre of body ``b``, along the axes of space."""
    return point[0] - bodies[b, 0], point[1] - bodies[b, 1], point[2] - bodies[b, 2]


def write_levers(i, lever_c, lever_a, lever):
    for k in range(3):
        lever[i, k] = lever_c[k]
        lever[i, 3 + k] = lever_a[k]


def turned_block(block, coupling, lever, frame, q, easy):
    """A local block of W, its diagonal and (W_nt, W_ns, W_ts), with the part of the spin of one body: ``m . I^-1 m'`` for
    the moments m of unit forces along the axes of the local frame, in the axes of the body with the quaternion ``q``.
    ``easy``: its inverse inertias."""
    w_nn, w_tt, w_ss = block
    w_nt, w_ns, w_ts = coupling
    n, t, s = frame
    m_n = turned_back(q, cross(lever, n))
    m_t = turned_back(q, cross(lever, t))
    m_s = turned_back(q, cross(lever, s))
    diagonal = (w_nn + weighted(m_n, easy, m_n), w_tt + weighted(m_t, easy, m_t), w_ss + weighted(m_s, easy, m_s))
    return diagonal, (w_nt + weighted(m_n, easy, m_t), w_ns + weighted(m_n, easy, m_s), w_ts + weighted(m_t, easy, m_s))


ROUNDED = 64.0 * 2.0**-104
"""Part of ``|l|^2 / I`` that rounding makes of a moment that is zero, eight roundings of its square."""


def rounding_of(lever, easy):
    """By how much rounding of a lever may make W_nn larger than zero [1/kg]; ``easy``: inverse inertias."""
    return ROUNDED * (lever[0] * lever[0] + lever[1] * lever[1] + lever[2] * lever[2]) * max(easy[0], easy[1], easy[2])


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
        gap, n, (p_x, p_y, p_z) = meet(k_c, k_a, contactors, shapes, stride)
        if FOREIGN and not is_sound(gap, n):
            return -1 - p, False
        if gap > alert:
            continue
        n_x = normal_sign() * n[0]
        n_y = normal_sign() * n[1]
        n_z = normal_sign() * n[2]
        c = body[k_c]
        a = body[k_a]
        # levers along n, positive from each centre to the contact point: they turn spin into u_t and u_s
        arm_c = n_x * (bodies[c, 0] - p_x) + n_y * (bodies[c, 1] - p_y) + n_z * (bodies[c, 2] - p_z)
        arm_a = n_x * (p_x - bodies[a, 0]) + n_y * (p_y - bodies[a, 1]) + n_z * (p_z - bodies[a, 2])
        # W = H^T M^-1 H in the frame (n, t, s)
        normal = (n_x, n_y, n_z)
        t = tangent_of(n_x, n_y, n_z)
        moving = moves(c, a, inverse_mass)
        if CENTRAL:
            block, w_nt, shear, plain = local_block(normal, t, moving, turns(c, a, arm_c, arm_a, inverse_mass))
            if result.lever.shape[0] > 0:  # other groups need it, and the arrays still hold older values
                write_levers(m, times(-arm_c, normal), times(arm_a, normal), result.lever)
        else:
            frame = (normal, t, cross(normal, t))
            point = (p_x, p_y, p_z)
            lever_c = seen_from(c, bodies, point)
            lever_a = seen_from(a, bodies, point)
            write_levers(m, lever_c, lever_a, result.lever)
            block = (weighted(normal, moving, normal), weighted(t, moving, t), weighted(frame[2], moving, frame[2]))
            coupled = (weighted(normal, moving, t), weighted(normal, moving, frame[2]), weighted(t, moving, frame[2]))
            easy_c = (inverse_mass[c, 3], inverse_mass[c, 4], inverse_mass[c, 5])
            easy_a = (inverse_mass[a, 3], inverse_mass[a, 4], inverse_mass[a, 5])
            block, coupled = turned_block(block, coupled, lever_c, frame, quaternion_of(bodies, c), easy_c)
            block, coupled = turned_block(block, coupled, lever_a, frame, quaternion_of(bodies, a), easy_a)
            w_nt = coupled[0]
            # both are held along a tangent: friction moves nothing, and any positive weight gives it
            block = (block[0], block[1] if block[1] > 0.0 else block[0], block[2] if block[2] > 0.0 else block[0])
            shear = (coupled[1], coupled[2])
            plain = False
            # a normal through the axis about which a body can turn: levers are rounded
            noise = rounding_of(lever_c, easy_c) + rounding_of(lever_a, easy_a)
            if block[0] <= noise:
                continue
        if block[0] <= 0.0:  # neither body can move along the normal: no impulse changes anything
            continue
        diagonal = diagonal and plain
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        for k in range(3):
            result.normal[m, k] = normal[k]
            result.tangent[m, k] = t[k]
            result.delassus[m, k] = block[k]
        result.arm[m, 0] = arm_c
        result.arm[m, 1] = arm_a
        if result.shear.shape[0] > 0:
            result.coupling[m] = w_nt
            result.shear[m, 0] = shear[0]
            result.shear[m, 1] = shear[1]
        for k in range(result.weight.shape[1]):
            result.weight[m, k] = 0.0
        result.slot[m] = first_slot + p
        m += 1
    return m, diagonal
