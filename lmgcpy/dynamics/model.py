"""A compiled scene: a frozen model, and the state of its bodies, which changes with time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, ContactorTable, JointTable, VisibilityRow
from lmgcpy.contact.lattice import Lattice
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.changes import Change, law_values
from lmgcpy.dynamics.drag import Drag
from lmgcpy.dynamics.loads import ManyForces, Pressure, at_time
from lmgcpy.dynamics.rotation import with_rotations
from lmgcpy.errors import number, vector
from lmgcpy.laws import Law

COMPONENTS = {2: ("x", "y", "spin"), 3: ("x", "y", "z", "spin_x", "spin_y", "spin_z")}
"""Components of a body's velocity by dimension."""


@dataclass(frozen=True)
class Drive:
    """A velocity imposed on one component of a body, or a force on it: a number or a function of time."""

    body: int
    component: int
    value: float | Callable[[float], float]
    dimension: int = 2

    def at(self, time: float) -> float:
        """Value at a time [s].

        Raises RuntimeError if a user's function fails, TypeError if it gives no number, and FloatingPointError if the
        number is not finite.
        """
        if not callable(self.value):
            return self.value
        component = COMPONENTS[self.dimension][self.component]
        which = f"of time imposed on component {component} of body {self.body} at t = {time:g} s"
        return at_time(self.value, time, which, number)


