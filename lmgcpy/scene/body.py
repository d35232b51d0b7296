"""Rigid bodies with mass, contactors, and conditions on the components of their velocity.

Before the scene is compiled, a body holds its own initial values. Afterwards its attributes are views of the simulation's
state.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from threading import Lock
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lmgcpy.dynamics.changes import DRIVEN, FREE, HIDDEN, LOADED, SHOWN
from lmgcpy.dynamics.model import COMPONENTS
from lmgcpy.errors import closest, named_arguments, number, read_only, shown, vector
from lmgcpy.scene.contactor import (
    Contactor,
    CylinderContactor,
    DiskContactor,
    PlaneContactor,
    RodContactor,
    SpatialContactor,
    SphereContactor,
    WallContactor,
    disk_area,
    disk_second_moment,
)
from lmgcpy.scene.solid import Material

if TYPE_CHECKING:
    from lmgcpy.dynamics.model import BodyState

AT_REST: Any = object()
"""Default of velocity, spin and rotation: the body starts at rest, along the axes."""

Prescribed = float | Callable[[float], float]
NO_CONDITIONS: Mapping[int, Prescribed] = {}
"""Conditions of a body without conditions. All such bodies share it; a statement makes new ones."""


NO_ROTATION = np.array([0.0, 0.0, 0.0, 1.0])
"""The quaternion of a body whose axes are those of space."""

RADIUS, MASS, INERTIA = 9, 10, 11
"""Columns of the radius [m], mass [kg] and inertia [kg m^2] in the row of a round body."""


class StartRows:
    """Rows of twelve numbers, one a body: up to nine initial positions and velocities, then the constants of a round body.

    The rows save memory: an array for each body would take 120 bytes, and a number 32.
    """

    WIDTH = 12

    def __init__(self) -> None:
        self.block, self.taken = np.empty((0, self.WIDTH)), 0
        self._lock = Lock()

    def take(self) -> tuple[np.ndarray, int]:
        """A block and the index of a free row in it."""
        with self._lock:
            if self.taken == len(self.block):
                self.block, self.taken = np.zeros((256, self.WIDTH)), 0
            self.taken += 1
            return self.block, self.taken - 1


_start_rows = StartRows()


@named_arguments
class Body(ABC):
    """A rigid body. In 2D masses are per metre of depth [kg]. The visibility table names bodies by their ``color``.

    Subclasses give ``dimension``, ``mass``, ``inertia`` and ``contactors``. In space a body keeps a ``rotation`` if it
    :attr:`turns`: spheres look alike from all sides, and walls never turn. The axes of such a body are its principal axes.
    """

    # slots save memory: a scene may have a hundred thousand bodies
    __slots__ = ("_block", "_color", "_forces", "_hidden", "_id", "_row", "_state", "_velocities")

    dimension: int = 2
    position_argument: str = "position"
    """Name of the argument that gives the position."""

    def __init__(self, *, position: Any, color: str, velocity: Any = AT_REST, rotation: Any = AT_REST, spin: Any = AT_REST):
        """``rotation``: angle [rad] in 2D; in 3D from the axes of the body to the axes of space, a scipy ``Rotation`` or
        the four numbers (q_x, q_y, q_z, q_w) of a unit quaternion."""
        what, d = type(self).__name__, self.dimension
        self._state: BodyState | None = None
        self.color = color
        self._id = -1
        at = vector(position, f"{self.position_argument} of a {what}", d)
        moving = vector(np.zeros(d) if velocity is AT_REST else velocity, f"velocity of a {what}", d)
        turned: Any = number(0.0 if rotation is AT_REST else rotation, "rotation") if d == 2 else ()
        if d == 3 and rotation is not AT_REST:
            self._quaternion = unit_quaternion(rotation, what)
        if d == 2:
            turning: Any = number(0.0 if spin is AT_REST else spin, "spin")
        else:
            turning = vector(np.zeros(3) if spin is AT_REST else spin, f"spin of a {what}", 3)
        self._block, self._row = _start_rows.take()
        start = np.hstack([at, turned, moving, turning])
        self._block[self._row, : len(start)] = start
        self._velocities = self._forces = NO_CONDITIONS
        self._hidden = False

    @property
    def id(self) -> int:
        """Row of the body in the arrays of a simulation; -1 before the body is added to a scene."""
        return self._id

    @property
    def color(self) -> str:
        """The colour by which the visibility table names the body."""
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
        """Mass [kg], per metre of depth in 2D; infinite if the body needs no mass."""

    @property
    @abstractmethod
    def inertia(self) -> Any:
        """Moment of inertia about the centre [kg m^2], per metre of depth in 2D; in 3D a number if it is the same about
        every axis, else three, about the axes of the body."""

    @property
    @abstractmethod
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        """Contactors, each with its offset [m] from the centre of the body, along the axes of the body."""

    @property
    def turns(self) -> bool:
        """Whether the body keeps a rotation in space: its inertias differ, or a contactor turns or is off its centre."""
        if self.dimension == 2:
            return False
        return np.ndim(self.inertia) > 0 or any(contactor.TURNS or any(offset) for contactor, offset in self.contactors)

    @property
    def link_radius(self) -> float:
        """Distance from the centre to the surface along a link [m]."""
        return 0.0

    @property
    def extent(self) -> float:
        """Radius of a circle around the centre that contains all contactors [m]."""
        return max(math.hypot(*offset) + contactor.bounding_radius for contactor, offset in self.contactors)

    @property
    def gravity_acts(self) -> bool:
        """Whether the scene's gravity acts on the body."""
        return True

    @property
    def held_by_default(self) -> bool:
        """Whether the components without a condition are held at rest."""
        return False

    # ------------------------------------------------------------------------------------------------------- state

    @property
    def _position(self) -> np.ndarray:
        """Initial (x, y, angle) or (x, y, z)."""
        return self._block[self._row, :3]

    @property
    def _velocity(self) -> np.ndarray:
        """Initial velocities and spins."""
        return self._block[self._row, 3 : 3 + len(self.components)]

    def _now(self, positions: bool) -> np.ndarray:
        if self._state is None:
            return self._position if positions else self._velocity
        return (self._state.positions if positions else self._state.velocities)[self._id]

    @property
    def position(self) -> np.ndarray:
        """Position [m], (d,), a live view. The position of a wall is its point."""
        return self._now(True)[: self.dimension]

    @property
    def rotation(self) -> Any:
        """Angle of rotation [rad] in 2D. In 3D the rotation from the axes of the body to the axes of space, a scipy
        ``Rotation``; AttributeError if the body keeps none."""
        if self.dimension == 2:
            return float(self._now(True)[2])
        if not self.turns:
            raise AttributeError(f"{self!r} keeps no rotation: it looks alike from all sides, or never turns.")
        from scipy.spatial.transform import Rotation  # slow to import

        return Rotation.from_quat(self._quaternion if self._state is None else self._now(True)[3:])

    def check_turning(self) -> None:
        """ValueError for a rotation in space that the body cannot keep, and for rods without ends; ``Scene.add`` asks."""
        if self.dimension == 2 or not hasattr(self, "__dict__"):
            return
        if "_start_rotation" in vars(self) and not self.turns:
            raise ValueError(f"{self!r} cannot take a rotation: it never turns, or looks alike from all sides.")
        for rod, at in ((rod, at) for rod, at in self.contactors if isinstance(rod, RodContactor)):
            for end in (np.add(at, rod.half), np.subtract(at, rod.half)):
                if not any(
                    isinstance(ball, SphereContactor)
                    and ball.radius >= rod.radius * (1.0 - 1e-9)
                    and math.dist(end, centre) <= 1e-6 * rod.radius
                    for ball, centre in self.contactors
                ):
                    raise ValueError(
                        f"{self!r} has {rod!r} without a sphere of its radius at its end {shown(end.tolist())} m from the "
                        "centre: a rod is only what lies between its ends. lmgcpy.capsule has both."
                    )

    @property
    def _quaternion(self) -> np.ndarray:
        """Initial rotation, (4,)."""
        return vars(self).get("_start_rotation", NO_ROTATION)

    @_quaternion.setter
    def _quaternion(self, quaternion: np.ndarray) -> None:
        if not hasattr(self, "__dict__"):
            raise ValueError(f"A {type(self).__name__} keeps no rotation: it looks alike from all sides.")
        vars(self)["_start_rotation"] = quaternion

    @property
    def velocity(self) -> np.ndarray:
        """Velocity [m/s], (d,), a live view."""
        return self._now(False)[: self.dimension]

    @property
    def reaction(self) -> Any:
        """Force and moment that contacts and links gave to the body in the last step of its simulation, the moment about
        its position: a :class:`Reaction <lmgcpy.measure.Reaction>`; AttributeError without a simulation."""
        if self._state is None or self._state.reaction is None:
            raise AttributeError(f"{self!r} is in no simulation yet, whose step could give it a reaction.")
        return self._state.reaction(self._id)

    @property
    def spin(self) -> Any:
        """Angular velocity [rad/s]: a number in 2D; in 3D (3,) along the axes of space, a live view, or a copy if the body
        turns."""
        turning = self._now(False)[self.dimension :]
        if self.dimension == 2:
            return float(turning[0])
        if self._state is None or self._state.positions.shape[1] == 3 or not self.turns:
            return turning
        return self.rotation.apply(turning)  # not read-only, as scipy does not turn what is

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components of the velocity."""
        return COMPONENTS[self.dimension]

    # -------------------------------------------------------------------------------------------------- conditions

    def fix(self, *components: str) -> Body:
        """Hold the named components at rest; without names, hold all of them. Returns the body.

        The components are "x", "y" and "spin" in 2D; in 3D "x", "y", "z", and "spin_x" …, which are about the axes of
        space, or about the own axes of a body that turns.

        Between the steps of a simulation ``fix``, ``impose_velocity``, ``impose_force``, ``free``, ``hide`` and ``show``
        act from the next step on, by numbers; each replaces what held or loaded the component before. Checkpoints and run
        files keep them.
        """
        for component in components:
            if not isinstance(component, str):
                raise TypeError(f"fix takes names of components, as in fix('x', 'y'), got {shown(component)}.")
        return self._state_changes(DRIVEN, self._to_drive("fix", dict.fromkeys(components or self.components, 0.0)))

    @named_arguments
    def impose_velocity(self, **components: Prescribed) -> Body:
        """Drive components x, y, z [m/s], spin … [rad/s] by a number or a function of time [s]. Returns the body."""
        return self._state_changes(DRIVEN, self._to_drive("impose_velocity", components))

    @named_arguments
    def impose_force(self, **components: Prescribed) -> Body:
        """Free components and load them: x, y, z [N], spin … [N m], numbers or functions of time [s]. Returns the body."""
        return self._state_changes(LOADED, self._to_load("impose_force", components))

    def impose_pressure(self, pressure: Prescribed) -> NoReturn:
        """TypeError: a membrane takes a pressure, in 2D a chain with a surface; a body takes forces."""
        raise TypeError(
            f"{self!r} takes no pressure: impose_pressure is for membranes, and in 2D for chains with a surface. Load it "
            "with impose_force, by the pressure times its area."
        )

    def free(self, *components: str) -> Body:
        """Let go of the named components, without names of all: nothing drives or loads them. Returns the body.

        A wall, whose components are held unless loaded, is loaded by nothing from then on, and needs a mass for it.
        """
        for component in components:
            if not isinstance(component, str):
                raise TypeError(f"free takes names of components, as in free('x', 'y'), got {shown(component)}.")
        names = components or self.components[: self.dimension if self.held_by_default else None]
        nothing = dict.fromkeys(names, 0.0)
        if self.held_by_default:  # a load of nothing takes the place of a drive
            return self._state_changes(LOADED, self._to_load("free", nothing))
        return self._state_changes(FREE, self._checked("free", nothing))

    def hide(self) -> Body:
        """Take the body away: it touches nothing, moves nowhere, and is in no picture, until ``show``. Returns the body.

        Its velocity is zero from then on. A body of a chain cannot be hidden (ValueError when the scene is compiled;
        between steps, here).
        """
        self._state_change(HIDDEN, -1, 0.0)
        return self

    def show(self) -> Body:
        """Put a hidden body back where it is, at rest. Returns the body."""
        self._state_change(SHOWN, -1, 0.0)
        return self

    @property
    def hidden(self) -> bool:
        """Whether the body is hidden."""
        return self._hidden

    def _to_drive(self, call: str, components: Mapping[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        """Components that are to be driven, checked, with their values."""
        checked = self._checked(call, components)
        for component, _ in checked:
            if component in self._forces and self._state is None:
                raise ValueError(self._twice(component, "loaded by impose_force", "driven"))
        return checked

    def _to_load(self, call: str, components: Mapping[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        """Components that are to be loaded, or freed by a load of nothing, checked, with their values."""
        checked = self._checked(call, components)
        for component, _ in checked:
            if component in self._velocities and self._state is None and call != "free":
                raise ValueError(self._twice(component, "driven by impose_velocity or fix", "loaded"))
            if not np.isfinite(self.mass if component < self.dimension else self.inertia).all():
                raise ValueError(
                    f"{self!r} has no {'mass' if component < self.dimension else 'inertia'}: give it one where it is made, "
                    f"so that a load on {self.components[component]} can move it."
                )
        return checked

    def _state_changes(self, kind: int, checked: list[tuple[int, Prescribed]]) -> Body:
        """Make a statement on several components, whose values are checked: if one is refused, none changes."""
        for component, value in checked:
            self._state_change(kind, component, value)
        return self

    def _state_change(self, kind: int, component: int, value: Prescribed) -> None:
        """Make a statement; between the steps of a simulation it is kept."""
        if self._state is not None:
            if self._id in self._state.chained and kind == HIDDEN:
                raise ValueError(f"{self!r} is linked in a chain, which would be cut: a body of a chain cannot be hidden.")
            self._state.keep(kind, self._id, component, float(value))  # type: ignore[arg-type]
        self._take(kind, component, value)

    def _take(self, kind: int, component: int, value: Prescribed) -> None:
        """Apply a statement to the conditions of the body."""
        if kind in (HIDDEN, SHOWN):
            self._hidden = kind == HIDDEN
            return
        others = [{k: v for k, v in held.items() if k != component} for held in (self._velocities, self._forces)]
        if kind != FREE:
            others[kind == LOADED][component] = value
        self._velocities, self._forces = others

    def _twice(self, component: int, already: str, now: str) -> str:
        return (
            f"Component {self.components[component]} of {self!r} is {already} already and cannot be {now} as well: "
            "choose one of the two."
        )

    def _checked(self, call: str, components: Mapping[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        if not components:
            raise TypeError(f"{call} needs a component, for example {call}(y=0.0).")
        checked: list[tuple[int, Prescribed]] = []
        for name, value in components.items():
            if name not in self.components:
                hint = closest(name, self.components)
                raise ValueError(f"{call}: a body in {self.dimension}D has no component '{name}'{hint}")
            value = value if callable(value) else number(value, f"{call}({name}=...)")
            if callable(value) and self._state is not None:
                raise RuntimeError(
                    f"{call}({name}=...) between steps takes numbers, which a run file keeps: impose functions of time "
                    "before the Simulation is made, or change numbers step by step in on_step."
                )
            checked.append((self.components.index(name), value))
        return checked

    def _refuse_compiled(self, what: str) -> None:
        if self._state is not None:
            raise RuntimeError(f"{self!r} is in a compiled scene, which cannot be edited: {what} before Simulation.")

    def __repr__(self) -> str:
        which = f"body {self.id}" if self.id >= 0 else "body not yet in a scene"
        position = ", ".join(f"{x:g}" for x in self.position)
        return f"<{type(self).__name__} '{self.color}', {which}, at ({position}) m>"


def dimension_of(position: Any) -> int:
    """3 for a position of three numbers, else 2."""
    return 3 if hasattr(position, "__len__") and getattr(position, "shape", None) != () and len(position) == 3 else 2


def unit_quaternion(rotation: Any, what: str) -> np.ndarray:
    """The quaternion (q_x, q_y, q_z, q_w) of a rotation in space, (4,); TypeError or ValueError with a sentence."""
    if hasattr(rotation, "as_quat"):
        given = np.asarray(rotation.as_quat(), dtype=float)
        if given.shape != (4,):
            raise ValueError(f"rotation of a {what} must be one rotation, got {shown(rotation)} of {len(given)}.")
        return given
    if not isinstance(rotation, (tuple, list, np.ndarray)):
        raise TypeError(
            f"rotation of a {what} in 3D must be a scipy.spatial.transform.Rotation or the four numbers of a unit "
            f"quaternion, got {shown(rotation)}."
        )
    if np.shape(rotation) != (4,):
        raise ValueError(
            f"rotation of a {what} must be a scipy.spatial.transform.Rotation or four numbers (q_x, q_y, q_z, q_w), got "
            f"{shown(rotation)}. Rotation.from_matrix and Rotation.from_euler make one."
        )
    given = vector(rotation, f"rotation of a {what}", 4)
    length = float(np.linalg.norm(given))
    if not abs(length - 1.0) < 1e-6:
        raise ValueError(f"rotation of a {what} must be a quaternion of length one, got {shown(given.tolist())}.")
    return given if abs(length - 1.0) <= 4.0 * np.finfo(float).eps else given / length  # the bits of a file


def principal_inertias(inertia: Any, what: str) -> Any:
    """Moments of inertia in space [kg m^2]: one number, or three that a body can have."""
    if np.ndim(inertia) == 0:
        return number(inertia, f"inertia of a {what}", above=0.0, unit="kg m^2")
    three = vector(inertia, f"inertia of a {what}", 3)
    if not (three > 0.0).all():
        raise ValueError(f"inertia of a {what} must be numbers above 0 [kg m^2], got {shown(three.tolist())}.")
    if 2.0 * three.max() > three.sum() * (1.0 + 1e-9):
        raise ValueError(
            f"inertia of a {what} is {shown(three.tolist())} kg m^2, which no body has: none of the three moments is "
            "larger than the sum of the others."
        )
    return read_only(three)


@named_arguments
class RigidBody(Body):
    """A body of given mass and inertia with any contactors: a cluster of disks or spheres, or contactors that you define.

    ``contactors`` is a list of contactors, or of pairs (contactor, offset from the centre of mass along the axes of the
    body [m]). In 3D ``inertia`` [kg m^2] is three numbers, about the axes of the body, which are its principal axes, or one
    if it is the same about each. :func:`lmgcpy.clump` finds mass, centre and axes of spheres or disks.
    """

    def __init__(self, contactors: list, *, mass: float, inertia: Any, **start: Any):
        self.dimension = dimension_of(start.get("position"))
        super().__init__(**{"color": "GRAIN", **start})
        if not isinstance(contactors, (list, tuple)) or not contactors:
            raise TypeError(f"A rigid body needs a list of at least one contactor, got {shown(contactors)}.")
        self._contactors: list[tuple[Contactor, tuple[float, ...]]] = []
        for item in contactors:
            contactor, offset = item if isinstance(item, tuple) and len(item) == 2 else (item, (0.0,) * self.dimension)
            if not isinstance(contactor, Contactor):
                raise TypeError(f"contactors must be Contactor objects or pairs (contactor, offset), got {shown(item)}.")
            self._refuse_other_dimension(contactor)
            self._contactors.append((contactor, tuple(vector(offset, "offset of a contactor", self.dimension).tolist())))
        self._mass = number(mass, "mass of a rigid body", above=0.0, unit="kg")
        if self.dimension == 2:
            inertia = number(inertia, "inertia of a rigid body", above=0.0, unit="kg m^2")
        self._inertia = principal_inertias(inertia, "rigid body")

    def _refuse_other_dimension(self, contactor: Contactor) -> None:
        """ValueError for a contactor that is for scenes of the other dimension, or never turns."""
        flat, unturned = (DiskContactor, WallContactor), (PlaneContactor, CylinderContactor)
        if isinstance(contactor, unturned):
            raise ValueError(f"contactors of a rigid body turn, and {contactor!r} does not: make it a wall of its own.")
        if isinstance(contactor, flat if self.dimension == 3 else SpatialContactor):
            raise ValueError(
                f"contactors of a rigid body whose position has {self.dimension} numbers cannot be {contactor!r}, which is "
                "for scenes of the other dimension."
            )

    @property
    def mass(self) -> float:
        return self._mass

    @property
    def inertia(self) -> Any:
        return self._inertia

    @property
    def turns(self) -> bool:
        return self.dimension == 3

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return self._contactors


class Round(Body):
    """A disk or a sphere. Subclasses give the contactor, the volume, and the ratio of inertia to mass."""

    __slots__ = ("_material",)

    noun: str
    """Name of the shape in error messages."""

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
            raise TypeError(f"material of a {self.noun} must be a lmgcpy.Material, got {shown(material)}.")
        if mass is None and material is None:
            raise TypeError(f"A {self.noun} needs a material= or a mass= [kg].")
        if mass is None:
            assert material is not None
            mass = material.density * self.volume(self.radius)
        own[MASS] = number(mass, f"mass of a {self.noun}", above=0.0, unit="kg")
        inertia = own[MASS] * self.turning(self.radius) if inertia is None else inertia
        own[INERTIA] = number(inertia, f"inertia of a {self.noun}", above=0.0)
        self._material = material

    @staticmethod
    @abstractmethod
    def _shape(radius: float) -> Any:
        """The contactor of that radius [m]."""

    @staticmethod
    @abstractmethod
    def volume(radius: float) -> float:
        """Volume of a body of that radius [m^3], or its area in 2D [m^2]."""

    @staticmethod
    @abstractmethod
    def turning(radius: float) -> float:
        """Ratio of its inertia to its mass [m^2]."""

    @property
    def material(self) -> Material | None:
        """The material, or None if the body was made from its mass."""
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
        """The contactor, made at each call to save memory."""
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
    """A disk. ``mass`` [kg] overrides the mass from the material, and ``inertia`` [kg m^2] overrides m R^2/2."""

    __slots__ = ()

    noun = "disk"
    _shape = DiskContactor

    volume = staticmethod(disk_area)

    @staticmethod
    def turning(radius: float) -> float:
        """R^2/2, the ratio of its inertia to its mass [m^2]."""
        return disk_second_moment(radius) / disk_area(radius)


class Boundary(Body):
    """A wall or a hollow cylinder. It never turns, has no weight, and its components are held unless loaded."""

    position_argument = "point"
    GIVES = ("position",)
    noun: str
    """Name of the shape in error messages."""
    _contactor: Any

    def __init__(self, *, point: Any, mass: float | None, **start: Any):
        super().__init__(position=point, **start)
        self._mass = math.inf if mass is None else number(mass, f"mass of a {self.noun}", above=0.0, unit="kg")

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


@named_arguments
class Wall(Boundary):
    """The half-space behind a line, or behind a plane in 3D. A wall never turns; its components are held unless loaded."""

    noun = "wall"

    def __init__(self, *, point: Any, normal: Any, mass: float | None = None, **start: Any):
        self.dimension = dimension_of(point)
        super().__init__(point=point, mass=mass, **start)
        self._contactor = WallContactor(normal) if self.dimension == 2 else PlaneContactor(normal)

    @property
    def normal(self) -> np.ndarray:
        """Outward unit normal, (d,)."""
        return self._contactor.normal

    def _checked(self, call: str, components: Mapping[str, Prescribed]) -> list[tuple[int, Prescribed]]:
        turns = [name for name in components if name in self.components[self.dimension :]]
        if turns and (call in ("impose_force", "free") or any(components[name] != 0.0 for name in turns)):
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
    """The half-space behind the line, or the plane in 3D, through ``point`` [m] with the outward ``normal``.

    A wall that is to be loaded needs a ``mass`` [kg].
    """
    return Wall(point=point, normal=normal, color=color, mass=mass)
