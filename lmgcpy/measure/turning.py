"""Bodies that turn: their angular momentum, and the directions of their long axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.positions import in_own_axes, in_space
from lmgcpy.errors import named_arguments, vector
from lmgcpy.measure.moment import Source, moment
from lmgcpy.measure.table import Table

LONG = 1e-6
"""A body has a long axis if its least moment of inertia is below the others by this part of the largest at least."""


@named_arguments
def angular_momentum(sim: Source, *, about: Any = None, frame: int | None = None) -> Any:
    """``L = sum m (x - c) x v + R I R^T w`` of the bodies with bounds and mass, a number, in 3D (3,) [kg m^2/s].

    It is taken at the end of the last step of a simulation, or of a ``frame`` of an open run, by default the last. R is the
    rotation of a body, I its inertia about its own axes, w its spin along the axes of space. ``about`` is the point c [m],
    (d,), by default the centre of mass of these bodies. In 2D L is per metre of depth.

    Raises ValueError in a periodic cell: L is not conserved there, and depends on the choice of images.

    A body that is thrown has the same about its centre of mass at any time:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=3, gravity=(0, 0, -10))
    >>> stick = lm.capsule(radius=0.1, length=1.0, position=(0, 0, 0), mass=1.0, spin=(3, 0, 1), velocity=(1, 0, 5))
    >>> stick = scene.add(stick)
    >>> sim = lm.Simulation(scene, time_step=1e-3)
    >>> before = lm.measure.angular_momentum(sim)
    >>> bool(abs(lm.measure.angular_momentum(sim.run(steps=500)) - before).max() < 1e-12)
    True
    """
    now = moment(sim, frame, "angular_momentum")
    d = now.positions.shape[1]
    if now.lattice is not None:
        raise ValueError("In a periodic cell angular momentum depends on the choice of images, and is not conserved.")
    chosen = now.moves
    mass, positions, velocities = now.mass[chosen], now.positions[chosen], now.velocities[chosen]
    if about is not None:
        centre = vector(about, "about", d)
    else:
        centre = np.average(positions, axis=0, weights=mass) if len(mass) else np.zeros(d)
    lever, momentum = positions - centre, mass[:, None] * velocities
    inertia = np.asarray(now.scene["bodies"]["inertia"], dtype=float)
    if d == 2:
        orbital = lever[:, 0] * momentum[:, 1] - lever[:, 1] * momentum[:, 0]
        return float(orbital.sum() + (inertia[chosen] * now.spins[chosen]).sum())
    own = np.zeros_like(now.spins)
    own[chosen] = inertia[chosen, None] * now.spins[chosen]
    body, rotations, inertias = now.turning
    own[body] = in_space(rotations, inertias * in_own_axes(rotations, now.spins[body]))
    return np.cross(lever, momentum).sum(axis=0) + own[chosen].sum(axis=0)


@dataclass(frozen=True, repr=False)
class LongAxes(Table):
    """The p bodies of a scene in 3D that have a long axis."""

    body: np.ndarray
    """Ids, (p,)."""
    direction: np.ndarray
    """Unit vectors t along their axes of least inertia, (p, 3); t and -t are the same."""

    @property
    def fabric(self) -> np.ndarray:
        """Mean of t (x) t, of trace 1, (3, 3): a third of the unit tensor if directions are isotropic, zero without any."""
        return self.direction.T @ self.direction / max(len(self), 1)


@named_arguments
def long_axes(sim: Source, *, frame: int | None = None) -> LongAxes:
    """Directions of the long axes of clumps and capsules, in a simulation or in a ``frame`` of an open run, by default the
    last.

    The long axis is the principal axis of least inertia. Bodies without a unique one, spheres, cubes, plates, have none.
    Raises ValueError in 2D, as bodies have one inertia there.
    """
    now = moment(sim, frame, "long_axes")
    if now.positions.shape[1] == 2:
        raise ValueError("long_axes is for scenes in 3D: in 2D a body has one inertia, which has no axis in the plane.")
    body, rotations, inertias = now.turning
    ordered = np.sort(inertias, axis=1)
    chosen = (ordered[:, 1] - ordered[:, 0] > LONG * ordered[:, 2]) & ~now.hidden[body]
    along = np.eye(3)[inertias[chosen].argmin(axis=1)]
    return LongAxes(body[chosen], in_space(rotations[chosen], along))
