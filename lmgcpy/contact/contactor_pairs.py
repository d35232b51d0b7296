"""Narrow phase: one function for each pair of contactor kinds.

``narrow(position_c, shape_c, position_a, shape_a)`` gets the position (:mod:`lmgcpy.contact.positions`) and the shape (a
tuple of numbers) of the candidate's and of the antagonist's contactor and returns ``gap [m], (n_x, n_y), (p_x, p_y)``, in
space three numbers each: the distance between the surfaces, the unit normal from the antagonist to the candidate, and the
contact point, the middle of the gap. It is compiled. Angles are [rad].
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

from lmgcpy.contact.frames import cross, tangent_of
from lmgcpy.contact.positions import rotated
from lmgcpy.errors import closest, shown


@dataclass(frozen=True)
class NarrowPhase:
    """How two kinds of contactor meet. ``form``: name of the form of the rows of H, "central" if the contact point lies on
    the normal through both centres, see ``lmgcpy.solve.kernels.forms``."""

    narrow: Callable
    form: str
    flipped: bool = False

    @property
    def foreign(self) -> bool:
        """Whether the function is not lmgcpy's own; its answers are then checked at every call."""
        return self.narrow.__module__ not in OWN

    @property
    def name(self) -> str:
        """The function by its name."""
        return f"{self.narrow.__module__}.{self.narrow.__qualname__}"


OF_NODES = "nodes' "
"""Begins the kinds of contactor that lie on several bodies: "nodes' edge" is an edge between bodies."""
OF_SURFACES = ("lmgcpy.contact.features", "lmgcpy.contact.folds")
"""Modules of the narrow phases of surfaces."""
OWN = (__name__, *OF_SURFACES)
"""Modules of lmgcpy's own narrow phases."""
_pairs: dict[tuple[str, str], NarrowPhase] = {}


def register_pair(
    candidate: str, antagonist: str, narrow: Callable, *, central: bool = False, form: str | None = None
) -> None:
    """Set the narrow phase of two contactor kinds; the reverse order follows from it.

    ``central``: True only if for every position the contact point lies on the line along the normal through the centre
    of each of the two (for an unbounded contactor, which does not spin, this is not asked). ``form``: the name of another
    form of the rows of H (``docs/contributing.md``).

    Raises ValueError for a pair of lmgcpy's own. The answers of the function are checked before it is compiled and in
    every step.
    """
    if not inspect.isfunction(narrow):
        raise TypeError(f"A narrow phase is a function of the positions and shapes of two contactors, got {shown(narrow)}.")
    expected = ("position_c", "shape_c", "position_a", "shape_a")
    got = tuple(inspect.signature(narrow).parameters)
    if got != expected:
        raise TypeError(f"A narrow phase takes ({', '.join(expected)}), {narrow.__qualname__} takes ({', '.join(got)}).")
    for kinds in ((candidate, antagonist), (antagonist, candidate)):
        known = _pairs.get(kinds)
        if known is not None and not known.foreign and known.narrow is not narrow:
            raise ValueError(
                f"How '{candidate}' and '{antagonist}' meet is lmgcpy's own, and every scene of this process counts on it: "
                "give your contactor another KIND."
            )
    _pairs[candidate, antagonist] = NarrowPhase(narrow, form or ("central" if central else "lever"))


def known_pairs() -> list[tuple[str, str]]:
    """Kinds of contactors that can meet, each pair once."""
    return list(_pairs)


BY_OTHERS = {
    *(frozenset(kinds) for kinds in product(("rod", "edge", "face"), ("plane", "cylinder", "face"))),
    *(frozenset(kinds) for kinds in (("line", "wall"), ("line",))),
}
"""Kinds of which the ends or corners touch before they do."""


def can_touch(candidate: str, antagonist: str) -> bool:
    """Whether contactors of two kinds can touch by themselves: the ends of a rod meet flat and hollow walls before it does,
    and the corners and edges of two faces meet."""
    return frozenset(kind.removeprefix(OF_NODES) for kind in (candidate, antagonist)) not in BY_OTHERS


def refuse_levers(candidate: str, antagonist: str) -> None:
    """ValueError if two kinds do not meet centrally, in a scene in space in which no body keeps a rotation."""
    known = _registered(candidate, antagonist)
    if known is not None and known.foreign and known.form == "lever":
        raise ValueError(
            f"How '{candidate}' and '{antagonist}' meet is not central, so that a contact turns the bodies, but none of "
            "this scene keeps a rotation: give register_pair central=True, or the class of the contactor TURNS = True."
        )


