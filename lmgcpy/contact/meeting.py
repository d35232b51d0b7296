"""How two contactors meet: the part shared by all kernels that call the narrow phase of a pair of kinds.

A kernel that calls :func:`meet` is specialised with ``KindPair.meaning`` (see :mod:`lmgcpy.contact.neighbours`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import row_reader

narrow: Callable[..., Any] = Slot("narrow")
"""The narrow phase of the pair, given by the specialisation like the three names below."""
read_shape_c: Callable[..., Any] = row_reader(1)
read_shape_a: Callable[..., Any] = row_reader(1)
FLIPPED = False
"""The candidate is the antagonist of the narrow phase."""
read_position: Callable[..., Any] = row_reader(3)
WIDTH = 3
"""Numbers of a position; 7 in scenes with bodies that keep a rotation in space."""
FOREIGN = False
"""Whether the narrow phase is not lmgcpy's own; its answers are then checked."""
UNIT = 1e-6
"""Largest difference of the square of a normal from one; impulses are wrong by the same share."""


def is_sound(gap, n):
    """Whether a gap is finite and a normal one."""
    square = 0.0
    for component in n:
        square += component * component
    return abs(gap) < np.inf and abs(square - 1.0) <= UNIT


def meet(k_c, k_a, contactors, shapes, stride):
    """(gap [m], normal, contact point [m]) of the contactors ``k_c`` and ``k_a``; the caller multiplies the normal with
    :func:`normal_sign`.

    ``contactors``: their positions, flat; ``shapes``: the numbers of their shapes, flat, ``stride`` of them each.
    """
    position_c = read_position(contactors, WIDTH * k_c)
    position_a = read_position(contactors, WIDTH * k_a)
    shape_c = read_shape_c(shapes, stride * k_c)
    shape_a = read_shape_a(shapes, stride * k_a)
    if FLIPPED:
        return narrow(position_a, shape_a, position_c, shape_c)
    return narrow(position_c, shape_c, position_a, shape_a)


def normal_sign():
    """Factor (1 or -1) that turns the normal of the narrow phase into the normal from the antagonist to the candidate."""
    return -1.0 if FLIPPED else 1.0
