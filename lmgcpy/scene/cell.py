"""The periodic cell of a scene: its edges, and how it deforms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy.contact.lattice import Lattice
from lmgcpy.dynamics.changes import DRIVEN, LOADED
from lmgcpy.errors import AXES, closest, named_arguments, number, numbers, shown, vector
from lmgcpy.scene.body import AT_REST, Body, Prescribed
from lmgcpy.scene.contactor import Contactor, CylinderContactor, PlaneContactor, WallContactor


class Edge(Body):
    """An edge of a periodic cell, which :meth:`lmgcpy.Scene.periodic` makes.

    Its position is the vector along it [m]. Its velocity is the column of the velocity gradient that belongs to its axis
    [1/s], its mass the inertia of that column [kg m^2], and a load on it is a stress [Pa].
    """

    held_by_default = True
    gravity_acts = False
    extent = math.inf
    inertia = math.inf
    position_argument = "edge"

    def __init__(self, axis: int, edge: Any, *, mass: float | None = None, velocity: Any = AT_REST):
        self.dimension = len(edge)
        super().__init__(position=edge, color=f"EDGE_{AXES[axis].upper()}", velocity=velocity)
        self.axis = axis
        self._mass = mass
        self._cell: Cell | None = None

    @property
    def mass(self) -> float:
        if self._mass is not None:
            return self._mass
        return math.inf if self._cell is None else self._cell._mean_inertia(self.axis)

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return []

    def hide(self) -> Body:
        """An edge cannot be hidden (TypeError)."""
        raise TypeError(f"{self!r} cannot be hidden: the bodies would have no images.")

    def __repr__(self) -> str:
        return f"<Edge {AXES[self.axis]} of a periodic cell, ({', '.join(f'{x:g}' for x in self.position)}) m>"

PRESSED = (
    "a surface in this periodic cell is under pressure, and the cell would deform: the work of a pressure on the cell is "
    "not known if the surface goes on beyond its faces. Hold the cell, or leave out the pressure."
)


class Cell:
    """A periodic cell, made by :meth:`lmgcpy.Scene.periodic`: what leaves it on one side enters on the other.

    It deforms as a whole with the velocity gradient ``G_ab``, the change of the velocity along a with the position along b.
    Each component with a and b periodic is held at rest, driven (``impose_rate``), or yields to an imposed stress
    (``impose_stress``). Names of components are two axes, "xx", "xy" ...: "xy" is ``dv_x/dy``, simple shear.

    A cell that is sheared by 2 in a second:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2)
    >>> cell = scene.periodic(x=1.0, y=1.0).impose_rate(xy=2.0)
    >>> grain = scene.add(lm.disk(radius=0.1, position=(0.5, 0.5), mass=1.0))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.1)
    >>> cell.edges.round(9)
    array([[1. , 0. ],
           [0.2, 1. ]])
    """

    def __init__(self, dimension: int, bodies: list[Body], edges: list[Edge], surfaces: list[Any]):
        """``bodies``, ``surfaces`` between bodies: of the scene, those that it gets later as well."""
        self._dimension = dimension
        self._bodies, self._surfaces = bodies, surfaces
        self._edges = edges
        for edge in edges:
            edge._cell = self

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self._dimension

    @property
    def lattice(self) -> Lattice:
        """Rows of the edges among the bodies, and their axes."""
        rows, axes = ([getattr(edge, name) for edge in self._edges] for name in ("id", "axis"))
        return Lattice(np.array(rows, dtype=np.int64), np.array(axes, dtype=np.int64), self.dimension)

    @property
    def edges(self) -> np.ndarray:
        """Edges of the cell now [m], (p, d) for p periodic directions, a copy.

        A cell that is sheared on and on takes other edges of the same lattice, which lean less.
        """
        return np.array([edge.position for edge in self._edges])

    @property
    def rate(self) -> np.ndarray:
        """Velocity gradient G now [1/s], (d, d), a copy."""
        rate = np.zeros((self.dimension, self.dimension))
        for edge in self._edges:
            rate[:, edge.axis] = edge.velocity
        return rate

    @property
    def volume(self) -> float:
        """Volume now [m^3], per metre of depth in 2D; of a cell that is not periodic in all directions, the length or area
        between its faces [m, m^2]."""
        return self.lattice.volume(self.edges)

    def wrapped(self, positions: np.ndarray) -> np.ndarray:
        """The images of positions (m, d) that lie in the cell now [m]; positions of bodies go on beyond its faces."""
        points = numbers(positions, "positions")
        if points.ndim != 2 or points.shape[1] != self.dimension:
            raise ValueError(f"positions must have shape (m, {self.dimension}) [m], got {points.shape}.")
        return self.lattice.wrapped(points, self.edges)

    @named_arguments
    def impose_rate(self, **components: Prescribed) -> Cell:
        """Drive components of G [1/s], by numbers or functions of time [s]: ``impose_rate(xy=0.1)``. Returns the cell."""
        return self._impose("impose_rate", DRIVEN, components)

    @named_arguments
    def impose_stress(self, **components: Prescribed) -> Cell:
        """Let components of G yield to a stress [Pa], traction positive, by numbers or functions of time [s]:
        ``impose_stress(xx=-1e5, yy=-1e5)``. Returns the cell.

        At rest Weber's stress of the cell, ``lmgcpy.measure.stress``, is the imposed one; in motion it differs by the
        inertia of cell and bodies. Raises ValueError if the cell is not periodic in all directions: it has no volume that a
        stress could act on.
        """
        if len(self._edges) < self.dimension:
            raise ValueError(
                f"A stress acts on a cell that is periodic in all {self.dimension} directions; this one is so in "
                f"{len(self._edges)}: load its walls instead."
            )
        return self._impose("impose_stress", LOADED, components)

    def fix(self, *components: str) -> Cell:
        """Hold the named components of G at zero; without names, all of them. Returns the cell."""
        for component in components:
            if not isinstance(component, str):
                raise TypeError(f"fix takes names of components, as in fix('xx', 'xy'), got {shown(component)}.")
        return self._impose("fix", DRIVEN, dict.fromkeys(components or self._names(), 0.0))

    def _names(self) -> list[str]:
        """Names of the components that the cell has: the edges of a cell stay among its periodic axes."""
        return [AXES[along.axis] + AXES[edge.axis] for edge in self._edges for along in self._edges]

    def _impose(self, call: str, kind: int, components: dict[str, Any]) -> Cell:
        names = self._names()
        if not components:
            raise TypeError(f"{call} needs a component, for example {call}({names[0]}=0.0).")
        checked: list[tuple[Edge, list[tuple[int, Prescribed]]]] = []
        for name, value in components.items():
            if name not in names:
                raise ValueError(f"{call}: this cell has no component '{name}'{closest(name, names)}")
            if not callable(value):
                number(value, f"{call}({name}=...)")
            edge = next(edge for edge in self._edges if AXES[edge.axis] == name[1])
            check = edge._to_drive if kind == DRIVEN else edge._to_load
            checked.append((edge, check(call, {name[0]: value})))
        pressed = any(surface.pressure is not None for surface in self._surfaces)
        if pressed and (kind == LOADED or any(value != 0.0 for value in components.values())):
            raise ValueError(f"{call}: {PRESSED}")
        for edge, of_edge in checked:
            edge._state_changes(kind, of_edge)
        return self

    def refuse_pressure(self) -> None:
        """ValueError if the cell is told to deform: a surface in it bears no pressure then."""
        driven = (value for edge in self._edges for value in edge._velocities.values())
        if any(edge._forces for edge in self._edges) or any(callable(value) or value != 0.0 for value in driven):
            raise ValueError(f"impose_pressure: {PRESSED}")

    def _mean_inertia(self, axis: int) -> float:
        """Inertia of a column of G [kg m^2]: ``M width^2 / 12``, as if the mass M of all bodies but the hidden ones moved
        with the mean flow, spread evenly over the width of the cell."""
        bodies = [body for body in self._bodies if math.isfinite(body.extent) and not isinstance(body, Edge)]
        mass = sum(body.mass for body in bodies if not body.hidden)
        lattice = self.lattice
        start = np.array([edge._position[: self.dimension] for edge in self._edges])
        return mass * float(lattice.widths(start)[lattice.axes.tolist().index(axis)]) ** 2 / 12.0

    def keep_inertia(self) -> None:
        """Keep the inertia that the cell has, if it has any: bodies that come later would change its energy in motion."""
        for edge in self._edges:
            edge._mass = edge.mass or None

    def check(self) -> None:
        """ValueError if a body without bounds does not go on unchanged beyond the faces, or if a cell that yields has no
        inertia."""
        for edge in self._edges:
            if edge.mass == 0.0 and edge._forces:
                raise ValueError(
                    "The periodic cell yields to a stress, and no body has a mass from which its inertia would follow: add "
                    "bodies, or say periodic(inertia=...)."
                )
            if edge.mass == 0.0:  # nothing moves it
                edge._mass = math.inf
        for body in self._bodies:
            for contactor, _ in body.contactors:
                if math.isfinite(contactor.bounding_radius):
                    continue
                across = None
                if isinstance(contactor, (WallContactor, PlaneContactor)):
                    across = [abs(float(contactor.normal @ edge.position)) for edge in self._edges]
                elif isinstance(contactor, CylinderContactor):
                    along = [float(contactor.axis @ edge.position) * contactor.axis for edge in self._edges]
                    across = [float(np.linalg.norm(e.position - a)) for e, a in zip(self._edges, along, strict=True)]
                lengths = [float(np.linalg.norm(edge.position)) for edge in self._edges]
                if across is None or any(a > 1e-9 * length for a, length in zip(across, lengths, strict=True)):
                    raise ValueError(
                        f"{body!r} cuts the faces of the periodic cell: a body without bounds must look the same from "
                        "every image. Turn it along the periodic directions, or make the cell periodic in fewer."
                    )

    def __repr__(self) -> str:
        edges = "; ".join(", ".join(f"{x:g}" for x in edge) for edge in self.edges)
        return f"<Cell periodic along {', '.join(AXES[edge.axis] for edge in self._edges)}, edges ({edges}) m>"


def edge_vector(value: Any, axis: int, dimension: int) -> np.ndarray:
    """The edge (d,) of an axis that a user gave as a length or as a vector [m]."""
    name = f"edge {AXES[axis]} of a periodic cell"
    if np.ndim(value) == 0:
        edge = np.zeros(dimension)
        edge[axis] = number(value, name, above=0.0, unit="m")
        return edge
    edge = vector(value, name, dimension)
    if not edge[axis] > 0.0:
        raise ValueError(f"The {name} must go along {AXES[axis]}, got {shown(edge.tolist())}.")
    return edge
