"""The local solve of contact with friction, rolling friction and torsion friction in 3D.

The impulse is (r_n, r_t, r_s, r_1, r_2, r_z): normal, friction in the disk ``|(r_t, r_s)| <= mu r_n``, rolling in the disk
``|(r_1, r_2)| <= mu_r r_n``, torsion ``|r_z| <= mu_z r_n``, each opposing its velocity if it is at its bound.

With ``s`` given for r_n in the bounds, ``u_n = 0`` and r_n eliminated (S: the Schur complement of the normal row of W), the
conditions on x = (r_t, r_s, r_1, r_2, r_z) are the optimality conditions of

    minimise  x . S x / 2 + p . x      in two disks and an interval of sizes mu s, mu_r s, mu_z s,

a strictly convex problem, whose only solution is continuous in s. So ``r_n = -(q_n + W_nx x(s)) / W_nn`` equals s for some
``s > 0``: at s = 0 it is ``-q_n / W_nn > 0``, and it stays bounded as s grows. So a solution exists for every symmetric
positive definite W. If W does not couple n with the other rows, as for spheres, whose contact lies between the centres,
``r_n = -q_n / W_nn`` at once, and the solution is unique. With strong coupling there may be several solutions, and the
bracket of the root picks one.

The convex problem is solved from the inside out; every equation in one unknown is monotone:

* torsion: after the minimisation over both disks the function is convex in r_z. So its minimiser in the interval is its
  free minimiser, or the nearer end;
* friction: the contact slides if ``|x_t|`` exceeds its bound at ``l = 0``; then ``u_t = -l x_t``, and ``|x_t|`` falls as l
  grows.
  A bracketed secant on ``1/|x_t|``, which is nearly linear in l, finds the root (Hebden 1973; More, Sorensen 1983);
* rolling: for given l the same in a single disk, ``(C + k) y = -p``, where Newton steps on ``1/|y|`` from k = 0 rise to the
  root. For spheres C is a multiple of the identity, y is along -p, and no step is needed.
"""

from __future__ import annotations

import math

from lmgcpy.compiled.kernel import inlined

REGULAR = 4e-15
"""Part of its diagonal that is added to S. If S is singular (a body that turns about one axis only), there are many x, and
this picks the least. As x is bounded, the change of the velocities is within the round-off of ``W r``."""
ENOUGH = 4e-16
"""Relative error at which a root is found."""
LARGE = 1e10
"""If r_n grows beyond this multiple of the impulse without friction, no impulse satisfies the law; the impulse without
friction is returned."""


@inlined
def react_rolling_in_space(W, q, friction, rolling, torsion):
    """Impulse (r_n, r_t, r_s, r_1, r_2, r_z) for ``u = q + W r``; see the module's text."""
    w_nn = W[0][0]
    # open: u = q satisfies the law with r = 0
    if q[0] >= 0.0 or w_nn <= 0.0:
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    alone = -q[0] / w_nn
    # spheres: n and torsion on their own, friction and rolling coupled in the same way in all directions
    coupled = W[0][1] != 0.0 or W[0][2] != 0.0 or W[0][3] != 0.0 or W[0][4] != 0.0 or W[0][5] != 0.0
    twisted = W[1][5] != 0.0 or W[2][5] != 0.0 or W[3][5] != 0.0 or W[4][5] != 0.0
    skew = W[1][2] != 0.0 or W[3][4] != 0.0 or W[1][4] != 0.0 or W[2][3] != 0.0
    if not (coupled or twisted or skew) and W[1][1] == W[2][2] and W[3][3] == W[4][4] and W[1][3] == W[2][4]:
        limits = (friction * alone, rolling * alone)
        x_t, x_s, y_1, y_2 = in_two_equal_disks(W[1][1], W[1][3], W[3][3], (q[1], q[2]), (q[3], q[4]), *limits)
        return (alone, x_t, x_s, y_1, y_2, in_interval(W[5][5], q[5], torsion * alone))
    return react_to_any_block(W, q, friction, rolling, torsion)


def in_interval(w, p, limit):
    """Minimiser of ``w z^2 / 2 + p z`` in ``|z| <= limit``; for w = 0 the minimiser of least magnitude."""
    if abs(p) <= w * limit:
        return -p / w if w > 0.0 else 0.0
    return -limit if p > 0.0 else limit


