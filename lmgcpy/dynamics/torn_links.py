"""Velocities given by hand that would tear rigid links: at the start of a simulation, or written between two steps.

A ball at the end of a taut rigid wire is thrown outward. The blow comes at once, and leaves no velocity u along the wire.
But a step detects at ``q_m = q + (1 - theta) h v``, with the velocity from before the blow. There the wire is too long by
``(1 - theta) h u``, and its law ``g + h u_n <= 0`` pulls that back within h: the ball comes back with ``(1 - theta) u``, at
any time step.

So in such a step the bodies of links that would be torn, and all that links join to them, go on with the velocity V of
their centre of mass, and do not turn:

    q_m = q + (1 - theta) h V

The links are as long as before, the impulses of the blow act along them there, and neither momentum is changed:
``sum m (q_m - q) x v = (1 - theta) h V x (sum m v) = 0``. With V the step is the same for all who watch it from a
frame that moves uniformly. It is zero in a direction in which one of these bodies is fixed. If one of them is driven,
nothing is replaced: how far it draws the others along is for the laws. Relative to their centre these bodies are
``(1 - theta) h`` late for ever, by no more than any time stepping knows when a blow came.

A link that turns becomes longer by ``(h u_t)^2 / 2 l`` and is not torn: it is if the way along it is more than that. And a
kick is more than what went on before: velocities that are damped by hand at every step tear nothing.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, JointTable
from lmgcpy.contact.detector import Group
from lmgcpy.dynamics.geometric_stiffness import connected
from lmgcpy.dynamics.step_problem import StepProblem

ROUNDING = 1e-9
"""A way along a link less than this part of the ways of its bodies is an error of the velocities that were given."""


def may_tear(links: list[ChainTable | JointTable], given: np.ndarray, before: np.ndarray) -> bool:
    """Whether a velocity ``given`` by hand may tear a rigid link: its bodies differ by more in it than in that ``before``,
    of velocities or of spins, (n, k)."""
    d = 2 if given.shape[1] == 3 else 3
    for table in links:
        if "rigid" in table.law.TRAITS:
            a, c = (table.bodies[end] for end in table.ends)
            new, old = given[c] - given[a], before[c] - before[a]
            for part in (slice(0, d), slice(d, None)):
                if np.any(np.linalg.norm(new[:, part], axis=1) > np.linalg.norm(old[:, part], axis=1)):
                    return True
    return False


def ways_of_whole_links(
    problem: StepProblem, ways: np.ndarray, before: np.ndarray, mass: np.ndarray, inverse_mass: np.ndarray
) -> np.ndarray | None:
    """The ``ways`` to the detection (n, k), or None: replaced for the bodies of rigid links that would be torn.

    ``problem``: assembled before these ways, at the positions at which the velocities were given; ``before``: the ways with
    the velocities before that, (n, k); ``mass`` and ``inverse_mass`` of the bodies (n, k).
    """
    d = problem.dimension
    links = [group for group in problem.by_law if group.chain is not None]
    count = links[-1].stop if links else 0
    c, a = problem.system.candidate[:count], problem.system.antagonist[:count]
    way, old = problem.relative_velocities(ways), problem.relative_velocities(before)
    torn = np.zeros(count, dtype=bool)
    size = np.linalg.norm(ways[:, :d], axis=1)
    for group in links:
        if "rigid" in group.law.TRAITS:
            part = slice(group.start, group.stop)
            most = np.maximum(turned(problem, group, way[part]), ROUNDING * (size[c[part]] + size[a[part]]))
            most = np.maximum(most, np.linalg.norm(old[part], axis=1))
            torn[part] = lengthened(problem, group, way[part, 0], old[part, 0]) > most
    if not torn.any():
        return None
    free = inverse_mass[:, :d] > 0.0
    moves: np.ndarray = np.all(free, axis=1)
    joins = moves[c] & moves[a]
    net = connected(c[joins], a[joins], len(ways))
    ends = np.concatenate([c[torn], a[torn]])
    whole = ways.copy()
    for label in np.unique(net[ends[moves[ends]]]):
        own = moves & (net == label)
        here = own[c] | own[a]
        linked = np.union1d(c[here], a[here])
        if np.any(np.where(free[linked], 0.0, ways[linked, :d])):
            continue  # driven
        centre = np.average(ways[own, :d], axis=0, weights=mass[own, 0])
        whole[own, :d] = np.where(free[linked].all(axis=0), centre, 0.0)
        whole[own, d:] = 0.0
    return whole


def lengthened(problem: StepProblem, group: Group, way: np.ndarray, old: np.ndarray) -> np.ndarray:
    """By how much more ways along the links of a group take them off their length than the ``old`` ones [m], (links,)."""
    if "pull" not in group.law.TRAITS:
        return np.abs(way - old)
    part = slice(group.start, group.stop)
    slack = problem.data.reference_gap[part] - problem.data.gap[part]
    return np.minimum(way - old, way - slack)  # a slack wire is not torn before it is taut


def turned(problem: StepProblem, group: Group, way: np.ndarray) -> np.ndarray:
    """By how much turning lengthens the links of a group that go a ``way`` (links, d) [m], (links,); joints: by nothing."""
    if group.chain is None or isinstance(group.chain, JointTable):
        return np.zeros(len(way))
    length = problem.data.gap[group.start : group.stop] + group.chain.radius_sum
    across = (way[:, 1 : problem.dimension] ** 2).sum(axis=1)
    return np.divide(across, 2.0 * length, out=np.zeros_like(length), where=length > 0.0)
