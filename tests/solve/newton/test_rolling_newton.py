"""Newton steps and paths of problems whose contacts roll: random ones with full coupling, in the plane and in space."""

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.path import Derivative, follow_path, map_at
from lmgcpy.solve.newton.path_3d import follow_curve, map_of
from lmgcpy.solve.newton.rows import LINK, OPEN, STICK

EPSILON = 1e-3
WIDTH = {2: 3, 3: 6}


def random_problem(seed, dimension, contacts=6):
    """Contacts, one of which does not roll and one that is smooth, a wire and a rod, with less rank than rows."""
    rng = np.random.default_rng(seed)
    count, width = contacts + 2, WIDTH[dimension]
    H = rng.standard_normal((width * count - 4, width * count))
    share = rng.uniform(0.1, 1.5, (3, count))
    share[:, contacts - 1 :] = 0.0
    share[1:, 0] = 0.0
    return lm.Problem(
        W=sparse.csr_array(H.T @ H),
        q=rng.standard_normal(width * count),
        mu=share[0],
        dimension=dimension,
        laws=("rolling-coulomb",) * contacts + ("rigid-wire", "elastic-rod"),
        compliance=np.array([0.0] * (count - 1) + [0.3]),
        guess=np.zeros((count, width)),
        rolling=share[1],
        torsion=share[2] if dimension == 3 else np.zeros(0),
    )


def point(active, seed):
    """Where the map is looked at, and the centre of a proximal problem, of chance."""
    a, centre = np.random.default_rng(1000 + seed).standard_normal((2, *active.q.shape))
    return a, centre


def kinds_at(active, a):
    return active.natural(-active.weight[:, None] * a, np.zeros_like(a))[1].kind


def mapped(active, a, kind, centre):
    """F(a), with these kinds where the map is curved, and the statuses."""
    return map_at(active, a, EPSILON, centre) if active.dimension == 2 else map_of(active, a, kind, EPSILON, centre)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_error_is_that_of_the_problem(dimension):
    """Which is written out in numpy, disk by disk; statuses of all kinds occur."""
    seen = set()
    for seed in range(100):
        problem = random_problem(seed, dimension)
        active = ActiveSet(problem)
        r = 0.5 * point(active, seed)[0]
        error, status = active.error(r)
        assert error == pytest.approx(problem.errors(r), abs=1e-12 * np.abs(error).max())
        seen |= set(status.kind.tolist())
    assert seen >= {OPEN, LINK, *range(STICK, STICK + 2**dimension)}


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_matrix_is_the_derivative_of_the_map(dimension):
    """By finite differences; and its sign is that of the determinant."""
    for seed in range(10):
        active = ActiveSet(random_problem(seed, dimension))
        (a, centre), d = point(active, seed), point(active, 77)[0]
        kind = kinds_at(active, a)
        at, status = mapped(active, a, kind, centre)
        ahead, _ = mapped(active, a + 1e-7 * d, kind, centre)
        matrix = Derivative(active, status, EPSILON)
        change = matrix.step((ahead - at) / 1e-7)
        # second order in 1e-7, and round-off over it, times the condition of the matrix, up to 1/EPSILON
        assert change == pytest.approx(d, abs=3e-3)
        inverse = [matrix.step(unit.reshape(a.shape)).ravel() for unit in np.eye(a.size)]
        assert matrix.sign == np.linalg.slogdet(np.array(inverse))[0]


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bend_changes_the_derivative_to_that_behind_the_wall(dimension):
    """As it is when factorised there anew, whichever status gives way to which. One disk of one interaction moves towards
    its middle or away, or all along the normal: what else there is does not turn and keeps its resistance to it."""
    passed = set()
    for seed in range(250):
        active = ActiveSet(random_problem(seed, dimension))
        (a, centre), given = point(active, seed), point(active, 77)[0]
        kind, mover = kinds_at(active, a), seed % len(a)
        along, outward, way = np.zeros_like(a), 1.0 if seed // 8 % 2 else -1.0, seed // 16 % (1 + dimension)
        along[mover, 0] = outward * (way == dimension)
        for part, _ in active.problem.disks[way : way + 1]:
            along[mover, part] = outward * a[mover, part] / np.linalg.norm(a[mover, part])
        status = mapped(active, a, kind, centre)[1]
        matrix = Derivative(active, status, EPSILON)
        model = type(status)(kind.copy(), status.direction.copy(), status.turning.copy())
        wall, jump = np.zeros((2, active.width))
        if dimension == 2:
            i, side, reach = active.next_bend(a, along, status)
        else:
            i, side, reach, _ = active.next_wall(a, along, kind, status.direction)
        on_a_disk = side != 0.0 if dimension == 2 else side >= 0
        if i != mover or (on_a_disk and way == dimension):  # no wall that way; or one that others of the contact see move
            continue
        a = a + (reach + 1e-9) * along
        if dimension == 2:
            active.pass_bend(i, side, a, model, wall, jump)
            matrix.bend(i, wall, jump, along)
        else:
            across, turned = np.zeros((2, 2, active.width))
            active.pass_wall(i, side, a, model, wall, jump, across, turned)
            for its_wall, its_jump in (*zip(across, turned, strict=True), (wall, jump)):
                if its_jump.any():
                    matrix.bend(i, its_wall, its_jump, along)
        assert model.kind[i] == kinds_at(active, a)[i]
        passed.add((int(kind[i]), int(model.kind[i])))
        anew = Derivative(active, mapped(active, a, model.kind, centre)[1], EPSILON).step(given)
        # 1e-9 behind the wall, times what the inverse of the matrix, of up to 1/EPSILON, makes of it
        assert matrix.step(given) == pytest.approx(anew, abs=1e-5 * np.abs(anew).max())
    slides = STICK + 2**dimension - 1
    assert passed >= {(OPEN, slides), (slides, OPEN), (OPEN, LINK), (LINK, OPEN)}
    turns = {(a - STICK) ^ (b - STICK) for a, b in passed if min(a, b) >= STICK}
    assert turns == {1 << g for g in range(dimension)}  # one disk at a time, and each


