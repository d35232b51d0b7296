"""Unilateral contact with Coulomb friction (Jean 1999), non-associated: sliding does not dilate.

The law stands in five places, each for a question that the others do not answer. Here it is solved for any local block W,
on tuples in registers, as sweeps need it. ``Problem.react`` solves it for ``w I`` on arrays of all interactions, without a
compiler, for residuals. ``newton.rows.natural_map`` does the same in a kernel and keeps the status and the direction of
sliding, of which the Jacobian is made. ``residual.project_on_cone`` is De Saxce's projection, the measure of published
solvers. ``locked.within_cones`` is the projection of impulses alone, without velocities, for the proof that there is no
solution. ``tests/laws/test_coulomb_five_ways.py`` holds them against each other at the same hard points.
"""

from __future__ import annotations

import math
from typing import ClassVar

from lmgcpy.compiled.kernel import inlined
from lmgcpy.laws.law import Law, Parameter
from lmgcpy.laws.signorini import approach

ROUND_OFF = 1e-14
"""A sum that is no larger than this part of its terms counts as zero. The test for singular blocks of W uses it."""
NEWTON_STEPS = 8
"""Most Newton steps for a contact that slides. Two to five are enough, and one if all tangents are alike."""
LEAST = 1e-300
"""Replaces ``W_tt = 0``: a sliding contact gets its full friction, a contact at rest gets none."""


def react_in_plane(W, q_n, q_t, friction):
    """Impulse (r_n, r_t) of ``0 <= u_n _|_ r_n >= 0``, ``|r_t| <= mu r_n``, opposing ``u_t``, for ``u = q + W r``."""
    (w_nn, w_nt), (w_tn, w_tt) = W
    # open: u = q satisfies the law with r = 0. The same if no impulse moves the bodies.
    if q_n >= 0.0 or w_nn <= 0.0:
        return (0.0, 0.0)
    # diagonal block: r_n and r_t decouple, and r_t is projected on the disk of radius mu r_n, W_tt = 0 or not
    if w_nt == 0.0 and w_tn == 0.0:
        r_n = -q_n / w_nn
        limit = friction * r_n
        return (r_n, min(limit, max(-limit, -q_t / max(w_tt, LEAST))))
    return react_to_full_block_in_plane(W, q_n, q_t, friction)


