"""Narrow phases of users and plug-ins: their answers are checked, as the answers of laws are.

A normal that is twice too long halves impulses. A normal of no length or an infinite gap lets bodies fall through each
other, a normal that points inward holds them together, and a point far from both bodies turns them. The kernels of foreign
pairs check the gap and the normal of every pair (:func:`lmgcpy.contact.meeting.is_sound`); this file checks the rest and
names the pair in errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
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
INWARD = -0.5
"""Growth of the gap by the way along the normal below which this points inward; it is 1 for normals of distances, -1 for
their opposites, and 0 on the axis of a cylinder, where a way in any direction narrows the gap."""
CLOSE = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Distances from touching, in parts of the size of both contactors, at which normals are looked at."""
NEAR = 1e-6
"""By how much, in parts of the radius, a contact point may be farther from a contactor than its radius and the gap."""


class NarrowPhaseError(RuntimeError):
    """Carries the clause on what a narrow phase did, for a sentence that names the step."""


def check_narrow_phase(kinds: KindPair, contactors: ContactorTable, dimension: int) -> None:
    """Call a narrow phase in plain Python before it is compiled: one contactor of each kind, around each other, apart and
    into each other, and close to touching.

    TypeError if it fails or returns a wrong answer. ValueError if its normal points inward, found by the gap: if bodies
    move apart along n the gap grows, d gap/d x_c . n = 1 for any gap that is a distance. Pairs that are apart and pairs
    that overlap are judged separately, as n = d / gap changes its sign with the gap: one group that fails is enough. Close
    to touching one pair that fails is enough.
    """
    pair = kinds.pair
    ids = [int(np.argmax(mine)) for mine in (kinds.is_candidate, kinds.is_antagonist)]
    sizes = [float(contactors.bounding_radius[k]) for k in ids]
    shapes = [tuple(contactors.shape[k, :size].tolist()) for k, size in zip(ids, kinds.shape_sizes, strict=True)]
    across = sum(size for size in sizes if np.isfinite(size)) or 1.0
    growth: dict[bool, list[float]] = {False: [], True: []}

    def placed(distance: float, angle: float) -> tuple[Any, ...]:
        """Arguments of the narrow phase for the first contactor at so many times the size of both from the second."""
        x, y = (distance * across * of(angle) for of in (math.cos, math.sin))
        there: tuple[float, ...] = (x, y, angle if dimension == 2 else 0.1 * across)
        here: tuple[float, ...] = (0.0, 0.0, 0.0)
        if kinds.width == 7:
            there, here = (*there, 0.5, -0.5, 0.5, 0.5), (*here, 0.0, 0.0, 0.0, 1.0)
        given = there, shapes[0], here, shapes[1]
        return (*given[2:], *given[:2]) if pair.flipped else given

    for near, angle in product((1.01, 0.9, 0.6, 0.3), (0.3, 2.0, 4.5)):
        given = placed(near, angle)
        try:
            with np.errstate(all="ignore"):
                answer = pair.narrow(*given)
        except PROGRAM as error:
            raise TypeError(f"T{_who(kinds)[1:]} raised {told(error)} at {shown(given)}: mend it.") from error
        except Exception:  # these numbers may be beyond its range: if it happens in a step, the error names the pair
            continue
        if not _is_answer(answer, dimension):
            raise TypeError(f"T{_who(kinds)[1:]} returned {shown(answer)}, expected {_expected(dimension)}.")
        if is_sound(*answer[:2]):
            growth[answer[0] < 0.0].append(_growth(pair.narrow, given, answer[1], 1e-3 * across))
    inward = [
        "overlap" if overlapping else "are apart"
        for overlapping, rates in growth.items()
        if rates and all(rate < INWARD for rate in rates)
    ]
    for angle in np.linspace(0.3, 6.0, 8).tolist():
        touching = _touching(lambda distance: _answer(pair.narrow, placed(distance, angle))[0])  # noqa: B023
        for depth, side in product(CLOSE, (1.0, -1.0)):
            given = placed(touching + side * depth, angle)
            gap, normal = _answer(pair.narrow, given)
            if is_sound(gap, normal) and _growth(pair.narrow, given, normal, 0.1 * depth * across) < INWARD:
                inward.append(f"have a gap of {gap:.2g} m")
    if inward:
        raise ValueError(
            f"T{_who(kinds)[1:]} returned a normal that points inward for contactors that {inward[0]}: the gap shrinks if "
            "the candidate moves along it. It points from the antagonist to the candidate: turn its sign."
        )


def _touching(gap: Callable[[float], float]) -> float:
    """A distance at which two contactors touch, by bisection; NaN if none is found from a tenth to four times their
    sizes."""
    inner, outer = 0.1, 4.0
    sign = math.copysign(1.0, gap(inner))
    if not gap(outer) * sign < 0.0:
        return math.nan
    for _ in range(40):
        middle = 0.5 * (inner + outer)
        inner, outer = (middle, outer) if gap(middle) * sign > 0.0 else (inner, middle)
    return outer


def _answer(narrow: Callable, given: tuple[Any, ...]) -> tuple[float, tuple[float, ...]]:
    """Gap and normal of a narrow phase, NaN if the call fails."""
    try:
        with np.errstate(all="ignore"):
            gap, normal, _ = narrow(*given)
        return float(gap), tuple(normal)
    except Exception:  # if it happens in a step, the error names the pair
        return math.nan, ()


def _growth(narrow: Callable, given: tuple[Any, ...], normal: tuple[float, ...], step: float) -> float:
    """Growth of the gap over the way of the candidate along the normal, d gap/d x_c . n; NaN if a call fails."""
    position, *others = given
    gaps = []
    for way in (-step, step):
        moved = [x + way * n for x, n in zip(position, normal, strict=False)]
        gaps.append(_answer(narrow, ((*moved, *position[len(moved) :]), *others))[0])
    return (gaps[1] - gaps[0]) / (2.0 * step)


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
    """The exception to raise if a narrow phase raised an ``error``, or returned a wrong answer, at one of these pairs
    (q, 2). The function calls it again in plain Python to find the pair."""
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
    """The exception to raise if the pair is not known, for example while lists of neighbours are made."""
    if not isinstance(error, CompilerError):
        return NarrowPhaseError(f"{_who(kinds)} raised {told(error)}")
    reason = str(error).strip().splitlines() or ["no reason was given"]
    return TypeError(f"T{_who(kinds)[1:]} cannot be compiled: {shown(reason[-1])}.")


def check_points(group: Group, found: Interactions, stop: int, contactors: ContactorTable) -> None:
    """NarrowPhaseError if a contact point of a group is farther from a bounded contactor than its radius and the gap."""
    rows = slice(group.start, stop)
    pairs = group.pairs[found.slot[rows] - group.first_slot]
    lever = found.arm[rows] ** 2
    if len(found.lateral):
        lever = lever + found.lateral[rows] ** 2
    if len(found.lever):
        lever = (found.lever[rows].reshape(-1, 2, 3) ** 2).sum(axis=2)
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
