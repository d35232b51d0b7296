"""Strategies of hypothesis for the properties of a law: parameters, time steps, gaps, velocities, blocks of W, histories.

Magnitudes are powers of ten around centres. The centres are 1 m/s, 1 mm and 1/kg, and others that follow from the
parameters of the law and their units. So the draws cover the thresholds of the law: a strength F matters if F h W is
about the velocity, a stiffness k if h^2 k W is about one, and a length if it is about the gap.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from hypothesis import strategies as st

from lmgcpy.laws import Law
from lmgcpy.laws.pair import asks_for_pair
from lmgcpy.testing.case import CaseStep, LawCase, Matrix, sizes
from lmgcpy.testing.units import NONE, Dimensions

Powers = tuple[float, float]


@dataclass(frozen=True)
class Spread:
    """Ranges of the powers of ten that are drawn around the centres."""

    parameter: Powers = (-2.0, 2.0)
    time_step: Powers = (-2.0, 2.0)
    delassus: Powers = (-3.0, 3.0)
    gap: Powers = (-5.0, 2.0)
    velocity: Powers = (-1.5, 1.5)
    near: Powers | None = (-1.0, 1.0)
    """Range for gaps around the lengths of the law; None: the parameters of the law give no centres."""


USUAL = Spread()


def extreme(decades: float = 12.0) -> Spread:
    """The spread of ``decades`` powers of ten to either side for every quantity."""
    powers = -decades, decades
    return Spread(parameter=powers, time_step=powers, delassus=powers, gap=powers, velocity=powers, near=None)


STEP, GAP, LENGTH = 1e-3, 1e-3, 1e-1
"""Usual time step [s], gap, and reference length [m]."""
COUPLING = 0.99
"""Largest |W_nt| / sqrt(W_nn W_tt)."""
LONGEST = 4
"""Largest number of steps of a history before the step that is checked."""


Draw = Callable[[st.SearchStrategy], Any]


@cache  # hypothesis needs more time to analyse a new strategy than to draw from it
def powers_of_ten(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive numbers 10^(k/8), which shrink towards one."""
    return st.integers(round(8.0 * low), round(8.0 * high)).map(lambda eighths: 10.0 ** (eighths / 8.0))


@cache
def signed(low: float, high: float) -> st.SearchStrategy[float]:
    """Zero, and powers of ten of either sign."""
    signs = st.sampled_from((-1.0, 1.0, -1.0, 1.0, 0.0))
    return st.tuples(signs, powers_of_ten(low, high)).map(lambda pair: pair[0] * pair[1])


@cache
def indices(count: int) -> st.SearchStrategy[int]:
    """Indices from 0 to ``count - 1``."""
    return st.integers(0, count - 1)


YES_OR_NO = st.booleans()
RHO = st.integers(-33, 33).map(lambda k: COUPLING * k / 33.0)


def instance(draw: Draw, law: Law, spread: Spread) -> Law:
    """The given law, or a law with parameters around the given ones, within their bounds."""
    if not law.parameters() or draw(YES_OR_NO):
        return law
    values: dict[str, float] = {}
    for name, parameter in law.parameters().items():
        given = law.values[name]
        if given is not None:
            values[name] = draw(around(given, *parameter.bounds.values(), *spread.parameter))
    try:
        return type(law)(**values)
    except (TypeError, ValueError):  # parameters may bound one another
        return law


@cache
def around(given: float, minimum: float, maximum: float, above: float, low: float, high: float) -> st.SearchStrategy[float]:
    """Values of a parameter: the given one, its minimum, and values at powers of ten from it, within the bounds."""
    bottom = max(minimum, above)
    origin = bottom if math.isfinite(bottom) else 0.0
    centre = given - origin or 1.0
    others = powers_of_ten(low, high).map(lambda factor: min(origin + factor * centre, maximum))
    return st.one_of(st.just(given), others, *([st.just(minimum)] if math.isfinite(minimum) else []))


Sizes = list[tuple[float, Dimensions]]


def lengths_of(known: Sizes, reference_length: float) -> list[float]:
    """Lengths among a law's parameters, and strains times the reference length [m]."""
    plain = [value ** (1.0 / of.length) for value, of in known if of.length and not of.time and not of.mass]
    return plain + [value * reference_length for value, of in known if of == NONE]


def times_of(known: Sizes) -> list[float]:
    """Times among a law's parameters, and inverse rates [s]."""
    return [value ** (1.0 / of.time) for value, of in known if of.time and not of.length and not of.mass]


def inverse_masses_of(known: Sizes, h: float, length: float) -> list[float]:
    """Inverse masses that follow from a law's parameters, the time step and a length [1/kg]."""
    return [(value * h**-of.time * length**-of.length) ** (-1.0 / of.mass) for value, of in known if of.mass]


