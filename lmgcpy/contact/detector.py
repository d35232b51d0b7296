"""Detection: from the positions at the middle of a step to its interactions, in canonical order.

Chains come first, in the order in which they were made, then contacts by row of the visibility table and kind of
contactor pair, and within those by ids. The list of neighbours is made anew only when something has moved by half the
skin; what it yields does not depend on when that was. The impulse of an interaction is kept by its place in the list of
neighbours, hence by identity: both contactors, and the row or the chain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.contact.broad_phase import near_pairs
from lmgcpy.contact.pairs import Pair, find_pair
from lmgcpy.jit import Kernel, kernel, row_reader
from lmgcpy.laws import Law


@dataclass(frozen=True)
class ContactorTable:
    """All contactors of a scene; k of them."""

    body: np.ndarray
    """Row of the body, (k,) int64."""
    offset: np.ndarray
    """Position in the frame of the body [m], (k, 2)."""
    kind: list[str]
    color: list[str]
    shape: np.ndarray
    """Numbers of the shapes, (k, widest)."""
    shape_size: list[int]
    bounding_radius: np.ndarray
    """[m], infinite where unbounded, (k,)."""


@dataclass(frozen=True)
class VisibilityRow:
    """Who sees whom, under which law, up to which gap [m]."""

    candidate: str
    antagonist: str
    law: Law
    alert: float
    adaptive: bool = False
    """Whether the alert distance grows with the speed of the bodies."""

    @cached_property
    def parameters(self) -> np.ndarray:
        """Parameters of the law, the same for all, (1, k)."""
        return np.ascontiguousarray(self.law.table(np.zeros(1)), dtype=float)


@dataclass(frozen=True)
class ChainTable:
    """Links of one chain: link i joins ``bodies[i]``, antagonist, and ``bodies[i + 1]``, candidate."""

    bodies: np.ndarray
    """Rows of the bodies, (links + 1,) int64; of a closed chain the last is the first."""
    law: Law
    radius_sum: np.ndarray
    """Sum of the two radii [m], (links,)."""
    reference_gap: np.ndarray
    """[m], (links,)."""
    start_gap: np.ndarray
    """Gap from which a link is drawn to its reference [m], (links,)."""
    relaxation: float
    """Time that this takes [s]; 0 for none."""

    @property
    def link_count(self) -> int:
        """How many links."""
        return len(self.radius_sum)

    @cached_property
    def parameters(self) -> np.ndarray:
        """Parameters of the law, one row a link, (links, k)."""
        return np.ascontiguousarray(self.law.table(self.radius_sum + self.reference_gap), dtype=float)

    def reference_gap_at(self, time: float) -> np.ndarray:
        """Reference gaps at a time [m], (links,)."""
        if time >= self.relaxation:
            return self.reference_gap
        return self.start_gap + (self.reference_gap - self.start_gap) * (time / self.relaxation)


class Interactions(NamedTuple):
    """The interactions of a step; m of them (see :class:`lmgcpy.solve.system.System` for those not told here)."""

    candidate: np.ndarray
    antagonist: np.ndarray
    gap: np.ndarray
    """At the detection configuration [m], (m,)."""
    normal: np.ndarray
    arm: np.ndarray
    lateral: np.ndarray
    delassus: np.ndarray
    coupling: np.ndarray
    slot: np.ndarray
    """Where the impulse of the interaction is remembered, (m,) int64."""

    def cut(self, count: int) -> Interactions:
        """The first ``count`` interactions, as views."""
        return Interactions(*(a[:count] for a in self))


def empty_interactions(capacity: int, central: bool) -> Interactions:
    return Interactions(
        candidate=np.zeros(capacity, np.uint32),
        antagonist=np.zeros(capacity, np.uint32),
        gap=np.zeros(capacity),
        normal=np.zeros((capacity, 2)),
        arm=np.zeros((capacity, 2)),
        lateral=np.zeros((0 if central else capacity, 2)),
        delassus=np.zeros((capacity, 2)),
        coupling=np.zeros(capacity),
        slot=np.zeros(capacity, np.int64),
    )


@dataclass
class Group:
    """Interactions of one law and one kind of contactor pair (``chain``: of one wire), rows start to stop."""

    law: Law
    central: bool
    chain: ChainTable | None = None
    row: VisibilityRow | None = None
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    kernel: Kernel | None = None
    kinds: tuple[str, str] | None = None
    first_slot: int = 0
    start: int = 0
    stop: int = 0
    diagonal: bool = True

    @property
    def parameters(self) -> np.ndarray:
        """Parameters of the law, one row for all or one each."""
        source = self.chain or self.row
        assert source is not None
        return source.parameters

    @property
    def slots(self) -> int:
        """How many interactions the group may have."""
        return self.chain.link_count if self.chain else len(self.pairs)


# ----------------------------------------------------------------------------------------------------------- kernels

narrow: Callable[..., Any] = lambda position_c, shape_c, position_a, shape_a: (0.0, (0.0, 1.0), (0.0, 0.0))  # noqa: E731
"""The pair's narrow phase, given by the specialisation, like the names below."""
read_position: Callable[..., Any] = row_reader(3)
read_shape_c: Callable[..., Any] = row_reader(1)
read_shape_a: Callable[..., Any] = row_reader(1)
FLIPPED = False
"""The candidate is the narrow phase's antagonist."""
CENTRAL = True


