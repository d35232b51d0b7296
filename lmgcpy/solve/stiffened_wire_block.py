"""A wire with geometric stiffness as one block: what :mod:`lmgcpy.solve.wire_block` is specialised with where it is on.

A taut link resists what moves across it (:mod:`lmgcpy.dynamics.geometric_stiffness`): beside its law along the normal it
has the linear rows

    r_t = -kappa (u_t - c_t)        kappa: its geometric stiffness [kg]; c_t: velocity that the wire carries along

so that an interaction has d unknowns and the links of a wire form a block-tridiagonal problem (cyclic where the chain is
closed), with blocks of size d. The driver of ``wire_block`` stays as it is. A Newton step ``d`` satisfies, row by row,

    d_a + s_a (w_a d_a - (W d)_a) = -F_a

with the law's slope s and weight w along the normal, and ``s = -kappa, w = 0, F = r_t + kappa (u_t - c_t)`` across it.
Rows where kappa is zero read ``r_t = 0``. The matrix is a symmetric positive definite one with scaled rows, so that block
elimination needs no pivoting.

The scratch ``System.work`` has a row for every link: right-hand side (d), slopes (d), eliminated block above the diagonal
(d x d), columns of the last link of a closed chain (d x d), and the block on the diagonal (d x d).
"""

from __future__ import annotations

import numpy as np

from lmgcpy.solve.contact_block import normal_velocity, push_normal, push_row, relative_velocity
from lmgcpy.solve.system import System
from lmgcpy.solve.wire_block import SAME, react, read, slope

PREPARED = 0
"""How many numbers the law prepares; given by the specialisation, as what follows."""
ROWS = 2
"""The dimension d."""


def scratch_width(dimension: int) -> int:
    """Numbers of scratch that a link needs."""
    return 2 * dimension + 3 * dimension**2


def residual(start, count, offset, weight, s):
    """Fill in -F and the slopes; returns (sum of (w F)^2, whether the law of a link changed its piece)."""
    merit = 0.0
    changed = False
    for k in range(count):
        i = np.uintp(start + k)
        w = weight * s.delassus[i, 0]
        if w == 0.0:  # both bodies are held
            for a in range(ROWS):
                s.work[k, a] = 0.0
                s.work[k, ROWS + a] = 0.0
            continue
        prepared = read(s.prepared, offset + k * PREPARED)
        u = relative_velocity(i, s)
        r = s.impulse[i, 0]
        free = (u[0] - w * r,)
        (new,) = react(((w,),), free, prepared)
        ((gradient,),) = slope(((w,),), free, prepared)
        s.work[k, 0] = new - r
        before = s.work[k, ROWS]
        if abs(gradient - before) > SAME * abs(gradient) or (gradient == 0.0 and abs(new - r) > SAME * abs(new)):
            changed = True
        s.work[k, ROWS] = gradient
        merit += (w * (new - r)) ** 2 + 0.0 * gradient  # a slope that is not finite must not pass for a singular matrix
        stiffness = s.geometric[i]
        for a in range(1, ROWS):
            lag = -stiffness * (u[a] - s.carried[i, a - 1]) - s.impulse[i, a]
            s.work[k, a] = lag
            s.work[k, ROWS + a] = -stiffness
            merit += (s.delassus[i, a] * lag / (1.0 + stiffness * s.delassus[i, a])) ** 2
    return merit, changed


def fill_diagonal(start, k, weight, s):
    """The block of the Newton matrix on the diagonal."""
    i = start + k
    first = 2 * ROWS + 2 * ROWS * ROWS
    for a in range(ROWS):
        gradient = s.work[k, ROWS + a]
        for b in range(ROWS):
            s.work[k, first + ROWS * a + b] = -gradient * s.own[i, a, b]
        w = weight * s.delassus[i, 0] if a == 0 else 0.0
        s.work[k, first + ROWS * a + a] += 1.0 + gradient * w


