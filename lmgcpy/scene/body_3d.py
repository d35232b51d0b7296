"""Bodies in 3D: spheres and hollow cylinders."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, shown
from lmgcpy.scene.body import Body, Boundary, Prescribed, Round
from lmgcpy.scene.contactor import CylinderContactor, SphereContactor
from lmgcpy.scene.material import Material

ALONG = 1e-9
"""A spin is along an axis if its part across it is this part of it at the most."""


@named_arguments
class Sphere(Round):
    """A sphere. ``mass`` [kg] overrides the mass from the material, and ``inertia`` [kg m^2] overrides 2/5 m R^2."""

    __slots__ = ()

    dimension = 3
    noun = "sphere"
    _shape = SphereContactor

    @staticmethod
    def volume(radius: float) -> float:
        """4/3 pi R^3, the volume of a sphere of that radius [m^3]."""
        return 4.0 / 3.0 * math.pi * radius**3

    @staticmethod
    def turning(radius: float) -> float:
        """2/5 R^2, the ratio of its inertia to its mass [m^2]."""
        return 0.4 * radius**2


@named_arguments
class CylinderWall(Boundary):
    """A hollow cylinder around the bodies. It never turns; its components are held unless loaded."""

    dimension = 3
    noun = "cylinder"

    def __init__(self, *, point: Any, axis: Any, radius: float, mass: float | None = None, **start: Any):
        super().__init__(point=point, mass=mass, **start)
        self._contactor = CylinderContactor(axis, radius)

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return self._contactor.radius

    @named_arguments
    def impose_velocity(self, **components: Prescribed) -> Body:
        """Drive components x, y, z [m/s], spin … [rad/s] by a number or a function of time [s]. Returns the body.

        A cylinder turns about its own axis only: ``point`` and ``axis`` are all of its position. So a spin must be along
        the axis. A function of time can be a spin only if the cylinder lies along a coordinate axis.
        """
        spins = np.array([_rate(components.get(name, 0.0)) for name in self.components[3:]])
        axis = self._contactor.axis
        across = np.where(np.isnan(spins), np.abs(axis) < 1.0 - ALONG, False)
        constant = np.nan_to_num(spins)
        if across.any() or np.linalg.norm(np.cross(constant, axis)) > ALONG * np.linalg.norm(constant):
            raise ValueError(
                f"{self!r} turns about its own axis only, {shown(axis.tolist())}: a spin across it would move the wall "
                "through itself. Drive the spin along the axis, its components as numbers in one call."
            )
        return super().impose_velocity(**components)


def _rate(value: Prescribed) -> float:
    """A spin that is a number; NaN for a function of time, 0 for anything that is no number, which is refused elsewhere."""
    if callable(value):
        return float("nan")
    return float(value) if isinstance(value, (int, float, np.number)) else 0.0


@named_arguments
def sphere(
    *,
    radius: float,
    position: Any,
    material: Material | None = None,
    color: str = "GRAIN",
    velocity: Any = (0.0, 0.0, 0.0),
    spin: Any = (0.0, 0.0, 0.0),
    mass: float | None = None,
    inertia: float | None = None,
) -> Sphere:
    """A sphere of ``radius`` [m] at ``position`` [m]; ``mass`` [kg] and ``inertia`` [kg m^2] override the material's."""
    return Sphere(
        radius=radius,
        position=position,
        material=material,
        color=color,
        velocity=velocity,
        spin=spin,
        mass=mass,
        inertia=inertia,
    )


@named_arguments
def cylinder_wall(*, point: Any, axis: Any, radius: float, color: str = "WALL", mass: float | None = None) -> CylinderWall:
    """A hollow cylinder of ``radius`` [m] around ``axis`` through ``point`` [m]. To be loaded it needs a ``mass`` [kg]."""
    return CylinderWall(point=point, axis=axis, radius=radius, color=color, mass=mass)
