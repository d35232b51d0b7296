"""The load of a body: the greatest impulse of its interactions, with which the error of a force is compared.

``|e_i| / W_nn`` is the impulse that would correct the error of interaction i. Over the load of its two bodies, it is the
part by which a force is off. It depends neither on the size of the sample nor on the time step, and on a press elsewhere
only by a floor of a thousandth. Bodies that nothing can move do not count, as a floor bears the loads of all.
"""

from __future__ import annotations

import numpy as np

NEARBY = 0.1
"""Part of its neighbours' load that counts as a body's own load: between loaded grains lie some that bear nothing."""
LITTLE = 1e-3
"""An impulse is little if it is at most this part of the geometric mean of all impulses, and moves a light body by no more
than the slip allows ..."""
NOTHING = 1e-6
"""... or if it is at most this part of that mean."""


def is_little(impulse, slip, bounds):
    """Whether an impulse [N s] on a light body, which makes this slip of it, is too small to matter."""
    return impulse <= NOTHING * bounds[3] or (impulse <= LITTLE * bounds[3] and slip <= bounds[1])


def add_load(start, stop, walls, s, found):
    """Enter the impulses of some interactions [N s] as loads of their bodies, in ``s.noise``; not for held walls, see
    ``momentum``.

    Adds to ``found`` the logarithms of the impulses and their number.
    """
    for i in range(start, stop):
        size = 0.0
        for k in range(s.impulse.shape[1]):
            size += s.impulse[i, k] * s.impulse[i, k]
        if size > 0.0:
            size = np.sqrt(size)
            found[1] += np.log(size)
            found[2] += 1.0
            if walls != 0:
                bear(s.candidate[i], size, s)
            if walls != 1:
                bear(s.antagonist[i], size, s)
            for k in range(s.corner.shape[1]):
                bear(s.corner[i, k], abs(s.weight[i, (s.normal.shape[1] + 1) * k]) * size, s)


def bear(b, size, s):
    """A body bears an impulse of this size if it can move."""
    mobility = 0.0
    for k in range(s.inverse_mass.shape[1]):
        mobility = max(mobility, s.inverse_mass[b, k])
    if mobility > 0.0:
        s.noise[b, 2] = max(s.noise[b, 2], size)


def share_load(start, stop, walls, s):
    """Enter for the bodies of some interactions the load of the other one, in the next column."""
    for i in range(start, stop):
        c = s.candidate[i]
        a = s.antagonist[i]
        if walls != 0:
            s.noise[c, 3] = max(s.noise[c, 3], s.noise[a, 2])
        if walls != 1:
            s.noise[a, 3] = max(s.noise[a, 3], s.noise[c, 2])


def load_of(i, s, typical):
    """Load of the two bodies of an interaction [N s]: the smaller one, or a part of the larger one if that is more.

    ``typical``: geometric mean of all impulses; every body counts as bearing a small part of it.
    """
    c = s.candidate[i]
    a = s.antagonist[i]
    of_c = max(s.noise[c, 2], NEARBY * s.noise[c, 3])
    of_a = max(s.noise[a, 2], NEARBY * s.noise[a, 3])
    if of_c == 0.0 or of_a == 0.0:  # a body that is held, or one without a load
        return max(of_c, of_a, LITTLE * typical)
    return max(min(of_c, of_a), NEARBY * max(of_c, of_a), LITTLE * typical)
