"""Stress of a granular sample by Weber's definition, in total and by interaction law (paper, section 3); of each particle,
and of a window.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number, numbers, shown, vector
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.scene.body_3d import capsule_volume
from lmgcpy.scene.contactor import DiskContactor, RodContactor, SphereContactor
from lmgcpy.scene.solid import union_volume


@named_arguments
def stress(sim: Source, *, frame: int | None = None, volume: float | None = None) -> dict[str, np.ndarray]:
    """``sigma = -(1/V) sum f (x) l`` over the interactions of a step [Pa], traction positive.

    The step is the last one of a simulation. Of an open run file it is the step that ended with ``frame``, by default the
    last frame.

    ``f`` is the force on the candidate. The branch vector ``l`` leads from the antagonist's centre to the candidate's; at
    a wall it starts, or ends, at the contact point, on a thread or membrane at the foot on its axis. The function returns
    ``{"total": (d, d), "<NAME>": (d, d), ..., "kinetic": (d, d)}``, one entry for each law of the scene, and "total" their
    sum.

    "kinetic" is the stress of bodies that fly about, ``-(1/V) sum m v' (x) v'`` at the end of the step: v' is the velocity
    relative to the mean flow in a periodic cell, else to the velocity of the centre of mass of all bodies with bounds. In
    a gas it is nearly all of the stress, in a sample at rest it is zero. The flux of momentum, which a cell that yields to
    a stress balances, is "total" and "kinetic" together.

    ``volume`` [m^3, per metre of depth in 2D] is by default the volume of the periodic cell, or of the box between
    opposite walls, hidden ones left out. A scene with neither raises ValueError, which asks for the volume. In a periodic
    cell the antagonist is the nearest image.

    A tower of three disks of 10 N each:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0)) for i in range(3)]
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="GRAIN"))
    >>> scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-6)).run(steps=5)
    >>> (0.2 * 0.6 * lm.measure.stress(sim, volume=0.2 * 0.6)["total"]).round(3)  # -sum f l [N m]
    array([[ 0.,  0.],
           [ 0., -9.]])
    """
    now = moment(sim, frame, "stress")
    net, positions = now.net, now.positions
    d = positions.shape[1]
    volume = sample_volume(now) if volume is None else number(volume, "volume", above=0.0, unit=f"m^{d}")
    unbounded = ~np.isfinite(now.extent)
    force = np.einsum("mk,mkd->md", net.force, net.frame)
    lever = now.levers_of_stress
    start = np.where(unbounded[net.antagonist, None], 0.0, lever[:, 1])
    end = np.where(unbounded[net.candidate, None], 0.0, lever[:, 0])
    branch = start - end
    dyads = -force[:, :, None] * branch[:, None, :] / volume
    parts = {name: dyads[net.law == name].sum(axis=0) for name in dict.fromkeys(now.laws)}
    return {"total": dyads.sum(axis=0), **parts, "kinetic": _kinetic(now) / volume}


def _kinetic(now: Moment) -> np.ndarray:
    """``-sum m v' (x) v'`` over the bodies with bounds [N m], (d, d)."""
    mass, velocity = now.mass[now.moves], now.velocities[now.moves]
    if now.lattice is None and len(mass):
        velocity = velocity - np.average(velocity, axis=0, weights=mass)
    return -np.einsum("b,bi,bj->ij", mass, velocity, velocity)


def sample_volume(now: Moment) -> float:
    """Volume between the faces of the periodic cell and between the walls that face each other [m^3, per metre of depth in
    2D], hidden ones left out; raises the error of :func:`box_volume`."""
    if now.lattice is None:
        return box_volume(now.positions, now.wall_normals)
    edges = now.lattice.edges(now.positions)
    if len(edges) == now.lattice.dimension:
        return now.lattice.volume(edges)
    # add walls a unit apart along the axes of the cell: the volume of this box is then the extent along the other axes
    normals, positions = dict(now.wall_normals), now.positions.copy()
    for axis in now.lattice.axes.tolist():
        for sign in (1.0, -1.0):
            normal = sign * np.eye(now.lattice.dimension)[axis]
            normals[len(positions)] = normal
            positions = np.concatenate([positions, -0.5 * normal[None]])
    return now.lattice.volume(edges) * box_volume(positions, normals)


def box_volume(positions: np.ndarray, wall_normals: dict[int, np.ndarray]) -> float:
    """Volume of the box between the walls [m^3, per metre of depth in 2D].

    It is the product of the distances between walls that face each other. The function raises ValueError unless there is
    one such pair of walls in each direction, at right angles.

    ``positions``: positions of all bodies [m], (n, d); ``wall_normals``: outward normals, (d,), by id of the body.
    """
    walls = [(normal, positions[body]) for body, normal in wall_normals.items()]
    pairs = [
        (n, abs(float(np.dot(n, q - p))))
        for i, (n, p) in enumerate(walls)
        for m, q in walls[i + 1 :]
        if np.allclose(n, -m, atol=1e-12)
    ]
    dimension = positions.shape[1]
    directions = np.array([n for n, _ in pairs]).reshape(-1, dimension)
    if len(pairs) != dimension or not np.allclose(directions @ directions.T, np.eye(dimension), atol=1e-9):
        raise ValueError(
            f"The volume of this sample is not that of a box: {len(pairs)} pairs of walls face each other where "
            f"{dimension} at right angles are needed. Give volume= [m^{dimension}]."
        )
    return float(np.prod([distance for _, distance in pairs]))


@named_arguments
def principal(sigma: np.ndarray) -> np.ndarray:
    """Principal values of the symmetric part of a stress tensor (d, d), greatest (most tensile) first [Pa], (d,)."""
    sigma = numbers(sigma, "a stress tensor")
    if sigma.shape not in ((2, 2), (3, 3)):
        raise ValueError(f"A stress tensor must have shape (2, 2) or (3, 3), got {sigma.shape}.")
    return np.linalg.eigvalsh(0.5 * (sigma + sigma.T))[::-1]


@dataclass(frozen=True, repr=False)
class ParticleStress(Table):
    """The p bodies with bounds, hidden ones left out; d dimensions."""

    body: np.ndarray
    """Ids, (p,)."""
    position: np.ndarray
    """Centres [m], (p, d)."""
    volume: np.ndarray
    """Their own volumes [m^3, per metre of depth in 2D], (p,); what spheres of a clump share counts once. 0 if a shape of a
    plug-in has none, NaN for a body of rods and other shapes that is no capsule."""
    moment: np.ndarray
    """Sum of force (x) lever over all forces on the body [N m], (p, d, d): its part of V sigma for a volume V around it."""

    @property
    def stress(self) -> np.ndarray:
        """Stress in each body [Pa], traction positive, (p, d, d): the moment over its own volume."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.moment / self.volume[:, None, None]


