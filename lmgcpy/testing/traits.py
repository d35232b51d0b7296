"""Properties that laws declare in ``TRAITS``."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import assume

from lmgcpy.laws import Law
from lmgcpy.testing.case import CaseStep, LawCase, Nonconformance, Numbers
from lmgcpy.testing.conformance import ROUND_OFF, drawn, to_laws_with, to_laws_with_tangent
from lmgcpy.testing.draw import extreme, powers_of_ten
from lmgcpy.testing.local_solve import STRIDES, differences


@drawn("push", "r_n >= 0", to_laws_with("push"), spread=extreme())
def push(case: LawCase, draw: Any) -> str:
    """The normal impulse is never negative, not even by round-off."""
    return "" if case.impulse[0] >= 0.0 else f"r_n = {case.impulse[0]!r} N s, expected r_n >= 0: it pulls."


@drawn("pull", "r_n <= 0", to_laws_with("pull"), spread=extreme())
def pull(case: LawCase, draw: Any) -> str:
    """The normal impulse is never positive, not even by round-off."""
    return "" if case.impulse[0] <= 0.0 else f"r_n = {case.impulse[0]!r} N s, expected r_n <= 0: it pushes."


def both(*reasons: Callable[[Law], str]) -> Callable[[Law], str]:
    """The property applies if all reasons are ""."""
    return lambda law: next((message for message in (reason(law) for reason in reasons) if message), "")


def friction_of(case: LawCase, name: str = "friction") -> float:
    """Coefficient of friction from ``conic``, from the prepared numbers, or from the parameters, in this order;
    ``name``: "friction", "rolling_friction" or "torsion_friction"."""
    law = case.law
    if law.conic is not None and name == "friction":
        return float(np.asarray(law.conic([np.array([value]) for value in case.prepared])[1]).ravel()[0])
    for named in (dict(zip(law.PREPARED, case.prepared, strict=True)), law.values):
        if named.get(name) is not None:
            return float(named[name])  # type: ignore[arg-type]
    message = f"the law declares 'cone' but names no {name}: give conic, or call a prepared number or parameter '{name}'."
    raise Nonconformance("cone", message)


@drawn(
    "cone",
    "|r_t| <= friction * r_n; |r_r|, |r_z| <= rolling_friction, torsion_friction * r_n",
    both(to_laws_with("cone"), to_laws_with_tangent),
    examples=200,
)
def cone(case: LawCase, draw: Any) -> str:
    """The tangential impulse is at most friction times the normal impulse, up to round-off of the product. If there are
    any, the rolling impulse is at most rolling friction times it, and the torsion impulse torsion friction times it."""
    normal, d = case.impulse[0], case.dimension
    parts = {"friction": case.impulse[1:d], "rolling_friction": case.impulse[d : 2 * d - 1]}
    parts["torsion_friction"] = case.impulse[2 * d - 1 :]
    for name, part in parts.items():
        if not part:
            continue
        friction, size = friction_of(case, name), math.hypot(*part)
        if not size <= friction * normal * (1.0 + 1e-14):
            what = {"friction": "|r_t|", "rolling_friction": "|r_r|", "torsion_friction": "|r_z|"}[name]
            most = f"{name} * r_n = {friction!r} * {normal!r} = {friction * normal!r} N s"
            return f"{what} = {size!r} N s, expected at most {most}."
    return ""


@drawn("no-dilatancy", "W diagonal: r_n does not depend on u_t", both(to_laws_with("cone"), to_laws_with_tangent))
def no_dilatancy(case: LawCase, draw: Any) -> str:
    """Friction is not associated: sliding does not separate the bodies. So the normal relation holds between u_n and r_n
    alone, and for a diagonal W the normal impulse does not depend on the tangential free velocity."""
    case = case.with_diagonal()
    without = case.react(case.W, (case.q[0], *(0.0 for _ in case.q[1:])), case.prepared)
    if case.W[0][0] * abs(case.impulse[0] - without[0]) <= ROUND_OFF * case.speed:
        return ""
    return (
        f"sliding changes the normal impulse: r_n = {case.impulse[0]!r} N s, with u_t = 0 and W without coupling it is "
        f"{without[0]!r} N s; the law dilates (its friction is associated)."
    )


@drawn("rigid", "W diagonal: d r_n / d u_n is 0 or -1/W_nn", to_laws_with("rigid"))
def rigid(case: LawCase, draw: Any) -> str:
    """The law has no compliance: either the velocity is constant and the impulse changes, or the impulse is constant and
    the velocity changes. So, away from kinks, the impulse takes up a change of the free normal velocity fully (-1/W_nn) or
    not at all."""
    case = case.with_diagonal()
    assume(case.speed > 0.0)
    w = case.W[0][0]
    for stride in STRIDES:
        left, right = (w * side[0] for side in differences(case, case.q, 0, stride * case.speed))
        if abs(left - right) > 1e-5:  # a kink is near
            continue
        nearest = -1.0 if left < -0.5 else 0.0
        if abs(left - nearest) > 1e-5:
            return f"d r_n / d u_n is {left / w!r} kg, expected 0 or -1/W_nn = {-1.0 / w!r} kg: the law is compliant."
        return ""
    return ""


# ------------------------------------------------------------------------------------------------------------- energy


def work(r: Numbers, u: Numbers) -> tuple[float, float]:
    """``r . u`` [J] and the sum of the sizes of its terms."""
    terms = [a * b for a, b in zip(r, u, strict=True)]
    return sum(terms), sum(map(abs, terms))


def gives_energy(case: LawCase, prepared: Numbers, how: str) -> str:
    """The error if the impulse has positive work at the end velocity, or ""."""
    r = case.react(case.W, case.q, prepared)
    u = tuple(q + float(np.dot(row, r)) for q, row in zip(case.q, case.W, strict=True))
    terms = [abs(q) + float(np.abs(row) @ np.abs(r)) for q, row in zip(case.q, case.W, strict=True)]
    gained = work(r, u)[0]
    if gained <= ROUND_OFF * float(np.abs(r) @ terms):
        return ""
    return f"{how}, r . u = {gained:.3g} J > 0 with r = {r} N s and u = q + W r = {u} m/s: the law gives energy."


@drawn("dissipative", "without bias r . u <= 0; alone, at its reference, r . (u- + u+)/2 <= 0", to_laws_with("dissipative"))
def dissipative(case: LawCase, draw: Any) -> str:
    """Three checks. First, with the prepared number ``bias`` set to zero (if there is one) the impulse never gives energy,
    ``r . u <= 0``, in any state. Second, the same holds for a new interaction at rest at its reference gap. Third, an
    impact of the two bodies alone at this gap, with a diagonal W, loses kinetic energy, ``r . (u- + u+)/2 <= 0``;
    restitution beyond 1 fails here."""
    law = case.law
    if "bias" in law.PREPARED:
        zero = tuple(0.0 if name == "bias" else value for name, value in zip(law.PREPARED, case.prepared, strict=True))
        message = gives_energy(case, zero, "with the prepared bias set to zero")
        if message:
            return message
    still = (0.0,) * case.size
    new = replace(case, steps=(CaseStep(case.reference_gap, still, case.W, case.q, case.birth),))
    message = gives_energy(new, new.prepared, "new, at its reference gap and at rest before the step")
    if message:
        return message
    impact = replace(case, steps=(CaseStep(case.reference_gap, case.q, case.W, case.q, case.birth),)).with_diagonal()
    r, u = impact.impulse, impact.velocity
    gained, terms = work(r, tuple(0.5 * (a + b) for a, b in zip(impact.q, u, strict=True)))
    if gained <= ROUND_OFF * terms:
        return ""
    return (
        f"an impact of these two bodies alone, new, at the reference gap, without coupling, raises the kinetic energy by "
        f"r . (u- + u+)/2 = {gained:.3g} J: u- = {impact.q} m/s, u+ = {u} m/s."
    )


@drawn("potential", "r_n = -h dE/dg at g+ = g + h u_n, state held", to_laws_with("potential"))
def potential(case: LawCase, draw: Any) -> str:
    """The normal force is minus the derivative of ``energy`` at the predicted gap, ``r_n / h = -E'(g + h u_n)``, with the
    state that ``prepare`` received, away from kinks of E'."""
    law, h = case.law, case.time_step
    if law.energy is None:
        return "the law declares 'potential' but gives no energy."
    predicted = case.gap + h * case.velocity[0]
    size = abs(predicted - case.reference_gap)
    gaps = h * case.speed
    assume(size > 1e-6 * gaps)  # gaps must resolve the elongation; otherwise only round-off is compared
    d = 1e-4 * size * draw(powers_of_ten(-0.5, 0.5))
    energies = [case.energy(predicted + k * d) for k in (-2.0, -1.0, 1.0, 2.0)]
    plain = (energies[2] - energies[1]) / (2.0 * d)
    wide = (energies[3] - energies[0]) / (4.0 * d)
    noise = 1e-14 * max(map(abs, energies)) / d
    assume(abs(plain - wide) <= 1e-6 * (abs(plain) + abs(wide)) + noise)  # otherwise a kink is near
    slope = (4.0 * plain - wide) / 3.0
    force = case.impulse[0] / h
    stiffest = (abs(force) + abs(slope)) / size
    if abs(force + slope) <= stiffest * (3e-6 * size + ROUND_OFF * gaps) + noise:
        return ""
    return (
        f"r_n / h = {force!r} N, expected minus the slope of the energy at the predicted gap {predicted!r} m, {-slope!r} N."
    )
