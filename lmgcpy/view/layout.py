"""The check of a layout: bodies that overlap, and links longer than their reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number
from lmgcpy.view.snapshot import Snapshot, snapshot

OVERLAP = 0.01
"""Part of the smaller radius from which an overlap is told: what is laid geometrically overlaps by 1e-9 of it, a sample
relaxed at a tolerance of 1e-2 by up to 3.5 %, at few places by more than this."""
EXCESS = 0.01
"""Part of its reference length by which a link must exceed it to be told; the time stepping itself leaves less."""
SHOWN = 10
"""Lines of a table that are written out."""

PAIR = np.dtype([("candidate", "i8"), ("antagonist", "i8"), ("depth", "f8"), ("share", "f8")])
LINK = np.dtype(
    [
        *(("chain", "i8"), ("link", "i8"), ("antagonist", "i8"), ("candidate", "i8")),
        *(("length", "f8"), ("excess", "f8")),
    ]
)


@dataclass(frozen=True)
class Layout:
    """What :func:`check` found, the worst first. ``str`` of it is a table."""

    overlaps: np.ndarray
    """A row a pair: ``candidate``, ``antagonist`` (ids), ``depth`` [m], ``share`` of the smaller radius."""
    links: np.ndarray
    """A row a link: ``chain`` and ``link`` (numbers), ``antagonist``, ``candidate`` (ids), ``length`` between the centres
    [m], ``excess``: the part of its reference length by which it is longer."""

    @property
    def sound(self) -> bool:
        """Whether there is nothing to tell."""
        return not len(self.overlaps) and not len(self.links)

    def __repr__(self) -> str:
        return f"<Layout: {len(self.overlaps)} overlaps, {len(self.links)} links longer than their reference>"

    def __str__(self) -> str:
        lines = [f"overlaps: {len(self.overlaps)}; links longer than their reference: {len(self.links)}"]
        if len(self.overlaps):
            lines.append("  bodies               depth [m]   of the smaller radius")
        for row in self.overlaps[:SHOWN]:
            bodies = f"{row['antagonist']:<9d} {row['candidate']:<9d}"
            lines.append(f"  {bodies} {row['depth']:10.3g}   {100 * row['share']:.3g} %")
        if len(self.overlaps) > SHOWN:
            lines.append(f"  and {len(self.overlaps) - SHOWN} more")
        if len(self.links):
            lines.append("  chain  link   bodies              length [m]   over its reference")
        for row in self.links[:SHOWN]:
            which = f"{row['chain']:<6d} {row['link']:<6d} {row['antagonist']:<9d} {row['candidate']:<9d}"
            lines.append(f"  {which} {row['length']:10.4g}   {100 * row['excess']:.3g} %")
        if len(self.links) > SHOWN:
            lines.append(f"  and {len(self.links) - SHOWN} more")
        return "\n".join(lines)


@named_arguments
def check(source: Any, *, frame: int | None = None, overlap: float = OVERLAP, excess: float = EXCESS) -> Layout:
    """Look for bodies that overlap and for links longer than their reference, in a scene, a simulation, or a run.

    ``frame``: of a run, by default the last. Told are overlaps deeper than the part ``overlap`` of the smaller radius,
    between bodies that see each other (between all, in a scene without a visibility table), and links longer than their
    reference length by more than the part ``excess`` of it. Shapes other than disks, spheres, lines, planes and cylinders
    are taken for the circles that hold them.
    """
    overlap = number(overlap, "overlap", minimum=0.0)
    excess = number(excess, "excess", minimum=0.0)
    moment = snapshot(source, frame)
    return Layout(overlaps_of(moment, overlap), long_links_of(moment, excess))


def overlaps_of(moment: Snapshot, share: float) -> np.ndarray:
    """Rows of :data:`PAIR`, deepest first for their radius."""
    rounds = moment.rounds
    radius = rounds.shape[:, 0]
    first, second, gap = near_pairs(rounds.position, radius)
    pieces = [(rounds.body[first], rounds.body[second], gap, np.minimum(radius[first], radius[second]))]
    for wall, point, normal in zip(moment.walls.body, moment.walls.position, moment.walls.shape, strict=True):
        gap = (rounds.position - point) @ normal - radius
        pieces.append((rounds.body, np.full(len(gap), wall), gap, radius))
    for tube, point, shape in zip(moment.cylinders.body, moment.cylinders.position, moment.cylinders.shape, strict=True):
        away = rounds.position - point
        away -= (away @ shape[:3])[:, None] * shape[:3]
        gap = shape[3] - np.linalg.norm(away, axis=1) - radius
        pieces.append((rounds.body, np.full(len(gap), tube), gap, radius))
    a, b, gap, smaller = (np.concatenate(part) for part in zip(*pieces, strict=True))
    deep = (-gap > share * smaller) & (a != b)
    a, b, depth, part = a[deep], b[deep], -gap[deep], -gap[deep] / smaller[deep]
    seen = visible(moment, a, b)
    order = np.argsort(-part[seen], kind="stable")
    found = np.zeros(len(order), dtype=PAIR)
    low, high = np.minimum(a, b)[seen][order], np.maximum(a, b)[seen][order]
    found["antagonist"], found["candidate"] = low, high
    found["depth"], found["share"] = depth[seen][order], part[seen][order]
    _, unique = np.unique(np.column_stack([low, high]), axis=0, return_index=True)  # of clusters the deepest contactors
    return found[np.sort(unique)]


def near_pairs(positions: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of circles or spheres that touch or overlap, and their gaps [m], (p,) each.

    A tree for each octave of the radius, so that beads among large grains do not each look at a grain's whole
    surroundings. (Detection has compiled kernels for this, which a look at a file should not wait for.)
    """
    from scipy.spatial import cKDTree

    octave = np.floor(np.log2(radius)).astype(int)
    members = [np.flatnonzero(octave == k) for k in np.unique(octave)]
    trees = [cKDTree(positions[ids]) for ids in members]
    found = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))]
    for i, tree in enumerate(trees):
        for j in range(i, len(trees)):
            reach = float(radius[members[i]].max() + radius[members[j]].max())
            near = tree.sparse_distance_matrix(trees[j], reach, output_type="ndarray")
            a, b = members[i][near["i"]], members[j][near["j"]]
            gap = near["v"] - radius[a] - radius[b]
            kept = (gap <= 0.0) & ((a < b) if i == j else True)
            found.append((a[kept], b[kept], gap[kept]))
    a, b, gap = (np.concatenate(part) for part in zip(*found, strict=True))
    return a, b, gap


