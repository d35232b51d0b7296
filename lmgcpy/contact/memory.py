"""The memory of a step for the next one: impulses and states by the identity of their interactions.

The impulse of an interaction is kept by its slot in the list of neighbours, hence by identity: both contactors, and the
row of the visibility table or the chain. So is the state of laws that have one; it lives as long as the interaction does,
from the first step within alert to the last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.groups import Group
from lmgcpy.contact.interactions import copy_with_spare_rows


@dataclass(frozen=True)
class Memory:
    """Impulses and states of the last step by identity, and the positions at which the list of neighbours was made; m
    interactions, c contactors.

    A list made anew from ``listed_at`` and ``reach`` is the same list, so a simulation that goes on from a memory gives
    the same numbers to the last bit.
    """

    identity: np.ndarray
    """Number of the table (of the chain, or the number of chains plus the row of the visibility table), then the two
    contactors, or the link and -1; (m, 3) int64."""
    impulse: np.ndarray
    """In the local frame, normal first [N s], (m, d)."""
    state: np.ndarray
    """State of the law of each interaction, (m, k + 1), k the longest state of the scene; NaN beyond the state of a shorter
    one. The last column is the gap that a contact is predicted to have at the next detection [m], NaN if not known."""
    listed: bool
    """Whether there is a list of neighbours; False before the first step."""
    listed_at: np.ndarray
    """Positions and angles of the contactors when the list was made [m, rad], (c, 3)."""
    reach: float
    """Distance between surfaces up to which pairs are in the list [m]."""
    rebuilds: int
    """How many lists were made so far."""


class LastStep:
    """Impulses and states of the last step, by the slots of the present list of neighbours."""

    def __init__(self, components: int, width: int):
        """``components``: largest number of components of an impulse; ``width``: length of the longest state of a law."""
        self._slots = np.zeros(0, np.int32)
        self._impulses = np.zeros((0, components))
        self._states = np.zeros((0, width))

    def __copy__(self) -> LastStep:
        """An independent copy. It shares arrays: they are replaced, never changed in place."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    def remember(self, slots: np.ndarray, impulse: np.ndarray, state: np.ndarray) -> None:
        """Keep impulses (m, d) and states (m, k) of the interactions in these slots, (m,), ascending."""
        # copies: the next step may write into the same arrays and then fail
        self._slots, self._impulses, self._states = map(copy_with_spare_rows, (slots, impulse, state))

    @property
    def width(self) -> tuple[int, int]:
        """Largest number of components of an impulse, and length of the longest state of a law."""
        return self._impulses.shape[1], self._states.shape[1]

    def recall(self, slots: np.ndarray, impulse: np.ndarray, state: np.ndarray) -> None:
        """Fill in the impulses (m, d) and states (m, k) of the interactions in these slots. A new interaction gets the
        impulse zero and the state NaN. Columns beyond the state of a law are NaN, too."""
        recall(slots, self._slots, self._impulses, self._states, impulse, state)

    def hand_on(self, slots: np.ndarray, surfaces: np.ndarray, impulse: np.ndarray, state: np.ndarray) -> None:
        """Give new interactions in these slots, of a contactor with a surface, the impulse and the state that it had with
        another feature of the surface in the last step, if it had just one that it has lost. ``surfaces``: of
        :func:`surfaces_met`."""
        new = np.flatnonzero(~np.isin(slots, self._slots, assume_unique=True))
        lost = np.flatnonzero(~np.isin(self._slots, slots, assume_unique=True))
        if not len(new) or not len(lost):
            return
        sides = []
        for rows, numbers in ((new, surfaces[slots[new]]), (lost, surfaces[self._slots[lost]])):
            number, first, uses = np.unique(numbers, return_index=True, return_counts=True)
            once = (uses == 1) & (number >= 0)
            sides.append((number[once], rows[first[once]]))
        _, here, there = np.intersect1d(sides[0][0], sides[1][0], assume_unique=True, return_indices=True)
        to, source = sides[0][1][here], sides[1][1][there]
        impulse[to], state[to] = self._impulses[source], self._states[source]

    def scale(self, factor: float) -> None:
        """Multiply the impulses, as for another time step, in which the forces stay; states stay, gaps that were predicted
        for another detection are no longer known."""
        self._impulses, self._states = factor * self._impulses, self._states.copy()
        self._states[:, -1] = np.nan

    def replace_impulses(self, slots: np.ndarray, impulse: np.ndarray) -> None:
        """Put impulses (m, d) in the place of those of the interactions in these slots, (m,), ascending; their states
        stay."""
        every = np.union1d(self._slots, slots)
        impulses, states = (np.empty((len(every), width)) for width in self.width)
        self.recall(every, impulses, states)
        impulses[np.searchsorted(every, slots)] = impulse
        self.remember(every, impulses, states)

    def carry_over(self, before: list[Group], groups: list[Group], slots: int) -> None:
        """Move impulses and states from the slots of the groups ``before`` to the slots of the new ``groups``, which have
        ``slots`` slots in all."""
        known = {group.identity: group for group in before}
        source = np.full(slots, -1, np.int32)
        """Index in the memory of the impulse and state that each new slot gets, or -1."""
        for group in groups:
            old = known.get(group.identity)
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

    def by_identity(self, groups: list[Group], tables: list) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(identity, impulse, state) of the interactions that have an impulse or a state, see :class:`Memory`; copies."""
        acting = self._impulses.view(np.int64).any(axis=1)  # bits: minus zero is kept as well
        kept = np.flatnonzero(acting | ~np.isnan(self._states).all(axis=1))
        slots = self._slots[kept]
        identity = np.empty((len(kept), 3), dtype=np.int64)
        for group in groups:
            first, last = np.searchsorted(slots, [group.first_slot, group.first_slot + group.slots])
            mine, index = identity[first:last], slots[first:last] - group.first_slot
            mine[:, 0] = table_index(group, tables)
            if group.chain:
                mine[:, 1] = index
                mine[:, 2] = -1
            else:
                mine[:, 1:] = group.pairs[index]
        return identity, self._impulses[kept], self._states[kept]

    def take(self, memory: Memory, groups: list[Group], tables: list, contactor_count: int) -> None:
        """Go on from a memory; ValueError if it holds interactions that these groups cannot have."""
        slots = np.full(len(memory.identity), -1)
        for group in groups:
            mine = memory.identity[:, 0] == table_index(group, tables)
            first, second = memory.identity[mine, 1:].T
            if group.chain:
                index, here = first, (first >= 0) & (first < group.slots)
            else:
                keys = (group.pairs[:, 0].astype(np.int64) * contactor_count + group.pairs[:, 1])[group.rank]
                wanted = first * contactor_count + second
                index = np.searchsorted(keys, wanted)
                here = index < len(keys)
                here[here] = keys[index[here]] == wanted[here]
                index[here] = group.rank[index[here]]
            slots[np.flatnonzero(mine)[here]] = group.first_slot + index[here]
        strange = int((slots < 0).sum())
        if strange:
            raise ValueError(
                f"{strange} of {len(slots)} remembered impulses belong to interactions "
                "that this scene does not have: the memory is of another scene."
            )
        order = np.argsort(slots, kind="stable")
        self._slots = slots[order].astype(np.int32)
        states = np.full((len(order), self._states.shape[1]), np.nan)
        states[:, : memory.state.shape[1]] = memory.state[order]  # older checkpoints hold no predicted gaps
        self._impulses, self._states = memory.impulse[order], states


def surfaces_met(groups: list[Group], contactors: ContactorTable, slots: int) -> np.ndarray | None:
    """A number for each slot, (slots,): the same for the pairs of one contactor and one surface under one law, -1 for pairs
    without a feature and for two surfaces; None if there are none but these."""
    feature, surface, elements = contactors.features, contactors.body, contactors.elements
    if elements is not None:
        feature, surface = feature.copy(), surface.copy()
        feature[elements.rows] = True
        surface[elements.rows] = surface.max(initial=0) + 1 + elements.skin
    if not feature.any():
        return None
    count, numbers = len(feature) + int(surface.max(initial=0)) + 1, np.full(slots, -1)
    for group in groups:
        if group.chain is not None or group.kinds is None:
            continue
        one = feature[group.pairs]
        # the surface in place of its feature; which of the two is it does not matter
        sides = np.where(one, len(feature) + surface[group.pairs], group.pairs)
        row = next(i for i, other in enumerate(groups) if other.row is group.row and other.chain is None)
        key = (row * count + sides.max(axis=1)) * count + sides.min(axis=1)
        numbers[group.first_slot : group.first_slot + group.slots] = np.where(one.sum(axis=1) == 1, key, -1)
    return numbers


def table_index(group: Group, tables: list) -> int:
    """Index of the group's chain or row in ``tables``, the chains and then the rows of the visibility table."""
    return next(i for i, table in enumerate(tables) if table is group.chain or table is group.row)


