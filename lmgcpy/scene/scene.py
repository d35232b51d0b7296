"""The scene: the user's bodies, laws and chains, compiled once into arrays."""

from __future__ import annotations

import itertools
import operator
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, ContactorTable, VisibilityRow
from lmgcpy.contact.features import topology
from lmgcpy.contact.groups import check_pairs
from lmgcpy.contact.lattice import crossing
from lmgcpy.contact.positions import in_own_axes
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.changes import (
    DRIVEN,
    GRAVITY,
    NOTED,
    OF_LAWS,
    REFERENCE,
    SEEN_LAW,
    SHOWN,
    Change,
    Counts,
    gap_values,
    laws_after,
)
from lmgcpy.dynamics.loads import ManyForces
from lmgcpy.dynamics.loads import forces as many_forces
from lmgcpy.dynamics.model import COMPONENTS, BodyState, Drive, Model
from lmgcpy.dynamics.rotation import with_rotations
from lmgcpy.dynamics.watch.start_overlaps import check_start
from lmgcpy.errors import AXES, LARGEST, closest, flag, named_arguments, number, numbers, read_only, shown, vector, whole
from lmgcpy.laws import Law
from lmgcpy.laws.first_calls import check_answers
from lmgcpy.laws.registry import check_interface
from lmgcpy.scene.body import INERTIA, MASS, RADIUS, Body, Disk, RigidBody, Wall
from lmgcpy.scene.body_3d import Sphere
from lmgcpy.scene.cell import Cell, Edge, edge_vector
from lmgcpy.scene.chain import Chain, refuse_other_class
from lmgcpy.scene.clump import Clump, make_clumps
from lmgcpy.scene.features import Surface, refuse_points_on_planes
from lmgcpy.scene.joint import Joint, Node, joint_tables, node_of
from lmgcpy.scene.many_bodies import SomeRound, StartNumbers, make_round
from lmgcpy.scene.medium import COEFFICIENTS, Medium, drag_of, medium
from lmgcpy.scene.skin import Net, PointMass, Skin, Thread, paths
from lmgcpy.scene.solid import Material
from lmgcpy.writing import html_table

SomeBody = TypeVar("SomeBody", bound=Body)

DEFAULT_ALERT = 0.2
"""Default alert distance, relative to the smallest bounding radius among the contactors of the two colours."""


