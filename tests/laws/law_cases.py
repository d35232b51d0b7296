"""What the tests of the laws draw: parameters within their bounds, Delassus blocks, states of an interaction.

Every law is tested as registered, so that the same tests serve a plug-in that is installed.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

import lmgcpy as lm

LAWS = {name: registration.law for name, registration in lm.laws.registrations().items()}


def magnitude(low: float, high: float):
    """Positive numbers, uniform in the exponent, between ``low`` and ``high``."""
    return st.floats(math.log(low), math.log(high)).map(lambda x: min(max(math.exp(x), low), high))


def signed(low: float, high: float):
    """Zero, or a number of either sign with a magnitude between ``low`` and ``high``."""
    decades = math.log(high / low)
    return st.floats(-1.0, 1.0).map(lambda x: math.copysign(low * math.exp(abs(x) * decades), x) if x else 0.0)


@dataclass(frozen=True)
class Spread:
    """Ranges of what is drawn; ``coupling``: largest |W_nt| / sqrt(W_nn W_tt)."""

    parameter: tuple[float, float] = (1e-3, 1e6)
    delassus: tuple[float, float] = (1e-3, 1e3)
    velocity: tuple[float, float] = (1e-6, 1e2)
    gap: tuple[float, float] = (1e-8, 1e-1)
    time_step: tuple[float, float] = (1e-5, 1e-1)
    coupling: float = 0.99


USUAL = Spread()
EXTREME = Spread(
    parameter=(1e-60, 1e60),
    delassus=(1e-30, 1e30),
    velocity=(1e-60, 1e60),
    gap=(1e-60, 1e60),
    time_step=(1e-12, 1e6),
)


@dataclass(frozen=True)
class Case:
    """One interaction: its law, W, free velocity q, and all that ``prepare`` saw."""

    law: lm.Law
    W: tuple[tuple[float, ...], ...]
    q: tuple[float, ...]
    gap: float
    reference_gap: float
    before: tuple[float, ...]
    time_step: float
    parameters: tuple[float, ...]
    prepared: tuple[float, ...]

    @property
    def impulse(self) -> np.ndarray:
        """What the law answers."""
        return np.array(self.law.react(self.W, self.q, self.prepared))

    @property
    def velocity(self) -> np.ndarray:
        """Velocity under that answer."""
        return np.array(self.q) + np.array(self.W) @ self.impulse

    @property
    def velocity_scale(self) -> float:
        """Size of the terms that make up a velocity: round-off of u and of the law's relation is relative to it."""
        terms = np.abs(self.q).sum() + np.abs(np.array(self.W)).sum(axis=0) @ np.abs(self.impulse)
        finite = [abs(number) for number in self.prepared[:1] if math.isfinite(number)]
        return float(terms) + sum(finite) + (abs(self.gap) + abs(self.reference_gap)) / self.time_step


def parameter_sets(law: type[lm.Law]) -> list[tuple[str, ...]]:
    """The subsets of a law's optional parameters that it accepts together with the required ones."""
    parameters = law.parameters()
    required = {name: 0.5 for name, parameter in parameters.items() if parameter.default is not None}
    optional = [name for name in parameters if name not in required]
    accepted = []
    for size in range(len(optional) + 1):
        for chosen in itertools.combinations(optional, size):
            try:
                law(**required, **dict.fromkeys(chosen, 0.5))
            except ValueError:
                continue
            accepted.append((*required, *chosen))
    assert accepted, f"no set of parameters at 0.5 makes a {law.__name__}"
    return accepted


def within(bounds: dict[str, float], spread: Spread):
    """Numbers within the bounds of a parameter, both ends included where they are reached."""
    low, high = spread.parameter
    floor = bounds["minimum"]
    values = magnitude(low, high).filter(lambda x: x >= floor) if bounds["maximum"] == math.inf else None
    if values is None:
        values = st.floats(max(floor, -high), bounds["maximum"])
    return st.one_of(st.just(floor), values) if math.isfinite(floor) else values


@st.composite
def law_instances(draw, law: type[lm.Law], spread: Spread = USUAL):
    """A law with parameters."""
    names = draw(st.sampled_from(parameter_sets(law)))
    return law(**{name: draw(within(law.parameters()[name].bounds, spread)) for name in names})


@st.composite
def blocks(draw, size: int, spread: Spread = USUAL):
    """A symmetric positive definite local block of W, as a tuple of rows."""
    diagonal = [draw(magnitude(*spread.delassus)) for _ in range(size)]
    if size == 1:
        return ((diagonal[0],),)
    rho = draw(st.one_of(st.just(0.0), st.floats(-spread.coupling, spread.coupling)))
    off = rho * math.sqrt(diagonal[0]) * math.sqrt(diagonal[1])
    return ((diagonal[0], off), (off, diagonal[1]))


@st.composite
def cases(draw, law: type[lm.Law], spread: Spread = USUAL):
    """One interaction under a law."""
    instance = draw(law_instances(law, spread))
    size = instance.rows(2)
    W = draw(blocks(size, spread))
    q = tuple(draw(signed(*spread.velocity)) for _ in range(size))
    gap = draw(signed(*spread.gap))
    reference_gap = draw(signed(*spread.gap)) if law.APPLIES_TO == "link" else 0.0
    before = tuple(draw(signed(*spread.velocity)) for _ in range(size))
    time_step = draw(magnitude(*spread.time_step))
    length = draw(magnitude(*spread.gap))
    parameters = tuple(float(value) for value in instance.table(np.array([length]))[0])
    prepared = tuple(float(number) for number in instance.prepare(gap, reference_gap, before, time_step, parameters, ()))
    return Case(instance, W, q, gap, reference_gap, before, time_step, parameters, prepared)


def with_number(case: Case, name: str, value: float) -> tuple[float, ...]:
    """The prepared numbers with one of them replaced."""
    place = case.law.PREPARED.index(name)
    return (*case.prepared[:place], value, *case.prepared[place + 1 :])
