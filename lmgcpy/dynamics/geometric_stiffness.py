"""Geometric stiffness: the impulse across a taut link that answers motion across it, within the step.

The normal of a link is taken at the detection, so that the turning of its tension T within the step is explicit. Across a
wire of beads of mass m and links of length l the step is then a leapfrog, unstable beyond ``s = 4 h^2 T/(m l) = 4``: light
beads under a heavy load zigzag, the stretch this leaves is pulled back in the next step, and that is a blow which makes
energy. The remedy is the term that the linearisation of the normal drops (Tournier, Nesme, Gilles, Faure 2015, ACM Trans.
Graph. 34; Andrews, Teichmann, Kovecses 2017): the impulse acts along the link as it will have turned,

    r_t = -kappa (u_t - c_t),      kappa = max(0, h |r_n| / l - 2 / P)  in tension,  0 otherwise,

with ``P = p_c / m_c + p_a / m_a`` for a link whose beads are held by p_c and p_a links. If ``s = h |r_n| P / l <= 2``, the
step resolves the motion of the beads, and nothing is added. In compression nothing is added either: a rod that buckles does
so for good physical reasons.

``c_t = l (omega x n)_t`` is the velocity across the link by the turning of the wire as a whole, at the angular velocity
omega that the wire had before the step. So the term resists bending of the wire, and slows down neither a pendulum nor a
spinning wire. Single links, one after another (``Scene.link``), are one wire: they go on at bodies that move and that two
of them and no other link hold. (By itself a link would turn as it turned before, and hold its own zigzag.)

**Jerks of free nets.** The impulses across the links of a net are a couple ``sum l n x r_t``, which is zero if omega
minimises ``sum kappa |u_t - l (omega x n)_t|^2`` with the velocities at the end: then the angular momentum is kept, and the
impulses take ``sum kappa |u_t - c_t|^2``. In smooth motion the two omegas differ by little. A jerk gives a net its rotation
within the step. So if the couple of a net that holds at nothing is more than :data:`COUPLE` of its tensions times their
lengths, the step is solved anew with one omega for the net, until it is the one of the velocities found.

**Stability** (docs/nscd.md). With ``C = sum kappa b b^T`` and ``K = sum (T/l) b b^T`` over the links, b the map from
velocities to the relative velocity across a link, the quantity ``v.(M + C/2 - h^2 K/4) v / 2 + x.K x / 2`` does not grow,
and it is positive at any step, mass and tension: ``sum b b^T / P <= M``, as the masses are shared out among the links.

**Pinched segments.** A contact on a thread or membrane (:mod:`lmgcpy.contact.elements`) turns with the element. With z the
distance of the other body's axis or centre from the axis of the element, two grains that pinch a segment with forces N
from both sides bring it back like a spring: the gap has the second derivative ``-z (n . sum G_k dx_k)^2``. As the G_k have
the sum zero, N z times this is the energy of springs across the links between the corners,

    k_ij = -N z G_i . G_j,       of a segment of length l: N z / l^2,

so that such a contact stiffens a link as a tension ``k_ij l`` does.

**kappa and r_n.** kappa is kept while a step is solved, so that the problem remains the linear complementarity problem that
solvers know, with one more linear row for each link and direction. Afterwards it is compared with the kappa of the impulses
found. If they differ, the step is solved again from these impulses. In smooth motion the kappa of the last step's impulses
is enough.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable
from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.interactions import levers
from lmgcpy.contact.links import turning_mobility
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.solve.kernels.stiffened_wire_block import scratch_columns
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.problems.report import NOT_FINITE, SOLVED_CODES, Outcome
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.solve.sweeps.sweep import only_out_of_balance

ENOUGH = 0.1
"""A stiffness is enough if it differs by no more than this part from the one that the impulses call for: a tenth below it,
``alpha = 0.9 - 1.8/s`` is still far from the least stable value, ``1/2 - 2/s``."""
TURNS = 30
"""Most solves of a step. (Jerked wires of 21 beads, mass ratios of 1e3 and 1e5: 17 at the worst, in the
first step of the jerk, and 1.0 to 1.3 in the mean.)"""
BOTH_WAYS = 2
"""From this turn on stiffnesses only grow, and may be larger than called for: if a link is taut in one turn and slack in
the next, the larger stiffness is stable and ends the search."""

COUPLE = 1e-4
"""See the module's text: about the angle [rad] by which the couple turns the tensions. (A chain that fell among 1000
grains did not come to it in 1000 steps.)"""
SEARCH = 10
"""Most solves of a step in search of omega, which answers linearly as long as no contact changes."""

MOST = 1e10
"""Most of ``kappa P``: it fixes the motion across a link to 1e-10, and velocities are right to eps times it, 2e-6. Tensions
that call for more are self-stresses of nets that a step has not solved, up to 1e14 N s. They begin the next turn, and a
stiffness of 1e14 bead masses made sweeps diverge, or locked steps that have a solution. (Four scenes of drawn ropes, picked
from 350 as they failed, 36 steps each: 79 unsolved steps without a bound, 26 with 1e12, 5 with 1e10, 1 with 1e8; but a bead
1e-8 times as heavy as others calls for 1e8 with reason.)"""

NODES = ("corner", "tip")
"""Ends of the kinds of elements that are nodes: contacts on them do not turn with a link."""


@dataclass(frozen=True)
class Pinched:
    """Contacts on links, see the module's text; k of them."""

    row: np.ndarray
    """Row of the interaction, (k,)."""
    link: np.ndarray
    """Link on which it is, (k,)."""
    factor: np.ndarray
    """``-z l G_i . G_j``: tension that it is worth, in parts of its normal impulse, (k,)."""

    def tension(self, impulse: np.ndarray, count: int) -> np.ndarray:
        """The tensions of ``count`` links that the contacts are worth [N s], (L,), for impulses (m, d)."""
        return np.bincount(self.link, self.factor * np.maximum(impulse[self.row, 0], 0.0), count)