def in_two_equal_disks(a, b, c, p, d, first, second):
    """Minimiser (x, y) of ``a |x|^2/2 + b x . y + c |y|^2/2 + p . x + d . y`` in ``|x| <= first``, ``|y| <= second``.

    For given l the disk of y is solved in closed form (:func:`rolling_at`), so that there is one equation for l.
    """
    if first <= 0.0:
        y_1, y_2 = in_equal_disk(c, d[0], d[1], second)
        return (0.0, 0.0, y_1, y_2)
    if a <= 0.0:  # held along the tangents, so that b = 0 as well
        x_1, x_2 = in_equal_disk(a, p[0], p[1], first)
        y_1, y_2 = in_equal_disk(c, d[0], d[1], second)
        return (x_1, x_2, y_1, y_2)
    # sticks
    size, x_1, x_2, y_1, y_2 = rolling_at(0.0, a, b, c, p, d, second)
    if size <= first:
        return (x_1, x_2, y_1, y_2)
    # slides: bracketed secant (Illinois) on first / |x| - 1, from below zero at l = 0 to where |x| is surely within
    low = 0.0
    below = first / size - 1.0
    high = (math.hypot(p[0], p[1]) + abs(b) * second) / first
    size, _, _, _, _ = rolling_at(high, a, b, c, p, d, second)
    above = min(first / size - 1.0, 1e3) if size > 0.0 else 1e3
    side = 0
    for _ in range(200):
        middle = (low * above - high * below) / (above - below)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        size, x_1, x_2, y_1, y_2 = rolling_at(middle, a, b, c, p, d, second)
        there = min(first / size - 1.0, 1e3) if size > 0.0 else 1e3
        if abs(there) <= ENOUGH or high - low <= ENOUGH * high:
            break
        if there < 0.0:
            low, below = middle, there
            if side == 1:
                above *= 0.5
            side = 1
        else:
            high, above = middle, there
            if side == -1:
                below *= 0.5
            side = -1
    # x on its circle to the last digit, and the y that belongs to it
    if size > 0.0:
        x_1 *= first / size
        x_2 *= first / size
    y_1, y_2 = in_equal_disk(c, d[0] + b * x_1, d[1] + b * x_2, second)
    return (x_1, x_2, y_1, y_2)


def in_equal_disk(c, d_1, d_2, limit):
    """Minimiser of ``c |y|^2 / 2 + d . y`` in ``|y| <= limit``; for c = 0 the minimiser of least length."""
    size = math.hypot(d_1, d_2)
    if size <= c * limit:
        return (-d_1 / c, -d_2 / c) if c > 0.0 else (0.0, 0.0)
    factor = -limit / size
    return (factor * d_1, factor * d_2)


def rolling_at(slowness, a, b, c, p, d, limit):
    """``(|x|, x, y)`` for ``u_t = -l x``: x is eliminated, and y is along d after this elimination; ``slowness``: l."""
    stiff = a + slowness
    ratio = b / stiff
    y_1, y_2 = in_equal_disk(c - b * ratio, d[0] - ratio * p[0], d[1] - ratio * p[1], limit)
    x_1 = -(p[0] + b * y_1) / stiff
    x_2 = -(p[1] + b * y_2) / stiff
    return math.hypot(x_1, x_2), x_1, x_2, y_1, y_2


# --------------------------------------------------------------------------------------------- blocks of any structure


def react_to_any_block(W, q, friction, rolling, torsion):
    """The impulse for ``q_n < 0`` and any symmetric block without negative eigenvalues; a separate function, so that the
    compiler leaves it out of the sweep."""
    w_nn = W[0][0]
    shares = (friction, rolling, torsion)
    alone = -q[0] / w_nn
    n = (W[0][1], W[0][2], W[0][3], W[0][4], W[0][5])
    reduced = without_normal(W, n, w_nn)
    free = (q[1] + n[0] * alone, q[2] + n[1] * alone, q[3] + n[2] * alone, q[4] + n[3] * alone, q[5] + n[4] * alone)
    # root of r_n(s) - s: bracketed secant (Illinois); without coupling the first value is the root
    low, high = 0.0, alone
    above = alone
    x = tangential_at(reduced, free, shares, high)
    there = alone - product_with(n, x) / w_nn - high
    while there > 0.0:
        if high > LARGE * alone:  # W is singular: friction presses the contact in, and no impulse satisfies the law
            return (alone, 0.0, 0.0, 0.0, 0.0, 0.0)
        low, above = high, there
        high *= 4.0
        x = tangential_at(reduced, free, shares, high)
        there = alone - product_with(n, x) / w_nn - high
    below = there
    middle = high
    side = 0
    for _ in range(200):
        if abs(there) <= ENOUGH * (alone + sizes_with(n, x) / w_nn) or high - low <= ENOUGH * high:
            break
        middle = (low * below - high * above) / (below - above)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        x = tangential_at(reduced, free, shares, middle)
        there = alone - product_with(n, x) / w_nn - middle
        if there > 0.0:
            low, above = middle, there
            if side == 1:
                below *= 0.5
            side = 1
        else:
            high, below = middle, there
            if side == -1:
                above *= 0.5
            side = -1
    return (middle, x[0], x[1], x[2], x[3], x[4])


