"""Invariance of a law: in other units, under reflection, and in frames that are turned about the normal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from lmgcpy.laws import Law, Parameter, State
from lmgcpy.testing.case import ENERGY, IMPULSE, LawCase, Matrix, Nonconformance, Numbers, reverse_tangent
from lmgcpy.testing.conformance import ROUND_OFF, drawn, run_once, search, to_laws_in_space, to_laws_with_tangent
from lmgcpy.testing.draw import USUAL
from lmgcpy.testing.units import Dimensions, dimensions

# --------------------------------------------------------------------------------------------------------------- units

FACTORS = [(16.0**length, 16.0**time, 16.0**mass) for length, time, mass in
           ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-2, 1, 0), (0, -2, 1), (3, 0, -1), (2, -3, -2))]  # fmt: skip
"""Factors for lengths, times and masses. They are powers of 16, which scale products, quotients and square roots exactly:
the law takes the same branch, and a difference is no round-off."""


def declared_dimensions(law: Law) -> dict[str, Dimensions]:
    """Dimensions of the law's parameters and states; Nonconformance for a unit that cannot be read."""
    found = {}
    declared: list[tuple[str, Parameter | State]] = [*law.parameters().items(), *law.states().items()]
    for name, of in declared:
        try:
            found[name] = dimensions(of.unit)
        except ValueError as error:
            raise Nonconformance("units", f"'{name}': {error}", law) from None
    return found


@run_once("units", "lengths, times and masses in other units: the same answer in those units")
def units(law: Law) -> str:
    """Dimensional covariance: the answer does not depend on the units. Gap, velocities, time step, W and parameters are
    scaled by their units; then impulses, states and energies must scale by theirs. This finds a wrong power of the time
    step, a length in millimetres and a hidden threshold.

    A 2D scene is per metre of depth. So units are read in two ways: literally, and with one metre of every area as that
    depth (a stress [Pa] times a length is then a force). The property must hold in one of the two.
    """
    plain = declared_dimensions(law)
    planar = {name: of.in_the_plane() for name, of in plain.items()}
    try:
        search(law, "units", lambda case, draw: other_units(case, draw, plain), USUAL, 100)
    except Nonconformance:
        if planar == plain:
            raise
        search(law, "units", lambda case, draw: other_units(case, draw, planar), USUAL, 100)
    return ""


def other_units(case: LawCase, draw: Any, declared: Mapping[str, Dimensions]) -> str:
    """The error in the answers to a case in other units, or ""."""
    factors = draw(st.sampled_from(FACTORS))
    values = {name: value for name, value in case.law.values.items() if value is not None}
    try:
        law = type(case.law)(**{name: value * declared[name].factor(*factors) for name, value in values.items()})
    except ValueError:  # the scaled parameter is out of its bounds
        return ""
    scaled = case.scaled(law, *factors)
    compared: list[tuple[str, str, float, float, float, Dimensions]] = []
    for k, (given, got) in enumerate(zip(case.impulse, scaled.impulse, strict=True)):
        compared.append((f"impulse[{k}]", "N s", given, got, case.speed / case.W[k][k], IMPULSE))
    for (name, of), given, got in zip(case.law.states().items(), case.after, scaled.after, strict=True):
        compared.append((f"state {name}", of.unit, given, got, 0.0, declared[name]))
    if case.law.energy is not None:
        stored = case.energy(case.gap)
        compared.append(("energy", "J", stored, scaled.energy(scaled.gap), 0.0, ENERGY))
    if case.law.dissipation is not None:
        size = sum(map(abs, case.impulse)) * case.speed
        compared.append(("dissipation", "J", case.dissipation, scaled.dissipation, size, ENERGY))
    for what, unit, given, got, size, power in compared:
        expected = given * power.factor(*factors)
        if abs(got - expected) > 1e-9 * (abs(expected) + size * power.factor(*factors)):
            length, time, mass = factors
            return (
                f"with lengths times {length:g}, times times {time:g}, masses times {mass:g}, {what} [{unit}] goes from "
                f"{given!r} to {got!r}, expected {expected!r}: a power of the time step or of a length is wrong, a number "
                "in the law has a hidden unit, or a parameter or state is declared with another unit than it has."
            )
    return ""


