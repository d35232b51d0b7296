"""A moment of a simulation or of a run: what the measures of a sample read, the same of both; and its chains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import Points
from lmgcpy.contact.lattice import Lattice
from lmgcpy.contact.links import offsets_in_space
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.changes import SEEN_LAW, laws_after
from lmgcpy.dynamics.interactions import InteractionView, detection_positions
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import numbers, shown, whole
from lmgcpy.io.run import Run
from lmgcpy.scene.description import describe, described_skins, lattice_of, trees_in_order

Source = Stepper | Run


@dataclass(frozen=True)
class Moment:
    """Bodies and interactions after a step; n bodies, d dimensions."""

    net: InteractionView
    positions: np.ndarray
    """[m], (n, d)."""
    extent: np.ndarray
    """Radius of the circle or sphere that holds each body [m], infinite for walls, (n,)."""
    lattice: Lattice | None
    """The lattice of the periodic cell; None without a cell."""
    laws: list[str]
    """Names of the laws of the scene."""
    links: frozenset[str]
    """Names of the laws that act in chains and joints."""
    source: Source
    number: int = -1
    """Number of the frame of a run; -1 for a simulation."""
    described: Mapping[str, Any] | None = None
    """The description of the scene from the run file, which takes some milliseconds to read; None for a simulation."""

    @cached_property
    def scene(self) -> Mapping[str, Any]:
        """The description of the scene."""
        if isinstance(self.source, Stepper):
            return describe(self.source.scene)
        return self.source.scene if self.described is None else self.described

    @property
    def hidden(self) -> np.ndarray:
        """Whether each body was hidden in the step, (n,) bool."""
        if isinstance(self.source, Stepper):
            return model_of(self.source).hidden
        return self.source.hidden(self.number, in_step=True)

    @property
    def bounded(self) -> np.ndarray:
        """Whether each body has bounds and is not hidden, (n,) bool."""
        return np.isfinite(self.extent) & ~self.hidden

    @cached_property
    def wall_normals(self) -> dict[int, np.ndarray]:
        """Outward normals of the walls that are not hidden, (d,) each, by id of the body."""
        of_all = model_of(self.source).wall_normals if isinstance(self.source, Stepper) else self.source.wall_normals
        hidden = self.hidden
        return {body: normal for body, normal in of_all.items() if not hidden[body]}

    @property
    def reference_gaps(self) -> np.ndarray:
        """Of the links of all chains, as they were then [m], (l,)."""
        if isinstance(self.source, Stepper):
            return np.asarray(self.scene["chains"]["reference_gaps"], dtype=float)
        return self.source.reference_gaps(self.number)

    @property
    def contact_laws(self) -> Iterator[tuple[str, str, str, Mapping[str, float | None]]]:
        """The rows of the visibility table as the step had them: two colours, name and parameters of their law."""
        if isinstance(self.source, Stepper):
            for row in model_of(self.source).rows:
                yield row.candidate, row.antagonist, row.law.NAME, row.law.values
            return
        # a statement between two steps acts in the second one
        given = laws_after(self.source.statements_before(self.number))
        for k, row in enumerate(self.scene["visibility"]):
            law = self.scene["laws"][row["law"]]
            parameters, names = law["parameters"], list(law["parameters"])
            if (SEEN_LAW, k) in given:
                parameters = {names[at]: value for at, value in given[SEEN_LAW, k].items()}
            yield row["candidate"], row["antagonist"], law["name"], parameters

    @property
    def velocities(self) -> np.ndarray:
        """[m/s], (n, d); in a periodic cell relative to the mean flow."""
        return self.source.velocities[:] if isinstance(self.source, Stepper) else self.source.velocities[self.number]

    @property
    def mass(self) -> np.ndarray:
        """[kg], (n,); infinite for walls without one."""
        if isinstance(self.source, Stepper):
            return model_of(self.source).mass[:, 0]
        return np.asarray(self.scene["bodies"]["mass"], dtype=float)

    @property
    def spins(self) -> np.ndarray:
        """[rad/s], (n,), in 3D along the axes of space, (n, 3)."""
        return self.source.spins[:] if isinstance(self.source, Stepper) else self.source.spins[self.number]

    @property
    def rotations(self) -> np.ndarray | None:
        """Angles turned [rad], (n,); in 3D quaternions, (n, 4), or None if no body keeps a rotation."""
        if self.positions.shape[1] == 3 and "turning" not in self.scene:
            return None
        return self.source.rotations if isinstance(self.source, Stepper) else self.source.rotations[self.number]

    @property
    def scheme(self) -> tuple[float, float]:
        """Time step [s] and theta of the step."""
        if isinstance(self.source, Run):
            return float(self.source.options["time_step"]), float(self.source.options["theta"])
        step = self.source.last_step
        return (self.source.time_step, self.source.theta) if step is None else (step.time_step, step.theta)

    @property
    def since_detection(self) -> float:
        """Time from the detection of the step to its end [s]."""
        time_step, theta = self.scheme
        return theta * time_step

    @cached_property
    def detected(self) -> np.ndarray:
        """Positions at the detection [m], (n, d)."""
        if isinstance(self.source, Stepper) and self.source.last_step is not None:
            detected = self.source.last_step.detected(self.positions)
            return np.concatenate([detected, self.positions[len(detected) :]])
        cell = None if self.lattice is None else CellMotion.of(self.lattice, self.extent)
        return detection_positions(self.positions, self.velocities, 1.0, self.since_detection, cell)

    @cached_property
    def chains(self) -> list[DescribedChain]:
        """The chains of the scene, with the reference gaps at its start."""
        return described_chains(self.scene)

    @cached_property
    def beads(self) -> np.ndarray:
        """Whether each body is a bead of a chain, (n,) bool."""
        found = np.zeros(len(self.extent), dtype=bool)
        for chain in self.chains:
            found[chain.path[chain.bead]] = True
        return found

    @cached_property
    def shaped(self) -> np.ndarray:
        """Whether each body has a shape of its own, (n,) bool: nodes of threads, nets and membranes may have none."""
        found = np.zeros(len(self.extent), dtype=bool)
        found[self._shapes[0]] = True
        return found

    @property
    def _shapes(self) -> tuple[np.ndarray, np.ndarray]:
        """Bodies of the shapes of the bodies, (k,), and whether each shape is a disk or a sphere around the centre of its
        body, (k,) bool."""
        if isinstance(self.source, Stepper):
            of_all = model_of(self.source).contactors
            own = np.ones(len(of_all.body), dtype=bool)
            if of_all.elements is not None:
                own[of_all.elements.rows] = False
            body, kind, offset = of_all.body[own], np.array(of_all.kind)[own], of_all.offset[own]
        else:
            table = self.scene["contactors"]
            body, kind, offset = table["body"], np.array(table["kinds"])[table["kind"]], table["offset"]
        return body, np.isin(kind, ("disk", "sphere")) & (offset == 0.0).all(axis=1)

    @cached_property
    def colors(self) -> dict[str, np.ndarray]:
        """The bodies that meet others by each colour, (n,) bool: by their own if they have a shape, and by the
        colours of the threads, nets and membranes whose nodes they are."""
        bodies, count = self.scene["bodies"], len(self.extent)
        found = {name: (bodies["color"] == k) & self.shaped for k, name in enumerate(bodies["colors"])}
        for skin in self.skins:
            found.setdefault(skin["color"], np.zeros(count, dtype=bool))[skin["bodies"]] = True
        return found

    @cached_property
    def skins(self) -> list[Mapping[str, Any]]:
        """The surfaces between bodies, as the description of the scene has them: bodies, cells, radius [m], and others."""
        if isinstance(self.source, Stepper):
            return list(described_skins(self.source.scene.skins).values())
        return trees_in_order(self.scene, "skins")

    @cached_property
    def turning(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ids of the bodies with inertias that keep a rotation in space, (t,), their quaternions, (t, 4), and their
        principal inertias [kg m^2], (t, 3)."""
        table = self.scene.get("turning")
        if table is None:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 4)), np.zeros((0, 3))
        rotations = self.source.rotations if isinstance(self.source, Stepper) else self.source.rotations[self.number]
        has = np.isfinite(table["inertia"]).all(axis=1)  # walls that turn have none
        body = table["body"][has]
        return body, rotations[body], table["inertia"][has]

    @property
    def moves(self) -> np.ndarray:
        """Whether each body has bounds and mass, is not hidden, and is no edge of a cell, (n,) bool."""
        found = self.bounded & np.isfinite(self.mass)
        if self.lattice is not None:
            found[self.lattice.rows] = False
        return found

    @property
    def levers_of_stress(self) -> np.ndarray:
        """The contact points seen from where their forces act on the bodies [m], (m, 2, d): from the centres of the bodies,
        and on a thread or membrane from the foot on its axis, as the nodes bear the force in parts whose mean place is
        that foot.

        The way from a node to a foot on its segment or triangle is normal to n, so that ``(lever . n) n`` leads from the
        foot to the contact point. It changes no contact of a round node itself, whose lever is along n. A node of another
        shape, a clump, keeps its lever: it is not known whether it or the thread meets the other body.
        """
        lever, n, node = np.array(self.net.lever), self.net.frame[:, 0], np.zeros(len(self.extent), dtype=bool)
        for skin in self.skins:
            node[skin["bodies"]] = True
        if not node.any():
            return lever
        body, is_round = self._shapes
        node[body[~is_round]] = False
        for side, bodies in enumerate((self.net.candidate, self.net.antagonist)):
            here = node[bodies] & ~self.is_link
            lever[here, side] = (lever[here, side] * n[here]).sum(axis=1)[:, None] * n[here]
        return lever

    @property
    def is_link(self) -> np.ndarray:
        """Whether each interaction is a link, (m,) bool."""
        return np.isin(self.net.law, list(self.links))


