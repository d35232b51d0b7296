"""The round-off of errors: the sizes of the terms that the relative velocity of an interaction is a sum of.

A relative velocity is a difference of velocities of bodies. The velocity of a body is a sum: its free velocity plus a term
for every impulse on it. A sum is rounded by at most a few ``eps`` times the sum of the sizes of its terms, and so is every
impulse, which enters with the same terms. With N and S the sums of these sizes for the centre of a body and its spin,

    N_b = |v_free,b| + (1/m_b) sum over its interactions of |r_j|,         S_b = |spin_free,b| + (1/I_b) sum of lever |r_j|,
    noise_i = N_c + N_a + lever_c S_c + lever_a S_a                                                            [m/s],

no error below ``ROUNDING noise_i`` means anything. If the errors of all interactions are below it, the impulses solve
exactly a problem whose operator and free velocities differ from the given ones by ``ROUNDING``, relative, number by number
(Oettli, Prager 1964): arithmetic of this precision cannot distinguish the two problems, and cannot do better.

**Gaps** are rounded as well, by ``eps |x| / 2`` for each of the two positions, and enter the laws as velocities,
``gap / h``. A solver can go below this rounding, as it takes the given numbers for exact. But then it only finds out which
of many contacts bear by the last digit of their gaps, and that may take any time. So ``|x_b| / 4 h``, twice that rounding,
is added to N_b if a solve takes long, and for the question whether there is anything to do at all.

Bodies at the corners of elements count with the sizes of the numbers by which they move the contact point.

In a periodic cell that deforms, the columns of its velocity gradient count as bodies, with the components of the branch as
factors.

Spins count by the lever at which they act, so that lengths, in any unit, are never added to angles.
"""

from __future__ import annotations

import numpy as np

ROUNDING = 4.0 * 2.0**-52
"""Relative round-off of a sum whose terms have gone through some operations."""


def begin_noise(first, last, s, free_velocity, gaps):
    """N and S of some bodies without impulses [m/s, rad/s], into ``s.noise``.

    ``gaps``: whether the rounding of gaps counts, 1 or 0.
    """
    d = s.normal.shape[1]
    # N = |x| / 4h + |v_free|, S = |spin_free|
    for b in range(first, last):
        centre = 0.0
        turning = 0.0
        for k in range(d):
            centre = max(centre, abs(free_velocity[b, k]))
        for k in range(d, free_velocity.shape[1]):
            turning = max(turning, abs(free_velocity[b, k]))
        s.noise[b, 0] = centre + 0.25 * gaps * s.farness[b]
        s.noise[b, 1] = turning


def kinetic_energy(first, last, s, velocity):
    """Kinetic energy of the free components of some bodies [J]."""
    energy = 0.0
    for b in range(first, last):
        for k in range(velocity.shape[1]):
            if s.inverse_mass[b, k] > 0.0:
                energy += 0.5 * velocity[b, k] ** 2 / s.inverse_mass[b, k]
    return energy


def add_noise(start, stop, walls, s):
    """Add the terms of the impulses of some interactions to N and S; not to held walls, see ``momentum``."""
    for i in range(start, stop):
        normal = abs(s.impulse[i, 0])
        tangential = 0.0
        for k in range(1, s.impulse.shape[1]):
            tangential += abs(s.impulse[i, k])
        if normal + tangential == 0.0:
            continue
        if walls != 0:
            add_size(s.candidate[i], i, 0, normal, tangential, s)
        if walls != 1:
            add_size(s.antagonist[i], i, 1, normal, tangential, s)
        for k in range(s.corner.shape[1]):
            share = share_of_corner(i, k, s)
            if share > 0.0:
                centre = 0.0
                for j in range(s.normal.shape[1]):
                    centre = max(centre, s.inverse_mass[s.corner[i, k], j])
                s.noise[s.corner[i, k], 0] += centre * share * (normal + tangential)
        for j in range(s.edges.shape[0]):
            edge = s.cell[i] + np.uintp(j)
            yielding = 0.0
            for k in range(s.normal.shape[1]):
                yielding = max(yielding, s.inverse_mass[edge, k])
            s.noise[edge, 0] += yielding * abs(s.branch[i, j]) * (normal + tangential)


def add_size(b, i, side, normal, tangential, s):
    """Add the terms of an impulse [N s] to N and S of a body."""
    d = s.normal.shape[1]
    # |r| / m to N, lever |r| / I to S
    moment = s.arm[i, side] * tangential
    if s.lateral.shape[0] > 0:
        moment += abs(s.lateral[i, side]) * normal
    if s.lever.shape[0] > 0:
        moment = length_of_lever(i, side, s) * (normal + tangential)
    centre = 0.0
    turning = 0.0
    for k in range(d):
        centre = max(centre, s.inverse_mass[b, k])
    for k in range(d, s.inverse_mass.shape[1]):
        turning = max(turning, s.inverse_mass[b, k])
    s.noise[b, 0] += centre * (normal + tangential)
    s.noise[b, 1] += turning * abs(moment)


def length_of_lever(i, side, s):
    """Sum of the components of a lever in space, which is at least its length [m]."""
    at = 3 * side
    return abs(s.lever[i, at]) + abs(s.lever[i, at + 1]) + abs(s.lever[i, at + 2])


def share_of_corner(i, k, s):
    """Sum of the sizes of the numbers by which a corner of an element enters interaction ``i``."""
    numbers = s.normal.shape[1] + 1
    share = 0.0
    for j in range(numbers * k, numbers * (k + 1)):
        share += abs(s.weight[i, j])
    return share


def gather_noise(first, last, s):
    """noise_i = N_c + N_a + lever_c S_c + lever_a S_a of some interactions [m/s], into ``s.floor``."""
    across = s.lateral.shape[0] > 0
    for k in range(first, last):
        i = np.uintp(k)
        c = s.candidate[i]
        a = s.antagonist[i]
        arm_c = abs(s.arm[i, 0])
        arm_a = abs(s.arm[i, 1])
        if across:
            arm_c += abs(s.lateral[i, 0])
            arm_a += abs(s.lateral[i, 1])
        if s.lever.shape[0] > 0:
            arm_c = length_of_lever(i, 0, s)
            arm_a = length_of_lever(i, 1, s)
        s.floor[i] = s.noise[c, 0] + s.noise[a, 0] + arm_c * s.noise[c, 1] + arm_a * s.noise[a, 1]
        for j in range(s.corner.shape[1]):
            s.floor[i] += share_of_corner(i, j, s) * s.noise[s.corner[i, j], 0]
        for j in range(s.edges.shape[0]):  # the term of a periodic cell, G l
            s.floor[i] += abs(s.branch[i, j]) * s.noise[s.edges[j], 0]
