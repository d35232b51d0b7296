"""Groups of interactions. A group has one law and one kind of contactor pair, or is one chain."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.contact.detection_tables import ChainTable, ContactorTable, JointTable, VisibilityRow
from lmgcpy.contact.elements import corners_of
from lmgcpy.contact.neighbours import KindPair
from lmgcpy.contact.slabs import Slabs, sort_pairs
from lmgcpy.laws import Law


@dataclass
class Group:
    """Interactions of one law and one kind of contactor pair (``chain``: of a chain, or of joints), rows start to stop."""

    law: Law
    form: str = "central"
    """Name of the form of the rows of H, see ``lmgcpy.solve.kernels.forms``."""
    chain: ChainTable | None = None
    row: VisibilityRow | None = None
    pairs: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    placed_pairs: np.ndarray | None = None
    """The pairs with the rows of images, in a periodic cell; None without a cell."""
    rank: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    """Index in ``pairs`` of each pair in the order of ids: 0, 1, 2, ... unless the scene is partitioned."""
    cuts: np.ndarray | None = None
    """Start of each slab in ``pairs``, then the start of the pairs in no slab, then the total. None without slabs."""
    rows: np.ndarray | None = None
    """The same starts as row numbers of the interactions. None without slabs."""
    walls: int = -1
    """0 if all candidates are walls, 1 if all antagonists are, else -1; -1 without slabs. Only held walls are in slabs."""
    kernel: Kernel | None = None
    kinds: KindPair | None = None
    unbounded: bool = False
    """Whether some of its contactors have no bounds."""
    first_slot: int = 0
    start: int = 0
    stop: int = 0
    diagonal: bool = True
    isotropic: bool = True
    """Whether each of its bodies has the same inertia about all axes; needed only if contacts roll in 3D."""

    @cached_property
    def on_elements(self) -> bool:
        """Whether at least one side of its interactions is an element."""
        return self.kinds is not None and max(self.kinds.corners) > 1

    @cached_property
    def foreign(self) -> bool:
        """Whether its narrow phase is not lmgcpy's own."""
        return self.kinds is not None and self.kinds.foreign

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
    def jointed(self) -> bool:
        """Whether its interactions are those of joints."""
        return isinstance(self.chain, JointTable)

    @property
    def identity(self) -> tuple[int, int]:
        """Key by which the group is found again in another list: the chain, or the row and the kinds."""
        return id(self.chain or self.row), id(self.kinds)


def first_contact(groups: list[Group]) -> int:
    """Row of the first interaction that is no link: links come first."""
    return max((group.stop for group in groups if group.chain is not None), default=0)


def contact_group(
    row: VisibilityRow,
    kinds: KindPair,
    pairs: np.ndarray,
    kernel: Kernel,
    form: str,
    body: np.ndarray,
    bounded: np.ndarray,
    slabs: Slabs | None,
) -> Group:
    """The group of one row of the visibility table and two kinds of contactor.

    ``pairs``: the neighbours of these kinds, (p, 2), sorted; ``kernel``: their narrow phase; ``form``: form of the rows
    of H; ``body``: row of the body of each contactor, (k,); ``bounded``: whether each contactor is bounded, (k,).
    """
    unbounded = meets_walls(kinds, bounded)
    group = Group(row.law, form, row=row, pairs=pairs, kernel=kernel, kinds=kinds, unbounded=unbounded)
    if slabs is None:
        group.rank = np.arange(len(pairs), dtype=np.int32)
        return group
    for side, mine in enumerate((kinds.is_candidate, kinds.is_antagonist)):
        if not (mine & bounded).any():
            group.walls = side
    group.pairs, group.rank = np.empty_like(pairs), np.empty(len(pairs), np.int32)
    group.cuts = np.empty(slabs.count + 2, np.int64)
    where = slabs.count, slabs.ring, slabs.slab, slabs.place
    sort_pairs(pairs, body, *where, group.walls, group.rank, group.pairs, group.cuts)
    return group


def meets_walls(kinds: KindPair, bounded: np.ndarray) -> bool:
    """Whether some of the contactors of two kinds have no bounds."""
    return bool((~bounded & (kinds.is_candidate | kinds.is_antagonist)).any())


def check_pairs(contactors: ContactorTable, rows: list[VisibilityRow]) -> None:
    """ValueError if the visibility table gives a law a pair of contactors that the law is not for."""
    kinds: dict[str, set[str]] = {}
    for kind, color in zip(contactors.kind, contactors.color, strict=True):
        kinds.setdefault(color, set()).add(kind)
    d = contactors.offset.shape[1]
    for row in rows:
        colors = row.candidate, row.antagonist
        on_nodes = [color for color in colors if any(corners_of(kind) > 1 for kind in kinds.get(color, ()))]
        if row.law.rows(d) > d and on_nodes:
            raise ValueError(
                f"Law '{row.law.NAME}' has rolling friction, and '{on_nodes[0]}' is a thread or membrane, which has no "
                "spin: give them lmgcpy.Coulomb."
            )
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
