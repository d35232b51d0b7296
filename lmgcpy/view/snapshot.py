"""Snapshots: a scene, a simulation or a frame of a run as arrays, from which every picture is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import FEATURES
from lmgcpy.contact.features import places_of
from lmgcpy.contact.lattice import Lattice, crossing
from lmgcpy.contact.positions import in_space
from lmgcpy.contact.segments import feet
from lmgcpy.dynamics.interactions import InteractionView
from lmgcpy.dynamics.model import COMPONENTS
from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import shown, whole
from lmgcpy.io.run import Run
from lmgcpy.measure.moment import DescribedChain, described_chains, joint_rows
from lmgcpy.scene.body import NO_ROTATION, Body
from lmgcpy.scene.contactor import (
    CylinderContactor,
    DiskContactor,
    PlaneContactor,
    RodContactor,
    SphereContactor,
    WallContactor,
)
from lmgcpy.scene.description import describe, lattice_of, outlines_of, trees_in_order
from lmgcpy.scene.scene import Scene

ROUND = (DiskContactor.KIND, SphereContactor.KIND)
FLAT = (WallContactor.KIND, PlaneContactor.KIND)


@dataclass(frozen=True)
class Contactors:
    """Positions and shapes of k contactors of one family."""

    body: np.ndarray
    """Ids of the bodies, (k,)."""
    position: np.ndarray
    """Positions [m], (k, d)."""
    shape: np.ndarray
    """Parameters of the shapes, (k, p)."""


LINKS = np.s_[:-1], np.s_[1:]
"""Beginnings and ends of the links along a chain."""


@dataclass(frozen=True)
class Forces:
    """Forces of the last step at m contacts and links. Links come first, chain by chain."""

    candidate: np.ndarray
    antagonist: np.ndarray
    """Ids, (m,)."""
    normal: np.ndarray
    """Normal force, pushing positive [N], (m,)."""
    lever: np.ndarray
    """Contact point seen from the candidate and from the antagonist [m], (m, 2, d)."""
    direction: np.ndarray
    """Normals, from the antagonist to the candidate, (m, d)."""
    link: np.ndarray
    """Normal force of each link of the chains [N], (l,)."""
    row: np.ndarray
    """Rows among all interactions, (m,): forces in joints, inside of what hangs together, are left out."""

    @classmethod
    def of(cls, net: InteractionView, scene: Mapping[str, Any]) -> Forces:
        """Forces of interactions; zero before the first step of a run."""
        links, joints = links_of(scene), joint_rows(scene)
        row = np.delete(np.arange(len(net)), np.s_[links : links + joints])
        normal = net.force[row, 0]
        link = normal[:links] if len(net) else np.zeros(links)
        return cls(net.candidate[row], net.antagonist[row], normal, net.lever[row], net.normal[row], link, row)


@dataclass(frozen=True)
class Snapshot:
    """Bodies and forces at one time; n bodies, d dimensions. ``scene`` is the result of
    :func:`lmgcpy.scene.description.describe`."""

    scene: Mapping[str, Any]
    time: float | None
    """Time [s]; None for a scene."""
    positions: np.ndarray
    """[m], (n, d)."""
    rotations: np.ndarray | None
    """Angles turned [rad], (n,); in 3D quaternions, (n, 4), or None if no body keeps a rotation."""
    velocities: np.ndarray
    """[m/s], (n, d)."""
    spins: np.ndarray
    """[rad/s], (n,), in 3D (n, 3)."""
    forces: Forces | None
    """None if no step was made yet."""
    hidden: np.ndarray
    """Whether each body is hidden, (n,) bool."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.scene["dimension"])

    @property
    def start(self) -> np.ndarray:
        """Positions at the start [m], (n, d)."""
        return self.scene["bodies"]["position"][:, : self.dimension]

    @cached_property
    def lattice(self) -> Lattice | None:
        """The lattice of the periodic cell; None without a cell."""
        return lattice_of(self.scene)

    @property
    def edges(self) -> np.ndarray:
        """Edges of the periodic cell [m], (p, d); (0, d) without one."""
        return np.zeros((0, self.dimension)) if self.lattice is None else self.lattice.edges(self.positions)

    def into_cell(self, points: np.ndarray) -> np.ndarray:
        """Displacements of points (m, d) to their images in the periodic cell [m], (m, d); zero without a cell."""
        if self.lattice is None:
            return np.zeros_like(points)
        return self.lattice.wrapped(points, self.edges) - points

    def placed(self, contactors: Contactors) -> np.ndarray:
        """Positions of contactors [m], (k, d), in a periodic cell of the images whose centres of mass lie in it."""
        return contactors.position + self.into_cell(self.positions[contactors.body])

    @cached_property
    def colors(self) -> np.ndarray:
        """Colours of the bodies in the visibility table, (n,)."""
        bodies = self.scene["bodies"]
        return np.array(bodies["colors"] or [""])[bodies["color"]]

    @cached_property
    def chains(self) -> list[DescribedChain]:
        """The chains of the scene."""
        return described_chains(self.scene)

    @cached_property
    def courses(self) -> list[np.ndarray]:
        """Where the links of each chain act, see :meth:`DescribedChain.course` [m], (l + 1, d)."""
        return [chain.course(self.lattice, self.positions, self.rotations) for chain in self.chains]

    @cached_property
    def skins(self) -> list[Mapping[str, Any]]:
        """The surfaces between bodies: bodies, cells, radius [m] and colour."""
        return trees_in_order(self.scene, "skins")

    @cached_property
    def skin_radius(self) -> np.ndarray:
        """Radius of the surface whose node each body is [m], (n,); zero for bodies that are none."""
        radius = np.zeros(len(self.positions))
        for skin in self.skins:
            radius[skin["bodies"]] = skin["radius"]
        return radius

    @cached_property
    def membranes(self) -> np.ndarray:
        """Corners of the triangles between bodies [m], (m, 3, 3), in a periodic cell those whose middles lie in it."""
        crossed = crossing(self.lattice, self.positions)
        cells = [skin["bodies"][skin["cells"]] for skin in self.skins if skin["cells"].shape[1] == 3]
        found = [places_of(self.positions, of_skin, crossed) for of_skin in cells]
        found = [corners + self.into_cell(corners.mean(axis=1))[:, None] for corners in found]
        return np.concatenate([np.zeros((0, 3, 3)), *found])

    @cached_property
    def link_count(self) -> int:
        """Number of links of all chains, which are the first interactions."""
        return links_of(self.scene)

    @cached_property
    def beads(self) -> np.ndarray:
        """Whether a body is a bead of a chain, (n,). A body above 1.5 times the median of its chain is a load."""
        part, radius = np.zeros(len(self.positions), dtype=bool), self.scene["bodies"]["link_radius"]
        for chain in self.chains:
            path = chain.path[chain.bead]
            part[path] = radius[path] <= 1.5 * np.median(radius[path]) if len(path) else False
        return part

    @cached_property
    def held(self) -> np.ndarray:
        """Whether a component of a body is held at rest, (n, 3), in 3D (n, 6): velocities, then spins."""
        table = self.scene["conditions"]
        by_default = self.scene["bodies"]["held_by_default"]
        held = np.tile(by_default[:, None], (1, len(COMPONENTS[self.dimension])))
        held[table["body"], table["component"]] = ~table["loaded"] & ~table["function"] & (table["value"] == 0.0)
        return held

    @cached_property
    def rounds(self) -> Contactors:
        """Disks and spheres, and circles that hold shapes of plug-ins without outline; the radius [m] is their shape."""
        table = self.scene["contactors"]
        chosen = np.isfinite(table["bounding_radius"]) & ~self._of_kind((RodContactor.KIND,))
        chosen[[k for k, _ in outlines_of(table)]] = False
        return self._contactors(chosen, table["bounding_radius"][:, None])

    @cached_property
    def rods(self) -> Contactors:
        """Rods; the radius, and the vector from the middle to an end [m] along the axes of space, are their shape."""
        given, d = self.scene["contactors"]["shape"], self.dimension
        shape = np.zeros((len(given), 1 + d))
        shape[:, : given.shape[1]] = given[:, : 1 + d]
        found = self._contactors(self._of_kind((RodContactor.KIND,)), shape)
        if self.rotations is not None:
            found.shape[:, 1:] = turned(found.shape[:, 1:], self.rotations[found.body])
        return found

    @cached_property
    def drawn(self) -> np.ndarray:
        """Ids of the bodies that have disks, spheres, rods or circles around them, ascending."""
        return np.unique(np.concatenate([self.rounds.body, self.rods.body]))

    @cached_property
    def outlines(self) -> list[tuple[int, np.ndarray]]:
        """Polylines of the shapes of plug-ins: id of the body, and points [m], (v, d)."""
        return self._outlines(~self._of_kind(FEATURES))

    @cached_property
    def facets(self) -> list[tuple[int, np.ndarray]]:
        """Triangles of surfaces, in the plane their segments: id of the body, and corners [m], (d, d)."""
        d = self.dimension
        return [(body, points[:d]) for body, points in self._outlines(self._of_kind(("face", "line")))]

    @cached_property
    def thickness(self) -> np.ndarray:
        """Radius of the surface of each body [m], (n,); zero for bodies that are none."""
        table, thick = self.scene["contactors"], np.zeros(len(self.positions))
        mine = self._of_kind(FEATURES)
        thick[table["body"][mine]] = table["shape"][mine, 0]
        return thick

    @cached_property
    def sharp_edges(self) -> list[tuple[int, np.ndarray]]:
        """Edges of surfaces between triangles that are not in one plane: id of the body, and ends [m], (2, 3)."""
        return self._outlines(self._of_kind(("edge",)))

    def _outlines(self, chosen: np.ndarray) -> list[tuple[int, np.ndarray]]:
        """Polylines of some contactors, (k,) bool: id of the body, and points [m], (v, d)."""
        table = self.scene["contactors"]
        lines = [(k, points) for k, points in outlines_of(table) if chosen[k] and not self.hidden[table["body"][k]]]
        owners = np.array([k for k, _ in lines], dtype=np.int64)
        placed = self._contactors(owners, np.zeros((len(table["body"]), 0)))
        found = []
        for body, position, (_, points) in zip(placed.body, placed.position, lines, strict=True):
            line = points if self.rotations is None else turned(points, self.rotations[[body]])
            found.append((int(body), position + line))
        return found

    @cached_property
    def discs(self) -> Contactors:
        """Disks and spheres alone; the radius [m] is their shape."""
        return self._contactors(self._of_kind(ROUND), self.scene["contactors"]["bounding_radius"][:, None])

    @cached_property
    def walls(self) -> Contactors:
        """Lines and planes; their outward normal is their shape."""
        return self._contactors(self._of_kind(FLAT), self.scene["contactors"]["shape"][:, : self.dimension])

    @cached_property
    def cylinders(self) -> Contactors:
        """Hollow cylinders; axis and radius [m] are their shape."""
        return self._contactors(self._of_kind((CylinderContactor.KIND,)), self.scene["contactors"]["shape"])

    @cached_property
    def unbounded(self) -> np.ndarray:
        """Whether a body has no bounds, (n,)."""
        table = self.scene["contactors"]
        without = np.zeros(len(self.positions), dtype=bool)
        without[table["body"][~np.isfinite(table["bounding_radius"])]] = True
        return without

    def _of_kind(self, kinds: tuple[str, ...]) -> np.ndarray:
        table = self.scene["contactors"]
        return np.array([kind in kinds for kind in table["kinds"]] or [False])[table["kind"]]

    def _contactors(self, chosen: np.ndarray, shape: np.ndarray) -> Contactors:
        table = self.scene["contactors"]
        chosen = np.arange(len(table["body"]))[chosen]
        chosen = chosen[~self.hidden[table["body"][chosen]]]
        body, offset = table["body"][chosen], table["offset"][chosen]
        if self.rotations is not None:
            offset = turned(offset, self.rotations[body])
        return Contactors(body, self.positions[body] + offset, shape[chosen])