@dataclass(frozen=True)
class Model:
    """Frozen description of a scene; n bodies, d dimensions, k components of a velocity."""

    dimension: int
    mass: np.ndarray
    """Mass or inertia by component [kg, kg m^2], (n, k); infinite if no mass was needed."""
    inverse_mass: np.ndarray
    """Inverse of the mass, zero if the component is driven, (n, k)."""
    radius: np.ndarray
    """Distance from the centre to the surface along a link [m], (n,); zero for bodies that are no disks or spheres."""
    extent: np.ndarray
    """Radius of a circle around the centre that holds the body [m], infinite for walls, (n,)."""
    wall_normals: dict[int, np.ndarray]
    """Outward normals of the walls by row of the body, (d,)."""
    gravity: np.ndarray | Callable[[float], np.ndarray]
    """Acceleration of gravity [m/s^2], (d,), or a function of time that gives it."""
    heavy: np.ndarray
    """Whether gravity acts on a body, (n,) bool."""
    contactors: ContactorTable
    rows: list[VisibilityRow]
    chains: list[ChainTable]
    apart: np.ndarray
    """Linked neighbours that do not collide, (p, 2) int64: rows of the bodies, the lower first, sorted."""
    velocities: list[Drive]
    """Imposed velocities."""
    forces: list[Drive]
    """Imposed forces."""
    loads: list[ManyForces | Pressure]
    """Forces on many bodies, and pressures on surfaces."""
    start: BodyState
    """State of the bodies at the beginning."""
    hidden: np.ndarray
    """Whether a body is hidden, (n,) bool."""
    cell: CellMotion | None = None
    """The periodic cell, if there is one."""
    drag: Drag | None = None
    """The drag of a medium, if there is one."""
    joints: list[JointTable] = field(default_factory=list)
    """The joints, those of one law in one table."""
    earlier: list[ChainTable] | None = None
    """The chains before statements gave them other reference gaps or laws, for the step from the time ``drawn``."""
    drawn: float = -np.inf
    """Time of those statements [s]."""

    @property
    def turning(self) -> np.ndarray:
        """Rows of the bodies that keep a rotation in space, ascending, (t,) int64."""
        return self.start.turning

    @property
    def lattice(self) -> Lattice | None:
        """The lattice of the periodic cell, if there is one."""
        return None if self.cell is None else self.cell.lattice

    def cell_in_step(self, *velocities: np.ndarray) -> CellMotion | None:
        """The periodic cell if it may deform in a step with these velocities (n, k)."""
        return self.cell if self.cell is not None and self.cell.deforms(self.inverse_mass, *velocities) else None

    @property
    def size(self) -> np.ndarray:
        """Size of the smallest contactor of each body [m], (n,), infinite for walls. Displacements are
        compared with it."""
        size = np.full(len(self.mass), np.inf)
        np.minimum.at(size, self.contactors.body, self.contactors.size)
        return size

    @cached_property
    def links(self) -> list[ChainTable]:
        """The chains, then the joints."""
        return [*self.chains, *self.joints]

    @cached_property
    def passive(self) -> frozenset[str]:
        """Names of the laws that promise to give no energy but the energy that they store."""
        laws = [row.law for row in self.rows] + [table.law for table in self.links]
        return frozenset(law.NAME for law in laws if {"dissipative", "potential"} & law.TRAITS or law.energy is not None)

    @cached_property
    def drawn_until(self) -> float:
        """Time until which links are drawn to their reference [s]."""
        return max([0.0, *(chain.relaxation for chain in self.chains)])

    @cached_property
    def free_mass(self) -> np.ndarray:
        """Mass or inertia by component [kg, kg m^2], (n, k), zero if driven."""
        return np.where(self.inverse_mass > 0.0, self.mass, 0.0)

    @cached_property
    def driven(self) -> np.ndarray:
        """Components that are driven, as indices into flat arrays (n, k)."""
        return np.flatnonzero(self.inverse_mass == 0.0)

    @cached_property
    def imposed(self) -> np.ndarray:
        """Components with imposed velocities, as indices into flat arrays (n, k)."""
        width = self.mass.shape[1]
        return np.array([drive.body * width + drive.component for drive in self.velocities], dtype=np.int64)

    def imposed_at(self, time: float) -> np.ndarray:
        """Velocities of these components at a time [s]; raises errors as :meth:`Drive.at`."""
        if self._imposed_for_good is not None:
            return self._imposed_for_good
        return np.array([drive.at(time) for drive in self.velocities], dtype=float)

    @cached_property
    def _imposed_for_good(self) -> np.ndarray | None:
        """Their velocities if none changes with time, else None."""
        values = [drive.value for drive in self.velocities if not callable(drive.value)]
        return np.array(values, dtype=float) if len(values) == len(self.velocities) else None

    @cached_property
    def bounded(self) -> np.ndarray:
        """Whether a body is neither a wall nor an edge of a periodic cell, (n,) bool."""
        bounded = np.isfinite(self.extent)
        if self.cell is not None:
            bounded[self.cell.lattice.rows] = False
        return bounded

    @cached_property
    def linked(self) -> np.ndarray:
        """Whether a body is in a chain, (n,) bool."""
        linked = np.zeros(len(self.mass), dtype=bool)
        for chain in self.links:
            linked[chain.bodies] = True
        return linked

    @cached_property
    def nodes(self) -> np.ndarray:
        """Whether a body is a node of a surface and has no shape of its own, (n,) bool."""
        nodes, table = np.zeros(len(self.mass), dtype=bool), self.contactors
        if table.elements is not None:
            nodes[table.elements.corner] = True
            nodes[np.delete(table.body, np.r_[table.elements.rows])] = False
        return nodes

    @cached_property
    def threaded(self) -> np.ndarray:
        """Whether a body is such a node and has segments in space only, of threads and nets, (n,) bool."""
        threaded, elements = self.nodes.copy(), self.contactors.elements
        if elements is not None:
            sheets = elements.count == 3 if self.dimension == 3 else np.ones(len(elements.count), dtype=bool)
            threaded[elements.corner[sheets]] = False
        return threaded

    @cached_property
    def movable_mass(self) -> np.ndarray:
        """Mass [kg], (n,), infinite if the body is held in all directions."""
        d = self.dimension
        return np.where((self.inverse_mass[:, :d] > 0.0).any(axis=1), self.mass[:, :d].min(axis=1), np.inf)

    @cached_property
    def spread(self) -> float:
        """Greatest movable mass of a bounded body over the least; 1 if there is none."""
        masses = self.movable_mass[self.bounded & np.isfinite(self.movable_mass)]
        return float(masses.max() / masses.min()) if len(masses) else 1.0

    @cached_property
    def weight(self) -> np.ndarray:
        """Force of gravity by component [N], (n, k), zero if driven; the force at t = 0 if gravity changes with time."""
        return self.weight_at(0.0)

    def weight_at(self, time: float) -> np.ndarray:
        """Force of gravity by component at a time [N], (n, k), zero if driven; raises the errors of the function."""
        gravity = self.gravity_at(time)
        weight = np.zeros_like(self.mass)
        for axis in np.flatnonzero(gravity):
            falls = self.heavy & (self.inverse_mass[:, axis] > 0.0)
            weight[:, axis] = np.where(falls, self.mass[:, axis] * gravity[axis], 0.0)
        return weight

    def gravity_at(self, time: float) -> np.ndarray:
        """Acceleration of gravity at a time [m/s^2], (d,); raises errors as :meth:`Drive.at`."""
        return at_time(self.gravity, time, f"gravity(t = {time:g} s)", partial(vector, size=self.dimension))

    def force(self, loads: list[tuple[Drive, float]], positions: np.ndarray, time: float) -> np.ndarray:
        """External forces on the free components at a time [N], (n, k): gravity, the ``loads``, each with its value, and
        those on many bodies at these positions (n, w)."""
        weight = self.weight_at(time) if callable(self.gravity) else self.weight
        force = weight.copy() if loads or self.loads else weight
        for load, value in loads:
            force[load.body, load.component] += value
        for many in self.loads:
            many.add_to(force, positions[:, : self.dimension], time)
        if self.loads:
            force[self.inverse_mass == 0.0] = 0.0
        return force

    def __repr__(self) -> str:
        return (
            f"<Model in {self.dimension}D: {len(self.mass)} bodies, {len(self.rows)} rows of the visibility table, "
            f"{len(self.chains)} chains>"
        )


