"""Forces and pressure of contacts on walls with ends, meshes and membranes, facet by facet."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.features import places_of
from lmgcpy.contact.lattice import crossing
from lmgcpy.contact.positions import in_plane, in_space
from lmgcpy.contact.segments import facet_distances
from lmgcpy.dynamics.loads import area_vectors
from lmgcpy.errors import named_arguments
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.scene.description import outlines_of

SAME = 1e-6
"""Part of the size of a facet by which another facet may be farther from the foot of a contact, and shares its force."""


@dataclass(frozen=True, repr=False)
class Facets(Table):
    """The f facets of all walls with ends, then of all membranes; d dimensions. In 2D they are segments."""

    surface: np.ndarray
    """Number of the surface, (f,): walls with ends in the order of their bodies, then membranes."""
    body: np.ndarray
    """Id of the wall, (f,); -1 for a membrane, which lies on many bodies."""
    facet: np.ndarray
    """Number of the facet in its surface, as it was given, (f,)."""
    position: np.ndarray
    """Mean of its corners [m], (f, d)."""
    normal: np.ndarray
    """Unit normals by the right-hand rule around the corners, in 2D to the left, (f, d). Of a surface with one side they
    point to the side that is met."""
    area: np.ndarray
    """[m^2], in 2D of a metre of depth, (f,)."""
    force: np.ndarray
    """Sum of the contact forces on the facet [N], (f, d)."""
    pressure: np.ndarray
    """``-(force . normal) / area`` [Pa], (f,): above 0 if it acts on the side to which the normal points."""

    @property
    def traction(self) -> np.ndarray:
        """``force / area`` [Pa], (f, d)."""
        return self.force / self.area[:, None]


@named_arguments
def facets(sim: Source, *, frame: int | None = None) -> Facets:
    """Contact forces on the facets of walls with ends, meshes and membranes, in the last step of a simulation or in the
    step of a ``frame`` of an open run.

    A contact acts on the facet that has its foot. If the foot is on an edge each of the two facets has half of the force,
    and at a corner all facets around it have equal parts. So the sum over the facets of a surface is the force on the
    surface, to round-off. In 2D a chain with a surface is a membrane. A pressure that ``impose_pressure`` gave, and the
    forces of links, are no contacts.

    A ball of 5 N on each half of a plate of two triangles of half a square metre:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -10.0))
    >>> plate = scene.add(lm.plate([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]))
    >>> for place in (0.3, 0.7):
    ...     ball = scene.add(lm.sphere(radius=0.1, position=(place, 1.0 - place, 0.1), mass=0.5))
    >>> scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=5)
    >>> lm.measure.facets(sim).pressure.round(6)
    array([10., 10.])
    """
    return facets_of(moment(sim, frame, "facets"))[0]


def facets_of(now: Moment) -> tuple[Facets, np.ndarray]:
    """The facets of a moment, and their corners [m], (f, d, d)."""
    d = now.positions.shape[1]
    surfaces = [*_walls(now), *_membranes(now)]
    force = np.einsum("mk,mkd->md", now.net.force, now.net.frame)
    free = (now.net.impulse[:, 0] > 0.0) & ~now.is_link
    sides = [(now.net.candidate, 1.0, free.copy()), (now.net.antagonist, -1.0, free)]
    loads = []
    for surface in surfaces:
        load = np.zeros((len(surface.corners), d))
        for bodies, sign, left in sides:
            mine = np.flatnonzero(left & surface.has[bodies])
            rho = surface.radius + 0.5 * now.net.gap[mine]
            feet = _seen_from(now, bodies[mine], now.net.point[mine]) + sign * rho[:, None] * now.net.normal[mine]
            row, facet, share = _under(now, surface, feet)
            np.add.at(load, facet, sign * share[:, None] * force[mine[row]])
            left[mine[row]] = False
        loads.append(load)
    counts = [len(surface.corners) for surface in surfaces]
    corners = np.concatenate([np.zeros((0, d, d)), *(surface.corners for surface in surfaces)])
    load, normal, area = np.concatenate([np.zeros((0, d)), *loads]), *_normals(corners)
    return Facets(
        surface=np.repeat(np.arange(len(counts)), counts),
        body=np.repeat(np.array([surface.body for surface in surfaces], dtype=np.int64), counts),
        facet=np.concatenate([np.zeros(0, np.int64), *map(np.arange, counts)]),
        position=corners.mean(axis=1) if len(corners) else np.zeros((0, d)),
        normal=normal,
        area=area,
        force=load,
        pressure=-np.einsum("fd,fd->f", load, normal) / np.where(area > 0.0, area, 1.0),
    ), corners


@dataclass(frozen=True)
class _Surface:
    """A wall with ends or a membrane; f facets, n bodies."""

    body: int
    has: np.ndarray
    """Whether a contact at a body may be on it, (n,) bool."""
    radius: float
    corners: np.ndarray
    """Corners [m], (f, d, d)."""
    met: np.ndarray
    """Corners where contacts were found, (f, d, d)."""


def _walls(now: Moment) -> list[_Surface]:
    """The walls with ends."""
    table, (count, d) = now.scene["contactors"], now.positions.shape
    kinds = np.array([kind in ("face", "line") for kind in table["kinds"]] or [False])
    mine = kinds[table["kind"]] & ~now.hidden[table["body"]]
    if not mine.any():
        return []
    outlines = [(k, points[:d]) for k, points in outlines_of(table) if mine[k]]
    rows = np.array([k for k, _ in outlines])
    of_body, own = table["body"][rows], np.array([points for _, points in outlines])
    found = []
    for body in np.unique(of_body).tolist():
        here = of_body == body
        shape = own[here] if now.rotations is None else _turned(now.rotations[body], own[here])
        before = shape if now.rotations is None else _turned_back(now.since_detection * now.spins[body], shape)
        has = np.arange(count) == body
        radius = float(table["shape"][rows[here][0], 0])
        found.append(_Surface(body, has, radius, now.positions[body] + shape, now.detected[body] + before))
    return found


def _membranes(now: Moment) -> list[_Surface]:
    """The membranes, in 2D chains with a surface."""
    (count, d), found = now.positions.shape, []
    for skin in now.skins:
        if skin["cells"].shape[1] < d:
            continue
        cells = skin["bodies"][skin["cells"]]
        places = [places_of(at, cells, crossing(now.lattice, at)) for at in (now.positions, now.detected)]
        has = np.zeros(count, dtype=bool)
        has[skin["bodies"]] = True
        found.append(_Surface(-1, has, float(skin["radius"]), *places))
    return found


def _seen_from(now: Moment, bodies: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (c, d), in a periodic cell their images next to where some bodies (c,) were at the detection [m]."""
    if now.lattice is None:
        return points
    return points - now.lattice.crossed(points - now.detected[bodies], now.lattice.edges(now.detected))


