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
without bound. Such a span gives way: its links share out ``e``, the distance of the ends less the sum of the lengths, by
their lengths, and laws get their gaps less that. Then a blow has the momentum that it stops. If a link has been drawn
shorter than it began, the span is too short because of that, and the run says that it has no solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.detection_tables import ChainTable
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
"""Part of the length of a span by which links may be shorter than they began and are not drawn."""


@dataclass(frozen=True)
class StraightSpans:
    """The spans of the rigid chains of a model, S of them with J inner bodies in all; none in most scenes."""

    ends: np.ndarray
    """The two held bodies of each span, (S, 2)."""
    crosses: np.ndarray
    """Whether one of its inner bodies is in another span too, (S,) bool."""
    link: np.ndarray
    """Rows of the links, one span after another, (S + J,), as the detector orders them."""
    span: np.ndarray
    """Span of each of these links, (S + J,)."""
    inner: np.ndarray
    """Places in ``link`` of the links before the inner bodies, (J,); the links after the bodies come next."""
    start: np.ndarray
    """Gaps with which these links began [m], (S + J,)."""
    weight: np.ndarray
    """Inverse masses of the inner bodies by component, divided by the sum of the largest ones over the span, (J, d)."""

    @classmethod
    def of(cls, chains: list[ChainTable], inverse_mass: np.ndarray, dimension: int) -> StraightSpans:
        """Find the spans of a model; ``inverse_mass`` by component, (n, k)."""
        inverse = inverse_mass[:, :dimension]
        held = inverse.max(axis=1, initial=0.0) == 0.0
        bodies_of, links_of, gaps_of, row = [], [], [], 0
        for chain in chains:
            count, bodies = chain.link_count, chain.bodies
            closed = bodies[0] == bodies[-1]
            around = bodies[:-1] if closed else bodies
            at = np.flatnonzero(held[around])
            if chain.points is not None:  # a point off the centre also moves if its body turns
                turns = chain.points.turns[: len(around)] & (inverse_mass[around].max(axis=1) > 0.0)
                at = np.flatnonzero(held[around] & ~turns)
            if closed:  # the last span goes on through the first body
                at = np.append(at, at[:1] + count)
            for first, last in zip(at[:-1].tolist(), at[1:].tolist(), strict=True):
                if "rigid" in chain.law.TRAITS and last > first + 1:
                    bodies_of.append(around[np.arange(first, last + 1) % len(around)])
                    links = np.arange(first, last) % count
                    links_of.append(row + links)
                    gaps_of.append(chain.start_gap[links])
            row += count
        nothing, masses = np.zeros(0, np.int64), [inverse[bodies[1:-1]] for bodies in bodies_of]
        met = np.bincount(np.concatenate([nothing, *(bodies[1:-1] for bodies in bodies_of)]), minlength=len(held))
        span = np.repeat(np.arange(len(links_of)), [len(links) for links in links_of])
        return cls(
            ends=np.array([bodies[[0, -1]] for bodies in bodies_of], dtype=np.int64).reshape(-1, 2),
            crosses=np.array([(met[bodies[1:-1]] > 1).any() for bodies in bodies_of], dtype=bool),
            link=np.concatenate([nothing, *links_of]),
            start=np.concatenate([np.zeros(0), *gaps_of]),
            span=span,
            inner=np.flatnonzero(span[:-1] == span[1:]),
            weight=np.concatenate([np.zeros((0, dimension)), *(own / own.max(axis=1).sum() for own in masses)]),
        )

    def straight(self, normal: np.ndarray) -> np.ndarray:
        """Whether a span is straight, (S,) bool, from the normals of all interactions (m, d)."""
        bend = normal[self.link[self.inner + 1]] - normal[self.link[self.inner]]
        square = np.bincount(self.span[self.inner], (self.weight * bend * bend).sum(axis=1), len(self.ends))
        return square < STRAIGHT

    def let_go(self, guess: np.ndarray, normal: np.ndarray) -> None:
        """Reduce the guess (m, d) of straight spans that cross to the part KEPT."""
        if self.crosses.any():
            guess[self.link[(self.crosses & self.straight(normal))[self.span]]] *= KEPT

    def give_way(self, problem: StepProblem, radius_sum: np.ndarray) -> None:
        """Let spans at rest that are too short give way: less gap in the problem; ``radius_sum`` of its links (L,)."""
        system, data, d = problem.system, problem.data, problem.dimension
        if not len(self.ends) or system.deforms:
            return
        length = data.reference_gap[self.link] + radius_sum[self.link]
        arrow = system.normal[self.link] * (data.gap[self.link] + radius_sum[self.link])[:, None]
        chord = np.sqrt(sum(np.bincount(self.span, arrow[:, i]) ** 2 for i in range(d)))
        short = chord / np.bincount(self.span, length) - 1.0
        least, most = TOO_SHORT
        moves = problem.free_velocity[self.ends].any(axis=(1, 2))
        drawn = np.bincount(self.span, self.start - data.reference_gap[self.link] > DRAWN * length) > 0.0
        short = np.where((short > least) & (short < most) & ~moves & ~drawn, short, 0.0)
        if short.any():
            data.gap[self.link] -= short[self.span] * length
            problem.prepare()

    def bearing(self, carries: np.ndarray, normal: np.ndarray) -> tuple[int, int] | None:
        """The ends of the first straight span all of whose links are among the interactions that carry (m,), if any."""
        found = self.straight(normal)
        found[self.span[~carries[self.link]]] = False
        return tuple(self.ends[found][0].tolist()) if found.any() else None
