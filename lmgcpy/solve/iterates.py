"""What accelerated sweeps do to their iterates, one part of the flat arrays at a time.

It belongs to the one kernel of :mod:`lmgcpy.solve.sweeps` that does all work, which plain sweeps then share: to compile a
kernel of their own would take them seconds.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.by_address import read

STEP, EXTRAPOLATE, KEEP, TAKE_BEST, START = map(np.int64, range(12, 17))
"""Kinds of work beyond those of plain sweeps."""


def part(task, count, chunks):
    """Which of so many rows a task has that works on whole arrays: the first, and the one after the last."""
    return task * count // chunks, (task + 1) * count // chunks


def squares(weight, x, y):
    """``|w (x - y)|^2`` [m^2/s^2]; four sums, so that no addition waits for the one before (5 % of a sweep)."""
    a = b = c = d = 0.0
    fours = weight.shape[0] - weight.shape[0] % 4
    for i in range(0, fours, 4):
        a += (weight[i] * (x[i] - y[i])) ** 2
        b += (weight[i + 1] * (x[i + 1] - y[i + 1])) ** 2
        c += (weight[i + 2] * (x[i + 2] - y[i + 2])) ** 2
        d += (weight[i + 3] * (x[i + 3] - y[i + 3])) ** 2
    for i in range(fours, weight.shape[0]):
        a += (weight[i] * (x[i] - y[i])) ** 2
    return a + b + c + d


def extrapolate(x, last, beta):
    """``x <- x + beta (x - last)`` and ``last <- x`` as it was, in place."""
    for i in range(x.shape[0]):
        here = x[i]
        x[i] = here + beta * (here - last[i])
        last[i] = here


def copy(x, y):
    """``y <- x``."""
    for i in range(x.shape[0]):
        y[i] = x[i]


def iterates_work(kind, task, job):
    """Work on one part of the iterates, by kind."""
    step = read(job)
    own = step.iterates
    impulse = step.s.impulse.reshape(-1)
    velocity = step.s.velocity.reshape(-1)
    first, last = part(task, impulse.shape[0], step.chunks)
    low, high = part(task, velocity.shape[0], step.chunks)
    here = impulse[first:last]
    if kind == STEP:
        step.partial[task, 0] = squares(own.weight[first:last], here, own.start[first:last])
    elif kind == EXTRAPOLATE:
        extrapolate(here, own.last_impulse[first:last], step.beta[0])
        copy(here, own.start[first:last])
        extrapolate(velocity[low:high], own.last_velocity[low:high], step.beta[0])
    elif kind == KEEP:
        copy(here, own.best_impulse[first:last])
    elif kind == TAKE_BEST:
        copy(own.best_impulse[first:last], here)
    else:
        copy(here, own.best_impulse[first:last])
        copy(here, own.last_impulse[first:last])
        copy(here, own.start[first:last])
        copy(velocity[low:high], own.last_velocity[low:high])
