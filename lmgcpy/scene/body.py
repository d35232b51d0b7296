"""Bodies: rigid, with mass, contactors, and conditions on their components.

Before a scene is compiled a body holds its own start; afterwards its attributes are views of the simulation's state.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from threading import Lock
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.dynamics.model import COMPONENTS
from lmgcpy.errors import closest, named_arguments, number, shown, vector
from lmgcpy.scene.contactor import Contactor, DiskContactor, PlaneContactor, WallContactor
from lmgcpy.scene.material import Material

if TYPE_CHECKING:
    from lmgcpy.dynamics.model import BodyState

STILL: Any = object()
"""Velocity or spin of a body of which none is given."""

Prescribed = float | Callable[[float], float]
UNSAID: Mapping[int, Prescribed] = MappingProxyType({})
"""Conditions of a body of which none were given: one for all, as most have none."""


RADIUS, MASS, INERTIA = 9, 10, 11
"""Where in its row of numbers a round body keeps them [m, kg, kg m^2]."""


class Starts:
    """Rows of twelve numbers, in which bodies keep where and how they start, up to nine, and round ones what they are: an
    array of one's own would take 120 bytes, and a number of one's own 32."""

    def __init__(self) -> None:
        self.block, self.taken = np.empty((0, 12)), 0
        self._lock = Lock()

    def take(self) -> tuple[np.ndarray, int]:
        """A block and a row in it that nobody has."""
        with self._lock:
            if self.taken == len(self.block):
                self.block, self.taken = np.zeros((256, 12)), 0
            self.taken += 1
            return self.block, self.taken - 1


_starts = Starts()


@named_arguments
class Body(ABC):
    """A rigid body. Masses are per metre of depth [kg] in 2D; ``color`` is what the visibility table calls it.

    Subclasses give ``dimension``, ``mass``, ``inertia`` and ``contactors``. ``rotation`` is for 2D: in 3D none is kept.
    """

    __slots__ = ("_block", "_color", "_forces", "_id", "_row", "_state", "_velocities")  # there may be a hundred thousand

    dimension: int = 2
    placed_by: str = "position"
    """What the argument is called that says where the body is."""

    def __init__(self, *, position: Any, color: str, velocity: Any = STILL, rotation: float = 0.0, spin: Any = STILL):
        what, d = type(self).__name__, self.dimension
        self._state: BodyState | None = None
        self.color = color
        self._id = -1
        at = vector(position, f"{self.placed_by} of a {what}", d)
        moving = vector(np.zeros(d) if velocity is STILL else velocity, f"velocity of a {what}", d)
        turned: Any = number(rotation, "rotation") if d == 2 else ()
        if d == 2:
            turning: Any = number(0.0 if spin is STILL else spin, "spin")
        else:
            turning = vector(np.zeros(3) if spin is STILL else spin, f"spin of a {what}", 3)
        self._block, self._row = _starts.take()
        start = np.hstack([at, turned, moving, turning])
        self._block[self._row, : len(start)] = start
        self._velocities = self._forces = UNSAID

    @property
    def id(self) -> int:
        """Row of the body in all that a simulation gives by body; -1 before it is in a scene, which gives it."""
        return self._id

    @property
    def color(self) -> str:
        """What the visibility table calls the body."""
        return self._color

    @color.setter
    def color(self, color: str) -> None:
        self._refuse_compiled("set its color")
        if not isinstance(color, str) or not color:
            raise TypeError(f"color of a {type(self).__name__} must be a word such as 'GRAIN', got {shown(color)}.")
        self._color = color

    @property
    @abstractmethod
    def mass(self) -> float:
        """Mass [kg], per metre of depth in 2D; infinite where none is needed."""

    @property
    @abstractmethod
    def inertia(self) -> float:
        """Moment of inertia about the centre [kg m^2], per metre of depth in 2D, about every axis in 3D."""

    @property
    @abstractmethod
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        """Contactors, each with its offset from the centre in the frame of the body [m]."""

    @property
    def link_radius(self) -> float:
        """From the centre to the surface along a link [m]."""
        return 0.0

    @property
    def extent(self) -> float:
        """Radius of a circle around the centre that holds all contactors [m]."""
        return max(math.hypot(*offset) + contactor.bounding_radius for contactor, offset in self.contactors)

    @property
    def gravity_acts(self) -> bool:
        """Whether the scene's gravity acts on the body."""
        return True

    @property
    def held_by_default(self) -> bool:
        """Whether a component that nothing is said of is held at rest."""
        return False

    # ------------------------------------------------------------------------------------------------------- state

    @property
    def _position(self) -> np.ndarray:
        """(x, y, angle) or (x, y, z) at the start."""
        return self._block[self._row, :3]

    @property
    def _velocity(self) -> np.ndarray:
        """Velocities and spins at the start."""
        return self._block[self._row, 3 : 3 + len(self.components)]

    def _now(self, positions: bool) -> np.ndarray:
        if self._state is None:
            return self._position if positions else self._velocity
        return (self._state.positions if positions else self._state.velocities)[self._id]

    @property
    def position(self) -> np.ndarray:
        """Position [m], (d,); of a wall, its point. A live view."""
        return self._now(True)[: self.dimension]

    @property
    def rotation(self) -> float:
        """Angle turned [rad], in 2D."""
        if self.dimension == 3:
            raise AttributeError(f"{self!r} has no rotation: in 3D none is kept.")
        return float(self._now(True)[2])

    @property
    def velocity(self) -> np.ndarray:
        """Velocity [m/s], (d,). A live view."""
        return self._now(False)[: self.dimension]

    @property
    def spin(self) -> Any:
        """Angular velocity [rad/s]: a number in 2D, (3,) in 3D, a live view."""
        turning = self._now(False)[self.dimension :]
        return float(turning[0]) if self.dimension == 2 else turning

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components of its velocity."""
        return COMPONENTS[self.dimension]

    # -------------------------------------------------------------------------------------------------- conditions

    def fix(self, *components: str) -> Body:
        """Hold the named components ("x", "y", "spin"; in 3D also "z", and "spin_x" …), all of them without names, at rest;
        returns the body."""
        for component in components:
            if not isinstance(component, str):
                raise TypeError(f"fix takes names of components, as in fix('x', 'y'), got {shown(component)}.")
        return self._drive("fix", dict.fromkeys(components or self.components, 0.0))

    @named_arguments
    def impose_velocity(self, **components: Prescribed) -> Body:
        """Drive components x, y, z [m/s], spin … [rad/s] by a number or a function of time [s]; returns the body."""
        return self._drive("impose_velocity", components)

    def _drive(self, call: str, components: dict[str, Prescribed]) -> Body:
        for component, value in self._checked(call, components):
            if component in self._forces:
                raise ValueError(self._twice(component, "loaded by impose_force", "driven"))
            self._condition(component, value, loaded=False)
        return self

    @named_arguments
    def impose_force(self, **components: Prescribed) -> Body:
        """Free components and load them: x, y, z [N], spin … [N m], numbers or functions of time [s]; returns the body."""
        for component, value in self._checked("impose_force", components):
            if component in self._velocities:
                raise ValueError(self._twice(component, "driven by impose_velocity or fix", "loaded"))
            if not math.isfinite(self.mass if component < self.dimension else self.inertia):
                raise ValueError(
                    f"{self!r} has no {'mass' if component < self.dimension else 'inertia'}: give it one where it is made, "
                    f"so that a load on {self.components[component]} can move it."
                )
            self._condition(component, value, loaded=True)
        return self

    def _condition(self, component: int, value: Prescribed, *, loaded: bool) -> None:
        if loaded:
            self._forces = {**self._forces, component: value}
        else:
            self._velocities = {**self._velocities, component: value}

    def _twice(self, component: int, already: str, now: str) -> str:
        return (
            f"Component {self.components[component]} of {self!r} is {already} already and cannot be {now} as well: "
            "choose one of the two."
        )

    def _checked(self, call: str, components: dict[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        self._refuse_compiled(f"call {call}")
        if not components:
            raise TypeError(f"{call} needs a component, for example {call}(y=0.0).")
        checked: list[tuple[int, Prescribed]] = []
        for name, value in components.items():
            if name not in self.components:
                hint = closest(name, self.components)
                raise ValueError(f"{call}: a body in {self.dimension}D has no component '{name}'{hint}")
            value = value if callable(value) else number(value, f"{call}({name}=...)")
            checked.append((self.components.index(name), value))
        return checked

    def _refuse_compiled(self, what: str) -> None:
        if self._state is not None:
            raise RuntimeError(f"{self!r} is in a compiled scene, which cannot be edited: {what} before Simulation.")

    def __repr__(self) -> str:
        which = f"body {self.id}" if self.id >= 0 else "body not yet in a scene"
        place = ", ".join(f"{x:g}" for x in self.position)
        return f"<{type(self).__name__} '{self.color}', {which}, at ({place}) m>"


@named_arguments
class RigidBody(Body):
    """A body of given mass and inertia made of any contactors: a cluster of disks, or shapes of one's own."""

    def __init__(self, contactors: list, *, mass: float, inertia: float, **start: Any):
        super().__init__(**start)
        if not isinstance(contactors, (list, tuple)) or not contactors:
            raise TypeError(f"A rigid body needs a list of at least one contactor, got {shown(contactors)}.")
        self._contactors: list[tuple[Contactor, tuple[float, ...]]] = []
        for item in contactors:
            contactor, offset = item if isinstance(item, tuple) and len(item) == 2 else (item, (0.0, 0.0))
            if not isinstance(contactor, Contactor):
                raise TypeError(f"contactors must be Contactor objects or pairs (contactor, offset), got {shown(item)}.")
            x, y = vector(offset, "offset of a contactor", 2)
            self._contactors.append((contactor, (float(x), float(y))))
        self._mass = number(mass, "mass of a rigid body", above=0.0, unit="kg")
        self._inertia = number(inertia, "inertia of a rigid body", above=0.0, unit="kg m^2")

    @property
    def mass(self) -> float:
        return self._mass

    @property
    def inertia(self) -> float:
        return self._inertia

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return self._contactors


