"""Checks of the arguments of samples. Each error is a sentence: what is wrong, where, and what to do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lmgcpy import errors
from lmgcpy.errors import AXES

WIDEST = 1e7
"""Largest number of coarsest bodies side by side on the floor of a box."""


def generator(seed: Any) -> np.random.Generator:
    """Random generator from a seed: a whole number, None, or a generator."""
    try:
        return np.random.default_rng(seed)
    except (TypeError, ValueError) as error:
        raise type(error)(f"seed must be a whole number of at least 0, or None, got {errors.shown(seed)}.") from error


def radii(values: Any, name: str = "radii", least: int = 1) -> np.ndarray:
    """Check radii [m], shape (n,): all are above zero."""
    array = errors.numbers(values, name)
    if array.ndim != 1:
        raise ValueError(f"{name} must have shape (n,), got {array.shape}.")
    if len(array) < least:
        raise ValueError(f"{name} must hold at least {least} value, got {len(array)}.")
    if (array <= 0.0).any():
        where = int(np.argmax(array <= 0.0))
        raise ValueError(f"{name} must be above zero, but number {where} is {array[where]:g} m.")
    return array


def spheres(positions: Any, sizes: Any, dimension: int, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Check positions [m], shape (n, dimension), and as many radii [m]."""
    centres = errors.numbers(positions, f"the positions of {name}")
    if centres.size == 0:
        centres = centres.reshape(0, dimension)
    if centres.ndim != 2 or centres.shape[1] != dimension:
        raise ValueError(f"the positions of {name} must have shape (n, {dimension}), got {centres.shape}.")
    lengths = radii(sizes, f"the radii of {name}", least=0)
    if len(lengths) != len(centres):
        raise ValueError(f"{name}: there are {len(centres)} positions and {len(lengths)} radii; give one radius each.")
    return centres, lengths


def obstacles(value: Any, dimension: int) -> tuple[np.ndarray, np.ndarray]:
    """Check the pair (positions, radii) of obstacles; ``None`` means no obstacle."""
    if value is None:
        return np.empty((0, dimension)), np.empty(0)
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        raise TypeError(
            "obstacles must be a pair (positions, radii), such as (wire.positions, wire.radii), or None; "
            f"got {errors.shown(value)}."
        )
    return spheres(value[0], value[1], dimension, "the obstacles")


def box(
    value: Any, *, dimensions: Sequence[int] = (2, 3), open_top: bool = True, name: str = "box"
) -> tuple[float, ...]:
    """Check the lengths of a box of this ``name`` that starts at the origin [m]; the last one is infinite if ``None`` was
    given."""
    kinds = " or ".join(str(dimension) for dimension in dimensions)
    if not isinstance(value, (tuple, list, np.ndarray)) or getattr(value, "shape", None) == ():
        raise TypeError(f"{name} must be a tuple of {kinds} lengths [m], got {errors.shown(value)}.")
    if len(value) not in dimensions:
        raise ValueError(f"{name} must have {kinds} lengths [m], got {len(value)}.")
    lengths = []
    for axis, length in enumerate(value):
        top = axis == len(value) - 1
        if length is None and top and open_top:
            lengths.append(math.inf)
        elif length is None:
            reason = "only the last length, the height, may be None" if open_top else "this box must be closed"
            raise ValueError(f"the length of {name} along {AXES[axis]} is None: {reason}; give a length [m].")
        else:
            lengths.append(errors.number(length, f"the length of {name} along {AXES[axis]}", above=0.0, unit="m"))
    return tuple(lengths)


def refuse_unfit(lengths: tuple[float, ...], coarsest: float, what: str, *, widest: float = WIDEST) -> None:
    """Refuse a box that is narrower than the coarsest body, or so wide that it cannot be divided into cells of the body's
    size: more than ``widest`` bodies lie side by side on its floor.
    """
    for axis, length in enumerate(lengths):
        if length < 2.0 * coarsest * (1.0 - 1e-12):
            raise ValueError(
                f"the box is too narrow for {what}: its length along {AXES[axis]} is {length:g} m, the diameter is "
                f"{2.0 * coarsest:g} m. Widen the box or take smaller radii."
            )
    side_by_side = math.prod(length / (2.0 * coarsest) for length in lengths[:-1])
    if side_by_side > widest:
        raise ValueError(
            f"the box is too wide for {what}: {side_by_side:.1e} of them lie side by side; at most {widest:.0e} are "
            "possible. Are its lengths and the radii both in metres?"
        )
