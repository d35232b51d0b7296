"""The smooth thread through the beads that the laying rules have placed: its nodes, and where it lies."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

WIRES = ("thread", "beads")
"""Wires in 3D: a smooth thread, or a chain of beads."""


def thread_nodes(
    beads: Sequence[np.ndarray], *, spacing: float, node_distance: float, radius: float, box: Sequence[float]
) -> tuple[list[np.ndarray], np.ndarray]:
    """Nodes of threads through chains of ``beads`` (b, 3) that are ``spacing`` apart [m]: nodes of each thread (n, 3), and
    the lengths of the thread between them (links,) [m].

    Nodes are beads, ``node_distance`` [m] apart at the most, or ``spacing`` if that is more, and closer at sharp turns.
    Segments that would cross are moved apart by some radii of the thread, within a box from the origin with these sizes
    [m], (3,).
    """
    every = max(1, int(node_distance / spacing + 1e-9))
    chosen = [_chosen(chain, spacing, every) for chain in beads]
    nodes = [chain[which] for chain, which in zip(beads, chosen, strict=True)]
    lengths = spacing * np.concatenate([np.diff(which) for which in chosen])
    return _moved_apart(nodes, radius, np.array(box)), lengths


STRAIGHT = 0.95
"""Least distance of the ends of a segment of a thread over the length of the wire between them."""


def _chosen(beads: np.ndarray, link: float, every: int) -> np.ndarray:
    """Numbers of the beads that are nodes: at most ``every`` links from one to the next, and fewer at turns of the wire: a
    longer segment would cut the corner, and come across the wire's other turns."""
    found = [0]
    while found[-1] < len(beads) - 1:
        i = found[-1]
        step = min(every, len(beads) - 1 - i)
        while step > 1 and np.linalg.norm(beads[i + step] - beads[i]) < STRAIGHT * step * link:
            step -= 1
        found.append(i + step)
    return np.array(found)


CLEAR = 1.05
"""Distance of segments that are moved apart, in diameters of the thread."""
ROUNDS = 100
"""Most rounds in which segments are moved apart. (Samples of 6500 grains take 10.)"""


def _moved_apart(chains: list[np.ndarray], radius: float, box: np.ndarray) -> list[np.ndarray]:
    """Move segments of threads that cross each other apart, by some radii. Between two beads of a wire there is room for a
    bead of another turn, which keeps its distance from both, and the smooth threads through them meet there."""
    from scipy.spatial import cKDTree  # slow to import

    nodes, parts = np.vstack(chains), np.cumsum([len(chain) for chain in chains])[:-1]
    first = np.setdiff1d(np.arange(len(nodes) - 1), parts - 1)  # of each segment
    longest = float(np.linalg.norm(nodes[first + 1] - nodes[first], axis=1).max())
    for _ in range(ROUNDS):
        start, way = nodes[first], nodes[first + 1] - nodes[first]
        pairs = cKDTree(start + 0.5 * way).query_pairs(longest + 2.0 * CLEAR * radius, output_type="ndarray")
        i, j = pairs[np.abs(first[pairs[:, 0]] - first[pairs[:, 1]]) > 1].T
        between = _between(start[i], way[i], start[j], way[j])
        distance = np.linalg.norm(between, axis=1)
        near = distance < 2.0 * radius
        if not near.any():
            break
        i, j, between, distance = i[near], j[near], between[near], distance[near, None]
        across = np.cross(way[i], way[j])  # of segments that meet in a point
        normal = np.where(distance > 1e-3 * radius, between, across)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        move = (CLEAR * radius - 0.5 * distance) * normal
        for end in (0, 1):
            np.add.at(nodes, first[i] + end, move)
            np.add.at(nodes, first[j] + end, -move)
        nodes = np.clip(nodes, radius, box - radius)
    return np.split(nodes, parts)


def _between(a: np.ndarray, along_a: np.ndarray, b: np.ndarray, along_b: np.ndarray) -> np.ndarray:
    """Shortest vectors from the second segments to the first (k, 3), each given by its start and the way to its end: the
    nearest point of one to the other in turn, which converges for straight segments."""
    on_a = 0.5 * np.ones((len(a), 1))
    for _ in range(50):
        p = a + on_a * along_a
        on_b = np.clip(((p - b) * along_b).sum(axis=1) / (along_b**2).sum(axis=1), 0.0, 1.0)[:, None]
        q = b + on_b * along_b
        on_a = np.clip(((q - a) * along_a).sum(axis=1) / (along_a**2).sum(axis=1), 0.0, 1.0)[:, None]
    return a + on_a * along_a - q


def along(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Points on the segments between nodes, at most ``spacing`` apart, (k, 3)."""
    parts = [nodes[-1:]]
    for start, end in pairwise(nodes):
        share = np.arange(0.0, 1.0, spacing / np.linalg.norm(end - start))
        parts.append(start + share[:, None] * (end - start))
    return np.vstack(parts)