def react_to_full_block_in_plane(W, q_n, q_t, friction):
    """The impulse for ``q_n < 0``, ``W_nn > 0`` and any block; a separate function, as :func:`react_by_bracket` is.

    Statuses are tried in the order open, stick, slide. For a symmetric positive definite ``W`` a solution exists; with
    strong coupling, ``mu |W_nt| > W_nn``, there may be several, and this order is the rule that picks one. A singular
    block may have no solution (:func:`react_by_bracket`): then the impulse is that without friction.
    """
    (w_nn, w_nt), (w_tn, w_tt) = W
    # normal impulse without friction, u_n = 0
    alone = -q_n / w_nn
    determinant = w_nn * w_tt - w_nt * w_tn
    if not determinant > ROUND_OFF * w_nn * w_tt:
        # singular block: with u_n = 0 the velocity u_t does not depend on r_t, so that the contact sticks or slides one way
        u_t = q_t + w_tn * alone
        if abs(u_t) <= ROUND_OFF * (abs(q_t) + abs(w_tn * alone)):
            return (alone, 0.0)
        side = -1.0 if u_t > 0.0 else 1.0
        slope = w_nn + side * friction * w_nt
        return (-q_n / slope, -side * friction * q_n / slope) if slope > 0.0 else (alone, 0.0)
    # stick: r = -W^-1 q, if it is in the cone
    r_n = (w_nt * q_t - w_tt * q_n) / determinant
    r_t = (w_tn * q_n - w_nn * q_t) / determinant
    if r_n >= 0.0 and abs(r_t) <= friction * r_n:
        return (r_n, r_t)
    # slide: r_t = side mu r_n, u_n = 0, and u_t of the other sign. Both signs can fail by round-off only; the loop keeps
    # the sign with the smaller error.
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

    ``coupling``: (W_nt, W_ns); ``shear``: (S_tt, S_ts, S_ss), the Schur complement of the normal row of W; ``free``: the
    tangential free velocity after the same elimination of r_n. Then ``(S + slowness I) r_t = -free`` and
    ``r_n = -(q_n + W_nt . r_t)/W_nn``.
    """
    # r_t by Cramer's rule on S + slowness I, then r_n from u_n = 0
    a = shear[0] + slowness
    b = shear[2] + slowness
    determinant = a * b - shear[1] * shear[1]
    r_t = (shear[1] * free[1] - b * free[0]) / determinant
    r_s = (shear[1] * free[0] - a * free[1]) / determinant
    r_n = -(q_n + coupling[0] * r_t + coupling[1] * r_s) / w_nn
    return math.sqrt(r_t * r_t + r_s * r_s), r_n, r_t, r_s


@inlined
def react_in_space(W, q_n, q_t, q_s, friction):
    """Impulse (r_n, r_t, r_s) of ``0 <= u_n _|_ r_n >= 0``, ``|r_t| <= mu r_n``, opposing ``u_t``, for ``u = q + W r``."""
    # open: u = q satisfies the law with r = 0
    if q_n >= 0.0:
        return (0.0, 0.0, 0.0)
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    if w_nt == 0.0 and w_ns == 0.0 and w_ts == 0.0:
        if not (w_tt == w_ss and w_nn > 0.0 and w_tt > 0.0):
            return react_by_bracket(W, q_n, q_t, q_s, friction)
        # diagonal block with W_tt = W_ss: r_n and r_t decouple, and r_t is projected on the disk of radius mu r_n
        r_n = -q_n / w_nn
        limit = friction * r_n
        length = math.sqrt(q_t * q_t + q_s * q_s) / w_tt
        factor = -1.0 / w_tt if length <= limit else -limit / (length * w_tt)
        return (r_n, factor * q_t, factor * q_s)
    return react_to_full_block(W, q_n, q_t, q_s, friction)


@inlined
def react_to_full_block(W, q_n, q_t, q_s, friction):
    """The impulse for ``q_n < 0`` and a block that couples the rows; what is rare is left to :func:`react_by_bracket`.

    Let S be the Schur complement of the normal row and ``k = W_tn / W_nn``. A contact that slides has ``u_t = -l r_t``,
    l > 0, with r_t(l) and r_n(l) of :func:`slide_at`, and with ``K = (S + l)^-1``

        d r_t / dl = -K r_t,     d|r_t| / dl = -r_t . K r_t / |r_t|,     d r_n / dl = k . K r_t.

    The angle between r_t and ``K r_t`` has a cosine of ``2 sqrt(det S) / tr S`` at least (Kantorovich). So if that is more
    than ``mu |k|``, ``|r_t| - mu r_n`` falls everywhere, and there is one root at most. ``mu r_n / |r_t|`` is nearly linear
    in l (linear if ``k = 0`` and S is a multiple of the identity), and Newton steps find where it is 1.
    """
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    if w_nn <= 0.0:
        return (0.0, 0.0, 0.0)
    # Schur complement of the normal row; a reciprocal does not wait for the velocities, as a quotient would
    inverse = 1.0 / w_nn
    k_t = w_nt * inverse
    k_s = w_ns * inverse
    s_tt = w_tt - k_t * w_nt
    s_ts = w_ts - k_t * w_ns
    s_ss = w_ss - k_s * w_ns
    determinant = s_tt * s_ss - s_ts * s_ts
    if not determinant > ROUND_OFF * w_tt * w_ss:
        return react_by_bracket(W, q_n, q_t, q_s, friction)
    # stick: r = -W^-1 q, if it is in the cone
    over = 1.0 / determinant
    alone = -q_n * inverse
    free_t = q_t + w_nt * alone
    free_s = q_s + w_ns * alone
    r_t = (s_ts * free_s - s_ss * free_t) * over
    r_s = (s_ts * free_t - s_tt * free_s) * over
    r_n = alone - (k_t * r_t + k_s * r_s)
    square = r_t * r_t + r_s * r_s
    size = math.sqrt(square)
    above = size - friction * r_n
    if above <= 0.0:
        return (r_n, r_t, r_s)
    # slide, if there is one root: Newton steps on mu r_n / |r_t| = 1 from l = 0
    trace = s_tt + s_ss
    if friction * friction * (k_t * k_t + k_s * k_s) * trace * trace < 4.0 * determinant:
        slowness = 0.0
        a = s_tt
        b = s_ss
        for _ in range(NEWTON_STEPS):
            # K r_t, and the derivative times |r_t|^3
            fall_t = (b * r_t - s_ts * r_s) * over
            fall_s = (a * r_s - s_ts * r_t) * over
            rise = friction * (square * (k_t * fall_t + k_s * fall_s) + r_n * (r_t * fall_t + r_s * fall_s))
            if not rise > 0.0:
                break
            slowness += above * (square / rise)
            if not slowness > 0.0:
                break
            a = s_tt + slowness
            b = s_ss + slowness
            over = 1.0 / (a * b - s_ts * s_ts)
            r_t = (s_ts * free_s - b * free_t) * over
            r_s = (s_ts * free_t - a * free_s) * over
            r_n = alone - (k_t * r_t + k_s * r_s)
            square = r_t * r_t + r_s * r_s
            size = math.sqrt(square)
            limit = friction * r_n
            above = size - limit
            if abs(above) < 8e-16 * size:
                factor = limit / size
                return (r_n, factor * r_t, factor * r_s)
    return react_by_bracket(W, q_n, q_t, q_s, friction)


def react_by_bracket(W, q_n, q_t, q_s, friction):
    """The impulse for ``q_n < 0`` and any symmetric block without negative eigenvalues.

    It is a separate function, so that the compiler inlines :func:`react_in_space` in the sweep and leaves this long one
    out. Statuses are tried in the order open, stick, slide. A contact that slides has ``u_t = -l r_t``, l > 0. If W is
    positive definite, ``|r_t| - mu r_n`` falls from above zero at l = 0, the sticking contact, to ``mu q_n / W_nn < 0``.
    So there is a root, and regula falsi finds it in a bracket. If W couples n strongly with t, there may be several roots;
    the function takes the one in the bracket.

    If S, the Schur complement of the normal row, is singular, sticking is the limit of l to 0: the least ``r_t`` that
    stops the contact. If no ``r_t`` stops it, ``|r_t|`` grows without bound as l falls, and ``mu r_n`` may grow faster:
    friction presses the contact in. Then :func:`first_root` searches a root among growing values of l. If there is none,
    no impulse satisfies the law: the function returns the impulse without friction, and :func:`lmgcpy.solve_local` reports
    the status "infeasible".
    """
    (w_nn, w_nt, w_ns), (_, w_tt, w_ts), (_, _, w_ss) = W
    if w_nn <= 0.0:
        return (0.0, 0.0, 0.0)
    # Schur complement of the normal row, and the tangential free velocity after the elimination of r_n
    coupling = (w_nt, w_ns)
    shear = (w_tt - w_nt * w_nt / w_nn, w_ts - w_nt * w_ns / w_nn, w_ss - w_ns * w_ns / w_nn)
    free = (q_t - w_nt * q_n / w_nn, q_s - w_ns * q_n / w_nn)
    scale = w_tt + w_ss if w_tt + w_ss > 0.0 else w_nn
    low = 0.0
    c, s = 1.0, 0.0
    rests = True
    if not shear[0] * shear[2] - shear[1] * shear[1] > ROUND_OFF * w_tt * w_ss:
        # singular Schur complement: in its eigenframe, l starts at round-off
        error = 100.0 * ROUND_OFF * (abs(q_t) + abs(q_s) - (abs(w_nt) + abs(w_ns)) * q_n / w_nn)
        c, s, coupling, shear, free = in_eigenframe(coupling, shear, free, scale, error)
        low = ROUND_OFF * (shear[0] if shear[0] > 0.0 else scale)
        rests = free[1] == 0.0 and (shear[0] > 0.0 or free[0] <= error)
    # stick: l = 0 (its limit for a singular S), if r is in the cone
    size, r_n, r_t, r_s = slide_at(low, w_nn, q_n, coupling, shear, free)
    above = size - friction * r_n
    if above <= 0.0:
        if rests:
            return (r_n, c * r_t - s * r_s, s * r_t + c * r_s)
        low = first_root(low, scale, w_nn, q_n, coupling, shear, free, friction)
        if low < 0.0:
            return (-q_n / w_nn, 0.0, 0.0)
        size, r_n, r_t, r_s = slide_at(low, w_nn, q_n, coupling, shear, free)
        above = size - friction * r_n
    # slide: bracket of the root of |r_t| - mu r_n
    high = max(scale, 4.0 * low)
    size, r_n, r_t, r_s = slide_at(high, w_nn, q_n, coupling, shear, free)
    below = size - friction * r_n
    for _ in range(200):  # one or two turns, unless friction is nearly zero
        if below <= 0.0:
            break
        low = high
        above = below
        high *= 4.0
        size, r_n, r_t, r_s = slide_at(high, w_nn, q_n, coupling, shear, free)
        below = size - friction * r_n
    side = 0
    for _ in range(200):
        # Illinois step: regula falsi that halves the value at the end which stays; bisection if it leaves the bracket
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
    # r_t scaled to mu r_n, so that the impulse is on the cone to the last digit
    factor = friction * r_n / size if size > 0.0 else 0.0
    return (r_n, factor * (c * r_t - s * r_s), factor * (s * r_t + c * r_s))


def in_eigenframe(coupling, shear, free, scale, error):
    """Eigenframe of a singular S: cos and sin of its angle, then coupling, ``S = diag(lambda, 0)`` and free velocity in it.

    If S vanishes, the first axis is along the free velocity. A free velocity along the second axis below ``error`` [m/s]
    counts as zero.
    """
    eigenvalue = max(shear[0] + shear[2], 0.0)
    angle = 0.5 * math.atan2(2.0 * shear[1], shear[0] - shear[2])
    if eigenvalue <= ROUND_OFF * scale:
        eigenvalue = 0.0
        angle = math.atan2(free[1], free[0])
    c, s = math.cos(angle), math.sin(angle)
    across = c * free[1] - s * free[0]
    turned = (c * coupling[0] + s * coupling[1], c * coupling[1] - s * coupling[0])
    return c, s, turned, (eigenvalue, 0.0, 0.0), (c * free[0] + s * free[1], across if abs(across) > error else 0.0)


def first_root(low, scale, w_nn, q_n, coupling, shear, free, friction):
    """The least of some 250 values of l at which ``|r_t| > mu r_n``; -1 if there is none.

    The values begin at ``low``, and each is a quarter above the one before.
    """
    slowness = low
    while slowness < 1e3 * scale:
        slowness *= 1.25
        size, r_n, _, _ = slide_at(slowness, w_nn, q_n, coupling, shear, free)
        if size > friction * r_n:
            return slowness
    return -1.0


class Coulomb(Law):
    """Signorini's condition, and ``r_t`` in the disk of radius ``mu r_n``, opposing ``u_t`` when sliding.

    In words: bodies do not overlap, and friction of at most ``mu r_n`` opposes sliding. ``friction`` is the coefficient mu.

    A ball that is thrown along a floor slides until it rolls with two thirds of its speed:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(3.0, 0.0)))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    >>> ball.velocity.round(9), round(ball.spin, 9)
    (array([2., 0.]), -20.0)
    """

    NAME = "coulomb"
    APPLIES_TO = "contact"
    KEEPS_GAP = True
    PREPARED: ClassVar[tuple[str, ...]] = ("bias", "friction")
    TRAITS = frozenset({"push", "cone", "dissipative", "rigid"})

    friction = Parameter("-", "coefficient of friction mu", minimum=0.0)

    def rows(self, dimension: int) -> int:
        """A frictionless contact has one row."""
        return dimension if self.friction > 0.0 else 1

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        (friction,) = parameters
        return (approach(gap, reference_gap, velocity[0], time_step), friction)

    @staticmethod
    @inlined
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
