"""TexSol samples: wires are laid, grains are deposited around them; the relaxation follows.

In 2D a wire lies in random orientation (paper, section 3), in 3D wires lie in layers (section 4).
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from lmgcpy.errors import flag, named_arguments, number, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.sample import deposit, grading, wire_2d, wire_3d
from lmgcpy.sample.wire_3d import BEAD_TO_GRAIN

SOLID_FRACTION_2D = 0.79
"""Solid fraction of a deposit around a wire; it sizes the box so that the sample comes out about square."""
SOLID_FRACTION_3D = 0.555
"""Solid fraction of a deposit in its box, walls included; it sizes the box so that the sample comes out about cubic."""
THETA_MAX_2D = 2.0
"""Greatest turn from bead to bead in 2D [rad], for a "random orientation state" (paper, section 3).

A wire has a random orientation on lengths beyond its persistence length. Of 40 wires of 300 beads each, with turns up to
0.6, 1.2, 2.0 and 2.6 rad, it is 0.59, 0.28, 0.14 and 0.11 of the sample's width; |mean exp(2 i theta)|^2 over the links in
a sixteenth of the sample is 3.5, 2.2, 1.7 and 1.7 times its value for independent links; the variance of the numbers of
beads in the sixteenths is 0.86, 0.57, 0.51 and 0.60 of their mean. With 2.0 the wire is the most even of all, and not
twisted more than necessary."""
THETA_MAX_3D, PHI_MAX = 0.1, 0.05
"""Random turns from bead to bead in 3D [rad] in the layer and out of it: a thread that is straight over some grains."""


@named_arguments
def lay_sample(
    grain_count: int = 1700,
    bead_count: int = 300,
    *,
    minimum: float = 0.005,
    maximum: float = 0.010,
    theta_max: float = THETA_MAX_2D,
    seed: int = 0,
    method: str = "geometric",
) -> Sample:
    """Lay the wire and deposit the grains around it; not yet relaxed.

    Grain radii are uniform by diameter between ``minimum`` and ``maximum`` [m]. The beads have the mean radius of the
    grains, so that the chain makes no membrane, and the reference gap is 5 % wider than the coarsest grain, so that every
    grain passes between two beads of a taut wire. The wire is laid with gaps as wide as the coarsest grain, 3 % slack:
    laid taut it would be tense in all directions after relaxation. ``theta_max`` [rad] as in
    :func:`lmgcpy.sample.wire_2d`, ``method`` as in :func:`lmgcpy.sample.deposit`.
    """
    whole(grain_count, "grains", minimum=10)
    whole(bead_count, "beads", minimum=0)
    if bead_count == 1:
        raise ValueError("beads must be 0 (sand alone) or at least 2: one bead is no wire.")
    number(minimum, "minimum radius", above=0.0, unit="m")
    number(theta_max, "theta_max", minimum=0.0, maximum=np.pi, unit="rad")
    radii = grading(grain_count, minimum=minimum, maximum=maximum, by="diameter", seed=seed)
    bead_radius = 0.5 * (minimum + maximum)
    laid_gap = 2.0 * maximum
    gap = 1.05 * laid_gap
    area = np.pi * (float(np.sum(radii**2)) + bead_count * bead_radius**2)
    side = float(np.sqrt(area / SOLID_FRACTION_2D))
    if bead_count == 0:
        positions = deposit(radii, box=(side, None), method=method, seed=seed)
        return Sample(positions, radii, (), gap, _box(positions, radii, side))
    # the wire stays below the surface of the deposit
    wire = wire_2d(
        box=(side, side - 2.0 * maximum),
        bead_radius=bead_radius,
        interstice=laid_gap,
        bead_count=bead_count,
        theta_max=theta_max,
        seed=seed,
    )
    if wire.cut:
        raise ValueError(
            f"No place was found for a wire of {bead_count} beads among {grain_count} grains, only for {wire.bead_count}: "
            "take fewer beads, more grains or another seed."
        )
    grains = deposit(radii, box=(side, None), obstacles=(wire.positions, wire.radii), method=method, seed=seed)
    positions, sizes = np.vstack([wire.positions, grains]), np.concatenate([wire.radii, radii])
    return Sample(positions, sizes, (bead_count,), gap, _box(positions, sizes, side))


@named_arguments
def lay_sample_3d(
    grain_count: int = 6500,
    bead_count: int = 3500,
    *,
    wires: int = 1,
    minimum: float = 0.4e-3,
    maximum: float = 0.6e-3,
    theta_max: float = THETA_MAX_3D,
    density: float = 2600.0,
    seed: int = 0,
    thread: bool = False,
    thread_diameter: float | None = None,
    node_distance: float = 0.7,
) -> Sample:
    """Lay the wires from below upward and deposit the grains around them; not yet compacted.

    Grain radii are uniform by diameter between ``minimum`` and ``maximum`` [m]. A bead is 20 % as large as the smallest
    grain (paper, section 4) and the interstice as wide as a bead: no grain passes between two beads. A bead weighs as
    much as a mean grain of ``density`` [kg/m^3], as inertia plays no part in tests as slow as these.
    ``bead_count``: number of beads of all ``wires`` together, which lie side by side. ``theta_max`` [rad]: greatest turn
    from bead to bead within the layer.

    With ``thread`` the wires are smooth, see :class:`lmgcpy.Thread`, of ``thread_diameter`` [m], by default as thick as
    beads. They are as long, and follow the beads: every second or third is a node, so that nodes are ``node_distance`` mean
    diameters of a grain apart at the most, and closer at sharp turns; other beads are left out. Straight
    segments do not follow the pores: tensions grow with their length (docs/texsol_3d.md).
    """
    whole(grain_count, "grains", minimum=10)
    whole(wires, "wires", minimum=1)
    whole(bead_count, "beads", minimum=0)
    if bead_count and bead_count < 2 * wires:
        raise ValueError(f"beads must be 0 (sand alone) or at least 2 for each wire, got {bead_count} for {wires}.")
    number(minimum, "minimum radius", above=0.0, unit="m")
    number(theta_max, "theta_max", minimum=0.0, maximum=np.pi, unit="rad")
    radii = grading(grain_count, minimum=minimum, maximum=maximum, by="diameter", seed=seed)
    mean_mass = number(density, "density", above=0.0, unit="kg/m^3") * 4.0 / 3.0 * np.pi * float(np.mean(radii**3))
    side = float(np.cbrt(4.0 / 3.0 * np.pi * np.sum(radii**3) / SOLID_FRACTION_3D))
    bead_radius = BEAD_TO_GRAIN * float(minimum)
    link = 4.0 * bead_radius
    number(node_distance, "node_distance", above=0.0)
    flag(thread, "thread")
    if thread_diameter is not None:
        if not thread:
            raise ValueError("thread_diameter is of a smooth thread: give thread=True, or leave it out for beads.")
        bead_radius = 0.5 * number(thread_diameter, "thread_diameter", above=0.0, maximum=0.99 * link, unit="m")
    gap: Any = link - 2.0 * bead_radius
    if bead_count == 0:
        positions = deposit(radii, box=(side, side, None), seed=seed)
        return Sample(positions, radii, (), gap, _box(positions, radii, side))
    # the wires stay below the surface of the deposit
    laid = wire_3d(
        box=(side, side, side - 2.0 * maximum),
        bead_radius=bead_radius,
        interstice=gap,
        bead_count=bead_count // wires,
        theta_max=theta_max,
        phi_max=PHI_MAX,
        wires=wires,
        seed=seed,
    )
    if laid.cut:
        raise ValueError(
            f"No place was found for {bead_count} beads of wire among {grain_count} grains, only for {laid.bead_count}: "
            "take fewer beads, more grains or another seed."
        )
    chains = [laid.positions[chain] for chain in laid.chains]
    obstacles = laid.positions
    if thread:
        diameter = 2.0 * float(np.mean(radii))
        every = max(1, int(node_distance * diameter / link + 1e-9))
        chosen = [_nodes(beads, link, every) for beads in chains]
        chains = [beads[nodes] for beads, nodes in zip(chains, chosen, strict=True)]
        gap = link * np.concatenate([np.diff(nodes) for nodes in chosen])
        chains = _apart(chains, bead_radius, np.array([side, side, side - 2.0 * maximum]))
        obstacles = np.vstack([_along(nodes, bead_radius) for nodes in chains])
    grains = deposit(radii, box=(side, side, None), obstacles=(obstacles, np.full(len(obstacles), bead_radius)), seed=seed)
    nodes = np.vstack(chains)
    positions, sizes = np.vstack([nodes, grains]), np.concatenate([np.full(len(nodes), bead_radius), radii])
    each = tuple(map(len, chains))
    return Sample(positions, sizes, each, gap, _box(positions, sizes, side), bead_mass=mean_mass, thread=thread)


STRAIGHT = 0.95
"""Least distance of the ends of a segment of a thread over the length of the wire between them."""


def _nodes(beads: np.ndarray, link: float, every: int) -> np.ndarray:
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


def _apart(chains: list[np.ndarray], radius: float, box: np.ndarray) -> list[np.ndarray]:
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


def _along(nodes: np.ndarray, spacing: float) -> np.ndarray:
    """Points on the segments between nodes, at most ``spacing`` apart, (k, 3)."""
    parts = [nodes[-1:]]
    for start, end in pairwise(nodes):
        share = np.arange(0.0, 1.0, spacing / np.linalg.norm(end - start))
        parts.append(start + share[:, None] * (end - start))
    return np.vstack(parts)


def _box(positions: np.ndarray, radii: np.ndarray, side: float) -> np.ndarray:
    """Sizes of a box of this side that reaches to the top of the highest particle [m], (d,)."""
    dimension = positions.shape[1]
    return np.array([*[side] * (dimension - 1), float((positions[:, -1] + radii).max())])
