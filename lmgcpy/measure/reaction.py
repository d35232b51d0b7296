"""Force and moment that the interactions of a step give to bodies."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, shown, vector, whole
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.scene.body import Body
from lmgcpy.writing import html_of_fields


@dataclass(frozen=True)
class Reaction:
    """Resultant of the interactions of some bodies with all others, in d dimensions."""

    force: np.ndarray
    """[N], (d,)."""
    moment: np.ndarray
    """Moment about ``about`` [N m], (1,) in 2D, (3,) in 3D."""
    about: np.ndarray
    """The point of the moment [m], (d,)."""
    by_law: dict[str, tuple[np.ndarray, np.ndarray]]
    """Force and moment by the name of the law; of every law of the scene."""

    def __repr__(self) -> str:
        force, turning = (", ".join(f"{x:.4g}" for x in part) for part in (self.force, self.moment))
        return f"<Reaction: force ({force}) N, moment ({turning}) N m>"

    def _repr_html_(self) -> str:
        return html_of_fields(self)


@named_arguments
def reaction(sim: Source, bodies: Any, *, about: Any = None, frame: int | None = None) -> Reaction:
    """Force and moment that contacts and links give to a body, or to several ones together, in the last step of a
    simulation, or in the step that ended with a ``frame`` of an open run, by default the last.

    ``bodies``: a body or its id, a list of these, or a colour. Forces between them cancel and are left out. ``about`` [m]
    is the point of the moment: by default the position of a single body, and the origin for several. Weight, imposed forces
    and drag are no interactions. A contact on a thread, net or membrane counts for its nearest node.

    The force on the candidate of an interaction acts at the contact point, ``sum F`` and ``sum (x - about) x F``, plus the
    moments of rolling friction; the antagonist has the opposite. A hidden body has none.

    A ball of 10 N on a floor, and what the floor bears:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> ball = scene.add(lm.disk(radius=0.1, position=(0.3, 0.1), mass=1.0))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=5)
    >>> ball.reaction.force.round(9), lm.measure.reaction(sim, floor, about=(0.0, 0.0)).moment.round(9)
    (array([ 0., 10.]), array([-3.]))
    """
    now = moment(sim, frame, "reaction")
    chosen, single = _chosen(bodies, now)
    d, net = now.positions.shape[1], now.net
    if about is None:
        centre = now.detected[chosen.argmax()] if single else np.zeros(d)
    else:
        centre = vector(about, "about", d)
    candidate, antagonist = chosen[net.candidate], chosen[net.antagonist]
    of_others = candidate != antagonist
    names, laws = list(dict.fromkeys(now.laws)), net.law[of_others]
    sign = np.where(candidate, 1.0, -1.0)[of_others, None]
    side = np.where(candidate, 0, 1)[of_others]
    body = np.where(candidate, net.candidate, net.antagonist)[of_others]
    frames = net.frame[of_others]
    force = sign * np.einsum("mk,mkd->md", net.force[of_others], frames)
    # in a periodic cell the point is at the chosen body's own image
    bounded = np.isfinite(now.extent)[body, None]
    lever = net.lever[of_others, side]
    point = np.where(bounded, now.detected[body] + lever, net.point[of_others]) - centre
    if d == 2:
        turning = (point[:, 0] * force[:, 1] - point[:, 1] * force[:, 0])[:, None]
    else:
        turning = np.cross(point, force)
    if net.moment.shape[1] and len(force):
        rolling = net.moment[of_others] / now.scheme[0]
        turning = turning + sign * (rolling if d == 2 else np.einsum("mk,mkd->md", rolling, frames))
    by_law = {name: (force[laws == name].sum(axis=0), turning[laws == name].sum(axis=0)) for name in names}
    return Reaction(force.sum(axis=0), turning.sum(axis=0), centre, by_law)


def _chosen(bodies: Any, now: Moment) -> tuple[np.ndarray, bool]:
    """The bodies that are meant, (n,) bool, and whether it is a single one."""
    count = len(now.positions)
    found = np.zeros(count, dtype=bool)
    if isinstance(bodies, str):
        colors = now.colors
        if bodies not in colors:
            raise ValueError(f"bodies '{bodies}' is no colour of this scene, which has {', '.join(sorted(colors))}.")
        return colors[bodies], False
    single = isinstance(bodies, Body) or not isinstance(bodies, Iterable)
    for one in [bodies] if single else bodies:
        row = one.id if isinstance(one, Body) else whole(one, "bodies of reaction")
        if not 0 <= row < count:
            raise ValueError(f"bodies of reaction: {shown(one)} is none of the {count} bodies of this scene.")
        found[row] = True
    if not found.any():
        raise ValueError("bodies of reaction names no body.")
    return found, single
