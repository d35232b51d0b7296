"""Whole problems in 3D: the kernels against plain numpy."""

import numpy as np
import pytest

import lmgcpy as lm


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
