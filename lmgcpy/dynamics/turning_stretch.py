"""The stretch of links that turn within a step, and a second solve that takes it back without a blow.

A law keeps its link to the gap that it predicts, ``g + h u_n``. A link of length l that turns by the angle h u_t / l is
longer than that at the end, by ``(h u_t)^2 / 2 l``, and its law pulls the excess back in the next step. As a rule this is
right: this pull turns the velocity of a pendulum. But light beads that whip before a heavy end leave a large excess at the
cost of next to no energy. The step in which all links are taut at once pulls the sum of the excess back within h, with the
heavy end.

So if a chain makes energy that its excess accounts for, and no winch, the step is solved a second time, as if the chain
had the gaps ``lambda`` that its laws predicted in the step before. Velocities and impulses come from the second solve,
displacements from the first, which takes the excess back (as projected time stepping does with penetrations: Acary 2013,
Comput. Methods Appl. Mech. Eng. 256):

    v   = v_free + M^-1 H r      r from lambda
    q_m + h v_1                  where the next step detects, v_1 from g

**No energy is made.** Let S(lambda) be the energy that links store, a convex function, infinite if a rigid link is too
long. Then v minimises ``|v - v_free|^2_M / 2 + S(lambda + h H^T v)``. The value at rest is at least the minimum plus
``|v|^2_M / 2``, so that ``|v|^2_M / 2 + S(lambda + h H^T v) <= |v_free|^2_M / 2 + S(lambda)``.

**Jerks.** A ball strikes a taut straight line. In a step its links do not resist, and it moves by ``h v``: an excess
``(h v)^2 / 2 l``. In the next one the links, which now have the slope ``h v / l``, are shortened by that within h, and
throw the ball back with ``v/2``, more if waves come together. Rigid links give nothing back: the second solve stops it.
The energy that the first one takes, 3/4, hides the energy that it gives. In motion that the step resolves the excess gives
what it takes, and ``u+ = -u-``. So a step is a jerk if rigid links take energy in it, if the work of pulling back the
excess is more than all kinetic energy nearby, and if the second solve leaves less energy than the first; else its nets go
back to g.

The stiffness of links and levers pulls velocities u across links, and spins, towards velocities c (``-kappa (u - c)``). It
adds ``kappa (u - c)^2 / 2`` to what v minimises, so that the right side has ``kappa c^2 / 4`` more. Its work counts as made
by the net: kappa jumps as a chain is jerked straight, and the first solve gives light bodies that whip a work of up to
``kappa u^2 / 4``, with heavy bodies.

**Nets of rods.** The gaps of all links follow from one displacement of the bodies, and so do the excesses. Rigid rods that
cross give more equations than motions. The equations agree if all chains have their detected gaps, or all their predicted
ones, but not if some have the one and some the other: then the step has no solution, and self-stresses of the net grow
without bound. So a chain of rigid rods and all rigid chains and joints with which it shares bodies that may move form one
net, of which all links or none are taken back. A wire holds one way: it may be shorter than its neighbours ask for.

**Wires at points.** A rigid wire at a point that turns with its body is in one net with all rigid links there, as the
moments of their levers work on the body together.

**Joints.** The points of a joint part by ``(h omega)^2 |l| / 2`` as its bodies turn within a step. The excess of its links
is the gap less the gap that they predicted, with its sign. In nets a rigid joint is as a rigid rod: two pendulums on joints
of one law are two nets.

**Tolerances.** The proof asks for ``S(lambda) = 0``, and ``lambda`` contains the error of the step before. The impulses of
nearly straight rods turn this error into energy. If the second solve makes energy, and more than the first, the nets that
were taken back go back to g.

**Nets on one body** share out what it brings, and one may take less because another takes more: the proof is about the sum.
So the energies of two solves are compared for all nets together that interactions and bodies join, and so is the work of
pulling back with the kinetic energy in a jerk.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, JointTable
from lmgcpy.dynamics.geometric_stiffness import connected
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem, ask
from lmgcpy.solve.kernels.law_kernels import StepData

MADE = 0.01
"""Part of the kinetic energy of its bodies, and of what loads give them from rest, that a net may make in a step. A
pendulum that turns by 0.1 rad in a step makes a thousandth on its way up and loses it on its way down: taking it would damp
a motion that the step resolves."""
JERK, STEPS = 1.0, 3.0
"""In a jerk the work of pulling back the excess is more than this part of the kinetic energy of the bodies of a net and of
the bodies that they touch, and more than loads give these from rest in that number of steps. (A pendulum that turns by
omega h in a step does omega^2 h^2 of it; a winch may draw it in until it turns by 0.8 rad. A ball that strikes a taut line:
1.5 and more.)"""
ACCOUNTS = 0.5
"""The work of pulling back the excess is at least this part of the energy made: else something else made the energy."""
TINY = 1e-12
"""A step with less excess, in parts of the shortest link, is not looked at: a link that turns by 1.4e-6 rad has as much."""
TURNS = 4
"""Most solves of a step: once some nets make no more energy, others may begin to."""


class Strand(NamedTuple):
    """A chain or a joint."""

    links: ChainTable
    """The chain, or the joints of one law."""
    group: int
    """First row of the links of all of these."""
    start: int
    stop: int
    """Rows of its own links."""
    bodies: np.ndarray
    """Rows of the bodies that it links."""


class TurningStretch:
    """Remembers the gaps that the links of a model predict, and solves steps anew if the excess would make energy.

    L links, as the detector orders them; ``predicted``: their gaps by the laws at the end of the last step [m], (L,), NaN
    if there was no step.
    """

    def __init__(self, model: Model):
        strands = strands_of(model)
        self._tiny = TINY * min((float((c.radius_sum + c.reference_gap).min()) for c in model.chains), default=0.0)
        self._cuts = np.array([0, *(strand.stop for strand in strands)])
        self._passive = np.array([strand.links.law.NAME in model.passive for strand in strands], dtype=bool)
        self._rods = np.array([is_of_rigid_rods(strand.links) for strand in strands], dtype=bool)
        self._rigid = np.array(["rigid" in strand.links.law.TRAITS for strand in strands], dtype=bool)
        self._ties = np.repeat(np.array([strand.links.law.TIES for strand in strands], dtype=bool), np.diff(self._cuts))
        self.predicted = np.full(self._cuts[-1], np.nan)
        self.look_at(model)

    def look_at(self, model: Model) -> None:
        """Go on with the free components of a model that has changed."""
        self._strands = strands_of(model)
        self._net = nets(self._strands, model.inverse_mass.max(axis=1, initial=0.0) > 0.0)
        order = np.argsort(self._net, kind="stable")
        cuts = np.cumsum(np.bincount(self._net)).tolist()
        self._of_net = [order[first:stop].tolist() for first, stop in itertools.pairwise([0, *cuts])]
        self._one = [any(len(joined_at(self._strands[k])) for k in net) for net in self._of_net]
        bodies = [np.unique(np.concatenate([self._strands[k].bodies for k in net])) for net in self._of_net]
        self._bodies = np.concatenate([np.zeros(0, np.int64), *bodies])
        self._first_body = np.cumsum([0, *(len(of_net) for of_net in bodies)])[:-1]
        self._mass = np.where(model.inverse_mass > 0.0, model.mass, 0.0)[self._bodies]

    def take_back(
        self,
        given: StepProblem,
        solved: StepProblem,
        before: np.ndarray,
        earlier: list[ChainTable] | None,
        solve: Callable[[StepProblem], StepProblem],
        moments: Callable[[StepProblem], np.ndarray],
    ) -> tuple[StepProblem, np.ndarray | None]:
        """The problem that gives the velocities of the step: ``solved``, or the one solved anew if a net makes energy; and
        in that case the impulses of the first solve minus the impulses of the last (m, d), which only moved positions.

        ``given``: the problem as it was assembled; ``before``: velocities at the start of the step (n, k); ``earlier``: the
        chains before they were drawn in or let out, None if none was. ``solved`` and the problem that ``solve`` returns
        have the velocities ``after``. ``moments``: work of the stiffness of levers in a problem by body [J], (n,).
        """
        count, h = len(self.predicted), given.data.time_step
        excess = np.nan_to_num(solved.data.gap[:count] - self.predicted)  # zero if no gap was predicted
        excess = np.where(self._ties, excess, np.fmax(excess, 0.0))
        if not np.abs(excess).max() > self._tiny:
            return solved, None
        first = None
        drawn = np.zeros(count)
        if earlier is not None:
            gaps = [chain.reference_gap_at(given.data.time) for chain in earlier]
            of_chains = slice(sum(len(gap) for gap in gaps))  # joints have no reference gap
            drawn[of_chains] = given.data.reference_gap[of_chains] - np.concatenate(gaps)
        limit = MADE * self._kinetic(before, given.free_velocity)
        passive = np.array([self._passive[net].all() for net in self._of_net], dtype=bool)
        done = ~passive
        taken, together = np.zeros(len(done), dtype=bool), None
        for _ in range(TURNS):
            tension = -solved.system.impulse[:count, 0]
            tension = np.where(self._ties, tension, np.fmax(tension, 0.0))
            # work of pulling back the excess
            pulled = np.bincount(self._net, np.add.reduceat(tension * excess, self._cuts[:-1]) / h)
            suspects = np.flatnonzero((pulled > ACCOUNTS * limit) & ~done).tolist()
            if not suspects:
                break
            made = self._made_by(solved, suspects, drawn, moments(solved))
            found = [net for net in suspects if limit[net] < made[net] < pulled[net] / ACCOUNTS]
            taking = [net for net in suspects if made[net] < -limit[net] and self._rigid[self._of_net[net]].all()]
            work = pulled[found + taking].sum()
            if not found and not any(work > self._jerk([net], given, before) for net in taking):
                break  # no jerk: nets that are joined have no less kinetic energy than one of them
            together = self._together(given) if together is None else together
            jerks: list[int] = []
            for label in np.unique(together[taking]).tolist():
                joined = [net for net in found + taking if together[net] == label]
                if pulled[joined].sum() > self._jerk(joined, given, before):
                    jerks += [net for net in joined if net in taking]
            found += jerks
            if not found:
                break
            taken[found] = done[found] = True
            first = solved.system.impulse.copy() if first is None else first
            judged = np.flatnonzero(np.isin(together, together[found]) & passive).tolist()
            made = self._made_by(solved, judged, drawn, moments(solved))
            solved = self._solve_again(given, taken, excess, solve)
            anew = self._made_by(solved, judged, drawn, moments(solved))
            more, total = (np.bincount(together, work)[together] for work in (anew - made, anew))
            found = [net for net in found if more[net] > 0.0 and (net in jerks or total[net] > 0.0)]
            if found:  # errors of lambda made more than the excess did, or a jerk gave nothing back: to the detected gaps
                taken[found] = False
                given.guess[:] = first
                solved = self._solve_again(given, taken, excess, solve)
        pushed = None if first is None or not taken.any() else first - solved.system.impulse
        return solved, pushed

    def restore(self, predicted: np.ndarray) -> None:
        """Go on from the gaps that a checkpoint holds; older files hold none."""
        self.predicted = predicted.copy() if len(predicted) else np.full(len(self.predicted), np.nan)

    def remember(self, problem: StepProblem) -> None:
        """Keep the gaps that the laws of a step predict, with its velocities ``after``."""
        data, count = problem.data, len(self.predicted)
        if count:
            self.predicted = data.gap[:count] + data.time_step * data.after[:count, 0]

    def move_on(self, ways: np.ndarray) -> None:
        """Let the bodies have gone on, by relative ``ways`` (m, d), from where the last step predicted the gaps."""
        self.predicted = self.predicted + ways[: len(self.predicted), 0]

    def _kinetic(self, before: np.ndarray, free: np.ndarray) -> np.ndarray:
        """Kinetic energy of the bodies of each net before the step, and what its loads give them from rest [J]; from
        velocities before it and without impulses, (n, k)."""
        before = before[self._bodies]
        given = free[self._bodies] - before
        return 0.5 * np.add.reduceat(np.einsum("bk,bk->b", self._mass, before * before + given * given), self._first_body)

    def _jerk(self, nets: list[int], given: StepProblem, before: np.ndarray) -> float:
        """The least work of pulling back the excess of nets in a jerk [J]; from velocities before the step (n, k)."""
        c, a = given.system.candidate, given.system.antagonist
        own = np.zeros(len(before), dtype=bool)
        own[np.concatenate([self._strands[k].bodies for net in nets for k in self._of_net[net]])] = True
        own &= given.inverse_mass.max(axis=1) > 0.0
        near = np.union1d(np.flatnonzero(own), np.concatenate([c[own[a]], a[own[c]]]))
        inverse, before = given.inverse_mass[near], before[near]
        squares = np.stack([before, STEPS * (given.free_velocity[near] - before)]) ** 2
        energies = 0.5 * np.divide(squares, inverse, out=np.zeros_like(squares), where=inverse > 0.0)
        moving, loaded = energies.sum(axis=(1, 2)).tolist()
        return max(JERK * moving, loaded)

    def _solve_again(
        self, given: StepProblem, taken: np.ndarray, excess: np.ndarray, solve: Callable[[StepProblem], StepProblem]
    ) -> StepProblem:
        """The step solved without the ``excess`` (L,) of the nets ``taken``, bool."""
        again, gap = given, given.data.gap.copy()
        if taken.any():
            gap[: len(excess)] -= np.where(np.repeat(taken[self._net], np.diff(self._cuts)), excess, 0.0)
            again = replace(given, data=given.data._replace(gap=gap))
        again.prepare()
        return solve(again)

    def _together(self, problem: StepProblem) -> np.ndarray:
        """A number for each net: the same if interactions and bodies that may move join them."""
        rows = problem.interaction_matrix()
        row, column = rows.nonzero()
        moves = problem.inverse_mass.ravel()[column] > 0.0
        body = rows.shape[0] + column[moves] // problem.inverse_mass.shape[1]
        # nets have numbers after rows and bodies, as a link of a net may join held bodies
        first = rows.shape[0] + len(problem.inverse_mass)
        net = np.repeat(self._net, np.diff(self._cuts))
        row = np.concatenate([row[moves], problem.system.impulse.shape[1] * np.arange(len(net))])
        return connected(row, np.concatenate([body, first + net]), first + len(self._of_net))[first:]

    def _made_by(
        self, problem: StepProblem, nets: list[int], drawn: np.ndarray, moments: np.ndarray
    ) -> np.ndarray:
        """Energy that these nets make in the step, rigid ones with the work of the ``moments`` on their bodies (n,) [J],
        zero for all others; ``drawn``: change of the reference gaps by hand [m], (L,)."""
        made, of_bodies = np.zeros(len(self._of_net)), np.add.reduceat(moments[self._bodies], self._first_body)
        for net in nets:
            made[net] = sum(self._made(problem, self._strands[k], drawn) for k in self._of_net[net])
            made[net] += of_bodies[net] if self._one[net] else 0.0
        return made

    def _made(self, problem: StepProblem, strand: Strand, drawn: np.ndarray) -> float:
        """Energy that a strand makes in the step: the work of its impulses, and the growth of its stored energy [J].

        A winch that draws in a rigid link does the work ``r_n drawn / h``, which the link does not make. Energy that a
        winch stores in a link is there before the step.
        """
        start, stop = strand.start, strand.stop
        data, part = problem.data, slice(start, stop)
        work = 0.5 * float((problem.system.impulse[part] * (data.before[part] + data.after[part])).sum())
        at = next(k for k, group in enumerate(problem.by_law) if group.start == strand.group)
        group, energy = problem.by_law[at], problem.kernels[at].energy
        if energy is None:
            return work - float(problem.system.impulse[part, 0] @ drawn[part]) / data.time_step

        def stored(data: StepData) -> float:
            return float(ask(group, energy, "energy", problem.system, data, (start, stop, data, group.parameters.ravel())))

        before = data._replace(gap=data.gap.copy(), after=np.zeros_like(data.after))
        before.gap[part] = self.predicted[part]
        return work + stored(data) - stored(before)


def is_of_rigid_rods(chain: ChainTable) -> bool:
    """Whether the links of a chain are rigid and hold both ways."""
    return "rigid" in chain.law.TRAITS and "pull" not in chain.law.TRAITS


def strands_of(model: Model) -> list[Strand]:
    """The chains and the joints of a model, as the detector orders them."""
    strands, first = [], 0
    for links in model.links:
        d = model.dimension
        if isinstance(links, JointTable):
            joints = range(first, first + links.link_count, d)
            strands += [Strand(links, first, at, at + d, links.bodies[2 * j : 2 * j + 2]) for j, at in enumerate(joints)]
        else:
            strands.append(Strand(links, first, first, first + links.link_count, links.bodies))
        first += links.link_count
    return strands


def joined_at(strand: Strand) -> np.ndarray:
    """Rows of the bodies at which a strand is one with all rigid strands there: all of rigid rods; of a rigid wire those
    that turn under it, as their moments work on them together."""
    links = strand.links
    if "rigid" not in links.law.TRAITS:
        return strand.bodies[:0]
    if is_of_rigid_rods(links):
        return strand.bodies
    if links.points is None:
        return strand.bodies[:0]
    return strand.bodies[links.points.turns]


def nets(strands: list[Strand], free: np.ndarray) -> np.ndarray:
    """Net of each strand, numbered from 0: rigid strands that share a body that may move are one, if one of them is joined
    there (:func:`joined_at`). Every other strand is a net of its own.

    ``free``: whether a body may move, (n,).
    """
    rigid = [k for k, strand in enumerate(strands) if "rigid" in strand.links.law.TRAITS]
    joins = np.zeros(len(free), dtype=bool)
    for k in rigid:
        joins[joined_at(strands[k])] = True
    joins &= free
    leads = list(range(len(strands)))  # from a strand on to the first one of its net

    def first_of(strand: int) -> int:
        while leads[strand] != strand:
            leads[strand] = strand = leads[leads[strand]]
        return strand

    seen: dict[int, int] = {}  # strand of a body
    for k in rigid:
        for body in strands[k].bodies[joins[strands[k].bodies]].tolist():
            leads[first_of(k)] = first_of(seen.setdefault(body, k))
    return np.unique([first_of(k) for k in range(len(strands))], return_inverse=True)[1]
