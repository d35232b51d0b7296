"""Grains without contact, for a simulation to start from: on a loose grid in a box, or at random in a periodic cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy import errors
from lmgcpy.sample import arguments

TRIES = 2000
"""Places that are tried for a grain before the cell is called full."""


@errors.named_arguments
def grid_positions(
    radii: Any,
    *,
    box: Any,
    obstacles: Any = None,
    spacing: float = 1.05,
    order: str = "random",
    seed: Any = 0,
) -> np.ndarray:
    """Positions [m], shape (n, d), of grains without overlap, one to a cell of a grid, layer upon layer from the floor.

    The cells are ``spacing`` coarsest diameters wide, or a little more so that whole cells fill the box; a cell that an
    obstacle reaches into stays empty. Within its cell a grain lies at random, so that it does not fall straight onto
    the one below. The positions are in the order of ``radii`` [m]; ``order``: whether the cells are filled at "random" or
    as "given".

    ``box``: lengths [m] from the origin, 2D or 3D, the last may be ``None``, an open top. ``obstacles``: pair
    (positions, radii) [m] or ``None``. ``seed``: whatever ``numpy.random.default_rng`` takes.

    Raises ValueError if the grains do not fit, with the number that did, and ValueError or TypeError if an argument makes
    no sense.
    """
    sizes = arguments.radii(radii)
    lengths = arguments.box(box)
    dimension = len(lengths)
    centres, obstacle_radii = arguments.obstacles(obstacles, dimension)
    spacing = errors.number(spacing, "spacing", minimum=1.0)
    order = errors.one_of(order, "order", ("random", "given"))
    coarsest = float(sizes.max())
    arguments.refuse_unfit(lengths, coarsest, "the coarsest grain")
    pitch = 2.0 * coarsest * spacing
    base = np.array(lengths[:-1])
    # 1e-9: a box of exactly five diameters has five cells
    counts = np.maximum(1, np.floor(base / pitch + 1e-9).astype(int))
    cell = np.append(base / counts, pitch)
    layer = np.stack(np.meshgrid(*(np.arange(count) + 0.5 for count in counts), indexing="ij"), axis=-1)
    layer = layer.reshape(-1, dimension - 1) * cell[:-1]
    half = 0.5 * cell
    rng = arguments.generator(seed)
    sequence = rng.permutation(len(sizes)) if order == "random" else np.arange(len(sizes))
    positions = np.empty((len(sizes), dimension))
    placed, level = 0, 0
    while placed < len(sizes):
        height = (level + 0.5) * pitch
        if height + 0.5 * pitch > lengths[-1] * (1.0 + 1e-12):
            raise ValueError(
                f"the box is full: {placed} of {len(sizes)} grains fitted on a grid under its height of "
                f"{lengths[-1]:g} m. Take fewer grains, a higher box, or None for an open top."
            )
        middles = np.column_stack((layer, np.full(len(layer), height)))
        near = np.abs(centres[:, -1] - height) < obstacle_radii + half[-1]
        free = _free_cells(middles, half, centres[near], obstacle_radii[near])
        chosen = sequence[placed : placed + len(free)]
        play = np.maximum(half - sizes[chosen, None], 0.0)
        positions[chosen] = middles[free[: len(chosen)]] + rng.uniform(-1.0, 1.0, play.shape) * play
        placed += len(chosen)
        level += 1
    return positions


def _free_cells(
    middles: np.ndarray, half: np.ndarray, obstacle_positions: np.ndarray, obstacle_radii: np.ndarray
) -> np.ndarray:
    """Rows of ``middles`` whose box of half lengths ``half`` no obstacle reaches into."""
    free = np.ones(len(middles), dtype=bool)
    for position, radius in zip(obstacle_positions, obstacle_radii, strict=True):
        beyond = np.maximum(np.abs(middles - position) - half, 0.0)
        free &= (beyond**2).sum(axis=1) >= radius**2
    return np.flatnonzero(free)


@errors.named_arguments
def scatter(radii: Any, *, cell: Any, seed: Any = 0) -> np.ndarray:
    """Positions [m] of grains that do not overlap in a periodic ``cell``, shape (n, d) in the order of the radii.

    Random sequential addition: the coarsest grain first, each at the first free one of places drawn evenly in the cell. No
    place and no direction is preferred. It fills at most some 0.5 of a cell in 2D and 0.35 in 3D.

    ``radii`` [m], shape (n,); ``cell``: its lengths (Lx, Ly) or (Lx, Ly, Lz) [m], from the origin. ``seed``: whatever
    ``numpy.random.default_rng`` takes. Raises ValueError where a grain finds no place.
    """
    sizes = arguments.radii(radii)
    lengths = np.array(arguments.box(cell, open_top=False, name="cell"))
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