@named_arguments
class Scene:
    """A 2D or 3D scene: bodies; the visibility table, which gives the law of each pair of colours; chains; joints;
    gravity [m/s^2].

    A ball above a floor:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    >>> steel = lm.Material("steel", density=7800.0)
    >>> ball = scene.add(lm.disk(radius=0.01, position=(0.0, 0.02), material=steel))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    >>> scene
    <Scene in 2D: 2 bodies, 1 rows of the visibility table, 0 chains>
    """

    def __init__(self, *, dimension: int, gravity: Any = None):
        self.dimension = whole(dimension, "dimension", minimum=2, maximum=3)
        self._compiled = False
        self._elements_after: int | None = None
        """Number of bodies to whose contactors those of surfaces between bodies come next: all that there were as the scene
        was compiled first."""
        self._settled = False  # links are as long as the steps of a run have left them
        self._state: BodyState | None = None
        self._at_start: list[tuple[Any, Any, bool]] = []
        """Conditions of the bodies when the scene was compiled, and whether they were hidden."""
        self.gravity = (0.0,) * self.dimension if gravity is None else gravity
        self.bodies: list[Body] = []
        self._rows: list[tuple[str, str, Law, float | None]] = []
        self.chains: list[Chain] = []
        self.joints: list[Joint] = []
        self.skins: list[Skin] = []
        self._many_forces: list[ManyForces] = []
        self._cell: Cell | None = None
        self._media: list[Medium] = []

    _from_run: ClassVar[Callable[..., Scene]]
    """Reads a scene from a run file; given by :mod:`lmgcpy.simulation`, as scenes know nothing of files."""

    @classmethod
    def from_run(
        cls,
        path: str | os.PathLike,
        step: int | None = None,
        *,
        functions: Mapping[Any, Callable[[float], Any]] | None = None,
    ) -> Scene:
        """The scene of a run file as it was after a ``step`` that has a frame, by default the last: a new scene, which may
        be edited, and in which a simulation begins at time 0.

        Bodies have their positions and velocities after that step; conditions, gravity and hidden bodies are as they were
        then. Impulses and states of laws are not kept: the first step starts from none. :func:`lmgcpy.resume` keeps them,
        with another time step and another solver too. Functions of time, which no file can hold, are given as to it, and
        begin at time 0 again.

        Raises the errors of ``lmgcpy.io.open_run``, and ValueError if there is no frame of that step.
        """
        return cls._from_run(path, step, functions)

    @property
    def gravity(self) -> Any:
        """Gravitational acceleration [m/s^2], (d,), or a function of time [s] that gives it.

        Between the steps of a simulation it may be set to another vector, which acts from the next step on.
        """
        return self._gravity

    @gravity.setter
    def gravity(self, gravity: Any) -> None:
        if callable(gravity):
            self._editable("make gravity a function of time")
            self._gravity = gravity
            return
        given = vector(gravity, "gravity", self.dimension)
        if self._state is not None:
            for axis, value in enumerate(given.tolist()):
                self._state.keep(GRAVITY, -1, axis, value)
        self._gravity = read_only(given)

    @property
    def rows(self) -> tuple[tuple[str, str, Law, float | None], ...]:
        """The visibility table: candidate colour, antagonist colour, law, alert distance [m] or None.

        Before a simulation is made it may be set to other rows, which ``see`` checks, as for a sample under another law:
        ``scene.rows = [(c, a, lm.Coulomb(friction=0.5), alert) for c, a, _, alert in scene.rows]``.
        """
        return tuple(self._rows)

    @rows.setter
    def rows(self, rows: Iterable[tuple[str, str, Law, float | None]]) -> None:
        self._editable("set the visibility table")
        before, self._rows = self._rows, []
        try:
            for row in _rows_of(rows):
                candidate, antagonist, law, alert = row
                self.see(candidate, antagonist, law, alert=alert)
        except BaseException:
            self._rows = before
            raise

    @named_arguments
    def add(self, body: SomeBody) -> SomeBody:
        """Add a body and give it its id. Returns the body.

        Between the steps of a simulation the body comes with its velocity. A run that is recorded takes no further body
        (RuntimeError), as all frames of a file have the same bodies. ValueError if the simulation could not begin with the
        body: it is too far from the origin, too big for the periodic cell, or overlaps another one by more than
        ``overlap`` of the simulation allows.
        """
        if not isinstance(body, Body):
            raise TypeError(f"Scene.add takes a body such as lmgcpy.disk(...), got {shown(body)}.")
        if body.dimension != self.dimension:
            only = " A RigidBody is 2D only." if isinstance(body, RigidBody) else ""
            raise ValueError(f"{body!r} is of dimension {body.dimension}, this scene of dimension {self.dimension}.{only}")
        if isinstance(body, Edge):
            raise TypeError(f"{body!r} belongs to a cell: Scene.periodic makes it.")
        if body.id >= 0:
            where = "this scene" if body.id < len(self.bodies) and self.bodies[body.id] is body else "another scene"
            raise ValueError(f"{body!r} is in {where} already: make a new body.")
        self._join([body])
        return body

    def _join(self, bodies: Sequence[Body]) -> None:
        """Give bodies their ids. Bodies that are added between the steps of a simulation were hidden until now."""
        if self._state is not None:
            self._state.refuse_recorded("The number of bodies")
        for body in bodies:
            body.check_turning()
        for id, body in enumerate(bodies, len(self.bodies)):
            body._id = id
        self.bodies += bodies
        if self._state is None:
            return
        try:
            model = self._model(self._state.time)
            check_pairs(model.contactors, model.rows)
            if self._cell is not None:
                self._cell.check()
            laid = replace(model, start=self._state.with_those_of(model.start))
            check_start(laid, self._state.overlap, len(self.bodies) - len(bodies))  # the next step has its sentences
        except BaseException:
            del self.bodies[-len(bodies) :]
            for body in bodies:
                body._id = -1
            raise
        self._state.grow(model.start)
        for body in bodies:
            body._state = self._state
            self._at_start.append((body._velocities, body._forces, True))
            if not body._hidden:
                self._state.keep(SHOWN, body._id, -1, 0.0)

    @named_arguments
    def periodic(self, *, x: Any = None, y: Any = None, z: Any = None, inertia: float | None = None) -> Cell:
        """Make the scene periodic along some axes: each axis gets an edge of the cell, a length or a vector [m]. Returns
        the cell, whose statements say how it deforms; without them it is held.

        Bodies near a face of the cell meet the images of bodies near the opposite face. Positions may lie outside of the
        cell and are not folded back, so that wires may be laid across its faces. The edges of a cell that is not periodic
        in all directions must lie along the periodic axes. The cell must be wider than four times the largest radius
        (twice the length of the longest cluster or capsule) and twice the distance within which contacts are looked for.

        ``inertia`` [kg m^2] is the inertia of each component of the velocity gradient that yields to a stress. If None, the
        column of an axis gets the mass of all bodies times the square of the width of the cell, over 12.
        """
        self._editable("make it periodic")
        if self._cell is not None:
            raise ValueError("This scene is periodic already: say all its edges in one call.")
        given = {axis: edge for axis, edge in enumerate((x, y, z)) if edge is not None}
        if not given:
            raise TypeError("periodic needs the edge of a direction, for example periodic(x=0.1).")
        if max(given) >= self.dimension:
            raise ValueError("A scene in 2D has no direction z.")
        if inertia is not None:
            inertia = number(inertia, "inertia of a periodic cell", above=0.0, unit="kg m^2")
        edges = {axis: edge_vector(edge, axis, self.dimension) for axis, edge in given.items()}
        for axis, edge in edges.items():
            for other in set(range(self.dimension)) - set(edges):
                if edge[other] != 0.0:
                    raise ValueError(
                        f"Edge {AXES[axis]} goes along {AXES[other]} as well, which is not periodic: give "
                        f"{AXES[other]} an edge, or take it out of this one."
                    )
        basis = np.array(list(edges.values()))
        lengths = np.prod(np.linalg.norm(basis, axis=1))
        if not np.sqrt(max(np.linalg.det(basis @ basis.T), 0.0)) > 1e-3 * lengths:
            raise ValueError(f"The edges of a periodic cell lie in one line or plane, got {shown(basis.tolist())}.")
        made = [Edge(axis, edge, mass=inertia) for axis, edge in edges.items()]
        self._join(made)
        return self._take_edges(made)

    def _take_edges(self, edges: list[Edge]) -> Cell:
        """Make the periodic cell from these edges, which are bodies of the scene."""
        self._cell = Cell(self.dimension, self.bodies, edges, self.skins)
        for chain in self.chains:
            chain.lie_in(self._cell)
        for skin in self.skins:
            skin.lie_in(self._cell)
        return self._cell

    @property
    def cell(self) -> Cell | None:
        """The periodic cell, None without one."""
        return self._cell

    @named_arguments
    def drag(
        self,
        bodies: Any = None,
        *,
        rate: float = 0.0,
        linear: float = 0.0,
        quadratic: float = 0.0,
        turning: float = 0.0,
        viscosity: float = 0.0,
        density: float = 0.0,
    ) -> None:
        """Let bodies move through a medium at rest: the list of ``bodies``, or all disks, spheres and clusters, those that
        are added later too. Several calls add up.

        ``rate`` [1/s]: forces ``-m rate v`` and moments ``-I rate omega``, a damping. ``linear`` [N s/m], ``quadratic``
        [N s^2/m^2] and ``turning`` [N m s]: ``-linear v - quadratic |v| v`` and ``-turning omega``. ``viscosity`` [Pa s]:
        the drag of Stokes on spheres, 6 pi eta R and 8 pi eta R^3. ``density`` [kg/m^3] of a fluid: the resistance
        ``1/2 C rho A |v| v`` on disks and spheres, C = 0.44 of spheres, 1 of disks, A their section.

        Drag is implicit within the step (``lmgcpy.dynamics.drag``): a body that sinks comes to its last velocity at any
        time step, and linear drag alone is exact. A force that is a function of time cannot do that: it is explicit.
        Weight is not changed: give gravity without buoyancy. Periodic cells: relative to the mean flow.
        """
        self._editable("add a drag")
        values = rate, linear, quadratic, turning, viscosity, density
        self._media.append(medium(bodies, self.bodies, self.dimension, dict(zip(COEFFICIENTS, values, strict=True))))

    @named_arguments
    def add_disks(
        self,
        radii: Any,
        positions: Any,
        *,
        material: Material | None = None,
        color: str = "GRAIN",
        velocities: Any = None,
        spins: Any = None,
        masses: Any = None,
        inertias: Any = None,
    ) -> list[Disk]:
        """Add many disks in one call, a hundred times as fast as one after another; returns them, in the order of
        ``positions`` [m], (n, 2).

        ``radii`` [m], (n,); ``velocities`` [m/s], (n, 2), and ``spins`` [rad/s], (n,), by default at rest; ``masses`` [kg],
        (n,), override the ``material``, and ``inertias`` [kg m^2], (n,), m R^2/2. What is the same for all may be given
        once. The bodies are those that :func:`lmgcpy.disk` makes, to the last bit.
        """
        given = {"velocities": velocities, "spins": spins, "masses": masses, "inertias": inertias}
        return self._add_round(Disk, radii, positions, material=material, color=color, **given)

    @named_arguments
    def add_spheres(
        self,
        radii: Any,
        positions: Any,
        *,
        material: Material | None = None,
        color: str = "GRAIN",
        velocities: Any = None,
        spins: Any = None,
        masses: Any = None,
        inertias: Any = None,
    ) -> list[Sphere]:
        """Add many spheres in one call; as :meth:`add_disks`, with ``positions``, ``velocities`` and ``spins`` of shape
        (n, 3), and 2/5 m R^2 for the inertias."""
        given = {"velocities": velocities, "spins": spins, "masses": masses, "inertias": inertias}
        return self._add_round(Sphere, radii, positions, material=material, color=color, **given)

    @named_arguments
    def add_clumps(
        self,
        shape: Clump,
        positions: Any,
        *,
        rotations: Any = None,
        scales: Any = None,
        color: str = "GRAIN",
        velocities: Any = None,
        spins: Any = None,
    ) -> list[RigidBody]:
        """Add many clumps of one shape, see :func:`lmgcpy.clump`, with their centres of mass at ``positions`` [m], (n, d);
        returns them in this order.

        ``rotations``: angles [rad], (n,), in 3D a scipy ``Rotation`` of n rotations or unit quaternions (n, 4); ``scales``
        multiply lengths, (n,); ``velocities`` [m/s], (n, d), and ``spins`` [rad/s], (n,) or (n, 3), by default at rest.
        What is the same for all may be given once.
        """
        given = {"rotations": rotations, "scales": scales, "velocities": velocities, "spins": spins}
        made = make_clumps(shape, positions, color=color, **given)
        if shape.dimension != self.dimension:
            raise ValueError(f"The clump is of dimension {shape.dimension}, this scene of dimension {self.dimension}.")
        self._join(made)
        return made

    def _add_round(self, kind: type[SomeRound], radii: Any, positions: Any, **given: Any) -> list[SomeRound]:
        if kind.dimension != self.dimension:
            raise ValueError(f"A {kind.noun} is of dimension {kind.dimension}, this scene of dimension {self.dimension}.")
        made = make_round(kind, radii, positions, **given)
        self._join(made)
        return made

    @named_arguments
    def see(self, candidate: str, antagonist: str, law: Law, *, alert: float | None = None) -> None:
        """Let bodies of two colours touch under a law; a pair of colours has one row, in either order.

        ``alert`` is the gap [m] up to which a pair is an interaction. If None, it is a fifth of the smallest radius of the
        two colours, or twice the travel of the fastest body in a step if that is more, and for walls the distance by which
        a wall and a body approach each other in a step. A gap that is beyond the alert distance and closes within one step
        is detected too late, as a penetration that stays. A law that acts at a distance (``Law.acts_within``) is seen at
        least up to there.
        """
        row = self._row(candidate, antagonist, law, alert)
        for one, other, earlier, _ in self._rows:
            if {one, other} == {candidate, antagonist}:
                raise ValueError(
                    f"The visibility table lets '{one}' and '{other}' touch under {earlier!r} already; '{candidate}' and "
                    f"'{antagonist}' under {law!r} would act on the same pairs. Give the bodies of one of the two another "
                    "colour, or write a law that does both."
                )
        self._rows.append(row)

    @named_arguments
    def set_law(self, candidate: str, antagonist: str, law: Law) -> None:
        """Let bodies of two colours that see each other touch under a law of the same class with other parameters.

        Between the steps of a simulation it acts from the next step on; checkpoints and run files keep it. LookupError if
        the colours do not see each other; ValueError between steps for a law with another number of rolling components,
        for which a simulation has no room.
        """
        self._check_law(law, "contact", "set_law")
        at = [k for k, (one, other, _, _) in enumerate(self._rows) if {one, other} == {candidate, antagonist}]
        if not at:
            raise LookupError(f"{shown(candidate)} does not see {shown(antagonist)}: Scene.see gives the two a law.")
        (k,) = at
        one, other, now, alert = self._rows[k]
        refuse_other_class(law, now, f"The law between '{one}' and '{other}'")
        d = self.dimension
        if self._state is not None and max(law.rows(d), d) != max(now.rows(d), d):
            raise ValueError(
                f"Between steps '{one}' and '{other}' cannot get a law with another number of rolling components, "
                f"{law.rows(d)} in place of {now.rows(d)}: begin with those that are to come, and let them be small."
            )
        check_answers(law, d)
        if self._state is not None:
            self._state.keep_law(SEEN_LAW, k, law)
        self._rows[k] = one, other, law, alert

    def _row(self, candidate: str, antagonist: str, law: Law, alert: float | None) -> tuple[str, str, Law, float | None]:
        """A row of the visibility table, checked by itself."""
        self._editable("extend the visibility table", "Scene.set_law changes parameters; for more make a new scene.")
        for color in (candidate, antagonist):
            if not isinstance(color, str) or not color:
                raise TypeError(f"A colour is a word such as 'GRAIN', got {shown(color)}.")
        self._check_law(law, "contact", "see")
        if alert is not None:
            alert = number(alert, f"alert between '{candidate}' and '{antagonist}'", minimum=0.0, unit="m")
        return candidate, antagonist, law, alert

    @named_arguments
    def chain(
        self,
        bodies: Any,
        law: Law,
        *,
        reference_gap: Any = None,
        block_spin: bool = False,
        closed: bool = False,
        relaxation: float = 0.0,
        neighbours_collide: bool | None = None,
        parameters: Mapping[str, Any] | None = None,
        surface: Thread | None = None,
        settled: bool = False,
    ) -> Chain:
        """Link consecutive bodies by a law; returns the chain.

        A body may be given as a pair (body, point), with the point relative to the body's centre, along its axes [m]. The
        link then acts at that point, and its length is measured to it, not to the surface. So wires end at the corner of a
        plate or at a wall.

        ``reference_gap`` [m] is the gap between surfaces at the reference length: one number, one number a link, a function
        of time [s] that gives them (see ``Chain.reference_gap``), or None for the initial gaps. ``block_spin`` holds the
        spin of the bodies: links carry no moment, so a bead that is free to spin rolls, and a chain of such beads slides
        over a drum without friction. ``closed`` links the last body to the first. A rigid link that starts beyond its
        reference is refused, unless ``relaxation`` [s] gives the time in which it is drawn in.

        ``neighbours_collide`` says whether linked neighbours whose colours see each other may also be in contact. If None,
        they may if the reference gap stays above a thousandth of the smaller radius, also during a relaxation. With a
        smaller gap, link and contact of the same pair would prestress each other without bound. Link beads by rods if they
        touch and must not be pushed into each other.

        ``surface`` gives the chain a smooth surface between its bodies, see :class:`~lmgcpy.Thread`. The bodies may then be
        points (:func:`~lmgcpy.point_mass`).

        ``settled`` says that the bodies lie as the steps of another simulation have left them: rigid links may be off their
        reference by the errors of the steps, and slack nodes of a surface closer to each other than it is thick.
        """
        self._editable("add a chain")
        self._check_law(law, "link", "chain")
        if law.TIES:
            raise TypeError(f"Law '{law.NAME}' ties two points, not bodies of a chain: give it to Scene.link.")
        block_spin, closed, settled = flag(block_spin, "block_spin"), flag(closed, "closed"), flag(settled, "settled")
        settled = settled or self._settled
        if neighbours_collide is not None:
            neighbours_collide = flag(neighbours_collide, "neighbours_collide, unless it is None,")
        if isinstance(bodies, (str, Body)) or not isinstance(bodies, Iterable):
            raise TypeError(f"A chain links a list of bodies, got {shown(bodies)}.")
        nodes = [self._node(given, "A chain") for given in bodies]
        members = [node.body for node in nodes]
        if len(members) < (3 if closed else 2):
            least, kind = (3, "closed chain") if closed else (2, "chain")
            raise ValueError(f"A {kind} needs at least {least} bodies, got {len(members)}.")
        if len({body.id for body in members}) < len(members):
            twice = next(body for i, body in enumerate(members) if body in members[:i])
            raise ValueError(f"{twice!r} is in the chain twice; closed=True links the last body to the first.")
        components = dict.fromkeys(COMPONENTS[self.dimension][self.dimension :], 0.0)
        blocked = [(body, body._to_drive("block_spin", components)) for body in members if block_spin]
        chain = Chain(
            nodes,
            law,
            reference_gap,
            relaxation=relaxation,
            closed=closed,
            neighbours_collide=neighbours_collide,
            parameters=parameters,
            settled=settled,
            cell=self._cell,
        )
        if surface is not None:
            count = len(chain.start_gaps)
            cells = np.column_stack([np.arange(count), np.arange(1, count + 1) % len(members)])
            chain.skin = self._skin(nodes, cells, surface, settled)
        for body, spins in blocked:
            body._state_changes(DRIVEN, spins)
        self.chains.append(chain)
        return chain

    @named_arguments
    def link(
        self,
        a: Body,
        b: Body,
        law: Law,
        *,
        at: Any = (None, None),
        reference_gap: Any = None,
        relaxation: float = 0.0,
        neighbours_collide: bool | None = None,
    ) -> Chain | Joint:
        """Link two bodies by a law, ``at`` a point of each; returns the chain of one link, or the joint.

        ``at``: points of a and of b, from the centre of the body along its axes [m], (d,) each; None stands for the centre.
        In 3D a body keeps axes if it turns, as clumps and capsules do, see ``Body.turns``; the axes of walls are those of
        space. The other arguments are as of :meth:`chain`.

        A law that ties two points, as :class:`~lmgcpy.BallJoint`, makes a joint: points that start apart are refused, and
        the bodies do not collide with each other unless ``neighbours_collide``.
        """
        self._editable("add a link")
        self._check_law(law, "link", "link")
        if isinstance(at, (str, Body)) or not isinstance(at, Iterable) or len(pair := list(at)) != 2:
            raise TypeError(f"at must be two points, one of each body, as ((0.1, 0.0), None), got {shown(at)}.")
        if not law.TIES:
            given = {"reference_gap": reference_gap, "relaxation": relaxation, "neighbours_collide": neighbours_collide}
            return self.chain([(a, pair[0]), (b, pair[1])], law, **given)
        nodes = self._node((a, pair[0]), "Scene.link"), self._node((b, pair[1]), "Scene.link")
        if a is b:
            raise ValueError(f"{a!r} cannot be tied to itself: a joint is between two bodies.")
        if reference_gap is not None or number(relaxation, "relaxation of a link", minimum=0.0, unit="s") > 0.0:
            raise ValueError(f"Law '{law.NAME}' ties two points: a joint has no reference_gap and does not relax.")
        collide = neighbours_collide is not None and flag(neighbours_collide, "neighbours_collide, unless it is None,")
        joint = Joint(nodes, law, collide=collide, settled=self._settled, cell=self._cell)
        self.joints.append(joint)
        return joint

    @named_arguments
    def net(
        self,
        bodies: Any,
        edges: Any,
        law: Law,
        *,
        surface: Thread | None = None,
        reference_gap: Any = None,
        neighbours_collide: bool | None = None,
    ) -> Net:
        """Link bodies by a law along ``edges``, (m, 2) indices of ``bodies``; returns the net.

        ``surface`` gives the links a round surface, see :class:`~lmgcpy.Thread`; ``reference_gap`` [m]: one number, one an
        edge in the order of ``edges``, or None for the initial gaps.
        """
        return self._net("net", bodies, edges, 2, law, surface, reference_gap, neighbours_collide)

    @named_arguments
    def membrane(
        self,
        bodies: Any,
        triangles: Any,
        law: Law,
        *,
        radius: float,
        color: str = "MEMBRANE",
        reference_gap: Any = None,
    ) -> Net:
        """A surface of triangles between bodies, linked by a law along the edges of the triangles; returns the net.

        ``triangles``: (m, 3) indices of ``bodies``; ``radius``: half of the thickness [m]. Others see both of its sides.
        ``reference_gap`` as of :meth:`net`, in the order of ``Net.edges``: by the lower index, then by the higher one.
        In 2D a closed chain with a surface is a membrane.
        """
        if self.dimension == 2:
            raise ValueError("A membrane of triangles is for 3D: in 2D take a chain with surface=lmgcpy.Thread(...).")
        return self._net("membrane", bodies, triangles, 3, law, Thread(radius, color=color), reference_gap, None)

    def _net(
        self, call: str, bodies: Any, cells: Any, corners: int, law: Law, thread: Any, gaps: Any, collide: bool | None
    ) -> Net:
        self._editable(f"add a {call}")
        self._check_law(law, "link", call)
        if isinstance(bodies, (str, Body)) or not isinstance(bodies, Iterable):
            raise TypeError(f"A {call} links a list of bodies, got {shown(bodies)}.")
        nodes = [self._node(body, f"A {call}") for body in bodies]
        what = f"{'edges' if corners == 2 else 'triangles'} of a {call}"
        given = numbers(cells, what, f"an array (m, {corners}) of indices")
        if given.ndim != 2 or given.shape[1] != corners or not len(given):
            raise ValueError(f"The {what} must be of shape (m, {corners}), got {given.shape}.")
        table = given.astype(np.int64)
        wrong = (table != given).any(axis=1) | (table < 0).any(axis=1) | (table >= len(nodes)).any(axis=1)
        wrong |= (np.diff(np.sort(table, axis=1), axis=1) == 0).any(axis=1)
        if wrong.any():
            i = int(np.argmax(wrong))
            raise ValueError(
                f"Row {i} of the {what} is {shown(given[i].tolist())}: it must be {corners} different indices of the "
                f"{len(nodes)} bodies, 0 ... {len(nodes) - 1}."
            )
        alone = np.setdiff1d(np.arange(len(nodes)), table)
        if len(alone) and thread is not None:
            raise ValueError(f"{nodes[alone[0]].body!r} is in none of the {what}: leave it out of the bodies.")
        _, first, uses = np.unique(np.sort(table, axis=1), axis=0, return_index=True, return_counts=True)
        if corners == 3 and uses.max() > 1:
            i = first[int(uses.argmax())]
            raise ValueError(f"Triangle {i} of a membrane, {table[i].tolist()}, is there {uses.max()} times: leave one.")
        edges = table if corners == 2 else topology(table, len(nodes)).edges
        ordered = np.unique(np.sort(edges, axis=1), axis=0)
        if len(ordered) < len(edges):
            raise ValueError("Two edges of a net join the same bodies: each pair has one link.")
        if gaps is not None:
            gaps = numbers(gaps, "reference_gap", "a number [m], or one an edge")
            if gaps.shape not in ((), (len(edges),)):
                raise ValueError(f"reference_gap must be a number [m], or one an edge, ({len(edges)},), got {gaps.shape}.")
            gaps = np.broadcast_to(gaps, len(edges))
        if collide is not None:
            collide = flag(collide, "neighbours_collide, unless it is None,")
        place = {tuple(edge): k for k, edge in enumerate(np.sort(edges, axis=1).tolist())}
        before, chains = (len(self.skins), len(self.chains)), []
        try:
            skin = None if thread is None else self._skin(nodes, table, thread, self._settled)
            for path in paths(ordered, len(nodes)):
                of_path = None
                if gaps is not None:
                    of_path = gaps[[place[min(ends), max(ends)] for ends in itertools.pairwise(path)]]
                members = [nodes[k].body for k in path]
                chains.append(self.chain(members, law, reference_gap=of_path, neighbours_collide=collide))
        except BaseException:  # a link that cannot be: then there is no net
            del self.skins[before[0] :], self.chains[before[1] :]
            raise
        return Net([node.body for node in nodes], edges, chains, skin)

    def _skin(self, nodes: Sequence[Node], cells: np.ndarray, thread: Thread, settled: bool) -> Skin:
        """Add a surface; TypeError or ValueError for one that bodies cannot have."""
        if not isinstance(thread, Thread):
            raise TypeError(f"surface must be a lmgcpy.Thread, got {shown(thread)}.")
        if any(node.point is not None for node in nodes):
            raise ValueError(
                "A surface goes through centres of bodies, and this one would go through points off them: end it at a node "
                "there, lmgcpy.point_mass(...), and tie both by scene.link(body, node, lmgcpy.BallJoint(), "
                "at=(point, None))."
            )
        skin = Skin([node.body for node in nodes], cells, thread, settled=settled)
        if self._cell is not None:
            skin.lie_in(self._cell)
        self.skins.append(skin)
        return skin

    @named_arguments
    def impose_forces(self, bodies: Any, forces: Any) -> None:
        """Load many bodies at once: ``forces`` [N] is an array (m, d), one row for all, or a function of time [s] that
        gives it. These forces come beside those of ``Body.impose_force``."""
        self._editable("impose forces on many bodies")
        if isinstance(bodies, (str, Body)) or not isinstance(bodies, Iterable):
            raise TypeError(f"Scene.impose_forces loads a list of bodies, got {shown(bodies)}.")
        members = [self._node(body, "Scene.impose_forces").body for body in bodies]
        for body in members:
            if body.held_by_default:
                raise ValueError(f"{body!r} is held, so that forces do not move it: load it by its impose_force.")
        if not callable(forces):
            forces = many_forces(forces, "forces", len(members), self.dimension).copy()
        self._many_forces.append(ManyForces(np.array([body.id for body in members], dtype=np.int64), forces))

    def _node(self, given: Any, what: str) -> Node:
        """A body, or a pair of a body and its point, to be linked."""
        body, point = given if isinstance(given, (tuple, list)) and len(given) == 2 else (given, None)
        if not isinstance(body, Body):
            raise TypeError(f"{what} links bodies of the scene, or points (body, point) of them, got {shown(body)}.")
        if not (0 <= body.id < len(self.bodies) and self.bodies[body.id] is body):
            raise ValueError(f"{body!r} is not in this scene: add it before it is linked.")
        return node_of(body, point)

    def _editable(self, what: str, instead: str = "Make a new scene.") -> None:
        if self._compiled:
            raise RuntimeError(f"Cannot {what}: a Simulation has compiled this scene. {instead}")

    def _check_law(self, law: Law, applies_to: str, call: str) -> None:
        if not isinstance(law, Law):
            raise TypeError(f"Scene.{call} takes a law such as lmgcpy.Coulomb(friction=0.3), got {shown(law)}.")
        check_interface(type(law))
        if self.dimension not in law.DIMENSIONS:
            raise ValueError(f"Law '{law.NAME}' is for scenes in {law.DIMENSIONS[0]}D, this one is in {self.dimension}D.")
        if applies_to != law.APPLIES_TO:
            right = "see" if law.APPLIES_TO == "contact" else "link" if law.TIES else "chain"
            raise TypeError(f"Law '{law.NAME}' is for a {law.APPLIES_TO}: give it to Scene.{right}, not Scene.{call}.")
        if law.APPLIES_TO == "link" and law.rows(self.dimension) != 1:
            raise TypeError(f"Law '{law.NAME}' has {law.rows(self.dimension)} components: a link acts along its line only.")

    # ----------------------------------------------------------------------------------------------------- compile

    def compile(self) -> Model:
        """The frozen model, with the initial values of imposed velocities. ``Simulation`` calls it."""
        self._editable("compile the scene again")
        self._check_colors()
        refuse_points_on_planes(self.bodies, self._rows)
        for law in {id(law): law for _, _, law, _ in self.rows}.values():
            check_answers(law, self.dimension)
        for chain in self.chains:
            check_answers(chain.law, self.dimension)
            chain.check_start()
        for joint in self.joints:
            check_answers(joint.law, self.dimension)
            joint.check_start(self._cell)
        if self._cell is not None:
            self._cell.check()
            for chain in self.chains:
                chain.check_cell(self._cell, chain._gaps)
        return self._model(0.0)

    def _model(self, time: float) -> Model:
        """The model of all bodies where they were laid, with the values of imposed velocities at a time [s]."""
        start, d, count = StartNumbers.of(self.bodies), self.dimension, len(COMPONENTS[self.dimension])
        positions, velocities = start.rows[:, :3].copy(), start.rows[:, 3 : 3 + count].copy()
        mass = np.repeat(start.rows[:, [MASS, INERTIA]], [d, count - d], axis=1)
        turning = start.turning
        if len(turning):
            positions = with_rotations(positions)
            positions[turning, 3:] = start.quaternion
            velocities[turning, 3:] = in_own_axes(start.quaternion, velocities[turning, 3:])
            mass[turning, 3:] = start.inertias
        contactors = self._with_elements(self._contactors(start), start)
        self._check_numbers(positions, velocities, mass, contactors)
        driven, loads, inverse_mass, hidden = self._conditions(mass)
        for drive in driven:
            velocities[drive.body, drive.component] = drive.at(time)
        velocities[hidden] = 0.0
        chained = frozenset(body.id for chain in self.chains for body in chain.bodies)
        chained |= {body.id for joint in self.joints for body in joint.bodies}
        for i in np.flatnonzero(hidden).tolist():
            if i in chained:
                raise ValueError(f"{self.bodies[i]!r} is hidden, but it is linked in a chain, which would be cut: show it.")
        tied = [sorted(body.id for body in joint.bodies) for joint in self.joints if not joint.collide]
        return Model(
            dimension=self.dimension,
            mass=mass,
            inverse_mass=inverse_mass,
            radius=start.link_radius,
            extent=start.extent,
            wall_normals={body.id: body.normal for body in self.bodies if isinstance(body, Wall)},
            gravity=self.gravity,
            heavy=start.heavy,
            contactors=contactors,
            rows=[
                VisibilityRow(
                    c,
                    a,
                    law,
                    self._alert(c, a, alert, contactors),
                    adaptive=alert is None,
                    reach=reach(c, a, law, contactors),
                )
                for c, a, law, alert in self.rows
            ],
            chains=[
                ChainTable(
                    chain.path,
                    chain.laws,
                    chain.radius_sums.copy(),
                    chain.reference_gap,
                    chain.start_gaps.copy(),
                    chain.relaxation,
                    chain.gaps_in_time,
                    chain.points,
                )
                for chain in self.chains
            ],
            joints=joint_tables(self.joints, d),
            apart=np.unique(
                np.concatenate([np.array(tied, np.int64).reshape(-1, 2), *(c.apart for c in self.chains)]), axis=0
            ),
            velocities=driven,
            forces=loads,
            loads=[*self._many_forces, *(skin.load for skin in self.skins if skin.load is not None)],
            start=BodyState(positions, velocities, chained=chained, turning=turning),
            hidden=hidden,
            cell=None if self._cell is None else CellMotion.of(self._cell.lattice, start.extent),
            drag=drag_of(self._media, self.bodies, mass, np.isfinite(start.extent) & start.heavy),
        )

    def _conditions(self, mass: np.ndarray) -> tuple[list[Drive], list[Drive], np.ndarray, np.ndarray]:
        """Imposed velocities and forces, the inverse masses that they leave (n, k), and the hidden bodies (n,)."""
        d, count = self.dimension, len(COMPONENTS[self.dimension])
        there = [body for body in self.bodies if not body._hidden]
        driven = [Drive(body.id, k, value, d) for body in there for k, value in body._velocities.items()]
        loads = [Drive(body.id, k, value, d) for body in there for k, value in body._forces.items()]
        for body in there:
            if body.held_by_default:
                held = [k for k in range(count) if k not in body._velocities and k not in body._forces]
                driven += [Drive(body.id, k, 0.0, d) for k in held]
        hidden = np.array([body._hidden for body in self.bodies], dtype=bool)
        inverse_mass = 1.0 / mass
        inverse_mass[hidden] = 0.0
        for drive in driven:
            inverse_mass[drive.body, drive.component] = 0.0
        return driven, loads, inverse_mass, hidden

    def changed(self, model: Model) -> Model:
        """The model with the conditions, the hidden bodies and the gravity of now, and all bodies that were added since; a
        simulation calls it between steps."""
        assert self._state is not None
        if len(self.bodies) > len(model.mass):
            if self._cell is not None:
                self._cell.keep_inertia()
            return self._after(model, replace(self._model(self._state.time), start=self._state))
        velocities, forces, inverse_mass, hidden = self._conditions(model.mass)
        rows = [
            row if law == row.law else replace(row, law=law, reach=reach(c, a, law, model.contactors))
            for row, (c, a, law, _) in zip(model.rows, self.rows, strict=True)
        ]
        chains = [table_of(chain, table) for chain, table in zip(self.chains, model.chains, strict=True)]
        now = replace(
            model,
            gravity=self.gravity,
            velocities=velocities,
            forces=forces,
            inverse_mass=inverse_mass,
            hidden=hidden,
            rows=model.rows if all(map(operator.is_, rows, model.rows)) else rows,
            chains=model.chains if all(map(operator.is_, chains, model.chains)) else chains,
        )
        return self._after(model, now)

    def _after(self, before: Model, now: Model) -> Model:
        """A model that comes after another one, and knows its chains if they were other ones."""
        assert self._state is not None
        if before.drawn == self._state.time:
            return replace(now, earlier=before.earlier, drawn=before.drawn)
        if all(map(same_links, before.chains, now.chains)):
            return now
        return replace(now, earlier=before.chains, drawn=self._state.time)

    def go_through(self, changes: list[Change]) -> None:
        """Go back to the conditions at the start, and from there through the statements between steps."""
        assert self._state is not None
        self._state.changes = list(changes)  # first: by it a restore that is interrupted knows that it was here
        self._gravity = self._gravity_at_start
        for body, (velocities, forces, hidden) in zip(self.bodies, self._at_start, strict=True):
            body._velocities, body._forces, body._hidden = velocities, forces, hidden
        self._rows = list(self._rows_at_start)
        for chain, (law, gaps, function) in zip(self.chains, self._chains_at_start, strict=True):
            chain._law, chain._gaps, chain.function = law, gaps, function
        self.take(changes)
        self._state.stale = True

    def take(self, changes: list[Change]) -> None:
        """Make of conditions, bodies and gravity what statements between steps made of them."""
        for change in changes:
            if change.kind == REFERENCE:
                self.chains[change.body]._take(change.component, change.value)
                continue
            if change.kind in (*OF_LAWS, NOTED):
                continue
            if change.kind != GRAVITY:
                self.bodies[change.body]._take(change.kind, change.component, change.value)
                continue
            gravity = np.zeros(self.dimension) if callable(self._gravity) else self._gravity.copy()
            gravity[change.component] = change.value
            self._gravity = gravity
        for (kind, k), given in laws_after(changes).items():
            now = self._rows[k][2] if kind == SEEN_LAW else self.chains[k]._law
            law = type(now)(**{list(now.parameters())[at]: value for at, value in given.items()})
            if kind == SEEN_LAW:
                one, other, _, alert = self._rows[k]
                self._rows[k] = one, other, law, alert
            else:
                self.chains[k]._refuse_links(law, self.chains[k].parameters)
                self.chains[k]._law = law

    @property
    def counts(self) -> Counts:
        """How many there are of what statements between steps name."""
        return Counts(
            bodies=len(self.bodies),
            dimension=self.dimension,
            links=[len(chain.start_gaps) for chain in self.chains],
            seen_parameters=[len(law.parameters()) for _, _, law, _ in self._rows],
            link_parameters=[len(chain._law.parameters()) for chain in self.chains],
        )

    def note_gaps(self) -> None:
        """Note the present reference gaps that are functions of time, for readers of a file, which holds no functions."""
        assert self._state is not None
        for k, chain in enumerate(self.chains):
            if chain.function is not None:
                for link, gap in gap_values(chain.reference_gap):
                    self._state.changes.append(Change(self._state.steps, NOTED, k, link, gap))

    def hand_over(self, state: BodyState) -> None:
        """Make the bodies views of a simulation's state. From then on only statements between steps change the scene."""
        self._compiled = True
        if self._elements_after is None:  # else a run goes on with bodies that came later
            self._elements_after = len(self.bodies)
        if self._cell is not None:
            self._cell.keep_inertia()
        self._state = state
        self._gravity_at_start = self._gravity
        self._at_start = [(body._velocities, body._forces, body._hidden) for body in self.bodies]
        self._rows_at_start = tuple(self._rows)
        self._chains_at_start = [(chain._law, chain._gaps, chain.function) for chain in self.chains]
        for body in self.bodies:
            body._state = state
        for k, chain in enumerate(self.chains):
            chain._state, chain._number = state, k

    def _check_colors(self) -> None:
        shaped = {body.color for body in self.bodies if not isinstance(body, PointMass)}
        met = shaped | {skin.color for skin in self.skins}
        known = met | {body.color for body in self.bodies}
        for candidate, antagonist, _, _ in self.rows:
            for color in (candidate, antagonist):
                if color not in known and known:
                    hint = closest(color, known)
                    raise LookupError(
                        f"No body has the colour '{color}' that the visibility table names{hint} If bodies of this colour "
                        "are to come later, begin with a hidden one."
                    )
                if color in known - met:
                    raise ValueError(
                        f"The visibility table names '{color}', the colour of points without a shape, which meet no "
                        f"one: name the colour of their surface{closest(color, met)}"
                    )

    def _check_numbers(self, positions: Any, velocities: Any, mass: Any, contactors: ContactorTable) -> None:
        """Check the numbers of bodies and contactors of foreign classes, and those that were written into views."""
        bodies, of_contactors = np.arange(len(self.bodies)), contactors.body
        radii = contactors.bounding_radius
        for what, values, owner, bound, sound in (
            ("position", positions, bodies, "finite", np.abs(positions) <= LARGEST),
            ("velocity", velocities, bodies, "finite", np.abs(velocities) <= LARGEST),
            ("mass and inertia", mass[:, 1:], bodies, "above 0", mass > 0.0),
            ("offset of a contactor", contactors.offset, of_contactors, "finite", np.abs(contactors.offset) <= LARGEST),
            ("shape of a contactor", contactors.shape, of_contactors, "finite", np.abs(contactors.shape) <= LARGEST),
            ("bounding_radius of a contactor", radii, of_contactors, "above 0", radii > 0.0),
        ):
            wrong = ~sound.all(axis=tuple(range(1, sound.ndim)))
            if wrong.any():
                i = int(np.argmax(wrong))
                body = self.bodies[owner[i]]
                raise ValueError(f"The {what} of {body!r} must be {bound}, got {shown(values[i].tolist())}.")

    def _contactors(self, start: StartNumbers) -> ContactorTable:
        """The table of all contactors of bodies."""
        rows, plain = start.rows, start.plain
        surfaces = {i: body for i in start.others if isinstance(body := self.bodies[i], Surface)}
        others = [(i, *item) for i in start.others if i not in surfaces for item in self.bodies[i].contactors]
        count = plain.astype(np.int64)
        np.add.at(count, [i for i, _, _ in others], 1)
        for i, body in surfaces.items():
            count[i] = body.feature_count
        owner = np.repeat(np.arange(len(rows)), count)
        round_kind = (Disk if self.dimension == 2 else Sphere)._shape.KIND
        shapes = [contactor.shape for _, contactor, _ in others]
        widths = [of.shapes.shape[1] for body in surfaces.values() for of in body.features]
        table = np.zeros((len(owner), max([1, *map(len, shapes), *widths])))
        bounding_radius = table[:, 0] = rows[owner, RADIUS]
        sizes, middle = np.full(len(owner), np.nan), np.zeros((len(owner), self.dimension))
        half_box = np.full(middle.shape, np.nan)
        kinds = [round_kind] * len(owner)
        offset = np.zeros((len(owner), self.dimension))
        shape_size = {round_kind: 1} if plain.any() else {}
        first = np.cumsum(count) - count
        for i, body in surfaces.items():
            last = int(first[i])
            for of in body.features:
                part, last = slice(last, last + len(of.radii)), last + len(of.radii)
                table[part, : of.shapes.shape[1]], bounding_radius[part] = of.shapes, of.radii
                kinds[part] = [of.kind] * len(of.radii)
                middle[part], half_box[part], sizes[part] = of.middles, of.half_boxes, of.size
                shape_size[of.kind] = max(of.shapes.shape[1], shape_size.get(of.kind, 0))
        single = ~plain
        single[list(surfaces)] = False
        for at, (_, contactor, from_centre), shape in zip(
            np.flatnonzero(single[owner]).tolist(), others, shapes, strict=True
        ):
            if len(from_centre) != self.dimension:
                raise ValueError(
                    f"{self.bodies[owner[at]]!r} has a contactor at {shown(from_centre)} m from its centre: an offset is "
                    f"{self.dimension} numbers in {self.dimension}D."
                )
            kinds[at] = contactor.KIND
            table[at, : len(shape)] = shape
            offset[at] = from_centre
            bounding_radius[at] = contactor.bounding_radius
            shape_size[contactor.KIND] = len(shape)
        colors = [body.color for body in self.bodies]
        return ContactorTable(
            body=owner,
            offset=offset if offset.any() else np.broadcast_to(0.0, offset.shape),
            kind=kinds,
            color=colors if (count == 1).all() else [colors[i] for i in owner.tolist()],
            shape=table,
            shape_size=shape_size,
            bounding_radius=bounding_radius,
            turns=np.isin(owner, start.turning) if len(start.turning) else None,
            middle=middle if middle.any() else None,
            half_box=None if np.isnan(sizes).all() else np.where(np.isnan(half_box), bounding_radius[:, None], half_box),
            sizes=None if np.isnan(sizes).all() else np.where(np.isnan(sizes), bounding_radius, sizes),
        )

    def _with_elements(self, contactors: ContactorTable, start: StartNumbers) -> ContactorTable:
        """The table of contactors with those of the surfaces between bodies."""
        if not self.skins:
            return contactors
        before = len(self.bodies) if self._elements_after is None else self._elements_after
        tables = [skin.table for skin in self.skins]
        points = start.rows[:, : self.dimension]
        crossed = crossing(None if self._cell is None else self._cell.lattice, points)
        return contactors.with_elements(tables, points, before, crossed)

    @staticmethod
    def _alert(candidate: str, antagonist: str, alert: float | None, contactors: ContactorTable) -> float:
        if alert is not None:
            return alert
        concerned = np.array([color in (candidate, antagonist) for color in contactors.color], dtype=bool)
        radii = contactors.size[concerned & np.isfinite(contactors.size)]
        return DEFAULT_ALERT * float(radii.min()) if len(radii) else 0.0

    def _repr_html_(self) -> str:
        kinds = Counter((type(body).__name__, body.color) for body in self.bodies)
        rows = [("gravity [m/s^2]", "a function of time" if callable(self.gravity) else self.gravity)]
        rows += [(f"{kind} '{color}'", f"{count} bodies") for (kind, color), count in kinds.items()]
        rows += [(f"'{c}' sees '{a}'", repr(law)) for c, a, law, _ in self.rows]
        laws = Counter(repr(chain.law) for chain in self.chains)
        rows += [("chains", f"{count} of {law}") for law, count in laws.items()]
        return html_table(repr(self).strip("<>"), (), rows)

    def __repr__(self) -> str:
        return (
            f"<Scene in {self.dimension}D: {len(self.bodies)} bodies, {len(self.rows)} rows of the visibility table, "
            f"{len(self.chains)} chains{f', {len(self.joints)} joints' if self.joints else ''}"
            f"{', compiled' if self._compiled else ''}>"
        )


