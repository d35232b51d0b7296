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
(d x d), columns of the last link of a closed chain (d x d).
"""

from __future__ import annotations

import numpy as np

from lmgcpy.solve.contact_block import normal_velocity, push_normal, push_row, relative_velocity
from lmgcpy.solve.small_matrices import small_matrices
from lmgcpy.solve.system import System
from lmgcpy.solve.wire_block import SAME, react, read, slope

PREPARED = 0
"""How many numbers the law prepares; given by the specialisation, as what follows."""
ROWS = 2
"""The dimension d."""
_of_two = small_matrices(ROWS)
block, row, square = _of_two["block"], _of_two["row"], _of_two["square"]
store_row, store_square, solve = _of_two["store_row"], _of_two["store_square"], _of_two["solve"]
unit, transposed, negative, scaled = (_of_two[name] for name in ("unit", "transposed", "negative", "scaled"))
product, times, plus, less = _of_two["product"], _of_two["times"], _of_two["plus"], _of_two["less"]
plus_row, less_row = _of_two["plus_row"], _of_two["less_row"]


def scratch_width(dimension: int) -> int:
    """Numbers of scratch that a link needs."""
    return 2 * dimension + 2 * dimension**2


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


def diagonal_block(start, k, weight, s):
    """The block of the Newton matrix on the diagonal, and the slopes of its rows."""
    i = start + k
    gradients = row(s.work, k, ROWS)
    W = block(s.own, i)
    return less(unit(gradients[0] * weight * s.delassus[i, 0]), scaled(gradients, W)), gradients


def eliminated_block(start, k, weight, s):
    """(P, G, slopes) of link k once the link before it is eliminated: its block on the diagonal plus G times what is left
    of that link, which is the Schur complement, as -G = -slope W_{i,i-1} is the block below the diagonal."""
    P, gradients = diagonal_block(start, k, weight, s)
    G = scaled(gradients, transposed(block(s.following, start + k - 1)))
    return plus(P, product(G, square(s.work, k - 1, 2 * ROWS))), G, gradients


def substitute(start, count, weight, s):
    """Solve the block-tridiagonal Newton system of ``count`` links for the right-hand side, in place; False where a
    block is singular."""
    above = 2 * ROWS
    for k in range(count):
        b = row(s.work, k, 0)
        if k == 0:
            P, gradients = diagonal_block(start, k, weight, s)
        else:
            P, G, gradients = eliminated_block(start, k, weight, s)
            b = plus_row(b, times(G, row(s.work, k - 1, 0)))
        left, b, determinant = solve(P, scaled(negative(gradients), block(s.following, start + k)), b)
        if not determinant > 0.0:
            return False
        store_square(s.work, k, above, left)
        store_row(s.work, k, b)
    for k in range(count - 2, -1, -1):
        known = times(square(s.work, k, above), row(s.work, k + 1, 0))
        store_row(s.work, k, less_row(row(s.work, k, 0), known))
    return True


def substitute_columns(start, count, weight, s):
    """Solve the system of :func:`substitute` for the columns of the last link of a closed chain, in place."""
    above = 2 * ROWS
    corner = above + ROWS * ROWS
    for k in range(count):
        columns = square(s.work, k, corner)
        if k == 0:
            P, _ = diagonal_block(start, k, weight, s)
        else:
            P, G, _ = eliminated_block(start, k, weight, s)
            columns = plus(columns, product(G, square(s.work, k - 1, corner)))
        store_square(s.work, k, corner, solve(P, columns, row(s.work, k, 0))[0])
    for k in range(count - 2, -1, -1):
        known = product(square(s.work, k, above), square(s.work, k + 1, corner))
        store_square(s.work, k, corner, less(square(s.work, k, corner), known))


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
        return substitute(start, count, weight, s)
    corner = 2 * ROWS + ROWS * ROWS
    P, gradients = diagonal_block(start, last, weight, s)
    to_first = block(s.following, start + last)
    to_before = transposed(block(s.following, start + last - 1))
    for k in range(last):  # columns of the last link: W_{first,last} and W_{last-1,last}
        columns = less(to_first, to_first)
        if k == 0:
            columns = plus(columns, transposed(to_first))
        if k == last - 1:
            columns = plus(columns, transposed(to_before))
        store_square(s.work, k, corner, scaled(negative(row(s.work, k, ROWS)), columns))
    if not substitute(start, last, weight, s):
        return False
    substitute_columns(start, last, weight, s)
    to_first = scaled(gradients, to_first)
    to_before = scaled(gradients, to_before)
    b = plus_row(row(s.work, last, 0), times(to_first, row(s.work, 0, 0)))
    b = plus_row(b, times(to_before, row(s.work, last - 1, 0)))
    P = plus(P, product(to_first, square(s.work, 0, corner)))
    P = plus(P, product(to_before, square(s.work, last - 1, corner)))
    _, b, determinant = solve(P, P, b)
    if not determinant > 0.0:
        return False
    store_row(s.work, last, b)
    for k in range(last):
        store_row(s.work, k, less_row(row(s.work, k, 0), times(square(s.work, k, corner), b)))
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
    their W; across the link ``react`` gives ``-kappa (u_t - w r_t - c_t)/(1 + kappa w)``. The
    squares are left in ``s.squared_error``."""
    total = 0.0
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        w = 0.0
        for a in range(ROWS):
            w += s.delassus[i, a] / ROWS
        if w == 0.0:
            s.squared_error[i] = 0.0
            continue
        u = relative_velocity(i, s)
        r = s.impulse[i, 0]
        (new,) = react(((w,),), (u[0] - w * r,), prepared)
        square = (w * (r - new)) ** 2
        stiffness = s.geometric[i]
        for a in range(1, ROWS):
            lag = s.impulse[i, a] + stiffness * (u[a] - s.carried[i, a - 1])
            square += (w * lag / (1.0 + stiffness * w)) ** 2
        s.squared_error[i] = square
        total += square
    return total