class Round(Body):
    """A disk or a sphere; subclasses make its contactor and say what it weighs and how it resists turning."""

    __slots__ = ("_material",)

    what: str
    """What it is called in sentences."""

    def __init__(
        self,
        *,
        radius: float,
        material: Material | None = None,
        mass: float | None = None,
        inertia: float | None = None,
        **start: Any,
    ):
        super().__init__(**start)
        own = self._block[self._row]
        own[RADIUS] = self._shape(radius).radius
        if material is not None and not isinstance(material, Material):
            raise TypeError(f"material of a {self.what} must be a lmgcpy.Material, got {shown(material)}.")
        if mass is None and material is None:
            raise TypeError(f"A {self.what} needs a material= or a mass= [kg].")
        if mass is None:
            assert material is not None
            mass = material.density * self._volume
        own[MASS] = number(mass, f"mass of a {self.what}", above=0.0, unit="kg")
        inertia = own[MASS] * self._turning if inertia is None else inertia
        own[INERTIA] = number(inertia, f"inertia of a {self.what}", above=0.0)
        self._material = material

    @staticmethod
    @abstractmethod
    def _shape(radius: float) -> Any:
        """Its contactor."""

    @property
    @abstractmethod
    def _volume(self) -> float:
        """Volume, in 2D area [m^3, m^2]."""

    @property
    @abstractmethod
    def _turning(self) -> float:
        """Inertia over mass [m^2]."""

    @property
    def material(self) -> Material | None:
        """What it is made of, if it was given one."""
        return self._material

    @property
    def radius(self) -> float:
        """Radius [m]."""
        return float(self._block[self._row, RADIUS])

    @property
    def mass(self) -> float:
        return float(self._block[self._row, MASS])

    @property
    def inertia(self) -> float:
        return float(self._block[self._row, INERTIA])

    @property
    def _contactor(self) -> Any:
        """Made when asked for: a hundred thousand are not kept."""
        return self._shape(self.radius)

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return [(self._contactor, (0.0,) * self.dimension)]

    @property
    def extent(self) -> float:
        return self.radius

    @property
    def link_radius(self) -> float:
        return self.radius