def table_of(chain: Chain, table: ChainTable) -> ChainTable:
    """The table of a chain as statements have left it; ``table`` if they have left it alone."""
    gaps = table.reference_gap if chain.function is not None else chain._gaps
    now = replace(table, laws=chain.laws, reference_gap=gaps.copy(), function=chain.gaps_in_time)
    return table if same_links(table, now) else now


def same_links(one: ChainTable, other: ChainTable) -> bool:
    """Whether two tables of a chain have the same laws and the same reference gaps."""
    if one.function is None and other.function is None:
        return one.laws == other.laws and np.array_equal(one.reference_gap, other.reference_gap)
    return one.laws == other.laws and one.function is not None and other.function is not None


def _rows_of(rows: Any) -> Iterator[tuple[str, str, Law, float | None]]:
    """Rows of a visibility table, each of four."""
    if isinstance(rows, str) or not isinstance(rows, Iterable):
        raise TypeError(f"rows must be a list of (candidate, antagonist, law, alert), got {shown(rows)}.")
    for row in rows:
        if not isinstance(row, (tuple, list)) or len(row) != 4:
            raise TypeError(f"A row of the visibility table is (candidate, antagonist, law, alert), got {shown(row)}.")
        yield tuple(row)  # type: ignore[misc]


def reach(candidate: str, antagonist: str, law: Law, contactors: ContactorTable) -> float:
    """Greatest gap at which the law acts between contactors of two colours, one of them bounded [m]."""
    bounds = []
    for color in (candidate, antagonist):
        radii = contactors.size[[color == of for of in contactors.color]]
        bounded = radii[np.isfinite(radii)]
        bounds.append({*radii[np.isinf(radii)], *([bounded.min(), bounded.max()] if len(bounded) else [])})
    pairs = [(float(one), float(other)) for one, other in itertools.product(*bounds) if min(one, other) < np.inf]
    what = f"acts_within of law '{law.NAME}'"
    return max((number(law.acts_within(*pair), what, minimum=0.0, unit="m") for pair in pairs), default=0.0)
