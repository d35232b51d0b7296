"""Every law that comes with lmgcpy against its line in the table of laws, stated here a second time.

Each statement returns velocities [m/s] that vanish where the relation holds; the answer of ``react`` must bring them
to round-off. They are differences of numbers of the size ``case.speed``, and solving a 2 x 2 block whose
condition is at most 1e2 (coupling 0.99 between equal diagonals; scaling of the rows costs nothing) loses two digits:
``TOLERANCE`` is a hundred times 2.2e-16 for that, and a hundred for the handful of operations.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from built_in import INSTANCES, name
from hypothesis import given
from hypothesis import strategies as st

from lmgcpy.testing.case import CaseStep, LawCase
from lmgcpy.testing.draw import cases

TOLERANCE = 1e-12


def complementarity(x: float, y: float) -> float:
    """Zero where ``0 <= x _|_ y >= 0``."""
    return min(x, y)


def friction_violations(case, mu, first=1, end=None):
    """Velocities that vanish where r_t is in the disk of radius mu r_n and dissipates the most there; r_t has the rows from
    ``first`` on."""
    if len(case.q) == 1:
        return [0.0 if mu == 0.0 else math.inf]
    rows = range(case.size)[first:end]
    w = min(case.W[k][k] for k in rows)
    r_n, r_t = case.impulse[0], case.impulse[first:end]
    there = [r - u / w for r, u in zip(r_t, case.velocity[first:end], strict=True)]
    inward = min(1.0, mu * r_n / (math.hypot(*there) or 1.0))
    outside = max(math.hypot(*r_t) - mu * r_n, 0.0)
    return [w * outside, *(w * (inward * at - r) for at, r in zip(there, r_t, strict=True))]


def signorini(case):
    """0 <= u_n + b  _|_  r_n >= 0: b = g/h where g > 0, else -(g_ref - g)/h within -2 |u_n^-| and 0 where u_n^- < 0."""
    bias = max(case.gap, 0.0) / case.time_step - taken_back(case)
    return [complementarity(case.velocity[0] + bias, case.W[0][0] * case.impulse[0])]


def taken_back(case):
    """Velocity that takes back what turning closed."""
    closed = (case.reference_gap - case.gap) / case.time_step
    return 0.0 if case.gap > 0.0 else float(np.clip(closed, 0.0, 2.0 * max(-case.steps[-1].before[0], 0.0)))


def coulomb(case):
    """The same, and Coulomb's friction."""
    return signorini(case) + friction_violations(case, case.law.friction)


def rolling_coulomb(case):
    """The same; and |r_r| <= mu_r r_n, opposing u_r where it rolls; in 3D two components of rolling, and |r_z| <= mu_z r_n,
    mu_z = 2/3 mu mu_r unless it is given."""
    d, law = case.dimension, case.law
    violations = signorini(case) + friction_violations(case, law.friction, 1, d)
    violations += friction_violations(case, law.rolling_friction, d, 2 * d - 1)
    if d == 3:
        torsion = 2 / 3 * law.friction * law.rolling_friction if law.torsion_friction is None else law.torsion_friction
        violations += friction_violations(case, torsion, 5)
    return violations


def restitution(case):
    """Where g <= 0: 0 <= u_n + phi  _|_  r_n >= 0, phi = u_n^- where that is positive, else -max(e |u_n^-|, what takes back
    turning) down to u_n^-; and friction towards the segment from -u_t^- to 0. Where g > 0: r = 0."""
    if case.gap > 0.0:
        return list(np.diag(case.W) * case.impulse)
    before, *slip = case.steps[-1].before
    phi = before if before >= 0.0 else max(before, -max(-case.law.restitution * before, taken_back(case)))
    normal = complementarity(case.velocity[0] + phi, case.W[0][0] * case.impulse[0])
    return [normal, *segment_violations(case, case.law.friction, np.array(slip))]


def segment_violations(case, mu, before):
    """Velocities that vanish where r_t is mu r_n times minus a subgradient of the distance of u_t to the segment from
    ``-before`` to 0: r_t and s = u_t less its nearest point of the segment satisfy Coulomb's law, and r_t pushes along the
    segment at its ends only, and outward there."""
    if len(case.q) == 1:
        return [0.0 if mu == 0.0 else math.inf]
    u, r = np.array(case.velocity[1:]), np.array(case.impulse[1:])
    square = float(before @ before)
    share = float(np.clip(-(u @ before) / square, 0.0, 1.0)) if square > 0.0 else 0.0
    w = min(np.diag(case.W)[1:])
    size = math.sqrt(square)
    inside = w * r @ before / size if square > 0.0 else 0.0
    # complementary, as round-off may leave u beside an end: inside > 0 only at the far end, < 0 only at 0
    ends = [min(max(inside, 0.0), (1.0 - share) * size), min(max(-inside, 0.0), share * size)]
    s = u + share * before
    there = r - s / w
    inward = min(1.0, mu * case.impulse[0] / (math.hypot(*there) or 1.0))
    outside = max(math.hypot(*r) - mu * case.impulse[0], 0.0)
    return [w * outside, *(w * (inward * there - r)), *ends]


