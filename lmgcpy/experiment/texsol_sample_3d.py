"""A TexSol sample in 3D (paper, section 4): wires laid layer by layer, grains deposited around them."""

from __future__ import annotations

import numpy as np

from lmgcpy.errors import named_arguments, number, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.sample import deposit, grading, wire_3d
from lmgcpy.sample.wire_3d import BEAD_TO_GRAIN

SOLID_FRACTION = 0.555
"""Of a deposit in its box, walls included; it sizes the box so that the sample comes out about cubic."""
THETA_MAX, PHI_MAX = 0.1, 0.05
"""Random turns from bead to bead [rad] in the layer and out of it: a thread that is straight over some grains."""


@named_arguments
def lay_sample_3d(
    grain_count: int = 6500,
    bead_count: int = 3500,
    *,
    wires: int = 1,
    minimum: float = 0.4e-3,
    maximum: float = 0.6e-3,
    density: float = 2600.0,
    seed: int = 0,
) -> Sample:
    """Lay the wires from below upward and deposit the grains around them; not yet compacted.

    Grain radii are uniform by diameter between ``minimum`` and ``maximum`` [m]. A bead is 20 % as large as the smallest
    grain (paper, section 4) and the interstice as wide as a bead: no grain passes between two beads. A bead weighs as
    much as a mean grain of ``density`` [kg/m^3]: in tests as slow as these inertia plays no part, but beads of their own
    mass, a hundredth of a grain's, hand on so little momentum in a sweep that the solver does not come to an end.
    ``bead_count`` is that of all ``wires`` together, which lie side by side.
    """
    whole(grain_count, "grains", minimum=10)
    whole(wires, "wires", minimum=1)
    whole(bead_count, "beads", minimum=0)
    if bead_count and bead_count < 2 * wires:
        raise ValueError(f"beads must be 0 (sand alone) or at least 2 for each wire, got {bead_count} for {wires}.")
    number(minimum, "minimum radius", above=0.0, unit="m")
    radii = grading(grain_count, minimum=minimum, maximum=maximum, by="diameter", seed=seed)
    mean_mass = number(density, "density", above=0.0, unit="kg/m^3") * 4.0 / 3.0 * np.pi * float(np.mean(radii**3))
    side = float(np.cbrt(4.0 / 3.0 * np.pi * np.sum(radii**3) / SOLID_FRACTION))
    bead_radius = BEAD_TO_GRAIN * float(minimum)
    gap = 2.0 * bead_radius
    if bead_count == 0:
        positions = deposit(radii, box=(side, side, None), seed=seed)
        return Sample(positions, radii, (), gap, _box(positions, radii, side))
    # the wires stay below the surface of the deposit
    thread = wire_3d(
        box=(side, side, side - 2.0 * maximum),
        bead_radius=bead_radius,
        interstice=gap,
        bead_count=bead_count // wires,
        theta_max=THETA_MAX,
        phi_max=PHI_MAX,
        wires=wires,
        seed=seed,
    )
    if thread.cut:
        raise ValueError(
            f"No place was found for {bead_count} beads of wire among {grain_count} grains, only for {thread.bead_count}: "
            "take fewer beads, more grains or another seed."
        )
    grains = deposit(radii, box=(side, side, None), obstacles=(thread.positions, thread.radii), seed=seed)
    positions, sizes = np.vstack([thread.positions, grains]), np.concatenate([thread.radii, radii])
    each = tuple(len(chain) for chain in thread.chains)
    return Sample(positions, sizes, each, gap, _box(positions, sizes, side), bead_mass=mean_mass)


def _box(positions: np.ndarray, radii: np.ndarray, side: float) -> np.ndarray:
    return np.array([side, side, float((positions[:, 2] + radii).max())])
