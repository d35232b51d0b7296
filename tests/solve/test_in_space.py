"""The local problem and whole problems in 3D: the round cone exactly, the kernels against plain numpy."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.jit import kernel
from lmgcpy.laws.coulomb import react_in_space


@kernel
def solve_all(W, q, friction, impulse):
    for i in range(q.shape[0]):
        block = (
            (W[i, 0, 0], W[i, 0, 1], W[i, 0, 2]),
            (W[i, 1, 0], W[i, 1, 1], W[i, 1, 2]),
            (W[i, 2, 0], W[i, 2, 1], W[i, 2, 2]),
        )
        impulse[i, 0], impulse[i, 1], impulse[i, 2] = react_in_space(block, q[i, 0], q[i, 1], q[i, 2], friction[i])


def blocks(count, spread, rng):
    """Symmetric positive definite blocks with eigenvalues over ``spread``, in any directions."""
    turn, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    W = np.einsum("mij,mj,mkj->mik", turn, np.exp(rng.uniform(-0.5, 0.5, (count, 3)) * np.log(spread)), turn)
    return 0.5 * (W + W.transpose(0, 2, 1))


@pytest.mark.parametrize("most_friction", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("spread", [1.0, 1e2, 1e4, 1e6])
def test_the_local_problem_is_solved(spread, most_friction):
    """Each condition of the law by itself, for full blocks; errors relative to the terms of ``q + W r``. The tangential
    velocity loses the digits of the condition of W and of the slope of the root in mu."""
    rng = np.random.default_rng(0)
    count = 100_000
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
    assert slide.sum() > 1000
    assert size[slide] == pytest.approx(limit[slide], rel=1e-12)
    power = np.einsum("mi,mi->m", u[slide, 1:], r[slide, 1:])
    most = np.linalg.norm(u[slide, 1:], axis=1) * size[slide]
    # the directions are opposite: an angle of a leaves a^2/2 of the power, and u_t may be 1e-10 of its terms
    assert np.all(power <= -most * (1.0 - 1e-6) + 1e-11 * scale[slide] * size[slide])


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


def heap():
    """Spheres pressed together in a corner, with an elastic wire, one of them held along y and one without spin about x."""
    rng = np.random.default_rng(2)
    scene = lm.Scene(dimension=3, gravity=(-3.0, -2.0, -9.81))
    balls = []
    for i in range(36):
        place = 0.195 * np.array([i % 3, i // 3 % 3, i // 9]) + 0.1 + rng.uniform(0.0, 0.005, 3)
        balls.append(scene.add(lm.sphere(radius=0.1, position=place, mass=rng.uniform(0.5, 2.0))))
    balls[16].fix("y")
    balls[20].fix("spin_x")
    for axis in range(3):
        scene.add(lm.wall(point=(0, 0, 0), normal=np.eye(3)[axis]))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.2))
    scene.chain(balls[::7], lm.ElasticWire(stiffness=1e5), reference_gap=0.1)
    solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=5)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore", overlap="ignore").run(steps=10)


def test_the_residual_of_the_kernels_is_that_of_numpy():
    sim = heap()
    problem = sim.problem()
    assert problem.dimension == 3
    assert len(problem.mu) == len(sim.interactions) > 80
    assert sim.report.residual > 1e-8
    assert lm.residual(problem, sim.interactions.impulse) == pytest.approx(sim.report.residual, rel=1e-9)


@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel])
@pytest.mark.parametrize("wire_blocks", [True, False])
def test_a_step_solved_as_a_problem_has_the_velocities_of_the_step(solver, wire_blocks):
    """On the assembled W, and on the bodies: where both are solved to 1e-10 the relative velocities agree to 1e-7 of them,
    as the impulses of a packing need not be unique."""
    sim = heap()
    problem = sim.problem()
    solution = lm.solve(problem, solver=solver(tolerance=1e-10, max_iterations=20_000, wire_blocks=wire_blocks))
    assert solution.status == "converged"
    sim = heap()
    sim.solver = lm.AcceleratedGaussSeidel(tolerance=1e-10, max_iterations=20_000)
    sim.step()
    again = sim.problem()
    other = lm.solve(again, solver=solver(tolerance=1e-10, max_iterations=20_000, wire_blocks=wire_blocks))
    size = np.abs(again.velocities(np.zeros_like(other.impulses))).max()
    assert other.velocities == pytest.approx(again.velocities(sim.interactions.impulse), abs=1e-7 * size)


def test_written_and_read_as_fclib(tmp_path):
    problem = heap().problem()
    lm.io.fclib.write(problem, tmp_path / "step.h5")
    back = lm.io.fclib.read(tmp_path / "step.h5")
    assert back.dimension == 3
    assert np.array_equal(back.q, problem.q)
    assert abs(back.W - problem.W).max() == 0.0