@kernel
def detect_contacts(
    pairs, first, first_slot, alert, contactors, body, shapes, stride, bodies, inverse_mass, result: Interactions
):
    """Narrow phase of one group: write interactions from row ``first`` on.

    Returns (row after the last, whether all local blocks of W are diagonal).
    """
    m = first
    diagonal = True
    for p in range(pairs.shape[0]):
        k_c = pairs[p, 0]
        k_a = pairs[p, 1]
        position_c = read_position(contactors, 3 * k_c)
        position_a = read_position(contactors, 3 * k_a)
        shape_c = read_shape_c(shapes, stride * k_c)
        shape_a = read_shape_a(shapes, stride * k_a)
        if FLIPPED:
            gap, (n_x, n_y), (p_x, p_y) = narrow(position_a, shape_a, position_c, shape_c)
            n_x = -n_x
            n_y = -n_y
        else:
            gap, (n_x, n_y), (p_x, p_y) = narrow(position_c, shape_c, position_a, shape_a)
        if gap > alert:
            continue
        c = body[k_c]
        a = body[k_a]
        inverse_c = inverse_mass[c, 2]
        inverse_a = inverse_mass[a, 2]
        # levers from the centres to the contact point, along n (away from the centre) and along t
        arm_c = n_x * (bodies[c, 0] - p_x) + n_y * (bodies[c, 1] - p_y)
        arm_a = n_x * (p_x - bodies[a, 0]) + n_y * (p_y - bodies[a, 1])
        x = inverse_mass[c, 0] + inverse_mass[a, 0]
        y = inverse_mass[c, 1] + inverse_mass[a, 1]
        w_nn = n_x * n_x * x + n_y * n_y * y
        w_tt = n_y * n_y * x + n_x * n_x * y + arm_c * arm_c * inverse_c + arm_a * arm_a * inverse_a
        w_nt = n_x * n_y * (y - x)
        if not CENTRAL:
            lateral_c = n_x * (p_y - bodies[c, 1]) - n_y * (p_x - bodies[c, 0])
            lateral_a = n_x * (p_y - bodies[a, 1]) - n_y * (p_x - bodies[a, 0])
            result.lateral[m, 0] = lateral_c
            result.lateral[m, 1] = lateral_a
            w_nn += lateral_c * lateral_c * inverse_c + lateral_a * lateral_a * inverse_a
            w_nt += arm_c * lateral_c * inverse_c - arm_a * lateral_a * inverse_a
        elif result.lateral.shape[0] > 0:  # other groups need it, and the arrays are used again
            result.lateral[m, 0] = 0.0
            result.lateral[m, 1] = 0.0
        if w_nn <= 0.0:  # neither can move along the normal: no impulse changes anything
            continue
        if w_tt <= 0.0:  # held along the tangent: friction moves nothing, and any positive weight finds it
            w_tt = w_nn
        if w_nt != 0.0:
            diagonal = False
        result.candidate[m] = c
        result.antagonist[m] = a
        result.gap[m] = gap
        result.normal[m, 0] = n_x
        result.normal[m, 1] = n_y
        result.arm[m, 0] = arm_c
        result.arm[m, 1] = arm_a
        result.delassus[m, 0] = w_nn
        result.delassus[m, 1] = w_tt
        result.coupling[m] = w_nt
        result.slot[m] = first_slot + p
        m += 1
    return m, diagonal


