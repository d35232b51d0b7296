"""Bodies in space: spheres, cylindrical walls and capsules; the volume of a body, and its twin in another place."""

from __future__ import annotations

import copy
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, vector
from lmgcpy.scene.body import NO_CONDITIONS, RADIUS, Body, Boundary, Prescribed, RigidBody, Round, _start_rows
from lmgcpy.scene.contactor import CylinderContactor, RodContactor, SphereContactor, direction
from lmgcpy.scene.solid import Material, union_volume

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

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


def placed(body: Body, position: Any, turn: Rotation | None = None) -> Body:
    """A body like this one, in no scene, with its centre at ``position`` [m]: at rest, without conditions.

    It stands as the body does, or turned from there by ``turn``, if it turns in space.
    """
    twin = copy.copy(body)
    twin._state, twin._id, twin._hidden = None, -1, False
    twin._velocities = twin._forces = NO_CONDITIONS
    twin._block, twin._row = _start_rows.take()
    twin._block[twin._row] = 0.0
    twin._block[twin._row, RADIUS:] = body._block[body._row, RADIUS:]
    twin.position[:] = position
    if body.turns:
        twin._quaternion = (body.rotation if turn is None else turn * body.rotation).as_quat()
    return twin


def body_volume(body: Body) -> float:
    """Volume [m^3] of a sphere, a clump, whose overlaps count once, or a capsule; ValueError for other bodies."""
    if isinstance(body, Capsule):
        return capsule_volume(body.radius, body.length)
    balls = [(*at, ball.radius) for ball, at in body.contactors if isinstance(ball, SphereContactor)]
    if len(balls) < len(body.contactors):
        raise ValueError(f"{body!r} is no sphere, clump or capsule, so that its volume is not known.")
    return union_volume(np.array(balls)[:, :3], np.array(balls)[:, 3])
