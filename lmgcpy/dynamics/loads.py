"""Loads on many bodies at once: forces by arrays, and the pressure on a surface between bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lmgcpy.contact.features import places_of
from lmgcpy.contact.lattice import Lattice, crossing
from lmgcpy.errors import number, numbers, shown


@dataclass(frozen=True)
class ManyForces:
    """Forces on some bodies [N]: an array (m, d), or a function of time [s] that gives it."""

    bodies: np.ndarray
    """Rows of the bodies, (m,)."""
    value: np.ndarray | Callable[[float], Any]

    def add_to(self, force: np.ndarray, positions: np.ndarray, time: float) -> None:
        """Add the forces at a time to those of all bodies (n, k)."""
        d = positions.shape[1]
        checked = partial(forces, count=len(self.bodies), dimension=d)
        given = at_time(self.value, time, f"of time imposed as forces at t = {time:g} s", checked)
        np.add.at(force[:, :d], self.bodies, given)


@dataclass(frozen=True)
class Pressure:
    """A pressure on one side of a surface, the side to which the normals of its cells point [Pa], in 2D [N/m]: a number or
    a function of time [s].

    The area vector of a triangle, half the product of two of its edges, is shared by its corners in three equal parts; in
    2D the two ends of a segment share its length along the normal to the left of its direction. With V the volume, or the
    area, behind the surface these are the derivatives of V by the positions of the nodes, exactly, so that the pressure
    does the work ``-p dV`` and gives a closed surface neither momentum nor angular momentum.
    """

    cells: np.ndarray
    """Rows of the bodies at the corners, (m, d)."""
    value: float | Callable[[float], float]
    lattice: Lattice | None = None
    """The lattice of a periodic cell, in which cells lie between nearest images."""

    def add_to(self, force: np.ndarray, positions: np.ndarray, time: float) -> None:
        """Add the forces at a time, for bodies at ``positions`` (n, d), to those of all bodies (n, k)."""
        d = positions.shape[1]
        pressure = at_time(self.value, time, f"of time imposed as a pressure at t = {time:g} s", number)
        share = -pressure / d * area_vectors(places_of(positions, self.cells, crossing(self.lattice, positions)))
        for corner in self.cells.T:
            np.add.at(force[:, :d], corner, share)


def area_vectors(corners: np.ndarray) -> np.ndarray:
    """Area vectors of triangles (m, 3, 3) by the right-hand rule, or in 2D of segments (m, 2, 2) to the left of their
    direction, (m, d)."""
    way = corners[:, 1:] - corners[:, :1]
    if corners.shape[2] == 2:
        return np.column_stack([-way[:, 0, 1], way[:, 0, 0]])
    return 0.5 * np.cross(way[:, 0], way[:, 1])


def forces(value: Any, name: str, count: int, dimension: int) -> np.ndarray:
    """Forces on so many bodies [N], (count, d); one row is for all of them."""
    given = numbers(value, name, f"an array ({count}, {dimension}) [N]")
    if given.shape not in ((count, dimension), (dimension,)):
        shape = f"({count}, {dimension}) [N], or ({dimension},) for all"
        raise ValueError(f"{name} must be of shape {shape}, got {given.shape}.")
    return np.broadcast_to(given, (count, dimension))


def at_time(value: Any, time: float, which: str, checked: Callable[[Any, str], Any]) -> Any:
    """A value, or the answer of a function of time, ``which`` names it in sentences: RuntimeError if the function fails,
    TypeError or FloatingPointError if it is not what ``checked`` lets through."""
    if not callable(value):
        return value
    try:
        given = value(time)
    except Exception as error:
        raise RuntimeError(f"The function {which} failed with {shown(error)}: mend it.") from error
    try:
        return checked(given, f"What is {which.removeprefix('of time ')}")
    except ValueError as error:
        raise FloatingPointError(str(error)) from error