def _under(now: Moment, surface: _Surface, feet: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The facets on which contacts with these ``feet`` (c, d) act: rows of the feet, facets, and shares, (k,) each.
    Contacts at the shape that a node has of its own are not on the membrane, and are left out."""
    from scipy.spatial import cKDTree  # slow to import

    corners = surface.met
    if not len(feet):
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)
    if now.lattice is not None:  # a contact may have been found at another image
        edges = now.lattice.edges(now.detected)
        steps = np.array(list(itertools.product((-1, 0, 1), repeat=len(edges)))) @ edges
    else:
        steps = np.zeros((1, feet.shape[1]))
    images = (feet[:, None] + steps).reshape(-1, feet.shape[1])
    middle = corners.mean(axis=1)
    size = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    octave = np.floor(np.log2(np.maximum(size, 1e-300)))
    pairs = []
    for level in np.unique(octave):  # facets much larger than others do not search among all of these
        members = np.flatnonzero(octave == level)
        near = cKDTree(middle[members]).query_ball_point(images, size[members].max() * (1.0 + SAME))
        row = np.repeat(np.arange(len(images)), [len(ids) for ids in near])
        pairs.append((row, members[np.concatenate([np.zeros(0, np.int64), *map(np.array, near)]).astype(np.int64)]))
    row, facet = (np.concatenate(part) for part in zip(*pairs, strict=True))
    away = facet_distances(images[row], corners[facet])
    row = row // len(steps)
    if surface.body >= 0:  # a foot off its wall by the second order of a large turn
        lost = np.setdiff1d(np.arange(len(feet)), row)
        if len(lost):
            every, all_facets = np.repeat(lost, len(corners)), np.tile(np.arange(len(corners)), len(lost))
            row, facet = np.concatenate([row, every]), np.concatenate([facet, all_facets])
            away = np.concatenate([away, facet_distances(feet[every], corners[all_facets])])
    else:
        on = away <= SAME * size[facet]
        row, facet, away = row[on], facet[on], away[on]
    least = np.full(len(feet), np.inf)
    np.minimum.at(least, row, away)
    on = away <= least[row] + SAME * size[facet]
    row, facet = row[on], facet[on]
    return row, facet, 1.0 / np.bincount(row, minlength=len(feet))[row]


def _normals(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (f, d) and areas (f,) of facets."""
    vector = area_vectors(corners)
    area = np.linalg.norm(vector, axis=1)
    return vector / np.where(area > 0.0, area, 1.0)[:, None], area


def _turned(rotation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (f, d, d) turned by an angle [rad], or by a quaternion (4,)."""
    return in_plane(rotation, vectors) if vectors.shape[2] == 2 else in_space(rotation, vectors)


def _turned_back(turn: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (f, d, d) turned back by an angle, or by a vector (3,) [rad]."""
    if vectors.shape[2] == 2:
        return _turned(-turn, vectors)
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else turn
    return _turned(np.append(-np.sin(0.5 * angle) * axis, np.cos(0.5 * angle)), vectors)
