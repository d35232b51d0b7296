"""Narrow phases of strangers: what they return is looked at, as what laws return is.

A normal that is twice too long halves impulses, one of no length and an infinite gap let bodies fall through each other,
and a point far from both turns them. The kernels of foreign pairs look at gap and normal of every pair
(:func:`lmgcpy.contact.meeting.is_sound`); here is what looks at the points, and what names the pair.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import CompilerError
from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.groups import Group
from lmgcpy.contact.images import Seen
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.meeting import is_sound
from lmgcpy.contact.neighbours import KindPair
from lmgcpy.errors import shown, told

PROGRAM = (NameError, AttributeError, TypeError, IndexError)
"""Errors that are faults of the program, whatever the positions are."""
NEAR = 1e-6
"""By how much, in parts of the radius, a contact point may be farther from a contactor than its radius and the gap."""


class NarrowPhaseError(RuntimeError):
    """Carries the clause on what a narrow phase did, for a sentence that names the step."""


def check_narrow_phase(kinds: KindPair, contactors: ContactorTable, dimension: int) -> None:
    """TypeError where a narrow phase fails or returns what it must not in some calls in plain Python, before it is
    compiled: one contactor of each kind, around each other."""
    pair = kinds.pair
    ids = [int(np.argmax(mine)) for mine in (kinds.is_candidate, kinds.is_antagonist)]
    sizes = [float(contactors.bounding_radius[k]) for k in ids]
    shapes = [tuple(contactors.shape[k, :size].tolist()) for k, size in zip(ids, kinds.shape_sizes, strict=True)]
    across = sum(size for size in sizes if np.isfinite(size)) or 1.0
    for angle in (0.3, 2.0, 4.5):
        there = (
            1.01 * across * math.cos(angle),
            1.01 * across * math.sin(angle),
            angle if dimension == 2 else 0.1 * across,
        )
        given: tuple[Any, ...] = there, shapes[0], (0.0, 0.0, 0.0), shapes[1]
        given = (*given[2:], *given[:2]) if pair.flipped else given
        try:
            with np.errstate(all="ignore"):
                answer = pair.narrow(*given)
        except PROGRAM as error:
            raise TypeError(f"T{_who(kinds)[1:]} raised {told(error)} at {shown(given)}: mend it.") from error
        except Exception:  # too much for the numbers given: a step tells where it happens
            continue
        if not _is_answer(answer, dimension):
            raise TypeError(f"T{_who(kinds)[1:]} returned {shown(answer)}, expected {_expected(dimension)}.")


def _who(kinds: KindPair) -> str:
    pair = kinds.pair
    names = (kinds.antagonist, kinds.candidate) if pair.flipped else (kinds.candidate, kinds.antagonist)
    return f"the narrow phase {'-'.join(names)} ({pair.name})"


def _expected(dimension: int) -> str:
    axes = "xyz"[:dimension]
    normal, point = (", ".join(f"{what}_{axis}" for axis in axes) for what in "np")
    return f"(gap, ({normal}), ({point})), numbers"


def _is_answer(answer: Any, dimension: int) -> bool:
    """Whether it is a gap and two tuples of numbers."""
    if not (isinstance(answer, tuple) and len(answer) == 3):
        return False
    gap, normal, point = answer
    vectors = all(isinstance(given, tuple) and len(given) == dimension for given in (normal, point))
    return vectors and all(isinstance(value, (int, float, np.number)) for value in (gap, *normal, *point))


def narrow_fault(
    group: Group, pairs: np.ndarray, seen: Seen, stride: int, dimension: int, error: Exception | None = None
) -> Exception:
    """What to raise where a narrow phase raised an ``error``, or gave what it must not, at one of these pairs (q, 2): it is
    asked again, in plain Python."""
    assert group.kinds is not None
    if isinstance(error, CompilerError):
        return listing_fault(group.kinds, error)
    pair, shapes = group.kinds.pair, seen.shapes.reshape(-1, stride)
    for k_c, k_a in pairs.tolist():
        ends = [
            (tuple(seen.placed[k].tolist()), tuple(shapes[k, :size].tolist()))
            for k, size in zip((k_c, k_a), group.kinds.shape_sizes, strict=True)
        ]
        (position_c, shape_c), (position_a, shape_a) = ends[::-1] if pair.flipped else ends
        at = f"{_who(group.kinds)} between bodies {seen.body[k_c]} and {seen.body[k_a]}"
        try:
            with np.errstate(all="ignore"):
                gap, normal, _ = pair.narrow(position_c, shape_c, position_a, shape_a)
            if not is_sound(gap, normal):
                return NarrowPhaseError(
                    f"{at} returned a gap of {gap:g} m and the normal {shown(normal)}: the gap must be "
                    "finite, and the normal of length one"
                )
        except Exception as raised:
            return NarrowPhaseError(f"{at} raised {told(raised)}")
    return listing_fault(group.kinds, error)


def listing_fault(kinds: KindPair, error: Exception | None) -> Exception:
    """The same where no pair is known, as where lists of neighbours are made."""
    if not isinstance(error, CompilerError):
        return NarrowPhaseError(f"{_who(kinds)} raised {told(error)}")
    reason = str(error).strip().splitlines() or ["no reason was given"]
    return TypeError(f"T{_who(kinds)[1:]} cannot be compiled: {shown(reason[-1])}.")


def check_points(group: Group, found: Interactions, stop: int, contactors: ContactorTable) -> None:
    """NarrowPhaseError where a contact point of a group is farther from a bounded contactor than its radius and the gap."""
    rows = slice(group.start, stop)
    pairs = group.pairs[found.slot[rows] - group.first_slot]
    lever = found.arm[rows] ** 2
    if len(found.lateral):
        lever = lever + found.lateral[rows] ** 2
    radius = contactors.bounding_radius[pairs]
    reach = radius + np.hypot.reduce(contactors.offset, axis=1)[pairs] + np.abs(found.gap[rows])[:, None]
    far = np.isfinite(reach) & ~(np.sqrt(lever) <= reach + NEAR * radius)
    if far.any():
        assert group.kinds is not None
        row, side = np.argwhere(far)[0]
        bodies = found.candidate[rows][row], found.antagonist[rows][row]
        distance = np.sqrt(lever[row, side])
        raise NarrowPhaseError(
            f"{_who(group.kinds)} between bodies {bodies[0]} and {bodies[1]} returned a contact point {distance:g} m "
            f"from the centre of body {bodies[side]}, farther than its radius and the gap"
        )
