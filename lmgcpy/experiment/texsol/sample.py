"""TexSol samples: wires are laid, grains are deposited around them; the relaxation follows.

In 2D a wire lies in random orientation (paper, section 3), in 3D wires lie in layers (section 4).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.errors import flag, named_arguments, number, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.thread_course import along, thread_nodes
from lmgcpy.sample import deposit, grading, wire_2d, wire_3d
from lmgcpy.sample.wire_3d import BEAD_TO_GRAIN

SOLID_FRACTION_2D = 0.79
"""Solid fraction of a deposit around a wire; it sizes the box so that the sample comes out about square."""
SOLID_FRACTION_3D = 0.555
"""Solid fraction of a deposit in its box, walls included; it sizes the box so that samples come out as high as planned."""
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
    slenderness: float = 1.0,
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
    ``bead_count``: number of beads of all ``wires`` together, which lie side by side. ``slenderness``: height of the sample
    over its width. ``theta_max`` [rad]: greatest turn from bead to bead within the layer.

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
    number(slenderness, "slenderness", minimum=0.1, maximum=10.0)
    side = float(np.cbrt(4.0 / 3.0 * np.pi * np.sum(radii**3) / (SOLID_FRACTION_3D * slenderness)))
    below_top = slenderness * side - 2.0 * maximum
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
        box=(side, side, below_top),
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
        apart, inside = node_distance * 2.0 * float(np.mean(radii)), (side, side, below_top)
        chains, gap = thread_nodes(chains, spacing=link, node_distance=apart, radius=bead_radius, box=inside)
        obstacles = np.vstack([along(nodes, bead_radius) for nodes in chains])
    grains = deposit(radii, box=(side, side, None), obstacles=(obstacles, np.full(len(obstacles), bead_radius)), seed=seed)
    nodes = np.vstack(chains)
    positions, sizes = np.vstack([nodes, grains]), np.concatenate([np.full(len(nodes), bead_radius), radii])
    each = tuple(map(len, chains))
    return Sample(positions, sizes, each, gap, _box(positions, sizes, side), bead_mass=mean_mass, thread=thread)


def _box(positions: np.ndarray, radii: np.ndarray, side: float) -> np.ndarray:
    """Sizes of a box of this side that reaches to the top of the highest particle [m], (d,)."""
    dimension = positions.shape[1]
    return np.array([*[side] * (dimension - 1), float((positions[:, -1] + radii).max())])
