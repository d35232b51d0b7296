"""Properties of ``prepare``, ``react``, ``slope`` and ``conic``: the local problem and its solution.

A pair (u, r) satisfies a law if r = react(w I, u - w r) for any w > 0: the law *is* this relation. As in the solvers,
errors are velocities, ``w |r - r'|`` [m/s].
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from lmgcpy.errors import shown
from lmgcpy.laws import Law
from lmgcpy.laws.law import ROLLING_ROWS
from lmgcpy.laws.registry import check_interface
from lmgcpy.testing.case import LawCase, Nonconformance, Numbers, diagonal
from lmgcpy.testing.conformance import (
    ROUND_OFF,
    drawn,
    run_once,
    search,
    to_contact_laws,
    to_laws_that_give,
    to_laws_with_tangent,
)
from lmgcpy.testing.draw import USUAL, extreme, powers_of_ten


@run_once("interface", "functions, arguments, and counts of numbers are those of the interface of laws")
def interface(law: Law) -> str:
    """The checks of the registry, then rows, the table of parameters, equality, and a first call of every function."""
    try:
        check_interface(type(law))
    except TypeError as error:
        return str(error)
    for dimension in law.DIMENSIONS:
        rows = law.rows(dimension)
        possible = sorted({1, dimension, ROLLING_ROWS.get(dimension, dimension)}) if law.APPLIES_TO == "contact" else [1]
        if rows not in possible:
            expected = " or ".join(map(str, possible)) if law.APPLIES_TO == "contact" else "1: links act along them"
            return f"rows({dimension}) returned {rows!r}, expected {expected}."
    table = law.table(np.array([0.1, 0.2, 0.3]))
    if not isinstance(table, np.ndarray) or table.ndim != 2 or len(table) != 3 or not np.isfinite(table).all():
        return f"table of three lengths returned {shown(table)}, expected finite numbers, an array of shape (3, k)."
    given = {name: value for name, value in law.values.items() if value is not None}
    if type(law)(**given) != law or hash(type(law)(**given)) != hash(law):
        return f"{type(law).__name__}(**{given}) differs from the law with these values: files could not name it."
    search(law, "interface", counts, USUAL, 20)
    return ""


def counts(case: LawCase, draw: Any) -> str:
    """The error in the types and counts of the numbers that the functions return, or ""; the numbers may be infinite."""
    try:
        return call_everything(case, draw)
    except Nonconformance as broken:
        if broken.property == "finite":
            return ""
        raise


def call_everything(case: LawCase, draw: Any) -> str:
    """Call every function of the law; the calls check the types and counts of the numbers."""
    _ = case.impulse, case.after
    if case.law.slope is not None:
        case.slope(case.q)
    if case.law.energy is not None:
        case.energy(case.gap)
    if case.law.dissipation is not None:
        _ = case.dissipation
    return ""


@drawn("finite", "no input within 12 decades to either side makes NaN, infinity or an exception", spread=extreme())
def finite(case: LawCase, draw: Any) -> str:
    """Impulse, state, slope and energy are finite; prepared numbers are not NaN. An infinite bias means an open contact."""
    return call_everything(case, draw)


# ------------------------------------------------------------------------------------------------------ the local problem


def error(case: LawCase, u: Sequence[float], r: Sequence[float], w: float) -> tuple[float, Numbers]:
    """``w |r - r'|`` [m/s] and ``r' = react(w I, u - w r)``."""
    again = case.react(diagonal([w] * case.size), [v - w * p for v, p in zip(u, r, strict=True)], case.prepared)
    return w * max(abs(a - b) for a, b in zip(again, r, strict=True)), again


def allowed(case: LawCase, r: Sequence[float], w: float) -> float:
    """Allowed round-off of :func:`error`. An error of u changes the answer by u / w; at large w errors of r dominate."""
    own = min(case.W[i][i] for i in range(case.size))
    return ROUND_OFF * max(1.0, w / own) * (case.speed + w * sum(map(abs, r)))


def satisfies(case: LawCase, w: float) -> str:
    """The error in the answer to a case at the weight ``w``, or "".

    At a large weight a law may have several answers (a softening law has), and then react may give another one. In that
    case each of the answers must come back at small weights.
    """
    r, u = case.impulse, case.velocity
    wrong, again = error(case, u, r, w)
    if wrong <= allowed(case, r, w):
        return ""
    other = tuple(v + w * (b - a) for v, a, b in zip(u, r, again, strict=True))
    small = [w * 1e-3, w * 1e-6]
    if all(error(case, *pair, v)[0] <= allowed(case, pair[1], v) for pair in ((u, r), (other, again)) for v in small):
        return ""
    return (
        f"with r = react(W, q) = {r} N s and u = q + W r = {u} m/s, at W = {case.W} 1/kg, react(w I, u - w r) at "
        f"w = {w!r} 1/kg is {again} N s, off by {wrong:.3g} m/s; expected r again."
    )


@drawn("fixed-point", "with W = w I: react(w' I, u - w' r) = r for every w'")
def fixed_point(case: LawCase, draw: Any) -> str:
    """The law does not depend on the weight: with ``r = react(w I, q)`` and ``u = q + w r``,
    ``react(w' I, u - w' r) = r`` for every w' > 0. The error measure of every solver relies on it."""
    w = case.W[0][0]
    last = replace(case.steps[-1], W=diagonal([w] * case.size))
    case = replace(case, steps=(*case.steps[:-1], last))
    return satisfies(case, w * draw(powers_of_ten(-4.0, 3.0)))


