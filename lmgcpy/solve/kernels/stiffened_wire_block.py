"""A wire with geometric stiffness as one block: the parts with which :mod:`lmgcpy.solve.kernels.wire_block` is specialised.

A taut link resists what moves across it (:mod:`lmgcpy.dynamics.geometric_stiffness`): beside its law along the normal it
has the linear rows

    r_t = -kappa (u_t - c_t)        kappa: its geometric stiffness [kg]; c_t: velocity that the wire carries along

so that an interaction has d unknowns and the links of a wire form a block-tridiagonal problem (cyclic if the chain is
closed), with blocks of size d. The driver of ``wire_block`` solves it. A Newton step ``d`` satisfies, row by row,

    d_a + s_a (w_a d_a - (W d)_a) = -F_a

with the law's slope s and weight w along the normal, and ``s = -kappa, w = 0, F = r_t + kappa (u_t - c_t)`` across it.
Rows with kappa = 0 read ``r_t = 0``. The matrix is a symmetric positive definite one with scaled rows, so that block
elimination needs no pivoting.

Across the links ``1/kappa`` is added to W; along them nothing is. So the normal pivots are held up as in ``wire_block``: a
straight wire between held beads is just as singular.

The eliminated blocks depend on W and the slopes alone, and W and kappa do not change while ``System.scratch`` lives. So
the blocks are kept there from one Newton step and one visit to the next, up to the first link whose law has changed its
slope. Most steps are then a substitution, at a third of the cost.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.solve.kernels.contact_block import push, relative_velocity
from lmgcpy.solve.kernels.rounding import ROUNDING
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.kernels.wire_block import SAME, held_up, react, read, relax_link, slope


def scratch_columns(dimension: int) -> dict[str, int]:
    """First columns of the numbers of a link in the scratch, and the number of columns.

    From 0 on: right-hand side (d); SLOPES: of its rows (d); ELIMINATED: 1 if it is, and the normal slope with which;
    PIVOT_ERROR: of its normal pivot, see ``wire_block.held_up``;
    INVERSE: of its eliminated block on the diagonal (d x d); ABOVE: its eliminated block above the diagonal (d x d);
    CORNER: its block in the columns of the last link of a closed chain (d x d).
    """
    d = dimension
    inverse = 2 * d + 3
    above, corner, width = (inverse + k * d * d for k in (1, 2, 3))
    names = {"SLOPES": d, "ELIMINATED": 2 * d, "PIVOT_ERROR": 2 * d + 2}
    return names | {"INVERSE": inverse, "ABOVE": above, "CORNER": corner, "WIDTH": width}


PREPARED = 0
"""Number of numbers that the law prepares. The specialisation gives this name and those below."""
ROWS = 2
"""The dimension d."""
SLOPES, ELIMINATED, PIVOT_ERROR, INVERSE, ABOVE, CORNER, _ = scratch_columns(ROWS).values()
_of_two = small_matrices(ROWS)
block, row, square = _of_two["block"], _of_two["row"], _of_two["square"]
store_row, store_square, inverted = _of_two["store_row"], _of_two["store_square"], _of_two["inverted"]
unit, transposed, negative, scaled = (_of_two[name] for name in ("unit", "transposed", "negative", "scaled"))
product, times, plus, less = _of_two["product"], _of_two["times"], _of_two["plus"], _of_two["less"]
plus_row, less_row, scaled_row = _of_two["plus_row"], _of_two["less_row"], _of_two["scaled_row"]


def residual(start, count, offset, weight, s, until_changed=False):
    """Write -F and the slopes to the scratch; return (sum of (w F)^2, whether the law of a link changed its piece).

    ``until_changed``: whether to leave off at the first link whose law changed its piece; right-hand side and slopes are
    incomplete then.

    Normal rows are divided by ``1 + s (w - W)``, as in ``wire_block``: the slope is that for ``w_i = W_ii``, whatever the
    weight.
    """
    merit = 0.0
    changed = False
    for k in range(count):
        i = np.uintp(start + k)
        u = relative_velocity(i, s)
        r = s.impulse[i, 0]
        # normal row: F = r_n - react(w, u_n - w r_n) and the slope of react
        w = weight * s.delassus[i, 0]
        if w == 0.0:  # both bodies are held along the normal
            s.scratch[i, 0] = 0.0
            s.scratch[i, SLOPES] = 0.0
        else:
            free = (u[0] - w * r,)
            prepared = read(s.prepared, offset + k * PREPARED)
            (new,) = react(((w,),), free, prepared)
            ((gradient,),) = slope(((w,),), free, prepared)
            diagonal = 1.0 + gradient * (w - s.delassus[i, 0])
            gradient /= diagonal
            s.scratch[i, 0] = (new - r) / diagonal
            before = s.scratch[i, SLOPES]
            if abs(gradient - before) > SAME * abs(gradient) or (gradient == 0.0 and abs(new - r) > SAME * abs(new)):
                changed = True
                if until_changed:
                    break
            s.scratch[i, SLOPES] = gradient
            merit += (w * (new - r)) ** 2 + 0.0 * gradient  # a slope that is not finite must not pass for a singular matrix
        # rows across: F = r_t + kappa (u_t - c_t), slope -kappa
        stiffness = s.geometric[i]
        for a in range(1, ROWS):
            lag = -stiffness * (u[a] - s.carried[i, a - 1]) - s.impulse[i, a]
            s.scratch[i, a] = lag
            s.scratch[i, SLOPES + a] = -stiffness
            merit += (s.delassus[i, a] * lag / (1.0 + stiffness * s.delassus[i, a])) ** 2
    return merit, changed


def diagonal_block(i, gradients, s):
    """The block of the Newton matrix on the diagonal, ``I + s_n W_nn e_n e_n^T - s W``; ``gradients``: the slopes s."""
    return less(unit(gradients[0] * s.delassus[i, 0]), scaled(gradients, block(s.own, i)))


def inverse_held_up(P, error):
    """Inverse and determinant of a block whose normal pivot, the one after the rows across, is held up."""
    inverse, determinant = inverted(P)
    pivot = 1.0 / inverse[0][0] if determinant > 0.0 else 0.0
    missing = held_up(pivot, error) - pivot
    if missing == 0.0:
        return inverse, determinant
    return inverted(plus(P, less(unit(missing), unit(0.0))))


def eliminate(start, stop, s):
    """Eliminate the links one after another, from the first link on that is not eliminated or has changed its slope since.
    Returns the number of eliminated links, -1 if a block is singular."""
    count = 0
    for k in range(start, stop):
        i = np.uintp(k)
        gradients = row(s.scratch, i, SLOPES)
        same = abs(gradients[0] - s.scratch[i, ELIMINATED + 1]) <= SAME * abs(gradients[0])
        if count == 0 and same and s.scratch[i, ELIMINATED] == 1.0:
            continue
        P = diagonal_block(i, gradients, s)
        error = ROUNDING
        if k > start:  # Schur complement with the block below the diagonal, -s W_{i,i-1}
            before = np.uintp(k - 1)
            known = product(transposed(block(s.following, before)), square(s.scratch, before, ABOVE))
            P = plus(P, scaled(gradients, known))
            error += abs(gradients[0] * known[0][0] * s.scratch[before, INVERSE]) * s.scratch[before, PIVOT_ERROR]
        inverse, determinant = inverse_held_up(P, error)
        s.scratch[i, PIVOT_ERROR] = error
        if not determinant > 0.0:
            s.scratch[i, ELIMINATED] = 0.0
            return -1
        store_square(s.scratch, i, INVERSE, inverse)
        # eliminated block above the diagonal, P^-1 (-s W_{i,i+1})
        store_square(s.scratch, i, ABOVE, product(inverse, scaled(negative(gradients), block(s.following, i))))
        s.scratch[i, ELIMINATED] = 1.0
        s.scratch[i, ELIMINATED + 1] = gradients[0]
        count += 1
    return count


def substitute(start, stop, s):
    """Solve the block-tridiagonal Newton system of eliminated links for the right-hand side, in place."""
    # forward substitution
    b = times(square(s.scratch, start, INVERSE), row(s.scratch, start, 0))
    store_row(s.scratch, start, b)
    for k in range(start + 1, stop):
        i = np.uintp(k)
        known = times(transposed(block(s.following, np.uintp(k - 1))), b)
        known = scaled_row(row(s.scratch, i, SLOPES), known)
        b = times(square(s.scratch, i, INVERSE), plus_row(row(s.scratch, i, 0), known))
        store_row(s.scratch, i, b)
    # back substitution
    for k in range(stop - 2, start - 1, -1):
        i = np.uintp(k)
        b = less_row(row(s.scratch, i, 0), times(square(s.scratch, i, ABOVE), b))
        store_row(s.scratch, i, b)


def substitute_columns(start, last, s):
    """Solve the system of :func:`substitute` for the columns of the last link of a closed chain. Returns the same sum as
    ``wire_block.substitute``, over the normal pivots."""
    passed_on = 0.0
    for k in range(start, last):
        columns = less(block(s.own, k), block(s.own, k))  # zeros
        if k == start:  # W_{first,last}
            columns = plus(columns, transposed(block(s.following, last)))
        if k == last - 1:  # W_{last-1,last}
            columns = plus(columns, block(s.following, k))
        if k > start:
            known = product(transposed(block(s.following, k - 1)), square(s.scratch, k - 1, CORNER))
            columns = less(columns, known)
        columns = scaled(negative(row(s.scratch, k, SLOPES)), columns)
        columns = product(square(s.scratch, k, INVERSE), columns)
        store_square(s.scratch, k, CORNER, columns)
        if columns[0][0] != 0.0 and s.scratch[k, SLOPES] != 0.0:
            passed_on += columns[0][0] ** 2 * abs(s.scratch[k, PIVOT_ERROR] / s.scratch[k, SLOPES])
    # back substitution
    for k in range(last - 2, start - 1, -1):
        known = product(square(s.scratch, k, ABOVE), square(s.scratch, k + 1, CORNER))
        store_square(s.scratch, k, CORNER, less(square(s.scratch, k, CORNER), known))
    return passed_on


def newton_step(start, count, s):
    """Write the Newton step into the first columns of the scratch. Returns False if the matrix is singular.

    In a closed chain the last link also meets the first. Its rows and columns are split off, as in ``wire_block``.
    """
    stop = start + count
    last = stop - 1
    closed = False
    for a in range(ROWS):
        for b in range(ROWS):
            if s.following[last, a, b] != 0.0:
                closed = True
    eliminated = eliminate(start, last if closed else stop, s)
    if eliminated < 0:
        return False
    if not closed:
        substitute(start, stop, s)
        return True
    substitute(start, last, s)
    if eliminated > 0:
        s.scratch[last, PIVOT_ERROR] = substitute_columns(start, last, s)
    # rows of the last link: their blocks in the columns of the first link and of the one before, with the sign changed
    gradients = row(s.scratch, last, SLOPES)
    to_first = scaled(gradients, block(s.following, last))
    to_before = scaled(gradients, transposed(block(s.following, last - 1)))
    b = plus_row(row(s.scratch, last, 0), times(to_first, row(s.scratch, start, 0)))
    b = plus_row(b, times(to_before, row(s.scratch, last - 1, 0)))
    # Schur complement of the last link
    P = diagonal_block(last, gradients, s)
    P = plus(P, product(to_first, square(s.scratch, start, CORNER)))
    P = plus(P, product(to_before, square(s.scratch, last - 1, CORNER)))
    error = ROUNDING + abs(gradients[0]) * s.scratch[last, PIVOT_ERROR]
    inverse, determinant = inverse_held_up(P, error)
    if not determinant > 0.0:
        return False
    b = times(inverse, b)
    store_row(s.scratch, last, b)
    # correction of the others by the columns of the last link
    for k in range(start, last):
        store_row(s.scratch, k, less_row(row(s.scratch, k, 0), times(square(s.scratch, k, CORNER), b)))
    return True


def move(start, count, s):
    """Add the Newton step to the impulses."""
    for k in range(count):
        i = np.uintp(start + k)
        for a in range(ROWS):
            s.impulse[i, a] += s.scratch[i, a]
        push(i, s, row(s.scratch, i, 0))


def relax(start, count, offset, s):
    """Update the links one after another, along the normal and then across it."""
    for k in range(count):
        i = np.uintp(start + k)
        w = s.delassus[i, 0]
        if w != 0.0:
            relax_link(i, w, read(s.prepared, offset + k * PREPARED), s)
        # the linear rows across, solved one by one: r_t = -kappa (u_t - c_t) with u_t = free_t + w r_t
        u = relative_velocity(i, s)
        s.scratch[i, 0] = 0.0
        for a in range(1, ROWS):
            w = s.delassus[i, a]
            lag = -s.geometric[i] * (u[a] - s.carried[i, a - 1]) - s.impulse[i, a]
            s.scratch[i, a] = lag / (1.0 + s.geometric[i] * w)
            s.impulse[i, a] += s.scratch[i, a]
        push(i, s, row(s.scratch, i, 0))


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
        # w = trace(W) / d
        w = 0.0
        for a in range(ROWS):
            w += s.delassus[i, a] / ROWS
        if w == 0.0:
            s.squared_error[i] = 0.0
            continue
        # e_n = w (r_n - react(w, u_n - w r_n))
        u = relative_velocity(i, s)
        r = s.impulse[i, 0]
        (new,) = react(((w,),), (u[0] - w * r,), prepared)
        square = (w * (r - new)) ** 2
        # e_t = w (r_t + kappa (u_t - c_t)) / (1 + kappa w)
        stiffness = s.geometric[i]
        for a in range(1, ROWS):
            lag = s.impulse[i, a] + stiffness * (u[a] - s.carried[i, a - 1])
            square += (w * lag / (1.0 + stiffness * w)) ** 2
        s.squared_error[i] = square
        total += square
    return total
