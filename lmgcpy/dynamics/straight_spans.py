"""Straight spans that cross: rigid links in line between two held bodies, whose tension nothing determines.

If both ends are held, the same tension T in every link of a span gives the body between two links ``T (n' - n)``, nothing
if the span is straight: no finite tension holds its weight, and the laws leave its tension to round-off and to tolerances.
A solver keeps the tension that it was given, with errors in proportion to it. A single span is one block of the sweep, and
its tension stays. But if spans share bodies, as in a flat net, these errors pass from one span to another; tensions of some
and compressions of others walk from sweep to sweep and from step to step, without end.

Of all tensions that solve the step the least is wanted, the limit of small slack: with slack a span sags by an angle a
until ``T = m g/a``. So such a span begins a step with half of the impulses that its links had. A solver still finds the
tensions that the laws determine; the others fall from step to step, until the span sags by angles that the laws see. (In a
step half of a sag is pulled back, and the tension doubles: "Straight between held beads" in docs/nscd.md.)

**Spans that are too short.** If a body of a taut chain is held while the chain moves, its links have an excess e of turning
(:mod:`lmgcpy.dynamics.turning_stretch`), which no motion between the held ends takes back: the step asks for self-stresses
without bound. Such a span gives way: its links share out ``e``, and laws get their gaps less that. Then a blow has the
momentum that it stops. If a link has been drawn shorter than it began, or the ends are driven, the span does not give way,
and the run says that it is too short. (A step may seem solved: bodies that are nearly in line move across it, by a way that
gives the linearised lengths.)

**Spans through points and joints.** A span goes on from chain to chain, and from joint to joint, through bodies at which
two ends of rigid links meet. A body that a span enters at the point p and leaves at q is a part of the length ``|q - p|``,
however it is turned. So the ends are no farther apart than the sum L of the lengths of links and bodies, and with the
distance D of the ends, ``e = D - L``. A link gets the part of e that its length has in L, with half of the lengths of the
bodies on both sides; a joint has no length of its own. The gap of a joint is a vector, and gets its part along the line
from end to end. Afterwards all vectors of a span add up to the length L, which the straight span has. If the centre of a
body is held and the body may spin, a span ends at the centre.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable, JointTable
from lmgcpy.contact.interactions import levers
from lmgcpy.dynamics.step_problem import StepProblem

STRAIGHT = 1e-10
"""Mean square of the angles between its links up to which a span is straight. (Flat nets of 2 to 12 links a
side, steps of 4 to 0.25 ms: 1e-8 does as well, with 1e-12 some steps take ten times the sweeps.)"""
KEPT = 0.5
"""Part of its impulses with which a step begins. (With 0.9 nets of wires still explode, with 0.1 tensions
jump by a factor of 1e3.)"""
TOO_SHORT = 1e-12, 1e-3
"""A span gives way if it is too short by a part of its length between these: more than round-off, and no more than links
leave that turn by 0.045 rad in a step."""
DRAWN = 1e-9
"""Part of the length of a span by which links may be shorter than they began and are not drawn, and by which a span that
does not give way may be too short."""


class Piece(NamedTuple):
    """Links of a chain from a held body, or its begin, to the next one, or its end; or a joint."""

    links: ChainTable
    row: int
    """Row of the first link of ``links``, as the detector orders them."""
    first: int
    stop: int
    """Places in ``links`` of its first link, and behind its last one; of a closed chain this may go round."""
    ends: tuple[int, int]
    """Rows of its first and last body."""

    def on_the_way(self, backward: bool, dimension: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Its links in the order of a span, a joint as one: first rows (k,), bodies (k + 1,), their points (k + 1, d), zero
        if these do not turn, and gaps at the start (k,)."""
        links = self.links
        if isinstance(links, JointTable):
            row, place = np.array([self.row + self.first]), 2 * self.first // dimension + np.arange(2)
            start = np.zeros(1)
        else:
            at = np.arange(self.first, self.stop) % links.link_count
            row, place, start = self.row + at, np.arange(self.first, self.stop + 1), links.start_gap[at]
            if links.closed:
                place %= links.link_count
        point = np.zeros((len(place), dimension))
        if links.points is not None:
            point = np.where(links.points.turns[place, None], links.points.offset[place], 0.0)
        found = row, links.bodies[place], point, start
        return tuple(part[::-1] for part in found) if backward else found  # type: ignore[return-value]


