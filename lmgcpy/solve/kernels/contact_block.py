"""One interaction as a block of Gauss-Seidel, in 2D and 3D: templates, specialised for a law's ``react``
(``lmgcpy.compiled.kernel``).

With the relative velocity ``u`` under the present impulses, the free velocity of one interaction is ``u - W r``. The law
gives the new impulse, and the bodies' velocities follow at once. The form of the interaction (``forms``) defines how ``u``
is read and how an impulse is given to the bodies. Vectors are tuples of d numbers (``small_matrices``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.solve.kernels.system import System

react: Callable[..., Any] = Slot("react")  # given by the specialisation
"""The law."""
read: Callable[..., Any] = Slot("read")
"""Reader of one row of prepared numbers."""
PREPARED = 0
"""Number of numbers that the law prepares."""
ROWS = 2
"""Number of components of the law's impulse; 1 if it is normal only."""
relative_velocity: Callable[..., Any] = Slot("relative_velocity")
"""Computes ``H^T v``. This function and those below exist once for 2D and once for 3D."""
push: Callable[..., Any] = Slot("push")
"""Adds ``M^-1 H d``."""
local_problem: Callable[..., Any] = Slot("local_problem")
"""W and ``u - W r``."""
row: Callable[..., Any] = Slot("row")
store_row: Callable[..., Any] = Slot("store_row")
exactly: Callable[..., Any] = Slot("exactly")
first_only: Callable[..., Any] = Slot("first_only")
differ: Callable[..., Any] = Slot("differ")
mean: Callable[..., Any] = Slot("mean")
multiple: Callable[..., Any] = Slot("multiple")
multiple_row: Callable[..., Any] = Slot("multiple_row")
less_row: Callable[..., Any] = Slot("less_row")
squares: Callable[..., Any] = Slot("squares")


def normal_velocity(i, s):
    """u_n of link ``i``."""
    return relative_velocity(i, s)[0]


def push_normal(i, s, d):
    """Add a normal impulse to link ``i``."""
    push(i, s, first_only(d))


def sweep(start, stop, offset, s: System):
    """Update the impulses of a group one after another."""
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)  # an unsigned index is not tested for counting from the end: gains 10 %
        u = relative_velocity(i, s)
        if ROWS == 1:
            w = s.delassus[i, 0]
            if w == 0.0:  # a link between bodies that are both held
                continue
            r_n = s.impulse[i, 0]
            # the law at the free velocity u_n - W_nn r_n
            (new_n,) = react(((w,),), (u[0] - w * r_n,), prepared)
            if new_n != r_n:
                s.impulse[i, 0] = new_n
                push_normal(i, s, new_n - r_n)
        else:
            r = row(s.impulse, i, 0)
            # the law at the free velocity u - W r
            W, free = local_problem(i, s, u, r)
            new = exactly(react(W, free, prepared))
            if differ(new, r):
                # v <- v + M^-1 H (new - r)
                store_row(s.impulse, i, new)
                push(i, s, less_row(new, r))
    return 0.0


def error(start, stop, offset, s: System):
    """Sum of squares of ``e = w (r - react(w I, u - w r))`` over a group [m^2/s^2], w the mean diagonal of its W; the
    squares are left in ``s.squared_error``."""
    total = 0.0
    for k in range(start, stop):
        prepared = read(s.prepared, offset + (k - start) * PREPARED)
        i = np.uintp(k)
        u = relative_velocity(i, s)
        # normal row alone: e_n = W_nn (r_n - react(W_nn, u_n - W_nn r_n))
        if ROWS == 1:
            w = s.delassus[i, 0]
            if w == 0.0:
                s.squared_error[i] = 0.0
                continue
            r_n = s.impulse[i, 0]
            (new_n,) = react(((w,),), (u[0] - w * r_n,), prepared)
            square = (w * (r_n - new_n)) ** 2
        else:
            # the law with w I for W: for any w > 0 it gives r back if r is the solution
            w = mean(row(s.delassus, i, 0))
            r = row(s.impulse, i, 0)
            new = exactly(react(multiple(w), less_row(u, multiple_row(w, r)), prepared))
            square = squares(multiple_row(w, less_row(r, new)))
        s.squared_error[i] = square
        total += square
    return total
