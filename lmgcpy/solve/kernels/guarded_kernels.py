"""Kernels of laws that end if a law raises or returns NaN, instead of going on.

A C function cannot pass an exception to its caller; numba would print it and go on. :func:`guard` makes a kernel that
returns NaN instead, which ends the solver. It costs nothing elsewhere: only laws with a ``raise`` get it, and a solve that
is repeated to find its fault.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.errors import LARGEST

body: Callable[..., Any] = Slot("body")  # given by the specialisation, as the next two
compute: Callable[..., Any] = Slot("compute")
read: Callable[..., Any] = Slot("read")


def guard(start, stop, offset, s):
    """The value of ``body``, NaN if it raises."""
    try:
        result = body(start, stop, offset, s)
    except Exception:
        result = np.nan
    return result


def noting_guard(start, stop, offset, s):
    """As :func:`guard`; the first fault is noted in the last but one of the prepared numbers. After a fault nothing is done
    any more, so that the numbers read last and the velocities belong to the fault."""
    if s.prepared[-2] != 0.0:
        return np.nan
    try:
        result = body(start, stop, offset, s)
    except Exception:
        s.prepared[-2] = 1.0
        result = np.nan
    return result


def noting_reader(array, start):
    """Read a row of prepared numbers and note in the last entry where it begins."""
    array[-1] = start
    return read(array, start)


def finite_vector(W, u, prepared):
    """The law's ``react``; raises if a component is not finite, or so large that its square may overflow, which would be
    seen first in the velocities that another law is given."""
    impulse = compute(W, u, prepared)
    for component in impulse:
        if not abs(component) <= LARGEST:
            raise FloatingPointError
    return impulse


def finite_matrix(W, u, prepared):
    """The law's ``slope``; raises if an entry is not finite."""
    rows = compute(W, u, prepared)
    for row in rows:
        for entry in row:
            if not np.isfinite(entry):
                raise FloatingPointError
    return rows
