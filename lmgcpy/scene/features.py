"""Walls with ends: plates, polylines and meshes. A surface is one body with a contactor for each of its features, see
:mod:`lmgcpy.contact.features`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.features import (
    DEEP,
    Corners,
    bounds,
    corner_shapes,
    edge_shapes,
    facet_shapes,
    kept_corners,
    kept_edges,
    ridges_of,
    topology,
    unique_rows,
)
from lmgcpy.errors import flag, named_arguments, number, numbers, one_of, shown, vector
from lmgcpy.scene.body import Body, Prescribed, principal_inertias
from lmgcpy.scene.clump import as_rotation
from lmgcpy.scene.contactor import Contactor
from lmgcpy.scene.facet_search import TOUCHES, first_crossing, hits_behind, is_thin, solids_behind
from lmgcpy.scene.mesh_clump import FLAT, check_closed, mesh_solid, read_surface
from lmgcpy.scene.solid import Material, Solid, principal_axes

MOST = 300_000
"""Largest number of facets of a mesh: a million take some minutes and gigabytes, and no ball feels them."""
SAME = 1e-9
"""Corners are the same within this part of the size of the surface."""
THIN = 1e-9
"""A triangle is a line if its height is this part of its longest side at the most."""
EVERYWHERE = {2: (1, 0, -1, 0, 0, 1, 0, -1), 3: (1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, *6 * (0,))}
"""Directions to corners that lie on all sides: what has them is met nowhere."""
SIDES = ("both", "outside", "inside")


@dataclass(frozen=True, eq=False)
class Features:
    """Features of one kind of a surface; m of them."""

    kind: str
    shapes: np.ndarray
    """Numbers of their shapes, (m, n)."""
    places: np.ndarray
    """Their corners along the axes of the body [m], (m, c, d)."""
    middles: np.ndarray
    """Centres of circles or spheres that contain them [m], (m, d)."""
    radii: np.ndarray
    """Radii of these [m], (m,)."""
    size: float
    """Size of the surface [m]; infinite for a wall."""

    @property
    def half_boxes(self) -> np.ndarray:
        """Half sides of boxes around the middles that contain the features, along the axes of the body [m], (m, d)."""
        return np.abs(self.places - self.middles[:, None]).max(axis=1, initial=0.0) + self.shapes[:, :1]


class FeatureContactor(Contactor):
    """One of the features of a surface."""

    __slots__ = ("_of", "_row")

    area = 0.0
    second_moment = 0.0

    def __init__(self, of: Features, row: int):
        self._of, self._row = of, row

    @property
    def KIND(self) -> str:  # type: ignore[override]
        """Kind of the feature."""
        return self._of.kind

    @property
    def TURNS(self) -> bool:  # type: ignore[override]
        """False: the body says whether it turns."""
        return False

    @property
    def shape(self) -> tuple[float, ...]:
        return tuple(self._of.shapes[self._row].tolist())

    @property
    def bounding_radius(self) -> float:
        return float(self._of.radii[self._row])

    @property
    def outline(self) -> Sequence[np.ndarray]:
        """The corners, of a triangle the first again at the end."""
        places = self._of.places[self._row]
        return [np.concatenate([places, places[:1]]) if len(places) == 3 else places]


@named_arguments
class Surface(Body):
    """A wall with ends, a plate or a mesh, that :func:`lmgcpy.wall_segment`, :func:`lmgcpy.plate`, :func:`lmgcpy.mesh` or
    :func:`lmgcpy.read_mesh` makes.

    It is held like a wall unless it was given a material, or a mass and an inertia: then it is free, and has weight. In
    space a held one keeps a rotation if it was given one, or is driven or loaded about an axis before the simulation is
    made.
    """

    def __init__(
        self,
        features: list[Features],
        *,
        mass: float | None = None,
        inertia: Any = None,
        held: bool = True,
        material: Material | None = None,
        **start: Any,
    ):
        self.dimension = features[0].middles.shape[1]
        super().__init__(**start)
        self.features, self._held, self.material = features, held, material
        self._mass = math.inf if mass is None else number(mass, "mass of a surface", above=0.0, unit="kg")
        self._inertia = math.inf if inertia is None else self._checked_inertia(inertia)

    def _checked_inertia(self, inertia: Any) -> Any:
        if self.dimension == 2:
            return number(inertia, "inertia of a surface", above=0.0, unit="kg m^2")
        return principal_inertias(inertia, "surface")

    @property
    def mass(self) -> float:
        return self._mass

    @property
    def inertia(self) -> Any:
        return self._inertia

    @property
    def contactors(self) -> list[tuple[Contactor, tuple[float, ...]]]:
        here = (0.0,) * self.dimension
        return [(FeatureContactor(of, row), here) for of in self.features for row in range(len(of.radii))]

    @property
    def feature_count(self) -> int:
        """Number of its contactors."""
        return sum(len(of.radii) for of in self.features)

    @property
    def facet_count(self) -> int:
        """Number of triangles, or of segments."""
        return len(self.features[0].radii)

    @property
    def radius(self) -> float:
        """Half of its thickness [m]."""
        return float(self.features[0].shapes[0, 0])

    @property
    def turns(self) -> bool:
        if self.dimension == 2:
            return False
        if self._state is not None and self._id < len(self._state.positions):
            return bool((self._state.turning == self._id).any())
        driven = [k for k, value in self._velocities.items() if callable(value) or value != 0.0]
        spins = any(k >= self.dimension for k in (*driven, *self._forces))
        return spins or not self._held or "_start_rotation" in vars(self)

    @property
    def extent(self) -> float:
        """Radius of a circle or sphere around the centre that contains the surface [m]; infinite if it is held, as of a
        wall."""
        return math.inf if self._held else self.reach

    @property
    def reach(self) -> float:
        """Radius of a circle or sphere around the centre that contains the surface [m]."""
        return max(float((np.linalg.norm(of.middles, axis=1) + of.radii).max(initial=0.0)) for of in self.features)

    @property
    def gravity_acts(self) -> bool:
        return not self._held

    @property
    def held_by_default(self) -> bool:
        return self._held

    def check_turning(self) -> None:
        """Nothing: a surface has no rods, and turns if it was given a rotation."""

    def _checked(self, call: str, components: Any) -> list[tuple[int, Prescribed]]:
        checked = super()._checked(call, components)
        turns = any(k >= self.dimension and (call != "impose_velocity" or value != 0.0) for k, value in checked)
        if self.dimension == 3 and turns and call != "fix" and self._state is not None and not self.turns:
            raise ValueError(
                f"{self!r} keeps no rotation, as nothing turned it when the simulation was made: give it rotation= where "
                "it is made, for example (0, 0, 0, 1), so that it can turn later."
            )
        return checked


def refuse_points_on_planes(bodies: Sequence[Body], rows: Sequence[tuple]) -> None:
    """ValueError for surfaces without radius that see each other, if one of them is free: a corner is a point then, and the
    first rounding error can put it behind a plane."""
    sharp = [body for body in bodies if isinstance(body, Surface) and body.radius == 0.0]
    for candidate, antagonist, *_ in rows:
        one = [body for body in sharp if body.color == candidate]
        other = [body for body in sharp if body.color == antagonist and not (body in one and len(one) == 1)]
        if one and other and not all(body.held_by_default for body in (*one, *other)):
            raise ValueError(
                f"{one[0]!r} and {other[-1]!r} see each other, and have no radius, so that corners and edges would pass "
                "through each other: give one of them a radius."
            )


@named_arguments
def wall_segment(
    *points: Any,
    radius: float = 0.0,
    closed: bool = False,
    sides: str = "both",
    centre: Any = None,
    material: Material | None = None,
    mass: float | None = None,
    inertia: float | None = None,
    rotation: float = 0.0,
    color: str = "WALL",
) -> Surface:
    """A wall in the plane from point to point [m]: a segment, or a polyline of several, ``closed`` or not.

    ``radius`` [m] is half of its thickness. ``sides``: which sides others touch, "both", or of a closed one only "outside"
    or "inside". Behind such a side lies a solid, which pushes out bodies that get into it. ``centre`` [m], by default the
    middle, is the point about which it turns. It is held; with a ``mass`` it may be loaded. A closed one of a ``material``,
    or any with ``mass`` and ``inertia`` about the centre, is free; ``rotation`` [rad] turns it about the centre.

    >>> import lmgcpy as lm
    >>> lm.wall_segment((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)).facet_count
    2
    """
    name = "wall_segment"
    if len(points) == 1 and np.ndim(points[0]) == 2:
        points = tuple(points[0])
    if len(points) < 2:
        raise TypeError(f"{name} takes at least two points of the plane, got {len(points)}.")
    at = np.array([vector(point, f"point {k} of {name}", 2) for k, point in enumerate(points)])
    if flag(closed, "closed") and len(at) < 3:
        raise ValueError(f"A closed {name} needs at least three points, got {len(at)}.")
    first = np.arange(len(at) if closed else len(at) - 1)
    cells = np.column_stack([first, (first + 1) % len(at)])
    length = np.linalg.norm(at[cells[:, 1]] - at[cells[:, 0]], axis=1)
    if not (length > SAME * max(1e-300, float(np.ptp(at, axis=0).max()))).all():
        k = int(length.argmin())
        raise ValueError(f"Segment {k} of {name} has no length: points {k} and {(k + 1) % len(at)} are the same.")
    one_of(sides, "sides", SIDES)
    if sides != "both" and not closed:
        raise ValueError(f'An open {name} has no solid behind it: say closed=True, or sides="both".')
    solid = polygon_solid(at) if closed else None
    if solid is not None and (sides != "both" or material is not None):
        _refuse_no_inside(name, at, cells, solid.volume)
    if solid is not None and (sides == "inside") == (solid.volume < 0.0):
        cells = cells[:, ::-1]  # normals to the left of the segments point to the side that is met
    given = {"material": material, "mass": mass, "inertia": inertia, "color": color, "rotation": rotation}
    return _surface(name, at, cells, radius, sides, centre, solid, given)


@named_arguments
def plate(
    corners: Any,
    *,
    radius: float = 0.0,
    centre: Any = None,
    mass: float | None = None,
    inertia: Any = None,
    rotation: Any = None,
    color: str = "WALL",
) -> Surface:
    """A plane convex plate in space with these ``corners`` [m], (n, 3), in order; others as of :func:`mesh`.

    >>> import lmgcpy as lm
    >>> lm.plate([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], radius=0.01).facet_count
    2
    """
    at = numbers(corners, "corners of a plate", "an array (n, 3) [m]")
    if at.ndim != 2 or at.shape[1] != 3 or len(at) < 3:
        raise ValueError(f"corners of a plate must be of shape (n, 3) [m] with n at least 3, got {at.shape}.")
    size = float(np.ptp(at, axis=0).max())
    turns = np.cross(np.roll(at, -1, axis=0) - at, np.roll(at, -2, axis=0) - np.roll(at, -1, axis=0))
    normal = turns[int(np.linalg.norm(turns, axis=1).argmax())]
    if not np.linalg.norm(normal) > THIN * size**2:
        raise ValueError("The corners of a plate lie in one line.")
    normal = normal / np.linalg.norm(normal)
    off = np.abs((at - at[0]) @ normal)
    if off.max() > 1e-6 * size:
        k = int(off.argmax())
        raise ValueError(f"Corner {k} of a plate is {off[k]:.3g} m off the plane of the others: give a mesh.")
    wrong = turns @ normal < -THIN * size**2
    if wrong.any():
        k = (int(wrong.argmax()) + 1) % len(at)
        raise ValueError(f"A plate is convex, and goes inward at its corner {k}: give a mesh, or several plates.")
    sides = np.roll(at, -1, axis=0) - at
    turned = np.arctan2(turns @ normal, (sides * np.roll(sides, -1, axis=0)).sum(axis=1)).sum()
    if turned > 3.0 * math.pi:  # a star turns by 4 pi
        raise ValueError("The corners of a plate go round it more than once: give them in order, each once.")
    triangles = np.column_stack([np.zeros(len(at) - 2, np.int64), np.arange(1, len(at) - 1), np.arange(2, len(at))])
    given = {"centre": centre, "mass": mass, "inertia": inertia, "rotation": rotation, "color": color}
    return mesh(at, triangles, radius=radius, **given)


@named_arguments
def mesh(
    points: Any,
    triangles: Any,
    *,
    radius: float = 0.0,
    sides: str = "both",
    centre: Any = None,
    material: Material | None = None,
    mass: float | None = None,
    inertia: Any = None,
    rotation: Any = None,
    color: str = "WALL",
) -> Surface:
    """A surface of ``triangles``, (m, 3) numbers of ``points`` [m], (n, 3).

    ``radius`` [m] is half of its thickness. ``sides``: which sides others touch, "both", or of a closed one only "outside"
    or "inside". Behind such a side lies a solid, which pushes out bodies that get into it. ``centre`` [m], by default the
    middle of the box around it, is the point about which it turns. It is held; with a ``mass`` [kg] it may be loaded. A
    closed one of a ``material``, or any with ``mass`` and ``inertia`` [kg m^2], is free: of a material about its centre of
    mass and principal axes, else about the centre and the axes of space, which must be principal. ``rotation``, a scipy
    ``Rotation`` or a unit quaternion, turns it about the centre.

    Points that are the same are merged. Raises TypeError or ValueError with a sentence that names the triangle: no
    triangles, lines, more than two at an edge, corners that lie inside the edge of another, an open surface with sides
    other than "both".
    """
    at = numbers(points, "points of a mesh", "an array (n, 3) [m]")
    if at.ndim != 2 or at.shape[1] != 3:
        raise ValueError(f"points of a mesh must be of shape (n, 3) [m], got {at.shape}.")
    try:
        given = np.asarray(triangles)
    except ValueError as error:  # rows of different lengths
        raise ValueError(f"triangles of a mesh must be of shape (m, 3), got {shown(triangles)}.") from error
    if given.dtype.kind not in "iu":
        raise TypeError(f"triangles of a mesh must be whole numbers, those of its points, got {shown(triangles)}.")
    return _mesh("The mesh", at, given.astype(np.int64), radius, sides, centre, material, mass, inertia, rotation, color)


@named_arguments
def read_mesh(
    path: Any,
    *,
    scale: float = 1.0,
    radius: float = 0.0,
    sides: str = "both",
    centre: Any = None,
    material: Material | None = None,
    mass: float | None = None,
    inertia: Any = None,
    rotation: Any = None,
    color: str = "WALL",
) -> Surface:
    """A surface of triangles from a file that pyvista reads, .stl, .ply, .obj or .vtp, or from a ``pyvista.PolyData``.

    ``scale`` takes its lengths to metres, 1e-3 if they are millimetres; ``centre`` [m] is in the scaled coordinates; the
    other arguments are as of :func:`mesh`. Raises the errors of :func:`mesh`, ImportError if pyvista is missing, and
    FileNotFoundError or OSError if the file cannot be read.
    """
    factor = number(scale, "scale of a mesh", above=0.0)
    name, at, triangles = read_surface(path)
    return _mesh(name, factor * at, triangles, radius, sides, centre, material, mass, inertia, rotation, color)


def _mesh(
    name: str,
    points: np.ndarray,
    triangles: np.ndarray,
    radius: float,
    sides: str,
    centre: Any,
    material: Material | None,
    mass: float | None,
    inertia: Any,
    rotation: Any,
    color: str,
) -> Surface:
    """The surface of a mesh, checked; ``name`` begins sentences."""
    one_of(sides, "sides", SIDES)
    _check_material(material)
    points, triangles = _cleaned(name, points, triangles)
    solid = None
    if sides != "both" or material is not None:
        check_closed(name, points, triangles)
        solid = mesh_solid(points, triangles)
        _refuse_no_inside(name, points, triangles, solid.volume)
        if (sides == "inside") == (solid.volume > 0.0):
            triangles = triangles[:, ::-1]
        if solid.volume < 0.0:
            solid = mesh_solid(points, triangles[:, ::-1] if sides == "inside" else triangles)
    given = {"material": material, "mass": mass, "inertia": inertia, "color": color}
    if rotation is not None:
        given["rotation"] = rotation
    return _surface(name, points, triangles, radius, sides, centre, solid, given)


def _cleaned(name: str, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a mesh in which equal points are one, and those that no triangle has are left out."""
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"{name} must have triangles of shape (m, 3), got {triangles.shape}.")
    if not len(triangles):
        raise ValueError(f"{name} has no triangles.")
    if len(triangles) > MOST:
        raise ValueError(
            f"{name} has {len(triangles)} triangles, and {MOST} are the most: mesh.decimate(0.9) of pyvista leaves a tenth."
        )
    outside = ((triangles < 0) | (triangles >= len(points))).any(axis=1)
    if outside.any():
        k = int(outside.argmax())
        raise ValueError(f"{name} has {len(points)} points, and its triangle {k} has the corners {triangles[k].tolist()}.")
    size = float(np.ptp(points, axis=0).max()) or 1.0
    _, first, same = np.unique(np.round(points / (SAME * size)), axis=0, return_index=True, return_inverse=True)
    triangles = first[same.ravel()][triangles]
    twice = (triangles == np.roll(triangles, 1, axis=1)).any(axis=1)
    corners = points[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    height = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    wrong = twice | (height <= THIN * sides**2)
    if wrong.any():
        k = int(wrong.argmax())
        at = _at(corners[k].mean(axis=0))
        raise ValueError(f"Triangle {k} of {_small(name)} is a line or a point, at {at}: take it out.")
    used, triangles = np.unique(triangles, return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3)
    _check_edges(name, points, triangles)
    return points, triangles


def _check_edges(name: str, points: np.ndarray, triangles: np.ndarray) -> None:
    """ValueError for more than two triangles at an edge, for the same triangle twice, and for T-joints."""
    edges = np.sort(np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    ends, which, uses = unique_rows(edges, len(points))
    if uses.max() > 2:
        e = int(uses.argmax())
        at = sorted(set((np.flatnonzero(which == e) % len(triangles)).tolist()))
        raise ValueError(
            f"{uses[e]} triangles of {_small(name)}, {', '.join(map(str, at))}, meet at the edge at "
            f"{_at(points[ends[e]].mean(axis=0))}: two are the most. Make bodies of its parts, and turn them alike."
        )
    # a triangle beside itself, the same way round: no edge has more than two
    least = triangles.argmin(axis=1)[:, None]
    _, first, same = np.unique(
        np.take_along_axis(triangles, (least + np.arange(3)) % 3, axis=1), axis=0, return_index=True, return_inverse=True
    )
    twice = np.flatnonzero(first[same.ravel()] != np.arange(len(triangles)))
    if len(twice):
        other = int(twice[0])
        both = f"{first[same.ravel()[other]]} and {other}"
        raise ValueError(f"Triangles {both} of {_small(name)} are the same one: leave one out.")
    # corners of the boundary that lie inside an edge of the boundary
    free = ends[uses == 1]
    if not len(free):
        return
    from scipy.spatial import cKDTree  # slow to import

    corners = np.unique(free)
    middle, half = 0.5 * (points[free[:, 0]] + points[free[:, 1]]), 0.5 * (points[free[:, 1]] - points[free[:, 0]])
    length = np.linalg.norm(half, axis=1)
    for e, near in enumerate(cKDTree(points[corners]).query_ball_point(middle, length * (1.0 - 1e-6))):
        y = points[corners[near]] - middle[e]
        off = np.linalg.norm(y - (y @ half[e])[:, None] * half[e] / length[e] ** 2, axis=1)
        if (off <= 1e-6 * length[e]).any():
            (k,) = np.flatnonzero((triangles == free[e, 0]).any(axis=1) & (triangles == free[e, 1]).any(axis=1))
            at = points[corners[near[int(off.argmin())]]]
            raise ValueError(
                f"A corner of {_small(name)}, at {_at(at)}, lies inside an edge of its triangle {k}: divide this triangle "
                "there."
            )


def _refuse_no_inside(name: str, points: np.ndarray, cells: np.ndarray, volume: float) -> None:
    """ValueError for a closed surface without an inside: it crosses itself, is flat or thin, or parts of it lie within
    others. ``volume``: the volume, or the area, with its sign."""
    d = points.shape[1]
    if d == 3:
        kind, remedy = "Triangle", "make a surface of each solid, or unite them, as boolean_union of pyvista does."
    else:
        kind, remedy = "Segment", "make a closed polyline of each part, or one around all of them."
    at = Corners(points, topology(cells, len(points), dimension=d))
    found = first_crossing(at)
    if found is not None:
        one, other = sorted(found[:2])
        raise ValueError(f"{kind}s {one} and {other} of {_small(name)} cross each other, at {_at(found[2])}: {remedy}")
    if (volume < 0.0) == (d == 3):  # normals to the right of segments point out of what goes around to the left
        at = Corners(points, topology(cells[:, ::-1], len(points), dimension=d))
    solids = solids_behind(at)
    # solids that face in and out may have no volume together, but the ones have 1 and the others not
    if abs(volume) <= FLAT * float(np.ptp(points, axis=0).max()) ** d and (solids == solids[0]).all():
        what = "volume" if d == 3 else "area"
        raise ValueError(f"{name} is flat: it encloses no {what}, so that it has no side that is outside.")
    if (solids != 1).any():
        k = int(np.argmax(solids != 1))
        where = f"{kind} {k} of {_small(name)}, at {_at(at.of_facets[k].mean(axis=0))},"
        if solids[k] > 1:
            raise ValueError(f"{where} lies within the solid of others: {remedy}")
        if is_thin(at, k):
            raise ValueError(
                f"{where} has nothing behind it: it lies on a spike, or on a part thinner than {TOUCHES:g} of the size. "
                "Leave this part out."
            )
        if d == 2:  # a closed polyline is one part
            remedy = f"{_small(name)} crosses itself at a point: {remedy}"
        else:
            remedy = "turn the order of the corners in its part."
        raise ValueError(f"{where} faces inward, and others outward: {remedy}")


def _small(name: str) -> str:
    """A name that begins a sentence, within one."""
    return name[0].lower() + name[1:]


def _at(point: np.ndarray) -> str:
    return f"({', '.join(f'{x:g}' for x in point)}) m"


def polygon_solid(points: np.ndarray) -> Solid:
    """The area within a closed polyline, of density one: negative if it goes clockwise."""
    x, y = points - points.mean(axis=0), np.roll(points, -1, axis=0) - points.mean(axis=0)
    twice = x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]
    area = 0.5 * float(twice.sum())
    shift = (twice @ (x + y)) / (6.0 * area) if area != 0.0 else np.zeros(2)
    polar = float((twice @ ((x * x) + x * y + (y * y))).sum()) / 12.0 - area * float(shift @ shift)
    return Solid(area, points.mean(axis=0) + shift, polar)


def _check_material(material: Any) -> None:
    if material is not None and not isinstance(material, Material):
        raise TypeError(f"material of a surface must be a lmgcpy.Material, got {shown(material)}.")


def _surface(
    name: str,
    points: np.ndarray,
    cells: np.ndarray,
    radius: float,
    sides: str,
    centre: Any,
    solid: Solid | None,
    given: dict[str, Any],
) -> Surface:
    """The body of a surface with these points (V, d) and cells (m, d)."""
    d, material, mass, inertia = points.shape[1], given["material"], given["mass"], given["inertia"]
    thick = number(radius, "radius of a surface", minimum=0.0, unit="m")
    _check_material(material)
    if material is not None:
        if solid is None:
            raise ValueError(f"{name} is open: without a volume a material gives it no mass. Give mass= and inertia=.")
        if centre is not None:
            raise TypeError("A surface of a material moves about its centre of mass: leave centre out.")
    held = material is None and (mass is None or inertia is None)
    axes = None
    if material is not None:
        assert solid is not None
        sign = math.copysign(1.0, solid.volume)
        weight = material.density * sign * solid.volume
        factor = 1.0 if mass is None else number(mass, "mass of a surface", above=0.0, unit="kg") / weight
        mass, moments, middle = factor * weight, factor * material.density * sign * np.asarray(solid.inertia), solid.centre
        if d == 3:
            moments, axes = principal_axes(moments)
        inertia = moments if inertia is None else inertia
        inertia = float(inertia) if d == 2 else inertia
    elif centre is None:
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    else:
        middle = vector(centre, "centre of a surface", d)
    start: dict[str, Any] = {"color": given["color"]}
    if d == 2:
        start["rotation"] = given["rotation"]
    elif axes is not None or "rotation" in given:
        turn = None if "rotation" not in given else as_rotation(given["rotation"], "surface")
        start["rotation"] = axes if turn is None else turn if axes is None else turn * axes
    places = points - middle if axes is None else axes.inv().apply(points - middle)
    return Surface(
        features_of(places, cells, thick, sides, free=not held),
        mass=mass,
        inertia=inertia,
        held=held,
        material=material,
        position=middle,
        **start,
    )


def features_of(points: np.ndarray, cells: np.ndarray, radius: float, sides: str, *, free: bool) -> list[Features]:
    """The features of a surface with these points (V, d) from its centre and cells (m, d): facets, edges, corners."""
    one_sided = sides != "both"
    net = topology(cells, len(points), dimension=points.shape[1])
    at = Corners(points, net)
    ridges = ridges_of(at)
    depth = thickness(at) / 2.0 if one_sided else DEEP
    facets = facet_shapes(at, radius, one_sided=one_sided, depth=depth, ridges=ridges)
    size = float(np.linalg.norm(points, axis=1).max()) + radius if free else math.inf
    kept, corners = kept_corners(at, one_sided=one_sided), corner_shapes(at, radius)
    if sides == "inside":  # nothing meets a corner, but its place shows how far the surface has moved
        corners = np.column_stack([corners[:, : 1 + net.dimension], np.tile(EVERYWHERE[net.dimension], (len(points), 1))])
        kept[:] = True
    # a corner without radius is a point, and a bounding sphere has a radius
    least = 1e-9 * float(np.abs(points).max())

    def features(kind: str, shapes: np.ndarray, places: np.ndarray) -> Features:
        middles, radii = bounds(places, radius)
        return Features(kind, shapes, places, middles, np.maximum(radii, least), size)

    flat = net.dimension == 2
    found = [features("line" if flat else "face", facets, at.of_facets)]
    if not flat:
        edges = kept_edges(ridges, one_sided=one_sided)
        found.append(features("edge", edge_shapes(at, radius, ridges=ridges)[edges], at.of_edges[edges]))
    found.append(features("tip" if flat else "corner", corners[kept], points[kept][:, None]))
    return found


def thickness(at: Corners) -> np.ndarray:
    """Way from the middle of each facet straight back to the next facet [m], (F,); :data:`DEEP` if there is none."""
    result = np.full(len(at.of_facets), 2.0 * DEEP)
    for ray, _, way in hits_behind(at, at.of_facets.mean(axis=1)):
        np.minimum.at(result, ray, way)
    return result