def is_foreign(candidate: str, antagonist: str) -> bool:
    """Whether two kinds meet by a function that is not lmgcpy's own."""
    known = _registered(candidate, antagonist)
    return known is not None and known.foreign


def _registered(candidate: str, antagonist: str) -> NarrowPhase | None:
    """The narrow phase of two kinds in either order, None if there is none."""
    return _pairs.get((candidate, antagonist)) or _pairs.get((antagonist, candidate))


def find_pair(candidate: str, antagonist: str) -> NarrowPhase:
    """The narrow phase of two kinds; LookupError if there is none."""
    if (candidate, antagonist) in _pairs:
        return _pairs[candidate, antagonist]
    if (antagonist, candidate) in _pairs:
        pair = _pairs[antagonist, candidate]
        return NarrowPhase(pair.narrow, pair.form, flipped=True)
    # those of features of surfaces would hide the others
    known = [f"{c}-{a}" for (c, a), pair in _pairs.items() if pair.narrow.__module__ not in OF_SURFACES]
    raise LookupError(
        f"No narrow phase tells how contactors '{candidate}' and '{antagonist}' meet"
        f"{closest(f'{candidate}-{antagonist}', known)} Add one with lmgcpy.contact.register_pair."
    )


def disk_disk(position_c, shape_c, position_a, shape_a):
    """Two disks of radii ``shape[0]`` [m]; with coincident centres the normal is upward."""
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    distance = math.sqrt(x * x + y * y)
    gap = distance - shape_c[0] - shape_a[0]
    n_x = 0.0
    n_y = 1.0
    if distance > 0.0:
        n_x = x / distance
        n_y = y / distance
    reach = shape_a[0] + 0.5 * gap
    return gap, (n_x, n_y), (position_a[0] + reach * n_x, position_a[1] + reach * n_y)