@kernel
def detect_links(chain, radius_sum, first, first_slot, bodies, inverse_mass, result: Interactions):
    """Links of one chain, between centres; ``coupling`` is the entry of W between a link and the next one."""
    count = radius_sum.shape[0]
    for k in range(count):
        i = first + k
        a = chain[k]
        c = chain[k + 1]
        x = bodies[c, 0] - bodies[a, 0]
        y = bodies[c, 1] - bodies[a, 1]
        distance = np.sqrt(x * x + y * y)
        n_x = 0.0
        n_y = 1.0
        if distance > 0.0:
            n_x = x / distance
            n_y = y / distance
        result.candidate[i] = c
        result.antagonist[i] = a
        result.gap[i] = distance - radius_sum[k]
        result.normal[i, 0] = n_x
        result.normal[i, 1] = n_y
        result.arm[i, 0] = 0.5 * distance
        result.arm[i, 1] = 0.5 * distance
        w = n_x * n_x * (inverse_mass[c, 0] + inverse_mass[a, 0]) + n_y * n_y * (inverse_mass[c, 1] + inverse_mass[a, 1])
        result.delassus[i, 0] = w
        result.delassus[i, 1] = w
        result.slot[i] = first_slot + k
    closed = chain[0] == chain[count]
    for k in range(count):
        i = first + k
        j = first if k == count - 1 else i + 1
        shared = chain[k + 1]
        if k == count - 1 and not closed:
            result.coupling[i] = 0.0
        else:
            result.coupling[i] = -(
                result.normal[i, 0] * result.normal[j, 0] * inverse_mass[shared, 0]
                + result.normal[i, 1] * result.normal[j, 1] * inverse_mass[shared, 1]
            )


@kernel
def place_contactors(bodies, body, offset, result):
    """Positions (x, y, angle) of the contactors from those of their bodies."""
    for k in range(body.shape[0]):
        b = body[k]
        cosine = np.cos(bodies[b, 2])
        sine = np.sin(bodies[b, 2])
        result[k, 0] = bodies[b, 0] + cosine * offset[k, 0] - sine * offset[k, 1]
        result[k, 1] = bodies[b, 1] + sine * offset[k, 0] + cosine * offset[k, 1]
        result[k, 2] = bodies[b, 2]


@kernel
def farthest(positions, before):
    """Square of the largest displacement."""
    largest = 0.0
    for i in range(positions.shape[0]):
        x = positions[i, 0] - before[i, 0]
        y = positions[i, 1] - before[i, 1]
        largest = max(largest, x * x + y * y)
    return largest


# ---------------------------------------------------------------------------------------------------------- detector


