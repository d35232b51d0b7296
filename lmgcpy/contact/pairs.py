"""Narrow phase: one function a pair of contactor kinds.

``narrow(position_c, shape_c, position_a, shape_a)`` gets the position (x, y, angle) and the shape (a tuple of numbers) of
the candidate's and of the antagonist's contactor and returns ``gap [m], (n_x, n_y), (p_x, p_y)``: the distance between
the surfaces, the unit normal from the antagonist to the candidate, and the contact point, the middle of the gap. It is
compiled. Angles are [rad].
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass

from lmgcpy.errors import closest


@dataclass(frozen=True)
class Pair:
    """How two kinds of contactor meet. ``central``: the contact point lies on the normal through both centres."""

    narrow: Callable
    central: bool
    flipped: bool = False


_pairs: dict[tuple[str, str], Pair] = {}


def register_pair(candidate: str, antagonist: str, narrow: Callable, *, central: bool = False) -> None:
    """Tell how a contactor kind meets another; the reverse order follows.

    ``central``: True only if for every position the contact point lies on the line along the normal through the centre
    of each of the two (for an unbounded contactor, which does not spin, this is not asked).
    """
    expected = ("position_c", "shape_c", "position_a", "shape_a")
    got = tuple(inspect.signature(narrow).parameters)
    if got != expected:
        raise TypeError(f"A narrow phase takes ({', '.join(expected)}), {narrow.__qualname__} takes ({', '.join(got)}).")
    _pairs[candidate, antagonist] = Pair(narrow, central)


def find_pair(candidate: str, antagonist: str) -> Pair:
    """The narrow phase of two kinds; LookupError if nobody has told how they meet."""
    if (candidate, antagonist) in _pairs:
        return _pairs[candidate, antagonist]
    if (antagonist, candidate) in _pairs:
        pair = _pairs[antagonist, candidate]
        return Pair(pair.narrow, pair.central, flipped=True)
    known = [f"{c}-{a}" for c, a in _pairs]
    raise LookupError(
        f"No narrow phase tells how contactors '{candidate}' and '{antagonist}' meet"
        f"{closest(f'{candidate}-{antagonist}', known)} Add one with lmgcpy.contact.register_pair."
    )


def disk_disk(position_c, shape_c, position_a, shape_a):
    """Two disks of radii ``shape[0]`` [m]; with coincident centres the normal is upward."""
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    distance = math.sqrt(x * x + y * y)
    gap = distance - shape_c[0] - shape_a[0]
    n_x = 0.0
    n_y = 1.0
    if distance > 0.0:
        n_x = x / distance
        n_y = y / distance
    reach = shape_a[0] + 0.5 * gap
    return gap, (n_x, n_y), (position_a[0] + reach * n_x, position_a[1] + reach * n_y)


def disk_wall(position_c, shape_c, position_a, shape_a):
    """A disk of radius ``shape_c[0]`` and the half-space behind a line with outward unit normal ``shape_a``."""
    n_x, n_y = shape_a
    distance = n_x * (position_c[0] - position_a[0]) + n_y * (position_c[1] - position_a[1])
    gap = distance - shape_c[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, (n_x, n_y), (position_c[0] - reach * n_x, position_c[1] - reach * n_y)


register_pair("disk", "disk", disk_disk, central=True)
register_pair("disk", "wall", disk_wall, central=True)