def moment(source: Any, frame: int | None, call: str) -> Moment:
    """The last step of a simulation, or the step that ended with a ``frame`` of an open run, by default the last.

    Raises TypeError with a sentence that names the ``call`` for anything else.
    """
    if isinstance(source, Stepper):
        if frame is not None:
            raise TypeError("frame is for run files: a simulation knows its last step only.")
        model = model_of(source)
        links = [table.law.NAME for table in model.links]
        laws = links + [row.law.NAME for row in model.rows]
        return Moment(
            source.interactions,
            source.positions,
            model.extent,
            model.lattice,
            laws,
            frozenset(links),
            source,
        )
    if not isinstance(source, Run):
        raise TypeError(
            f"{call} takes a simulation, the object that lmgcpy.Simulation(...) makes, or a run file that "
            f"lmgcpy.io.open_run opens, got {shown(source)}."
        )
    k = frame_number(source, -1 if frame is None else frame, "frame")
    scene = source.scene
    codes = [*scene["chains"]["law"].tolist(), *scene.get("joints", {"law": np.zeros(0, int)})["law"].tolist()]
    links = [scene["laws"][code]["name"] for code in dict.fromkeys(codes)]
    given = source.interactions(k), source.positions[k], source.extent, lattice_of(scene)
    return Moment(*given, list(source.laws), frozenset(links), source, k, scene)


