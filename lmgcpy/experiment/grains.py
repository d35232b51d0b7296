"""Loose samples of spheres or clumps, with or without fibres, at random places in a box; a compaction follows."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.sample import fibres, grading
from lmgcpy.sample.arguments import generator
from lmgcpy.scene.body import Body
from lmgcpy.scene.body_3d import capsule_volume
from lmgcpy.scene.clump import Clump
from lmgcpy.scene.solid import Material

LOOSE = 0.3
"""Part of the box that the grains fill, clumps with the spheres around them, without fibres."""
ROOM = 1.5
"""Volume of the box for each fibre, over the volume around it in which no centre of a mean grain can lie."""


@named_arguments
def lay_grains(
    grain_count: int = 400,
    *,
    minimum: float = 0.4e-3,
    maximum: float = 0.6e-3,
    shape: Clump | None = None,
    content: float = 0.0,
    fibre_radius: float = 0.1e-3,
    fibre_length: float = 5e-3,
    orientation: Any = "random",
    spread: float | None = None,
    segments: int = 1,
    density: float = 2600.0,
    seed: Any = 0,
) -> Sample:
    """Lay fibres and grains among them at random places in a cubic box; not yet compacted.

    Grain radii are uniform by diameter between ``minimum`` and ``maximum`` [m]. With a ``shape`` in 3D, which
    :func:`lmgcpy.clump` makes, the grains are clumps of it, each of the volume of the sphere in its place, in rotations
    uniform on SO(3). Clumps have the density of the shape, fibres ``density`` [kg/m^3].

    ``content``: volume of the fibres over that of the grains; ``fibre_radius``, ``fibre_length`` [m], ``orientation`` and
    ``spread`` as ``radius``, ``length`` and so on in :func:`lmgcpy.sample.fibres`. Fibres of one of the ``segments`` are
    rigid; with more they are chains of capsules on ball joints, which bend freely.

    >>> from lmgcpy.experiment import lay_grains
    >>> lay_grains(100, content=0.02, fibre_length=2e-3)
    <Sample in 3D: 115 particles, 15 of them fibres, in a box of 0.00664 x 0.00664 x 0.00664 m>
    """
    whole(grain_count, "grains", minimum=10)
    if shape is not None and (not isinstance(shape, Clump) or shape.dimension != 3):
        raise TypeError(f"shape of the grains must be a clump in 3D that lmgcpy.clump made, or None, got {shown(shape)}.")
    content = number(content, "content", minimum=0.0, maximum=1.0)
    radius = number(fibre_radius, "fibre_radius", above=0.0, unit="m")
    length = number(fibre_length, "fibre_length", above=0.0, unit="m")
    fibre, rng = Material("fibre", density=density), generator(seed)
    radii = grading(grain_count, minimum=minimum, maximum=maximum, by="diameter", dimension=3, seed=rng)
    solid = 4.0 / 3.0 * np.pi * float(np.sum(radii**3))
    scales = radii if shape is None else radii * np.cbrt(4.0 / 3.0 * np.pi / shape.volume)
    around = radii if shape is None else scales * shape.extent
    kept_out = np.pi * (radius + float(around.mean())) ** 2 * length
    volume = 4.0 / 3.0 * np.pi * float(np.sum(around**3)) / LOOSE
    volume += ROOM * kept_out * content * solid / capsule_volume(radius, length)
    side = max(float(np.cbrt(volume)), 1.001 * (length + 2.0 * radius) if content > 0.0 else 0.0)
    laid = fibres(
        around,
        content=content,
        radius=radius,
        length=length,
        box=(side, side, side),
        orientation=orientation,
        spread=spread,
        grain_volume=solid,
        seed=rng,
    )
    bodies: list[Body] = list(laid.capsules(fibre, segments=segments))
    if shape is None:
        return Sample(laid.grains, radii, (), 0.0, np.full(3, side), bodies=bodies, segments=segments)
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    turns = Rotation.random(grain_count, rng)
    clumps = [shape.at(x, rotation=q, scale=s) for x, q, s in zip(laid.grains, turns, scales, strict=True)]
    return Sample(np.empty((0, 3)), np.empty(0), (), 0.0, np.full(3, side), bodies=[*clumps, *bodies], segments=segments)
