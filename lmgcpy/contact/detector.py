"""Detection: from the positions at the middle of a step to its interactions, in canonical order.

Chains come first, in the order in which they were made, then contacts by row of the visibility table and kind of
contactor pair, and within those by ids. The list of neighbours is made anew only when something has moved by half the
skin; what it yields does not depend on when that was. The impulse of an interaction is kept by its place in the list of
neighbours, hence by identity: both contactors, and the row or the chain. So is the state of laws that have one; it lives
as long as the interaction does, from the first step within alert to the last.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lmgcpy.contact import narrow_phase, narrow_phase_3d
from lmgcpy.contact.broad_phase import near_pairs
from lmgcpy.contact.memory import Memory
from lmgcpy.contact.narrow_phase import Interactions, empty_interactions, farthest, place_contactors
from lmgcpy.contact.pairs import Pair, find_pair
from lmgcpy.contact.tables import ChainTable, ContactorTable, VisibilityRow
from lmgcpy.jit import Kernel, row_reader
from lmgcpy.laws import Law


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


class Detector:
    """Keeps the neighbours of a scene and the memory of its impulses."""

    def __init__(
        self,
        contactors: ContactorTable,
        rows: list[VisibilityRow],
        chains: list[ChainTable],
        inverse_mass: np.ndarray,
        dimension: int = 2,
    ):
        self.contactors = contactors
        self.rows = rows
        self.chains = chains
        self.inverse_mass = inverse_mass
        self._narrow = narrow_phase if dimension == 2 else narrow_phase_3d
        check_pairs(contactors, rows)
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
        self.dimension = dimension
        self.memory = np.zeros((0, dimension))
        laws = [row.law for row in rows] + [chain.law for chain in chains]
        self.state_names = list(dict.fromkeys(name for law in laws for name in law.states()))
        self._width = max((len(law.states()) for law in laws), default=0)
        self.state = np.zeros((0, self._width))
        self._capacity = empty_interactions(0, True, dimension)
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
        if self._listed_at is None or late or 4.0 * farthest(placed, self._listed_at, self.dimension) > self._skin**2:
            self._reach = (1.2 * widest if late else widest) + self._skin
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

    def remember(self, interactions: Interactions, impulse: np.ndarray, state: np.ndarray) -> None:
        """Keep the impulses (m, d) of the step for the next one's start, and the states (m, k) of the laws."""
        self.memory[:] = 0.0
        self.memory[interactions.slot] = impulse
        self.state[:] = np.nan
        self.state[interactions.slot] = state

    def recall(self, interactions: Interactions) -> np.ndarray:
        """Impulses of the last step by identity, zero for new interactions, (m, d)."""
        return self.memory[interactions.slot]

    def recall_state(self, interactions: Interactions) -> np.ndarray:
        """States of the laws by identity, (m, k), k the longest; NaN for new interactions and for laws with fewer."""
        return self.state[interactions.slot]

    def give_memory(self) -> Memory:
        """Impulses of the last step and states by identity, and what the list of neighbours came from, as copies."""
        acting = self.memory.view(np.int64).any(axis=1)  # bits: minus zero is kept as well
        kept = np.flatnonzero(acting | ~np.isnan(self.state).all(axis=1))
        identity = np.empty((len(self.memory), 3), dtype=np.int64)
        for group in self.groups:
            mine = identity[group.first_slot : group.first_slot + group.slots]
            mine[:, 0] = self._table(group)
            if group.chain:
                mine[:, 1] = np.arange(group.slots)
                mine[:, 2] = -1
            else:
                mine[:, 1:] = group.pairs
        return Memory(
            identity=identity[kept],
            impulse=self.memory[kept],
            state=self.state[kept],
            listed=self._listed_at is not None,
            listed_at=np.zeros((len(self.contactors.body), 3)) if self._listed_at is None else self._listed_at.copy(),
            reach=self._reach,
            rebuilds=self.rebuilds,
        )

    def take_memory(self, memory: Memory) -> None:
        """Go on from a memory; ValueError where it holds interactions that this scene cannot have."""
        if not memory.listed:
            return
        self._reach = memory.reach
        self._list_neighbours(memory.listed_at)
        self.rebuilds = memory.rebuilds
        self.memory[:] = 0.0
        self.state[:] = np.nan
        base = len(self.contactors.body)
        found = 0
        for group in self.groups:
            mine = memory.identity[:, 0] == self._table(group)
            first, second = memory.identity[mine, 1:].T
            if group.chain:
                place, here = first, (first >= 0) & (first < group.slots)
            else:
                keys = group.pairs[:, 0] * base + group.pairs[:, 1]
                place = np.searchsorted(keys, first * base + second)
                here = place < len(keys)
                here[here] = keys[place[here]] == (first * base + second)[here]
            self.memory[group.first_slot + place[here]] = memory.impulse[mine][here]
            self.state[group.first_slot + place[here]] = memory.state[mine][here]
            found += int(here.sum())
        if found < len(memory.identity):
            raise ValueError(
                f"{len(memory.identity) - found} of {len(memory.identity)} remembered impulses belong to interactions "
                "that this scene does not have: the memory is of another scene."
            )

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

    def _list_neighbours(self, placed: np.ndarray) -> None:
        """Make the groups and their lists of neighbours anew and carry impulses and states over."""
        before = {self._identity(group): group for group in self.groups}
        self.rebuilds += 1
        self._listed_at = placed.copy()
        bounded = self._bounded
        near = near_pairs(placed[bounded, : self.dimension], self.contactors.bounding_radius[bounded], self._reach)
        near = bounded[near]
        groups = [Group(chain.law, True, chain=chain) for chain in self.chains]
        for row in self.rows:
            groups += self._groups_of_row(row, near)
        slots = 0
        for group in groups:
            group.first_slot = slots
            slots += group.slots
        memory = np.zeros((slots, self.dimension))
        state = np.full((slots, self._width), np.nan)
        for group in groups:
            old = before.get(self._identity(group))
            if old is not None:
                new_slots, old_slots = self._common_slots(group, old)
                memory[new_slots] = self.memory[old_slots]
                state[new_slots] = self.state[old_slots]
        self.groups = groups
        self.memory = memory
        self.state = state
        self._capacity = empty_interactions(slots, all(group.central for group in groups), self.dimension)

    @staticmethod
    def _identity(group: Group) -> tuple:
        return (id(group.chain), id(group.row), group.kinds)

    def _common_slots(self, new: Group, old: Group) -> tuple[np.ndarray, np.ndarray]:
        """Slots of the interactions that a group has in the new list and in the old one."""
        if new.chain:
            links = np.arange(new.slots)
            return new.first_slot + links, old.first_slot + links
        base = len(self.contactors.body)
        new_keys = new.pairs[:, 0] * base + new.pairs[:, 1]
        old_keys = old.pairs[:, 0] * base + old.pairs[:, 1]
        _, in_new, in_old = np.intersect1d(new_keys, old_keys, assume_unique=True, return_indices=True)
        return new.first_slot + in_new, old.first_slot + in_old

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
            central = pair.central and not self.contactors.offset[np.union1d(candidates, antagonists)].any()
            detect = self._kernel(kind_c, kind_a, pair, central)
            groups.append(Group(row.law, central, row=row, pairs=mine, kernel=detect, kinds=(kind_c, kind_a)))
        return groups

    def _kernel(self, kind_c: str, kind_a: str, pair: Pair, central: bool) -> Kernel:
        size = dict(zip(self.contactors.kind, self.contactors.shape_size, strict=True))
        return self._narrow.detect_contacts.specialise(
            narrow=pair.narrow,
            read_shape_c=row_reader(size[kind_c]),
            read_shape_a=row_reader(size[kind_a]),
            FLIPPED=pair.flipped,
            **({"CENTRAL": central} if self.dimension == 2 else {}),
        )


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


def _all_pairs(candidates: np.ndarray, antagonists: np.ndarray) -> np.ndarray:
    c, a = np.meshgrid(candidates, antagonists, indexing="ij")
    return np.stack([c.ravel(), a.ravel()], axis=1).astype(np.int64)
