"""The energy balance of a step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.detection_tables import ChainTable
from lmgcpy.dynamics.faults import check_energy
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem, ask


class Flight(NamedTuple):
    """How bodies would fly in a step without impulses."""

    force: np.ndarray
    """External forces at the middle of the step (n, k)."""
    inertial: np.ndarray | None
    """Forces of inertia in a periodic cell (n, k), None without a cell."""
    mobility: np.ndarray
    """Velocity that an impulse gives [1/kg], (n, k): the inverse masses, less with drag."""
    free_velocity: np.ndarray
    """Velocities without impulses (n, k), with the imposed velocities at the end of the step."""


@dataclass
class Energy:
    """Energies and works in [J] (per metre of depth in 2D).

    At every step ``kinetic - kinetic before = loads + drives + sum of interactions + drag + unbalanced`` holds to
    round-off. Each term is a work at the mean velocity of the step: ``loads`` the work of gravity, imposed forces, and
    stresses imposed on a cell; ``drives`` the work of whatever holds the driven components, with its part for the inertia
    of bodies in the mean flow of a cell; ``interactions`` the work of the impulses by name of law. ``kinetic`` is the
    energy of the free components. ``total_loads``, ``total_drives``, ``total_interactions`` and ``total_dissipated`` are
    sums over the run.
    """

    kinetic: float = 0.0
    loads: float = 0.0
    drives: float = 0.0
    interactions: dict[str, float] = field(default_factory=dict)
    stored: dict[str, float] = field(default_factory=dict)
    """Energy in elastic links at the predicted gaps, by law; at each step its change and the work of the links'
    impulses sum to the energy that the scheme damps, plus a term from the links' second-order stretch."""
    dissipated: dict[str, float] = field(default_factory=dict)
    """Energy that laws report as dissipated in this step, by law. The work of their impulses and the change of their stored
    energy may be more: a contact may report its friction but not its shocks."""
    drag: float = 0.0
    """Work of the drag of a medium."""
    unbalanced: float = 0.0
    """Work of the impulses by which light bodies between heavy ones are left out of balance, within the solver's bounds."""
    defect: float = 0.0
    """Error of the identity in this step."""
    total_loads: float = 0.0
    total_drives: float = 0.0
    total_interactions: dict[str, float] = field(default_factory=dict)
    total_dissipated: dict[str, float] = field(default_factory=dict)
    by_hand: float = 0.0
    """Energy that was given to chains in this step by setting their reference gaps or laws, or by a function of time for
    their gaps: the work of a winch."""
    total_by_hand: float = 0.0
    """Sum of ``by_hand`` over the run."""
    made: float = 0.0
    """Energy that interactions have made: the work and the stored energy of all laws that promise to make none, less the
    energy given ``by_hand``, less the smallest value of this sum so far. Not counted while links relax to their
    reference."""

    made_by_law: dict[str, float] = field(default_factory=dict)
    """``made`` for each law alone: one law may make energy that another takes. Work that contacts only transmit is not
    counted: see ``transmitted``."""

    @property
    def mechanical(self) -> float:
        """Kinetic and stored energy."""
        return self.kinetic + sum(self.stored.values())

    def __repr__(self) -> str:
        work = {"loads": self.loads, "drives": self.drives, "interactions": sum(self.interactions.values())}
        works = ", ".join(f"{name} {value + 0.0:.4g} J" for name, value in work.items())  # + 0.0: no "-0"
        stored = sum(self.stored.values())
        return f"<Energy: kinetic {self.kinetic:.4g} J, stored {stored:.4g} J; works of the last step: {works}>"

    @property
    def turned(self) -> float:
        """The largest of mechanical energy and the works of loads, drives and interactions: ``made`` is compared with
        it."""
        work = abs(sum(self.total_interactions.values()))
        return max(self.mechanical, abs(self.total_loads), abs(self.total_drives), work)

    def turn(self, first: float, last: float) -> None:
        """Enter the works of what drives a part of the spins of bodies that turn freely in space, at the beginning and at
        the end of a step [J]; the kinetic energy of ``advance`` contains the first."""
        if first != 0.0 or last != 0.0:
            self.kinetic += last
            self.drives += first + last
            self.total_drives += first + last

    def advance(
        self,
        problem: StepProblem,
        model: Model,
        flight: Flight,
        before: np.ndarray,
        pushed: np.ndarray | None,
        dissipated: dict[str, float],
        given: Iterable[tuple[str, float]] = (),
        held: Iterable[tuple[str, float]] = (),
    ) -> None:
        """Enter a step at its end: its flight without impulses, and the velocities of the bodies before it (n, k).

        ``dissipated``: see :func:`dissipated_by_law`. ``pushed``: impulses that moved bodies without giving them velocity
        (m, d), None for none; their work is the work against the loads on the way. ``given``: see :func:`given_by_hand`;
        ``held``: works of moments by name of law, see ``LeverStiffness.works``. Raises FloatingPointError, and enters
        nothing, if a stored energy is not finite.
        """
        data, system, after = problem.data, problem.system, problem.system.velocity
        against = None if pushed is None else pushed * problem.relative_velocities(fallen(problem, flight, before))
        works: dict[str, float] = {}
        stored: dict[str, float] = {}
        for law, start, stop in problem.spans_of_laws:
            work = work_of_impulses(start, stop, system.impulse, data.before, data.after)
            if against is not None:
                work -= float(against[start:stop].sum())
            works[law.NAME] = works.get(law.NAME, 0.0) + work
        for group, kernels in zip(problem.by_law, problem.kernels, strict=True):
            if kernels.energy is not None:
                name = group.law.NAME
                arguments = group.start, group.stop, data, group.parameters.ravel()
                energy = ask(group, kernels.energy, "energy", problem.system, data, arguments)
                check_energy(problem, group, energy)
                stored[name] = stored.get(name, 0.0) + energy
        moments = dict(held)
        if moments:
            works = added(works, moments)
        gain, self.kinetic, power, drives = terms_of_bodies(model.free_mass, flight.force, before, after)
        # the energy stored before the first step is not known: for laws that store, the first step does not count
        counted = [name for name in works if name in model.passive and (name not in stored or name in self.stored)]
        change = {name: works[name] + stored.get(name, 0.0) - self.stored.get(name, 0.0) for name in counted}
        given = list(given)
        for name, energy in given:
            if name in change:
                change[name] -= energy
        self.by_hand = sum((energy for _, energy in given), 0.0)
        self.total_by_hand += self.by_hand
        self.unbalanced = work_of_imbalance(problem, before) if len(problem.light.body) else 0.0
        if data.time < model.drawn_until:
            self.made, self.made_by_law = 0.0, {}
        else:
            self.made = max(0.0, self.made + sum(change.values()) + self.unbalanced)
            through, made = transmitted(problem, change) if len(works) > 1 else {}, dict(self.made_by_law)
            for name, work in change.items():
                made[name] = max(0.0, made.get(name, 0.0) + work - through.get(name, 0.0))
            self.made_by_law = made
        self.loads = data.time_step * power
        if against is not None:
            self.loads += float(against.sum())
        self.drives = -work_on_driven(problem, model, before) if drives else 0.0
        if flight.inertial is not None:
            self.drives += data.time_step * float((flight.inertial * (0.5 * (before + after))).sum())
        self.interactions = works
        self.stored = stored
        self.dissipated = dissipated
        if model.drag is not None:
            total = flight.force if flight.inertial is None else flight.force + flight.inertial
            # the mobility of the step contains the moments as well as the drag
            self.drag = work_of_drag(problem, model, data.time_step * total, before) - sum(moments.values())
        self.defect = gain - (self.loads + self.drives + sum(works.values()) + self.drag + self.unbalanced)
        self.total_loads += self.loads
        self.total_drives += self.drives
        # new dictionaries, as a step that fails goes back to the old ones
        self.total_interactions = added(self.total_interactions, works)
        if dissipated:
            self.total_dissipated = added(self.total_dissipated, dissipated)


