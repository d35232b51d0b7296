"""Many disks or spheres made at once from arrays, and numbers of many bodies read at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple, TypeVar

import numpy as np

from lmgcpy.errors import LARGEST, number, numbers, shown
from lmgcpy.scene.body import INERTIA, MASS, NO_CONDITIONS, RADIUS, Body, Disk, Round, StartRows
from lmgcpy.scene.body_3d import Sphere
from lmgcpy.scene.solid import Material

SomeRound = TypeVar("SomeRound", bound=Round)
PLAIN = (Disk, Sphere)
"""Classes of which a row of numbers says all; a class derived from them may say otherwise."""


def make_round(
    kind: type[SomeRound],
    radii: Any,
    positions: Any,
    *,
    material: Material | None,
    color: str,
    velocities: Any,
    spins: Any,
    masses: Any,
    inertias: Any,
    rotations: np.ndarray | None = None,
) -> list[SomeRound]:
    """A body of a class for each of the ``positions``, the same to the last bit as the class itself would make it.

    Raises TypeError and ValueError with a sentence that names the argument and the first row that is wrong.
    """
    d, what = kind.dimension, f"add_{kind.noun}s"
    place = numbers(positions, f"positions of {what}", f"an array (n, {d}) [m]")
    if place.ndim != 2 or place.shape[1] != d:
        raise ValueError(f"positions of {what} must be of shape (n, {d}) [m], got {place.shape}.")
    count = len(place)
    turning = 1 if d == 2 else 3
    block = np.zeros((count, StartRows.WIDTH))
    block[:, :d] = place
    if rotations is not None:  # in 2D
        block[:, 2] = rotations
    first = 3  # of the velocities
    block[:, first : first + d] = of_each(velocities, f"velocities of {what}", (count, d), "m/s")
    spin = of_each(spins, f"spins of {what}", (count,) if d == 2 else (count, 3), "rad/s")
    block[:, first + d : first + d + turning] = spin.reshape(count, turning)
    radius = block[:, RADIUS] = _above_zero(radii, "radii", kind, count, "m")
    if material is not None and not isinstance(material, Material):
        raise TypeError(f"material of {what} must be a lmgcpy.Material, got {shown(material)}.")
    if masses is None:
        if material is None:
            raise TypeError(f"{what} needs a material= or masses= [kg].")
        # the class's own formulas, number by number: numpy's powers may differ from Python's in the last bit
        masses = [material.density * kind.volume(r) for r in radius.tolist()]
    mass = block[:, MASS] = _above_zero(masses, "masses", kind, count, "kg")
    if inertias is None:
        inertias = mass * np.array([kind.turning(r) for r in radius.tolist()])
    block[:, INERTIA] = _above_zero(inertias, "inertias", kind, count, "kg m^2")
    if not isinstance(color, str) or not color:
        raise TypeError(f"color of {what} must be a word such as 'GRAIN', got {shown(color)}.")
    made = [object.__new__(kind) for _ in range(count)]
    for row, body in enumerate(made):
        body._block, body._row, body._state, body._id = block, row, None, -1
        body._color, body._material, body._hidden = color, material, False
        body._velocities = body._forces = NO_CONDITIONS
    return made


def of_each(value: Any, name: str, shape: tuple[int, ...], unit: str) -> np.ndarray:
    """Numbers of the given shape: one row a body, or one for all; None for zeros."""
    if value is None:
        return np.zeros(shape)
    given = numbers(value, name, f"an array {shape} [{unit}]")
    if given.shape not in (shape, shape[1:]):
        alternatives = (
            f"{shape} [{unit}], or {shape[1:]} for all" if shape[1:] else f"{shape} [{unit}], or one number for all"
        )
        raise ValueError(f"{name} must be of shape {alternatives}, got {given.shape}.")
    return np.broadcast_to(given, shape)


def _above_zero(value: Any, name: str, kind: type[Round], count: int, unit: str) -> np.ndarray:
    """Numbers above zero, (count,): one a body, or one for all."""
    whole_name = f"{name} of add_{kind.noun}s"
    given = of_each(value, whole_name, (count,), unit)
    wrong = np.flatnonzero(~(given >= 1.0 / LARGEST))
    if len(wrong):
        row = int(wrong[0])
        number(float(given[row]), f"{whole_name}: number {row}", above=0.0, unit=unit)
    return given


class StartNumbers(NamedTuple):
    """Numbers of the bodies before the first step, as arrays; n bodies."""

    rows: np.ndarray
    """Positions, velocities, radii, masses and inertias, (n, 12), see :class:`~lmgcpy.scene.body.StartRows`."""
    plain: np.ndarray
    """Whether a body is a disk or sphere of lmgcpy that its row describes completely, (n,) bool."""
    extent: np.ndarray
    link_radius: np.ndarray
    """[m], (n,)."""
    heavy: np.ndarray
    """Whether gravity acts, (n,) bool."""
    turning: np.ndarray
    """Rows of the bodies that keep a rotation in space, (t,) int64."""
    quaternion: np.ndarray
    """Their rotations, (t, 4)."""
    inertias: np.ndarray
    """Their inertias about their own axes [kg m^2], (t, 3)."""

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> StartNumbers:
        """Copy the numbers of bodies. Bodies that are no plain disks or spheres are asked one by one."""
        rows = _rows_of(bodies)
        plain = np.fromiter((type(body) in PLAIN for body in bodies), bool, len(bodies))
        turning = np.array([i for i in np.flatnonzero(~plain).tolist() if bodies[i].turns], dtype=np.int64)
        start = cls(
            *(rows, plain, rows[:, RADIUS].copy(), rows[:, RADIUS].copy(), np.ones(len(bodies), dtype=bool), turning),
            np.array([bodies[i]._quaternion for i in turning.tolist()]).reshape(-1, 4),
            np.array([np.broadcast_to(bodies[i].inertia, 3) for i in turning.tolist()]).reshape(-1, 3),
        )
        for i in start.others:
            body = bodies[i]
            rows[i, MASS], rows[i, INERTIA] = body.mass, np.max(body.inertia)
            start.extent[i], start.link_radius[i], start.heavy[i] = body.extent, body.link_radius, body.gravity_acts
        return start

    @property
    def others(self) -> list[int]:
        """Rows of the bodies that are not plain."""
        return np.flatnonzero(~self.plain).tolist()

    @property
    def mass(self) -> np.ndarray:
        """[kg], (n,)."""
        return self.rows[:, MASS]

    @property
    def inertia(self) -> np.ndarray:
        """[kg m^2], (n,)."""
        return self.rows[:, INERTIA]


def _rows_of(bodies: Sequence[Body]) -> np.ndarray:
    """The rows of numbers of bodies, (n, 12), a copy."""
    rows = np.fromiter((body._row for body in bodies), np.intp, len(bodies))
    result = np.empty((len(bodies), StartRows.WIDTH))
    first = 0
    # bodies that were made together have one block
    for _, run in groupby(bodies, key=lambda body: id(body._block)):
        members = list(run)
        last = first + len(members)
        result[first:last] = members[0]._block[rows[first:last]]
        first = last
    return result
