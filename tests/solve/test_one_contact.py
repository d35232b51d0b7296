"""One contact by itself: every block without negative eigenvalues has a solution or is told to have none."""

import math

import numpy as np
import pytest
import suites
from hypothesis import given, settings
from hypothesis import strategies as st

import lmgcpy as lm
from lmgcpy.compiled.kernel import kernel
from lmgcpy.laws import coulomb
from lmgcpy.laws.coulomb import react_by_bracket, react_in_plane, react_in_space

COUNT = suites.size(10_000, long=100_000)


@kernel
def solve_plane(W, q, friction, impulse):
    for i in range(q.shape[0]):
        block = ((W[i, 0, 0], W[i, 0, 1]), (W[i, 1, 0], W[i, 1, 1]))
        impulse[i, 0], impulse[i, 1] = react_in_plane(block, q[i, 0], q[i, 1], friction[i])


@kernel
def solve_space(W, q, friction, impulse):
    for i in range(q.shape[0]):
        block = (
            (W[i, 0, 0], W[i, 0, 1], W[i, 0, 2]),
            (W[i, 1, 0], W[i, 1, 1], W[i, 1, 2]),
            (W[i, 2, 0], W[i, 2, 1], W[i, 2, 2]),
        )
        impulse[i, 0], impulse[i, 1], impulse[i, 2] = react_in_space(block, q[i, 0], q[i, 1], q[i, 2], friction[i])


def solve_all(W, q, friction, r):
    (solve_plane if q.shape[1] == 2 else solve_space)(W, q, friction, r)


def of_rank(rank, dimension, count, rng):
    """Blocks ``G G^T`` of so many columns, singular if those are fewer than the rows."""
    G = rng.normal(size=(count, dimension, rank))
    return np.einsum("mik,mjk->mij", G, G)


def faults(W, q, friction, r):
    """How far each contact is from the law, in u_n and in sliding against friction, relative to the terms of q + W r."""
    u = q + np.einsum("mij,mj->mi", W, r)
    terms = np.abs(q).max(axis=1) + np.einsum("mij,mj->mi", np.abs(W), np.abs(r)).max(axis=1)
    limit, size, speed = friction * r[:, 0], np.linalg.norm(r[:, 1:], axis=1), np.linalg.norm(u[:, 1:], axis=1)
    assert np.isfinite(r).all()
    assert (r[:, 0] >= 0.0).all()
    assert (size <= limit * (1.0 + 1e-14)).all()
    normal = np.where(r[:, 0] > 0.0, np.abs(u[:, 0]), np.maximum(-u[:, 0], 0.0))
    inside = np.where(size < limit * (1.0 - 1e-9), speed, 0.0)  # then it sticks
    against = np.linalg.norm(u[:, 1:] * limit[:, None] + speed[:, None] * r[:, 1:], axis=1) / np.where(
        limit > 0, limit, 1.0
    )
    return np.max([normal, inside, np.where((r[:, 0] > 0.0) & (limit > 0.0), against, 0.0)], axis=0) / terms


def has_root(W, q, mu):
    """Whether a sliding solution exists, from the roots of a polynomial in l, ``u_t = -l r_t``: an independent way.

    With ``D(l) = det(S + l I)`` and ``N(l) = -adj(S + l I) f``, ``r_t = N/D`` and ``W_nn r_n = -q_n - W_nt . r_t``; the
    equation ``|r_t|^2 = mu^2 r_n^2`` times ``D^2`` is of degree four.
    """
    S = W[1:, 1:] - np.outer(W[1:, 0], W[0, 1:]) / W[0, 0]
    f = q[1:] - W[1:, 0] * q[0] / W[0, 0]
    D = np.poly1d([1.0, S[0, 0] + S[1, 1], S[0, 0] * S[1, 1] - S[0, 1] ** 2])
    N = np.poly1d([-f[0], S[0, 1] * f[1] - S[1, 1] * f[0]]), np.poly1d([-f[1], S[0, 1] * f[0] - S[0, 0] * f[1]])
    normal = -(D * q[0] + N[0] * W[0, 1] + N[1] * W[0, 2]) / W[0, 0]
    roots = (N[0] * N[0] + N[1] * N[1] - normal * normal * mu**2).roots
    real = roots[(np.abs(roots.imag) < 1e-9 * np.abs(roots)) & (roots.real > 1e-9 * np.trace(W))].real
    return any(normal(l) / D(l) >= 0.0 for l in real)


