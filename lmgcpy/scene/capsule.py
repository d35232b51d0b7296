"""Capsules: a sphere swept along a segment. A short fibre is one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, vector
from lmgcpy.scene.body import RigidBody
from lmgcpy.scene.contactor import RodContactor, SphereContactor, direction
from lmgcpy.scene.material import Material


def capsule_volume(radius: float, length: float) -> float:
    """Volume of a capsule of a radius, and a length between the centres of its ends [m^3]."""
    return math.pi * radius**2 * (length + 4.0 / 3.0 * radius)


def capsule_inertias(mass: float, radius: float, length: float) -> np.ndarray:
    """Moments of inertia of a capsule about its axes [kg m^2], (3,), the last along the segment.

    Those of its cylinder and of its two half spheres, whose centres of mass are 3/8 of the radius beyond the ends.
    """
    density = mass / capsule_volume(radius, length)
    shaft, balls = density * math.pi * radius**2 * length, density * 4.0 / 3.0 * math.pi * radius**3
    along = shaft * 0.5 * radius**2 + balls * 0.4 * radius**2
    across = shaft * (length**2 / 12.0 + radius**2 / 4.0)
    across += balls * (0.4 * radius**2 + 0.25 * length**2 + 0.375 * length * radius)
    return np.array([across, across, along])


@named_arguments
class Capsule(RigidBody):
    """A capsule, its axis along the z axis of the body. It meets others by its parts: both ends are spheres, and a rod is
    between them. So two parallel capsules touch at two points, and a capsule lies on a plane by its ends."""

    def __init__(
        self,
        *,
        radius: float,
        length: float,
        material: Material | None = None,
        mass: float | None = None,
        **start: Any,
    ):
        radius = number(radius, "radius of a capsule", above=0.0, unit="m")
        length = number(length, "length of a capsule", above=0.0, unit="m")
        if material is not None and not isinstance(material, Material):
            raise TypeError(f"material of a capsule must be a lmgcpy.Material, got {shown(material)}.")
        if mass is None:
            if material is None:
                raise TypeError("A capsule needs a material= or a mass= [kg].")
            mass = material.density * capsule_volume(radius, length)
        mass = number(mass, "mass of a capsule", above=0.0, unit="kg")
        start["position"] = vector(start.get("position"), "position of a capsule", 3)
        half = 0.5 * length
        parts = [
            (RodContactor(radius, (0.0, 0.0, half)), (0.0, 0.0, 0.0)),
            (SphereContactor(radius), (0.0, 0.0, half)),
            (SphereContactor(radius), (0.0, 0.0, -half)),
        ]
        super().__init__(parts, mass=mass, inertia=capsule_inertias(mass, radius, length), **start)
        self.radius, self.length, self.material = radius, length, material


def along(axis: Any, name: str) -> np.ndarray:
    """The quaternion of the shortest turn from the z axis to a direction, (4,)."""
    x, y, z = direction(axis, name, 3)
    if x == 0.0 and y == 0.0:
        return np.array([0.0, 0.0, 0.0, 1.0]) if z > 0.0 else np.array([1.0, 0.0, 0.0, 0.0])
    # e_z x axis, and 1 + e_z . axis, without cancellation
    turn = np.array([-y, x, 0.0, 1.0 + z if z > 0.0 else (x * x + y * y) / (1.0 - z)])
    return turn / np.linalg.norm(turn)


@named_arguments
def capsule(
    *,
    radius: float,
    length: float,
    position: Any,
    axis: Any = (0.0, 0.0, 1.0),
    rotation: Any = None,
    material: Material | None = None,
    mass: float | None = None,
    color: str = "GRAIN",
    velocity: Any = (0.0, 0.0, 0.0),
    spin: Any = (0.0, 0.0, 0.0),
) -> Capsule:
    """A capsule: a sphere of ``radius`` [m] swept along a segment of ``length`` [m] around ``position`` [m], along
    ``axis``.

    ``rotation``, from the axes of the body (z along the segment) to those of space, takes the place of ``axis``; ``mass``
    [kg] overrides the mass from the ``material``.

    >>> import lmgcpy as lm
    >>> polyester = lm.Material("polyester", 1380.0)
    >>> fibre = lm.capsule(radius=1e-4, length=1e-2, position=(0, 0, 0), axis=(1, 0, 0), material=polyester)
    >>> f"{fibre.mass:.4g} kg"
    '4.393e-07 kg'
    """
    if rotation is None:
        rotation = along(axis, "axis of a capsule")
    return Capsule(
        radius=radius,
        length=length,
        material=material,
        mass=mass,
        position=position,
        rotation=rotation,
        color=color,
        velocity=velocity,
        spin=spin,
    )