def pieces_of(tables: list[ChainTable], held: np.ndarray, dimension: int) -> list[Piece]:
    """The pieces of the rigid ones among chains and joints; ``held``: whether the centre of a body is, (n,) bool."""
    pieces, row = [], 0
    for links in tables:
        if "rigid" in links.law.TRAITS:
            count, bodies = links.link_count, links.bodies
            if isinstance(links, JointTable):
                for j, ends in enumerate(bodies.reshape(-1, 2).tolist()):
                    pieces.append(Piece(links, row, dimension * j, dimension * (j + 1), tuple(ends)))
            else:
                cuts = np.flatnonzero(held[bodies[:-1]])
                cuts = np.append(cuts, cuts[:1] + count) if links.closed else np.unique([0, *cuts, count])
                for first, stop in itertools.pairwise(cuts.tolist()):
                    last = stop % count if links.closed else stop
                    pieces.append(Piece(links, row, first, stop, (int(bodies[first]), int(bodies[last]))))
        row += links.link_count
    return pieces


def ways(pieces: list[Piece], held: np.ndarray) -> list[list[tuple[Piece, bool]]]:
    """Pieces that lead from one held body to another, with whether each is passed backward."""
    at: dict[int, list[tuple[int, int]]] = {}
    within: set[int] = set()
    for k, piece in enumerate(pieces):
        for end, body in enumerate(piece.ends):
            at.setdefault(body, []).append((k, end))
        if not isinstance(piece.links, JointTable):
            around = len(piece.links.bodies) - piece.links.closed
            within.update(piece.links.bodies[np.arange(piece.first + 1, piece.stop) % around].tolist())
    found = []
    for k, piece in enumerate(pieces):
        for end in (0, 1):
            if not held[piece.ends[end]]:
                continue
            way, now = [(piece, end == 1)], (k, 1 - end)
            while not held[body := pieces[now[0]].ends[now[1]]] and len(at[body]) == 2 and body not in within:
                other, its = at[body][at[body][0] == now]
                way.append((pieces[other], its == 1))
                now = other, 1 - its
            if held[body] and (k, end) < now:  # once, not again from its other end
                found.append(way)
    return found


