"""Contactors: the shapes of bodies in contact.

A new shape needs a subclass of :class:`Contactor`, and one narrow phase for each kind of contactor that it can touch
(``lmgcpy.contact.register_pair``). No other part of the package lists the shapes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from lmgcpy.errors import named_arguments, number, read_only, vector


class Contactor(ABC):
    """A shape fixed to a body. Areas and moments are per metre of depth, as in 2D."""

    __slots__ = ()

    KIND: ClassVar[str]
    """Name under which narrow phases are registered."""
    TURNS: ClassVar[bool] = True
    """Whether it turns with its body. In space a body with such a contactor keeps a rotation."""

    @property
    @abstractmethod
    def shape(self) -> tuple[float, ...]:
        """The numbers that the narrow phase receives."""

    @property
    @abstractmethod
    def bounding_radius(self) -> float:
        """Radius [m] of a circle around the contactor's position that contains the shape; may be infinite."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Area [m^2]; zero if the shape has no area of its own."""

    @property
    @abstractmethod
    def second_moment(self) -> float:
        """Polar second moment of area about the contactor's position [m^4]."""

    @property
    def outline(self) -> Sequence[np.ndarray] | None:
        """How the contactor is drawn: polylines in its own frame [m], (v, d) each. If None, round contactors are drawn as
        they are, others as their bounding circle or sphere."""
        return None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} '{self.KIND}' of shape ({', '.join(f'{x:g}' for x in self.shape)})>"


class RoundContactor(Contactor):
    """A disk or a sphere of radius ``radius`` [m]."""

    __slots__ = ("radius",)

    def __init__(self, radius: float):
        self.radius = number(radius, f"radius of a {self.KIND}", above=0.0, unit="m")

    @property
    def shape(self) -> tuple[float, ...]:
        return (self.radius,)

    @property
    def bounding_radius(self) -> float:
        return self.radius


@named_arguments
class DiskContactor(RoundContactor):
    """A disk of radius ``radius`` [m]."""

    __slots__ = ()
    KIND = "disk"

    @property
    def area(self) -> float:
        return disk_area(self.radius)

    @property
    def second_moment(self) -> float:
        return disk_second_moment(self.radius)


def disk_area(radius: float) -> float:
    """Area of a disk [m^2]."""
    return math.pi * radius**2


def disk_second_moment(radius: float) -> float:
    """Polar second moment of area of a disk about its centre [m^4]."""
    return 0.5 * math.pi * radius**4


class WallContactor(Contactor):
    """The half-space behind a line through the contactor's position with the outward ``normal``."""

    KIND = "wall"
    area = 0.0
    second_moment = 0.0
    bounding_radius = math.inf

    def __init__(self, normal):
        self.normal = direction(normal, "normal of a wall", 2)

    @property
    def shape(self) -> tuple[float, ...]:
        return (float(self.normal[0]), float(self.normal[1]))


def direction(value, name: str, dimension: int) -> np.ndarray:
    """The unit vector along ``value``, (dimension,), read-only; ValueError for a zero vector."""
    given = vector(value, name, dimension)
    length = float(np.linalg.norm(given))
    if length == 0.0:
        raise ValueError(f"{name} must not be zero: it is a direction.")
    return read_only(given / length)


class SpatialContactor(Contactor):
    """A shape in 3D, without area and moment of its own."""

    __slots__ = ()

    area = 0.0
    second_moment = 0.0


@named_arguments
class SphereContactor(SpatialContactor, RoundContactor):
    """A sphere of radius ``radius`` [m]."""

    __slots__ = ()
    KIND = "sphere"
    TURNS = False  # it looks alike from all sides


@named_arguments
class RodContactor(SpatialContactor):
    """A sphere of radius ``radius`` [m] swept along a segment, without its ends: from its position by ``half`` and by
    ``-half``, a vector [m] along the axes of the body. Spheres at the ends make a capsule of it (:func:`lmgcpy.capsule`).
    """

    KIND = "rod"

    def __init__(self, radius: float, half: Any):
        self.radius = number(radius, "radius of a rod", above=0.0, unit="m")
        self.half = read_only(vector(half, "half of a rod", 3))
        if not self.half.any():
            raise ValueError("half of a rod must not be zero: it is the way from its middle to an end.")

    @property
    def shape(self) -> tuple[float, ...]:
        return (self.radius, *self.half.tolist())

    @property
    def bounding_radius(self) -> float:
        return float(np.linalg.norm(self.half)) + self.radius


class PlaneContactor(SpatialContactor):
    """The half-space behind a plane through the contactor's position with the outward ``normal``."""

    KIND = "plane"
    TURNS = False
    bounding_radius = math.inf

    def __init__(self, normal):
        self.normal = direction(normal, "normal of a wall whose point has 3 numbers", 3)

    @property
    def shape(self) -> tuple[float, ...]:
        return tuple(self.normal.tolist())


class CylinderContactor(SpatialContactor):
    """The outside of a cylinder of radius ``radius`` [m] around ``axis`` through the contactor's position."""

    KIND = "cylinder"
    TURNS = False
    bounding_radius = math.inf

    def __init__(self, axis, radius: float):
        self.axis = direction(axis, "axis of a cylinder", 3)
        self.radius = number(radius, "radius of a cylinder", above=0.0, unit="m")

    @property
    def shape(self) -> tuple[float, ...]:
        return (*self.axis.tolist(), self.radius)
