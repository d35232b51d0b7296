"""The check of a layout: bodies that overlap, and links longer than their reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.segments import facet_distances, segment_distances
from lmgcpy.errors import named_arguments, number
from lmgcpy.view.snapshot import Snapshot, snapshot

OVERLAP = 0.01
"""Least overlap that is reported, as part of the smaller radius. A geometric deposit overlaps by 1e-9 of it. A sample
relaxed at a tolerance of 1e-2 overlaps by up to 3.5 %, at few contacts by more than 1 %."""
EXCESS = 0.01
"""Least excess of a link over its reference length that is reported, as part of that length. Time stepping leaves less."""
SHOWN = 10
"""Number of lines of a table that are written out."""

PAIR = np.dtype([("candidate", "i8"), ("antagonist", "i8"), ("depth", "f8"), ("share", "f8")])
LINK = np.dtype(
    [
        *(("chain", "i8"), ("link", "i8"), ("antagonist", "i8"), ("candidate", "i8")),
        *(("length", "f8"), ("excess", "f8")),
    ]
)


@dataclass(frozen=True)
class Layout:
    """Overlaps and long links that :func:`check` found, the worst first. ``str`` makes a table."""

    overlaps: np.ndarray
    """One row for each pair: ``candidate``, ``antagonist`` (ids), ``depth`` [m], ``share`` of the smaller radius."""
    links: np.ndarray
    """One row for each link: ``chain`` and ``link`` (numbers), ``antagonist``, ``candidate`` (ids), ``length`` between the
    centres [m], ``excess``: the part of its reference length by which it is longer."""

    @property
    def sound(self) -> bool:
        """Whether nothing was found."""
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

    ``frame`` of a run is by default the last. The result holds overlaps deeper than the part ``overlap`` of the smaller
    radius, between bodies that see each other (between all bodies in a scene without a visibility table), and links longer
    than their reference length by more than the part ``excess`` of it. The shapes of plug-ins count as the circles that
    hold them, those with an outline not at all.
    """
    overlap = number(overlap, "overlap", minimum=0.0)
    excess = number(excess, "excess", minimum=0.0)
    snap = snapshot(source, frame)
    return Layout(overlaps_of(snap, overlap), long_links_of(snap, excess))


def overlaps_of(snap: Snapshot, share: float) -> np.ndarray:
    """Rows of :data:`PAIR`, deepest first for their radius."""
    rounds, rods = snap.rounds, snap.rods
    body, middle = np.concatenate([rounds.body, rods.body]), np.concatenate([rounds.position, rods.position])
    radius, half = np.concatenate([rounds.shape[:, 0], rods.shape[:, 0]]), np.zeros_like(middle)
    half[len(rounds.body) :] = rods.shape[:, 1:]
    first, second, gap = near_pairs(middle, radius + np.linalg.norm(half, axis=1))
    if len(rods.body):
        apart = segment_distances(middle[first], half[first], middle[second], half[second])
        gap = apart - radius[first] - radius[second]
    pieces = [(body[first], body[second], gap, np.minimum(radius[first], radius[second]))]
    # at walls the spheres at the ends of rods decide
    body, middle, radius = rounds.body, rounds.position, rounds.shape[:, 0]
    for wall, point, normal in zip(snap.walls.body, snap.walls.position, snap.walls.shape, strict=True):
        gap = (middle - point) @ normal - radius
        pieces.append((body, np.full(len(gap), wall), gap, radius))
    for tube, point, shape in zip(snap.cylinders.body, snap.cylinders.position, snap.cylinders.shape, strict=True):
        away = middle - point
        away -= (away @ shape[:3])[:, None] * shape[:3]
        gap = shape[3] - np.linalg.norm(away, axis=1) - radius
        pieces.append((body, np.full(len(gap), tube), gap, radius))
    pieces += facet_overlaps(snap)
    a, b, gap, smaller = (np.concatenate(part) for part in zip(*pieces, strict=True))
    deep = (-gap > share * smaller) & (a != b)
    a, b, depth, part = a[deep], b[deep], -gap[deep], -gap[deep] / smaller[deep]
    seen = visible(snap, a, b) & ~tied(snap, a, b)
    order = np.argsort(-part[seen], kind="stable")
    found = np.zeros(len(order), dtype=PAIR)
    low, high = np.minimum(a, b)[seen][order], np.maximum(a, b)[seen][order]
    found["antagonist"], found["candidate"] = low, high
    found["depth"], found["share"] = depth[seen][order], part[seen][order]
    _, unique = np.unique(np.column_stack([low, high]), axis=0, return_index=True)  # clusters: their deepest contactors
    return found[np.sort(unique)]


