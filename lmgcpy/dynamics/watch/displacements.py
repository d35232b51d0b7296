"""Displacements of bodies in one step: the alert distance that they need, and a warning if they are too large.

A contact is seen in time if the alert distance covers the distance by which its two sides close in a step. The displacement
of a body includes its spin, as contactors off its centre move by ``h (|v| + |omega| arm)``, in space by
``h (|v| + sum over its axes of |omega_k| arm_k)``. A rod moves as the spheres at its ends do. The displacement of a wall is
the one along its normal, as a wall that slides in its own plane moves no surface.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.watch import Said

OWN, OTHERS = 0.5, 1.0
"""The run warns if a body moves in a step by more than OWN times its own radius, or OTHERS times the smallest radius that
it meets. Two bodies that meet head-on then close no more than the radius, or the diameter, of the smaller one."""
LENGTHS = 2.0
"""The run warns if the ends of a link move relative to each other in a step by more than this number of lengths. Twice the
length is the diameter of the circle on which one end turns about the other: a link that keeps its length admits no more."""
TURN = 0.5
"""Angle by which a link turns in the time step that the warning proposes [rad]."""

LATE = 0.2
"""Part of the smallest radius by which the alert distance may fall short of the distance that a step closed. It is the
least alert distance by default. A step that falls short by less is not made again."""


class Displacements(NamedTuple):
    """The largest displacements of one step [m], and the body and the wall that exceed their limit most."""

    travel: float
    """Largest displacement of a body or a wall, with the spin of off-centre contactors."""
    closing: float
    """Largest distance by which a body and a wall may come closer: the largest displacement of a bounded body, plus the
    largest displacement of a wall along its normal."""
    body: int
    body_distance: float
    body_excess: float
    """Displacement of this body over its limit."""
    wall: int
    wall_distance: float
    wall_excess: float


def worse(one: Displacements, other: Displacements) -> Displacements:
    """The larger displacements of two, and the worst body and wall of either."""
    body = one if one.body_excess >= other.body_excess else other
    wall = one if one.wall_excess >= other.wall_excess else other
    travel, closing = max(one.travel, other.travel), max(one.closing, other.closing)
    return Displacements(travel, closing, *body[2:5], *wall[5:])


@kernel
def _measure(velocities, dimension, arm, limit, walls, across, wall_limit):
    """(greatest speed, greatest closing speed, worst body, its speed, its speed over its limit, and the same of the walls).

    ``arm`` (n, k): distances from the axes of spin, at least 0 for bounded bodies; ``across`` (w, d, d): from the velocity
    of a wall to the velocity of its surface along the normal.
    """
    fastest = 0.0
    fastest_bounded = 0.0
    body = -1
    body_speed = 0.0
    body_excess = 0.0
    for i in range(velocities.shape[0]):
        # |v| + |omega| arm
        square = 0.0
        for k in range(dimension):
            square += velocities[i, k] * velocities[i, k]
        speed = np.sqrt(square)
        for k in range(arm.shape[1]):
            if arm[i, k] > 0.0:
                speed += arm[i, k] * abs(velocities[i, dimension + k])
        fastest = max(fastest, speed)
        # bounded bodies have limits, and close gaps with walls
        if arm[i, 0] >= 0.0:
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
        # speed of the wall's surface along its normal
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
    """Measures the displacements of each step of a simulation, and warns once of each kind that is too large."""

    def __init__(self, model: Model, said: Said):
        self._said = said
        contactors, d = model.contactors, model.dimension
        radius, owner = contactors.bounding_radius, contactors.body
        self._dimension = d
        self._cell = model.cell
        self._widest = 2.0 * float(radius[np.isfinite(radius)].max(initial=0.0))
        self._own, self._others = radii_that_meet(model)
        self._limit = np.minimum(OWN * self._own, OTHERS * self._others)
        self._arm = np.zeros((len(self._limit), 1 if d == 2 else 3))
        np.maximum.at(self._arm, owner, off_axes(model))
        self._walls = np.unique(owner[np.isinf(radius)])
        self._arm[self._walls] = -1.0
        of_walls = np.array([across(model, int(wall)) for wall in self._walls]).reshape(-1, d, d)
        self._given = d, self._arm, self._limit, self._walls, of_walls, self._limit[self._walls]
        self._late = LATE * float(np.minimum(self._own, self._others).min(initial=np.inf))
        self._links = unseen_links(model, np.isfinite(self._limit))

    def measure(self, velocities: np.ndarray, time_step: float) -> Displacements:
        """The largest displacements of a step with these velocities (n, k)."""
        flow = 0.0
        if self._cell is not None:
            gradient = self._cell.gradient(velocities)
            velocities = velocities.copy()
            velocities[self._cell.lattice.rows] = 0.0
            # with the cell, two bodies that touch come closer by h |G| (R_c + R_a), half of it each; twice that for bodies
            # that do not touch yet
            flow = float(np.abs(gradient).sum()) * self._widest
        measured = _measure(velocities, *self._given)
        speed, closing, body, body_speed, excess, wall, wall_speed, wall_excess = measured
        h = time_step
        of_bodies, of_walls = (body, h * body_speed, h * excess), (wall, h * wall_speed, h * wall_excess)
        return Displacements(h * (speed + flow), h * closing, *of_bodies, *of_walls)

    def unseen(self, moves: Displacements, after: Displacements, widest: Callable[[float, float], float]) -> bool:
        """Whether a step may have closed gaps that were not seen: the displacements ``after`` it are larger than the
        displacements ``moves`` for which gaps were detected. ``widest``: alert distance by travel and closing [m].

        A wall under a load, or a body that is hit, gets its velocity in the step.
        """
        if after.travel <= moves.travel and after.closing <= moves.closing:
            return False
        return widest(after.travel, after.closing) > widest(moves.travel, moves.closing) + self._late

    def far(self, moves: Displacements, before: np.ndarray, after: np.ndarray, time: float, time_step: float) -> list[str]:
        """A sentence for each kind of displacement that is too large for the first time.

        ``before``, ``after``: velocities at the start and the end of the step (n, k), which ends at the ``time`` [s].
        """
        sentences = []
        if moves.body_excess > 1.0 and self._said.first("body"):
            spins = self._arm[moves.body].any()
            what = f"{'a contactor of ' if spins else ''}body {moves.body} moves by {moves.body_distance:.3g} m"
            sentences.append(self._sentence(what, moves.body, time, time_step / moves.body_excess))
        if moves.wall_excess > 1.0 and self._said.first("wall"):
            what = f"wall {moves.wall} moves by {moves.wall_distance:.3g} m"
            sentences.append(self._sentence(what, moves.wall, time, time_step / moves.wall_excess))
        if len(self._links.length) and "link" not in self._said:
            sentences += self._far_links(before, time, time_step) or self._far_links(after, time, time_step)
        return sentences

    def _sentence(self, what: str, body: int, time: float, would_do: float) -> str:
        return (
            f"In the step to t = {time:g} s {what}, more than {self._whose(body)}: contacts are seen late. "
            f"At this speed a time step of {rounded_down(would_do)} s would do. (Said once.)"
        )

    def _whose(self, body: int) -> str:
        if OWN * self._own[body] <= OTHERS * self._others[body]:
            return f"half its radius of {self._own[body]:.3g} m"
        return f"the smallest radius it meets, {self._others[body]:.3g} m"

    def _far_links(self, velocities: np.ndarray, time: float, time_step: float) -> list[str]:
        links = self._links
        difference = velocities[links.candidate, : self._dimension] - velocities[links.antagonist, : self._dimension]
        distance = time_step * np.sqrt((difference * difference).sum(axis=1))
        i = int(np.argmax(distance / links.length))
        if distance[i] <= LENGTHS * links.length[i] or not self._said.first("link"):
            return []
        return [
            f"In the step to t = {time:g} s bodies {links.antagonist[i]} and {links.candidate[i]} move by "
            f"{distance[i]:.3g} m relative to each other, more than twice the length of their link, "
            f"{links.length[i]:.3g} m, which it cannot keep. At this speed a time step of "
            f"{rounded_down(time_step * TURN * links.length[i] / distance[i])} s would do. (Said once.)"
        ]


def rounded_down(value: float) -> str:
    """A positive number rounded down to two digits: a time step that is proposed must not be too long."""
    if not 0.0 < value < math.inf:
        return f"{value:.2g}"
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / unit * (1.0 + 1e-12)) * unit:.2g}"


def off_axes(model: Model) -> np.ndarray:
    """Greatest distance of what a contactor shows to move as its body turns, from the axes of the spin [m], (k, 1 or 3): of
    its centre, and of all of it unless it is round."""
    contactors = model.contactors
    if model.dimension == 2:
        long = np.array([kind == "line" for kind in contactors.kind], dtype=bool)
        return (np.hypot(*contactors.swing.T) + np.where(long, contactors.bounding_radius, 0.0))[:, None]
    if contactors.turns is None:
        return np.zeros((len(contactors.body), 3))
    squares = contactors.swing**2
    distance = np.sqrt(np.maximum(squares.sum(axis=1, keepdims=True) - squares, 0.0))
    plain = np.array([kind in ("sphere", "rod") for kind in contactors.kind], dtype=bool)  # a rod has spheres at its ends
    return distance + np.where(plain, 0.0, contactors.bounding_radius)[:, None]


def radii_that_meet(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """For each body the smallest radius among its contactors, and among those that they see [m], each (n,).

    A radius is infinite if the contactors have no bounds or see no others.
    """
    contactors = model.contactors
    listed = list(zip(contactors.color, contactors.size.tolist(), strict=True))
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
    """Matrix (d, d) from the velocity of a body without bounds to the velocity of its surface along the normal."""
    d, contactors = model.dimension, model.contactors
    mine = np.flatnonzero(contactors.body == body)
    kind, shape = contactors.kind[mine[0]], contactors.shape[mine[0]]
    if len(mine) == 1 and kind in ("wall", "plane"):
        return np.outer(shape[:d], shape[:d])
    if len(mine) == 1 and kind == "cylinder":
        return np.eye(d) - np.outer(shape[:d], shape[:d])
    return np.eye(d)


class UnseenLinks(NamedTuple):
    """Links with at least one body that no contactor sees; m of them."""

    candidate: np.ndarray
    antagonist: np.ndarray
    length: np.ndarray
    """Distance between the centres at the reference gap [m], (m,)."""


def unseen_links(model: Model, seen: np.ndarray) -> UnseenLinks:
    """Links that the radii of contacts do not watch; ``seen``: whether contacts watch a body, (n,) bool."""
    ends = [np.column_stack([chain.bodies[1:], chain.bodies[:-1]]) for chain in model.chains]
    pairs = np.concatenate([np.zeros((0, 2), np.int64), *ends])
    lengths = np.concatenate([np.zeros(0), *(chain.radius_sum + chain.reference_gap for chain in model.chains)])
    kept = ~seen[pairs].all(axis=1)
    return UnseenLinks(pairs[kept, 0], pairs[kept, 1], lengths[kept])
