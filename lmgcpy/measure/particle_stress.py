"""Stress particle by particle, and of a window."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, shown, vector
from lmgcpy.measure.disk_union import disk_union
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.scene.contactor import DiskContactor, SphereContactor


@dataclass(frozen=True, repr=False)
class ParticleStress(Table):
    """The p bodies with bounds; d dimensions."""

    body: np.ndarray
    """Ids, (p,)."""
    position: np.ndarray
    """Centres [m], (p, d)."""
    volume: np.ndarray
    """Their own volumes [m^3, per metre of depth in 2D], (p,); 0 if a shape of a plug-in has none."""
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
    force = np.einsum("mk,mkd->md", net.force, net.frame)
    count, d = now.positions.shape
    moments = np.zeros((count, d, d))
    np.add.at(moments, net.candidate, force[:, :, None] * net.lever[:, 0, None, :])
    np.add.at(moments, net.antagonist, -force[:, :, None] * net.lever[:, 1, None, :])
    moments[~np.isfinite(now.extent)] = 0.0
    return moments


def volumes_of(now: Moment) -> np.ndarray:
    """Volumes of the shapes of each body [m^3, per metre of depth in 2D], (n,).

    The area that disks of a cluster share counts once. Overlaps of other shapes of one body count twice.
    """
    table = now.scene["contactors"]
    body, sizes = np.asarray(table["body"]), np.array(table["area"], dtype=float)
    kinds = np.array(table["kinds"] or [""])[table["kind"]]
    if now.positions.shape[1] == 3:
        sphere = kinds == SphereContactor.KIND
        sizes = np.where(sphere, 4.0 / 3.0 * np.pi * np.where(sphere, table["bounding_radius"], 0.0) ** 3, 0.0)
    volumes = np.bincount(body, weights=sizes, minlength=len(now.positions))
    if now.positions.shape[1] == 2:
        disk = kinds == DiskContactor.KIND
        clusters = np.flatnonzero(np.bincount(body[disk], minlength=len(volumes)) > 1)
        for cluster in clusters.tolist():
            its = np.flatnonzero(disk & (body == cluster))
            radii = np.asarray(table["bounding_radius"])[its]
            volumes[cluster] += disk_union(np.asarray(table["offset"])[its, :2], radii) - sizes[its].sum()
    return volumes