def added(totals: dict[str, float], more: dict[str, float]) -> dict[str, float]:
    """Sums by name."""
    sums = dict(totals)
    for name, value in more.items():
        sums[name] = sums.get(name, 0.0) + value
    return sums


def transmitted(problem: StepProblem, change: dict[str, float]) -> dict[str, float]:
    """Works [J] that rigid contacts only transmit, for laws that made energy in a step; ``change``: by law, the energy
    that it made [J].

    A contact that opens bears nothing. If ``u_n^- > 0`` and ``r_n > 0``, other impulses closed it within the step before it
    pressed, and it made nothing. The work at the mean velocity is ``r_n (u_n^- + u_n^+)/2``; its part ``r_n u_n^-/2`` is
    work of the others, which have as much less. (A heavy ball falls on a light bead of a taut wire, the bead runs away from
    it, and both stop: the wire takes the energy of the ball and this part, which the contact seems to make.) A contact that
    takes back overlap presses by itself and transmits nothing. All contacts of a body together transmit no more than
    interactions of other laws took there in the same step, and a law no more than these took and than it made. A law that
    is alone transmits nothing.
    """
    found: dict[str, float] = {}
    laws = {group.law.NAME: group.law for group in problem.by_law}
    data, system, free = problem.data, problem.system, problem.inverse_mass.max(axis=1) > 0.0
    for name, law in laws.items():
        if law.APPLIES_TO != "contact" or not {"rigid", "push"} <= law.TRAITS or change.get(name, 0.0) <= 0.0:
            continue
        own = np.zeros(len(system.impulse), dtype=bool)
        for group in problem.by_law:
            own[group.start : group.stop] = name == group.law.NAME
        presses = own & ~(data.gap < data.reference_gap)
        through = np.where(presses, 0.5 * system.impulse[:, 0] * np.fmax(data.before[:, 0], 0.0), 0.0)
        if not through.any():
            continue
        work = 0.5 * (system.impulse * (data.before + data.after)).sum(axis=1)
        taken = np.where(own, 0.0, np.fmax(-work, 0.0))
        bodies = np.concatenate([system.candidate, system.antagonist])
        of_body, contacts = (
            np.bincount(bodies, np.tile(weights, 2), minlength=len(free)) for weights in (taken, through > 0.0)
        )
        share = np.where(free, of_body / np.maximum(contacts, 1.0), 0.0)
        most = share[system.candidate] + share[system.antagonist]
        found[name] = min(float(np.minimum(through, most).sum()), float(taken.sum()), change[name])
    return found