def disk_wall(position_c, shape_c, position_a, shape_a):
    """A disk of radius ``shape_c[0]`` and the half-space behind a line with outward unit normal ``shape_a``."""
    n_x, n_y = shape_a
    distance = n_x * (position_c[0] - position_a[0]) + n_y * (position_c[1] - position_a[1])
    gap = distance - shape_c[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, (n_x, n_y), (position_c[0] - reach * n_x, position_c[1] - reach * n_y)


def sphere_sphere(position_c, shape_c, position_a, shape_a):
    """Two spheres of radii ``shape[0]`` [m]; with coincident centres the normal is upward."""
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    z = position_c[2] - position_a[2]
    distance = math.sqrt(x * x + y * y + z * z)
    gap = distance - shape_c[0] - shape_a[0]
    n = (0.0, 0.0, 1.0)
    if distance > 0.0:
        n = (x / distance, y / distance, z / distance)
    reach = shape_a[0] + 0.5 * gap
    return gap, n, (position_a[0] + reach * n[0], position_a[1] + reach * n[1], position_a[2] + reach * n[2])


def sphere_plane(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` and the half-space behind a plane with outward unit normal ``shape_a``."""
    n = shape_a
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    z = position_c[2] - position_a[2]
    distance = n[0] * x + n[1] * y + n[2] * z
    gap = distance - shape_c[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1], position_c[2] - reach * n[2])


def sphere_cylinder(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` in a hollow cylinder: ``shape_a`` is the unit vector of its axis, and its radius.

    If the centre lies on the axis, the normal is a fixed vector at right angles to it.
    """
    e_x, e_y, e_z, radius = shape_a
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    z = position_c[2] - position_a[2]
    # radial part of the centre: x - (x . e) e
    along = x * e_x + y * e_y + z * e_z
    x -= along * e_x
    y -= along * e_y
    z -= along * e_z
    distance = math.sqrt(x * x + y * y + z * z)
    # gap = R - |x - (x . e) e| - r; the normal points to the axis
    gap = radius - distance - shape_c[0]
    if distance > 0.0:
        n = (-x / distance, -y / distance, -z / distance)
    # centre on the axis: n along z x e, or along x x e if the axis is steep
    elif abs(e_z) < 0.5:
        length = math.sqrt(e_x * e_x + e_y * e_y)
        n = (-e_y / length, e_x / length, 0.0)
    else:
        length = math.sqrt(e_y * e_y + e_z * e_z)
        n = (0.0, -e_z / length, e_y / length)
    # contact point in the middle of the gap
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1], position_c[2] - reach * n[2])


APART = math.inf, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
"""Answer for contactors of which other parts are nearer: gap, normal and point."""


def sphere_rod(position_c, shape_c, position_a, shape_a):
    """A sphere of radius ``shape_c[0]`` and a rod, a sphere of radius ``shape_a[0]`` swept along a segment: from its centre
    to an end, ``shape_a[1:]`` along the axes of the body.

    The rod is what lies between its ends: beyond them the spheres of the ends are met. If the centre of the sphere lies on
    the axis, the normal is a fixed vector at right angles to it.
    """
    h = rotated((position_a[3], position_a[4], position_a[5], position_a[6]), (shape_a[1], shape_a[2], shape_a[3]))
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    z = position_c[2] - position_a[2]
    # foot of the centre on the axis, a + s h
    square = h[0] * h[0] + h[1] * h[1] + h[2] * h[2]
    s = (x * h[0] + y * h[1] + z * h[2]) / square
    if not -1.0 < s < 1.0:
        return APART
    x -= s * h[0]
    y -= s * h[1]
    z -= s * h[2]
    distance = math.sqrt(x * x + y * y + z * z)
    gap = distance - shape_c[0] - shape_a[0]
    if distance > 0.0:
        n = (x / distance, y / distance, z / distance)
    else:
        length = math.sqrt(square)
        n = tangent_of(h[0] / length, h[1] / length, h[2] / length)
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1], position_c[2] - reach * n[2])


def rod_rod(position_c, shape_c, position_a, shape_a):
    """Two rods that cross between their ends; shapes as in :func:`sphere_rod`.

    The gap is the distance of two points of the axes less both radii, which holds for any two points. So rods that are
    nearly parallel, where the nearest points are ill-conditioned, are not held apart by more than their distance. Where an
    end of one is nearest, its sphere meets the other rod.
    """
    h = rotated((position_c[3], position_c[4], position_c[5], position_c[6]), (shape_c[1], shape_c[2], shape_c[3]))
    k = rotated((position_a[3], position_a[4], position_a[5], position_a[6]), (shape_a[1], shape_a[2], shape_a[3]))
    x = position_c[0] - position_a[0]
    y = position_c[1] - position_a[1]
    z = position_c[2] - position_a[2]
    # nearest points c + s h and a + t k
    hh = h[0] * h[0] + h[1] * h[1] + h[2] * h[2]
    kk = k[0] * k[0] + k[1] * k[1] + k[2] * k[2]
    hk = h[0] * k[0] + h[1] * k[1] + h[2] * k[2]
    xh = x * h[0] + y * h[1] + z * h[2]
    xk = x * k[0] + y * k[1] + z * k[2]
    area = hh * kk - hk * hk
    if not area > 0.0:
        return APART
    s = (hk * xk - kk * xh) / area
    t = (hh * xk - hk * xh) / area
    if not (-1.0 < s < 1.0 and -1.0 < t < 1.0):
        return APART
    x += s * h[0] - t * k[0]
    y += s * h[1] - t * k[1]
    z += s * h[2] - t * k[2]
    distance = math.sqrt(x * x + y * y + z * z)
    gap = distance - shape_c[0] - shape_a[0]
    if distance > 0.0:
        n = (x / distance, y / distance, z / distance)
    else:  # the axes cut each other
        length = math.sqrt(area)
        n_x, n_y, n_z = cross(h, k)
        n = (n_x / length, n_y / length, n_z / length)
    reach = shape_a[0] + 0.5 * gap
    p_x = position_a[0] + t * k[0] + reach * n[0]
    p_y = position_a[1] + t * k[1] + reach * n[1]
    p_z = position_a[2] + t * k[2] + reach * n[2]
    return gap, n, (p_x, p_y, p_z)


register_pair("disk", "disk", disk_disk, central=True)
register_pair("disk", "wall", disk_wall, central=True)
register_pair("sphere", "sphere", sphere_sphere, central=True)
register_pair("sphere", "plane", sphere_plane, central=True)
register_pair("sphere", "cylinder", sphere_cylinder, central=True)
register_pair("sphere", "rod", sphere_rod)
register_pair("rod", "rod", rod_rod)
