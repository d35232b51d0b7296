"""A TexSol sample in 2D (paper, section 3): the wire in random orientation, grains deposited around it, relaxation."""

from __future__ import annotations

import numpy as np

from lmgcpy.errors import named_arguments, number, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.sample import deposit, grading, wire_2d

SOLID_FRACTION = 0.79
"""Of a deposit around a wire; it sizes the box so that the sample comes out about square."""


@named_arguments
def lay_sample(
    grain_count: int = 1700,
    bead_count: int = 300,
    *,
    minimum: float = 0.005,
    maximum: float = 0.010,
    seed: int = 0,
    method: str = "geometric",
) -> Sample:
    """Lay the wire and deposit the grains around it; not yet relaxed.

    Grain radii are uniform by diameter between ``minimum`` and ``maximum`` [m]. The beads have the mean radius of the
    grains, close to that of the sand so that the chain makes no membrane, and the reference gap is 5 % wider than the
    coarsest grain, so that every grain passes between two beads of a taut wire. The wire is laid with gaps as wide as
    the coarsest grain, 3 % slack: laid taut it would be tense in all directions after relaxation. ``method``: of the
    deposit, see :func:`lmgcpy.sample.deposit`.
    """
    whole(grain_count, "grains", minimum=10)
    whole(bead_count, "beads", minimum=0)
    if bead_count == 1:
        raise ValueError("beads must be 0 (sand alone) or at least 2: one bead is no wire.")
    number(minimum, "minimum radius", above=0.0, unit="m")
    radii = grading(grain_count, minimum=minimum, maximum=maximum, by="diameter", seed=seed)
    bead_radius = 0.5 * (minimum + maximum)
    laid_gap = 2.0 * maximum
    gap = 1.05 * laid_gap
    area = np.pi * (float(np.sum(radii**2)) + bead_count * bead_radius**2)
    side = float(np.sqrt(area / SOLID_FRACTION))
    if bead_count == 0:
        positions = deposit(radii, box=(side, None), method=method, seed=seed)
        return _in_box(positions, radii, 0, gap, side)
    # the wire stays below the surface of the deposit
    wire = wire_2d(
        box=(side, side - 2.0 * maximum), bead_radius=bead_radius, interstice=laid_gap, bead_count=bead_count, seed=seed
    )
    if wire.cut:
        raise ValueError(
            f"No place was found for a wire of {bead_count} beads among {grain_count} grains, only for {wire.bead_count}: "
            "take fewer beads, more grains or another seed."
        )
    grains = deposit(radii, box=(side, None), obstacles=(wire.positions, wire.radii), method=method, seed=seed)
    return _in_box(np.vstack([wire.positions, grains]), np.concatenate([wire.radii, radii]), bead_count, gap, side)


def _in_box(positions: np.ndarray, radii: np.ndarray, bead_count: int, gap: float, width: float) -> Sample:
    height = float((positions[:, 1] + radii).max())
    return Sample(positions, radii, (bead_count,) if bead_count else (), gap, np.array([width, height]))