def velocities_of(known: Sizes, h: float, length: float, w: float) -> list[float]:
    """Velocities that follow from a law's parameters, the time step, a length and W [m/s]."""
    return [value * w**of.mass * h ** (-1.0 - of.time) * length ** (1.0 - of.length) for value, of in known if of != NONE]


def block(draw: Draw, size: int, centre: float, spread: Spread) -> Matrix:
    """A symmetric positive definite local block of W [1/kg]."""
    entries = [centre * draw(powers_of_ten(*spread.delassus)) for _ in range(size)]
    coupled = size > 1 and draw(indices(4)) < 3
    rho = [draw(RHO) if coupled else 0.0 for _ in range(size * (size - 1) // 2)]
    if size > 3:
        return of_partial_correlations(rho, entries)
    if size == 3:  # the third correlation within the bounds that the first two set: W stays positive definite
        rho[2] = rho[0] * rho[1] + rho[2] * math.sqrt((1.0 - rho[0] ** 2) * (1.0 - rho[1] ** 2))
    roots = [math.sqrt(entry) for entry in entries]
    return tuple(
        tuple(entries[i] if i == j else rho[i + j - 1] * roots[i] * roots[j] for j in range(size)) for i in range(size)
    )


def of_partial_correlations(rho: list[float], entries: list[float]) -> Matrix:
    """The symmetric positive definite matrix with this diagonal and the correlations ``L L^T``, L triangular with rows of
    length one: each entry is ``rho``/2 times the length that the entries before leave."""
    size = len(entries)
    given = iter(rho)
    L = np.zeros((size, size))
    for i in range(size):
        left = 1.0
        for j in range(i):
            L[i, j] = 0.5 * next(given) * math.sqrt(left)
            left -= L[i, j] ** 2
        L[i, i] = math.sqrt(left)
    scaled = np.sqrt(entries)[:, None] * L
    W = scaled @ scaled.T
    W[np.diag_indices(size)] = entries
    return tuple(map(tuple, (0.5 * (W + W.T)).tolist()))


@st.composite
def cases(draw: Draw, given: Law, spread: Spread = USUAL) -> LawCase:
    """An interaction under the law, or under the law with other parameters, possibly with a history."""
    law = instance(draw, given, spread)
    dimension = draw(st.sampled_from(dimensions_of(law)))
    size = law.rows(dimension)
    link = law.APPLIES_TO == "link"

    known = [(value, of) for value, of in sizes(law) if value > 0.0] if spread.near else []

    def centre(usual: float, candidates: list[float]) -> float:
        sound = [usual, *(value for value in candidates if 1e-60 < value < 1e60)] if spread.near else [usual]
        return sound[draw(indices(len(sound)))] if len(sound) > 1 else usual

    reference_length = LENGTH * draw(powers_of_ten(*spread.gap))
    h = centre(STEP, times_of(known)) * draw(powers_of_ten(*spread.time_step))
    length = centre(GAP, lengths_of(known, reference_length))
    gaps = signed(*(spread.near if spread.near and length != GAP else spread.gap))
    reference_gap = length * draw(gaps) if link or law.KEEPS_GAP else 0.0
    reference_gap = reference_gap if link else min(reference_gap, 0.0)

    def step(time: float) -> CaseStep:
        gap = 0.0 if link and draw(indices(4)) == 3 else reference_gap + length * draw(gaps)
        W = block(draw, size, centre(1.0, inverse_masses_of(known, h, length)), spread)
        speeds = [length / h, abs(gap) / h, *velocities_of(known, h, length, W[0][0])]
        before, q = (tuple(centre(1.0, speeds) * draw(signed(*spread.velocity)) for _ in range(size)) for _ in range(2))
        return CaseStep(gap=gap, before=before, W=W, q=q, time=time)

    count = draw(indices(LONGEST + 1)) if law.states() else 0
    birth = float(draw(YES_OR_NO))
    steps = tuple(step(birth + k * h) for k in range(count + 1))
    bodies: dict[str, Any] = {}
    if asks_for_pair(law):
        radius, mass = length * draw(powers_of_ten(*spread.gap)), draw(powers_of_ten(*spread.delassus))
        others = st.sampled_from((1.0, 0.5, 4.0, math.inf))
        bodies = {"radii": (radius, radius * draw(others)), "masses": (mass * draw(others), mass)}
    return LawCase(
        law=law,
        time_step=h,
        reference_gap=reference_gap,
        reference_length=reference_length,
        birth=birth,
        steps=steps,
        dimension=dimension,
        **bodies,
    )


def dimensions_of(law: Law) -> tuple[int, ...]:
    """Dimensions in which the law has different numbers of rows, out of those that it is for."""
    by_rows: dict[int, int] = {}
    for dimension in sorted(law.DIMENSIONS):
        by_rows.setdefault(law.rows(dimension), dimension)
    return tuple(by_rows.values())