# -------------------------------------------------------------------------------------------------------------- mirror


@drawn("mirror", "the mirrored history has the mirrored answer: the same r_n, r_t reversed", to_laws_with_tangent)
def mirror(case: LawCase, draw: Any) -> str:
    """Frame indifference in the plane: if t is reversed (u_t, W_nt and r_t change sign) from the birth of the interaction,
    the tangential impulse is reversed too. Each number of the state must stay the same or change its sign; laws need not
    declare which. W is diagonal here, so that a law has one answer."""
    case = case.with_diagonal()
    image = case.mirrored()
    expected = reverse_tangent(case.impulse)
    for k, (got, wanted) in enumerate(zip(image.impulse, expected, strict=True)):
        if case.W[k][k] * abs(got - wanted) > ROUND_OFF * case.speed:
            return f"with the tangent reversed react gives {image.impulse} N s, expected {expected} N s."
    for name, plain, mirrored in zip(case.law.states(), case.after, image.after, strict=True):
        if abs(abs(plain) - abs(mirrored)) > 1e-9 * abs(plain):
            return f"with the tangent reversed state {name} is {mirrored!r}, expected {plain!r} or {-plain!r}."
    return ""


# ---------------------------------------------------------------------------------------------------------- isotropy

QUARTER = 0.5 * math.pi


@drawn("isotropy", "in 3D, tangents turned about the normal: r_n as before, r_t turned", to_laws_in_space)
def isotropy(case: LawCase, draw: Any) -> str:
    """Frame indifference in 3D: the tangents t and s are a choice. If they turn about the normal, the components of the
    vectors in the tangent plane (friction and rolling) turn back, and the normal and torsion components stay. Here W is
    the same in all directions, diagonal except for the coupling of friction with rolling. The numbers of a state are not
    compared: they may be components."""
    if case.dimension != 3:
        return ""
    angle, share = draw(st.integers(1, 15)) * QUARTER / 4.0, draw(st.integers(-9, 9)) / 10.0
    straight = replace(case, steps=tuple(replace(step, W=isotropic(step.W, share)) for step in case.steps))
    turned = replace(
        straight,
        steps=tuple(replace(step, before=turn(step.before, angle), q=turn(step.q, angle)) for step in straight.steps),
    )
    expected = turn(straight.impulse, angle)
    for k, (got, wanted) in enumerate(zip(turned.impulse, expected, strict=True)):
        if straight.W[k][k] * abs(got - wanted) > ROUND_OFF * straight.speed:
            return f"with the tangents turned by {angle:.4g} rad react gives {turned.impulse} N s, expected {expected} N s."
    return ""


def turn(vector: Numbers, angle: float) -> Numbers:
    """Components of a vector, with its rolling components, in a frame that is turned about the normal by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    parts = list(vector)
    for k in range(1, len(vector) - 1, 2):
        parts[k], parts[k + 1] = c * vector[k] + s * vector[k + 1], c * vector[k + 1] - s * vector[k]
    return tuple(parts)


def isotropic(W: Matrix, share: float) -> Matrix:
    """A block with the diagonal of W, made equal along both tangents. If there are rolling components, t and s are coupled
    with them by ``share`` of the greatest coupling of a positive definite block."""
    block = np.diag(np.diag(W))
    for k in range(1, len(W) - 1, 2):
        block[k + 1, k + 1] = block[k, k]
    if len(W) == 6:
        for k in (1, 2):
            block[k, k + 2] = block[k + 2, k] = share * math.sqrt(block[k, k] * block[k + 2, k + 2])
    return tuple(map(tuple, block.tolist()))