@named_arguments
class Disk(Round):
    """A disk: grain, bead. Its mass is that of its material, or ``mass`` [kg]; its inertia m R^2/2, or ``inertia``."""

    __slots__ = ()

    what = "disk"
    _shape = DiskContactor

    @property
    def _volume(self) -> float:
        return self._contactor.area

    @property
    def _turning(self) -> float:
        return self._contactor.second_moment / self._contactor.area


@named_arguments
class Wall(Body):
    """The half-space behind a line, in 3D a plane. Every component is held unless freed by a load; it never turns."""

    placed_by = "point"

    def __init__(self, *, point: Any, normal: Any, mass: float | None = None, **start: Any):
        self.dimension = 3 if hasattr(point, "__len__") and getattr(point, "shape", None) != () and len(point) == 3 else 2
        super().__init__(position=point, **start)
        self._contactor = WallContactor(normal) if self.dimension == 2 else PlaneContactor(normal)
        self._mass = math.inf if mass is None else number(mass, "mass of a wall", above=0.0, unit="kg")

    @property
    def normal(self) -> np.ndarray:
        """Outward unit normal, (d,)."""
        return self._contactor.normal

    @property
    def mass(self) -> float:
        return self._mass

    @property
    def inertia(self) -> float:
        return math.inf

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return [(self._contactor, (0.0,) * self.dimension)]

    @property
    def gravity_acts(self) -> bool:
        return False

    @property
    def held_by_default(self) -> bool:
        return True

    def _checked(self, call: str, components: dict[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        turns = [name for name in components if name in self.components[self.dimension :]]
        if turns and (call == "impose_force" or any(components[name] != 0.0 for name in turns)):
            names = " and ".join(self.components[: self.dimension])
            raise ValueError(f"A wall does not turn: drive or load its components {names}.")
        return super()._checked(call, components)


@named_arguments
def disk(
    *,
    radius: float,
    position: Any,
    material: Material | None = None,
    color: str = "GRAIN",
    velocity: Any = (0.0, 0.0),
    spin: float = 0.0,
    mass: float | None = None,
    inertia: float | None = None,
) -> Disk:
    """A disk of ``radius`` [m] at ``position`` [m]; ``mass`` [kg] and ``inertia`` [kg m^2] override the material's."""
    return Disk(
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
def wall(*, point: Any, normal: Any, color: str = "WALL", mass: float | None = None) -> Wall:
    """A half-space bounded by the line, in 3D the plane, through ``point`` [m] with outward ``normal``; ``mass`` [kg] if
    it is loaded."""
    return Wall(point=point, normal=normal, color=color, mass=mass)