@named_arguments
def particle_stress(sim: Source, *, frame: int | None = None) -> ParticleStress:
    """Stress in every body with bounds, of the last step of a simulation or of a ``frame`` of an open run.

    A body in equilibrium under forces f at levers l from its centre has the mean stress ``sum f (x) l / V``. The levers of
    forces on a thread or membrane begin at the foot on its axis. Weber's sum over interactions is the sum of these moments
    over the bodies, as branch vectors are differences of levers, so that

        V sigma = sum of moments,

    which :func:`window_stress` takes of a part of the sample.
    """
    now = moment(sim, frame, "particle_stress")
    moments = moments_of(now)
    chosen = np.flatnonzero(now.bounded)
    return ParticleStress(chosen, now.positions[chosen], volumes_of(now)[chosen], moments[chosen])


@named_arguments
def window_stress(sim: Source, window: tuple, *, frame: int | None = None) -> np.ndarray:
    """Stress in a ``window``, two corners ((x, y), (x, y)) in 2D, with z in 3D [m]: (d, d) [Pa], traction positive.

    It is the sum of the moments of the bodies whose centres lie in the window, over its volume. Windows that tile the box
    of a sample have its Weber stress as their mean. A window should hold many bodies. In a periodic cell, which must not be
    smaller than the window, the images of the bodies count.
    """
    now = moment(sim, frame, "window_stress")
    d = now.positions.shape[1]
    low, high = corners(window, "window", d)
    moments, total = moments_of(now), np.zeros((d, d))
    for positions in images_near(now, now.positions, 0.5 * (low + high)):
        inside = np.isfinite(now.extent) & ((low <= positions) & (positions < high)).all(axis=1)
        total += moments[inside].sum(axis=0)
    return total / float(np.prod(high - low))