def product_with(n, x):
    """``n . x``."""
    return n[0] * x[0] + n[1] * x[1] + n[2] * x[2] + n[3] * x[3] + n[4] * x[4]


def sizes_with(n, x):
    """Sum of the sizes of the terms of ``n . x``."""
    return abs(n[0] * x[0]) + abs(n[1] * x[1]) + abs(n[2] * x[2]) + abs(n[3] * x[3]) + abs(n[4] * x[4])


def without_normal(W, n, w_nn):
    """Schur complement S of the normal row, the upper triangle in blocks: (A: friction, B: friction by rolling, C: rolling,
    f: friction by torsion, g: rolling by torsion, e: torsion)."""
    A = (
        regular(W[1][1], n[0] * n[0] / w_nn, w_nn),
        W[1][2] - n[0] * n[1] / w_nn,
        regular(W[2][2], n[1] * n[1] / w_nn, w_nn),
    )
    B = (
        (W[1][3] - n[0] * n[2] / w_nn, W[1][4] - n[0] * n[3] / w_nn),
        (W[2][3] - n[1] * n[2] / w_nn, W[2][4] - n[1] * n[3] / w_nn),
    )
    C = (
        regular(W[3][3], n[2] * n[2] / w_nn, w_nn),
        W[3][4] - n[2] * n[3] / w_nn,
        regular(W[4][4], n[3] * n[3] / w_nn, w_nn),
    )
    f = (W[1][5] - n[0] * n[4] / w_nn, W[2][5] - n[1] * n[4] / w_nn)
    g = (W[3][5] - n[2] * n[4] / w_nn, W[4][5] - n[3] * n[4] / w_nn)
    return A, B, C, f, g, regular(W[5][5], n[4] * n[4] / w_nn, w_nn)


def regular(w, taken, w_nn):
    """``w - taken``, an entry of the diagonal of S, with its regular part."""
    return max(w - taken, 0.0) + REGULAR * (w if w > 0.0 else w_nn)


def tangential_at(reduced, free, shares, s):
    """x(s) = (r_t, r_s, r_1, r_2, r_z) for bounds of ``shares`` times s."""
    A, B, C, f, g, e = reduced
    limits = shares[0] * s, shares[1] * s
    p, d = (free[0], free[1]), (free[2], free[3])
    z = shares[2] * s
    if z > 0.0:
        # torsion without a bound, eliminated
        x_t, x_s, y_1, y_2 = in_two_disks(
            (less(A[0], f[0] * f[0] / e), A[1] - f[0] * f[1] / e, less(A[2], f[1] * f[1] / e)),
            (
                (B[0][0] - f[0] * g[0] / e, B[0][1] - f[0] * g[1] / e),
                (B[1][0] - f[1] * g[0] / e, B[1][1] - f[1] * g[1] / e),
            ),
            (less(C[0], g[0] * g[0] / e), C[1] - g[0] * g[1] / e, less(C[2], g[1] * g[1] / e)),
            (p[0] - f[0] * free[4] / e, p[1] - f[1] * free[4] / e),
            (d[0] - g[0] * free[4] / e, d[1] - g[1] * free[4] / e),
            *limits,
        )
        x_z = -(free[4] + f[0] * x_t + f[1] * x_s + g[0] * y_1 + g[1] * y_2) / e
        if abs(x_z) <= z:
            return (x_t, x_s, y_1, y_2, x_z)
        z = z if x_z > 0.0 else -z
    # torsion at its bound
    p, d = (p[0] + f[0] * z, p[1] + f[1] * z), (d[0] + g[0] * z, d[1] + g[1] * z)
    x_t, x_s, y_1, y_2 = in_two_disks(A, B, C, p, d, *limits)
    return (x_t, x_s, y_1, y_2, z)


