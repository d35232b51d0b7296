"""The description of a scene: plain arrays, numbers and words that a file can hold, and the way back to a scene.

A description holds laws by name and parameters, contactors by kind and shape, and bodies by the numbers that the model
needs. It cannot hold functions of time; it records the components on which they were imposed.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.features import SIZES
from lmgcpy.contact.lattice import Lattice
from lmgcpy.dynamics.changes import DRIVEN, LOADED
from lmgcpy.dynamics.loads import ManyForces
from lmgcpy.dynamics.model import COMPONENTS
from lmgcpy.errors import AXES, shown
from lmgcpy.laws import Law, registry
from lmgcpy.scene.body import Body, Disk, RigidBody, Wall
from lmgcpy.scene.body_3d import Capsule, CylinderWall, Sphere
from lmgcpy.scene.cell import Edge
from lmgcpy.scene.contactor import (
    Contactor,
    CylinderContactor,
    DiskContactor,
    PlaneContactor,
    RodContactor,
    SphereContactor,
    WallContactor,
    disk_area,
    disk_second_moment,
)
from lmgcpy.scene.features import Features, Surface
from lmgcpy.scene.joint import Node
from lmgcpy.scene.many_bodies import StartNumbers
from lmgcpy.scene.medium import described, media_of
from lmgcpy.scene.scene import Scene
from lmgcpy.scene.skin import PointMass, Skin, Thread
from lmgcpy.scene.solid import Material

KINDS: dict[type[Body], str] = {
    Disk: "disk",
    Wall: "wall",
    RigidBody: "rigid",
    Sphere: "sphere",
    CylinderWall: "cylinder",
    PointMass: "point",
    Capsule: "capsule",
    Surface: "surface",
}
"""Classes of bodies that a description restores; bodies of other classes come back as :class:`RecordedBody`."""

EDGES = tuple(f"edge {axis}" for axis in AXES)
"""Kinds of the edges of a periodic cell."""

_COLLIDE = (False, True, None)
"""Values of ``neighbours_collide``; a file holds the index."""

_CONDITION_FIELDS = ("body", "component", "loaded", "function", "value")

Key = tuple[int, str] | tuple[str, int] | str
Functions = Mapping[Key, Callable[[float], Any]]
"""Functions of time by id of the body and name of the component; functions of reference gaps by ``("chain", 0)``, with the
number of the chain; the function of gravity by "gravity"."""


class RecordedContactor(Contactor):
    """A contactor of a foreign kind, known by the numbers of its shape."""

    area = 0.0
    second_moment = 0.0
    bounding_radius = 0.0
    shape: tuple[float, ...] = ()
    outline: list[np.ndarray] | None = None

    def __init__(self, kind: str, shape: tuple[float, ...], bounding_radius: float, area: float, second_moment: float):
        self.KIND = kind  # type: ignore[misc]
        self.shape = shape
        self.bounding_radius = bounding_radius
        self.area = area
        self.second_moment = second_moment


class RecordedBody(Body):
    """A body of a foreign class, known by the numbers that the model needs."""

    mass = 0.0
    inertia = 0.0
    link_radius = 0.0
    extent = 0.0
    gravity_acts = True
    held_by_default = False
    turns = False
    contactors: list[tuple[Contactor, tuple[float, ...]]] = []  # noqa: RUF012

    def __init__(self, dimension: int, **start: Any):
        self.dimension = dimension
        super().__init__(**start)


def describe(scene: Scene) -> dict[str, Any]:
    """The description of the initial scene: a tree of dictionaries with arrays, lists, numbers and words."""
    bodies, start = scene.bodies, StartNumbers.of(scene.bodies)
    laws: list[Law] = []
    table = scene._contactors(start)
    # contactors that are no disk or sphere of lmgcpy, by their rows in the table
    surfaces = {i: body for i in start.others if isinstance(body := bodies[i], Surface)}
    odd = [contactor for i in start.others if i not in surfaces for contactor, _ in bodies[i].contactors]
    single = ~start.plain
    single[list(surfaces)] = False
    others = dict(zip(np.flatnonzero(single[table.body]).tolist(), odd, strict=True))
    first_row = {int(np.searchsorted(table.body, i)): body for i, body in surfaces.items()}
    area, second_moment = np.zeros((2, len(table.body)))
    if scene.dimension == 2:
        for sizes, size_of in ((area, disk_area), (second_moment, disk_second_moment)):
            sizes[:] = [size_of(radius) for radius in table.shape[:, 0].tolist()]
    for k, contactor in others.items():
        area[k], second_moment[k] = contactor.area, contactor.second_moment
    turning = {"body": start.turning, "rotation": start.quaternion, "inertia": start.inertias}
    colors, color = _codes([body.color for body in bodies])
    kinds, kind = _codes(table.kind)
    body_kinds, body_kind = _codes([_kind(body) for body in bodies])
    materials = list(dict.fromkeys(m for m in (getattr(body, "material", None) for body in bodies) if m is not None))
    conditions = [
        (body.id, component, loaded, value)
        for body in bodies
        for loaded, values in ((False, body._velocities), (True, body._forces))
        for component, value in values.items()
    ]
    at_points = any(node.point is not None for chain in scene.chains for node in chain.nodes)
    joints = {
        "law": np.array([_law(joint.law, laws) for joint in scene.joints], dtype=np.int64),
        "body": np.array([[body.id for body in joint.bodies] for joint in scene.joints], dtype=np.int64),
        "point": np.array([_points(joint.nodes) for joint in scene.joints], dtype=float),
        "collide": np.array([joint.collide for joint in scene.joints], dtype=bool),
    }
    of_time = np.array([chain.function is not None for chain in scene.chains], dtype=bool)
    return {
        "dimension": scene.dimension,
        # a function of time is a NaN, as no file can hold it
        "gravity": np.full(scene.dimension, np.nan) if callable(scene.gravity) else np.array(scene.gravity),
        "materials": [{"name": material.name, "density": material.density} for material in materials],
        "bodies": {
            "kinds": body_kinds,
            "kind": body_kind,
            "colors": colors,
            "color": color,
            "material": np.array([_index(getattr(body, "material", None), materials) for body in bodies], dtype=np.int64),
            "position": start.rows[:, :3].copy(),
            "velocity": start.rows[:, 3 : 3 + len(COMPONENTS[scene.dimension])].copy(),
            "mass": start.mass.copy(),
            "inertia": start.inertia.copy(),
            "link_radius": start.link_radius,
            "extent": start.extent,
            "gravity_acts": start.heavy,
            "held_by_default": np.array([body.held_by_default for body in bodies], dtype=bool),
            "hidden": np.array([body.hidden for body in bodies], dtype=bool),
        },
        **({"turning": turning} if len(start.turning) else {}),
        "contactors": {
            "kinds": kinds,
            "kind": kind,
            "body": table.body,
            "offset": np.array(table.offset),
            "shape": table.shape,
            "shape_size": np.array([table.shape_size[kind] for kind in table.kind], dtype=np.int64),
            "bounding_radius": table.bounding_radius,
            "area": area,
            "second_moment": second_moment,
            "outlines": _outlines(others, first_row, scene.dimension),
            **({} if table.sizes is None else {"size": table.sizes, "middle": middle_of(table)}),
        },
        "conditions": {
            "body": np.array([body for body, _, _, _ in conditions], dtype=np.int64),
            "component": np.array([component for _, component, _, _ in conditions], dtype=np.int64),
            "loaded": np.array([loaded for _, _, loaded, _ in conditions], dtype=bool),
            "function": np.array([callable(value) for _, _, _, value in conditions], dtype=bool),
            "value": np.array([math.nan if callable(value) else value for _, _, _, value in conditions], dtype=float),
        },
        **({"media": described(scene._media)} if scene._media else {}),
        "visibility": [
            {"candidate": c, "antagonist": a, "law": _law(law, laws), "alert": alert} for c, a, law, alert in scene.rows
        ],
        "chains": {
            "law": np.array([_law(chain.law, laws) for chain in scene.chains], dtype=np.int64),
            "closed": np.array([chain.closed for chain in scene.chains], dtype=bool),
            "neighbours_collide": np.array([_COLLIDE.index(c.neighbours_collide) for c in scene.chains], dtype=np.int64),
            "relaxation": np.array([chain.relaxation for chain in scene.chains], dtype=float),
            "body_count": np.array([len(chain.bodies) for chain in scene.chains], dtype=np.int64),
            "bodies": np.array([body.id for chain in scene.chains for body in chain.bodies], dtype=np.int64),
            "link_count": np.array([len(chain.start_gaps) for chain in scene.chains], dtype=np.int64),
            "reference_gaps": np.concatenate([chain.reference_gap for chain in scene.chains] or [np.zeros(0)]),
            **({"function": of_time} if of_time.any() else {}),
            "parameters": {str(i): dict(chain.parameters) for i, chain in enumerate(scene.chains) if chain.parameters},
            **({"points": _points([node for chain in scene.chains for node in chain.nodes])} if at_points else {}),
        },
        **({"joints": joints} if scene.joints else {}),
        **({"skins": described_skins(scene.skins), **_elements_after(scene)} if scene.skins else {}),
        **({"forces": _many_forces(scene._many_forces)} if scene._many_forces else {}),
        "laws": [
            {"name": law.NAME, "distribution": _distribution(law), "parameters": law.values} for law in laws
        ],  # last, because the tables above add their laws to the list
    }


def from_description(description: Mapping[str, Any], functions: Functions | None = None) -> Scene:
    """The scene of a description. ``functions`` gives the functions of time by body and component, ``{(3, "y"): f}``.

    Raises ValueError with a sentence if a function is missing or superfluous, and LookupError if a law or the narrow phase
    of two kinds of contactor is not registered.
    """
    scene = build(description)
    impose(scene, description, functions or {})
    return scene


def build(description: Mapping[str, Any], *, settled: bool = False) -> Scene:
    """The scene of a description without the conditions on its bodies; ``settled``: links may be off their reference."""
    laws = [_make_law(**law) for law in description["laws"]]
    gravity = description["gravity"]
    scene = Scene(dimension=int(description["dimension"]), gravity=None if np.isnan(gravity).all() else gravity)
    scene._settled = settled
    _add_bodies(scene, description)
    _check_conditions(scene, description["conditions"])
    for row in description["visibility"]:
        # files of former versions may have two rows of the same colours
        scene._rows.append(scene._row(row["candidate"], row["antagonist"], laws[row["law"]], row["alert"]))
    chains = description["chains"]
    # in files without the field, linked neighbours always collided
    collide = chains.get("neighbours_collide", np.full(len(chains["law"]), _COLLIDE.index(True)))
    members = np.split(chains["bodies"], np.cumsum(chains["body_count"]))
    gaps = np.split(chains["reference_gaps"], np.cumsum(chains["link_count"]))
    points = _points_in(chains, "points", chains["bodies"].shape, scene.dimension)
    points_of = np.split(points, np.cumsum(chains["body_count"]))
    for i, law in enumerate(chains["law"]):
        scene.chain(
            [(scene.bodies[body], _given(point)) for body, point in zip(members[i], points_of[i], strict=True)],
            laws[law],
            reference_gap=gaps[i],
            closed=bool(chains["closed"][i]),
            relaxation=float(chains["relaxation"][i]),
            neighbours_collide=_COLLIDE[collide[i]],
            parameters=chains.get("parameters", {}).get(str(i)),  # none in files of former versions
        )
    if "joints" in description:
        joints = description["joints"]
        points = _points_in(joints, "point", joints["body"].shape, scene.dimension)
        for law, (a, b), at, collide in zip(joints["law"], joints["body"], points, joints["collide"], strict=True):
            tied, where = (scene.bodies[a], scene.bodies[b]), (_given(at[0]), _given(at[1]))
            scene.link(*tied, laws[law], at=where, neighbours_collide=bool(collide))
    _add_skins(scene, description)
    if "elements_after" in description:
        scene._elements_after = int(description["elements_after"])
        if not 0 <= scene._elements_after <= len(scene.bodies):
            raise ValueError("the surfaces between bodies come after more bodies than there are, or fewer than none")
    scene._settled = False
    if "media" in description:
        scene._media = media_of(description["media"], len(scene.bodies))
    return scene


def _points_in(table: Mapping[str, Any], name: str, shape: tuple[int, ...], dimension: int) -> np.ndarray:
    """The points of a table, (..., d), NaN for centres; ValueError if they do not fit to the bodies."""
    points = table.get(name, np.full((*shape, dimension), np.nan))  # none in files of former versions
    if points.shape != (*shape, dimension):
        raise ValueError("the points at which links act do not fit to the bodies")
    return points


def _given(point: np.ndarray) -> np.ndarray | None:
    """A point of a table, None for the centre."""
    return None if np.isnan(point).all() else point


def functions_of_time(description: Mapping[str, Any]) -> list[Key]:
    """What is a function of time: id of the body and name of the component of each condition, chains, and "gravity"."""
    conditions = description["conditions"]
    rows = zip(conditions["body"], conditions["component"], conditions["function"], strict=True)
    names = COMPONENTS[description["dimension"]]
    found: list[Key] = [(int(body), names[component]) for body, component, function in rows if function]
    found += [("chain", k) for k in chains_of_time(description)]
    found += [("pressure", k) for k in _loads_of_time(description, "skins", "pressure")]
    found += [("forces", k) for k in _loads_of_time(description, "forces", "value")]
    return found + (["gravity"] if np.isnan(description["gravity"]).all() else [])


def _loads_of_time(description: Mapping[str, Any], table: str, name: str) -> list[int]:
    """Numbers of the pressures, or of the forces on many bodies, that are functions of time."""
    return [k for k, row in enumerate(trees_in_order(description, table)) if np.isnan(row[name]).any()]


def trees_in_order(description: Mapping[str, Any], table: str) -> list[Mapping[str, Any]]:
    """The rows of a table of trees, which are named by their numbers; none in files of former versions."""
    rows = description.get(table, {})
    return [rows[str(k)] for k in range(len(rows))]


def described_skins(skins: Sequence[Skin]) -> dict[str, dict[str, Any]]:
    """The surfaces between bodies, by their numbers."""
    return {
        str(k): {
            "bodies": np.array([body.id for body in skin.bodies], dtype=np.int64),
            "cells": skin.cells,
            "radius": skin.radius,
            "color": skin.color,
            "loaded": skin.pressure is not None,
            "pressure": math.nan if callable(skin.pressure) else skin.pressure or 0.0,
        }
        for k, skin in enumerate(skins)
    }


def _elements_after(scene: Scene) -> dict[str, int]:
    """The number of bodies before the surfaces between bodies, if others came later: contactors keep their numbers."""
    there = scene._elements_after
    return {} if there is None or there == len(scene.bodies) else {"elements_after": there}


def _many_forces(many: Sequence[ManyForces]) -> dict[str, dict[str, Any]]:
    return {
        str(k): {"bodies": forces.bodies, "value": np.full(1, math.nan) if callable(forces.value) else forces.value}
        for k, forces in enumerate(many)
    }


def _add_skins(scene: Scene, description: Mapping[str, Any]) -> None:
    for row in trees_in_order(description, "skins"):
        bodies, cells = row["bodies"], row["cells"]
        if not (bodies.ndim == 1 and cells.ndim == 2 and cells.shape[1] in (2, 3) and cells.min(initial=0) >= 0):
            raise ValueError("the fields of a skin do not fit together")
        nodes = [Node(scene.bodies[k], None) for k in bodies.tolist()]
        skin = scene._skin(nodes, cells, Thread(float(row["radius"]), color=row["color"]), scene._settled)
        skin._pressure = float(row["pressure"]) if row["loaded"] else None
        for chain in scene.chains:
            if [body.id for body in chain.bodies] == bodies.tolist():
                chain.skin = skin
    for row in trees_in_order(description, "forces"):
        scene._many_forces.append(ManyForces(row["bodies"], row["value"]))


def chains_of_time(description: Mapping[str, Any]) -> list[int]:
    """Numbers of the chains whose reference gaps are functions of time."""
    return np.flatnonzero(description["chains"].get("function", np.zeros(0, dtype=bool))).tolist()


def asked_again(functions: list[Key]) -> str:
    """Functions of time as one writes them in a call: ``(3, "y"): f, "gravity": f``."""
    words = (str(key).replace("'", '"') if isinstance(key, tuple) else f'"{key}"' for key in functions)
    return ", ".join(f"{word}: f" for word in words)


# ---------------------------------------------------------------------------------------------- scene to description


def _outlines(contactors: dict[int, Contactor], surfaces: dict[int, Surface], dimension: int) -> dict[str, np.ndarray]:
    """Polylines of the contactors, by row, that have some, and of ``surfaces`` by their first row: the contactor of each,
    its number of points, and the points [m].

    Raises ValueError with a sentence if an outline is no polyline.
    """
    owners, lines = [], []
    for k, contactor in contactors.items():
        outline = contactor.outline
        if outline is None:
            continue
        must = f"outline of {contactor!r} must be polylines of shape (v, {dimension}) [m]"
        try:
            found = [np.array(line, dtype=float) for line in outline]
        except (TypeError, ValueError) as error:
            raise ValueError(f"{must}, got {shown(outline)}.") from error
        for points in found:
            if points.ndim != 2 or points.shape[1] != dimension or not np.isfinite(points).all():
                raise ValueError(f"{must}, got {shown(points)} among them.")
            owners.append(k)
            lines.append(points)
    owner, count = [np.array(owners, dtype=np.int64)], [np.array([len(line) for line in lines], dtype=np.int64)]
    for row, body in surfaces.items():
        for of in body.features:
            closed = of.places if of.places.shape[1] < 3 else np.concatenate([of.places, of.places[:, :1]], axis=1)
            owner.append(row + np.arange(len(closed)))
            count.append(np.full(len(closed), closed.shape[1]))
            lines.append(closed.reshape(-1, dimension))
            row += len(closed)
    points = np.concatenate([np.zeros((0, dimension)), *lines])
    return {"contactor": np.concatenate(owner), "count": np.concatenate(count), "point": points}


def outlines_of(table: Mapping[str, Any]) -> list[tuple[int, np.ndarray]]:
    """Contactor and points [m], (v, d), of each polyline in the table of contactors of a description.

    Files of former versions have none. Raises ValueError if the fields do not fit together.
    """
    outlines = table.get("outlines")
    if outlines is None:
        return []
    owner, count, point = outlines["contactor"], outlines["count"], outlines["point"]
    sound = len(owner) == len(count) and (count >= 0).all() and count.sum() == len(point) and np.isfinite(point).all()
    if not sound or (len(owner) and not (owner.min() >= 0 and owner.max() < len(table["body"]))):
        raise ValueError("the outlines of contactors do not fit together")
    return list(zip(owner.tolist(), np.split(point, np.cumsum(count)[:-1]), strict=False))


def lattice_of(description: Mapping[str, Any]) -> Lattice | None:
    """The lattice of the periodic cell in a description, None without a cell."""
    bodies = description["bodies"]
    if not set(EDGES) & set(bodies["kinds"]):
        return None
    kinds = np.array(bodies["kinds"])[bodies["kind"]]
    rows = np.flatnonzero(np.isin(kinds, EDGES))
    axes = np.array([EDGES.index(kind) for kind in kinds[rows].tolist()], dtype=np.int64)
    d = int(description["dimension"])
    if len(set(axes.tolist())) < len(axes) or axes.max() >= d:
        raise ValueError(f"its periodic cell has the edges {', '.join(AXES[k] for k in axes)} in {d}D")
    order = np.argsort(axes)
    return Lattice(rows[order], axes[order], d)


def _kind(body: Body) -> str:
    """The kind of a body in descriptions."""
    return EDGES[body.axis] if isinstance(body, Edge) else KINDS.get(type(body), "other")


def _codes(words: list[str]) -> tuple[list[str], np.ndarray]:
    """The different words, and the index of each entry among them, (n,) int64."""
    table = list(dict.fromkeys(words))
    index = {word: i for i, word in enumerate(table)}
    return table, np.array([index[word] for word in words], dtype=np.int64)


def _points(nodes: Sequence[Node]) -> np.ndarray:
    """The points of some nodes [m], (k, d), NaN for centres."""
    nowhere = np.full(nodes[0].body.dimension, np.nan)
    return np.array([nowhere if node.point is None else node.point for node in nodes])


def _index(item: Any, items: list) -> int:
    return -1 if item is None else items.index(item)


def _law(law: Law, laws: list[Law]) -> int:
    """Index of the law in the list; a new law is added."""
    if law not in laws:
        laws.append(law)
    return laws.index(law)


def _distribution(law: Law) -> str:
    registration = registry.registrations().get(law.NAME)
    return registration.distribution if registration is not None and registration.law is type(law) else "unregistered"


# ---------------------------------------------------------------------------------------------- description to scene


def _make_law(name: str, distribution: str, parameters: Mapping[str, float | None]) -> Law:
    kind = registry.get(name)
    now = registry.registrations()[name].distribution
    if now != distribution:
        logging.getLogger("lmgcpy").warning("Law '%s' came from %s and now comes from %s.", name, distribution, now)
    return kind(**{parameter: value for parameter, value in parameters.items() if value is not None})


def _add_bodies(scene: Scene, description: Mapping[str, Any]) -> None:
    bodies = description["bodies"]
    materials = [Material(**material) for material in description["materials"]]
    of_body: list[list[int]] = [[] for _ in bodies["mass"]]
    for k, body in enumerate(description["contactors"]["body"].tolist()):
        of_body[body].append(k)
    turning = _turning_of(description)
    # bodies of one kind, colour and material that follow each other are made at once
    alike = zip(*(bodies[name].tolist() for name in ("kind", "color", "material")), strict=True)
    for (kind_code, color_code, material_code), run in groupby(range(len(of_body)), key=list(alike).__getitem__):
        rows = list(run)
        kind, color = bodies["kinds"][kind_code], bodies["colors"][color_code]
        if kind in ("disk", "sphere"):
            material = materials[material_code] if material_code >= 0 else None
            _add_round(scene, description, Disk if kind == "disk" else Sphere, color, material, rows, of_body)
            continue
        for i in rows:
            scene._join([_one_body(scene.dimension, description, kind, color, i, of_body[i], turning.get(i))])
    lattice = lattice_of(description)
    if lattice is not None:
        edges = [scene.bodies[i] for i in lattice.rows]
        scene._take_edges([edge for edge in edges if isinstance(edge, Edge)])
    if "hidden" in bodies:  # not in files of former versions
        for i in np.flatnonzero(bodies["hidden"]).tolist():
            scene.bodies[i].hide()


def _add_round(
    scene: Scene,
    description: Mapping[str, Any],
    kind: type[Disk] | type[Sphere],
    color: str,
    material: Material | None,
    rows: list[int],
    of_body: list[list[int]],
) -> None:
    """Add the disks or spheres of some rows of the table of bodies."""
    bodies, d = description["bodies"], scene.dimension
    position, velocity = bodies["position"][rows], bodies["velocity"][rows]
    scene._add_round(
        kind,
        description["contactors"]["shape"][[of_body[i][0] for i in rows], 0],
        position[:, :d],
        velocities=velocity[:, :d],
        spins=velocity[:, 2] if d == 2 else velocity[:, 3:],
        masses=bodies["mass"][rows],
        inertias=bodies["inertia"][rows],
        rotations=position[:, 2] if d == 2 else None,
        material=material,
        color=color,
    )


def _turning_of(description: Mapping[str, Any]) -> dict[int, tuple[np.ndarray, Any]]:
    """Rotation and inertia of the bodies that keep a rotation in space, by row; ValueError if the fields do not fit."""
    table = description.get("turning")
    if table is None:
        return {}
    body, rotation, inertia = table["body"], table["rotation"], table["inertia"]
    if not (body.ndim == 1 and rotation.shape == (len(body), 4) and inertia.shape == (len(body), 3)):
        raise ValueError("the fields of bodies that turn do not fit together")
    alike = (inertia == inertia[:, :1]).all(axis=1)
    inertias = [float(row[0]) if one else row for row, one in zip(inertia, alike.tolist(), strict=True)]
    return dict(zip(body.tolist(), zip(rotation, inertias, strict=True), strict=True))


def _one_body(
    dimension: int,
    description: Mapping[str, Any],
    kind: str,
    color: str,
    i: int,
    of_body: list[int],
    turning: tuple[np.ndarray, Any] | None,
) -> Body:
    """The body of a row of the table of bodies, with its contactors, that is no disk or sphere; ``turning``: its rotation
    and inertia if it keeps a rotation in space."""
    bodies, table = description["bodies"], description["contactors"]
    parts = [] if kind == "surface" else of_body
    contactors = [(_contactor(table, k), tuple(table["offset"][k].tolist())) for k in parts]
    position, velocity = bodies["position"][i], bodies["velocity"][i]
    start: dict[str, Any] = {"color": color, "velocity": velocity[:dimension]}
    start |= {"spin": float(velocity[2]), "rotation": float(position[2])} if dimension == 2 else {"spin": velocity[3:]}
    mass, inertia = float(bodies["mass"][i]), float(bodies["inertia"][i])
    if turning is not None:
        start["rotation"], inertia = turning
    made: Body
    if kind == "wall":
        contactor = contactors[0][0]
        held = None if mass == math.inf else mass
        made = Wall(point=position[:dimension], normal=contactor.shape, mass=held, **start)
        made._contactor = contactor
    elif kind == "cylinder":
        shape, held = contactors[0][0].shape, None if mass == math.inf else mass
        made = CylinderWall(point=position, axis=shape[:3], radius=shape[3], mass=held, **start)
        made._contactor = contactors[0][0]
    elif kind in EDGES:
        held = None if mass == math.inf else mass
        made = Edge(EDGES.index(kind), position[:dimension], mass=held, velocity=velocity[:dimension])
    elif kind == "capsule":
        rod = contactors[0][0]
        assert isinstance(rod, RodContactor)
        made = Capsule(radius=rod.radius, length=2.0 * rod.half[2], mass=mass, position=position, **start)
        at = int(bodies["material"][i])
        made.material = Material(**description["materials"][at]) if at >= 0 else None
    elif kind == "surface":
        at = int(bodies["material"][i])
        made = Surface(
            features_in(table, of_body),
            mass=mass if np.isfinite(mass) else None,
            inertia=inertia if np.isfinite(inertia).all() else None,
            held=bool(bodies["held_by_default"][i]),
            material=Material(**description["materials"][at]) if at >= 0 else None,
            position=position[:dimension],
            **start,
        )
    elif kind == "point":
        made = PointMass(position=position[:dimension], mass=mass, color=color, velocity=velocity[:dimension])
    elif kind == "rigid":
        made = RigidBody(contactors, mass=mass, inertia=inertia, position=position[:dimension], **start)
    else:
        made = RecordedBody(dimension, position=position[:dimension], **start)
        vars(made).update(
            mass=mass,
            inertia=inertia,
            turns=turning is not None,
            contactors=contactors,
            link_radius=float(bodies["link_radius"][i]),
            extent=float(bodies["extent"][i]),
            gravity_acts=bool(bodies["gravity_acts"][i]),
            held_by_default=bool(bodies["held_by_default"][i]),
        )
    return made


def _contactor(table: Mapping[str, Any], k: int) -> Contactor:
    kind = table["kinds"][table["kind"][k]]
    shape = tuple(table["shape"][k, : table["shape_size"][k]].tolist())
    if kind == DiskContactor.KIND:
        return DiskContactor(shape[0])
    if kind in (WallContactor.KIND, PlaneContactor.KIND):
        wall = WallContactor(shape) if kind == WallContactor.KIND else PlaneContactor(shape)
        wall.normal = np.array(shape)  # not normalised again, which could change the last bit
        return wall
    if kind == SphereContactor.KIND:
        return SphereContactor(shape[0])
    if kind == RodContactor.KIND:
        return RodContactor(shape[0], shape[1:])
    if kind == CylinderContactor.KIND:
        cylinder = CylinderContactor(shape[:3], shape[3])
        cylinder.axis = np.array(shape[:3])
        return cylinder
    sizes = (float(table[name][k]) for name in ("bounding_radius", "area", "second_moment"))
    recorded = RecordedContactor(kind, shape, *sizes)
    recorded.outline = [points for owner, points in outlines_of(table) if owner == k] or None
    return recorded


def features_in(table: Mapping[str, Any], of_body: list[int]) -> list[Features]:
    """The features of a surface in some rows of the table of contactors, by kind in the order in which they stand."""
    rows, kinds = np.array(of_body, dtype=np.int64), table["kind"][of_body]
    outlines = dict(outlines_of(table))
    found = []
    for code in dict.fromkeys(kinds.tolist()):
        mine = rows[kinds == code]
        places = np.array([outlines[k][: 3 if len(outlines[k]) == 4 else None] for k in mine.tolist()])
        shapes = table["shape"][mine, : int(table["shape_size"][mine[0]])]
        size, kind = float(table["size"][mine[0]]), table["kinds"][code]
        made = Features(kind, shapes, places, table["middle"][mine], table["bounding_radius"][mine], size)
        sound = size > 0.0 and np.isfinite(made.middles).all() and np.isfinite(places).all() and (made.radii > 0.0).all()
        if not sound or not shapes.shape[1] == SIZES.get(kind, shapes.shape[1]):
            raise ValueError("the features of a surface do not fit together")
        found.append(made)
    return found


def middle_of(table: ContactorTable) -> np.ndarray:
    """Centres of the bounding spheres seen from the contactors [m], (k, d)."""
    return np.zeros(table.offset.shape) if table.middle is None else table.middle


def _check_conditions(scene: Scene, conditions: Mapping[str, Any]) -> None:
    bodies, components = conditions["body"], conditions["component"]
    counts = len(scene.bodies), len(COMPONENTS[scene.dimension])
    for what, codes, count in zip(("body", "component"), (bodies, components), counts, strict=True):
        if len(codes) and not (codes.dtype.kind in "iu" and codes.min() >= 0 and codes.max() < count):
            raise ValueError(f"a condition names a {what} that does not exist")
    if bodies.ndim != 1 or any(conditions[name].shape != bodies.shape for name in _CONDITION_FIELDS):
        raise ValueError("the fields of the conditions differ in shape")
    if conditions["value"].dtype.kind != "f":
        raise ValueError("the values of conditions are no numbers")


def impose(scene: Scene, description: Mapping[str, Any], functions: Functions) -> None:
    """Impose the conditions of a description on its scene, and gravity and reference gaps if they are functions of time;
    raises the errors of :func:`from_description`."""
    conditions = description["conditions"]
    if not isinstance(functions, Mapping):
        raise TypeError(f"functions must be a dictionary such as {{(3, 'y'): f}}, got {shown(functions)}.")
    missing: list[tuple[Key, str]] = []
    left = dict(functions)
    if np.isnan(description["gravity"]).all():
        gravity = left.pop("gravity", None)
        if gravity is None:
            missing.append(("gravity", "gravity"))
        elif not callable(gravity):
            raise TypeError(f"functions['gravity'] must be a function of time, got {shown(gravity)}.")
        else:
            scene.gravity = gravity
    for body, component, loaded, function, value in zip(*(conditions[name] for name in _CONDITION_FIELDS), strict=True):
        what: Any = float(value)
        if function:
            name = COMPONENTS[scene.dimension][component]
            what = left.pop((int(body), name), None)
            if what is None:
                what = f"the {'force' if loaded else 'velocity'} along '{name}' of {scene.bodies[body]!r}"
                missing.append(((int(body), name), what))
                continue
            if not callable(what):
                raise TypeError(f"functions[{int(body)}, '{name}'] must be a function of time, got {shown(what)}.")
        scene.bodies[body]._take(LOADED if loaded else DRIVEN, int(component), what)
    for k in chains_of_time(description):
        what = left.pop(("chain", k), None)
        if what is None:
            missing.append((("chain", k), f"the reference_gap of chain {k}"))
        elif not callable(what):
            raise TypeError(f"functions['chain', {k}] must be a function of time, got {shown(what)}.")
        else:
            scene.chains[k]._drive(what)
    for name, table, column in (("pressure", "skins", "pressure"), ("forces", "forces", "value")):
        for k in _loads_of_time(description, table, column):
            what = left.pop((name, k), None)
            if what is None:
                missing.append(((name, k), f"{name} {k}"))
            elif not callable(what):
                raise TypeError(f"functions['{name}', {k}] must be a function of time, got {shown(what)}.")
            elif name == "pressure":
                scene.skins[k]._pressure = what
            else:
                scene._many_forces[k] = replace(scene._many_forces[k], value=what)
    if missing:
        which = "; ".join(words for _, words in missing)
        again = asked_again([key for key, _ in missing])
        raise ValueError(
            f"Functions of time, which no file can hold, gave {which}. Give {'it' if len(missing) == 1 else 'them'} again, "
            f"from Python: lmgcpy.resume(path, functions={{{again}}}); lmgcpy.Scene.from_run takes the same functions."
        )
    if left:
        raise ValueError(
            f"functions names {shown(list(left))}, where the run has no function of time; "
            "keys are (id of the body, component), for example (3, 'y'), and ('chain', number of the chain)."
        )