@dataclass(frozen=True)
class StraightSpans:
    """The spans of a model, S of them with K links, a joint being one, and J inner bodies in all; none in most scenes."""

    ends: np.ndarray
    """The two held bodies of each span, (S, 2)."""
    crosses: np.ndarray
    """Whether all of its links are between centres, and one of its inner bodies is in another span too, (S,) bool."""
    central: np.ndarray
    """Whether all of its links are between centres, (S,) bool."""
    link: np.ndarray
    """Rows of the links, of a joint the first, one span after another, (K,), as the detector orders them."""
    span: np.ndarray
    """Span of each of these links, (K,)."""
    inner: np.ndarray
    """Places in ``link`` of the links before the inner bodies, (J,); the links after the bodies come next."""
    start: np.ndarray
    """Gaps with which these links began [m], (K,)."""
    weight: np.ndarray
    """Inverse masses of the inner bodies by component, divided by the sum of the largest ones over the span, (J, d)."""
    sense: np.ndarray
    """1 if a span passes a link from its antagonist to its candidate, else -1, (K,)."""
    joint: np.ndarray
    """Whether it is a joint, (K,) bool."""
    more: np.ndarray
    """Length of bodies that counts to a link [m], (K,)."""
    radius_sum: np.ndarray
    """Sum of the radii at the ends of a link [m], (K,)."""
    turns: np.ndarray
    """Whether the antagonist and the candidate of a link may turn about their centres; inner bodies always, (K, 2) bool."""
    held: np.ndarray
    """Whether components of the velocities of the two ends are held or driven, (S, 2, k) bool."""

    @classmethod
    def of(cls, tables: list[ChainTable], inverse_mass: np.ndarray, dimension: int) -> StraightSpans:
        """Find the spans of a model; ``tables``: its chains and joints; ``inverse_mass`` by component, (n, k)."""
        inverse = inverse_mass[:, :dimension]
        held = inverse.max(axis=1, initial=0.0) == 0.0
        radius_sum = np.concatenate([np.zeros(0), *(links.radius_sum for links in tables)])
        pieces = pieces_of(tables, held, dimension) if any(held[links.bodies].any() for links in tables) else []
        rows, bodies_of, starts, senses, joints, lengths, central, turn = [], [], [], [], [], [], [], []
        for way in ways(pieces, held):
            parts = [piece.on_the_way(backward, dimension) for piece, backward in way]
            row, start = (np.concatenate([part[i] for part in parts]) for i in (0, 3))
            if len(row) == 1:
                continue
            bodies = np.concatenate([parts[0][1][:1], *(part[1][1:] for part in parts)])
            turns = inverse_mass[bodies[[0, -1]], dimension:].max(axis=1) > 0.0
            sizes = np.array([len(part[0]) for part in parts])
            ends = np.cumsum(sizes)
            entered, left = (np.array([part[2][i] for part in parts]) for i in (0, -1))
            between = 0.5 * np.linalg.norm(entered[1:] - left[:-1], axis=1)
            more = np.zeros(len(row))
            more[ends - sizes] += [turns[0] * np.linalg.norm(entered[0]), *between]
            more[ends - 1] += [*between, turns[1] * np.linalg.norm(left[-1])]
            backward = np.repeat([backward for _, backward in way], sizes)
            free = np.ones((len(row), 2), dtype=bool)  # from end to end, then from antagonist to candidate
            free[0, 0], free[-1, 1] = turns
            turn.append(np.where(backward[:, None], free[:, ::-1], free))
            rows.append(row)
            bodies_of.append(bodies)
            starts.append(start)
            senses.append(np.where(backward, -1.0, 1.0))
            joints.append(np.repeat([isinstance(piece.links, JointTable) for piece, _ in way], sizes))
            lengths.append(more)
            central.append(all(piece.links.form == "central" and not piece.links.law.TIES for piece, _ in way))
        nothing, masses = np.zeros(0, np.int64), [inverse[bodies[1:-1]] for bodies in bodies_of]
        met = np.bincount(np.concatenate([nothing, *(bodies[1:-1] for bodies in bodies_of)]), minlength=len(held))
        span = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
        ends = np.array([bodies[[0, -1]] for bodies in bodies_of], dtype=np.int64).reshape(-1, 2)
        link = np.concatenate([nothing, *rows])
        between_centres = np.array(central, dtype=bool)
        return cls(
            ends=ends,
            crosses=between_centres & np.array([(met[bodies[1:-1]] > 1).any() for bodies in bodies_of], dtype=bool),
            central=between_centres,
            link=link,
            start=np.concatenate([np.zeros(0), *starts]),
            span=span,
            inner=np.flatnonzero(span[:-1] == span[1:]),
            weight=np.concatenate([np.zeros((0, dimension)), *(own / own.max(axis=1).sum() for own in masses)]),
            sense=np.concatenate([np.zeros(0), *senses]),
            joint=np.concatenate([np.zeros(0, dtype=bool), *joints]),
            more=np.concatenate([np.zeros(0), *lengths]),
            radius_sum=radius_sum[link],
            turns=np.concatenate([np.zeros((0, 2), dtype=bool), *turn]),
            held=inverse_mass[ends] == 0.0,
        )

    def straight(self, normal: np.ndarray) -> np.ndarray:
        """Whether a span between centres is straight, (S,) bool, from the normals of all interactions (m, d)."""
        e = self.sense[:, None] * normal[self.link]
        bend = e[self.inner + 1] - e[self.inner]
        square = np.bincount(self.span[self.inner], (self.weight * bend * bend).sum(axis=1), len(self.ends))
        return self.central & (square < STRAIGHT)

    def let_go(self, guess: np.ndarray, normal: np.ndarray) -> None:
        """Reduce the guess (m, d) of straight spans that cross to the part KEPT."""
        if len(self.ends) and self.crosses.any():
            guess[self.link[(self.crosses & self.straight(normal))[self.span]]] *= KEPT

    def give_way(self, problem: StepProblem) -> None:
        """Let spans at rest that are too short give way: less gap in the problem."""
        if not len(self.ends) or problem.system.deforms:
            return
        data, d = problem.data, problem.dimension
        chord, length, distance, short, gives = self._spanned(problem)
        short = np.where(gives & (short > TOO_SHORT[0]), short, 0.0)
        if short.any():
            part, tied = short[self.span] * length, self.joint
            data.gap[self.link[~tied]] -= part[~tied]
            along = (self.sense * part)[tied, None] * (chord / distance[:, None])[self.span[tied]]
            data.gap[self.link[tied, None] + np.arange(d)] -= along
            problem.prepare()

    def too_short(self, problem: StepProblem) -> tuple[int, int, float, float] | None:
        """Of the span that is too short by the largest part and does not give way: its ends, the length of its links and of
        the bodies between them [m], and the distance of the ends [m]; if there is no such span, None."""
        if not len(self.ends) or problem.system.deforms:
            return None
        _, length, distance, short, gives = self._spanned(problem)
        short[gives] = 0.0
        k = int(np.argmax(short))
        if not short[k] > DRAWN:
            return None
        one, other = self.ends[k].tolist()
        return one, other, float(length[self.span == k].sum()), float(distance[k])

    def _spanned(self, problem: StepProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Vectors from end to end [m], (S, d); lengths of links, with what bodies count to them [m], (K,); distances of the
        ends [m], parts by which spans are too short, and whether a span gives way if it is too short, (S,) each.
        """
        system, data, d = problem.system, problem.data, problem.dimension
        reference, gap = data.reference_gap[self.link], data.gap[self.link]
        length = reference + self.radius_sum + self.more
        vector = system.normal[self.link] * (gap + self.radius_sum)[:, None]
        tied = self.joint
        if not self.central.all():
            vector[tied] = data.gap[self.link[tied, None] + np.arange(d)]
            lever = levers(system, self.link)  # of the candidate, of the antagonist; in a joint they end half-way
            lever[tied] += 0.5 * vector[tied, None] * np.array([1.0, -1.0])[:, None]
            lever[~self.turns[:, ::-1]] = 0.0
            vector += lever[:, 1] - lever[:, 0]
        vector *= self.sense[:, None]
        chord = np.stack([np.bincount(self.span, vector[:, i]) for i in range(d)], axis=1)
        distance = np.sqrt(sum(chord[:, i] ** 2 for i in range(d)))
        short = distance / np.bincount(self.span, length) - 1.0
        moves = ((problem.free_velocity[self.ends] != 0.0) & self.held).any(axis=(1, 2))
        drawn = np.bincount(self.span, self.start - reference > DRAWN * length) > 0.0
        return chord, length, distance, short, ~moves & ~drawn & (short < TOO_SHORT[1])

    def bearing(self, carries: np.ndarray, normal: np.ndarray) -> tuple[int, int] | None:
        """The ends of the first straight span all of whose links are among the interactions that carry (m,), if any."""
        found = self.straight(normal)
        found[self.span[~carries[self.link]]] = False
        return tuple(self.ends[found][0].tolist()) if found.any() else None
