"""The partition of a large scene into slabs, from its geometry alone, so that threads can share a sweep.

Every bounded body is in one slab. Slabs lie side by side along the longest horizontal axis of the sample. A pair within a
slab, or between a slab and the next, belongs to the lower of the two slabs. So slabs i and i + 2 share no body: all even
slabs can be swept at the same time, then all odd ones. The result has the same bits for every number of threads. Bodies
without bounds that are held (walls) are never written to and belong to no slab. One thread sweeps the other pairs at the
end: pairs that reach further than the next slab, and pairs with walls that move under a load.

Across a periodic axis the slabs are a ring: the first comes after the last, which has the pairs of both. Their number is
even then, so that the last is odd and the first even. They lie between planes along the other edges of the cell
(:meth:`~lmgcpy.contact.lattice.Lattice.across`), however the cell leans.

Within a slab the sweep goes upward, row by row, and the solver keeps the bodies in that order, so that the next data are
in the cache or come in a stream. In large scenes one thread gains by this order, too: ids are unrelated to positions, and
a sweep by ids over 50 000 spheres waits for memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.detection_tables import ContactorTable

_partition_from = [{2: 10_000, 3: 3000}]
"""Least number of bounded contactors of a scene that is partitioned, by dimension; smaller scenes keep the order of ids.
From this number on one thread loses nothing if ids are unrelated to positions, and two threads are faster by 1.7 and more
(``benchmarks/threads.py``)."""
MOST_SLABS = 32
"""Greatest number of slabs; half of them can be swept at the same time."""
LEAST_SLABS = 8
"""A sample with room for this many slabs along a horizontal axis is cut across that axis."""
BODIES_A_SLAB = 1250
"""Least number of bodies in a slab if there are more than :data:`LEAST_SLABS` slabs: fewer slabs need fewer sweeps."""
BINS = 1024
"""Number of bins along the axis; slabs are cut at their borders."""
MOST_ROWS = 64
"""Greatest number of rows along each of the other axes."""
NOWHERE, EVERYWHERE = -1, -2
"""Slab of a body without bounds: held, or moving."""


def is_large(count: int, dimension: int) -> bool:
    """Whether a scene of ``count`` bounded contactors is partitioned."""
    return count >= _partition_from[-1][dimension]


@contextmanager
def partition_from(count: int) -> Iterator[None]:
    """In this context, simulations are partitioned from ``count`` bounded contactors on; for tests and benchmarks."""
    _partition_from.append({2: count, 3: count})
    try:
        yield
    finally:
        _partition_from.pop()


@dataclass(frozen=True)
class Slabs:
    """Slab and place of each of n bodies."""

    count: int
    ring: bool
    """Whether the first slab comes after the last."""
    slab: np.ndarray
    """Slab of each body, (n,) int32; NOWHERE or EVERYWHERE if it has no bounds."""
    place: np.ndarray
    """Place of each body in the order of the sweep, slab by slab, (n,) int32; bodies without bounds come last."""


def cut_slabs(along: np.ndarray, width: float) -> tuple[int, np.ndarray]:
    """Slabs of about equal numbers of points and no narrower than ``width`` [m]: their number, and the slab of each point.

    ``along``: coordinates of the points along the axis [m], (n,).
    """
    low, span = float(along.min()), float(np.ptp(along))
    most = min(MOST_SLABS, max(LEAST_SLABS, len(along) // BODIES_A_SLAB))
    wanted = min(most, int(span / width)) if span > 0.0 else 1
    if wanted < 2:
        return 1, np.zeros(len(along), np.int32)
    bins = np.minimum((along - low) * (BINS / span), BINS - 1).astype(np.int32)
    least = int(np.ceil(width * BINS / span))
    slab_of_bin = np.zeros(BINS, np.int32)
    slab, first, inside = 0, 0, 0
    for k, number in enumerate(np.bincount(bins, minlength=BINS).tolist()):
        if inside * wanted >= len(along) and k - first >= least:
            slab, first, inside = slab + 1, k, 0
        slab_of_bin[k] = slab
        inside += number
    return slab + 1, slab_of_bin[bins]


def cut_ring(along: np.ndarray, width: float, period: float) -> tuple[int, np.ndarray]:
    """Slabs of a periodic axis, with coordinates ``along`` in [0, period) [m], (n,): an even number of them, or one.

    As :func:`cut_slabs`, with equal shares of the points and the greatest number of slabs that are all wide enough.
    """
    most = min(MOST_SLABS, max(LEAST_SLABS, len(along) // BODIES_A_SLAB), int(period / width))
    bins = np.minimum(along * (BINS / period), BINS - 1).astype(np.int32)
    inside = np.bincount(bins, minlength=BINS)
    before = np.cumsum(inside) - inside
    for count in range(most - most % 2, 3, -2):
        slab_of_bin = np.minimum(before * count // len(along), count - 1).astype(np.int32)
        if np.bincount(slab_of_bin, minlength=count).min() >= np.ceil(width * BINS / period):
            return count, slab_of_bin[bins]
    return 1, np.zeros(len(along), np.int32)


def sweep_axes(spans: np.ndarray, width: float) -> list[int]:
    """The axis across which slabs are cut, and then those along which the rows within a slab are counted.

    ``spans``: extent of the sample along each axis [m], (d,), the last of them upward.

    Weight goes down from body to body, so a sweep should visit bodies in the order of their height: slabs lie side by
    side, and rows are counted upward. Only a sample that is too slender for that is cut across its height.
    """
    *level, upward = range(len(spans))
    longest = max(level, key=lambda axis: spans[axis])
    if spans[longest] >= min(LEAST_SLABS * width, spans[upward]):
        return [longest, upward, *(axis for axis in level if axis != longest)]
    return [upward, *level]


def partition(centres: np.ndarray, width: float, period: np.ndarray) -> tuple[int, bool, np.ndarray, np.ndarray]:
    """Partition of points (n, d) into slabs no narrower than ``width`` [m], and rows within them: the number of slabs,
    whether they are a ring, the slab of each point, and its place in the order of the sweep.

    ``period`` of each coordinate [m], (d,), infinite along axes that are not periodic.
    """
    spans = np.where(np.isfinite(period), period, [np.ptp(along) for along in centres.T])
    across, *others = sweep_axes(spans, width)
    ring = bool(np.isfinite(period[across]))
    along = centres[:, across]
    count, slab = cut_ring(along, width, float(period[across])) if ring else cut_slabs(along, width)
    key = slab.astype(np.int64)
    for axis in others:
        rows = min(MOST_ROWS, int(spans[axis] / width) + 1)
        row = (centres[:, axis] - centres[:, axis].min()) * (rows / max(float(spans[axis]), width))
        key = key * rows + np.minimum(row, rows - 1).astype(np.int64)
    place = np.empty(len(centres), np.int32)
    key = key.astype(np.min_scalar_type(int(key.max())))  # numpy sorts numbers of 16 bits in O(n)
    place[np.argsort(key, kind="stable")] = np.arange(len(centres), dtype=np.int32)
    return count, ring, slab, place


def cut_bodies(
    placed: np.ndarray,
    period: np.ndarray,
    contactors: ContactorTable,
    bounded: np.ndarray,
    free: np.ndarray,
    width: float,
) -> Slabs:
    """The partition of the bodies, by their first contactor, into slabs no narrower than ``width`` [m].

    ``placed``: positions of the contactors, (k, d), and their ``period``, see :func:`partition`; ``bounded``: whether each
    is bounded, (k,); ``free``: whether each body has a component that is not held, (n,).
    """
    indices = np.flatnonzero(bounded)
    first = indices[np.diff(contactors.body[indices], prepend=-1) > 0]  # bodies ascend
    bodies = contactors.body[first]
    count, ring, slab_of, place_of = partition(placed.take(first, axis=0), width, period)
    slab = np.where(free, EVERYWHERE, NOWHERE).astype(np.int32)
    slab[bodies] = slab_of
    place = np.empty(len(slab), np.int32)
    place[slab < 0] = np.arange(len(bodies), len(slab))
    place[bodies] = place_of
    return Slabs(count, ring, slab, place)


@kernel
def sort_pairs(pairs, body, count, ring, slab, place, walls, rank, result, cuts):
    """Write the pairs into ``result`` in the order of the sweep, and the new index of each pair into ``rank``. Pairs are
    sorted by the earlier of their two bodies, on a ring by the body in the last slab if the other is in the first; pairs
    with the same one keep their order.

    ``walls``: 0 if the candidates are walls, 1 if the antagonists are, else -1. ``cuts``: start of each slab in
    ``result``, then the start of the pairs in no slab, then the total.
    """
    # key of a pair: the place of its body that comes first; pairs of no slab come last
    cuts[:] = 0
    last = place.shape[0]
    key = np.empty(pairs.shape[0], np.int64)
    first = np.zeros(last + 2, np.int64)
    for p in range(pairs.shape[0]):
        c = body[pairs[p, 0]]
        a = body[pairs[p, 1]]
        key[p] = last
        mine = count
        if walls == 0:
            if slab[c] == NOWHERE and slab[a] >= 0:
                mine = slab[a]
                key[p] = place[a]
        elif walls == 1:
            if slab[a] == NOWHERE and slab[c] >= 0:
                mine = slab[c]
                key[p] = place[c]
        elif slab[c] >= 0 and slab[a] >= 0 and abs(slab[c] - slab[a]) <= 1:
            mine = min(slab[c], slab[a])
            key[p] = min(place[c], place[a])
        elif ring and slab[c] >= 0 and slab[a] >= 0 and abs(slab[c] - slab[a]) == count - 1:
            mine = count - 1
            key[p] = max(place[c], place[a])
        cuts[mine + 1] += 1
        first[key[p] + 1] += 1
    # counting sort by the key
    for k in range(1, cuts.shape[0]):
        cuts[k] += cuts[k - 1]
    for k in range(1, first.shape[0]):
        first[k] += first[k - 1]
    for p in range(pairs.shape[0]):
        k = first[key[p]]
        first[key[p]] += 1
        rank[p] = k
        result[k, 0] = pairs[p, 0]
        result[k, 1] = pairs[p, 1]
