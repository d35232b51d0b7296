"""One interaction under a law: the arguments of the law's functions, step by step, and their answers.

The functions are called in plain Python; every answer is checked before it is used.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.errors import shown, told
from lmgcpy.laws import Law
from lmgcpy.laws.pair import Pair, as_asked, asks_for_pair, pair_of
from lmgcpy.testing.units import Dimensions, dimensions

Numbers = tuple[float, ...]
Matrix = tuple[Numbers, ...]

LENGTH, VELOCITY, IMPULSE, ENERGY = dimensions("m"), dimensions("m/s"), dimensions("N s"), dimensions("J")
INVERSE_MASS, TIME = dimensions("1/kg"), dimensions("s")


class Nonconformance(AssertionError):
    """A law breaks a property. The message gives the name of the property, the law, the finding and the input."""

    def __init__(self, name: str, message: str, law: Law | None = None, given: str = ""):
        self.property, self.message, self.law, self.given = name, message, law, given
        of = f" of {law!r} (law '{law.NAME}')" if law is not None else ""
        super().__init__(f"{name}{of}: {message}{given and f'{chr(10)}{given}'}")


def ask(law: Law, function: str, *arguments: Any) -> Any:
    """The answer of a function of the law; Nonconformance if it raises."""
    try:
        return getattr(law, function)(*arguments)
    except Exception as error:
        raise Nonconformance("finite", f"{function} raised {told(error)}, expected numbers.") from error


def numbers(law: Law, function: str, count: int, why: str, *arguments: Any, infinite: bool = False) -> Numbers:
    """The tuple of ``count`` finite numbers that a function of the law returns; ``infinite`` allows infinite numbers."""
    answer = ask(law, function, *arguments)
    if not isinstance(answer, tuple) or len(answer) != count:
        raise Nonconformance("interface", f"{function} returned {shown(answer)}, expected a tuple of {count}, {why}.")
    return tuple(_number(function, value, infinite) for value in answer)


def _rows_of_numbers(law: Law, function: str, count: int, *arguments: Any) -> Matrix:
    """The square matrix, a tuple of rows, that a function of the law returns."""
    answer = ask(law, function, *arguments)
    if not isinstance(answer, tuple) or [len(row) if isinstance(row, tuple) else -1 for row in answer] != [count] * count:
        raise Nonconformance(
            "interface", f"{function} returned {shown(answer)}, expected a tuple of {count} tuples of {count} numbers."
        )
    return tuple(tuple(_number(function, value, False) for value in row) for row in answer)


def number(law: Law, function: str, *arguments: Any) -> float:
    """The finite number that a function of the law returns."""
    return _number(function, ask(law, function, *arguments), False)


def _number(function: str, value: Any, infinite: bool) -> float:
    try:
        result = float(value)
    except (TypeError, ValueError) as error:
        raise Nonconformance("interface", f"{function} returned {shown(value)} where a number was expected.") from error
    if math.isnan(result) or (math.isinf(result) and not infinite):
        raise Nonconformance("finite", f"{function} returned {result}, expected a finite number.")
    return result


@dataclass(frozen=True)
class CaseStep:
    """Data of one time step of an interaction, which is solved alone."""

    gap: float
    """Gap at the detection configuration [m]."""
    before: Numbers
    """Relative velocity at the start of the step [m/s]."""
    W: Matrix
    """Local block of the Delassus operator [1/kg]."""
    q: Numbers
    """Relative velocity at the end of the step without impulse [m/s]."""
    time: float = 0.0
    """Time at the start of the step [s]."""


@dataclass(frozen=True)
class LawCase:
    """An interaction from its birth to its last step, which the properties check."""

    law: Law
    time_step: float
    reference_gap: float
    reference_length: float
    birth: float
    """Time at which the interaction begins [s]."""
    steps: tuple[CaseStep, ...]
    dimension: int = 2
    radii: tuple[float, float] = (0.1, 0.1)
    """Radii of the two bodies [m]."""
    masses: tuple[float, float] = (1.0, 1.0)
    """[kg]."""

    # -------------------------------------------------------------------------------------------------- arguments

    @property
    def gap(self) -> float:
        """Gap of the last step [m]."""
        return self.steps[-1].gap

    @property
    def W(self) -> Matrix:
        """Local block of the last step [1/kg]."""
        return self.steps[-1].W

    @property
    def q(self) -> Numbers:
        """Free velocity of the last step [m/s]."""
        return self.steps[-1].q

    @cached_property
    def size(self) -> int:
        """Number of rows of the law."""
        return self.law.rows(self.dimension)

    @cached_property
    def parameters(self) -> Numbers:
        """Parameters in the order of ``prepare``."""
        return tuple(float(value) for value in self.law.table(np.array([self.reference_length]))[0])

    # ----------------------------------------------------------------------------------------------------- answers

    def known(self, name: str, time: float) -> tuple[Pair, ...]:
        """Last arguments of a function of the law: ``(Pair,)`` if it takes the pair, ``()`` if not."""
        return as_asked(getattr(self.law, name), pair_of(self.radii, self.masses, time))

    def first_state(self, gap: float) -> Numbers:
        """The state of an interaction that begins at this gap."""
        count = len(self.law.states())
        if self.law.initial is None:
            return (0.0,) * count
        given = gap, self.reference_gap, self.birth, self.parameters, *self.known("initial", self.birth)
        return numbers(self.law, "initial", count, "one for each state", *given)

    def prepare(self, step: CaseStep, state: Numbers) -> Numbers:
        """The prepared numbers for a step."""
        names = self.law.PREPARED
        given = step.gap, self.reference_gap, step.before, self.time_step, self.parameters, state
        known = self.known("prepare", step.time)
        return numbers(self.law, "prepare", len(names), "one for each name in PREPARED", *given, *known, infinite=True)

    def react(self, W: Matrix, u: Sequence[float], prepared: Numbers) -> Numbers:
        """The impulse [N s]."""
        return numbers(self.law, "react", self.size, "one for each row of the law", W, tuple(map(float, u)), prepared)

    def commit(self, step: CaseStep, impulse: Numbers, state: Numbers) -> Numbers:
        """The state after a step with this impulse."""
        return self.committed(step, velocity(step, impulse), impulse, state)

    def committed(self, step: CaseStep, u: Numbers, impulse: Numbers, state: Numbers) -> Numbers:
        """The state after a step with this end velocity and this impulse."""
        if self.law.commit is None:
            return state
        given = step.gap, self.reference_gap, u, impulse, self.time_step, self.parameters, state
        return numbers(self.law, "commit", len(state), "one for each state", *given, *self.known("commit", step.time))

    @property
    def dissipation(self) -> float:
        """Energy that the last step dissipates, as the law tells [J]."""
        step = self.steps[-1]
        mean = tuple(0.5 * (a + b) for a, b in zip(step.before, self.velocity, strict=True))
        given = step.gap, self.reference_gap, mean, self.impulse, self.time_step, self.parameters, self.state
        return number(self.law, "dissipation", *given, *self.known("dissipation", step.time))

    @cached_property
    def history(self) -> tuple[Numbers, ...]:
        """The states before each step."""
        states = [self.first_state(self.steps[0].gap)]
        for step in self.steps[:-1]:
            states.append(self.commit(step, self.react(step.W, step.q, self.prepare(step, states[-1])), states[-1]))
        return tuple(states)

    @property
    def state(self) -> Numbers:
        """State before the last step."""
        return self.history[-1]

    @cached_property
    def prepared(self) -> Numbers:
        """Prepared numbers of the last step."""
        return self.prepare(self.steps[-1], self.state)

    @cached_property
    def impulse(self) -> Numbers:
        """Impulse of the last step [N s]."""
        return self.react(self.W, self.q, self.prepared)

    @property
    def velocity(self) -> Numbers:
        """Velocity at the end of the last step, u = q + W r [m/s]."""
        return velocity(self.steps[-1], self.impulse)

    @property
    def after(self) -> Numbers:
        """State after the last step."""
        return self.commit(self.steps[-1], self.impulse, self.state)

    def slope(self, u: Sequence[float]) -> Matrix:
        """The generalized derivative of the law at the free velocity ``u`` [kg]."""
        return _rows_of_numbers(self.law, "slope", self.size, self.W, tuple(map(float, u)), self.prepared)

    def energy(self, gap: float, state: Numbers | None = None) -> float:
        """Energy stored at a gap [J], with the state before the last step unless ``state`` is given."""
        held = self.state if state is None else state
        known = self.known("energy", self.steps[-1].time)
        return number(self.law, "energy", gap, self.reference_gap, self.parameters, held, *known)

    # ------------------------------------------------------------------------------------------------------ measures

    @cached_property
    def speed(self) -> float:
        """Size of the terms of velocities [m/s]. The round-off of u and of the law's relation is relative to it."""
        step, h = self.steps[-1], self.time_step
        terms = (
            sum(map(abs, step.q)) + float(np.abs(step.W).sum(axis=0) @ np.abs(self.impulse)) + sum(map(abs, step.before))
        )
        terms += (abs(step.gap) + abs(self.reference_gap)) / h
        for value, power in sizes(self.law, self.state):
            if power in (LENGTH, VELOCITY):
                terms += value / (h if power == LENGTH else 1.0)
        bias = dict(zip(self.law.PREPARED, self.prepared, strict=True)).get("bias", 0.0)
        return terms + (abs(bias) if math.isfinite(bias) else 0.0)

    # ---------------------------------------------------------------------------------------------------- transforms

    def with_diagonal(self) -> LawCase:
        """The same case with diagonal blocks of W."""
        return replace(self, steps=tuple(replace(step, W=diagonal(np.diag(step.W).tolist())) for step in self.steps))

    def mirrored(self) -> LawCase:
        """The same case with the tangent reversed."""

        def reversed_step(step: CaseStep) -> CaseStep:
            W = tuple(
                reverse_tangent(row) if i == 0 else tuple(-w for w in reverse_tangent(row)) for i, row in enumerate(step.W)
            )
            return replace(step, before=reverse_tangent(step.before), q=reverse_tangent(step.q), W=W)

        return replace(self, steps=tuple(reversed_step(step) for step in self.steps))

    def scaled(self, law: Law, length: float, time: float, mass: float) -> LawCase:
        """The same case in other units; ``law`` has its parameters in these units."""

        def of(power: Dimensions) -> float:
            return power.factor(length, time, mass)

        return LawCase(
            law=law,
            time_step=time * self.time_step,
            reference_gap=length * self.reference_gap,
            reference_length=length * self.reference_length,
            birth=time * self.birth,
            steps=tuple(
                CaseStep(
                    gap=length * step.gap,
                    before=tuple(of(VELOCITY) * v for v in step.before),
                    W=tuple(tuple(of(INVERSE_MASS) * w for w in row) for row in step.W),
                    q=tuple(of(VELOCITY) * v for v in step.q),
                    time=time * step.time,
                )
                for step in self.steps
            ),
            dimension=self.dimension,
            radii=(length * self.radii[0], length * self.radii[1]),
            masses=(mass * self.masses[0], mass * self.masses[1]),
        )

    # --------------------------------------------------------------------------------------------------------- words

    def __str__(self) -> str:
        step, law = self.steps[-1], self.law
        link = f", reference gap {self.reference_gap!r} m, reference length {self.reference_length!r} m"
        lines = [
            f"law {law!r}, parameters {self.parameters}, time step {self.time_step!r} s",
            f"gap {step.gap!r} m{link if law.APPLIES_TO == 'link' else ''}, velocity before {step.before} m/s",
            f"W = {step.W} 1/kg, free velocity u = {step.q} m/s",
        ]
        if asks_for_pair(law):
            lines.append(f"radii {self.radii} m, masses {self.masses} kg, time {step.time!r} s")
        try:
            if law.states():
                state = dict(zip(law.states(), self.state, strict=True))
                lines.append(f"state {state} after {len(self.steps) - 1} steps since its birth at {self.birth!r} s")
                lines += [f"  step {k}: {earlier}" for k, earlier in enumerate(self.steps[:-1], start=1)]
            lines.append(f"prepared {dict(zip(law.PREPARED, self.prepared, strict=True))}")
            lines.append(f"react(W, u) = {self.impulse} N s")
        except Nonconformance:
            pass
        return "\n".join(f"    {line}" for line in lines)


def velocity(step: CaseStep, impulse: Numbers) -> Numbers:
    """u = q + W r [m/s]."""
    return tuple(q + sum(w * r for w, r in zip(row, impulse, strict=True)) for q, row in zip(step.q, step.W, strict=True))


def diagonal(entries: Sequence[float]) -> Matrix:
    """The matrix with this diagonal."""
    return tuple(tuple(w if i == j else 0.0 for j in range(len(entries))) for i, w in enumerate(entries))


def reverse_tangent(vector: Numbers) -> Numbers:
    """The vector with its tangential component reversed."""
    return (vector[0], *(-component for component in vector[1:]))


def sizes(law: Law, state: Numbers = ()) -> list[tuple[float, Dimensions]]:
    """Sizes and dimensions of the law's parameters and of a state; numbers with an unreadable unit are left out."""
    declared = [(law.values[name], of.unit) for name, of in law.parameters().items()]
    declared += [(value, of.unit) for value, of in zip(state, law.states().values(), strict=False)]
    found = []
    for value, unit in declared:
        with suppress(ValueError):
            found.append((abs(value or 0.0), dimensions(unit)))
    return found