@pytest.mark.scaled
@pytest.mark.parametrize("most_friction", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_positive_definite_block_always_has_a_solution(dimension, most_friction):
    """Six times 10 000, or 100 000; those of a condition above 1e9 lose digits to it and are left out (one in 200)."""
    rng = np.random.default_rng(1)
    W = of_rank(dimension, dimension, COUNT, rng)
    kept = np.linalg.cond(W) < 1e9
    assert kept.mean() > 0.99
    W, q = W[kept], rng.normal(size=(kept.sum(), dimension))
    friction = rng.uniform(0.0, most_friction, len(W))
    r = np.zeros_like(q)
    solve_all(W, q, friction, r)
    assert faults(W, q, friction, r).max() < 1e-9


@pytest.mark.scaled
@pytest.mark.parametrize("rank", [1, 2])
def test_a_singular_block_that_can_be_brought_to_rest_is_solved(rank):
    """``q`` in the range of W, as where it is the velocity of bodies: 20 000 blocks, or 200 000, friction to 10."""
    rng = np.random.default_rng(2)
    W = of_rank(rank, 3, COUNT, rng)
    q = np.einsum("mij,mj->mi", W, rng.normal(size=(COUNT, 3)))
    friction = rng.uniform(0.0, 10.0, COUNT)
    r = np.zeros_like(q)
    solve_all(W, q, friction, r)
    # measured 8e-14: round-off of the singular part, over the eigenvalue that is left
    assert faults(W, q, friction, r).max() < 1e-11


@pytest.mark.default_parameters("2")
@pytest.mark.scaled
@pytest.mark.parametrize("rank", [1, 2])
def test_any_other_singular_block_is_solved_or_has_no_solution(rank):
    """Those not solved have none, by the roots of a polynomial; friction to 3, 10 000 blocks, or 100 000."""
    rng = np.random.default_rng(3)
    W, q = of_rank(rank, 3, COUNT, rng), rng.normal(size=(COUNT, 3))
    friction = rng.uniform(0.0, 3.0, COUNT)
    r = np.zeros_like(q)
    solve_all(W, q, friction, r)
    unsolved = np.flatnonzero(faults(W, q, friction, r) > 1e-6)
    assert 0.01 < len(unsolved) / COUNT < 0.5
    for i in unsolved:
        assert not has_root(W[i], q[i], friction[i]), i
        assert np.abs(r[i, 1:]).max() == 0.0


def blocks(count, spread, rng):
    """Symmetric positive definite blocks with eigenvalues over ``spread``, in any directions."""
    turn, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    W = np.einsum("mij,mj,mkj->mik", turn, np.exp(rng.uniform(-0.5, 0.5, (count, 3)) * np.log(spread)), turn)
    return 0.5 * (W + W.transpose(0, 2, 1))


@pytest.mark.scaled
@pytest.mark.parametrize("most_friction", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("spread", [1.0, 1e2, 1e4, 1e6])
def test_the_local_problem_is_solved(spread, most_friction):
    """Each condition of the law by itself, for full blocks; errors relative to the terms of ``q + W r``. The tangential
    velocity loses the digits of the condition of W and of the slope of the root in mu."""
    rng = np.random.default_rng(0)
    count = COUNT
    W, q = blocks(count, spread, rng), rng.normal(size=(count, 3))
    friction = rng.uniform(0.0, most_friction, count)
    r = np.zeros((count, 3))
    solve_all(W, q, friction, r)
    u = q + np.einsum("mij,mj->mi", W, r)
    scale = np.linalg.norm(q, axis=1) + np.einsum("mij,mj->mi", np.abs(W), np.abs(r)).max(axis=1)
    limit = friction * r[:, 0]
    size = np.linalg.norm(r[:, 1:], axis=1)
    acting = r[:, 0] > 0.0
    assert 0.45 < acting.mean() < 0.55
    assert np.all(r[:, 0] >= 0.0)
    assert np.all(u[~acting, 0] >= 0.0)
    assert np.all(np.abs(u[acting, 0]) <= 1e-11 * scale[acting])
    assert np.all(size <= limit * (1.0 + 1e-14))
    sliding = np.linalg.norm(u[:, 1:], axis=1) > 1e-10 * scale
    slide = acting & sliding
    assert slide.sum() > COUNT // 100
    assert size[slide] == pytest.approx(limit[slide], rel=1e-12)
    power = np.einsum("mi,mi->m", u[slide, 1:], r[slide, 1:])
    most = np.linalg.norm(u[slide, 1:], axis=1) * size[slide]
    # the directions are opposite: an angle of a leaves a^2/2 of the power, and u_t may be 1e-10 of its terms
    assert np.all(power <= -most * (1.0 - 1e-6) + 1e-11 * scale[slide] * size[slide])


solve_by_bracket = solve_space.specialise(react_in_space=react_by_bracket)


def with_one_root(W, friction):
    """Which blocks have ``mu |k| tr S < 2 sqrt(det S)``; k and S as of ``react_to_full_block``."""
    k = W[:, 0, 1:] / W[:, 0, :1]
    S = W[:, 1:, 1:] - W[:, 0, :1, None] * k[:, :, None] * k[:, None, :]
    one = friction * np.linalg.norm(k, axis=1) * np.trace(S, axis1=1, axis2=2) < 2.0 * np.sqrt(np.linalg.det(S))
    return k, S, one


@pytest.mark.parametrize("spread", [1.0, 10.0, 1e2, 1e6])
def test_newton_steps_find_what_a_bracket_finds(spread):
    """For blocks with one root ``|r_t| - mu r_n`` falls over all l, and both ways lead to the same impulse. With a spread
    of 1 couplings are round-off, as those of spheres among bodies that turn."""
    rng = np.random.default_rng(7)
    W = blocks(COUNT, spread, rng)
    q, friction = rng.normal(size=(COUNT, 3)), 10.0 ** rng.uniform(-2.0, 0.5, COUNT)
    q[:, 0] = -np.abs(q[:, 0])
    k, S, one = with_one_root(W, friction)
    assert one.sum() > COUNT // 4
    alone, free = -q[:, 0] / W[:, 0, 0], q[:, 1:] - k * q[:, :1]
    above = []
    for slowness in np.r_[0.0, np.geomspace(1e-7, 1e7, 60)]:
        r_t = -np.linalg.solve(S + slowness * np.eye(2), free[:, :, None])[:, :, 0]
        above.append(np.linalg.norm(r_t, axis=1) - friction * (alone - (k * r_t).sum(axis=1)))
    assert (np.diff(above, axis=0) <= 1e-12 * (np.abs(above[0]) + friction * alone))[:, one].all()  # round-off
    r, same = np.zeros((COUNT, 3)), np.zeros((COUNT, 3))
    solve_space(W, q, friction, r)
    solve_by_bracket(W, q, friction, same)
    # measured 1e-15; both miss the root by round-off, times the condition of S
    far = np.abs(r - same).max(axis=1) / (np.abs(same).max(axis=1) * np.linalg.cond(S))
    assert far[one].max() < 1e-14


@pytest.mark.parametrize(("spread", "steps", "left"), [(1.0, 1, 0.01), (3.0, 4, 0.01), (100.0, 6, 0.1)])
def test_newton_steps_are_few(monkeypatch, spread, steps, left):
    """With so many steps a bracket is left for some contacts with one root: those that pull if they stick, r_n < 0."""
    W, rng = blocks(500, spread, np.random.default_rng(8)), np.random.default_rng(9)
    q = rng.normal(size=(500, 3))
    q[:, 0] = -np.abs(q[:, 0])
    monkeypatch.setattr(coulomb, "NEWTON_STEPS", steps)
    monkeypatch.setattr(coulomb, "react_by_bracket", lambda *given: None)
    one = with_one_root(W, np.full(500, 0.3))[2]
    found = [react_in_space(block, *free, 0.3) for block, free in zip(W[one].tolist(), q[one].tolist(), strict=True)]
    assert len(found) > 250
    assert found.count(None) <= left * len(found)


@pytest.mark.parametrize("case", ["no friction", "stiff along s", "stiff along n", "at rest", "tiny", "huge"])
def test_degenerate_blocks(case):
    W, q, friction = np.eye(3), np.array([-1.0, 0.5, -0.3]), 0.4
    if case == "no friction":
        W[0, 1] = W[1, 0] = 0.3
        friction = 0.0
    elif case == "stiff along s":
        W[2, 2], W[0, 2], W[2, 0] = 1e12, 1e5, 1e5
    elif case == "stiff along n":
        W[0, 0], W[0, 1], W[1, 0] = 1e12, 1e5, 1e5
    elif case == "at rest":
        q[:] = 0.0
    else:
        W *= 1e-200 if case == "tiny" else 1e200
    r = np.array(react_in_space(tuple(map(tuple, W.tolist())), *q.tolist(), friction))
    assert np.isfinite(r).all()
    assert np.hypot(*r[1:]) <= friction * r[0] * (1.0 + 1e-14)
    if q[0] < 0.0:
        assert (q + W @ r)[0] == pytest.approx(0.0, abs=1e-10)


EYE = np.eye(3)
NO_WAY = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
"""As Painleve's rod on rough ground: friction along t presses it in faster than the normal impulse pushes it out."""


@pytest.mark.parametrize(
    ("W", "q", "friction", "status", "impulse"),
    [
        (EYE, (1.0, 1.0, 0.0), 0.5, "open", (0.0, 0.0, 0.0)),
        (EYE, (-1.0, 0.1, 0.0), 0.5, "stick", (1.0, -0.1, 0.0)),
        (EYE, (-1.0, 3.0, 4.0), 0.5, "slide", (1.0, -0.3, -0.4)),
        (EYE, (-1.0, 3.0, 4.0), 0.0, "slide", (1.0, 0.0, 0.0)),
        (np.diag([1e12, 1.0, 2.0]), (-1e12, 0.1, 0.2), 0.5, "stick", (1.0, -0.1, -0.1)),
        (np.diag([1.0, 1e-12, 2.0]), (-1.0, 1e-13, 0.2), 0.5, "stick", (1.0, -0.1, -0.1)),
        (np.diag([1.0, 0.0, 0.0]), (-1.0, 3.0, 4.0), 0.5, "slide", (1.0, -0.3, -0.4)),
        (np.diag([1.0, 0.0, 0.0]), (-1.0, 0.0, 0.0), 0.5, "stick", (1.0, 0.0, 0.0)),
        (np.diag([1.0, 0.0, 2.0]), (-1.0, 0.0, 0.5), 0.5, "stick", (1.0, 0.0, -0.25)),
        (np.diag([0.0, 1.0, 1.0]), (-1.0, 0.5, 0.0), 0.5, "infeasible", (0.0, 0.0, 0.0)),
        (np.diag([0.0, 1.0, 1.0]), (0.0, 0.5, 0.0), 0.5, "open", (0.0, 0.0, 0.0)),
        (np.zeros((3, 3)), (-1.0, 0.5, 0.0), 0.5, "infeasible", (0.0, 0.0, 0.0)),
        (NO_WAY, (-1.0, 1.0, 0.0), 2.0, "infeasible", (1.0, 0.0, 0.0)),
        (NO_WAY, (-1.0, 1.0, 0.0), 0.5, "slide", (2.0, -1.0, 0.0)),
        (np.eye(2), (-1.0, 3.0), 0.5, "slide", (1.0, -0.5)),
        (np.diag([1.0, 0.0]), (-1.0, 0.0), 0.5, "stick", (1.0, 0.0)),
        (np.diag([1.0, 0.0]), (-1.0, 3.0), 0.5, "slide", (1.0, -0.5)),
        (np.diag([0.0, 1.0]), (-1.0, 0.5), 0.5, "infeasible", (0.0, 0.0)),
        (NO_WAY[:2, :2], (-1.0, 1.0), 2.0, "infeasible", (1.0, 0.0)),
        (NO_WAY[:2, :2], (-1.0, 1.0), 0.5, "slide", (2.0, -1.0)),
    ],
)
def test_one_contact(W, q, friction, status, impulse):
    found = lm.solve_local(W, q, friction=friction)
    assert found.status == status
    assert np.isfinite(found.impulse).all()
    assert found.impulse == pytest.approx(impulse, abs=1e-12)
    assert found.velocity == pytest.approx(np.asarray(q) + np.asarray(W) @ found.impulse)


sides = st.floats(-1e3, 1e3, allow_subnormal=False)


@settings(max_examples=suites.size(60, long=300))
@given(G=st.lists(sides, min_size=9, max_size=9), q=st.lists(sides, min_size=3, max_size=3), friction=st.floats(0.0, 10.0))
def test_every_answer_is_finite_and_in_the_cone(G, q, friction):
    """Zeros, equal rows and huge ratios among the entries, as hypothesis likes them."""
    root = np.array(G).reshape(3, 3)
    found = lm.solve_local(root @ root.T, q, friction=friction)
    r = found.impulse
    assert np.isfinite(r).all()
    assert r[0] >= 0.0
    # below 1e-150 squares have no digits left, of the solver's as well: there it may stick without friction
    assert math.hypot(r[1], r[2]) <= friction * r[0] * (1.0 + 1e-12) + 1e-150


def test_what_is_no_block_is_told():
    with pytest.raises(ValueError, match=r"W must have shape \(2, 2\) or \(3, 3\)"):
        lm.solve_local(np.eye(4), np.zeros(4), friction=0.5)
    with pytest.raises(ValueError, match="W must be symmetric"):
        lm.solve_local([[1.0, 0.5], [0.0, 1.0]], (-1.0, 0.0), friction=0.5)
    with pytest.raises(ValueError, match="no negative eigenvalue, got -1"):
        lm.solve_local(np.diag([1.0, -1.0]), (-1.0, 0.0), friction=0.5)
