"""The error of a force, against what the bodies of an interaction bear."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.solve.kernels.loads import LITTLE, NEARBY

G = 9.81


def tower(solver, *, count=8, dimension=2):
    """A tower whose every second body weighs ten times as much, with a loaded piston beside it."""
    down = (0.0,) * (dimension - 1) + (-G,)
    make = lm.disk if dimension == 2 else lm.sphere

    def at(x, z):
        return (x, z) if dimension == 2 else (x, 0.0, z)

    scene = lm.Scene(dimension=dimension, gravity=down)
    for k in range(count):
        scene.add(make(radius=0.1, position=at(0.0, 0.1 + 0.2 * k), mass=1.0 + 9.0 * (k % 2)))
    piston = scene.add(make(radius=0.1, position=at(1.0, 0.1), mass=1.0))
    piston.impose_force(**{"y" if dimension == 2 else "z": -1e5})
    scene.add(lm.wall(point=at(0.0, 0.0), normal=at(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")


def error_of_force(problem):
    """The measure as its definition reads, from the arrays of the step."""
    s = problem.system
    size = np.linalg.norm(s.impulse, axis=1)
    own = np.zeros(len(s.velocity))
    for ends in (s.candidate, s.antagonist):
        np.maximum.at(own, ends, size)
    own[(s.inverse_mass == 0.0).all(axis=1)] = 0.0
    nearby = np.zeros_like(own)
    np.maximum.at(nearby, s.candidate, own[s.antagonist])
    np.maximum.at(nearby, s.antagonist, own[s.candidate])
    bears = np.maximum(own, NEARBY * nearby)
    c, a = bears[s.candidate], bears[s.antagonist]
    least = np.where((c == 0.0) | (a == 0.0), np.maximum(c, a), np.minimum(c, a))
    typical = np.exp(np.log(size[size > 0.0]).mean())
    load = np.maximum(np.maximum(least, NEARBY * np.maximum(c, a)), LITTLE * typical)
    return float((np.sqrt(s.squared_error) / (s.delassus[:, 0] * load)).max())


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("sweeps", [5, 30])
def test_the_report_tells_it(dimension, sweeps):
    sim = tower(lm.GaussSeidel(tolerance=1e-9, max_iterations=sweeps), dimension=dimension)
    report = sim.step()
    assert report.force > 0.0
    assert report.force == pytest.approx(error_of_force(sim.last_step[0]), rel=1e-9)


def test_it_is_bounded_by_the_solver():
    """By a hundred times the tolerance and at most 1e-2, or by what is asked for."""
    for solver, bound in (
        (lm.GaussSeidel(tolerance=1e-2), 1e-2),
        (lm.GaussSeidel(tolerance=1e-6), 1e-4),
        (lm.GaussSeidel(tolerance=1e-2, force=1e-5), 1e-5),
    ):
        assert solver.bounds[2] == pytest.approx(bound)
        assert tower(solver).step().force <= bound
    assert tower(lm.GaussSeidel(tolerance=0.5, slip=1.0, force=1e9)).step().iterations < 3
    with pytest.raises(ValueError, match="force must be"):
        lm.GaussSeidel(force=0.0)


def test_forces_beside_a_loaded_piston():
    """e(0) is that of the piston, and the residual says nothing of the tower beside it; each force of the tower is right
    all the same. (Without the bound, with a slip of 1, the lowest is 86 % wrong.)"""
    weight = G * np.cumsum([10.0, 1.0] * 4)[::-1]
    wrong = []
    for force in (1e9, 1e-4):
        sim = tower(lm.GaussSeidel(tolerance=1e-2, slip=1.0, force=force))
        sim.step()
        net = sim.interactions
        tall = (net.candidate < 8) & (net.antagonist != 8) & (np.abs(net.normal[:, 1]) > 0.9)
        found = np.sort(np.abs(net.force[tall, 0]))[::-1]
        wrong.append(np.abs(found / weight - 1.0).max())
    assert wrong[0] > 0.3
    assert wrong[1] < 0.02


def test_a_problem_without_bodies_has_it_as_well():
    """Interactions that W couples stand for those on the same body."""
    sim = tower(lm.Auto())
    sim.step()
    problem = sim.problem()
    solution = lm.solve(problem, solver=lm.GaussSeidel(tolerance=1e-2, force=1e-6), guess=np.zeros_like(problem.guess))
    exact = lm.solve(problem, solver=lm.Newton(tolerance=1e-12))
    assert solution.status == "converged"
    assert solution.impulses[:, 0] == pytest.approx(exact.impulses[:, 0], rel=1e-4, abs=1e-9)