class Detector:
    """Keeps the neighbours of a scene and the memory of its impulses."""

    def __init__(
        self,
        contactors: ContactorTable,
        rows: list[VisibilityRow],
        chains: list[ChainTable],
        inverse_mass: np.ndarray,
    ):
        self.contactors = contactors
        self.rows = rows
        self.chains = chains
        self.inverse_mass = inverse_mass
        bounded = np.isfinite(contactors.bounding_radius)
        self._bounded = np.flatnonzero(bounded)
        self._unbounded = np.flatnonzero(~bounded)
        self._free: np.ndarray = inverse_mass.max(axis=1, initial=0.0) > 0.0
        self._in_place = not contactors.offset.any() and np.array_equal(contactors.body, np.arange(len(inverse_mass)))
        self._shapes = np.ascontiguousarray(contactors.shape).ravel()
        self._stride = contactors.shape.shape[1]
        self._kind = np.array(contactors.kind, dtype=object)
        self._color = np.array(contactors.color, dtype=object)
        radii = contactors.bounding_radius[bounded]
        self._largest = float(radii.max()) if len(radii) else 0.0
        self._skin = max([0.2 * float(radii.min()) if len(radii) else 0.0, *(row.alert for row in rows)])
        self._reach = 0.0
        self._listed_at: np.ndarray | None = None
        self.groups: list[Group] = []
        self.memory = np.zeros((0, 2))
        self._capacity = empty_interactions(0, True)
        self.rebuilds = 0

    def alert(self, row: VisibilityRow, travel: float) -> float:
        """Alert distance of a row [m]. Where the user gave none, it covers what two bodies at the greatest speed can
        close in a step, ``travel`` each, up to the largest radius: a contact seen too late starts with a penetration."""
        return max(row.alert, min(2.0 * travel, self._largest)) if row.adaptive else row.alert

    def detect(self, bodies: np.ndarray, travel: float) -> Interactions:
        """Interactions at the positions ``bodies`` (n, 3) of the bodies, filled into arrays that the next call reuses.

        ``travel``: the longest way of a body in one step [m].
        """
        placed = self._place(bodies)
        widest = max((self.alert(row, travel) for row in self.rows), default=0.0)
        late = widest > self._reach - self._skin
        if self._listed_at is None or late or 4.0 * farthest(placed, self._listed_at) > self._skin**2:
            self._reach = (1.2 * widest if late else widest) + self._skin
            self._list_neighbours(placed)
        flat = placed.ravel()
        first = 0
        for group in self.groups:
            group.start = first
            if group.chain:
                detect_links(
                    group.chain.bodies,
                    group.chain.radius_sum,
                    first,
                    group.first_slot,
                    bodies,
                    self.inverse_mass,
                    self._capacity,
                )
                first += group.slots
            else:
                assert group.kernel is not None
                assert group.row is not None
                first, group.diagonal = group.kernel(
                    group.pairs,
                    first,
                    group.first_slot,
                    self.alert(group.row, travel),
                    flat,
                    self.contactors.body,
                    self._shapes,
                    self._stride,
                    bodies,
                    self.inverse_mass,
                    self._capacity,
                )
            group.stop = first
        return self._capacity.cut(first)

    def remember(self, interactions: Interactions, impulse: np.ndarray) -> None:
        """Keep the impulses of the step for the next one's start."""
        self.memory[:] = 0.0
        self.memory[interactions.slot] = impulse

    def recall(self, interactions: Interactions) -> np.ndarray:
        """Impulses of the last step by identity, zero for new interactions, (m, 2)."""
        return self.memory[interactions.slot]

    def _place(self, bodies: np.ndarray) -> np.ndarray:
        if self._in_place:
            return bodies
        placed = np.empty((len(self.contactors.body), 3))
        place_contactors(bodies, self.contactors.body, self.contactors.offset, placed)
        return placed

    def _list_neighbours(self, placed: np.ndarray) -> None:
        """Make the groups and their lists of neighbours anew and carry the memory of the impulses over."""
        before = {self._identity(group): group for group in self.groups}
        self.rebuilds += 1
        self._listed_at = placed.copy()
        near = near_pairs(placed[self._bounded], self.contactors.bounding_radius[self._bounded], self._reach)
        near = self._bounded[near]
        groups = [Group(chain.law, True, chain=chain) for chain in self.chains]
        for row in self.rows:
            groups += self._groups_of_row(row, near)
        slots = 0
        for group in groups:
            group.first_slot = slots
            slots += group.slots
        memory = np.zeros((slots, 2))
        for group in groups:
            old = before.get(self._identity(group))
            if old is not None:
                self._carry_over(group, memory, old, self.memory)
        self.groups = groups
        self.memory = memory
        self._capacity = empty_interactions(slots, all(group.central for group in groups))

    @staticmethod
    def _identity(group: Group) -> tuple:
        return (id(group.chain), id(group.row), group.kinds)

    def _carry_over(self, group: Group, memory: np.ndarray, old: Group, old_memory: np.ndarray) -> None:
        new_range = slice(group.first_slot, group.first_slot + group.slots)
        old_range = slice(old.first_slot, old.first_slot + old.slots)
        if group.chain:
            memory[new_range] = old_memory[old_range]
            return
        base = len(self.contactors.body)
        new_keys = group.pairs[:, 0] * base + group.pairs[:, 1]
        old_keys = old.pairs[:, 0] * base + old.pairs[:, 1]
        _, in_new, in_old = np.intersect1d(new_keys, old_keys, assume_unique=True, return_indices=True)
        memory[new_range][in_new] = old_memory[old_range][in_old]

    def _groups_of_row(self, row: VisibilityRow, near: np.ndarray) -> list[Group]:
        """Groups of one row of the visibility table, by kinds of contactor; the first body is the candidate."""
        candidates = np.flatnonzero(self._color == row.candidate)
        antagonists = np.flatnonzero(self._color == row.antagonist)
        walls_c = np.intersect1d(candidates, self._unbounded)
        walls_a = np.intersect1d(antagonists, self._unbounded)
        free_c = np.setdiff1d(candidates, walls_c)
        free_a = np.setdiff1d(antagonists, walls_a)
        parts = [near, near[:, ::-1]]
        parts += [_all_pairs(free_c, walls_a), _all_pairs(walls_c, free_a)]
        pairs = np.concatenate(parts)
        pairs = pairs[np.isin(pairs[:, 0], candidates) & np.isin(pairs[:, 1], antagonists)]
        first, second = self.contactors.body[pairs].T
        in_order = first < second if row.candidate == row.antagonist else first != second
        pairs = pairs[in_order & (self._free[first] | self._free[second])]
        kinds = sorted({(c, a) for c, a in zip(self._kind[pairs[:, 0]], self._kind[pairs[:, 1]], strict=True)})
        groups = []
        for kind_c, kind_a in kinds:
            mine = pairs[(self._kind[pairs[:, 0]] == kind_c) & (self._kind[pairs[:, 1]] == kind_a)]
            mine = mine[np.lexsort((mine[:, 1], mine[:, 0]))]
            pair = find_pair(kind_c, kind_a)
            central = pair.central and not self.contactors.offset[mine.ravel()].any()
            detect = self._kernel(kind_c, kind_a, pair, central)
            groups.append(Group(row.law, central, row=row, pairs=mine, kernel=detect, kinds=(kind_c, kind_a)))
        return groups

    def _kernel(self, kind_c: str, kind_a: str, pair: Pair, central: bool) -> Kernel:
        size = dict(zip(self.contactors.kind, self.contactors.shape_size, strict=True))
        return detect_contacts.specialise(
            narrow=pair.narrow,
            read_shape_c=row_reader(size[kind_c]),
            read_shape_a=row_reader(size[kind_a]),
            FLIPPED=pair.flipped,
            CENTRAL=central,
        )


def _all_pairs(candidates: np.ndarray, antagonists: np.ndarray) -> np.ndarray:
    c, a = np.meshgrid(candidates, antagonists, indexing="ij")
    return np.stack([c.ravel(), a.ravel()], axis=1).astype(np.int64)
