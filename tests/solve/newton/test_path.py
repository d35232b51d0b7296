"""Paths to the solutions of proximal problems in the plane."""

from itertools import product

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.bench.cases import in_the_plane
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.path import RENEW, Derivative, follow_path

EPSILON = 1e-3


def problem(W, q, mu, laws, compliance):
    return lm.Problem(
        W=sparse.csr_array(W), q=q, mu=mu, dimension=2, laws=laws, compliance=compliance, guess=np.zeros((len(mu), 2))
    )


def random_problem(seed, contacts=3):
    """Contacts, one of them smooth, a wire and a rod, with full coupling and less rank than rows."""
    rng = np.random.default_rng(seed)
    laws = ("coulomb",) * contacts + ("rigid-wire", "elastic-rod")
    count = len(laws)
    H = rng.standard_normal((2 * count - 3, 2 * count))
    mu = np.concatenate([rng.uniform(0.1, 1.5, contacts - 1), np.zeros(3)])
    compliance = np.zeros(count)
    compliance[-1] = 0.3
    return problem(H.T @ H, rng.standard_normal(2 * count), mu, laws, compliance)


def every_solution(active, epsilon, centre):
    """All solutions of the proximal problem, by a dense solve for every combination of statuses: the laws written out."""
    p = active.problem
    w = np.repeat(active.weight, 2)
    A, b = p.W.toarray() + epsilon * np.diag(w), p.q - epsilon * w * centre.ravel()
    choices = {"coulomb": "os+-", "rigid-wire": "ot", "elastic-rod": "t"}
    found = []
    for statuses in product(*(choices[law] for law in p.laws)):
        E, rows, C = [], [], []
        for i, status in enumerate(statuses):
            unit = np.eye(len(b))
            if status == "o":
                continue
            slope = {"+": 1.0, "-": -1.0}.get(status, 0.0) * p.mu[i]
            E.append(unit[2 * i] + slope * unit[2 * i + 1])
            rows.append(2 * i)
            C.append(p.compliance[i])
            if status == "s" and p.mu[i] > 0.0:
                E.append(unit[2 * i + 1])
                rows.append(2 * i + 1)
                C.append(0.0)
        E = np.array(E).reshape(-1, len(b)).T
        x = np.linalg.solve((A @ E)[rows] + np.diag(C), -b[rows])
        r = E @ x
        u = (A @ r + b).reshape(-1, 2)
        r = r.reshape(-1, 2)
        holds = True
        for i, (law, status) in enumerate(zip(p.laws, statuses, strict=True)):
            if law == "coulomb":
                holds &= u[i, 0] > -1e-9 and r[i, 0] > -1e-9 and abs(r[i, 1]) < p.mu[i] * r[i, 0] + 1e-9
                holds &= status not in "+-" or r[i, 1] * u[i, 1] < 1e-9
            elif law == "rigid-wire":
                holds &= r[i, 0] < 1e-9 and u[i, 0] < 1e-9
        if holds:
            found.append(r)
    return found


@pytest.mark.long
def test_a_path_ends_at_one_of_all_solutions():
    """Random problems of five interactions, 2^1 4^2 2 = 64 sets of statuses, from random starts and centres."""
    reached = 0
    for seed in range(150):
        active = ActiveSet(random_problem(seed))
        rng = np.random.default_rng(1000 + seed)
        start, centre = rng.standard_normal((2, 5, 2))
        solutions = every_solution(active, EPSILON, centre)
        assert solutions, seed  # epsilon w makes W positive definite
        path = follow_path(active, start, EPSILON, centre, 500)
        if path.impulses is not None:
            reached += 1
            scale = max(np.abs(path.impulses).max(), 1.0)
            assert min(np.abs(path.impulses - r).max() for r in solutions) < 1e-8 * scale, seed
    assert reached >= 145  # a path from a start of chance may come back to a large rest