def in_two_disks(A, B, C, p, d, first, second):
    """Minimiser (x, y) of ``x . A x / 2 + x . B y + y . C y / 2 + p . x + d . y`` in ``|x| <= first``, ``|y| <= second``;
    the method of :func:`in_two_equal_disks`."""
    if first <= 0.0:
        y_1, y_2 = in_disk(C, d[0], d[1], second)
        return (0.0, 0.0, y_1, y_2)
    # sticks: u_t = 0 with |x| within its bound
    size, x_1, x_2, y_1, y_2 = both_at(0.0, A, B, C, p, d, second)
    if size <= first:
        return (x_1, x_2, y_1, y_2)
    # slides: bracket of the root l of f = first/|x| - 1, from |x| = |(A + l)^-1 (p + B y)| <= (|p| + |B| second)/l
    low = 0.0
    below = first / size - 1.0
    coupling = math.hypot(math.hypot(B[0][0], B[0][1]), math.hypot(B[1][0], B[1][1]))
    high = (math.hypot(p[0], p[1]) + coupling * second) / first
    size, _, _, _, _ = both_at(high, A, B, C, p, d, second)
    above = min(first / size - 1.0, 1e3) if size > 0.0 else 1e3
    side = 0
    for _ in range(200):
        # secant on f, or bisection if round-off puts it outside
        middle = (low * above - high * below) / (above - below)
        if not low < middle < high:
            middle = 0.5 * (low + high)
        size, x_1, x_2, y_1, y_2 = both_at(middle, A, B, C, p, d, second)
        there = min(first / size - 1.0, 1e3) if size > 0.0 else 1e3
        if abs(there) <= ENOUGH or high - low <= ENOUGH * high:
            break
        # Illinois step: the end that stays twice counts half
        if there < 0.0:
            low, below = middle, there
            if side == 1:
                above *= 0.5
            side = 1
        else:
            high, above = middle, there
            if side == -1:
                below *= 0.5
            side = -1
    # x exactly at its bound, and the y that belongs to it
    if size > 0.0:
        x_1 *= first / size
        x_2 *= first / size
    pushed = d[0] + B[0][0] * x_1 + B[1][0] * x_2, d[1] + B[0][1] * x_1 + B[1][1] * x_2
    y_1, y_2 = in_disk(C, pushed[0], pushed[1], second)
    return (x_1, x_2, y_1, y_2)


def both_at(slowness, A, B, C, p, d, limit):
    """``(|x|, x, y)`` for ``u_t = -l x``; ``slowness``: l."""
    a_11, a_12, a_22 = A[0] + slowness, A[1], A[2] + slowness
    determinant = less(a_11 * a_22, a_12 * a_12)
    # (A + l)^-1 B by columns, and (A + l)^-1 p
    k_11 = (a_22 * B[0][0] - a_12 * B[1][0]) / determinant
    k_21 = (a_11 * B[1][0] - a_12 * B[0][0]) / determinant
    k_12 = (a_22 * B[0][1] - a_12 * B[1][1]) / determinant
    k_22 = (a_11 * B[1][1] - a_12 * B[0][1]) / determinant
    m_1 = (a_22 * p[0] - a_12 * p[1]) / determinant
    m_2 = (a_11 * p[1] - a_12 * p[0]) / determinant
    # Schur complement of the rows of friction, and d after the elimination of x
    left = (
        less(C[0], B[0][0] * k_11 + B[1][0] * k_21),
        C[1] - B[0][0] * k_12 - B[1][0] * k_22,
        less(C[2], B[0][1] * k_12 + B[1][1] * k_22),
    )
    d_1 = d[0] - B[0][0] * m_1 - B[1][0] * m_2
    d_2 = d[1] - B[0][1] * m_1 - B[1][1] * m_2
    y_1, y_2 = in_disk(left, d_1, d_2, limit)
    x_1 = -m_1 - k_11 * y_1 - k_12 * y_2
    x_2 = -m_2 - k_21 * y_1 - k_22 * y_2
    return math.hypot(x_1, x_2), x_1, x_2, y_1, y_2


def less(a, b):
    """``a - b`` > 0 of a positive definite block, at least ``REGULAR * a`` in spite of round-off."""
    return max(a - b, REGULAR * a)


def in_disk(C, d_1, d_2, limit):
    """Minimiser of ``y . C y / 2 + d . y`` in ``|y| <= limit``; C: (C_11, C_12, C_22)."""
    if limit <= 0.0:
        return (0.0, 0.0)
    slowness = 0.0
    for _ in range(100):
        # y = -(C + k)^-1 d
        c_11, c_22 = C[0] + slowness, C[2] + slowness
        determinant = less(c_11 * c_22, C[1] * C[1])
        y_1 = (C[1] * d_2 - c_22 * d_1) / determinant
        y_2 = (C[1] * d_1 - c_11 * d_2) / determinant
        size = math.hypot(y_1, y_2)
        if size <= limit * (1.0 + ENOUGH):
            break
        # Newton step on 1 / |y| - 1 / limit rises to the root
        e_1, e_2 = y_1 / size, y_2 / size
        curve = (c_22 * e_1 * e_1 - 2.0 * C[1] * e_1 * e_2 + c_11 * e_2 * e_2) / determinant
        new = slowness + (size / limit - 1.0) / curve if curve > 0.0 else 2.0 * slowness
        if not new > slowness:
            break
        slowness = new
    # on its circle to the last digit
    factor = limit / size if slowness > 0.0 and size > 0.0 else 1.0
    return (y_1 * factor, y_2 * factor)