@drawn("general-W", "with any W, coupled as well: react(w I, u - w r) = r", to_laws_with_tangent, examples=300)
def general_delassus(case: LawCase, draw: Any) -> str:
    """The local problem is solved exactly for every symmetric positive definite W: with ``r = react(W, q)`` and
    ``u = q + W r``, ``react(w I, u - w r) = r``. If there are several answers, each of them is right."""
    return satisfies(case, min(case.W[i][i] for i in range(case.size)) * draw(powers_of_ten(-4.0, 0.0)))


@drawn("reach", "a contact whose gap stays beyond the reach of the law has no impulse", to_contact_laws)
def reach(case: LawCase, draw: Any) -> str:
    """A new contact beyond ``acts_within``, whose gap stays beyond it without impulse, has none: otherwise the answer would
    depend on how far contacts are seen."""
    step, within = case.steps[-1], case.law.acts_within(*case.radii)
    beyond = abs(step.gap) or within or 1e-3
    gap = within + beyond
    assume(gap - within > 0.5 * beyond)  # otherwise a length is lost in round-off
    slow = max(step.q[0], -0.25 * beyond / case.time_step)
    new = replace(case, birth=step.time, steps=(replace(step, gap=gap, q=(slow, *step.q[1:])),))
    if any(new.impulse):
        return f"r = {new.impulse} N s at a gap of {gap!r} m, beyond acts_within{case.radii} = {within!r} m: expected none."
    return ""


# -------------------------------------------------------------------------------------------------------------- slope


STRIDES = (1e-4, 1e-6, 1e-8)
"""Strides of the differences relative to the size of velocities; a kink may hide within the larger strides."""


@drawn(
    "slope",
    "slope = d react / d u, between the derivatives of both sides at a kink",
    to_laws_that_give("slope"),
    examples=200,
)
def slope(case: LawCase, draw: Any) -> str:
    """``slope[i][j]`` lies between the two one-sided derivatives of ``r_i`` by ``u_j``, which agree where react is smooth.
    It is checked at the free velocity of the case, and at a kink between this and another velocity."""
    points = [case.q]
    j = draw(st.integers(0, case.size - 1))
    shift = case.speed * draw(powers_of_ten(-3.0, 0.0))
    for sign in (1.0, -1.0):
        points += kink(case, case.q, moved(case.q, j, sign * shift), j)
    for u in points:
        message = wrong_slope(case, u)
        if message:
            return message
    return ""


def moved(u: Sequence[float], j: int, d: float) -> Numbers:
    """``u`` with d added to component j."""
    return (*u[:j], u[j] + d, *u[j + 1 :])