def turned(points: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Points (k, d), turned by one rotation, or by one each: angles [rad] or quaternions, (1 or k,) or (1 or k, 4)."""
    if points.shape[1] == 3:
        return in_space(rotations, points)
    c, s = np.cos(rotations), np.sin(rotations)
    return np.stack([c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]], axis=-1)


STUB = 0.25
"""Length of a line inside a shape without centre, as part of the smaller bounding radius."""


def acting_lines(snap: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the line along which each interaction acts [m], (m, d) each, from the antagonist to the candidate.

    The line of a link joins the two centres. The line of a contact passes through its point and joins the centres of the
    two touching disks or spheres, or ends on the axis of a rod. At a wall or a shape of a plug-in it ends at the contact
    point; between two of these it is a short piece of the normal. In a periodic cell the antagonist is its image next to
    the candidate.
    """
    forces = snap.forces
    assert forces is not None
    c, a = forces.candidate, forces.antagonist
    # contact point from the lever of the bounded side: the lever from a wall far away would be less exact
    from_candidate = snap.positions[c] + forces.lever[:, 0]
    from_antagonist = snap.positions[a] + forces.lever[:, 1]
    start, start_is_centre = _ends(snap, a, np.where(snap.unbounded[a, None], from_candidate, from_antagonist))
    end, end_is_centre = _ends(snap, c, np.where(snap.unbounded[c, None], from_antagonist, from_candidate))
    if snap.lattice is not None:
        image = snap.lattice.nearest(from_antagonist - from_candidate, snap.edges) @ snap.edges
        start -= np.where((snap.unbounded[a] | snap.unbounded[c])[:, None], 0.0, image)
    link = np.arange(len(c)) < snap.link_count
    if link.any():
        start[link], end[link] = (np.concatenate([course[part] for course in snap.courses]) for part in LINKS)
    stub = ~(start_is_centre | end_is_centre | link)
    if stub.any():
        extent = snap.scene["bodies"]["extent"]
        half = STUB * np.minimum(extent[c[stub]], extent[a[stub]])[:, None] * forces.direction[stub]
        start[stub] -= half
        end[stub] += half
    return start, end


def _ends(snap: Snapshot, bodies: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the lines of forces that act on bodies at points (m, d) [m]: the centre of the disk or sphere that touches,
    the nearest point of the axis of the rod, or else the point; and whether it is a centre or on an axis (m,)."""
    discs, rods = snap.discs, snap.rods
    body = np.concatenate([discs.body, rods.body])
    middle, radius = np.concatenate([discs.position, rods.position]), np.concatenate([discs.shape[:, 0], rods.shape[:, 0]])
    half = np.zeros_like(middle)
    half[len(discs.body) :] = rods.shape[:, 1:]
    order = np.argsort(body, kind="stable")
    count = np.bincount(body, minlength=len(snap.positions))
    first = np.cumsum(count) - count
    # every shape of the body beside every point
    here = np.repeat(np.arange(len(bodies)), count[bodies])
    start = np.cumsum(count[bodies]) - count[bodies]
    shape = order[np.arange(len(here)) - np.repeat(start - first[bodies], count[bodies])]
    foot = feet(points[here], middle[shape], half[shape])
    away = np.abs(np.linalg.norm(points[here] - foot, axis=1) - radius[shape])
    nearest = np.lexsort((away, here))[start[count[bodies] > 0]]
    # farther away, another shape of the body touches
    only = np.bincount(snap.scene["contactors"]["body"], minlength=len(count))[bodies[here[nearest]]] == 1
    nearest = nearest[only | (away[nearest] <= 0.5 * radius[shape[nearest]])]
    ends, is_centre = points.copy(), np.zeros(len(bodies), dtype=bool)
    ends[here[nearest]], is_centre[here[nearest]] = foot[nearest], True
    return ends, is_centre


def snapshot(source: Any, frame: Any = None) -> Snapshot:
    """The snapshot of a Scene or a Simulation, or of a ``frame`` of an open run, by default the last.

    The function raises TypeError for any other source, ValueError for a frame that does not exist.
    """
    if frame is not None and isinstance(source, (Scene, Stepper)):
        raise TypeError(f"frame is for run files: a {type(source).__name__} is drawn as it is now.")
    if isinstance(source, Scene):
        return _of_scene(source)
    if isinstance(source, Stepper):
        return _of_simulation(source)
    if not isinstance(source, Run):
        raise TypeError(
            "What is drawn is a Scene, a Simulation, or a run that lmgcpy.io.open_run(path) opened, "
            f"got {shown(source)} as source."
        )
    return _of_run(source, frame_number(source, frame))


def frame_number(run: Run, frame: Any) -> int:
    """Number of a frame, counted from the start; if None, the last frame."""
    count = run.frame_count
    if count == 0:
        raise ValueError(f"There is no frame in '{run.path}' yet: wait until the run has written its first.")
    k = whole(-1 if frame is None else frame, "frame", minimum=-(2**62))
    if not -count <= k < count:
        known = f"{count} frames, 0 to {count - 1}" if count > 1 else "one frame, 0"
        raise ValueError(f"'{run.path}' has {known}, got frame {k}.")
    return k % count


def _of_scene(scene: Scene) -> Snapshot:
    d, bodies = scene.dimension, scene.bodies
    return Snapshot(
        scene=describe(scene),
        time=None,
        positions=np.array([body.position for body in bodies], dtype=float).reshape(-1, d),
        rotations=_rotations(bodies, d),
        velocities=np.array([body.velocity for body in bodies], dtype=float).reshape(-1, d),
        spins=np.array([body.spin for body in bodies], dtype=float).reshape((-1,) if d == 2 else (-1, 3)),
        forces=None,
        hidden=np.array([body.hidden for body in bodies], dtype=bool),
    )


def _rotations(bodies: list[Body], dimension: int) -> np.ndarray | None:
    """Angles of bodies [rad], (n,), in 3D their quaternions, (n, 4), or None if none keeps a rotation."""
    if dimension == 2:
        return np.array([body.rotation for body in bodies], dtype=float)
    if not any(body.turns for body in bodies):
        return None
    return np.array([body.rotation.as_quat() if body.turns else NO_ROTATION for body in bodies])


def _of_simulation(sim: Stepper) -> Snapshot:
    scene = describe(sim.scene)
    return Snapshot(
        scene=scene,
        time=sim.time,
        positions=sim.positions.copy(),
        rotations=sim.rotations.copy() if sim.model.dimension == 2 or len(sim.state.turning) else None,
        velocities=sim.velocities.copy(),
        spins=sim.spins.copy(),
        forces=Forces.of(sim.interactions, scene) if sim.steps else None,
        hidden=np.array([body.hidden for body in sim.scene.bodies], dtype=bool),
    )


def _of_run(run: Run, frame: int) -> Snapshot:
    scene = run.scene
    return Snapshot(
        scene=scene,
        time=float(run.times[frame]),
        positions=run.positions[frame],
        rotations=run.rotations[frame] if run.dimension == 2 or run.rotations.shape[2] else None,
        velocities=run.velocities[frame],
        spins=run.spins[frame],
        forces=Forces.of(run.interactions(frame), scene),
        hidden=run.hidden(frame),
    )


def links_of(scene: Mapping[str, Any]) -> int:
    """Number of links of all chains of a scene's description."""
    return int(scene["chains"]["link_count"].sum())