@dataclass
class BodyState:
    """State of the bodies: positions (n, 3 or 7), velocities (n, k), and the time [s].

    In 2D (x, y, angle) [m, m, rad] and (v_x, v_y, spin); in 3D (x, y, z) and three components of the spin more. If bodies
    keep a rotation, positions have four numbers more, the quaternion (``lmgcpy/contact/positions.py``); the spins of such
    bodies are along their own axes, and others have the axes of space.
    """

    positions: np.ndarray
    velocities: np.ndarray
    time: float = 0.0
    changes: list[Change] = field(default_factory=list)
    """Statements between steps so far."""
    steps: int = 0
    """Number of steps so far."""
    turning: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    """Rows of the bodies that keep a rotation in space, (t,)."""
    stale: bool = False
    """Whether statements were made that the model does not know yet."""
    chained: frozenset[int] = frozenset()
    """Rows of the bodies that are in chains."""
    recorded: bool = False
    """Whether the next step goes into a file, which holds one time step, one solver, and one number of bodies."""
    reaction: Callable[[int], Any] | None = None
    """Reaction of a body in the last step, by its row; of the simulation that has this state."""
    overlap: str = "ignore"
    """Answer to added bodies that overlap others, see :class:`lmgcpy.Simulation`."""

    def keep(self, kind: int, body: int, component: int, value: float) -> None:
        """Keep a statement between steps, see :class:`~lmgcpy.dynamics.changes.Change`."""
        self.changes.append(Change(self.steps, kind, body, component, value))
        self.stale = True

    def keep_law(self, kind: int, index: int, law: Law) -> None:
        """Keep the statement that a row of the visibility table, or a chain, has a law."""
        for component, value in law_values(law):
            self.keep(kind, index, component, value)

    def refuse_recorded(self, what: str) -> None:
        """RuntimeError if steps are recorded: a file holds only one ``what``."""
        if self.recorded:
            raise RuntimeError(
                f"{what} cannot change in a run that is recorded, as its file holds one "
                f"{what.removeprefix('The ').replace('_', ' ')}: end the run, change it, and record into another file."
            )

    def with_those_of(self, laid: BodyState) -> BodyState:
        """These bodies, followed by the further bodies of another state."""
        count, before = len(self.positions), self.positions
        if before.shape[1] < laid.positions.shape[1]:
            before = with_rotations(before)
        positions = np.concatenate([before, laid.positions[count:]])
        velocities = np.concatenate([self.velocities, laid.velocities[count:]])
        return BodyState(positions, velocities, self.time, turning=laid.turning)

    def grow(self, laid: BodyState) -> None:
        """Append the further bodies of another state."""
        both = self.with_those_of(laid)
        self.positions, self.velocities, self.stale = both.positions, both.velocities, True
        self.turning = both.turning

    def copy(self) -> BodyState:
        """An independent copy."""
        return BodyState(self.positions.copy(), self.velocities.copy(), self.time, turning=self.turning)

    def __repr__(self) -> str:
        return f"<BodyState of {len(self.positions)} bodies at t = {self.time:g} s>"