def visible(moment: Snapshot, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether bodies see each other, (p,)."""
    table = moment.scene["visibility"]
    if not table:
        return np.ones(len(a), dtype=bool)
    words = moment.scene["bodies"]["colors"]
    sees = np.zeros((len(words), len(words)), dtype=bool)
    for row in table:
        if row["candidate"] in words and row["antagonist"] in words:
            i, j = words.index(row["candidate"]), words.index(row["antagonist"])
            sees[i, j] = sees[j, i] = True
    color = moment.scene["bodies"]["color"]
    return sees[color[a], color[b]]


def long_links_of(moment: Snapshot, excess: float) -> np.ndarray:
    """Rows of :data:`LINK`, the longest first for their reference."""
    rows = [np.zeros(0, dtype=LINK)]
    for number_of_chain, chain in enumerate(moment.chains):
        a, b = chain.path[:-1], chain.path[1:]
        length = np.linalg.norm(moment.positions[b] - moment.positions[a], axis=1)
        over = length / chain.reference - 1.0
        link = np.flatnonzero(over > excess)
        row = np.zeros(len(link), dtype=LINK)
        row["chain"], row["link"] = number_of_chain, link
        row["antagonist"], row["candidate"] = a[link], b[link]
        row["length"], row["excess"] = length[link], over[link]
        rows.append(row)
    found = np.concatenate(rows)
    return found[np.argsort(-found["excess"], kind="stable")]