def test_a_path_turns_back_where_a_solution_ceases_to_exist():
    """One contact with ``mu W_nt > W_nn``: open and sliding solutions end together at q_n = 0, where q_n falls and sliding
    closes what would open. Beyond it only sticking is left, ``r = -W^-1 q`` but for epsilon."""
    W, q, mu = np.array([[1.0, 2.0], [2.0, 5.0]]), np.array([-0.1, 1.0]), 2.0
    active = ActiveSet(problem(W, q, np.array([mu]), ("coulomb",), np.zeros(1)))
    still = np.zeros((1, 2))
    path = follow_path(active, np.array([[-1.0, -1.0]]), 1e-9, still, 10)
    assert path.bends == 2  # open, sliding, sticking: nothing else lies between
    assert path.impulses == pytest.approx(-np.linalg.solve(W, q)[None], rel=1e-6)
    assert path.impulses[0] == pytest.approx(lm.solve_local(W, q, friction=mu).impulse, rel=1e-6)


def test_a_path_that_bends_too_often_is_given_up():
    active = ActiveSet(random_problem(0))
    start = np.random.default_rng(3).standard_normal((5, 2))
    needs = follow_path(active, start, EPSILON, np.zeros((5, 2)), 500).bends
    assert needs > 1
    assert follow_path(active, start, EPSILON, np.zeros((5, 2)), needs).impulses is not None
    short = follow_path(active, start, EPSILON, np.zeros((5, 2)), needs - 1)
    assert short.impulses is None
    assert short.bends == needs - 1


def test_long_paths_are_as_exact_as_short_ones():
    """Through several factorisations: what a path ends with satisfies the proximal problem to round-off."""
    rng = np.random.default_rng(5)
    count = 150
    H = rng.standard_normal((2 * count, 2 * count))
    active = ActiveSet(
        problem(H.T @ H, rng.standard_normal(2 * count), np.full(count, 0.3), ("coulomb",) * count, np.zeros(count))
    )
    centre = np.zeros((count, 2))
    path = follow_path(active, 3.0 * rng.standard_normal((count, 2)), 0.1, centre, 2000)
    assert path.bends > 2 * RENEW
    error = np.linalg.norm(active.error(path.impulses, 0.1, centre)[0])
    assert error < 1e-10 * active.nothing


@pytest.mark.long
def test_a_locked_step_of_sand_is_solved_to_the_last_digits():
    """Newton steps with sweeps alone stop at 1e-6 to 1e-4 here, for thousands of factorisations."""
    step = next(in_the_plane()).problem
    for solver in (lm.Auto(tolerance=1e-10), lm.Newton(tolerance=1e-10)):
        solution = lm.solve(step, solver=solver)
        assert lm.residual(step, solution.impulses) <= 1e-10


def test_a_bend_into_a_singular_cell_is_an_error_that_ends_the_path():
    """Sherman-Morrison divides by 1 + wall . change, which is 0 in exact arithmetic where a cell is singular, as in regular
    packings: numpy warned the user of a division, and the path went on with what is not finite."""
    active = ActiveSet(problem(np.array([[2.0, 0.5], [0.5, 2.0]]), np.array([-1.0, 0.3]), [0.4], ("coulomb",), [0.0]))
    jump, along = np.array([1.0, 0.0]), np.ones((1, 2))
    status = active.error(active.problem.guess, EPSILON, active.problem.guess)[1]

    def bent(wall):
        matrix = Derivative(active, status, EPSILON)
        return matrix, matrix.bend(0, wall, jump, along)

    matrix, _ = bent(np.zeros(2))  # no bend: the change is that of the jump alone
    change = matrix._changes[0, 0, 0]
    assert 1.0 + (-1.0 / change) * change == 0.0  # exactly
    with pytest.raises(RuntimeError, match="singular"):
        bent(np.array([-1.0 / change, 0.0]))
    assert np.isfinite(bent(np.array([-0.5 / change, 0.0]))[1][0]).all()