def test_paths_in_the_plane_end_at_solutions():
    """What a path ends with satisfies the proximal problem to round-off."""
    reached = bends = 0
    for seed in range(100):
        active = ActiveSet(random_problem(seed, 2))
        start, centre = point(active, seed)
        path = follow_path(active, start, EPSILON, centre, 1000)
        bends += path.bends
        if path.impulses is not None:
            reached += 1
            error = np.linalg.norm(active.error(path.impulses, EPSILON, centre)[0])
            assert error < 1e-8 * active.nothing, seed
    assert reached >= 90  # a path from a start of chance may come back to a large rest
    assert bends > 5 * 100


def test_paths_in_space_end_near_solutions():
    """What the path and the Newton steps at its end give satisfies the proximal problem."""
    reached = bends = 0
    for seed in range(40):
        active = ActiveSet(random_problem(seed, 3))
        start, centre = point(active, seed)
        curve = follow_curve(active, start, EPSILON, centre, 300)
        if curve.status is None:
            continue
        status = curve.status
        for _ in range(6):
            r = active.newton(status, EPSILON, centre)
            error, status = active.error(r, EPSILON, centre)
        reached += np.linalg.norm(error) < 1e-9 * active.nothing
        bends += curve.bends
    assert reached >= 30  # as in the plane; nor need Newton steps come to an end
    assert bends > 5 * 40


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("dimension", [2, 3])
def test_solvers_solve_it(dimension):
    """Sweeps with the laws' own kernels and Newton steps: the residual of the problem, written out in numpy."""
    for seed in range(6):
        problem = random_problem(seed, dimension)
        for solver in (lm.GaussSeidel(tolerance=1e-7, max_iterations=50_000), lm.Newton(tolerance=1e-10)):
            solution = lm.solve(problem, solver=solver)
            assert solution.status == "converged", (seed, solution)
            assert lm.residual(problem, solution.impulses) <= 1.1 * solver.tolerance
