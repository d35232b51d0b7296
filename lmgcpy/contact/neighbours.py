"""Lists of neighbours: the pairs of contactors that a row of the visibility table concerns, by kinds of contactor.

Distances between surfaces say up to which gap a pair is in a list, and up to which it is an interaction. Lists are made in
O(n): pairs come sorted from the grid of cells and stay sorted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import kernel, row_reader
from lmgcpy.contact.broad_phase import ExcludedPairs, by_first
from lmgcpy.contact.contactor_pairs import NarrowPhase, can_touch, find_pair, is_foreign
from lmgcpy.contact.detection_tables import ContactorTable, VisibilityRow
from lmgcpy.contact.elements import corners_of
from lmgcpy.contact.features import oriented
from lmgcpy.contact.meeting import meet

STEPS_A_LIST = 4
"""Number of steps at the greatest speed for which a list of neighbours is meant to last."""
FEW, STEPS_OF_FEW = 100, 20
"""With at most ``FEW`` contactors a list is meant to last ``STEPS_OF_FEW`` steps: to look at all of their pairs costs less
than to make a list."""


class Distances:
    """The alert distances of a visibility table and the reach of its lists of neighbours [m]."""

    def __init__(self, contactors: ContactorTable, rows: list[VisibilityRow], meets_walls: list[bool]):
        """``meets_walls``: whether contactors without bounds take part in a row."""
        self._fixed = max([0.0, *(max(row.alert, row.reach) for row in rows if not row.adaptive)])
        adaptive = {(row.alert, row.reach, walls) for row, walls in zip(rows, meets_walls, strict=True) if row.adaptive}
        self._adaptive = sorted(adaptive)
        bounded = np.isfinite(contactors.size)
        radii = contactors.size[bounded]
        self._largest = float(radii.max()) if len(radii) else 0.0
        self._lasting = STEPS_OF_FEW if len(radii) <= FEW else STEPS_A_LIST
        # a contactor off the centre of its body swings about it
        swing = np.sqrt((contactors.swing * contactors.swing).sum(axis=1))[bounded]
        self.cap = float((radii + swing).max()) if len(radii) else 0.0
        """Bound of the adaptive alert distance of two bounded contactors."""
        self._skin = max([0.2 * float(radii.min()) if len(radii) else 0.0, *(row.alert for row in rows)])
        greatest = [self.alert(row, np.inf) for row in rows if row.adaptive]
        fixed = [max(row.alert, row.reach) for row in rows]
        self.fullest = max(greatest + fixed) + max(self._skin, 0.5 * self._largest) if greatest else np.inf
        """Reach of the widest list; a list of this reach holds all pairs with walls."""

    def alert(self, row: VisibilityRow, travel: float, closing: float = 0.0) -> float:
        """Alert distance of a row [m]. If the user gave none, it covers the distance that two bodies at the greatest speed
        close in a step, ``travel`` each, up to the largest radius (with the offset of its contactor): a contact seen too
        late starts with a penetration. For contactors without bounds it covers ``closing``, however large that is. The
        reach of a law that acts at a distance is added. A distance that the user gave is raised to the reach."""
        if not row.adaptive:
            return max(row.alert, row.reach)
        return row.reach + max(row.alert, min(2.0 * travel, self.cap), closing)

    def widest_alert(self, travel: float, closing: float) -> float:
        """The greatest alert distance."""
        widest, covered = self._fixed, min(2.0 * travel, self.cap)
        for alert, reach, walls in self._adaptive:
            widest = max(widest, reach + max(alert, covered, closing if walls else 0.0))
        return widest

    def reach(self, widest: float, travel: float) -> float:
        """Reach of a list made now, ``widest`` being the greatest alert distance of bounded contactors: lists that last
        longer hold more pairs, and every step looks at all of them."""
        return widest + max(self._skin, min(2.0 * self._lasting * travel, 0.5 * self._largest))


@dataclass(frozen=True)
class KindPair:
    """The contactors of one row of the visibility table that are of one kind each."""

    candidate: str
    antagonist: str
    is_candidate: np.ndarray
    """Whether each contactor may be a candidate, (k,) bool."""
    is_antagonist: np.ndarray
    """Whether each contactor may be an antagonist, (k,) bool."""
    shape_sizes: tuple[int, int]
    """Length of the shape of each of the two kinds."""
    width: int = 3
    """Length of a position."""

    @property
    def pair(self) -> NarrowPhase:
        """The narrow phase of the two kinds; LookupError if there is none."""
        return find_pair(self.candidate, self.antagonist)

    @property
    def meaning(self) -> dict[str, Any]:
        """Arguments for ``specialise`` of kernels that call :func:`lmgcpy.contact.meeting.meet`."""
        size_c, size_a = self.shape_sizes
        readers: dict[str, Any] = {"read_shape_c": row_reader(size_c), "read_shape_a": row_reader(size_a)}
        if self.width > 3:
            readers |= {"read_position": row_reader(self.width), "WIDTH": self.width}
        return {"narrow": oriented(self.pair.narrow, self.width), "FLIPPED": self.pair.flipped, **readers}

    @property
    def corners(self) -> tuple[int, int]:
        """On how many bodies a contactor of each of the two kinds lies."""
        return corners_of(self.candidate), corners_of(self.antagonist)

    @property
    def foreign(self) -> bool:
        """Whether the narrow phase of the kinds is not lmgcpy's own."""
        return is_foreign(self.candidate, self.antagonist)


