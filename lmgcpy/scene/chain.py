"""Chains: wires and rods made of bodies, each linked to the next; in a periodic cell to its nearest image."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import Points
from lmgcpy.dynamics.changes import LINK_LAW, REFERENCE, gap_values
from lmgcpy.dynamics.model import BodyState
from lmgcpy.errors import closest, number, numbers, read_only, shown
from lmgcpy.laws import Law
from lmgcpy.laws.first_calls import check_answers
from lmgcpy.scene.body import Round
from lmgcpy.scene.cell import Cell
from lmgcpy.scene.contactor import DiskContactor, SphereContactor
from lmgcpy.scene.joint import Node, points_of
from lmgcpy.scene.skin import Skin

BLOW = 1e-6
"""Relative excess over the reference length from which a rigid link is refused at the start. Its bias would give the
bodies a velocity of that excess divided by the time step."""
COLLISION_GAP = 1e-3
"""Linked neighbours collide by default if the reference gap is above this part of the smaller radius. A taut wire holds the
gap at its reference, within the solver's tolerance, and a contact acts from a gap of zero. If both act at the same gap, the
link pulls and the contact pushes without bound."""


class Chain:
    """Bodies, each linked to the next: link i goes from ``bodies[i]``, antagonist, to ``bodies[i + 1]``, candidate.

    ``reference_gap`` [m], (links,), are gaps between surfaces. ``parameters`` are the parameters of the law that differ
    from link to link, (links,) each. Links act between centres or points of bodies, and carry no moment. ``settled``: rigid
    links may be off their reference by the errors that the steps of a run have left.

    A wire of ten links, 1 m long, that hangs from a hook:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> beads = [scene.add(lm.disk(radius=0.01, position=(0.0, -0.1 * i), mass=0.5)) for i in range(11)]
    >>> hook = beads[0].fix()
    >>> chain = scene.chain(beads, lm.RigidWire())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=10)
    >>> -sim.interactions.force[:, 0].round(9)  # tension, from the hook to the free end [N]
    array([50., 45., 40., 35., 30., 25., 20., 15., 10.,  5.])
    """

    def __init__(
        self,
        nodes: list[Node],
        law: Law,
        reference_gap: Any,
        *,
        relaxation: float = 0.0,
        closed: bool = False,
        neighbours_collide: bool | None = None,
        parameters: Mapping[str, Any] | None = None,
        settled: bool = False,
        cell: Cell | None = None,
    ):
        self.skin: Skin | None = None
        """The surface of the chain, None if only its bodies have one."""
        self._law = law
        self._cell = cell
        self._state: BodyState | None = None
        """State of the simulation that has compiled the scene."""
        self._number = -1
        """Number of the chain in that scene."""
        self.function: Callable[[float], Any] | None = reference_gap if callable(reference_gap) else None
        """Function of time [s] that gives the reference gaps, or None."""
        self.bodies = [node.body for node in nodes]
        self.nodes = list(nodes)
        """The bodies, each with the point at which links act."""
        self._nodes = nodes + nodes[:1] if closed else self.nodes
        self.closed = closed
        self.neighbours_collide = neighbours_collide
        self.relaxation = number(relaxation, "relaxation of a chain", minimum=0.0, unit="s")
        self.radius_sums = read_only(np.array([a.radius + b.radius for a, b in self._pairs()]))
        self._as_built = reference_gap is None
        self.start_gaps = read_only(self.lengths() - self.radius_sums)
        self._refuse_relaxation(self.function)
        if self.function is not None:
            self._gaps = self._gaps_of(self.function, 0.0)
        elif reference_gap is None:
            self._gaps = self.start_gaps.copy()
        else:
            given = numbers(
                reference_gap, "reference_gap", "a number [m], one number a link, a function of time [s], or None"
            )
            if given.shape not in ((), (1,), self.start_gaps.shape):
                raise ValueError(
                    f"reference_gap must be a number [m], {len(self.start_gaps)} numbers (one a link), a function of time "
                    f"or None, got {shown(reference_gap)}."
                )
            self._gaps = np.broadcast_to(given, self.start_gaps.shape).copy()
        self.parameters = self._of_each_link(parameters)
        self._refuse_no_length(self.start_gaps, "starts with no distance", "move one of them")
        self._refuse_no_length(self._gaps, "has no length at its reference", "give a larger reference_gap")
        self._settled = settled
        self.check_start()

    def _of_each_link(self, parameters: Mapping[str, Any] | None) -> dict[str, np.ndarray]:
        """Parameters of the law that differ from link to link, (links,) each."""
        if parameters is None:
            return {}
        if not isinstance(parameters, Mapping):
            raise TypeError(f"parameters are arrays by name, as {{'strength': [10.0, 20.0]}}, got {shown(parameters)}.")
        count, known, found = len(self.start_gaps), self._law.parameters(), {}
        for name, given in parameters.items():
            if name not in known:
                raise ValueError(f"parameters: law '{self._law.NAME}' has no {shown(name)}{closest(name, known)}")
            values = numbers(given, f"parameters['{name}']", f"{count} numbers [{known[name].unit}], one a link")
            if values.shape != (count,):
                raise ValueError(f"parameters['{name}'] must be {count} numbers, one a link, got {shown(given)}.")
            found[name] = read_only(values)
        self._refuse_links(self._law, found)
        return found

    def _refuse_links(self, law: Law, parameters: dict[str, np.ndarray]) -> None:
        """Raise the error of the first link whose own parameters the law does not take."""
        for i, of_link in enumerate(self._laws(law, parameters)):
            if isinstance(of_link, Exception):
                raise type(of_link)(f"Link {i} of the chain: {of_link}") from of_link

    def _laws(self, law: Law, parameters: dict[str, np.ndarray]) -> Iterator[Law | Exception]:
        """The law of each link, with its own parameters, or the error that these make."""
        for values in zip(*(column.tolist() for column in parameters.values()), strict=True):
            try:
                yield law.with_values(**dict(zip(parameters, values, strict=True)))
            except (TypeError, ValueError) as error:
                yield error

    @property
    def law(self) -> Law:
        """The law of the links. It may be set to a law of the same class with other parameters. Between the steps of a
        simulation, the new law acts from the next step on. The values that ``parameters`` gave each link stay."""
        return self._law

    @law.setter
    def law(self, law: Law) -> None:
        refuse_other_class(law, self._law, f"The law of {self!r}")
        check_answers(law, self.bodies[0].dimension)
        self._refuse_links(law, self.parameters)
        if self._state is not None:
            self._state.keep_law(LINK_LAW, self._number, law)
        self._law = law

    @property
    def laws(self) -> list[Law]:
        """The laws of the links: one that all share, or one each."""
        return [law for law in self._laws(self._law, self.parameters) if isinstance(law, Law)] or [self._law]

    def _pairs(self) -> list[tuple[Node, Node]]:
        return list(zip(self._nodes[:-1], self._nodes[1:], strict=True))

    def lengths(self) -> np.ndarray:
        """Current distances between the centres, or points, [m], (links,); in a periodic cell between nearest images."""
        branch = np.diff([node.place for node in self._nodes], axis=0)
        if self._cell is not None:
            branch = self._cell.lattice.shortened(branch, self._cell.edges)
        return np.array([np.linalg.norm(x) for x in branch])

    def impose_pressure(self, pressure: float | Callable[[float], float]) -> Chain:
        """Press on one side of a chain with a surface, in 2D; see :meth:`Skin.impose_pressure`. Returns the chain."""
        if self.skin is None:
            raise TypeError(
                "A chain without a surface has no side on which a pressure could act: make it with "
                "surface=lmgcpy.Thread(radius)."
            )
        self.skin.impose_pressure(pressure)
        return self

    def lie_in(self, cell: Cell) -> None:
        """Measure the chain in a periodic cell that came after it."""
        self._cell = cell
        self.start_gaps = read_only(self.lengths() - self.radius_sums)
        if self._as_built:
            self._gaps = self.start_gaps.copy()

    def check_cell(self, cell: Cell, gaps: np.ndarray) -> None:
        """ValueError for a link with one of these reference gaps (links,) that is no shorter than half the width of a cell:
        which images it joins is not known."""
        width = float(cell.lattice.widths(cell.edges).min())
        lengths = gaps + self.radius_sums
        i = int(np.argmax(lengths))
        if not lengths[i] < 0.5 * width:
            a, b = self._pairs()[i]
            raise ValueError(
                f"Link {i} of the chain, between {a!r} and {b!r}, is {lengths[i]:.3g} m long at its reference: a link "
                f"joins the nearest images and must be shorter than half the width of the periodic cell, {0.5 * width:.3g} "
                "m. Take more beads or a larger cell."
            )

    @property
    def reference_gap(self) -> np.ndarray:
        """Reference gaps [m], (links,), a copy. They may be set to one number or to one a link, also between the steps of
        a simulation: a winch, ``chain.reference_gap -= 1e-4``, draws a rope in by a little in every step. Before a
        simulation is made they may be set to a function of time [s] that gives them.

        A rigid link follows at once: drawn in by s before a step of h, its ends approach by s/h; the run warns if s is more
        than a tenth of its length. It must keep a length, and does not relax (ValueError). Before the simulation is made, a
        rigid link that would begin with a blow is refused as by :meth:`Scene.chain`.

        A step asks the function for the gaps of the next detection, ``(2 - theta) h`` after its beginning, as a law drives
        its link to these: links have the gap ``f(t)`` at each detection, and their ends the velocity ``f'(t)`` at the end
        of each step, both to O(h^2).
        """
        if self.function is None:
            return self._gaps.copy()
        return self._gaps_of(self.function, 0.0 if self._state is None else self._state.time)

    @reference_gap.setter
    def reference_gap(self, gaps: Any) -> None:
        self._refuse_relaxation(gaps)
        if callable(gaps):
            if self._state is not None:
                raise RuntimeError(
                    "reference_gap between steps takes numbers, which a run file keeps: give a function of time before the "
                    "Simulation is made, or change numbers step by step in on_step."
                )
            self._drive(gaps)
            return
        wanted = self._checked(gaps)
        if self._state is None:
            self._refuse_blows(wanted, wanted != self._gaps)
        self._as_built = False
        for link, gap in gap_values(wanted):
            new = link < 0 or self.function is not None or gap != self._gaps[link]
            if new and self._state is not None:
                self._state.keep(REFERENCE, self._number, link, gap)
        self._gaps, self.function = wanted, None

    def _drive(self, function: Callable[[float], Any]) -> None:
        """Take a function of time for the reference gaps; if it is wrong at the start, nothing changes."""
        self._gaps, self.function = self._gaps_of(function, 0.0), function
        self._as_built = False

    @property
    def gaps_in_time(self) -> Callable[[float], np.ndarray] | None:
        """The function of time that gives the reference gaps [m], (links,), with its answers checked; None for none."""
        return None if self.function is None else partial(self._gaps_of, self.function)

    def _gaps_of(self, function: Callable[[float], Any], time: float) -> np.ndarray:
        """Reference gaps that a function gives at a time [s], (links,). RuntimeError if the function fails, TypeError or
        ValueError if it gives gaps that no chain can have."""
        where = f"The function of time for reference_gap of {self!r} at t = {time:g} s"
        try:
            given = function(time)
        except Exception as error:
            raise RuntimeError(f"{where} failed with {shown(error)}: mend it.") from error
        try:
            return self._checked(given)
        except (TypeError, ValueError) as error:
            kind = TypeError if isinstance(error, TypeError) else ValueError
            raise kind(f"{where} gave what cannot be: {error}") from error

    def _checked(self, gaps: Any) -> np.ndarray:
        """Reference gaps that were given, one for each link, (links,); ValueError where they cannot be."""
        given = numbers(gaps, "reference_gap", "a number [m] or one number a link")
        if given.shape not in ((), self.start_gaps.shape):
            raise ValueError(
                f"reference_gap must be a number [m] or {len(self.start_gaps)} numbers, one a link, got {shown(gaps)}."
            )
        wanted = given + np.zeros_like(self.start_gaps)
        self._refuse_no_length(wanted, "would have no length at its reference", "give a larger gap")
        if self._cell is not None:
            self.check_cell(self._cell, wanted)
        return wanted

    def _refuse_relaxation(self, gaps: Any) -> None:
        if self.relaxation > 0.0 and gaps is not None:
            raise ValueError("The reference_gap of a chain that relaxes cannot be set: make it with relaxation=0.")

    def _take(self, link: int, gap: float) -> None:
        """Apply a statement to the reference gaps; ``link`` -1 means all."""
        gaps = self._gaps.copy()
        gaps[slice(None) if link < 0 else link] = gap
        self._gaps, self.function = gaps, None

    @property
    def path(self) -> np.ndarray:
        """Ids of the bodies along the chain; a closed chain repeats the first id at the end."""
        return np.array([node.body.id for node in self._nodes], dtype=np.int64)

    @property
    def points(self) -> Points | None:
        """The points of the bodies along :attr:`path` at which links act, None if all are centres."""
        points = points_of(self._nodes)
        return points if points.offset.any() else None

    @property
    def colliding(self) -> np.ndarray:
        """Whether the two bodies of a link may also be in contact, (links,) bool."""
        if self.neighbours_collide is not None:
            return np.full(len(self.start_gaps), self.neighbours_collide)
        shortest = self._gaps
        if self.relaxation > 0.0:
            shortest = np.minimum(shortest, self.start_gaps)
        cores = np.array([[core_radius(node) for node in pair] for pair in self._pairs()])
        smaller = np.where(cores > 0.0, cores, np.inf).min(axis=1)
        return shortest + self.radius_sums - cores.sum(axis=1) > COLLISION_GAP * np.where(smaller < np.inf, smaller, 0.0)

    @property
    def apart(self) -> np.ndarray:
        """Pairs of ids of linked bodies that do not collide, the lower id first, (p, 2) int64."""
        path = self.path
        return np.sort(np.column_stack([path[:-1], path[1:]])[~self.colliding], axis=1)

    def _refuse_no_length(self, gaps: np.ndarray, what: str, remedy: str) -> None:
        """Refuse links between centres that coincide: they have no direction."""
        lengths = gaps + self.radius_sums
        i = int(np.argmin(lengths))
        if not lengths[i] > 0.0:
            a, b = self._pairs()[i]
            ends = "the centres of" if a.point is None and b.point is None else "its ends at"
            raise ValueError(f"Link {i} of the chain {what} between {ends} {a!r} and {b!r}, {lengths[i]:g} m: {remedy}.")

    def check_start(self) -> None:
        """ValueError for a rigid link that is off its reference where its bodies are now, in a scene that is written."""
        if not self._settled:
            self._refuse_blows(self._gaps, np.ones(len(self._gaps), dtype=bool))

    def _refuse_blows(self, gaps: np.ndarray, given: np.ndarray) -> None:
        """Refuse rigid links that are off one of these reference gaps (links,) at the start, of those that are ``given`` it
        now (links,)."""
        if "rigid" not in self._law.TRAITS or self.relaxation > 0.0:
            return
        start = self.lengths() - self.radius_sums
        excess = np.where(given, start - gaps, 0.0)
        if "pull" not in self._law.TRAITS:
            excess = np.abs(excess)
        i = int(np.argmax(excess))
        if excess[i] > BLOW * (gaps[i] + self.radius_sums[i]):
            a, b = self._pairs()[i]
            raise ValueError(
                f"Link {i} of the chain, between {a!r} and {b!r}, has a gap of {start[i]:g} m where its "
                f"reference is {gaps[i]:g} m: a rigid link would pull it right with a blow. Move the "
                "bodies, give reference_gap=None (as built), or draw it in slowly with relaxation= [s]."
            )

    def __repr__(self) -> str:
        return f"<Chain of {len(self.bodies)} bodies, {self._law!r}{', closed' if self.closed else ''}>"


def refuse_other_class(law: Any, now: Law, what: str) -> None:
    """TypeError unless a law is of the class of the one whose place it takes: the rest of a simulation is made for it."""
    if type(law) is not type(now):
        raise TypeError(
            f"{what} may be set to one with other parameters, of the same class '{now.NAME}', got {shown(law)}: for "
            "another class make a new scene."
        )


def core_radius(node: Node) -> float:
    """Radius [m] of the largest circle or sphere around the centre that a body certainly fills. A point has 0, as if it lay
    on the surface.

    It is the larger of the link radius and the radius that the disks or spheres of the body fill; 0 if neither is known.
    """
    body = node.body
    if node.point is not None:
        return 0.0
    if isinstance(body, Round):
        return body.radius
    filled = (c.radius - math.hypot(*at) for c, at in body.contactors if isinstance(c, (DiskContactor, SphereContactor)))
    return max(body.link_radius, *filled, 0.0)
