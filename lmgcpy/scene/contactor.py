"""Contactors: the shapes by which bodies meet.

A new shape is a subclass of :class:`Contactor` and one narrow phase for each kind it is to meet
(``lmgcpy.contact.register_pair``); nothing in the package knows the list of shapes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from lmgcpy.errors import named_arguments, number, vector


class Contactor(ABC):
    """A shape in the frame of its body, in 2D; areas and moments are per metre of depth."""

    KIND: ClassVar[str]
    """Name by which narrow phases are registered."""

    @property
    @abstractmethod
    def shape(self) -> tuple[float, ...]:
        """Numbers that the narrow phase receives."""

    @property
    @abstractmethod
    def bounding_radius(self) -> float:
        """Radius of a circle around the contactor's position that holds it [m]; infinite for what has no bounds."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Area [m^2]; zero for what has none of its own."""

    @property
    @abstractmethod
    def second_moment(self) -> float:
        """Polar second moment of area about the contactor's position [m^4]."""


@named_arguments
class DiskContactor(Contactor):
    """A disk of radius ``radius`` [m]."""

    KIND = "disk"

    def __init__(self, radius: float):
        self.radius = number(radius, "radius of a disk", above=0.0, unit="m")

    @property
    def shape(self) -> tuple[float, ...]:
        return (self.radius,)

    @property
    def bounding_radius(self) -> float:
        return self.radius

    @property
    def area(self) -> float:
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        return 0.5 * math.pi * self.radius**4


class WallContactor(Contactor):
    """The half-space behind a line through the contactor's position with the outward ``normal``."""

    KIND = "wall"
    area = 0.0
    second_moment = 0.0
    bounding_radius = math.inf

    def __init__(self, normal):
        direction = vector(normal, "normal of a wall", 2)
        length = float(np.hypot(*direction))
        if length == 0.0:
            raise ValueError("normal of a wall must not be zero: it points from the wall into the free space.")
        self.normal = direction / length

    @property
    def shape(self) -> tuple[float, ...]:
        return (float(self.normal[0]), float(self.normal[1]))
