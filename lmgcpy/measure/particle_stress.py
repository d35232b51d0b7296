"""Stress particle by particle, and of a window."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, shown, vector
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.scene.ball_union import union_volume
from lmgcpy.scene.capsule import capsule_volume
from lmgcpy.scene.contactor import DiskContactor, RodContactor, SphereContactor


@dataclass(frozen=True, repr=False)
class ParticleStress(Table):
    """The p bodies with bounds; d dimensions."""

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

    A body in equilibrium under forces f at levers l from its centre has the mean stress ``sum f (x) l / V``. Weber's sum
    over interactions is the sum of these moments over the bodies, as branch vectors are differences of levers, so that

        V sigma = sum of moments,

    which :func:`window_stress` takes of a part of the sample.
    """
    now = moment(sim, frame, "particle_stress")
    moments = moments_of(now)
    chosen = np.flatnonzero(np.isfinite(now.extent))
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
    if not isinstance(window, (tuple, list, np.ndarray)) or len(window) != 2:
        raise TypeError(f"window must be two corners such as ((0, 0), (1, 2)) [m], got {shown(window)}.")
    low, high = (vector(corner, "a corner of window", d) for corner in window)
    if not (low < high).all():
        raise ValueError(f"window must be its low corner and its high corner [m], got {shown(window)}.")
    moments, total = moments_of(now), np.zeros((d, d))
    for positions in images_near(now, 0.5 * (low + high)):
        inside = np.isfinite(now.extent) & ((low <= positions) & (positions < high)).all(axis=1)
        total += moments[inside].sum(axis=0)
    return total / float(np.prod(high - low))


def images_near(now: Moment, centre: np.ndarray) -> list[np.ndarray]:
    """List with the positions of the bodies [m], (n, d). In a periodic cell: one array (n, d) for each shift, with the
    images of the bodies around a point ``centre`` (d,)."""
    if now.lattice is None:
        return [now.positions]
    edges = now.lattice.edges(now.positions)
    nearest = centre + now.lattice.shortened(now.positions - centre, edges)
    return [nearest + np.array(shift) @ edges for shift in itertools.product((-1, 0, 1), repeat=len(edges))]


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