def differences(case: LawCase, u: Sequence[float], j: int, d: float) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of react by u_j to the left and to the right, from differences over ``d``."""
    here, up, down = (np.array(case.react(case.W, v, case.prepared)) for v in (u, moved(u, j, d), moved(u, j, -d)))
    return (here - down) / d, (up - here) / d


def kink(case: LawCase, one: Numbers, other: Numbers, j: int) -> list[Numbers]:
    """The velocity between two others at which a derivative of react jumps; empty if none jumps."""
    d = STRIDES[1] * case.speed
    if d == 0.0:
        return []
    low, high = differences(case, one, j, d)[1], differences(case, other, j, d)[1]
    i = int(np.argmax(np.abs(high - low)))
    if abs(high[i] - low[i]) <= 1e-3 / case.W[i][i]:
        return []
    for _ in range(60):
        middle = moved(one, j, 0.5 * (other[j] - one[j]))
        between = differences(case, middle, j, d)[1]
        if abs(between[i] - low[i]) <= abs(between[i] - high[i]):
            one = middle
        else:
            other = middle
    return [one]


def wrong_slope(case: LawCase, u: Numbers) -> str:
    """The error of the slope at ``u``, or ""."""
    given = np.array(case.slope(u))
    smallest = min(case.W[i][i] for i in range(case.size))
    assume(case.speed > 0.0)
    message = ""
    for j in range(case.size):
        for stride in STRIDES:
            d = stride * case.speed
            left, right = differences(case, u, j, d)
            round_off = 1e-6 / smallest + 1e-14 * (case.speed / smallest + max(map(abs, case.impulse))) / d
            low, high = np.minimum(left, right) - round_off, np.maximum(left, right) + round_off
            if ((low <= given[:, j]) & (given[:, j] <= high)).all():
                break
            message = message or (
                f"slope by component {j} is {given[:, j].tolist()} kg at u = {tuple(u)} m/s, expected to lie between the "
                f"derivatives of react from the left and from the right, {left.tolist()} and {right.tolist()}."
            )
        else:
            return message
    return ""


# --------------------------------------------------------------------------------------------------------- conic form


@drawn("conic", "conic's bias, friction and compliance describe react", to_laws_that_give("conic"))
def conic(case: LawCase, draw: Any) -> str:
    """With b, mu and C of ``conic`` the answer satisfies ``0 <= u_n + b _|_ r_n >= 0`` and Coulomb's friction (contacts),
    ``0 <= -(u_n + b + C r_n) _|_ -r_n >= 0`` (links that pull), or ``u_n + b + C r_n = 0`` (other links). For a law with
    rolling components it also gives mu_r and mu_z: rolling and torsion impulses satisfy Coulomb's condition with these.
    Prepared numbers ``slip_t`` and ``slip_s``, if a law has them, are zero here: friction that knows the slip before the
    step has no conic form, but the solvers that need one only take statuses from it."""
    law, d = case.law, case.dimension
    named = zip(law.PREPARED, case.prepared, strict=True)
    prepared = tuple(0.0 if name in ("slip_t", "slip_s") else value for name, value in named)
    columns = [np.array([value]) for value in prepared]
    message = f"conic returned {shown(law.conic(columns))}"  # type: ignore[misc]
    given = [float(np.asarray(value).ravel()[0]) for value in law.conic(columns)]  # type: ignore[misc]
    if len(given) != (5 if case.size > d else 3):
        more = ", a rolling friction and a torsion friction" if case.size > d else ""
        return f"{message}: expected a bias, a friction and a compliance{more}."
    bias, friction, compliance, *turning = given
    if not (min(friction, compliance, *turning) >= 0.0 and not math.isnan(bias)):
        return f"{message}: expected a bias, and the other numbers to be at least 0."
    if law.APPLIES_TO == "contact" and compliance != 0.0:
        return f"{message}: a contact in conic form has no compliance."
    if case.size == 1 and friction > 0.0:
        return f"{message}, but the law has one row: no friction."
    w = min(case.W[i][i] for i in range(case.size))
    r = case.react(case.W, case.q, prepared)
    u = tuple(q + float(np.dot(row, r)) for q, row in zip(case.q, case.W, strict=True))
    normal = -(u[0] - w * r[0] + bias) / (w + compliance)
    if law.APPLIES_TO == "contact":
        normal = max(normal, 0.0)
    elif "pull" in law.TRAITS:
        normal = min(normal, 0.0)
    expected = [normal]
    stick = [p - v / w for p, v in zip(r, u, strict=True)]
    ends = 1, *(end for end in (d, 2 * d - 1, 2 * d) if end <= case.size)
    for first, end, share in zip(ends, ends[1:], (friction, *turning), strict=False):
        limit = share * max(normal, 0.0)
        expected += [part * min(1.0, limit / (math.hypot(*stick[first:end]) or 1.0)) for part in stick[first:end]]
    wrong = w * max(abs(a - b) for a, b in zip(r, expected, strict=True))
    if wrong <= allowed(case, r, w):
        return ""
    what = f"with these r would be {tuple(expected)} N s instead, {wrong:.3g} m/s away."
    return f"{message}, bias, friction and compliance; {what}"