def key_of(pairs: np.ndarray) -> np.ndarray:
    """A number for each pair of bodies (k, 2), in either order."""
    low, high = np.sort(pairs, axis=1).T
    return (low << 32) + high


@dataclass(frozen=True)
class LinkStiffness:
    """The links of all chains, one after another, as the detector orders them; L of them."""

    count: int
    dimension: int
    radius_sum: np.ndarray
    """Sum of the two radii [m], (L,)."""
    share: np.ndarray
    """P, see the module's text [1/kg], (L,). A point off the centre has more mobility than 1/m: the greatest that it may
    have is taken."""
    joined: np.ndarray
    """Whether a link shares a bead with the next one of its chain, (L,) bool."""
    following: np.ndarray
    """Row of the next link of its chain, (L,)."""
    wires: list[np.ndarray | slice]
    """Links of each wire: of a chain, or of single links that go on from each other."""
    turns: bool
    """Whether some act at points that turn with their bodies."""
    ends: np.ndarray
    """Rows of the two bodies of each link, (L, 2)."""
    free: np.ndarray
    """Whether a body moves freely, (n,) bool."""

    @classmethod
    def of(cls, chains: list[ChainTable], inverse_mass: np.ndarray, dimension: int) -> LinkStiffness:
        """Gather the links of a model; ``inverse_mass`` by component, (n, k)."""
        nothing = np.zeros(0, np.int64)
        inverse = inverse_mass[:, :dimension]
        a = np.concatenate([nothing, *(chain.bodies[:-1] for chain in chains)])
        c = np.concatenate([nothing, *(chain.bodies[1:] for chain in chains)])
        held = np.bincount(np.concatenate([a, c]), minlength=len(inverse))  # links at each body
        weight_a, weight_c = (held[ends] * inverse.max(axis=1, initial=0.0)[ends] for ends in (a, c))
        turning = inverse_mass[:, dimension:].max(axis=1, initial=0.0)
        cuts = np.cumsum([0, *(chain.link_count for chain in chains)])
        following = np.arange(1, len(a) + 1)
        joined = np.ones(len(a), dtype=bool)
        for chain, first, end in zip(chains, cuts[:-1], cuts[1:], strict=True):
            following[end - 1] = first
            if chain.bodies[0] != chain.bodies[-1]:
                joined[end - 1] = False
            if chain.points is not None:  # at most 1/m + |p|^2 / I
                square = (chain.points.offset**2).sum(axis=1)
                more = held[chain.bodies] * turning[chain.bodies] * np.where(chain.points.turns, square, 0.0)
                weight_a[first:end] += more[:-1]
                weight_c[first:end] += more[1:]
        radius_sum = np.concatenate([np.zeros(0), *(chain.radius_sum for chain in chains)])
        turns = any(chain.form == "lever" for chain in chains)
        ends = np.column_stack([a, c])
        wires = wires_of(ends, cuts, (held == 2) & (inverse.max(axis=1, initial=0.0) > 0.0))
        free = inverse.min(axis=1, initial=np.inf) > 0.0
        return cls(len(a), dimension, radius_sum, weight_a + weight_c, joined, following, wires, turns, ends, free)

    def resolution(
        self, impulse: np.ndarray, gap: np.ndarray, time_step: float, pinched: Pinched | None = None
    ) -> np.ndarray:
        """``s = h |r_n| P / l`` of each link in tension, zero of the others, (L,); impulses (m, d), gaps (m,).

        Beyond 2 the step does not resolve the motion of the beads across their wire.
        """
        tension = np.maximum(-impulse[: self.count, 0], 0.0)
        if pinched is not None:
            tension += pinched.tension(impulse, self.count)
        length = gap[: self.count] + self.radius_sum
        return time_step * tension * self.share / np.where(length > 0.0, length, np.inf)  # of no length: no direction

    def stiffness(
        self, impulse: np.ndarray, gap: np.ndarray, time_step: float, pinched: Pinched | None = None
    ) -> np.ndarray:
        """kappa of each link [kg], (L,)."""
        excess = np.minimum(self.resolution(impulse, gap, time_step, pinched) - 2.0, MOST)
        return np.where(excess > 0.0, excess, 0.0) / np.where(self.share > 0.0, self.share, 1.0)

    @cached_property
    def _keys(self) -> tuple[np.ndarray, np.ndarray]:
        """Keys of the links by their bodies, and their order."""
        keys = key_of(self.ends)
        return keys, np.argsort(keys)

    def pinched(self, problem: StepProblem) -> Pinched | None:
        """The contacts of a step that lie on links, None if there are none."""
        s, d = problem.system, self.dimension
        if not s.corner.shape[1]:
            return None
        keys, order = self._keys
        rows, links, factors = [], [], []
        for group in problem.by_law:
            if not group.on_elements:
                continue
            assert group.kinds is not None
            at, part = 0, slice(group.start, group.stop)
            arm = np.abs(s.arm[part]).sum(axis=1)
            kinds = group.kinds.candidate, group.kinds.antagonist
            for kind, count, side in zip(kinds, group.kinds.corners, (0, 1), strict=True):
                corner = s.corner[part, at : at + count].astype(np.int64)
                tilt = s.weight[part].reshape(len(corner), -1, d + 1)[:, at : at + count, 2:]  # rho G
                at += count if count > 1 else 0
                if count == 1 or kind.endswith(NODES):
                    continue
                rho = s.arm[part, side]
                for i, j in itertools.combinations(range(count), 2):
                    key = key_of(corner[:, [i, j]])
                    link = order[np.minimum(np.searchsorted(keys[order], key), len(keys) - 1)]
                    length = problem.data.gap[link] + self.radius_sum[link]
                    factor = -arm * length * (tilt[:, i] * tilt[:, j]).sum(axis=1) / np.where(rho != 0.0, rho, np.inf) ** 2
                    here = np.flatnonzero((keys[link] == key) & (factor > 0.0))
                    rows.append(group.start + here)
                    links.append(link[here])
                    factors.append(factor[here])
        return Pinched(np.concatenate(rows), np.concatenate(links), np.concatenate(factors)) if rows else None

    def stiffen(self, problem: StepProblem, stiffness: np.ndarray, before: np.ndarray) -> StepProblem:
        """The problem of the step with these stiffnesses (L,); ``before``: stiffnesses of the impulses at its start, (L,),
        the weights of the links in the turning of their wire."""
        s, d = problem.system, self.dimension
        frame = local_frames(s.normal[: self.count])
        across = frame.transpose(0, 2, 1)
        own, shared = self._blocks(s, frame)
        length = problem.data.gap[: self.count] + self.radius_sum
        carried = self._carried(frame, length, problem.data.before[: self.count], before)
        if problem.carried is not None:
            carried = np.where(np.isnan(problem.carried), carried, problem.carried)
        system = s._replace(
            geometric=stiffness.copy(),
            carried=carried,
            own=own @ across,
            following=-shared @ across[self.following],
            scratch=np.zeros((len(s.scratch), scratch_columns(d)["WIDTH"])),
        )
        return problem.on(system, stiffened=True)

    def _blocks(self, s: System, frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """``frame K`` (L, d, d) of each link with the mobility K of its two ends [1/kg], and with the mobility of the end
        that it shares with the next link."""
        d, ends = self.dimension, (s.candidate[: self.count], s.antagonist[: self.count])
        of_candidate, of_antagonist = (s.inverse_mass[ids, :d] for ids in ends)
        shared = np.where(self.joined[:, None], of_candidate, 0.0)
        own = frame * (of_candidate + of_antagonist)[:, None]  # a quarter of the time of einsum
        if not self.turns:
            return own, frame * shared[:, None]
        lever = levers(s, slice(self.count))
        of_candidate, of_antagonist = (
            turning_mobility(lever[:, end], s.axes[ids].reshape(-1, 3, 3) if d == 3 else None, s.inverse_mass[ids, d:])
            for end, ids in enumerate(ends)
        )
        more = np.where(self.joined[:, None, None], of_candidate, 0.0)
        return own + frame @ (of_candidate + of_antagonist), frame * shared[:, None] + frame @ more

    def _carried(self, frame: np.ndarray, length: np.ndarray, velocity: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """c_t of each link [m/s], (L, d - 1), from the relative velocities (L, d) at the start of the step."""
        carried = np.zeros((self.count, self.dimension - 1))
        for wire in self.wires:
            if weight[wire].any():
                turns = turning(frame[wire], length[wire])
                carried[wire] = turns @ omega_of(turns, velocity[wire, 1:], weight[wire])
        return carried

    @cached_property
    def nets(self) -> list[np.ndarray]:
        """Links of each connected set of chains of which no body is held, (l,); none if some act at points."""
        if self.turns:
            return []
        label = connected(self.ends[:, 0], self.ends[:, 1], len(self.free))
        of_links = label[self.ends[:, 0]]
        return [np.flatnonzero(of_links == net) for net in np.setdiff1d(of_links, label[~self.free]).tolist()]

    def turned(self, problem: StepProblem) -> Turned | None:
        """The free nets whose impulses across their links are a couple, None if there are none."""
        if not self.nets:
            return None
        s = problem.system
        frame = local_frames(s.normal[: self.count])
        length = problem.data.gap[: self.count] + self.radius_sum
        turns = turning(frame, length)
        couple = np.einsum("lao,la->lo", turns, s.impulse[: self.count, 1 : self.dimension])
        moment = length * np.abs(s.impulse[: self.count, 0])
        out = [net for net in self.nets if np.linalg.norm(couple[net].sum(axis=0)) > COUPLE * moment[net].sum()]
        if not out:
            return None
        velocity = problem.relative_velocities(s.velocity)[: self.count, 1 : self.dimension]
        omegas = [omega_of(turns[net], velocity[net], s.geometric[net]) for net in out]
        return Turned(out, [turns[net] for net in out], omegas)


class Turned(NamedTuple):
    """Free nets that a step turns, see the module's text."""

    nets: list[np.ndarray]
    """Links of each."""
    turns: list[np.ndarray]
    """``(omega x l n)_t`` of its links for a unit omega, (l, d - 1, o)."""
    omegas: list[np.ndarray]
    """omega of each by the velocities found [rad/s], (o,)."""


class Search:
    """The search for the angular velocities that a step gives to its nets, fixed points of an affine function: Anderson's
    method (1965, J. ACM 12)."""

    def __init__(self) -> None:
        self._tried: dict[int, tuple[list[np.ndarray], list[np.ndarray]]] = {}
        self.begun: np.ndarray | None = None
        """c_t before the search, (L, d - 1)."""
        self.ended = False

    def go_on(self, turned: Turned, carried: np.ndarray) -> None:
        """Enter the next c_t of the nets that are not in balance."""
        self.begun = carried.copy() if self.begun is None else self.begun
        for net, turns, found in zip(turned.nets, turned.turns, turned.omegas, strict=True):
            taken, errors = self._tried.setdefault(int(net[0]), ([], []))
            following = found
            if taken:
                errors.append(found - taken[-1])
                if len(errors) > 1:
                    change, moved = (np.diff(values, axis=0).T for values in (errors, taken))
                    following = found - (moved + change) @ np.linalg.lstsq(change, errors[-1], rcond=1e-10)[0]
            taken.append(following)
            carried[net] = turns @ following
            self.ended |= len(taken) > SEARCH


def connected(c: np.ndarray, a: np.ndarray, count: int) -> np.ndarray:
    """A number for each of ``count`` bodies, (n,): the same if links between bodies ``c`` and ``a`` (L,) join them."""
    from scipy.sparse import coo_array  # takes as long to import as the rest of lmgcpy
    from scipy.sparse.csgraph import connected_components

    label: np.ndarray = connected_components(coo_array((np.ones(len(c)), (c, a)), shape=(count, count)), directed=False)[1]
    return label


def turning(frame: np.ndarray, length: np.ndarray) -> np.ndarray:
    """Velocities across links for a unit angular velocity, (L, d - 1, o): ``l`` in 2D; in space ``(omega x n).t = omega.b``
    and ``(omega x n).b = -omega.t``."""
    if frame.shape[1] == 2:
        return length[:, None, None]
    return length[:, None, None] * np.stack([frame[:, 2], -frame[:, 1]], axis=1)


def omega_of(turns: np.ndarray, velocity: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The angular velocity that minimises ``sum weight |u_t - l (omega x n)_t|^2`` [rad/s], (o,); velocities (L, d - 1)."""
    if turns.shape[2] == 1:
        lever = turns[:, 0, 0]
        return np.array([(weight * lever) @ velocity[:, 0] / ((weight * lever) @ lever)])
    root = np.sqrt(weight)[:, None]
    omega: np.ndarray = np.linalg.lstsq((root[..., None] * turns).reshape(-1, 3), (root * velocity).ravel(), rcond=1e-10)[0]
    return omega


def wires_of(ends: np.ndarray, cuts: np.ndarray, between: np.ndarray) -> list[np.ndarray | slice]:
    """The links of each wire, from the bodies of the links (L, 2), the first link of each chain and L, and whether a body
    may be between two links of a wire, (n,) bool."""
    single = cuts[:-1][np.diff(cuts) == 1]
    of_link = np.repeat(single, 2)
    body = ends[single].ravel()
    order = np.argsort(body, kind="stable")
    pairs = np.flatnonzero((body[order][1:] == body[order][:-1]) & between[body[order][1:]])
    leads = {link: link for link in of_link.tolist()}

    def first_of(link: int) -> int:
        while leads[link] != link:
            leads[link] = link = leads[leads[link]]
        return link

    for one, other in zip(of_link[order[pairs]].tolist(), of_link[order[pairs + 1]].tolist(), strict=True):
        low, high = sorted((first_of(one), first_of(other)))
        leads[high] = low
    together: dict[int, list[int]] = {}
    for link in leads:
        together.setdefault(first_of(link), []).append(link)
    chains = itertools.pairwise(cuts.tolist())
    return [
        np.array(together[first]) if first in together else slice(first, stop)
        for first, stop in chains
        if first not in leads or first in together
    ]


def enough(used: np.ndarray, needed: np.ndarray, share: np.ndarray, turn: int) -> bool:
    """Whether the stiffnesses ``used`` are enough for the impulses found with them in this turn, from 0; ``share``: inverse
    of the mass or inertia that bears each."""
    difference = needed - used if turn >= BOTH_WAYS else np.abs(needed - used)
    return bool((difference * share <= ENOUGH * (needed * share + 2.0)).all())


def after_turn(used: np.ndarray, needed: np.ndarray, turn: int) -> np.ndarray:
    """The stiffnesses of the turn after this one."""
    return np.maximum(used, needed) if turn >= BOTH_WAYS else needed


def solve_stiffened(links: LinkStiffness, problem: StepProblem, solver: Solver) -> tuple[StepProblem, Outcome, int]:
    """Solve a step until the stiffnesses of its links fit the impulses found. Returns the problem of the last turn; its
    outcome, with the sweeps and Newton steps of all turns; the number of turns.

    Then, until the angular velocities of free nets fit as well. If a step with them is not solved they stay as they were.

    The turns also end once three of them were not solved, or one for light bodies that are out of balance.
    """
    gap, h = problem.data.gap, problem.data.time_step
    plain, stiffened = problem, None
    pinched = links.pinched(problem)
    used = before = links.stiffness(problem.guess, gap, h, pinched)
    sweeps = factorisations = unsolved = 0
    search = Search()
    for turn in range(TURNS):
        problem.guess[: links.count, 1:][used == 0.0] = 0.0
        if not used.any():
            problem = plain
        elif stiffened is None:
            problem = stiffened = links.stiffen(plain, used, before)
        else:  # nothing else changes
            problem = stiffened
            problem.system.geometric[:] = used
            problem.system.scratch.fill(0.0)
        outcome = solver.solve(problem)
        sweeps += outcome.iterations
        factorisations += outcome.factorisations
        unsolved += outcome.status not in SOLVED_CODES
        if outcome.status not in SOLVED_CODES and search.begun is not None and not search.ended:
            problem.system.carried[:] = search.begun
            search.ended = True
            continue
        needed = links.stiffness(problem.system.impulse, gap, h, pinched)
        if outcome.status == NOT_FINITE or unsolved == 3:
            break
        if enough(used, needed, links.share, turn):
            turned = links.turned(problem) if problem is stiffened and not search.ended else None
            if turned is None or plain.carried is not None:
                break
            search.go_on(turned, problem.system.carried)
            plain.guess[:] = problem.system.impulse
            continue
        if problem.light.out.any() and only_out_of_balance(solver.bounds, problem.system.measured):
            break
        used = after_turn(used, needed, turn)
        plain.guess[:] = problem.system.impulse
    return problem, outcome._replace(iterations=sweeps, factorisations=factorisations), turn + 1