@kernel
def recall(slots, known, impulses, states, impulse, state):
    """Copy the rows of ``impulses`` and ``states``, one for each of the slots ``known``, to the rows of ``impulse`` and
    ``state`` with the same ``slots``; others get 0 and NaN. Both ascend."""
    k = 0
    for i in range(slots.shape[0]):
        while k < known.shape[0] and known[k] < slots[i]:
            k += 1
        here = k < known.shape[0] and known[k] == slots[i]
        for column in range(impulse.shape[1]):
            impulse[i, column] = impulses[k, column] if here else 0.0
        for column in range(state.shape[1]):
            state[i, column] = states[k, column] if here else np.nan


@kernel
def carry(old, old_rank, remembered, new, new_rank, source):
    """Carry an index from each pair of the old list to the same pair of the new list: ``source[new] = remembered[old]`` if
    that is not negative. ``old_rank``, ``new_rank``: index in its list of each pair in the order of ids."""
    k = 0
    for p in range(old_rank.shape[0]):
        here = old_rank[p]
        if remembered[here] < 0:
            continue
        c = old[here, 0]
        a = old[here, 1]
        # both lists ascend by ids: go on in the new list to this pair, or to the first pair after it
        while k < new_rank.shape[0]:
            there = new_rank[k]
            if new[there, 0] > c or (new[there, 0] == c and new[there, 1] >= a):
                if new[there, 0] == c and new[there, 1] == a:
                    source[there] = remembered[here]
                break
            k += 1
