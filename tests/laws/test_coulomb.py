"""Coulomb's law with full coupling of normal and tangential motion, where neither existence nor uniqueness is plain."""

from __future__ import annotations

import math

import numpy as np
import pytest
import suites
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lmgcpy.laws.coulomb import Coulomb, react_in_plane


def magnitude(low, high):
    """Positive numbers, uniform in the exponent, between ``low`` and ``high``."""
    return st.floats(math.log(low), math.log(high)).map(lambda x: min(max(math.exp(x), low), high))


def signed(low, high):
    """Zero, or a number of either sign with a magnitude between ``low`` and ``high``."""
    return st.tuples(st.sampled_from((-1.0, 0.0, 1.0)), magnitude(low, high)).map(math.prod)


def natural_map_error(W, q, mu, r):
    """Largest violation of the law [m/s] by an impulse: Signorini, the cone, and maximal dissipation."""
    W, q, r = np.array(W), np.array(q), np.array(r)
    u = q + W @ r
    w = W[1, 1]
    radius = mu * max(r[0], 0.0)
    projected = min(radius, max(-radius, r[1] - u[1] / w))
    return max(abs(min(u[0], W[0, 0] * r[0])), w * abs(projected - r[1]))


def scale(W, q, r):
    """Size of the terms in u = q + W r, and of the terms that a rounding of r moves."""
    return (np.abs(q).sum() + np.abs(np.array(W)).sum(axis=0) @ np.abs(r)).item()


@settings(max_examples=suites.size(100, long=1000))
@given(
    w=magnitude(1e-2, 1e2),
    ratio=magnitude(1e-4, 1e4),
    rho=st.floats(-0.9999, 0.9999),
    q=st.tuples(signed(1e-4, 1e2), signed(1e-4, 1e2)),
    mu=st.floats(0.0, 10.0),
)
@example(w=1.0, ratio=1.0, rho=0.99, q=(-1.0, 0.0), mu=10.0)
@example(w=1.0, ratio=1e-4, rho=-0.9999, q=(-1.0, 1.0), mu=10.0)
@example(w=1.0, ratio=1.0, rho=0.5, q=(-1.0, -0.5), mu=0.5)
def test_a_solution_exists_at_any_coupling_and_friction(w, ratio, rho, q, mu):
    """For a symmetric positive definite W, mu |W_nt| > W_nn included (Painlevé's paradox stays out in 2D impacts).

    The condition of the block, after scaling of its rows, is (1 + rho)/(1 - rho) <= 2e4; two solves of that condition
    and ten operations leave 2e4 * 10 * 2.2e-16 = 5e-11 of the terms.
    """
    w_tt = w * ratio
    w_nt = rho * math.sqrt(w * w_tt)
    W = ((w, w_nt), (w_nt, w_tt))
    r = react_in_plane(W, *q, mu)
    assert natural_map_error(W, q, mu, r) <= 5e-11 * scale(W, q, r)


@given(w=magnitude(1e-2, 1e2), w_t=magnitude(1e-2, 1e2), q=st.tuples(signed(1e-4, 1e2), signed(1e-4, 1e2)))
def test_without_friction_in_two_components_it_is_signorini(w, w_t, q):
    r_n, r_t = react_in_plane(((w, 0.0), (0.0, w_t)), *q, 0.0)
    assert r_n == max(0.0, -q[0] / w)
    assert r_t == 0.0


@given(
    w=magnitude(1e-2, 1e2),
    w_t=magnitude(1e-2, 1e2),
    q=st.tuples(signed(1e-4, 1e2), signed(1e-4, 1e2)),
    mu=st.floats(0.0, 10.0),
    tiny=st.floats(-1e-13, 1e-13),
)
def test_the_coupled_formula_meets_the_uncoupled_one(w, w_t, q, mu, tiny):
    """As W_nt goes to zero the branch with coupling gives what the short branch gives: no jump between the two kernels.

    Where the law's answer is Lipschitz its change is at most of the order of (1 + mu)^2 |W_nt|/W r, W being at most 1e4
    from round in both directions: 1e-13 * 121 * 1e4 * 10.
    """
    coupling = tiny * math.sqrt(w * w_t)
    plain = np.array(react_in_plane(((w, 0.0), (0.0, w_t)), *q, mu))
    coupled = np.array(react_in_plane(((w, coupling), (coupling, w_t)), *q, mu))
    size = (abs(q[0]) + abs(q[1])) / min(w, w_t)
    assert np.abs(plain - coupled).max() <= 1e-6 * size


def test_mirror_images_have_mirrored_answers():
    """Turning t round turns r_t round: exactly, where the solution is unique."""
    W = ((2.0, 0.7), (0.7, 1.0))
    mirrored = ((2.0, -0.7), (-0.7, 1.0))
    for q_t in (-3.0, -0.5, 0.0, 0.5, 3.0):
        r_n, r_t = react_in_plane(W, -1.0, q_t, 0.4)
        assert react_in_plane(mirrored, -1.0, -q_t, 0.4) == (r_n, -r_t)


@pytest.mark.parametrize(("q_t", "r_t"), [(1e-5, -0.2), (-1e5, 0.2), (0.0, 0.0)])
def test_where_no_impulse_changes_the_sliding_velocity_all_friction_acts(q_t, r_t):
    """W_tt = 0 leaves u_t = q_t, and mu = 0.4 of r_n = 1/2 acts against it."""
    assert react_in_plane(((2.0, 0.0), (0.0, 0.0)), -1.0, q_t, 0.4) == pytest.approx((0.5, r_t), rel=1e-15)


def test_bodies_that_no_impulse_moves_get_none():
    assert react_in_plane(((0.0, 0.0), (0.0, 0.0)), -1.0, 1.0, 0.4) == (0.0, 0.0)


@pytest.mark.parametrize(("q_t", "status"), [(0.0, "stick"), (0.299, "stick"), (0.301, "slide"), (-0.301, "slide")])
def test_it_slides_beyond_the_friction(q_t, status):
    """With W = I and a blow of 1 m/s, r_n = 1: it sticks up to |q_t| = mu = 0.3, and slides against u_t beyond."""
    r_n, r_t = Coulomb.react(((1.0, 0.0), (0.0, 1.0)), (-1.0, q_t), (0.0, 0.3))
    assert r_n == 1.0
    if status == "stick":
        assert r_t == -q_t
    else:
        assert r_t == -math.copysign(0.3, q_t)


def test_sliding_does_not_dilate():
    """The law is non-associated: a contact that slides fast closes at u_n = 0, it does not lift off at mu |u_t|."""
    r = np.array(Coulomb.react(((1.0, 0.0), (0.0, 1.0)), (-1.0, 50.0), (0.0, 0.8)))
    u = np.array([-1.0, 50.0]) + r
    assert u[0] == 0.0
    assert u[1] == 50.0 - 0.8


def test_an_open_gap_may_close_and_an_old_penetration_is_left():
    """bias = max(g, 0)/h: 1 mm in 1 ms may close at 1 m/s; -1 mm asks for nothing."""
    assert Coulomb.prepare(1e-3, 0.0, (0.0, 0.0), 1e-3, (0.3,), ()) == (1.0, 0.3)
    assert Coulomb.prepare(-1e-3, 0.0, (0.0, 0.0), 1e-3, (0.3,), ()) == (0.0, 0.3)


def test_a_frictionless_contact_has_one_row():
    assert Coulomb(friction=0.0).rows(2) == 1
    assert Coulomb(friction=0.1).rows(2) == 2
