"""Warnings of a run: links that do not keep their length, contacts that sink in, interactions that make energy, and jerks
without rebound.

All can happen although every step is solved: in a time step that is too long links turn by large angles, and the stretch
that remains is pulled back in the next step.

**Jerks.** A rigid link does no work in nature. A body of mass M that stretches out two links of length l round a light body
of mass m turns it round ever faster. It is thrown back with all its energy after the light body has gone through the line,
which takes ``(l/2) m / r``, with r the impulse that stops M. A longer step finds the links straight and takes the energy.
So the number of a jerk is ``h |r_n| W_nn / l``, with ``W_nn`` about 1/m. (If the wire was slack, the law itself takes the
energy.)

Each warning comes once, with its number, the bodies, and a time step that would do. It costs some sums over the links and
the laws of a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.dynamics.energy import Energy
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.dynamics.straight_spans import StraightSpans
from lmgcpy.dynamics.watch import Said
from lmgcpy.dynamics.watch.displacements import rounded_down
from lmgcpy.solve.problems.report import Lock

STRETCH = 0.1
"""Part of its reference length by which a rigid link may be off for :data:`RUNNING` steps before the run warns. A link that
turns by 0.45 rad in a step is off by as much. (The column study, at a tolerance of 1e-2, leaves 5 %.)"""
DRIVEN_OFF = 0.01
"""Part by which a link between bodies that are held or driven along it may be off while it gets worse: no impulse can bring
it back."""
RUNNING = 3
"""Steps in a row. A single blow, as in a wire that is thrown taut, leaves a stretch that the next step pulls back."""
AT_ONCE = 0.25
"""Part of its reference length by which a rigid link may be off in one step. A link that turns by 0.65 rad in a step is.
Light bodies that whip are put back from a tenth on (whipping_links.py), so that no right blow leaves as much. An elastic
link may end longer by as much than its law predicts."""
MADE_BY_CONTACTS = 0.02
"""Part of the energy turned over that a law of contacts may have made before the run warns, if it promises to dissipate."""
MADE_BY_LINKS = 0.05
"""Limit for a law of rigid links, which give back the stretch of turning. (Wires that are jerked make up to 2 %, at eight
octaves of the time step and mass ratios of 1 to 1e7. A run that goes wrong makes 100 % and more.)"""
MADE_BY_POTENTIALS = 0.1
"""Limit for a law that stores energy: its links have the potential of linear springs and stretch as they turn."""
MADE_BY_ALL = 0.25
"""Limit for all laws together with the imbalance of light bodies, if the run has warned of no law."""
SUNK = 0.1
"""Part of the smaller radius by which a rigid contact may overlap, beyond the largest overlap of the start, before the run
warns. (A relaxation at a tolerance of 1e-2 leaves up to 0.035.)"""
START = 10.0
"""Near rest the energy turned over is less than the error of a step. So the run warns only if interactions have made more
than loads give to bodies at rest in this number of steps."""
ERRORS = 1e-3
"""It does not warn either if a law has made less than this part of the energy that the normal impulses of a step would give
to bodies at rest, one by one. (A taut wire without slack on a drum: 3e-6, which the drum makes and the wire takes by errors
of the velocities.)"""
TAKEN = 0.05
"""Part of the energy turned over that rigid links may take in a step that does not resolve how they turn before the run
warns. (Double pendulums with a light elbow: 0.2 to 0.67 if the first straightening is lost.)"""
FIRST = 3.0
"""The run does not warn if rigid links took less than loads give to bodies at rest in this number of steps."""
JERK = 0.1
"""``h |r_n| W_nn / l`` of a jerk that a step resolves. (Pendulums and wires lose up to 0.02 of their energy there.)"""
AT_LENGTH = 1e-9
"""A wire is slack if it is shorter by more than this part of its length."""
RESOLVED = 4.0
"""Beads zigzag across their wire if ``s = 4 h^2 T/(m l)`` is larger, unless there is geometric stiffness."""


class Watch:
    """Looks at the links and the energy after each step of a simulation."""

    def __init__(self, model: Model, said: Said):
        lengths = [np.zeros(0), *(chain.radius_sum for chain in model.chains)]
        self._radius_sum = np.concatenate(lengths)
        self._rigid, self._pull = (
            np.concatenate(
                [np.zeros(0, bool), *(np.full(chain.link_count, trait in chain.law.TRAITS) for chain in model.chains)]
            )
            for trait in ("rigid", "pull")
        )
        self.follow(model)
        self._most_made: dict[str, float] = {}
        for law in [row.law for row in model.rows] + [table.law for table in model.links]:
            contact = law.APPLIES_TO == "contact"
            most = MADE_BY_POTENTIALS if law.energy is not None else MADE_BY_CONTACTS if contact else MADE_BY_LINKS
            self._most_made[law.NAME] = most
        self._said = said
        self._stretched = 0
        self.stretch = 0.0
        """Largest part of its reference length by which a rigid link was off at the detection of the last step: a wire too
        long, a rod either way."""

    def follow(self, model: Model) -> None:
        """Take what changed between two steps."""
        self._drawn, self._drawn_until = model.drawn, model.drawn_until
        self.overlap_of_start: float | None = None
        """Largest overlap of the first step that is looked at, in parts of the smaller radius; None before it."""

    def links(self, problem: StepProblem, s: np.ndarray) -> Iterator[str]:
        """Sentences on the links of a step; ``s``: ``4 h^2 T/(m l)`` of the links, (L,), empty with geometric stiffness."""
        count = len(self._rigid)
        if not count:
            return
        data, system, h = problem.data, problem.system, problem.data.time_step

        def between(i: int) -> str:
            bodies = f"bodies {system.candidate[i]} and {system.antagonist[i]}"
            return f"In the step from t = {data.time:g} s the link between {bodies}"

        length = data.reference_gap[:count] + self._radius_sum
        off_by = (data.gap[:count] - data.reference_gap[:count]) / length
        excess = np.where(self._rigid, np.where(self._pull, off_by, np.abs(off_by)), 0.0)
        i = int(np.argmax(excess))
        self.stretch = max(float(excess[i]), 0.0)
        if self.stretch > DRIVEN_OFF:
            stuck = system.delassus[:count, 0] == 0.0
            driven = np.where(stuck & (off_by * data.after[:count, 0] > 0.0), excess, 0.0)
            k = int(np.argmax(driven))
            if driven[k] > DRIVEN_OFF and self._said.first("driven"):
                yield (
                    f"{between(k)} is off its reference length of {length[k]:.3g} m by {100.0 * driven[k]:.3g} %: along it "
                    "both are driven or held, so that no impulse keeps its length. End the drive, drive one of them by a "
                    "force, or take an elastic law. (Said once.)"
                )
            excess[stuck] = 0.0
            i = int(np.argmax(excess))
        off = excess[i] > STRETCH and data.time >= self._drawn_until and data.time != self._drawn
        self._stretched = self._stretched + 1 if off else 0
        at_once = off and excess[i] > AT_ONCE and data.time > 0.0
        if self.stretch > STRETCH and data.time == self._drawn and self._said.first("drawn"):
            way = abs(float(data.gap[i] - data.reference_gap[i]))
            yield (
                f"{between(i)} was given a reference length that is off by {way:.3g} m, {100.0 * self.stretch:.3g} % of "
                f"it: a blow, in which its ends meet it at {way / h:.3g} m/s. Draw it in or let it out by less in a step. "
                "(Said once.)"
            )
        if (self._stretched >= RUNNING or at_once) and self._said.first("stretch"):
            yield (
                f"{between(i)} is off its reference length of {length[i]:.3g} m by {100.0 * excess[i]:.3g} %: it turns "
                f"by too much in a step, if steps are solved. A time step of "
                f"{rounded_down(h * math.sqrt(0.5 * STRETCH / excess[i]))} s would do. (Said once.)"
            )
        if "stretch" not in self._said and not self._rigid.all():
            turned = self._turned(problem)
            i = int(np.argmax(turned))
            if turned[i] > AT_ONCE and self._said.first("stretch"):
                yield (
                    f"{between(i)}, of {length[i]:.3g} m, turns by too much in a step: it ends longer than its law "
                    f"predicts by {100.0 * turned[i]:.3g} %. A time step of "
                    f"{rounded_down(h * math.sqrt(0.5 * STRETCH / turned[i]))} s "
                    "would do. (Said once.)"
                )
        i = int(np.argmax(s)) if len(s) else 0
        if len(s) and s[i] > RESOLVED and self._said.first("zigzag"):
            yield (
                f"{between(i)} has more tension than the step resolves across its wire: 4 h^2 T/(m l) is {s[i]:.3g}, and "
                f"beads zigzag from {RESOLVED:g} on. A time step of "
                f"{rounded_down(0.9 * h * math.sqrt(RESOLVED / s[i]))} s would do, or geometric_stiffness=True. "
                "(Said once.)"
            )

    def spans(self, spans: StraightSpans, problem: StepProblem) -> Iterator[str]:
        """A sentence on links that are too short for what they span."""
        if "driven" in self._said or "lock" in self._said:
            return
        found = spans.too_short(problem)
        if found is None or not self._said.first("driven"):
            return
        one, other, length, distance = found
        yield (
            f"In the step from t = {problem.data.time:g} s the links from body {one} to body {other} are {length:.6g} m "
            f"long, with the bodies between them, and these two, driven or held, are {distance:.6g} m apart: no motion "
            "gives the links their length. Let them out, end the drive, drive one of the two by a force, or take an "
            "elastic law. (Said once.)"
        )

    def _turned(self, problem: StepProblem) -> np.ndarray:
        """Part by which elastic links end longer than their laws predict, as they turn, (L,); of slack wires and of rigid
        links, whose length is looked at as it is, zero."""
        count, data, d = len(self._rigid), problem.data, problem.dimension
        move = data.time_step * data.after[:count, :d]
        predicted = data.gap[:count] + self._radius_sum + move[:, 0]
        ends = np.sqrt(predicted * predicted + (move[:, 1:] * move[:, 1:]).sum(axis=1))
        reference = data.reference_gap[:count] + self._radius_sum
        aim = np.where(self._pull, np.maximum(predicted, reference), predicted)
        return np.where(self._rigid, 0.0, (ends - aim) / reference)

    def overlaps(self, problem: StepProblem) -> Iterator[str]:
        """A sentence on rigid contacts that have sunk in."""
        if "overlap" in self._said:
            return
        system, data, deepest, i = problem.system, problem.data, 0.0, -1
        for law, start, stop in problem.spans_of_laws:
            if law.APPLIES_TO == "contact" and "rigid" in law.TRAITS:
                deepest, i = deeper(start, stop, data.gap, system.scale, data.time_step, deepest, i)
        if self.overlap_of_start is None:
            self.overlap_of_start = deepest
        if deepest <= self.overlap_of_start + SUNK or not self._said.first("overlap"):
            return
        yield (
            f"In the step from t = {data.time:g} s bodies {system.candidate[i]} and {system.antagonist[i]} overlap by "
            f"{-data.gap[i]:.3g} m, {100.0 * deepest:.3g} % of the smaller radius: a step saw them late, or what "
            f"the tolerance left has added up. A time step of {rounded_down(0.5 * data.time_step)} s, or a tenth of the "
            "solver's tolerance or slip, would leave less. (Said once.)"
        )

    def jerk(self, problem: StepProblem, gap: np.ndarray, energy: Energy, thrust: Callable[[], float]) -> Iterator[str]:
        """A sentence on the energy that rigid links took in a step which does not resolve how they turn.

        ``problem``: the step as it was solved last; ``gap``: of the detection [m], (m,); ``thrust``: as below.
        """
        if not min(energy.interactions.values(), default=0.0) < -TAKEN * energy.turned or "jerk" in self._said:
            return
        data, system, count, h = problem.data, problem.system, len(self._rigid), problem.data.time_step
        if not self._rigid.any() or data.time < self._drawn_until or data.time in (0.0, self._drawn):
            return  # what velocities at the start lose to links is no matter of the step
        if "driven" in self._said:
            return  # nor is what links do that cannot have their length
        length = data.reference_gap[:count] + self._radius_sum
        turning = h * np.abs(system.impulse[:count, 0]) * system.delassus[:count, 0] / length
        slack = self._pull & (gap[:count] < data.reference_gap[:count] - AT_LENGTH * length)
        work = 0.5 * (system.impulse[:count] * (data.before[:count] + data.after[:count])).sum(axis=1)
        work = np.where(self._rigid & ~slack & (turning > JERK), work, 0.0)
        taken, i = -float(work.sum()), int(np.argmin(work))
        if taken <= max(TAKEN * energy.turned, FIRST**2 * thrust()) or not self._said.first("jerk"):
            return
        yield (
            f"In the step from t = {data.time:g} s rigid links that were not slack took {taken:.3g} J, "
            f"{100.0 * taken / energy.turned:.3g} % of all energy turned over, most the link between bodies "
            f"{system.candidate[i]} and {system.antagonist[i]}: a jerk without rebound. Light bodies between heavy ones "
            "would hand it back, but the step does not resolve how they turn their links. A time step of "
            f"{rounded_down(h * JERK / turning[work < 0.0].max())} s would do; of a thread that is thrown taut no rebound "
            "may be what is meant. (Said once.)"
        )

    def energy(
        self, energy: Energy, thrust: Callable[[], float], shock: Callable[[], float], time: float, time_step: float
    ) -> Iterator[str]:
        """A sentence on each law that promises to make no energy and has made some; ``thrust`` computes the energy that the
        loads of a step alone would give to bodies at rest [J]; ``shock``, the energy that its normal impulses would give
        them, one by one. If bodies are tensioned against each other, works below a part of it are errors."""
        turned = energy.turned
        makers = [
            (f"interactions of law '{name}'", made)
            for name, made in energy.made_by_law.items()
            if made > self._most_made[name] * turned
        ]
        if energy.made > MADE_BY_ALL * turned and not self._said.any_of("interactions of law"):
            makers.append(("interactions and the imbalance of light bodies", energy.made))
        for maker, made in makers:
            if maker in self._said:
                continue
            if made <= max(START**2 * thrust(), ERRORS * shock()) or not self._said.first(maker):
                continue
            yield (
                f"Until t = {time:g} s {maker} have made {made:.3g} J out of nothing, "
                f"{100.0 * made / turned:.3g} % of all energy turned over. See whether a time step of "
                f"{rounded_down(0.5 * time_step)} s, or a solver with a smaller tolerance, does the same. "
                "(Said once of each law.)"
            )

    def lock(self, lock: Lock, time: float) -> Iterator[str]:
        """A sentence on the first step that has no solution; ``time``: of its end [s]."""
        if self._said.first("lock"):
            yield f"The step to t = {time:g} s has no solution: {lock}. (Said once.)"


@kernel
def deeper(start, stop, gap, scale, time_step, deepest, row):
    """The deepest overlap of some contacts, in parts of the smaller radius, and its row, if it is more than ``deepest``;
    else this and ``row``. ``scale``: time step over the smaller radius [s/m]."""
    for i in range(start, stop):
        overlap = -gap[i] * scale[i] / time_step
        if overlap > deepest:
            deepest = overlap
            row = i
    return deepest, row