def corners(value: Any, name: str, d: int) -> tuple[np.ndarray, np.ndarray]:
    """The low and the high corner of a box, (d,) each; TypeError or ValueError with a sentence that calls it ``name``."""
    if not isinstance(value, (tuple, list, np.ndarray)) or len(value) != 2:
        raise TypeError(f"{name} must be two corners such as ((0, 0), (1, 2)) [m], got {shown(value)}.")
    low, high = (vector(corner, f"a corner of {name}", d) for corner in value)
    if not (low < high).all():
        raise ValueError(f"{name} must be its low corner and its high corner [m], got {shown(value)}.")
    return low, high


def images_near(now: Moment, points: np.ndarray, centre: np.ndarray, reach: float = 0.0) -> list[np.ndarray]:
    """List with points [m], (k, d), alone. In a periodic cell: one array (k, d) for each shift, with all images that are
    within ``reach`` [m] of a point ``centre`` (d,), and at least the nearest ones and their neighbours."""
    if now.lattice is None:
        return [points]
    edges = now.lattice.edges(now.positions)
    nearest = centre + now.lattice.shortened(points - centre, edges)
    most = np.ceil(0.5 + reach / now.lattice.widths(edges)).astype(int).tolist()
    shifts = itertools.product(*(range(-count, count + 1) for count in most))
    return [nearest + np.array(shift) @ edges for shift in shifts]


def moments_of(now: Moment) -> np.ndarray:
    """Sum of force (x) lever over all that acts on each body [N m], (n, d, d); zero for bodies without bounds."""
    net = now.net
    force, lever = np.einsum("mk,mkd->md", net.force, net.frame), now.levers_of_stress
    count, d = now.positions.shape
    moments = np.zeros((count, d, d))
    np.add.at(moments, net.candidate, force[:, :, None] * lever[:, 0, None, :])
    np.add.at(moments, net.antagonist, -force[:, :, None] * lever[:, 1, None, :])
    moments[~np.isfinite(now.extent)] = 0.0
    return moments


def volumes_of(now: Moment) -> np.ndarray:
    """Volumes of the bodies [m^3, per metre of depth in 2D], (n,).

    What disks or spheres of one body share counts once. Shapes of plug-ins have their area in 2D, no volume in 3D. NaN for
    a body of rods and other shapes that is no capsule.
    """
    table, bodies, d = now.scene["contactors"], now.scene["bodies"], now.positions.shape[1]
    body, radius = np.asarray(table["body"]), np.asarray(table["bounding_radius"])
    kinds = np.array(table["kinds"] or [""])[table["kind"]]
    ball = np.isin(kinds, (DiskContactor.KIND, SphereContactor.KIND))
    sizes = np.array(table["area"], dtype=float)
    if d == 3:
        sizes[ball] = 4.0 / 3.0 * np.pi * radius[ball] ** 3
    volumes = np.bincount(body, weights=sizes, minlength=len(now.positions))
    rows = np.flatnonzero(ball)
    rows = rows[np.bincount(body[rows], minlength=len(volumes))[body[rows]] > 1]
    for its in np.split(rows, np.flatnonzero(np.diff(body[rows])) + 1):
        if not len(its):
            continue
        shared = union_volume(np.asarray(table["offset"])[its, :d], radius[its]) - float(sizes[its].sum())
        volumes[body[its[0]]] += shared
    for k in np.flatnonzero(kinds == RodContactor.KIND):
        r, length = float(table["shape"][k, 0]), 2.0 * float(np.linalg.norm(table["shape"][k, 1:4]))
        capsule = bodies["kinds"][bodies["kind"][body[k]]] == "capsule"
        volumes[body[k]] = capsule_volume(r, length) if capsule else np.nan
    return volumes
