"""Work of accelerated sweeps on their iterates, one part of the flat arrays at a time.

It belongs to the one kernel of :mod:`lmgcpy.solve.sweeps.sweep` that does all work, which plain sweeps then share: to
compile a kernel of their own would take them seconds.
"""

from __future__ import annotations

import numpy as np

STEP, EXTRAPOLATE, KEEP, TAKE_BEST, START, RESUME = map(np.int64, range(16, 22))
"""Kinds of work that plain sweeps do not have."""


def part(task, count, chunks):
    """First row, and the row after the last, of a task that works on whole arrays of ``count`` rows in ``chunks`` parts."""
    return task * count // chunks, (task + 1) * count // chunks


def squares(weight, x, y, first, last):
    """``|w (x - y)|^2`` [m^2/s^2]; four sums, so that no addition waits for the one before (5 % of a sweep)."""
    a = b = c = d = 0.0
    one, two, three = np.uintp(1), np.uintp(2), np.uintp(3)
    fours = last - (last - first) % 4
    for k in range(first, fours, 4):
        i = np.uintp(k)
        a += (weight[i] * (x[i] - y[i])) ** 2
        b += (weight[i + one] * (x[i + one] - y[i + one])) ** 2
        c += (weight[i + two] * (x[i + two] - y[i + two])) ** 2
        d += (weight[i + three] * (x[i + three] - y[i + three])) ** 2
    for k in range(fours, last):
        i = np.uintp(k)
        a += (weight[i] * (x[i] - y[i])) ** 2
    return a + b + c + d


def extrapolate(x, before, beta, first, last):
    """``x <- x + beta (x - before)`` and ``before <- x`` as it was, in place."""
    for k in range(first, last):
        i = np.uintp(k)
        here = x[i]
        x[i] = here + beta * (here - before[i])
        before[i] = here


def copy(x, y, first, last):
    """``y <- x``."""
    for k in range(first, last):
        i = np.uintp(k)
        y[i] = x[i]


def iterates_work(kind, task, job):
    """Work on one part of the iterates, by kind."""
    first, last = part(task, job.impulse.shape[0], job.chunks)
    low, high = part(task, job.velocity.shape[0], job.chunks)
    # |w (r - r_start)|^2, r_start the impulses before the sweep
    if kind == STEP:
        job.partial[task, 0] = squares(job.weight, job.impulse, job.start, first, last)
    # momentum: r <- r + beta (r - r_last), v <- v + beta (v - v_last)
    elif kind == EXTRAPOLATE:
        extrapolate(job.impulse, job.last_impulse, job.beta[0], first, last)
        copy(job.impulse, job.start, first, last)
        extrapolate(job.velocity, job.last_velocity, job.beta[0], low, high)
    # the best impulses so far, and the way back to them or to the start of the sweep
    elif kind == KEEP:
        copy(job.impulse, job.best_impulse, first, last)
    elif kind == TAKE_BEST:
        copy(job.best_impulse, job.impulse, first, last)
    elif kind == RESUME:
        copy(job.start, job.impulse, first, last)
    # begin: no momentum yet
    else:
        copy(job.impulse, job.best_impulse, first, last)
        copy(job.impulse, job.last_impulse, first, last)
        copy(job.impulse, job.start, first, last)
        copy(job.velocity, job.last_velocity, low, high)
