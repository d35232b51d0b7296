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

**What tears.** A link that turns becomes longer by ``(h u_t)^2 / 2 l`` within a step, and has a velocity along itself at
its end; a lever l of a body does so by ``(h omega)^2 |l| / 2``. Only a longer way along the link tears it, which must also
be more than the ways with the velocities from before: velocities that are damped by hand at every step tear nothing. Nor
does a small part of the ways by which links of the same net turn, as velocities from a run have the error of its solver.
Links that a function of time draws are left to it.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, JointTable
from lmgcpy.contact.detector import Group
from lmgcpy.dynamics.geometric_stiffness import connected
from lmgcpy.dynamics.step_problem import StepProblem

SMALL = 1e-2
"""A way along a link less than this part of the greatest way of a link of its net is an error of the velocities that were
given. To leave it costs such a part of a velocity; to take it for a kick would delay the whole net."""


def may_tear(links: list[ChainTable], given: np.ndarray, before: np.ndarray) -> bool:
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
    problem: StepProblem,
    velocities: np.ndarray,
    before: np.ndarray,
    time: float,
    mass: np.ndarray,
    inverse_mass: np.ndarray,
) -> np.ndarray | None:
    """Ways to the detection, (n, k), or None: the velocities times the ``time`` until then [s], replaced for the bodies of
    rigid links that would be torn.

    ``problem``: assembled at the positions and with the ``velocities`` that were given, (n, k); ``before``: the velocities
    before that; ``mass`` and ``inverse_mass`` of the bodies (n, k).
    """
    d = problem.dimension
    links = [(group, group.chain) for group in problem.by_law if group.chain is not None]
    count = links[-1][0].stop if links else 0
    c, a = problem.system.candidate[:count], problem.system.antagonist[:count]
    way = time * problem.data.before[:count]
    old = time * problem.relative_velocities(before)[:count]
    longer, torn = np.zeros(count), np.zeros(count, dtype=bool)
    for group, table in links:
        if "rigid" in group.law.TRAITS and table.function is None:
            part = slice(group.start, group.stop)
            longer[part] = lengthened(problem, group, way[part, 0], old[part, 0])
            bound = np.maximum(turned(problem, group, table, velocities), np.linalg.norm(old[part], axis=1))
            torn[part] = longer[part] > bound
    if not torn.any():
        return None
    free = inverse_mass[:, :d] > 0.0
    moves: np.ndarray = np.all(free, axis=1)
    joins = moves[c] & moves[a]
    net = connected(c[joins], a[joins], len(velocities))
    ends = np.concatenate([c[torn], a[torn]])
    ways = time * velocities
    for label in np.unique(net[ends[moves[ends]]]):
        own = moves & (net == label)
        here = own[c] | own[a]
        if not np.any(longer[here & torn] > SMALL * np.linalg.norm(way[here], axis=1).max()):
            continue
        linked = np.union1d(c[here], a[here])
        if np.any(np.where(free[linked], 0.0, velocities[linked, :d])):
            continue  # driven
        centre = time * np.average(velocities[own, :d], axis=0, weights=mass[own, 0])
        ways[own, :d] = np.where(free[linked].all(axis=0), centre, 0.0)
        ways[own, d:] = 0.0
    return ways


def lengthened(problem: StepProblem, group: Group, way: np.ndarray, old: np.ndarray) -> np.ndarray:
    """By how much more ways along the links of a group take them off their length than the ``old`` ones [m], (links,)."""
    if "pull" not in group.law.TRAITS:
        return np.abs(way - old)
    part = slice(group.start, group.stop)
    slack = problem.data.reference_gap[part] - problem.data.gap[part]
    return np.minimum(way - old, way - slack)  # a slack wire is not torn before it is taut


def turned(problem: StepProblem, group: Group, table: ChainTable, velocities: np.ndarray) -> np.ndarray:
    """By how much turning lengthens the links of a group in a step, their own and that of levers [m], (links,)."""
    h, d = problem.data.time_step, problem.dimension
    part = slice(group.start, group.stop)
    result = np.zeros(group.stop - group.start)
    if not isinstance(table, JointTable):
        length = problem.data.gap[part] + table.radius_sum
        across = ((h * problem.data.before[part, 1:d]) ** 2).sum(axis=1)
        np.divide(across, 2.0 * length, out=result, where=length > 0.0)
    if table.points is not None:
        lever = np.linalg.norm(table.points.offset, axis=1)
        spin = h * np.linalg.norm(velocities[table.bodies, d:], axis=1)
        result += sum((0.5 * lever * spin**2)[end] for end in table.ends)
    return result