def facet_overlaps(snap: Snapshot) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Disks or spheres near the facets of surfaces: their bodies, the bodies of the surfaces, gaps from either side, and
    radii [m], (p,) each."""
    from scipy.spatial import cKDTree

    balls, facets = snap.rounds, snap.facets
    if not facets or not len(balls.body):
        return []
    owner, corners = np.array([body for body, _ in facets]), np.array([points for _, points in facets])
    thick = snap.thickness[owner]
    middle = 0.5 * (corners.min(axis=1) + corners.max(axis=1))
    reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1) + thick + float(balls.shape[:, 0].max())
    near = cKDTree(balls.position).query_ball_point(middle, reach)
    facet = np.repeat(np.arange(len(facets)), [len(ids) for ids in near])
    ball = np.concatenate([np.zeros(0, np.int64), *map(np.array, near)]).astype(np.int64)
    radius = balls.shape[ball, 0]
    gap = facet_distances(balls.position[ball], corners[facet]) - radius - thick[facet]
    return [(balls.body[ball], owner[facet], gap, radius)]


def near_pairs(positions: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of circles or spheres that touch or overlap, and their gaps [m], (p,) each.

    There is a tree for each octave of the radius, so that beads among large grains do not each search the whole
    neighbourhood of a grain. (The compiled kernels of detection could do this, but a look at a file should not wait for
    the compiler.)
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


def visible(snap: Snapshot, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether bodies see each other, (p,)."""
    table = snap.scene["visibility"]
    if not table:
        return np.ones(len(a), dtype=bool)
    words = snap.scene["bodies"]["colors"]
    sees = np.zeros((len(words), len(words)), dtype=bool)
    for row in table:
        if row["candidate"] in words and row["antagonist"] in words:
            i, j = words.index(row["candidate"]), words.index(row["antagonist"])
            sees[i, j] = sees[j, i] = True
    color = snap.scene["bodies"]["color"]
    return sees[color[a], color[b]]


def tied(snap: Snapshot, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Whether joints tie bodies that do not collide, (p,)."""
    if "joints" not in snap.scene:
        return np.zeros(len(a), dtype=bool)
    table, count = snap.scene["joints"], len(snap.positions)
    pairs = np.sort(table["body"][~table["collide"]], axis=1)
    return np.isin(np.minimum(a, b) * count + np.maximum(a, b), pairs[:, 0] * count + pairs[:, 1])


def long_links_of(snap: Snapshot, excess: float) -> np.ndarray:
    """Rows of :data:`LINK`, the longest first for their reference."""
    rows = [np.zeros(0, dtype=LINK)]
    for number_of_chain, (chain, course) in enumerate(zip(snap.chains, snap.courses, strict=True)):
        a, b = chain.path[:-1], chain.path[1:]
        length = np.linalg.norm(np.diff(course, axis=0), axis=1)
        over = length / chain.reference - 1.0
        link = np.flatnonzero(over > excess)
        row = np.zeros(len(link), dtype=LINK)
        row["chain"], row["link"] = number_of_chain, link
        row["antagonist"], row["candidate"] = a[link], b[link]
        row["length"], row["excess"] = length[link], over[link]
        rows.append(row)
    found = np.concatenate(rows)
    return found[np.argsort(-found["excess"], kind="stable")]