def elongation_rate(case):
    """(g + h u_n - g_ref)/h: predicted elongation over the step."""
    return case.velocity[0] + (case.gap - case.reference_gap) / case.time_step


def rigid_rod(case):
    """u_n + (g - g_ref)/h = 0."""
    return [elongation_rate(case)]


def rigid_wire(case):
    """0 <= -(u_n + (g - g_ref)/h)  _|_  -r_n >= 0."""
    return [complementarity(-elongation_rate(case), -case.W[0][0] * case.impulse[0])]


def per_compliance(case, impulse_error, stiffness, viscosity=0.0):
    """An error of the impulse as one of the velocity: by 1/(h^2 k + h c), or by W where that is smaller."""
    h = case.time_step
    return min(case.W[0][0], 1.0 / (h * h * stiffness + h * viscosity)) * impulse_error


def elastic_rod(case):
    """r_n = -h k (g+ - g_ref)."""
    k = case.parameters[0]
    expected = -(case.time_step**2) * k * elongation_rate(case)
    return [per_compliance(case, case.impulse[0] - expected, k)]


def elastic_wire(case):
    """r_n = -h k max(g+ - g_ref, 0)."""
    k = case.parameters[0]
    expected = -(case.time_step**2) * k * max(elongation_rate(case), 0.0)
    return [per_compliance(case, case.impulse[0] - expected, k)]


def voigt_force(case):
    """-h k (g+ - g_ref) - h c u_n."""
    h, (k, c) = case.time_step, case.parameters
    return -(h * h) * k * elongation_rate(case) - h * c * case.velocity[0]


def voigt_rod(case):
    """r_n = -h k (g+ - g_ref) - h c u_n."""
    return [per_compliance(case, case.impulse[0] - voigt_force(case), *case.parameters)]


def voigt_wire(case):
    """min(0, -h k (g+ - g_ref) - h c u_n) where g+ > g_ref, 0 where g+ < g_ref, anything between where g+ = g_ref."""
    r = case.impulse[0]
    beyond_force = per_compliance(case, min(r - min(voigt_force(case), 0.0), 0.0), *case.parameters)
    short_of_force = per_compliance(case, max(r - min(voigt_force(case), 0.0), 0.0), *case.parameters)
    elongation = elongation_rate(case)
    round_off = TOLERANCE * case.speed
    if elongation < -round_off:
        return [case.W[0][0] * r]
    if elongation > round_off:
        return [beyond_force, short_of_force]
    return [beyond_force, max(r, 0.0)]


RELATIONS = {
    "signorini": signorini,
    "coulomb": coulomb,
    "rolling-coulomb": rolling_coulomb,
    "restitution": restitution,
    "rigid-rod": rigid_rod,
    "ball-joint": rigid_rod,
    "rigid-wire": rigid_wire,
    "elastic-rod": elastic_rod,
    "elastic-wire": elastic_wire,
    "voigt-rod": voigt_rod,
    "voigt-wire": voigt_wire,
}


@pytest.mark.parametrize("law", INSTANCES, ids=name)
@given(data=st.data())
def test_react_solves_the_relation(law, data):
    """W is any symmetric positive definite block; the sentence of the law's statement is its relation."""
    case = data.draw(cases(law))
    violations = RELATIONS[law.NAME](case)
    assert np.abs(violations).max() <= TOLERANCE * case.speed


@pytest.mark.parametrize("factor", [0.5, 0.999, 1.001, 2.0])
@pytest.mark.parametrize("law", INSTANCES, ids=name)
def test_the_relation_rejects_a_wrong_impulse(law, factor):
    """So that the test above can fail: at an active interaction of speed 1 m/s, W = 2/kg, a wrong impulse shows."""
    size = law.rows(2)
    q = (1.0 if law.APPLIES_TO == "link" else -1.0, 0.8, 0.2)[:size]
    W = tuple(row[:size] for row in ((2.0, 0.5, 0.1), (0.5, 1.0, 0.2), (0.1, 0.2, 1.0))[:size])
    step = CaseStep(gap=0.0, before=(0.0,) * size, W=W, q=q)
    case = LawCase(law, time_step=1e-2, reference_gap=0.0, reference_length=0.1, birth=0.0, steps=(step,))
    assert np.abs(RELATIONS[law.NAME](case)).max() <= TOLERANCE
    wrong = replace(case)
    vars(wrong)["impulse"] = tuple(factor * component for component in case.impulse)
    assert np.abs(RELATIONS[law.NAME](wrong)).max() > 1e-4
