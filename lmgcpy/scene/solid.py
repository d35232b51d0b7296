"""A material, and a solid made of it: volume, centre of mass and inertia, also of a union of disks or spheres.

Overlaps count once. A plane z = const cuts the spheres in disks, so that both are one formula. In the plane Green's
theorem, applied to the vector field p g(p), gives the integral of a homogeneous function g of degree k over the covered
area as

    1/(k + 2) * sum over the exposed arcs of the integral of g(p) (p . n) ds,

where p = c + r n is on the circle of radius r around c, and n = exp(i phi) in complex numbers. g = 1, p, |p|^2 and p^2
give all moments up to the second one; each integrand is a polynomial in n and 1/n, so each arc is exact. Ball j hides an
interval of angles of circle i, and the exposed arcs are what the union of these intervals leaves.

In space this is integrated over z, sphere by sphere. Between break points, which are the poles of the sphere, the extreme z
of the circles in which the others cut it, and the exposed points where two such circles meet, the integrand is analytic,
apart from square roots at the ends of an interval. z = m - h cos(theta) removes those, and Gauss's rule converges fast;
intervals where two rules differ are halved.

Unlike formulas with the vertices and arcs of the boundary (Connolly 1985, J. Am. Chem. Soc. 107, 1118), this needs no
decision about the topology. It stays right if spheres touch, or if many meet in a point or share a circle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import flag, named_arguments, number, numbers, shown

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

SAME = 1e-9
"""Moments of inertia are the same, and products of inertia are zero, within this part of the largest moment."""

TOLERANCE = 1e-13
"""Two rules on an interval must agree within this part of the moments of all spheres together. The finer one is better."""
HALVINGS = 12
"""Largest number of times that an interval is halved. Then its error is entered in the error of the result."""
TURN = 2.0 * math.pi
TOUCHING = 1e-6
"""Balls touch if their gap is this part of the smaller radius at the most: offsets are often rounded."""


@named_arguments
@dataclass(frozen=True)
class Material:
    """A material with a ``name`` and a ``density`` [kg/m^3]."""

    name: str
    density: float

    def __post_init__(self):
        if not isinstance(self.name, str) or not self.name:
            raise TypeError(f"The name of a material must be a word, got {shown(self.name)}.")
        density = number(self.density, f"density of material '{self.name}'", above=0.0, unit="kg/m^3")
        object.__setattr__(self, "density", density)


@dataclass(frozen=True)
class Solid:
    """A solid, or an area in 2D, of density one. Mass and inertia of a body are its density times these.

    ``volume`` [m^3], in 2D the area [m^2]; ``centre`` of mass (d,) [m]; ``inertia`` about it, (3, 3) [m^5], in 2D the polar
    moment [m^4]; ``error``: estimated relative error of volume and inertia.
    """

    volume: float
    centre: np.ndarray
    inertia: np.ndarray | float
    error: float = 0.0


def principal_axes(inertia: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Principal moments (3,) of an inertia tensor (3, 3), and the rotation from the principal axes to the given ones.

    The columns of the rotation's matrix Q are the principal axes, inertia = Q diag(moments) Q^T. Of all right-handed sets
    of axes they are the one at the smallest angle from the given axes. So a tensor that is diagonal, or one with three
    equal moments, gives the identity exactly, and the moments are in the order of the axes to which they are near.
    """
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    values, vectors = np.linalg.eigh(inertia)
    near = SAME * values[2]
    if np.abs(inertia - np.diag(np.diag(inertia))).max() <= near:
        axes = np.eye(3)
    elif values[1] - values[0] <= near or values[2] - values[1] <= near:
        axes = _shortest_turn(vectors[:, 2 if values[1] - values[0] <= near else 0])
    else:
        signed = [vectors[:, order] * signs for order in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
        right_handed = [q for q in signed if np.linalg.det(q) > 0.0]
        # rounded, so that noise does not choose between equal angles
        axes = max(right_handed, key=lambda q: tuple(np.round([np.trace(q), *q.ravel()], 9)))
    moments = np.diag(axes.T @ inertia @ axes)
    same = np.abs(moments[:, None] - moments) <= near
    return same @ moments / same.sum(axis=1), Rotation.from_matrix(axes)


def _shortest_turn(axis: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) of the smallest angle that turns a coordinate axis, the nearest one, to the line along ``axis``
    (3,) (Rodrigues' formula)."""
    nearest = int(np.argmax(np.round(np.abs(axis), 9)))
    axis = axis * np.sign(axis[nearest])
    turn = np.outer(axis, np.eye(3)[nearest])
    turn -= turn.T
    return np.eye(3) + turn + turn @ turn / (1.0 + axis[nearest])


def checked_balls(radii: Any, offsets: Any, *, separate: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """``radii`` (n,) and ``offsets`` (n, d) [m] of the balls of a clump as arrays of floats; d is 2 or 3.

    Raises TypeError or ValueError with a sentence if they are no balls, or if they form several parts that do not touch
    each other. Such a body is possible, but mostly it is a mistake in a unit, so ``separate=True`` must ask for it.
    """
    radii, offsets = numbers(radii, "radii of a clump"), numbers(offsets, "offsets of a clump")
    if radii.ndim != 1 or not len(radii):
        raise ValueError(f"radii of a clump must be at least one number in a row, got an array of shape {radii.shape}.")
    if offsets.ndim != 2 or offsets.shape[1] not in (2, 3) or len(offsets) != len(radii):
        raise ValueError(
            f"offsets of a clump of {len(radii)} radii must have the shape ({len(radii)}, 3), or ({len(radii)}, 2) in 2D, "
            f"got {offsets.shape}."
        )
    if radii.min() <= 0.0:
        at = int(radii.argmin())
        raise ValueError(f"radii of a clump must be above 0 m, got {radii[at]:g} m for ball {at}.")
    part = _first_part(radii, offsets)
    if not flag(separate, "separate") and not part.all():
        gaps = np.linalg.norm(offsets[part][:, None] - offsets[~part], axis=2) - radii[part][:, None] - radii[~part]
        a, b = np.unravel_index(gaps.argmin(), gaps.shape)
        raise ValueError(
            f"The balls of a clump must touch or overlap, but balls {np.flatnonzero(part)[a]} and "
            f"{np.flatnonzero(~part)[b]} are {gaps.min():g} m apart, and no others join their parts. Check the units of "
            "radii and offsets; separate=True makes one rigid body of several parts."
        )
    return radii, offsets


def _first_part(radii: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Whether each ball is joined with the first one by balls that touch, (n,)."""
    part = np.arange(len(radii)) == 0
    todo = [0]
    while todo:
        i = todo.pop()
        gap = np.linalg.norm(offsets - offsets[i], axis=1) - radii - radii[i]
        new = ~part & (gap <= TOUCHING * np.minimum(radii, radii[i]))
        part |= new
        todo += np.flatnonzero(new).tolist()
    return part


def ball_union(centres: np.ndarray, radii: np.ndarray) -> Solid:
    """The union of disks or spheres as one solid of density one; ``centres`` (n, d) and ``radii`` (n,) [m].

    Disks are exact. The relative error of spheres is some 1e-12, and ``error`` has an estimate that is larger.
    """
    centres, radii = _bare(np.asarray(centres, dtype=float), np.asarray(radii, dtype=float))
    d = centres.shape[1]
    origin, size = centres.mean(axis=0), float(radii.max())
    x, r = np.zeros((len(radii), 3)), radii / size
    x[:, :d] = (centres - origin) / size
    if d == 2:
        arcs = np.sum([_circle_moments(i, x, r, np.zeros(1)) for i in range(len(r))], axis=0)
        area, first, polar, _ = (complex(moment) for moment in arcs[:, 0])
        shift = first / area
        inertia = polar.real - area.real * abs(shift) ** 2
        return Solid(area.real * size**2, origin + size * np.array([shift.real, shift.imag]), inertia * size**4, 0.0)
    far = float((np.linalg.norm(x, axis=1) + r).max())
    scale = 4.0 / 3.0 * math.pi * float((r**3).sum()) * far ** _DEGREES
    moments, errors = np.sum([_sphere_moments(i, x, r, scale) for i in range(len(r))], axis=0)
    volume, first, second = moments[0], moments[1:4], moments[[[4, 5, 6], [5, 7, 8], [6, 8, 9]]]
    shift = first / volume
    second -= volume * np.outer(shift, shift)
    inertia = np.trace(second) * np.eye(3) - second
    error = max(errors[0] / volume, errors[4:].max() / np.linalg.eigvalsh(inertia)[0])
    return Solid(float(volume) * size**3, origin + size * shift, inertia * size**5, float(error))


_DEGREES = np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2])
"""Degrees of the moments 1, x, y, z, xx, xy, xz, yy, yz, zz."""


def union_volume(centres: np.ndarray, radii: np.ndarray) -> float:
    """Volume of a union of spheres [m^3], or area of disks [m^2]; what many sizes of one shape share is found once."""
    shape = np.column_stack([centres, radii]) / radii[0]
    return float(radii[0] ** centres.shape[1] * _volume_of_shape(shape.round(12).tobytes(), centres.shape[1]))


@lru_cache(maxsize=256)
def _volume_of_shape(shape: bytes, dimension: int) -> float:
    """Volume of a union of balls, rows (centre, radius)."""
    balls = np.frombuffer(shape).reshape(-1, dimension + 1)
    return ball_union(balls[:, :-1], balls[:, -1]).volume


def _bare(centres: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The balls that lie in no other ball; the first of equal ones."""
    order = np.argsort(-radii, kind="stable")
    kept: list[int] = []
    for i in order:
        distance = np.linalg.norm(centres[kept] - centres[i], axis=1)
        if not (distance <= radii[kept] - radii[i]).any():
            kept.append(int(i))
    kept.sort()
    return centres[kept], radii[kept]


def _planes(i: int, x: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors d (m, 3) and numbers k (m,): a point c_i + p of sphere i is in ball j if p . d_j >= k_j."""
    d = x - x[i]
    squares = (d * d).sum(axis=1)
    near = squares < (r + r[i]) ** 2
    near[i] = False
    return d[near], 0.5 * (squares + (r[i] - r) * (r[i] + r))[near]


def _circle_moments(i: int, x: np.ndarray, r: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Parts of the integrals of 1, p, |p|^2 and p^2 from the exposed arcs of sphere i at the heights ``z`` (l,) above its
    centre: (4, l) complex."""
    d, k = _planes(i, x, r)
    rho = np.sqrt(np.maximum(r[i] ** 2 - z * z, 0.0))
    across = rho[:, None] * np.hypot(d[:, 0], d[:, 1])
    level = k - z[:, None] * d[:, 2]
    half = np.arctan2(np.sqrt(np.maximum((across - level) * (across + level), 0.0)), level)  # 0: exposed, pi: hidden
    first = np.mod(np.arctan2(d[:, 1], d[:, 0]) - half, TURN)
    order = np.argsort(first, axis=1)
    first = np.take_along_axis(first, order, axis=1)
    last = first + 2.0 * np.take_along_axis(half, order, axis=1)

    # an interval that passes 2 pi hides the beginning, too
    begin = np.zeros((len(z), first.shape[1] + 1))
    begin[:, 0] = np.maximum(last.max(axis=1, initial=0.0) - TURN, 0.0)
    begin[:, 1:] = last
    begin = np.maximum.accumulate(begin, axis=1)
    end = np.hstack([first, np.full((len(z), 1), TURN)])
    end = np.maximum(begin, end)

    # integrals of 1, n, n^2, n^3 over the exposed arcs
    a, b = np.exp(1j * begin), np.exp(1j * end)
    differences = b - a, b * b - a * a, b * b * b - a * a * a
    e0 = (end - begin).sum(axis=1)
    e1, e2, e3 = (power.sum(axis=1) / (1j * q) for q, power in enumerate(differences, 1))

    # g(p) (p . n), p = c + rho n, multiplied out
    c = complex(x[i, 0], x[i, 1])
    bar, square = c.conjugate(), abs(c) ** 2
    along = (bar * e1).real
    area = rho * e0 + along
    first = 1.5 * c * rho * e0 + (0.5 * square + rho**2) * e1 + 0.5 * c**2 * e1.conj() + 0.5 * bar * rho * e2
    polar = rho * (2.0 * square + rho**2) * e0 + (square + 3.0 * rho**2) * along + rho * (bar**2 * e2).real
    mixed = 2.0 * c**2 * rho * e0 + 0.5 * c**3 * e1.conj() + 0.5 * c * (square + 5.0 * rho**2) * e1
    mixed += rho * (square + rho**2) * e2 + 0.5 * bar * rho**2 * e3
    return rho * np.array([area / 2.0, first / 3.0, polar / 4.0, mixed / 4.0])


def _sphere_moments(i: int, x: np.ndarray, r: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of the moments (10,) from the exposed part of sphere i, and estimates of their errors (10,)."""
    cuts = _break_points(*_planes(i, x, r), float(r[i]))
    middle, width = 0.5 * (cuts[1:] + cuts[:-1]), 0.5 * (cuts[1:] - cuts[:-1])
    low, high = np.zeros(len(middle)), np.full(len(middle), math.pi)
    total, errors = np.zeros(10), np.zeros(10)
    for halving in range(HALVINGS + 1):
        rough, fine = (_rule(i, x, r, middle, width, low, high, count) for count in (8, 16))
        wrong = np.abs(fine - rough)
        again = (wrong > TOLERANCE * scale).any(axis=1) & (halving < HALVINGS)
        total += fine[~again].sum(axis=0)
        errors += wrong[~again].sum(axis=0)
        if not again.any():
            break
        half = 0.5 * (low + high)[again]
        low, high = np.hstack([low[again], half]), np.hstack([half, high[again]])
        middle, width = np.tile(middle[again], 2), np.tile(width[again], 2)
    return total, errors


def _rule(
    i: int, x: np.ndarray, r: np.ndarray, middle: np.ndarray, width: np.ndarray, low: np.ndarray, high: np.ndarray, count:
    int
) -> np.ndarray:
    """Moments (intervals, 10) by Gauss's rule in theta from ``low`` to ``high``, z = middle - width cos(theta)."""
    nodes, weights = _gauss(count)
    half = 0.5 * (high - low)[:, None]
    theta = 0.5 * (high + low)[:, None] + half * nodes
    height = middle[:, None] - width[:, None] * np.cos(theta)
    area, first, polar, square = _circle_moments(i, x, r, height.ravel()).reshape(4, *height.shape)
    z = x[i, 2] + height
    xx, yy, xy = 0.5 * (polar.real + square.real), 0.5 * (polar.real - square.real), 0.5 * square.imag
    area = area.real
    moments = [area, first.real, first.imag, z * area, xx, xy, z * first.real, yy, z * first.imag, z * z * area]
    return (np.array(moments) * (weights * half * width[:, None] * np.sin(theta))).sum(axis=2).T


@cache
def _gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(count)


def _break_points(d: np.ndarray, k: np.ndarray, r: float) -> np.ndarray:
    """Heights (n,) above the centre of a sphere between which the integrand is analytic."""
    squares = (d * d).sum(axis=1)
    middle = k / squares
    reach = np.sqrt(np.maximum(r * r - middle * k, 0.0) * (d[:, 0] ** 2 + d[:, 1] ** 2) / squares)
    found = [np.array([-r, r]), middle * d[:, 2] - reach, middle * d[:, 2] + reach]

    # two circles meet on the line p . d_a = k_a, p . d_b = k_b
    a, b = np.triu_indices(len(k), 1)
    along = np.cross(d[a], d[b])
    length = (along * along).sum(axis=1)
    crossing = length > 1e-24 * squares[a] * squares[b]
    a, b, along, length = a[crossing], b[crossing], along[crossing], length[crossing, None]
    foot = (k[a, None] * np.cross(d[b], along) + k[b, None] * np.cross(along, d[a])) / length
    left = r * r - (foot * foot).sum(axis=1)
    on = left > 0.0
    way = along[on] * np.sqrt(left[on, None] / length[on])
    points = np.vstack([foot[on] - way, foot[on] + way])
    exposed = (points @ d.T <= k + 1e-9 * r * np.sqrt(squares)).all(axis=1)
    found.append(points[exposed, 2])

    cuts = np.sort(np.clip(np.hstack(found), -r, r))
    return cuts[np.hstack([True, np.diff(cuts) > 1e-13 * r])]