def factor_diagonal(k, s):
    """LU factors of the block on the diagonal, in place; False where a pivot vanishes."""
    first = 2 * ROWS + 2 * ROWS * ROWS
    for c in range(ROWS):
        pivot = s.work[k, first + ROWS * c + c]
        if not abs(pivot) > 0.0:
            return False
        for a in range(c + 1, ROWS):
            f = s.work[k, first + ROWS * a + c] / pivot
            s.work[k, first + ROWS * a + c] = f
            for b in range(c + 1, ROWS):
                s.work[k, first + ROWS * a + b] -= f * s.work[k, first + ROWS * c + b]
    return True


def solve_diagonal(k, at, columns, s):
    """Solve with the factors for ``columns`` right-hand sides that begin at ``at``, in place."""
    first = 2 * ROWS + 2 * ROWS * ROWS
    for b in range(columns):
        for a in range(ROWS):
            for c in range(a):
                s.work[k, at + columns * a + b] -= s.work[k, first + ROWS * a + c] * s.work[k, at + columns * c + b]
        for reverse in range(ROWS):
            a = ROWS - 1 - reverse
            for c in range(a + 1, ROWS):
                s.work[k, at + columns * a + b] -= s.work[k, first + ROWS * a + c] * s.work[k, at + columns * c + b]
            s.work[k, at + columns * a + b] /= s.work[k, first + ROWS * a + a]


def subtract_below(start, k, at, columns, s):
    """Take the block below the diagonal times the solution of link k - 1 off that of link k."""
    for a in range(ROWS):
        gradient = s.work[k, ROWS + a]
        for b in range(columns):
            for c in range(ROWS):  # entry -gradient W_{i,i-1}, the transpose of what follows link i - 1
                s.work[k, at + columns * a + b] += (
                    gradient * s.following[start + k - 1, c, a] * s.work[k - 1, at + columns * c + b]
                )


def substitute(start, count, weight, s, closed):
    """Solve the block-tridiagonal Newton system of ``count`` links for the right-hand side, and for the columns of the last
    link of a closed chain, in place. Returns False where a pivot vanishes."""
    above = 2 * ROWS
    corner = above + ROWS * ROWS
    first = corner + ROWS * ROWS
    for k in range(count):
        fill_diagonal(start, k, weight, s)
        if k > 0:
            subtract_below(start, k, 0, 1, s)
            if closed:
                subtract_below(start, k, corner, ROWS, s)
            for a in range(ROWS):  # Schur complement of the link before
                gradient = s.work[k, ROWS + a]
                for b in range(ROWS):
                    for c in range(ROWS):
                        s.work[k, first + ROWS * a + b] += (
                            gradient * s.following[start + k - 1, c, a] * s.work[k - 1, above + ROWS * c + b]
                        )
        if not factor_diagonal(k, s):
            return False
        solve_diagonal(k, 0, 1, s)
        if closed:
            solve_diagonal(k, corner, ROWS, s)
        if k < count - 1:
            for a in range(ROWS):
                for b in range(ROWS):
                    s.work[k, above + ROWS * a + b] = -s.work[k, ROWS + a] * s.following[start + k, a, b]
            solve_diagonal(k, above, ROWS, s)
    for k in range(count - 2, -1, -1):
        for a in range(ROWS):
            for c in range(ROWS):
                entry = s.work[k, above + ROWS * a + c]
                s.work[k, a] -= entry * s.work[k + 1, c]
                if closed:
                    for b in range(ROWS):
                        s.work[k, corner + ROWS * a + b] -= entry * s.work[k + 1, corner + ROWS * c + b]
    return True