def dissipated_by_law(problem: StepProblem) -> dict[str, float]:
    """Energies [J] that laws report as dissipated in a step, by law; asked before the laws commit.

    Raises FloatingPointError if one is not finite.
    """
    found: dict[str, float] = {}
    data, impulse = problem.data, problem.system.impulse
    for group, kernels in zip(problem.by_law, problem.kernels, strict=True):
        if kernels.dissipation is None:
            continue
        mean = 0.5 * (data.before + data.after)
        arguments = group.start, group.stop, data, mean, impulse, group.parameters.ravel()
        energy = ask(group, kernels.dissipation, "dissipation", problem.system, data, arguments)
        if not math.isfinite(energy):
            raise FloatingPointError(
                f"In the step from t = {data.time:g} s dissipation of law '{group.law.NAME}' returned an energy that is "
                "not finite."
            )
        found[group.law.NAME] = found.get(group.law.NAME, 0.0) + energy
    return found


def given_by_hand(problem: StepProblem, earlier: list[ChainTable], predicted: np.ndarray) -> Iterator[tuple[str, float]]:
    """Energies [J], by law, that chains got because they changed since the step before, in which they were ``earlier``.

    The stored energy changes by ``E'(g) - E(g)`` at the gaps ``predicted`` by the step before [m], (L,), or at the detected
    gaps if no prediction is known. A rigid link stores nothing: while it is drawn, it gets the work of its impulse.
    """
    data = problem.data
    for group, kernels, before in zip(problem.by_law, problem.kernels, earlier, strict=False):  # chains come first
        assert group.chain is not None
        if before is group.chain:
            continue
        part = slice(group.start, group.stop)
        reference = before.reference_gap_at(data.time)
        if kernels.energy is None:
            if "rigid" in group.law.TRAITS:
                mean = 0.5 * (data.before[part, 0] + data.after[part, 0])
                drawn = data.reference_gap[part] != reference
                yield group.law.NAME, float(problem.system.impulse[part, 0].dot(np.where(drawn, mean, 0.0)))
            continue
        then = data._replace(gap=data.gap.copy(), reference_gap=data.reference_gap.copy(), after=np.zeros_like(data.after))
        then.gap[part] = np.where(np.isnan(predicted[part]), then.gap[part], predicted[part])
        stored = []
        for table, gaps in ((group.chain, data.reference_gap[part]), (before, reference)):
            then.reference_gap[part] = gaps
            arguments = group.start, group.stop, then, table.parameters.ravel()
            stored.append(float(ask(group, kernels.energy, "energy", problem.system, then, arguments)))
        yield group.law.NAME, stored[0] - stored[1]


