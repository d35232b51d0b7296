"""Stress of a granular sample by Weber's definition, in total and by interaction law (paper, section 3)."""

from __future__ import annotations

import numpy as np

from lmgcpy.errors import named_arguments, number, numbers
from lmgcpy.measure.moment import Moment, Source, moment


@named_arguments
def stress(sim: Source, *, frame: int | None = None, volume: float | None = None) -> dict[str, np.ndarray]:
    """``sigma = -(1/V) sum f (x) l`` over the interactions of a step [Pa], traction positive.

    The step is the last one of a simulation. Of an open run file it is the step that ended with ``frame``, by default the
    last frame.

    ``f`` is the force on the candidate. The branch vector ``l`` leads from the antagonist's centre to the candidate's; at
    a wall it starts, or ends, at the contact point. The function returns ``{"total": (d, d), "<NAME>": (d, d), ...,
    "kinetic": (d, d)}``, one entry for each law of the scene, and "total" their sum.

    "kinetic" is the stress of bodies that fly about, ``-(1/V) sum m v' (x) v'`` at the end of the step: v' is the velocity
    relative to the mean flow in a periodic cell, else to the velocity of the centre of mass of all bodies with bounds. In
    a gas it is nearly all of the stress, in a sample at rest it is zero. The flux of momentum, which a cell that yields to
    a stress balances, is "total" and "kinetic" together.

    ``volume`` [m^3, per metre of depth in 2D] is by default the volume of the periodic cell, or of the box between
    opposite walls. A scene without both raises ValueError, which asks for the volume. In a periodic cell the antagonist is
    the nearest image.

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
    2D]; raises the error of :func:`box_volume`."""
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
