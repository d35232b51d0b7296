"""A whole wire as one block of Gauss-Seidel: template, specialised for a law's ``react`` and ``slope``.

The links of a chain see each other through the beads they share: their part of the Delassus operator is tridiagonal (cyclic
if the chain is closed). The system of the laws of all links,

    F_i(r) = r_i - react(w_i, u_i - w_i r_i) = 0,    any w_i > 0,

is solved by a semi-smooth Newton method. With ``s_i`` the slope of ``react`` a step ``d`` satisfies

    d_i + s_i (w_i d_i - W_{i,i-1} d_{i-1} - W_ii d_i - W_{i,i+1} d_{i+1}) = -F_i,

one elimination down the chain and one substitution up: O(n) at any tension and mass ratio. For the laws that come with
lmgcpy the matrix is a symmetric positive definite one with scaled rows, which needs no pivoting, and the method is the
active-set method, which ends after finitely many steps. ``F`` is always evaluated from the velocities of the bodies, so
that repeated steps refine the solution beyond what the elimination loses to round-off.

Under a heavy load ``w r`` dwarfs ``u``: of beads that carry a million times their weight, ``u`` is lost to round-off in
``u - W_ii r``, although it matters for the tension. Hence ``w_i`` is a small fraction of ``W_ii``. For links that are
slack or rigid, or slack or elastic, the fraction makes no difference to the active sets after the first step, as every
iterate has ``r_i`` or the law's velocity at its bound. In the first step it does: if contacts have moved a taut wire a
little, half its links look slack. And a law of three pieces, as the Voigt wire, may cycle between the two outer pieces.
If either is seen, the visit goes on with ``w_i = W_ii``, the pieces of the single updates, until the active set has
settled.

A straight wire between held beads is singular: with its ends held, a constant tension moves nothing. Its last pivot is of
the order of the square of the angles between its links, and below 1e-8 rad it is round-off of any sign. So every
pivot p comes with a bound E of its error,

    E_i = ROUNDING + (W_{i,i-1} / p_{i-1})^2 E_{i-1},        both in the scaling of row i,

and p is never less than ``FLOOR E``. This is a dashpot on one link, ``(p' - p) (r - r_before)``, which a repeated step
takes back: the solution, F = 0, stays the same, and tensions that move nothing change as little as they can.

``System.scratch`` has four columns: right-hand side, slope, eliminated superdiagonal, column of the last link of a closed
chain. The slopes stay from one visit to the next.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.solve.kernels.contact_block import normal_velocity, push_normal
from lmgcpy.solve.kernels.rounding import ROUNDING
from lmgcpy.solve.kernels.system import System

react: Callable[..., Any] = lambda W, u, prepared: u  # noqa: E731  given by the specialisation
"""The law."""
slope: Callable[..., Any] = lambda W, u, prepared: ((0.0,),)  # noqa: E731
"""Derivative of ``react``."""
read: Callable[..., Any] = lambda array, start: ()  # noqa: E731
"""Reader of one row of prepared numbers."""
PREPARED = 0
"""How many numbers the law prepares."""
LIGHT = 2.0**-20
"""w_i as a fraction of W_ii: a hanging chain with a tip mass of 1e6 beads gains four digits of tension by it."""
NEWTON_STEPS = 30
"""Bound on the steps of one visit; one or two are usual, and the next sweep goes on from where this one ends."""
FLOOR = 16.0
"""Least pivot in parts of the bound of its error. A pivot above it is right to 6 %, so a Newton step leaves at most 6 % of
the error, and the next step reduces that further."""
COLUMN = 3
"""Column of the scratch that holds the column of the last link of a closed chain."""
SAME = 1e-9
"""Relative difference up to which two slopes, or two impulses, are the same but for round-off."""


def held_up(pivot, error):
    """A pivot, raised to its least value ``FLOOR * error``; ``error``: the bound of its error."""
    return pivot if abs(pivot) >= FLOOR * error else FLOOR * error


def residual(start, count, offset, weight, s, until_changed=False):
    """Write -F and the slopes to columns 0 and 1; return (sum of (w F)^2, whether the law of a link changed its piece).

    ``until_changed``: whether to leave off at the first link whose law changed its piece; right-hand side and slopes are
    incomplete then.

    ``weight``: w_i as a fraction of W_ii. Rows are divided by their diagonal entry ``1 + s (w - W)``, which makes of every
    slope the one for ``w_i = W_ii``: the matrix does not depend on the weight.
    """
    merit = 0.0
    changed = False
    for k in range(count):
        i = np.uintp(start + k)
        w = weight * s.delassus[i, 0]
        if w == 0.0:  # both bodies are held
            s.scratch[i, 0] = 0.0
            s.scratch[i, 1] = 0.0
            continue
        prepared = read(s.prepared, offset + k * PREPARED)
        u_n = normal_velocity(i, s)
        r = s.impulse[i, 0]
        # F = r - react(w, u - w r) and the slope of react
        free = (u_n - w * r,)
        (new,) = react(((w,),), free, prepared)
        ((gradient,),) = slope(((w,),), free, prepared)
        # row of the Newton matrix over its diagonal entry
        diagonal = 1.0 + gradient * (w - s.delassus[i, 0])
        gradient /= diagonal
        s.scratch[i, 0] = (new - r) / diagonal
        # The slope tells the pieces of a law apart, up to round-off. Of two pieces of slope 0, slack and full, a step ends
        # on the one from which it was taken: there new = r.
        if abs(gradient - s.scratch[i, 1]) > SAME * abs(gradient) or (gradient == 0.0 and abs(new - r) > SAME * abs(new)):
            changed = True
            if until_changed:
                break
        s.scratch[i, 1] = gradient
        merit += (w * (new - r)) ** 2 + 0.0 * gradient  # a slope that is not finite must not pass for a singular matrix
    return merit, changed


def substitute(start, stop, s, right):
    """Solve the tridiagonal Newton system for the right-hand side in column ``right`` of the scratch, in place.

    Column 2 holds the eliminated superdiagonal. If the right-hand side is the column of a further link, the errors of the
    pivots cause an error of its Schur complement: the returned sum times its slope.
    """
    x = above = coupling = error = passed_on = 0.0
    inverse = 1.0
    for k in range(start, stop):
        i = np.uintp(k)
        gradient = s.scratch[i, 1]
        # elimination of the subdiagonal -s_i W_{i,i-1}
        lower = -gradient * coupling
        taken = lower * above
        # pivot, and the bound of its error
        error = ROUNDING + abs(taken * inverse) * error
        pivot = held_up(1.0 - taken, error)
        inverse = 1.0 / pivot  # beside the divisions that follow, and not after them, as the next error would be
        x = (s.scratch[i, right] - lower * x) / pivot
        if right == COLUMN and gradient != 0.0:
            passed_on += x * x * abs(error / gradient)
        # eliminated superdiagonal -s_i W_{i,i+1} / pivot
        coupling = s.coupling[i] if k < stop - 1 else 0.0
        above = -gradient * coupling / pivot
        s.scratch[i, right] = x
        s.scratch[i, 2] = above
    # back substitution
    for k in range(stop - 2, start - 1, -1):
        i = np.uintp(k)
        x = s.scratch[i, right] - s.scratch[i, 2] * x
        s.scratch[i, right] = x
    return passed_on


def newton_step(start, count, s):
    """Write the Newton step into column 0 of the scratch. Returns True: pivots that are held up are never zero.

    In a closed chain the last link also meets the first. Its row and column are split off: two substitutions for the
    other links, then the equation of the last link.
    """
    last = start + count - 1
    corner = s.coupling[last]
    if corner == 0.0:
        substitute(start, last + 1, s, 0)
        return True
    # row of the last link: its entries in the columns of the first link and of the one before
    to_first = -s.scratch[last, 1] * corner
    to_before = -s.scratch[last, 1] * s.coupling[last - 1]
    # column of the last link
    for i in range(start, last):
        s.scratch[i, COLUMN] = 0.0
    s.scratch[start, COLUMN] += -s.scratch[start, 1] * corner
    s.scratch[last - 1, COLUMN] += -s.scratch[last - 1, 1] * s.coupling[last - 1]
    substitute(start, last, s, 0)
    error = ROUNDING + abs(s.scratch[last, 1]) * substitute(start, last, s, COLUMN)
    # Schur complement of the last link
    taken = to_first * s.scratch[start, COLUMN] + to_before * s.scratch[last - 1, COLUMN]
    pivot = held_up(1.0 - taken, error)
    x = (s.scratch[last, 0] - to_first * s.scratch[start, 0] - to_before * s.scratch[last - 1, 0]) / pivot
    s.scratch[last, 0] = x
    # correction of the others by the column of the last link
    for i in range(start, last):
        s.scratch[i, 0] -= x * s.scratch[i, COLUMN]
    return True


def move(start, count, s):
    """Add the Newton step, column 0 of the scratch, to the impulses."""
    for k in range(count):
        i = np.uintp(start + k)
        d = s.scratch[i, 0]
        if d != 0.0:
            s.impulse[i, 0] += d
            push_normal(i, s, d)


def relax_link(i, w, prepared, s):
    """Update one link along its normal by itself, as a contact is updated."""
    r = s.impulse[i, 0]
    (new,) = react(((w,),), (normal_velocity(i, s) - w * r,), prepared)
    s.impulse[i, 0] = new
    push_normal(i, s, new - r)


def relax(start, count, offset, s):
    """Update the links one after another, as contacts are updated."""
    for k in range(count):
        i = np.uintp(start + k)
        w = s.delassus[i, 0]
        if w == 0.0:
            continue
        relax_link(i, w, read(s.prepared, offset + k * PREPARED), s)


def sweep(start, stop, offset, s: System):
    """Solve the links of one chain together."""
    count = stop - start
    weight = LIGHT
    cycled = False
    merit, changed = residual(start, count, offset, weight, s, until_changed=True)
    if changed:  # the active set differs from the one at the end of the last visit, or this is the first visit
        weight = 1.0
        merit, _ = residual(start, count, offset, weight, s)
    enough = 1e-24 * merit
    for _ in range(NEWTON_STEPS):
        if merit <= enough:
            break
        if not newton_step(start, count, s):  # singular matrix
            relax(start, count, offset, s)
            merit, _ = residual(start, count, offset, weight, s)
            continue
        move(start, count, s)
        before = merit
        merit, changed = residual(start, count, offset, weight, s)
        if not changed and weight != LIGHT:  # the active set has settled: what a heavy load leaves to round-off comes next
            weight = LIGHT
            merit, _ = residual(start, count, offset, weight, s)
        elif not changed and not merit < 0.1 * before:  # Newton's step is exact on a settled active set
            break
        elif changed and not merit < before and weight == LIGHT:
            if cycled:
                break
            # the active set cycles: one pass of single updates, and their weight until it settles
            relax(start, count, offset, s)
            cycled = True
            weight = 1.0
            merit, _ = residual(start, count, offset, weight, s)
            enough = 0.0
        elif changed and not merit < before:
            relax(start, count, offset, s)
            merit, _ = residual(start, count, offset, weight, s)
    return 0.0 * merit  # 0, or NaN if the merit is not finite
