"""Detection: from the positions at the middle of a step to its interactions, in canonical order.

Chains come first, in the order in which they were made, then contacts by row of the visibility table and kind of
contactor pair, and within those by ids. The list of neighbours is made anew only when something has moved as far as it
may; what it yields does not depend on when that was. In large scenes interactions are sorted by place instead of by ids
(:mod:`lmgcpy.contact.slabs`), that of the bodies when the list was made.

The impulse of an interaction is kept by its place in the list of neighbours, hence by identity: both contactors, and the
row or the chain. So is the state of laws that have one; it lives as long as the interaction does, from the first step
within alert to the last.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.contact import narrow_phase, narrow_phase_3d
from lmgcpy.contact.apart import Apart
from lmgcpy.contact.broad_phase import near_pairs
from lmgcpy.contact.memory import Memory, carry, recall
from lmgcpy.contact.narrow_phase import Interactions, empty_interactions, farthest, place_contactors
from lmgcpy.contact.neighbours import KindPair, Surroundings, kind_pairs, neighbours
from lmgcpy.contact.slabs import (
    EVERYWHERE,
    NOWHERE,
    Slabs,
    is_large,
    partition,
    sort_pairs,
)
from lmgcpy.contact.spare_rows import room
from lmgcpy.contact.tables import ChainTable, ContactorTable, VisibilityRow
from lmgcpy.laws import Law

STEPS_A_LIST = 4
"""For so many steps at the greatest speed a list of neighbours is meant to last."""


@dataclass
class Group:
    """Interactions of one law and one kind of contactor pair (``chain``: of one wire), rows start to stop."""

    law: Law
    central: bool
    chain: ChainTable | None = None
    row: VisibilityRow | None = None
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    rank: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    """Places of the pairs, taken by ids, in ``pairs``: the same order unless the scene is partitioned."""
    cuts: np.ndarray | None = None
    """Where in ``pairs`` each slab begins, and what belongs to none, and the end; None without slabs."""
    rows: np.ndarray | None = None
    """Where among the interactions they begin, as ``cuts``."""
    walls: int = -1
    """0 or 1 where the candidates or antagonists are walls: held ones, in the slabs."""
    kernel: Kernel | None = None
    kinds: KindPair | None = None
    unbounded: bool = False
    """Whether some of its contactors have no bounds."""
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

    @property
    def identity(self) -> tuple[int, int]:
        """What makes it the same group in another list: the chain, or the row and the kinds."""
        return id(self.chain or self.row), id(self.kinds)


class Detector:
    """Keeps the neighbours of a scene and the memory of its impulses."""

    def __init__(
        self,
        contactors: ContactorTable,
        rows: list[VisibilityRow],
        chains: list[ChainTable],
        inverse_mass: np.ndarray,
        dimension: int = 2,
        apart: np.ndarray | None = None,
    ):
        """``apart``: pairs of bodies that never meet, (p, 2), the lower first, sorted; None for none."""
        self.contactors = contactors
        self.rows = rows
        self.chains = chains
        self.inverse_mass = inverse_mass
        self._narrow = narrow_phase if dimension == 2 else narrow_phase_3d
        check_pairs(contactors, rows)
        self._bounded: np.ndarray = np.isfinite(contactors.bounding_radius)
        self._free: np.ndarray = inverse_mass.max(axis=1, initial=0.0) > 0.0
        self._apart = Apart(np.zeros((0, 2), np.int64) if apart is None else apart, len(inverse_mass))
        self._in_place = not contactors.offset.any() and np.array_equal(contactors.body, np.arange(len(inverse_mass)))
        self._shapes = np.ascontiguousarray(contactors.shape).ravel()
        self._stride = contactors.shape.shape[1]
        self._kinds = [kind_pairs(contactors, row) for row in rows]
        self._meets_walls = [any(self._without_bounds(kinds) for kinds in of_row) for of_row in self._kinds]
        self._offset_colors = {contactors.color[k] for k in np.flatnonzero(contactors.offset.any(axis=1)).tolist()}
        radii = contactors.bounding_radius[self._bounded]
        self._partitioned = is_large(len(radii))
        self._largest = float(radii.max()) if len(radii) else 0.0
        self._usual = float(np.quantile(radii, 0.95)) if len(radii) else 0.0
        self._skin = max([0.2 * float(radii.min()) if len(radii) else 0.0, *(row.alert for row in rows)])
        # a contactor off the centre of its body swings about it
        swing = np.sqrt((contactors.offset * contactors.offset).sum(axis=1))[self._bounded]
        self._cap = float((radii + swing).max()) if len(radii) else 0.0
        greatest = [self.alert(row, np.inf) for row in rows if row.adaptive]
        fixed = [row.alert for row in rows]
        self._fullest = max(greatest + fixed) + max(self._skin, 0.5 * self._largest) if greatest else np.inf
        """Reach of the widest list; one that reaches so far holds all that walls see."""
        self._reach = 0.0
        self._listed_at: np.ndarray | None = None
        self.groups: list[Group] = []
        self.place: np.ndarray | None = None
        """Place of each body in the order of the sweep, (n,); None without slabs."""
        self.dimension = dimension
        laws = [row.law for row in rows] + [chain.law for chain in chains]
        self.state_names = list(dict.fromkeys(name for law in laws for name in law.states()))
        self._width = max((len(law.states()) for law in laws), default=0)
        self._slots = np.zeros(0, np.int32)
        self._impulses = np.zeros((0, dimension))
        self._states = np.zeros((0, self._width))
        kinds_of_mass = [inverse_mass[:, :dimension], inverse_mass[:, dimension:]]
        alike = all((part == part[:, :1]).all() for part in kinds_of_mass)
        self._plain = dimension == 3 and not chains and alike
        self._capacity = empty_interactions(0, True, dimension, plain=self._plain)
        self.rebuilds = 0

    def alert(self, row: VisibilityRow, travel: float, closing: float = 0.0) -> float:
        """Alert distance of a row [m]. Where the user gave none, it covers what two bodies at the greatest speed can
        close in a step, ``travel`` each, up to the largest radius (with the offset of its contactor): a contact seen too
        late starts with a penetration. For contactors without bounds it covers ``closing``, whatever that is."""
        return max(row.alert, min(2.0 * travel, self._cap), closing) if row.adaptive else row.alert

    def widest(self, travel: float, closing: float) -> float:
        """The greatest alert distance [m]."""
        rows = zip(self.rows, self._meets_walls, strict=True)
        return max((self.alert(row, travel, closing if walls else 0.0) for row, walls in rows), default=0.0)

    def detect(self, bodies: np.ndarray, travel: float, closing: float = 0.0) -> Interactions:
        """Interactions at the positions ``bodies`` (n, 3) of the bodies, filled into arrays that the next call reuses.

        ``travel``: the longest way of a body in one step; ``closing``: by which a body and a wall may come closer [m].
        """
        placed = self._place(bodies)
        widest = self.widest(travel, 0.0)
        if self._out_of_date(placed, widest) or (closing > self._cap and self._reach < self._fullest < np.inf):
            # lists that last longer hold more pairs, which every step looks at
            skin = max(self._skin, min(2.0 * STEPS_A_LIST * travel, 0.5 * self._largest))
            self._reach = widest + skin
            self._list_neighbours(placed)
        flat = placed.ravel()
        first = 0
        for group in self.groups:
            group.start = first
            if group.chain:
                self._narrow.detect_links(
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
                    self.alert(group.row, travel, closing if group.unbounded else 0.0),
                    flat,
                    self.contactors.body,
                    self._shapes,
                    self._stride,
                    bodies,
                    self.inverse_mass,
                    self._capacity,
                )
            group.stop = first
            if group.cuts is not None:
                slots = self._capacity.slot[group.start : first]
                group.rows = group.start + np.searchsorted(slots, group.first_slot + group.cuts)
        return self._capacity.cut(first)

    def remember(self, interactions: Interactions, impulse: np.ndarray, state: np.ndarray) -> None:
        """Keep the impulses (m, d) of the step for the next one's start, and the states (m, k) of the laws."""
        self._slots = room(len(interactions.slot), dtype=np.int32)
        self._slots[:] = interactions.slot
        self._impulses, self._states = impulse, state

    def recall(self, interactions: Interactions) -> np.ndarray:
        """Impulses of the last step by identity, zero for new interactions, (m, d)."""
        known = room(len(interactions.slot), self.dimension, fill=0.0)
        recall(interactions.slot, self._slots, self._impulses, known)
        return known

    def recall_state(self, interactions: Interactions) -> np.ndarray:
        """States of the laws by identity, (m, k), k the longest; NaN for new interactions and for laws with fewer."""
        known = room(len(interactions.slot), self._width, fill=np.nan)
        recall(interactions.slot, self._slots, self._states, known)
        return known

    def give_memory(self) -> Memory:
        """Impulses of the last step and states by identity, and what the list of neighbours came from, as copies."""
        acting = self._impulses.view(np.int64).any(axis=1)  # bits: minus zero is kept as well
        kept = np.flatnonzero(acting | ~np.isnan(self._states).all(axis=1))
        slots = self._slots[kept]
        identity = np.empty((len(kept), 3), dtype=np.int64)
        for group in self.groups:
            first, last = np.searchsorted(slots, [group.first_slot, group.first_slot + group.slots])
            mine, places = identity[first:last], slots[first:last] - group.first_slot
            mine[:, 0] = self._table(group)
            if group.chain:
                mine[:, 1] = places
                mine[:, 2] = -1
            else:
                mine[:, 1:] = group.pairs[places]
        return Memory(
            identity=identity,
            impulse=self._impulses[kept],
            state=self._states[kept],
            listed=self._listed_at is not None,
            listed_at=np.zeros((len(self.contactors.body), 3)) if self._listed_at is None else self._listed_at.copy(),
            reach=self._reach,
            rebuilds=self.rebuilds,
        )

    def take_memory(self, memory: Memory) -> None:
        """Go on from a memory; ValueError where it holds interactions that this scene cannot have."""
        self._reach = memory.reach
        self._listed_at = None
        self.groups = []
        if memory.listed:
            self._list_neighbours(memory.listed_at)
        self.rebuilds = memory.rebuilds
        slots = np.full(len(memory.identity), -1)
        base = len(self.contactors.body)
        for group in self.groups:
            mine = memory.identity[:, 0] == self._table(group)
            first, second = memory.identity[mine, 1:].T
            if group.chain:
                place, here = first, (first >= 0) & (first < group.slots)
            else:
                keys = (group.pairs[:, 0].astype(np.int64) * base + group.pairs[:, 1])[group.rank]
                place = np.searchsorted(keys, first * base + second)
                here = place < len(keys)
                here[here] = keys[place[here]] == (first * base + second)[here]
                place[here] = group.rank[place[here]]
            slots[np.flatnonzero(mine)[here]] = group.first_slot + place[here]
        strange = int((slots < 0).sum())
        if strange:
            raise ValueError(
                f"{strange} of {len(slots)} remembered impulses belong to interactions "
                "that this scene does not have: the memory is of another scene."
            )
        order = np.argsort(slots, kind="stable")
        self._slots = slots[order].astype(np.int32)
        self._impulses, self._states = memory.impulse[order], memory.state[order]

    def _table(self, group: Group) -> int:
        """Place of the group's chain or row among chains and rows."""
        tables: list = [*self.chains, *self.rows]
        return next(i for i, table in enumerate(tables) if table is group.chain or table is group.row)

    def _place(self, bodies: np.ndarray) -> np.ndarray:
        if self._in_place:
            return bodies
        placed = np.empty((len(self.contactors.body), 3))
        place_contactors(bodies, self.contactors.body, self.contactors.offset, placed)
        return placed

    def _out_of_date(self, placed: np.ndarray, widest: float) -> bool:
        """Whether a pair may be within the ``widest`` alert distance that the list does not have."""
        if self._listed_at is None or widest > self._reach:
            return True
        if 4.0 * farthest(placed, self._listed_at, self.dimension) > (self._reach - widest) ** 2:
            return True
        # of what has no bounds the smallest turn moves far things
        turned = self.dimension == 2 and (placed[:, 2] != self._listed_at[:, 2])[~self._bounded].any()
        return bool(turned)

    def _list_neighbours(self, placed: np.ndarray) -> None:
        """Make the groups and their lists of neighbours anew and carry impulses and states over."""
        self.rebuilds += 1
        self._listed_at = placed.copy()
        bounded = np.flatnonzero(self._bounded)
        centres = placed.take(bounded, axis=0)[:, : self.dimension]
        near = near_pairs(centres, self.contactors.bounding_radius[bounded], self._reach)
        if len(bounded) < len(placed):
            near = bounded.astype(np.int32).take(near)
        near = self._apart.take_off(near, self.contactors.body)
        of_walls = self._reach if self._reach < self._fullest else np.inf
        around = Surroundings(near, placed, of_walls, self.contactors, self._bounded, self._free, self._apart)
        slabs = self._cut_slabs(placed) if self._partitioned else None
        self.place = None if slabs is None else slabs.place
        groups = [Group(chain.law, True, chain=chain) for chain in self.chains]
        for row, kinds in zip(self.rows, self._kinds, strict=True):
            groups += [group for pair in kinds if (group := self._group(row, pair, around, slabs)).slots]
        slots = 0
        for group in groups:
            group.first_slot = slots
            slots += group.slots
        self._carry_over(groups, slots)
        self.groups = groups
        central = all(group.central for group in groups)
        if len(self._capacity.gap) < slots or (not central and len(self._capacity.lateral) < slots):
            self._capacity = empty_interactions(slots + slots // 8, central, self.dimension, plain=self._plain)

    def _without_bounds(self, kinds: KindPair) -> bool:
        """Whether some of the contactors have no bounds."""
        return bool((~self._bounded & (kinds.is_candidate | kinds.is_antagonist)).any())

    def _cut_slabs(self, placed: np.ndarray) -> Slabs:
        """The partition of the bodies, by their first contactor."""
        bounded = np.flatnonzero(self._bounded)
        first = bounded[np.diff(self.contactors.body[bounded], prepend=-1) > 0]  # bodies ascend
        bodies, centres = self.contactors.body[first], placed.take(first, axis=0)[:, : self.dimension]
        count, slab_of, place_of = partition(centres, 2.0 * self._usual + self._reach)
        slab = np.where(self._free, EVERYWHERE, NOWHERE).astype(np.int32)
        slab[bodies] = slab_of
        place = np.empty(len(slab), np.int32)
        place[slab < 0] = np.arange(len(bodies), len(slab))
        place[bodies] = place_of
        return Slabs(count, slab, place)

    def _group(self, row: VisibilityRow, kinds: KindPair, around: Surroundings, slabs: Slabs | None) -> Group:
        """The group of one row of the visibility table and two kinds of contactor."""
        pairs = neighbours(row, kinds, around)
        if len(pairs) == 0:
            return Group(row.law, True, row=row)
        central = kinds.pair.central and self._offset_colors.isdisjoint((row.candidate, row.antagonist))
        names = {"CENTRAL": central} if self.dimension == 2 else {}
        kernel = self._narrow.detect_contacts.specialise(**kinds.meaning, **names)
        unbounded = self._without_bounds(kinds)
        group = Group(row.law, central, row=row, pairs=pairs, kernel=kernel, kinds=kinds, unbounded=unbounded)
        if slabs is None:
            group.rank = np.arange(len(pairs), dtype=np.int32)
            return group
        for side, mine in enumerate((kinds.is_candidate, kinds.is_antagonist)):
            if not (mine & self._bounded).any():
                group.walls = side
        group.pairs, group.rank = np.empty_like(pairs), np.empty(len(pairs), np.int32)
        group.cuts = np.empty(slabs.count + 2, np.int64)
        where = slabs.count, slabs.slab, slabs.place
        sort_pairs(pairs, self.contactors.body, *where, group.walls, group.rank, group.pairs, group.cuts)
        return group

    def _carry_over(self, groups: list[Group], slots: int) -> None:
        """From the slots of the present list to those of another, of so many slots."""
        before = {group.identity: group for group in self.groups}
        source = np.full(slots, -1, np.int32)
        """Where in the memory each new slot is, or -1."""
        for group in groups:
            old = before.get(group.identity)
            if old is None:
                continue
            first, last = np.searchsorted(self._slots, [old.first_slot, old.first_slot + old.slots])
            remembered = np.full(old.slots, -1, np.int32)
            remembered[self._slots[first:last] - old.first_slot] = np.arange(first, last)
            mine = source[group.first_slot : group.first_slot + group.slots]
            if group.chain:
                mine[:] = remembered
            else:
                carry(old.pairs, old.rank, remembered, group.pairs, group.rank, mine)
        self._slots = np.flatnonzero(source >= 0).astype(np.int32)
        kept = source[self._slots]
        self._impulses, self._states = self._impulses.take(kept, axis=0), self._states.take(kept, axis=0)


def check_pairs(contactors: ContactorTable, rows: list[VisibilityRow]) -> None:
    """ValueError where the visibility table gives a law a pair of contactors that the law is not for."""
    kinds: dict[str, set[str]] = {}
    for kind, color in zip(contactors.kind, contactors.color, strict=True):
        kinds.setdefault(color, set()).add(kind)
    for row in rows:
        allowed = row.law.PAIRS
        if allowed is None:
            continue
        for c in sorted(kinds.get(row.candidate, ())):
            for a in sorted(kinds.get(row.antagonist, ())):
                if (c, a) not in allowed and (a, c) not in allowed:
                    pairs = ", ".join("-".join(pair) for pair in sorted(allowed))
                    raise ValueError(
                        f"Law '{row.law.NAME}' is for contacts {pairs}, but "
                        f"'{row.candidate}' sees '{row.antagonist}' with a {c} and a {a}: give them another law."
                    )