def model_of(sim: Stepper) -> Model:
    """The model of the last step, with the bodies that were added since: until the next step they are hidden, and have
    neither bounds nor mass."""
    model = sim.model if sim.last_step is None else sim.last_step.model
    added = len(sim.positions) - len(model.mass)
    if not added:
        return model
    return replace(
        model,
        mass=np.pad(model.mass, ((0, added), (0, 0)), constant_values=np.inf),
        extent=np.pad(model.extent, (0, added), constant_values=np.inf),
        hidden=np.pad(model.hidden, (0, added), constant_values=True),
    )


def frame_number(run: Run, frame: Any, name: str) -> int:
    """The number of a frame of a run, counted from 0; ``frame`` may count from the end.

    Raises TypeError if ``frame`` is not a whole number, and IndexError if the run has no such frame; the sentence calls it
    ``name``.
    """
    k = whole(frame, name, minimum=-(2**62))
    count = run.frame_count
    if not -count <= k < count:
        have = f"has the frames 0 to {count - 1}" if count else "has no frame yet"
        raise IndexError(f"{name} {k} does not exist: the run {have}.")
    return k % count


@dataclass(frozen=True)
class Motion:
    """Bodies at an earlier state and now; n bodies, d dimensions."""

    begin: np.ndarray
    """Positions then [m], (n, d)."""
    end: np.ndarray
    """Positions now [m], (n, d)."""
    bounded: np.ndarray
    """As in :class:`Moment`, (n,) bool."""


