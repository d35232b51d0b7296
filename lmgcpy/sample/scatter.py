"""Grains at random in a periodic cell: a loose, even start for compactions without walls."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy import errors
from lmgcpy.sample import arguments

TRIES = 2000
"""Places that are tried for a grain before the cell is called full."""


@errors.named_arguments
def scatter(radii: Any, *, cell: Any, seed: Any = 0) -> np.ndarray:
    """Positions [m] of grains that do not overlap in a periodic ``cell``, shape (n, d) in the order of the radii.

    Random sequential addition: the coarsest grain first, each at the first free one of places drawn evenly in the cell. No
    place and no direction is preferred. It fills at most some 0.5 of a cell in 2D and 0.35 in 3D.

    ``radii`` [m], shape (n,); ``cell``: its lengths (Lx, Ly) or (Lx, Ly, Lz) [m], from the origin. ``seed``: whatever
    ``numpy.random.default_rng`` takes. Raises ValueError where a grain finds no place.
    """
    sizes = arguments.radii(radii)
    lengths = np.array(arguments.box(cell, open_top=False))
    rng = arguments.generator(seed)
    if 4.0 * float(sizes.max()) > float(lengths.min()):
        raise ValueError(
            f"the cell is too narrow: a length is {lengths.min():g} m, and twice the coarsest diameter is "
            f"{4.0 * sizes.max():g} m. Take a larger cell or smaller radii."
        )
    positions = np.empty((len(sizes), len(lengths)))
    order = np.argsort(-sizes, kind="stable")
    for count, grain in enumerate(order):
        placed = order[:count]
        near = (sizes[placed] + sizes[grain]) ** 2
        for _ in range(TRIES):
            place = rng.random(len(lengths)) * lengths
            apart = positions[placed] - place
            apart -= lengths * np.rint(apart / lengths)
            if (np.einsum("pd,pd->p", apart, apart) >= near).all():
                break
        else:
            raise ValueError(
                f"no place was found for {len(sizes) - count} of {len(sizes)} grains: take a larger cell, with at most "
                "0.45 of it solid in 2D and 0.3 in 3D."
            )
        positions[grain] = place
    return positions
