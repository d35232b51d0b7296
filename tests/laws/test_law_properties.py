"""What every registered law promises, plug-ins included: written once for all laws and run on each.

Tolerances are relative to ``case.velocity_scale``, the size of the terms in ``u = q + W r``; 1e-12 is 1e4 units of
round-off: a hundred for the condition of a 2 x 2 block (coupling at most 0.99) and a hundred for the operations.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from law_cases import EXTREME, LAWS, cases, magnitude, with_number

TOLERANCE = 1e-12

every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def with_trait(trait: str):
    chosen = {name: law for name, law in LAWS.items() if trait in law.TRAITS}
    return pytest.mark.parametrize("law", chosen.values(), ids=chosen.keys())


def spherical(w: float, size: int):
    """The block w I."""
    return tuple(tuple(w if i == j else 0.0 for j in range(size)) for i in range(size))


@every_law
@given(data=st.data())
def test_extreme_input_gives_a_finite_impulse(law, data):
    """Sixty decades to either side: no division by zero, no overflow, no NaN.

    The only infinite prepared number that is allowed is a bias that says "open".
    """
    case = data.draw(cases(law, EXTREME))
    assert len(case.prepared) == len(law.PREPARED)
    assert not np.isnan(case.prepared).any()
    assert len(case.impulse) == len(case.q)
    assert np.isfinite(case.impulse).all()
    if law.slope is not None:
        assert np.isfinite(law.slope(case.W, case.q, case.prepared)).all()
    if law.energy is not None:
        assert np.isfinite(law.energy(case.gap, case.reference_gap, case.parameters, ()))


@every_law
@given(data=st.data(), w=magnitude(1e-3, 1e3))
def test_the_answer_is_a_fixed_point_at_any_weight(law, data, w):
    """react(w I, u - w r) = r where (u, r) satisfies the law: what the error measure of every solver rests on."""
    case = data.draw(cases(law))
    r, u = case.impulse, case.velocity
    again = np.array(law.react(spherical(w, len(r)), tuple(u - w * r), case.prepared))
    scale = case.velocity_scale + w * np.abs(r).sum()
    # an error of u moves the answer by u / w; at large w the impulse itself is what round-off is relative to
    assert w * np.abs(again - r).max() <= TOLERANCE * max(1.0, w / min(np.diag(case.W))) * scale


@every_law
@given(data=st.data())
def test_a_wrong_impulse_is_no_fixed_point(law, data):
    """The other direction: the error sees an impulse that is off by d, as one of at least W_nn d.

    Off towards the side where the law has no bound, for w = W_nn: a monotone law then answers with less than what was
    offered, by d at least (min(w r, W_nn d) for a rigid law, d (C + W_nn) w / (w + C) with a compliance C).
    """
    case = data.draw(cases(law))
    w = case.W[0][0]
    d = 1e-3 * (case.velocity_scale + 1.0) / w
    r = np.array(case.impulse)
    r[0] += -d if "pull" in law.TRAITS else d
    u = np.array(case.q) + np.array(case.W) @ r
    again = np.array(law.react(spherical(w, len(r)), tuple(u - w * r), case.prepared))
    assert w * abs(again[0] - r[0]) > 0.99 * w * d


@with_trait("push")
@given(data=st.data())
def test_push_never_pulls(law, data):
    assert data.draw(cases(law, EXTREME)).impulse[0] >= 0.0


@with_trait("pull")
@given(data=st.data())
def test_pull_never_pushes(law, data):
    assert data.draw(cases(law, EXTREME)).impulse[0] <= 0.0


@with_trait("cone")
@given(data=st.data())
def test_the_impulse_is_in_its_cone(law, data):
    """|r_t| <= mu r_n up to one rounding of the product."""
    case = data.draw(cases(law))
    assume(len(case.q) > 1)
    friction = case.prepared[law.PREPARED.index("friction")]
    assert np.linalg.norm(case.impulse[1:]) <= friction * case.impulse[0] * (1.0 + 4e-16)


@with_trait("dissipative")
@given(data=st.data())
def test_without_bias_the_impulse_takes_energy(law, data):
    """r . u <= 0: with zero bias r . u is the work of the impulse at the end velocity."""
    case = data.draw(cases(law))
    prepared = with_number(case, "bias", 0.0)
    r = np.array(law.react(case.W, case.q, prepared))
    terms = np.abs(case.q) + np.abs(np.array(case.W)) @ np.abs(r)
    assert r @ (np.array(case.q) + np.array(case.W) @ r) <= TOLERANCE * (np.abs(r) @ terms)


@with_trait("rigid")
@given(data=st.data(), exponent=st.integers(-40, 40))
def test_a_rigid_law_knows_no_compliance(law, data, exponent):
    """Twice the W, half the impulse: exactly, for a factor that is a power of two."""
    case = data.draw(cases(law))
    factor = 2.0**exponent
    scaled = tuple(tuple(factor * w for w in row) for row in case.W)
    assert np.array_equal(factor * np.array(law.react(scaled, case.q, case.prepared)), case.impulse)


@with_trait("potential")
@given(data=st.data())
def test_the_force_is_the_slope_of_the_energy(law, data):
    """r_n = -h E'(g+) at the predicted gap g+ = g + h u_n.

    E is piecewise quadratic or smoother: the central difference over 2 d is exact to round-off, which is that of E over
    d. With d = 1e-3 of the elongation that leaves 1e-12; a kink within d is avoided.
    """
    case = data.draw(cases(law))
    predicted = case.gap + case.time_step * case.velocity[0]
    size = abs(predicted - case.reference_gap)
    # the gaps must resolve the elongation: else its round-off is compared with itself
    assume(size > 1e-6 * (abs(case.gap) + abs(case.reference_gap) + case.time_step * case.velocity_scale))
    d = 1e-3 * size
    slope = (
        law.energy(predicted + d, case.reference_gap, case.parameters, ())
        - law.energy(predicted - d, case.reference_gap, case.parameters, ())
    ) / (2.0 * d)
    force = case.impulse[0] / case.time_step
    stiffest = (abs(force) + abs(slope)) / size
    # round-off of the gaps, as a force, and the difference's own
    gaps = abs(case.gap) + abs(case.reference_gap) + case.time_step * case.velocity_scale
    assert abs(force + slope) <= stiffest * (1e-9 * size + TOLERANCE * gaps)


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if law.slope is not None])
@given(data=st.data())
def test_slope_is_the_derivative_of_react(name, data):
    """Against finite differences, where the one-sided ones agree: away from the kinks of the law.

    For the piecewise linear laws a difference over d is exact up to the round-off of react over d: with d = 1e-4 of the
    scale about 1e-11 of 1/W. 1e-6 leaves room for smooth plug-ins.
    """
    law = LAWS[name]
    case = data.draw(cases(law))
    size = len(case.q)
    d = 1e-4 * (case.velocity_scale + 1e-12)
    slope = np.array(law.slope(case.W, case.q, case.prepared))
    assert slope.shape == (size, size)
    for j in range(size):
        moved = [list(case.q), list(case.q)]
        moved[0][j] += d
        moved[1][j] -= d
        up, down = (np.array(law.react(case.W, tuple(q), case.prepared)) for q in moved)
        right, left = (up - case.impulse) / d, (case.impulse - down) / d
        largest = 1.0 / min(np.diag(case.W))
        assume(np.abs(right - left).max() <= 1e-7 * largest)
        assert np.abs(slope[:, j] - 0.5 * (right + left)).max() <= 1e-6 * largest


@pytest.mark.parametrize("name", [name for name, law in LAWS.items() if law.slope is not None])
@given(data=st.data())
def test_slope_lies_between_zero_and_rigid(name, data):
    """-1/W <= dr_n/du_n <= 0 at every point, kinks too: what keeps the wire block's matrix invertible."""
    law = LAWS[name]
    case = data.draw(cases(law, EXTREME))
    slope = law.slope(case.W, case.q, case.prepared)[0][0]
    assert -(1.0 + 1e-15) / case.W[0][0] <= slope <= 0.0


@every_law
@given(data=st.data())
def test_the_normal_answer_is_monotone(law, data):
    """Along the normal, with W diagonal: a larger free velocity never gives a larger impulse, at any kink.

    So the local problem has one answer, and the sweep cannot cycle at one interaction.
    """
    case = data.draw(cases(law))
    w = case.W[0][0]
    step = data.draw(magnitude(1e-12, 1e3))
    block = spherical(w, len(case.q))
    lower = law.react(block, case.q, case.prepared)[0]
    upper = law.react(block, (case.q[0] + step, *case.q[1:]), case.prepared)[0]
    assert upper <= lower + 1e-15 * abs(lower)
    assert math.isfinite(upper)