def newton_step(start, count, weight, s):
    """The Newton step in the first columns of the scratch; False where the matrix is singular.

    In a closed chain the last link also meets the first. Its rows and columns are split off, as in ``wire_block``.
    """
    last = count - 1
    closed = False
    for a in range(ROWS):
        for b in range(ROWS):
            if s.following[start + last, a, b] != 0.0:
                closed = True
    if not closed:
        return substitute(start, count, weight, s, False)
    corner = 2 * ROWS + ROWS * ROWS
    first = corner + ROWS * ROWS
    for k in range(last):
        for a in range(ROWS):
            for b in range(ROWS):
                entry = 0.0
                if k == 0:  # W_{first,last}, the transpose of what follows the last link
                    entry += s.following[start + last, b, a]
                if k == last - 1:
                    entry += s.following[start + k, a, b]
                s.work[k, corner + ROWS * a + b] = -s.work[k, ROWS + a] * entry
    if not substitute(start, last, weight, s, True):
        return False
    fill_diagonal(start, last, weight, s)
    for a in range(ROWS):
        gradient = s.work[last, ROWS + a]
        for c in range(ROWS):
            to_first = -gradient * s.following[start + last, a, c]
            to_before = -gradient * s.following[start + last - 1, c, a]
            s.work[last, a] -= to_first * s.work[0, c] + to_before * s.work[last - 1, c]
            for b in range(ROWS):
                s.work[last, first + ROWS * a + b] -= (
                    to_first * s.work[0, corner + ROWS * c + b] + to_before * s.work[last - 1, corner + ROWS * c + b]
                )
    if not factor_diagonal(last, s):
        return False
    solve_diagonal(last, 0, 1, s)
    for k in range(last):
        for a in range(ROWS):
            for b in range(ROWS):
                s.work[k, a] -= s.work[k, corner + ROWS * a + b] * s.work[last, b]
    return True


def move(start, count, s):
    """Add the Newton step to the impulses."""
    for k in range(count):
        i = np.uintp(start + k)
        for a in range(ROWS):
            s.impulse[i, a] += s.work[k, a]
        push_row(i, s, s.work[k])


def relax(start, count, offset, s):
    """Update the links one after another, along the normal and then across it."""
    for k in range(count):
        i = np.uintp(start + k)
        w = s.delassus[i, 0]
        if w == 0.0:
            continue
        prepared = read(s.prepared, offset + k * PREPARED)
        r = s.impulse[i, 0]
        (new,) = react(((w,),), (normal_velocity(i, s) - w * r,), prepared)
        s.impulse[i, 0] = new
        push_normal(i, s, new - r)
        u = relative_velocity(i, s)
        s.work[k, 0] = 0.0
        for a in range(1, ROWS):
            w = s.delassus[i, a]
            lag = -s.geometric[i] * (u[a] - s.carried[i, a - 1]) - s.impulse[i, a]
            s.work[k, a] = lag / (1.0 + s.geometric[i] * w)
            s.impulse[i, a] += s.work[k, a]
        push_row(i, s, s.work[k])


def sweep_links(start, stop, offset, s: System):
    """Update the links of one chain one after another: for laws without a slope, and solvers without wire blocks."""
    relax(start, stop - start, offset, s)
    return 0.0


def error(start, stop, offset, s: System):
    """Sum of squares of ``e = w (r - react(w I, u - w r))`` over the links of one chain [m^2/s^2], w the mean diagonal of
    their W; across the link ``react`` gives ``-kappa (u_t - w r_t - c_t)/(1 + kappa w)``."""
    total = 0.0
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        w = 0.0
        for a in range(ROWS):
            w += s.delassus[i, a] / ROWS
        if w == 0.0:
            continue
        u = relative_velocity(i, s)
        r = s.impulse[i, 0]
        (new,) = react(((w,),), (u[0] - w * r,), prepared)
        square = (w * (r - new)) ** 2
        stiffness = s.geometric[i]
        for a in range(1, ROWS):
            lag = s.impulse[i, a] + stiffness * (u[a] - s.carried[i, a - 1])
            square += (w * lag / (1.0 + stiffness * w)) ** 2
        total += square
        if not square <= s.worst[0] and not np.isnan(s.worst[0]):  # the first NaN, too, is the worst
            s.worst[0] = square
            s.worst[1] = i
    return total