def kind_pairs(contactors: ContactorTable, row: VisibilityRow) -> list[KindPair]:
    """The pairs of kinds that a row may bring together, sorted."""
    kind, color = np.array(contactors.kind, dtype=str), np.array(contactors.color, dtype=str)
    candidate, antagonist = color == row.candidate, color == row.antagonist
    size = contactors.shape_size
    return [
        KindPair(c, a, candidate & (kind == c), antagonist & (kind == a), (size[c], size[a]), contactors.width)
        for c in np.unique(kind[candidate]).tolist()
        for a in np.unique(kind[antagonist]).tolist()
        if can_touch(c, a)
    ]


@kernel
def _choose(near, is_candidate, is_antagonist, same, body, free, chosen):
    """Write the near pairs of two kinds as (candidate, antagonist). Returns their number, and whether the candidate is
    the first contactor of every near pair.

    ``same``: whether the two colours are the same; the candidate is then the contactor of the lower body.
    """
    count = 0
    in_order = True
    for p in range(near.shape[0]):
        for turned in range(2):
            c = near[p, turned]
            a = near[p, 1 - turned]
            if not (is_candidate[c] and is_antagonist[a]):
                continue
            # not a body with itself, not twice, not two bodies that are held
            if body[c] == body[a] or (same and body[c] > body[a]) or not (free[c] or free[a]):
                continue
            chosen[count, 0] = c
            chosen[count, 1] = a
            count += 1
            in_order = in_order and turned == 0
    return count, in_order


@kernel
def _choose_unbounded(candidates, antagonists, same, body, free, reach, contactors, shapes, stride, chosen):
    """Write the pairs whose gap is within ``reach``, sorted. Returns their number, with those that do not fit."""
    count = 0
    for k in range(candidates.shape[0]):
        c = candidates[k]
        for j in range(antagonists.shape[0]):
            a = antagonists[j]
            if body[c] == body[a] or (same and body[c] > body[a]) or not (free[c] or free[a]):
                continue
            gap, _, _ = meet(c, a, contactors, shapes, stride)
            if gap > reach:
                continue
            if count < chosen.shape[0]:
                chosen[count, 0] = c
                chosen[count, 1] = a
            count += 1
    return count


@dataclass(frozen=True)
class Surroundings:
    """The input of a list of neighbours; k contactors, n bodies."""

    near: np.ndarray
    """Pairs of bounded contactors within reach, (p, 2), sorted."""
    placed: np.ndarray
    """Positions of the contactors, (k, w), see :mod:`lmgcpy.contact.positions`; of elements the origin."""
    shapes: np.ndarray
    """Numbers of their shapes, flat."""
    reach: float
    """Distance between surfaces up to which a pair with a contactor without bounds is a neighbour [m]."""
    contactors: ContactorTable
    bounded: np.ndarray
    """Whether each contactor is bounded, (k,) bool."""
    free: np.ndarray
    """Whether a body of each contactor has a component that is not held, (k,) bool."""
    excluded: ExcludedPairs
    """Pairs of bodies that never meet; ``near`` has none of them."""


def neighbours(row: VisibilityRow, kinds: KindPair, around: Surroundings) -> np.ndarray:
    """The pairs (candidate, antagonist) of one row and two kinds, (p, 2) int32, sorted.

    Bounded contactors come from the near pairs; a contactor without bounds is tested against every bounded one.
    """
    same = row.candidate == row.antagonist
    body, free = around.contactors.body, around.free
    chosen = np.empty((len(around.near), 2), np.int32)
    count, in_order = _choose(around.near, kinds.is_candidate, kinds.is_antagonist, same, body, free, chosen)
    pairs = chosen[:count]
    if not in_order:
        pairs = by_first(pairs, len(body))
    for c_bounded in (True, False):
        candidates = np.flatnonzero(kinds.is_candidate & (around.bounded == c_bounded))
        antagonists = np.flatnonzero(kinds.is_antagonist & (around.bounded != c_bounded))
        if len(candidates) and len(antagonists):
            more = _against_unbounded(candidates, antagonists, same, kinds, around)
            pairs = _merged(pairs, more) if len(pairs) and len(more) else (more if len(more) else pairs)
    return pairs


def _against_unbounded(
    candidates: np.ndarray, antagonists: np.ndarray, same: bool, kinds: KindPair, around: Surroundings
) -> np.ndarray:
    contactors = around.contactors
    choose = _choose_unbounded.specialise(**kinds.meaning)
    chosen = np.empty((len(candidates) + len(antagonists), 2), np.int32)
    read = around.placed.ravel(), around.shapes, contactors.shape.shape[1]
    given = candidates, antagonists, same, contactors.body, around.free, around.reach, *read
    count = choose(*given, chosen)
    if count > len(chosen):
        chosen = np.empty((count, 2), np.int32)
        choose(*given, chosen)
    return around.excluded.left_out_of(chosen[:count], contactors.body)


def _merged(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Two lists of pairs as one, sorted; for kinds with both bounded and unbounded contactors."""
    pairs = np.concatenate([one, other])
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
