"""Paths to the solutions of proximal problems in space."""

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.solve.newton.active_set import ActiveSet, Status
from lmgcpy.solve.newton.path import Derivative
from lmgcpy.solve.newton.path_3d import follow_curve, map_of
from lmgcpy.solve.newton.proximal import solution_by_path
from lmgcpy.solve.newton.rows import LINK, OPEN, SLIDE, STICK

EPSILON = 1e-3


def problem(W, q, mu, laws=None):
    count = len(mu)
    laws = laws or ("coulomb",) * count
    return lm.Problem(
        W=sparse.csr_array(W),
        q=q,
        mu=mu,
        dimension=3,
        laws=laws,
        compliance=np.zeros(count),
        guess=np.zeros((count, 3)),
    )


def random_problem(seed, contacts=8):
    """Contacts, one of them smooth, a wire and a rod, with full coupling and less rank than rows."""
    rng = np.random.default_rng(seed)
    count = contacts + 2
    H = rng.standard_normal((3 * count - 4, 3 * count))
    mu = np.concatenate([rng.uniform(0.1, 1.5, contacts - 1), np.zeros(3)])
    laws = ("coulomb",) * contacts + ("rigid-wire", "rigid-rod")
    return problem(H.T @ H, rng.standard_normal(3 * count), mu, laws)


def test_map_and_its_matrix():
    """F(a), written out, has the derivative that the factors of a Newton step solve with: by finite differences."""
    active = ActiveSet(random_problem(0))
    rng = np.random.default_rng(1)
    a, centre, d = rng.standard_normal((3, 10, 3))
    a[:, 0] += 0.5
    w = active.weight[:, None]
    error, cell = active.natural(-w * a, np.zeros_like(a))
    r = -error / w  # react(w I, -w a), by the kernel of Newton steps
    assert {OPEN, STICK, SLIDE} <= set(cell.kind)
    at, status = map_of(active, a, cell.kind, EPSILON, centre)
    assert at == pytest.approx(active.velocities(r, EPSILON, centre) - w * (r - a), abs=1e-12)
    ahead, _ = map_of(active, a + 1e-6 * d, cell.kind, EPSILON, centre)
    change = Derivative(active, status, EPSILON).step((ahead - at) / 1e-6)
    assert change == pytest.approx(d, abs=1e-4)  # second order in 1e-6, times the condition of the matrix


def test_the_sign_is_that_of_the_determinant():
    """Of the derivative of F, whose inverse is built column by column."""
    for seed in range(20):
        active = ActiveSet(random_problem(seed))
        a, centre = np.random.default_rng(seed).standard_normal((2, 10, 3))
        kind = active.natural(-active.weight[:, None] * a, np.zeros_like(a))[1].kind
        matrix = Derivative(active, map_of(active, a, kind, EPSILON, centre)[1], EPSILON)
        inverse = [matrix.step(unit.reshape(a.shape)).ravel() for unit in np.eye(a.size)]
        assert matrix.sign == np.linalg.slogdet(np.array(inverse))[0]


def test_a_bend_changes_the_derivative_to_that_behind_the_wall():
    """As it is when factorised there anew, whichever status gives way to which; on the way there one interaction moves, and
    does not turn, as the model of the others is not made anew."""
    passed = set()
    for seed in range(120):
        active = ActiveSet(random_problem(seed))
        a, given, centre = np.random.default_rng(seed).standard_normal((3, 10, 3))
        kind = active.natural(-active.weight[:, None] * a, np.zeros_like(a))[1].kind
        status = map_of(active, a, kind, EPSILON, centre)[1]
        matrix = Derivative(active, status, EPSILON)
        along, mover, outward = np.zeros_like(a), seed % 10, 1.0 if seed % 20 < 10 else -1.0
        along[mover] = outward, *(-outward * a[mover, 1:] / np.linalg.norm(a[mover, 1:]))
        i, disk, reach, _ = active.next_wall(a, along, kind, status.direction)
        if i != mover:  # there is no wall that way
            continue
        a = a + (reach + 1e-9) * along
        (wall, jump), (across, turned) = np.zeros((2, 3)), np.zeros((2, 1, 3))
        before, model = kind[i], Status(kind.copy(), status.direction.copy(), status.turning.copy())
        active.pass_wall(i, disk, a, model, wall, jump, across, turned)
        passed.add((before, model.kind[i]))
        for its_wall, its_jump in ((across[0], turned[0]), (wall, jump)):
            if its_jump.any():
                matrix.bend(i, its_wall, its_jump, along)
        anew = Derivative(active, map_of(active, a, model.kind, EPSILON, centre)[1], EPSILON).step(given)
        # 1e-9 behind the wall, times what the inverse of the matrix, of up to 1/EPSILON, makes of it
        assert matrix.step(given) == pytest.approx(anew, abs=1e-5 * np.abs(anew).max())
    assert passed >= {(STICK, SLIDE), (SLIDE, STICK), (OPEN, SLIDE), (SLIDE, OPEN), (OPEN, LINK), (LINK, OPEN)}


