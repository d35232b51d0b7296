"""Surfaces between bodies: threads and nets of segments, membranes of triangles. Bodies without a shape are their nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from lmgcpy.contact.elements import SkinTable
from lmgcpy.contact.features import places_of, topology
from lmgcpy.dynamics.loads import Pressure, area_vectors
from lmgcpy.errors import named_arguments, number, read_only, shown
from lmgcpy.scene.body import AT_REST, Body, dimension_of
from lmgcpy.scene.cell import Cell
from lmgcpy.scene.contactor import Contactor


@named_arguments
@dataclass(frozen=True)
class Thread:
    """The surface of a chain or a net: round, of this ``radius`` [m], around the segments between its nodes. The visibility
    table names it by its ``color``."""

    radius: float
    color: str = field(default="THREAD", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", number(self.radius, "radius of a thread", above=0.0, unit="m"))
        if not isinstance(self.color, str) or not self.color:
            raise TypeError(f"color of a thread must be a word such as 'THREAD', got {shown(self.color)}.")


class Skin:
    """A surface between bodies: segments or triangles, ``cells``, with a radius [m]. Chains, nets and membranes have one.

    ``bodies``: its nodes; ``cells``: corners of the cells as indices of these, (m, 2) or (m, 3).
    """

    def __init__(self, bodies: Sequence[Body], cells: Any, thread: Thread, *, settled: bool = False):
        """ValueError, with the nodes, for cells whose nodes are nearer to each other than the thickness, and for triangles
        whose height is below it, unless steps of a run have made them so, ``settled``."""
        self.bodies = list(bodies)
        self.cells = read_only(np.array(cells, dtype=np.int64))
        self.radius, self.color = thread.radius, thread.color
        self._pressure: float | Callable[[float], float] | None = None
        self._cell: Cell | None = None
        self._settled = settled
        self._refuse_crowded()
        self._net = topology(self.cells, len(self.bodies), dimension=self.dimension)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.bodies[0].dimension

    @property
    def is_net(self) -> bool:
        """Whether its cells are segments in space, which have no sides."""
        return self.cells.shape[1] < self.dimension

    @property
    def pressure(self) -> float | Callable[[float], float] | None:
        """The pressure on it [Pa], a number or a function of time [s]; None for none."""
        return self._pressure

    @property
    def table(self) -> SkinTable:
        """The surface as the detection knows it."""
        return SkinTable(np.array([body.id for body in self.bodies], dtype=np.int64), self._net, self.radius, self.color)

    def impose_pressure(self, pressure: float | Callable[[float], float]) -> Skin:
        """Press on the side to which the normals point, with ``pressure`` [Pa], in 2D [N/m]: a number or a function of time
        [s]. Returns the surface. Neighbours must have their normals on the same side (ValueError).

        Normals are those of the right-hand rule around the corners of a triangle; in 2D they point to the left of the
        chain's direction. The forces follow the surface as it moves and deforms. A periodic cell must be held
        (ValueError).
        """
        if self.is_net:
            raise TypeError("A thread or net in space has no side on which a pressure could act: give it to a membrane.")
        self._refuse_two_sides()
        if any(body._state is not None for body in self.bodies):
            raise RuntimeError("A pressure is imposed before Simulation: if it changes, give a function of time.")
        checked = pressure if callable(pressure) else number(pressure, "pressure on a surface", unit="Pa")
        if self._cell is not None:
            self._cell.refuse_pressure()
        self._pressure = checked
        return self

    @property
    def load(self) -> Pressure | None:
        """The load of the pressure, None if there is none."""
        if self.pressure is None:
            return None
        lattice = None if self._cell is None else self._cell.lattice
        return Pressure(np.array([body.id for body in self.bodies])[self.cells], self.pressure, lattice)

    def lie_in(self, cell: Cell) -> None:
        """Lie between the nearest images in a periodic cell."""
        self._cell = cell
        self._refuse_crowded()
        if self.pressure is not None:
            cell.refuse_pressure()

    def _refuse_crowded(self) -> None:
        if self._settled:
            return
        crossed = None if self._cell is None else partial(self._cell.lattice.crossed, edges=self._cell.edges)
        places = places_of(np.array([body.position for body in self.bodies]), self.cells, crossed)
        sides = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2)
        shortest = sides.min(axis=1)
        i = int(np.argmin(shortest))
        if not shortest[i] > 2.0 * self.radius:
            who = " and ".join(map(repr, (self.bodies[k] for k in self.cells[i].tolist())))
            raise ValueError(
                f"Cell {i} of a surface, between {who}, has nodes {shortest[i]:.3g} m apart, closer than its thickness of "
                f"{2.0 * self.radius:.3g} m: take fewer nodes or a smaller radius."
            )
        if self.cells.shape[1] < 3:
            return
        height = 2.0 * np.linalg.norm(area_vectors(places), axis=1) / sides.max(axis=1)
        i = int(np.argmin(height))
        if not height[i] > 2.0 * self.radius:
            who = " and ".join(map(repr, (self.bodies[k] for k in self.cells[i].tolist())))
            raise ValueError(
                f"Triangle {i} of a membrane, between {who}, has a height of {height[i]:.3g} m, less than its thickness of "
                f"{2.0 * self.radius:.3g} m: leave it out, move a body, or take a smaller radius."
            )

    def _refuse_two_sides(self) -> None:
        """ValueError if the normals of two neighbours are on different sides of the surface: two triangles pass their edge
        in opposite directions, in 2D a segment begins at the end of the other one."""
        net = self._net
        inner = (net.facets_of >= 0).all(axis=1)
        facets, places = net.facets_of[inner], net.places[inner]
        first = places if self.dimension == 2 else net.facets[facets, (places + 1) % 3]
        wrong = first[:, 0] == first[:, 1]
        if wrong.any():
            one, other = facets[int(np.argmax(wrong))].tolist()
            raise ValueError(
                f"The normals of the cells {one} and {other} of a surface are on different sides of it: change the order "
                "of the corners of one, so that a pressure acts on one side."
            )

    def __repr__(self) -> str:
        kind = "triangles" if self.cells.shape[1] == 3 else "segments"
        size = f"{len(self.cells)} {kind} between {len(self.bodies)} bodies, radius {self.radius:g} m"
        return f"<Skin '{self.color}' of {size}>"


class Net:
    """Links along edges between bodies, with a surface: a net or a membrane. ``Scene.net`` and ``Scene.membrane`` make it.

    Links are those of several chains, each along a path of edges, so that a solver has few groups of links.
    """

    def __init__(self, bodies: Sequence[Body], edges: np.ndarray, chains: list[Any], skin: Skin | None):
        self.bodies, self.chains, self.skin = list(bodies), chains, skin
        self.edges = edges
        """Indices of the two bodies of each link, (e, 2), in the order of reference gaps: of a net as given."""

    def impose_pressure(self, pressure: float | Callable[[float], float]) -> Net:
        """Press on one side of a membrane, see :meth:`Skin.impose_pressure`. Returns the net."""
        if self.skin is None:
            raise TypeError("A net without a surface has no side on which a pressure could act.")
        self.skin.impose_pressure(pressure)
        return self

    def __repr__(self) -> str:
        return f"<Net of {len(self.edges)} links between {len(self.bodies)} bodies, {self.skin!r}>"


def paths(edges: np.ndarray, count: int) -> list[list[int]]:
    """Paths that together go through each of the edges (e, 2) between ``count`` nodes once, and through no node twice.

    A path goes straight on where it can: it begins where it finds an edge and takes edges until it would meet itself.
    """
    left: list[dict[int, None]] = [{} for _ in range(count)]
    for a, b in edges.tolist():
        left[a][b] = left[b][a] = None
    found = []
    for start in sorted(range(count), key=lambda k: len(left[k]) % 2 == 0):  # from odd nodes first, where a path must end
        while left[start]:
            path, seen, here = [start], {start}, start
            while (onward := next((k for k in left[here] if k not in seen), None)) is not None:
                del left[here][onward], left[onward][here]
                path.append(onward)
                seen.add(onward)
                here = onward
            found.append(path)
    return found


@named_arguments
class PointMass(Body):
    """A node of a thread, net or membrane: it has a mass, but no shape of its own and no spin."""

    extent = 0.0

    def __init__(self, *, position: Any, mass: float, color: str = "NODE", velocity: Any = AT_REST):
        self.dimension = dimension_of(position)
        super().__init__(position=position, color=color, velocity=velocity)
        self._mass = number(mass, "mass of a point mass", above=0.0, unit="kg")

    @property
    def mass(self) -> float:
        return self._mass

    @property
    def inertia(self) -> float:
        """Nothing turns a point: any number would do."""
        return self._mass

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        return []


@named_arguments
def point_mass(*, position: Any, mass: float, color: str = "NODE", velocity: Any = None) -> PointMass:
    """A point of ``mass`` [kg] at ``position`` [m]: a node of a thread, see :class:`lmgcpy.Thread`. Others meet it only by
    the surfaces whose node it is."""
    velocity = AT_REST if velocity is None else velocity
    return PointMass(position=position, mass=mass, color=color, velocity=velocity)