def work_of_imbalance(problem: StepProblem, before: np.ndarray) -> float:
    """Work [J] of the impulses ``(M - m) (v_c - v)`` on light bodies, see :mod:`lmgcpy.solve.sweeps.light_bodies`."""
    light = problem.light
    after = problem.system.velocity[light.body]
    impulse = light.mass * (1.0 / light.share[:, None] - 1.0) * (light.centre - after)
    return 0.5 * float((impulse * (before[light.body] + after)).sum())


def work_of_drag(problem: StepProblem, model: Model, given: np.ndarray, before: np.ndarray) -> float:
    """Work [J] of the impulses ``M (v+ - v) - h F - (v+ - v_free) / mobility`` at the mean velocity: bodies got these
    besides the impulses of the forces, ``given`` as h F (n, k), and of the interactions."""
    after, free = problem.system.velocity, model.inverse_mass > 0.0
    answered = (after - problem.free_velocity) / np.where(free, problem.inverse_mass, 1.0)
    impulse = np.where(free, model.free_mass * (after - before) - given - answered, 0.0)
    return 0.5 * float((impulse * (before + after)).sum())


def work_on_driven(problem: StepProblem, model: Model, before: np.ndarray) -> float:
    """Work [J] of the impulses on driven components at their mean velocity, which their drives must bring up."""
    driven = model.driven
    mean = 0.5 * (before.take(driven) + problem.system.velocity.take(driven))
    return float(problem.momentum().take(driven).dot(mean))


def fallen(problem: StepProblem, flight: Flight, before: np.ndarray) -> np.ndarray:
    """Velocities that the loads of a step alone give to the free components (n, k), with the mobilities of the step, but
    without the moments that hold the levers of links."""
    stiffened = np.divide(problem.inverse_mass, flight.mobility, out=np.ones_like(before), where=flight.mobility > 0.0)
    return np.where(problem.system.inverse_mass > 0.0, stiffened * (flight.free_velocity - before), 0.0)


@kernel
def work_of_impulses(start, stop, impulse, before, after):
    """Work [J] of the impulses of some interactions at the means of their relative velocities (m, d)."""
    total = 0.0
    for i in range(start, stop):
        work = 0.0
        for k in range(impulse.shape[1]):
            work += impulse[i, k] * (0.5 * (before[i, k] + after[i, k]))
        total += work
    return total


@kernel
def terms_of_bodies(free_mass, force, before, after):
    """Gain of kinetic energy [J], kinetic energy at the end [J], power of the forces at the mean velocity [W], and whether
    a driven component, whose ``free_mass`` is zero, has a mean velocity; (n, k) each."""
    gain = 0.0
    twice = 0.0
    power = 0.0
    moves = False
    for b in range(free_mass.shape[0]):
        of_body = 0.0
        at_end = 0.0
        of_force = 0.0
        for k in range(free_mass.shape[1]):
            mean = 0.5 * (before[b, k] + after[b, k])
            # not from two large numbers that nearly cancel
            of_body += free_mass[b, k] * (after[b, k] - before[b, k]) * mean
            at_end += free_mass[b, k] * after[b, k] * after[b, k]
            of_force += force[b, k] * mean
            moves = moves or (free_mass[b, k] == 0.0 and mean != 0.0)
        gain += of_body
        twice += at_end
        power += of_force
    return gain, 0.5 * twice, power, moves


def kinetic_energy(free_mass: np.ndarray, velocities: np.ndarray) -> float:
    """``v . M v / 2`` [J] of the free components, (n, k) both."""
    return 0.5 * float((free_mass * velocities * velocities).sum(axis=1).sum())