def test_paths_end_at_solutions():
    """From random starts: what the path and the Newton steps at its end give satisfies the proximal problem."""
    reached = bends = 0
    for seed in range(60):
        active = ActiveSet(random_problem(seed))
        start, centre = np.random.default_rng(1000 + seed).standard_normal((2, 10, 3))
        curve = follow_curve(active, start, EPSILON, centre, 200)
        if curve.status is None:
            continue
        r = centre
        for _ in range(6):
            r = active.newton(curve.status, EPSILON, centre)
            error, status = active.error(r, EPSILON, centre)
            curve = curve._replace(status=status)
        reached += np.linalg.norm(error) < 1e-9 * active.nothing
        bends += curve.bends
    assert reached >= 54  # as in the plane, a path from a start of chance may not come to an end; nor may Newton steps
    assert bends > 5 * 60


def test_a_path_turns_back_where_a_solution_ceases_to_exist():
    """As in the plane, with coupling along a direction between the two tangents; sticking is all that is left."""
    slope = np.array([0.6, 0.8])
    W = np.eye(3) * 5.0
    W[0, 0] = 1.0
    W[0, 1:] = W[1:, 0] = 2.0 * slope
    q, mu = np.array([-0.1, *(1.0 * slope)]), 2.0
    active = ActiveSet(problem(W, q, np.array([mu])))
    start = np.array([[-1.0, *(-1.0 * slope + 0.1)]])
    curve = follow_curve(active, start, 1e-9, np.zeros((1, 3)), 50)
    assert curve.bends == 2
    r = active.newton(curve.status, 1e-9, np.zeros((1, 3)))
    assert r == pytest.approx(-np.linalg.solve(W, q)[None], rel=1e-6)
    assert r[0] == pytest.approx(lm.solve_local(W, q, friction=mu).impulse, rel=1e-6)


@pytest.mark.parametrize("impulse", [np.nan, np.inf])
def test_a_path_from_impulses_that_are_not_finite_is_given_up(impulse):
    """As sweeps leave them where a step has no solution."""
    active = ActiveSet(problem(np.eye(3), np.array([-1.0, 0.5, 0.0]), np.ones(1)))
    with np.errstate(invalid="ignore", over="ignore"):
        curve = follow_curve(active, np.full((1, 3), impulse), EPSILON, np.zeros((1, 3)), 50)
    assert curve.status is None


def test_a_path_to_infinity_is_given_up():
    """One body with six degrees of freedom at four contacts: F grows by up to a third from piece to piece, to 1e160 and
    out of the range of numbers if it is followed on."""
    for seed in (13, 23):
        rng = np.random.default_rng(seed)
        H = rng.standard_normal((6, 12))
        active = ActiveSet(problem(H.T @ H, rng.standard_normal(6) @ H, np.ones(4)))
        start, centre = np.random.default_rng(seed).standard_normal((2, 4, 3))
        curve = follow_curve(active, start, EPSILON, centre, 60)
        assert curve.status is None
        assert curve.cost <= 4  # without a limit 5 and 7, up to where the numbers overflow


def test_a_path_spends_no_more_than_it_may():
    active = ActiveSet(random_problem(3))
    start = np.random.default_rng(4).standard_normal((10, 3))
    for most in (1, 5, 7, 8, 9, 10, 40):
        _, cost, _ = solution_by_path(active, start, EPSILON, 1e-10, most)
        assert cost <= most
