"""Moves in one step that are far for the bodies concerned: how far contacts must be seen, and what is said of it.

A contact is seen in time where the alert distance covers what its two sides close in a step. For that the way of a body
counts with its spin, as contactors off its centre move by ``|v| + |omega| arm``; the way of a wall counts along its normal,
as it moves nothing by sliding in itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.dynamics.model import Model

OWN, OTHERS = 0.5, 1.0
"""By so many of its own radii, and of the smallest radius that it meets, may a body move in a step before it is told: two
that meet head-on then pass no more than the radius, or the diameter, of the smaller."""
LENGTHS = 2.0
"""By so many lengths may the ends of a link move relative to each other in a step before it is told: the way from one side
of a circle to the other, and the longest that a link admits which keeps its length."""
TURN = 0.5
"""Angle by which a link may turn in the step that would do [rad]."""

LATE = 0.2
"""Part of the smallest radius by which the alert distance may fall short of what a step closed: the least alert distance by
default. Below it a step is never made again."""


class Displacements(NamedTuple):
    """The longest ways of one step [m], and the worst of what is watched."""

    travel: float
    """Of bodies and walls, with the spin of off-centre contactors."""
    closing: float
    """By which a body and a wall may come closer: the longest way of a bounded body and that of a wall along its normal."""
    body: int
    body_path: float
    body_excess: float
    """Its way over what is not told."""
    wall: int
    wall_path: float
    wall_excess: float


def worse(one: Displacements, other: Displacements) -> Displacements:
    """The longer ways of two, and what is worst in either."""
    body = max(one, other, key=lambda ways: ways.body_excess)
    wall = max(one, other, key=lambda ways: ways.wall_excess)
    travel, closing = max(one.travel, other.travel), max(one.closing, other.closing)
    return Displacements(travel, closing, *body[2:5], *wall[5:])


@kernel
def _measure(velocities, dimension, arm, limit, walls, across, wall_limit):
    """Greatest speeds: of all, of the bounded bodies (``arm`` >= 0) and the walls, ``across`` (k, d, d) taking their
    velocity to what moves their surface; and for bodies and walls who is worst, its speed, and that over its limit."""
    fastest = 0.0
    fastest_bounded = 0.0
    body = -1
    body_speed = 0.0
    body_excess = 0.0
    for i in range(velocities.shape[0]):
        square = 0.0
        for k in range(dimension):
            square += velocities[i, k] * velocities[i, k]
        speed = np.sqrt(square)
        if arm[i] > 0.0:
            speed += arm[i] * abs(velocities[i, dimension])
        fastest = max(fastest, speed)
        if arm[i] >= 0.0:
            fastest_bounded = max(fastest_bounded, speed)
            if speed > body_excess * limit[i]:
                body = i
                body_speed = speed
                body_excess = speed / limit[i]
    fastest_wall = 0.0
    wall = -1
    wall_speed = 0.0
    wall_excess = 0.0
    for j in range(walls.shape[0]):
        square = 0.0
        for k in range(dimension):
            along = 0.0
            for m in range(dimension):
                along += across[j, k, m] * velocities[walls[j], m]
            square += along * along
        speed = np.sqrt(square)
        fastest_wall = max(fastest_wall, speed)
        if speed > wall_excess * wall_limit[j]:
            wall = walls[j]
            wall_speed = speed
            wall_excess = speed / wall_limit[j]
    return fastest, fastest_bounded + fastest_wall, body, body_speed, body_excess, wall, wall_speed, wall_excess


class DisplacementWatch:
    """Measures the moves of a simulation and says once each which of them are far."""

    def __init__(self, model: Model):
        contactors, d = model.contactors, model.dimension
        radius, owner = contactors.bounding_radius, contactors.body
        self._dimension = d
        self._own, self._others = radii_that_meet(model)
        self._limit = np.minimum(OWN * self._own, OTHERS * self._others)
        self._arm = np.zeros(len(self._limit))
        if d == 2:  # in 3D no rotation is kept, and offsets do not turn
            np.maximum.at(self._arm, owner, np.hypot(*contactors.offset.T))
        self._walls = np.unique(owner[np.isinf(radius)])
        self._arm[self._walls] = -1.0
        self._across = np.array([across(model, int(wall)) for wall in self._walls]).reshape(-1, d, d)
        self._late = LATE * float(np.minimum(self._own, self._others).min(initial=np.inf))
        self._links = unseen_links(model, np.isfinite(self._limit))
        self._said = {"body": False, "wall": False, "link": False}

    def measure(self, velocities: np.ndarray, time_step: float) -> Displacements:
        """The longest ways of a step with these velocities (n, k)."""
        given = self._arm, self._limit, self._walls, self._across, self._limit[self._walls]
        h = time_step
        all_, closing, body, way, excess, wall, wall_path, wall_excess = _measure(velocities, self._dimension, *given)
        return Displacements(h * all_, h * closing, body, h * way, h * excess, wall, h * wall_path, h * wall_excess)

    def unseen(self, ways: Displacements, after: Displacements, widest: Callable[[float, float], float]) -> bool:
        """Whether a step may have closed gaps that were not seen, as those ``after`` it are longer than the ways it was
        made for. ``widest``: alert distance by travel and closing [m].

        A wall under a load, or a body that is hit, gets its velocity in the step.
        """
        return widest(after.travel, after.closing) > widest(ways.travel, ways.closing) + self._late

    def far(self, ways: Displacements, before: np.ndarray, after: np.ndarray, time: float, time_step: float) -> list[str]:
        """A sentence for each kind of move that is too far for the first time.

        ``before``, ``after``: velocities at the start and the end of the step (n, k), which ends at the ``time`` [s].
        """
        told = []
        if ways.body_excess > 1.0 and not self._said["body"]:
            spins = self._arm[ways.body] > 0.0
            what = f"{'a contactor of ' if spins else ''}body {ways.body} moves by {ways.body_path:.3g} m"
            told.append(self._sentence("body", what, ways.body, time, time_step / ways.body_excess))
        if ways.wall_excess > 1.0 and not self._said["wall"]:
            what = f"wall {ways.wall} moves by {ways.wall_path:.3g} m"
            told.append(self._sentence("wall", what, ways.wall, time, time_step / ways.wall_excess))
        if len(self._links.length) and not self._said["link"]:
            told += self._far_links(before, time, time_step) or self._far_links(after, time, time_step)
        return told

    def _sentence(self, kind: str, what: str, body: int, time: float, would_do: float) -> str:
        self._said[kind] = True
        return (
            f"In the step to t = {time:g} s {what}, more than {self._whose(body)}: contacts are seen late. "
            f"A time step of {would_do:.2g} s would do. (Said once.)"
        )

    def _whose(self, body: int) -> str:
        if OWN * self._own[body] <= OTHERS * self._others[body]:
            return f"half its radius of {self._own[body]:.3g} m"
        return f"the smallest radius it meets, {self._others[body]:.3g} m"

    def _far_links(self, velocities: np.ndarray, time: float, time_step: float) -> list[str]:
        links = self._links
        difference = velocities[links.candidate, : self._dimension] - velocities[links.antagonist, : self._dimension]
        ways = time_step * np.sqrt((difference * difference).sum(axis=1))
        i = int(np.argmax(ways / links.length))
        if ways[i] <= LENGTHS * links.length[i]:
            return []
        self._said["link"] = True
        return [
            f"In the step to t = {time:g} s bodies {links.antagonist[i]} and {links.candidate[i]} move by {ways[i]:.3g} m "
            f"relative to each other, more than twice the length of their link, {links.length[i]:.3g} m, which it cannot "
            f"keep. A time step of {time_step * TURN * links.length[i] / ways[i]:.2g} s would do. (Said once.)"
        ]


def radii_that_meet(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """For each body the smallest radius among its contactors, and among those that they see [m], each (n,); infinite for
    what has no bounds or meets nobody."""
    contactors = model.contactors
    listed = list(zip(contactors.color, contactors.bounding_radius.tolist(), strict=True))
    smallest: dict[str, float] = {}
    for color, radius in listed:
        smallest[color] = min(smallest.get(color, np.inf), radius)
    met: dict[str, float] = {}
    for row in model.rows:
        for one, other in ((row.candidate, row.antagonist), (row.antagonist, row.candidate)):
            met[one] = min(met.get(one, np.inf), smallest.get(other, np.inf))
    own, others = np.full((2, len(model.mass)), np.inf)
    np.minimum.at(own, contactors.body, [radius if color in met else np.inf for color, radius in listed])
    np.minimum.at(others, contactors.body, [met.get(color, np.inf) for color, _ in listed])
    return own, others


def across(model: Model, body: int) -> np.ndarray:
    """What takes the velocity of a body without bounds to that of its surface along the normal, (d, d)."""
    d, contactors = model.dimension, model.contactors
    mine = np.flatnonzero(contactors.body == body)
    kind, shape = contactors.kind[mine[0]], contactors.shape[mine[0]]
    if len(mine) == 1 and kind in ("wall", "plane"):
        return np.outer(shape[:d], shape[:d])
    if len(mine) == 1 and kind == "cylinder":
        return np.eye(d) - np.outer(shape[:d], shape[:d])
    return np.eye(d)


class UnseenLinks(NamedTuple):
    """Links of which one body at least is seen by nobody; m of them."""

    candidate: np.ndarray
    antagonist: np.ndarray
    length: np.ndarray
    """Between the centres at the reference [m], (m,)."""


def unseen_links(model: Model, seen: np.ndarray) -> UnseenLinks:
    """Links that the radii of contacts do not watch; ``seen``: which bodies contacts watch, (n,) bool."""
    ends = [np.column_stack([chain.bodies[1:], chain.bodies[:-1]]) for chain in model.chains]
    pairs = np.concatenate([np.zeros((0, 2), np.int64), *ends])
    lengths = np.concatenate([np.zeros(0), *(chain.radius_sum + chain.reference_gap for chain in model.chains)])
    kept = ~seen[pairs].all(axis=1)
    return UnseenLinks(pairs[kept, 0], pairs[kept, 1], lengths[kept])