def motion(source: Any, frame: int | None, since: Any, call: str) -> Motion:
    """The motion from a frame ``since`` of an open run to ``frame``, by default the last; in a simulation from positions
    that were copied earlier, (n, d) [m], to the present. Raises TypeError, ValueError and IndexError with a sentence."""
    if isinstance(source, Stepper):
        if frame is not None:
            raise TypeError("frame is for run files: a simulation knows its last step only.")
        end = source.positions
        begin = numbers(since, "since of a simulation", "positions copied earlier, sim.positions.copy() [m]")
        step = source.last_step
        if step is not None and begin.shape == end[: len(step.model.mass)].shape:  # of the bodies of the last step
            begin = np.concatenate([begin, end[len(begin) :]])
        if begin.shape != end.shape:
            raise ValueError(
                f"since of a simulation must be positions of all its bodies, copied earlier, {end.shape} [m], got an array "
                f"of shape {begin.shape}: since=sim.positions.copy()."
            )
        model = model_of(source)
        return Motion(begin, end, np.isfinite(model.extent) & ~model.hidden)
    if not isinstance(source, Run):
        raise TypeError(f"{call} takes a simulation or a run file that lmgcpy.io.open_run opens, got {shown(source)}.")
    first = frame_number(source, since, "since")
    last = frame_number(source, -1 if frame is None else frame, "frame")
    bounded = np.isfinite(source.extent) & ~source.hidden(last, in_step=True)
    return Motion(source.positions[first], source.positions[last], bounded)


@dataclass(frozen=True)
class DescribedChain:
    """The l links between consecutive bodies of ``path``. The path of a closed chain ends with its first body."""

    path: np.ndarray
    """Ids of the bodies, (l + 1,)."""
    radius: np.ndarray
    """Distance from where a link acts to where its gap begins, of each body [m], (l + 1,)."""
    bead: np.ndarray
    """Whether the links act at the centre of each body: it is a bead, and no body to which the chain is tied, (l + 1,)."""
    gap: np.ndarray
    """Reference gaps [m], (l,)."""
    points: Points | None
    """Where links act on these bodies, None for their centres."""

    @property
    def reference(self) -> np.ndarray:
        """Reference lengths [m], (l,)."""
        return self.gap + self.radius[:-1] + self.radius[1:]

    def places(self, positions: np.ndarray, rotations: np.ndarray | None) -> np.ndarray:
        """Where links act on each body [m], (l + 1, d).

        ``positions`` (n, d) and ``rotations`` of the bodies: angles (n,), or quaternions (n, 4); None if no body keeps one.
        """
        centres = positions[self.path]
        if self.points is None:
            return centres
        placed = centres if rotations is None else np.column_stack([centres, rotations[self.path]])
        return centres + offsets_in_space(self.points, placed)

    def course(self, lattice: Lattice | None, positions: np.ndarray, rotations: np.ndarray | None) -> np.ndarray:
        """These places, in a periodic cell each as the image nearest to the one before [m], (l + 1, d)."""
        places = self.places(positions, rotations)
        return places if lattice is None else lattice.course(places, lattice.edges(positions))


def described_chains(scene: Mapping[str, Any]) -> list[DescribedChain]:
    """The chains in the description of a scene."""
    table, link_radius = scene["chains"], np.asarray(scene["bodies"]["link_radius"], dtype=float)
    bodies = np.asarray(table["bodies"], dtype=np.int64)
    points = np.asarray(table.get("points", np.full((len(bodies), int(scene["dimension"])), np.nan)))
    ends = np.cumsum(np.asarray(table["body_count"], dtype=np.int64))[:-1]
    gaps = np.split(np.asarray(table["reference_gaps"], dtype=float), np.cumsum(table["link_count"])[:-1])
    found = []
    closed = np.asarray(table["closed"], dtype=bool).tolist()
    for path, at, gap, ring in zip(np.split(bodies, ends), np.split(points, ends), gaps, closed, strict=False):
        if ring:
            path, at = np.append(path, path[0]), np.concatenate([at, at[:1]])
        centre = np.isnan(at[:, 0])
        offset = np.where(centre[:, None], 0.0, at)
        moved = Points(offset, (offset != 0.0).any(axis=1)) if offset.any() else None
        found.append(DescribedChain(path, np.where(centre, link_radius[path], 0.0), centre, gap, moved))
    return found


def joint_rows(scene: Mapping[str, Any]) -> int:
    """Number of interactions of the joints of a scene: they come after the links of its chains."""
    return int(scene["dimension"]) * len(scene["joints"]["law"]) if "joints" in scene else 0
