"""The bound on the motion of a solution, and the certificate that there is none."""

import math

import numpy as np
import pytest
import scipy.sparse as sparse
from test_random_problems import drawn

import lmgcpy as lm
from lmgcpy.solve.problems.locked import least_motion, within_cones
from lmgcpy.solve.problems.problem import Split


@pytest.mark.default_parameters("0.6-2")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_a_solution_moves_at_least_as_much_as_the_bound_tells(dimension, friction):
    """30 problems each, solved to 1e-9: the kinetic norm of what the impulses do is not below the bound."""
    told = 0
    for seed in range(30):
        problem = drawn(seed, dimension, friction, bodies=6, interactions=9)
        solution = lm.solve(problem, solver=lm.Auto(tolerance=1e-9))
        if solution.status != "converged":
            continue
        x = solution.impulses.ravel()
        bound = least_motion(problem, solution.impulses).norm
        assert bound <= math.sqrt(x @ (problem.W @ x)) * (1.0 + 1e-6)
        told += bound > 0.0
    assert told >= 10


@pytest.mark.default_parameters(seed=(0, 1))
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_problem_without_a_solution_is_found_out(seed, dimension):
    """A bead between two fixed planes that close on it, beside a problem that has a solution: of the impulses that sweeps
    leave those of the bead remain, equal on both sides."""
    rng = np.random.default_rng(seed)
    d = dimension
    sound = drawn(seed, d, 0.5, bodies=6, interactions=9)
    mass = 10.0 ** rng.uniform(-3.0, 3.0)
    between = np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag([1.0] + [0.0] * (d - 1)))
    between += np.diag(np.tile([0.0] + [3.0] * (d - 1), 2))  # across the gap each plane's bead turns by itself
    W = sparse.block_diag([sound.W, between / mass], format="csr")
    q = np.concatenate([sound.q, np.tile([-0.1] + [0.0] * (d - 1), 2)])
    laws = (*sound.laws, "coulomb", "coulomb")
    problem = lm.Problem(W, q, np.append(sound.mu, [0.5, 0.5]), d, laws, np.zeros(11), np.zeros((11, d)))
    solution = lm.solve(problem, solver=lm.GaussSeidel(tolerance=1e-6, max_iterations=1000))
    assert solution.status == "budget spent"
    bound = least_motion(problem, solution.impulses)
    assert bound.norm > 1e3
    size = np.linalg.norm(bound.stress, axis=1)
    assert size[:9].max() < 1e-5 * size[9:].min()
    assert size[9] == pytest.approx(size[10], rel=1e-6)
    assert least_motion(sound, np.zeros((9, d))).norm < 1e3


@pytest.mark.parametrize("seed", range(3))
def test_a_cell_that_yields_does_not_make_the_matrix_dense(seed):
    """The part of a cell in W, columns columns^T, is kept apart: the same motion as with W as a whole."""
    rng = np.random.default_rng(seed)
    sound = drawn(seed, 2, 0.5, bodies=6, interactions=9)
    between = np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), np.diag([1.0, 0.0])) + np.diag([0.0, 3.0] * 2)
    bodies = sparse.block_diag([sound.W, between], format="csr")
    columns = rng.normal(size=(22, 2))
    columns[-4:] = 0.0  # the cell does not move the bead, which stays locked
    W = sparse.csr_array(bodies + columns @ columns.T)
    laws, none, at_rest = (*sound.laws, "coulomb", "coulomb"), np.zeros(11), np.zeros((11, 2))
    given = W, np.concatenate([sound.q, [-0.1, 0.0] * 2]), np.append(sound.mu, [0.5, 0.5]), 2, laws, none, at_rest
    whole, apart = lm.Problem(*given), lm.Problem(*given, split=Split(sparse.csr_array(bodies), columns))
    impulses = lm.solve(whole, solver=lm.GaussSeidel(tolerance=1e-6, max_iterations=1000)).impulses
    one, other = least_motion(whole, impulses), least_motion(apart, impulses)
    assert one.norm > 1e3
    assert other.norm == pytest.approx(one.norm, rel=1e-3)
    np.testing.assert_allclose(other.stress, one.stress, atol=1e-6 * np.abs(one.stress).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_brought_into_the_cones_is_the_nearest_there(dimension):
    """The projection p of x on a convex cone is in it, x - p is in the polar cone, and both are orthogonal."""
    problem = drawn(3, dimension, 0.7, bodies=8, interactions=40)
    x = np.random.default_rng(1).normal(size=(40, dimension))
    x[problem.cones != 0, 1:] = 0.0
    p = within_cones(problem, x)
    contact = problem.cones == 0
    size = np.linalg.norm(p[contact, 1:], axis=1)
    assert (size <= problem.mu[contact] * p[contact, 0] + 1e-12).all()
    assert (p[~contact, 0] <= 0.0).all()
    left = x - p
    np.testing.assert_allclose((left * p).sum(axis=1), 0.0, atol=1e-12)
    across = np.linalg.norm(left[contact, 1:], axis=1)
    assert (left[contact, 0] <= -problem.mu[contact] * across + 1e-12).all()
    np.testing.assert_array_equal(within_cones(problem, p), within_cones(problem, within_cones(problem, p)))


def test_a_link_between_driven_bodies_is_a_self_stress_of_its_own():
    """Where W is zero any impulse is in balance, and one against the velocity of the link does work."""
    W, none = sparse.csr_array((2, 2)), np.zeros(1)
    problem = lm.Problem(W, np.array([-0.1, 0.0]), none, 2, ("rigid-rod",), none, np.zeros((1, 2)))
    assert least_motion(problem, np.zeros((1, 2))).norm > 1e6
