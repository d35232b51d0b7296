"""Coulomb's law stands in five places, each for what it is asked: all are one law at the same hard points."""

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.laws.coulomb import react_in_plane, react_in_space
from lmgcpy.solve.newton.rows import natural_map
from lmgcpy.solve.problems.locked import within_cones
from lmgcpy.solve.problems.residual import project_on_cone

FRICTION = (0.0, 1e-12, 0.3, 1.0, 1e6)
WEIGHT = (1e-8, 1.0, 1e8)
SIZES = (0.0, 1e-16, 1.0 - 2.0**-52, 1.0, 1.0 + 2.0**-52, 3.0, 1e12)
"""Tangential velocities in parts of mu times the normal one (of it, if mu is 0): inside, on and outside the cone."""


def hard_points(dimension):
    """Free velocities (p, d), friction (p,) and weights (p,): open, touching, on the edge of the cone, at its tip."""
    points = []
    turns = [(1.0,), (-1.0,)] if dimension == 2 else [(1.0, 0.0), (0.6, -0.8), (0.0, -1.0)]
    for mu in FRICTION:
        for w in WEIGHT:
            for q_n in (-1.0, -1e-130, -0.0, 0.0, 1e-130, 1.0):
                for size in SIZES:
                    for turn in turns:
                        tangential = size * (mu if mu > 0.0 else 1.0) * (abs(q_n) if q_n else 1.0)
                        points.append(((q_n, *(tangential * t for t in turn)), mu, w))
    free, mu, weight = (np.array(column) for column in zip(*points, strict=True))
    return free, mu, weight


def by_react(free, mu, weight):
    """What sweeps do, for any block of W: here ``w I``."""
    found = []
    for q, m, w in zip(free.tolist(), mu.tolist(), weight.tolist(), strict=True):
        if len(q) == 2:
            found.append(react_in_plane(((w, 0.0), (0.0, w)), *q, m))
        else:
            found.append(react_in_space(((w, 0.0, 0.0), (0.0, w, 0.0), (0.0, 0.0, w)), *q, m))
    return np.array(found)


def problem_of(free, mu, weight):
    """One contact for each point, none of which meets another."""
    W = sparse.diags_array(np.repeat(weight, free.shape[1])).tocsr()
    m, d = free.shape
    more = {"laws": ("coulomb",) * m, "compliance": np.zeros(m), "guess": np.zeros((m, d))}
    return lm.Problem(W=W, q=free.ravel(), mu=mu, dimension=d, **more)


@pytest.mark.parametrize("dimension", [2, 3])
def test_all_are_one_law(dimension):
    free, mu, weight = hard_points(dimension)
    r = by_react(free, mu, weight)
    problem = problem_of(free, mu, weight)
    scale = np.abs(free).max(axis=1) / weight

    def agree(found, what):
        # each takes a handful of operations, rounded to 1.1e-16 of their terms each
        worst = np.abs(found - r).max(axis=1) / np.maximum(scale, 1e-300)
        assert worst.max() <= 4e-15, (what, free[worst.argmax()], mu[worst.argmax()], weight[worst.argmax()])

    agree(problem.react(free, weight), "the residual of problems, on arrays")
    error, kind, count = np.empty_like(r), np.empty(len(r), np.int64), len(r)
    status = kind, np.empty((count, dimension - 1)), np.empty((count, 1))
    nothing = np.zeros(count)
    natural_map(free, np.zeros_like(r), weight, mu[:, None], nothing, nothing, problem.cones, dimension, error, *status)
    agree(-error / weight[:, None], "the map of Newton steps, which also names the status")
    # De Saxce: w r - (u + mu |u_t| n) projected on the cone is w r, if and only if r solves the law
    u = free + weight[:, None] * r
    shifted = u.copy()
    shifted[:, 0] += mu * np.linalg.norm(u[:, 1:], axis=1)
    moderate = mu <= 1.0  # a shift of 1e6 times the sliding velocity leaves 1e-10 of the normal component
    projected = project_on_cone(weight[:, None] * r - shifted, mu) / weight[:, None]
    worst = np.abs(projected - r).max(axis=1)[moderate] / np.maximum(scale[moderate], 1e-300)
    assert worst.max() <= 4e-15
    np.testing.assert_allclose(within_cones(problem, r), r, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_law_itself_holds_at_these_points(dimension):
    """Signorini and Coulomb, read off (u, r), so that the five are not wrong together."""
    free, mu, weight = hard_points(dimension)
    r = by_react(free, mu, weight)
    u = free + weight[:, None] * r
    scale = np.abs(free).max(axis=1)
    assert (r[:, 0] >= 0.0).all()
    assert (u[:, 0] >= -1e-15 * scale).all()
    assert (np.abs(u[:, 0] * weight * r[:, 0]) <= 1e-15 * scale**2).all()
    size = np.linalg.norm(r[:, 1:], axis=1)
    assert (size <= mu * r[:, 0] * (1.0 + 1e-15)).all()
    sliding = np.linalg.norm(u[:, 1:], axis=1)
    slides = (sliding > 4e-15 * scale) & (r[:, 0] > 0.0)
    np.testing.assert_allclose(size[slides], (mu * r[:, 0])[slides], rtol=1e-12)
    power = (u[:, 1:] * r[:, 1:]).sum(axis=1)
    np.testing.assert_allclose(power[slides], -(sliding * size)[slides], rtol=1e-12)
