"""The order in which the groups of a step are swept, and the tasks that threads may do side by side."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lmgcpy.contact.detector import Group
from lmgcpy.solve.kernels.law_kernels import LawKernels
from lmgcpy.solve.kernels.system import Groups

Piece = tuple[int, int, int, bool]
"""Group, first row, row after the last, whether it is in a slab."""


def schedule(groups: list[Group], kernels: list[LawKernels], offset: np.ndarray) -> Groups:
    """The groups of a step, one after another. A partitioned scene (:mod:`lmgcpy.contact.slabs`) has four phases: chains,
    side by side if no body is in two of them; even slabs; odd slabs; pairs in no slab.

    ``offset``: where the numbers of each group begin in ``System.prepared``.
    """
    if all(group.cuts is None for group in groups):
        order = [piece for g, group in enumerate(groups) for piece in _in_blocks(g, group, kernels[g])]
        first = [offset[g] + len(groups[g].law.PREPARED) * (start - groups[g].start) for g, start, _, _ in order]
        ends = [start for _, start, _, _ in order], [stop for _, _, stop, _ in order]
        return Groups.in_order([kernels[g] for g, _, _, _ in order], *ends, first)
    pieces: list[Piece] = []
    task, phase = [0], [0]
    for tasks in _phases(groups, kernels):
        for found in tasks:
            if found:
                pieces += found
                task.append(len(pieces))
        if len(task) - 1 > phase[-1]:
            phase.append(len(task) - 1)
    table = np.array(pieces, dtype=np.int64).reshape(-1, 4)
    of = table[:, 0].tolist()
    walls = [groups[g].walls if inside else -1 for g, _, _, inside in pieces]
    width = np.array([len(group.law.PREPARED) for group in groups])
    starts = np.array([group.start for group in groups])
    return Groups(
        sweep=np.array([kernels[g].sweep_in_slab(wall).address for g, wall in zip(of, walls, strict=True)], np.int64),
        error=np.array([kernels[g].error.address for g in of], np.int64),
        momentum=np.array([kernels[g].momentum.address for g in of], np.int64),
        start=table[:, 1].copy(),
        stop=table[:, 2].copy(),
        offset=np.asarray(offset)[of] + width[of] * (table[:, 1] - starts[of]),
        walls=np.array(walls, np.int64),
        task=np.array(task),
        phase=np.array(phase),
    )


def _in_blocks(g: int, group: Group, kernels: LawKernels) -> list[Piece]:
    """The pieces of a group that are swept one after another: all of it, or the links of each joint if they are a block."""
    if not (group.jointed and kernels.key.block):
        return [(g, group.start, group.stop, False)]
    d = kernels.key.form.dimension
    return [(g, row, row + d, False) for row in range(group.start, group.stop, d)]


def _phases(groups: list[Group], kernels: list[LawKernels]) -> Iterator[list[list[Piece]]]:
    """The tasks of each phase, each a list of pieces; some may be empty."""
    chains = [_in_blocks(g, group, kernels[g]) for g, group in enumerate(groups) if group.chain]
    yield chains if _chains_apart(groups) else [[piece for chain in chains for piece in chain]]
    rows = {g: group.rows.tolist() for g, group in enumerate(groups) if group.rows is not None}
    slabs = _slabs(groups)
    for parity in (0, 1):
        yield [_cut(rows, slab, inside=True) for slab in range(parity, slabs, 2)]
    yield [_cut(rows, slabs, inside=False)]


def most_at_once(groups: list[Group]) -> int:
    """Largest number of tasks that a phase may have."""
    if all(group.cuts is None for group in groups):
        return 1
    chains = sum(group.chain is not None for group in groups)
    return max((_slabs(groups) + 1) // 2, chains if _chains_apart(groups) else 1)


def _chains_apart(groups: list[Group]) -> bool:
    """Whether no body is in two chains."""
    bodies = [np.unique(group.chain.bodies) for group in groups if group.chain]
    return len(np.unique(np.concatenate([np.zeros(0, int), *bodies]))) == sum(map(len, bodies))


def _slabs(groups: list[Group]) -> int:
    """Number of slabs."""
    return max(len(group.cuts) - 2 for group in groups if group.cuts is not None)


def _cut(rows: dict[int, list[int]], slab: int, *, inside: bool) -> list[Piece]:
    """The pieces that the groups have in one slab."""
    return [(g, cut[slab], cut[slab + 1], inside) for g, cut in rows.items() if cut[slab + 1] > cut[slab]]
