"""Wires with geometric stiffness: every solver and every way to visit the links against one dense solution."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

import lmgcpy as lm

pytestmark = pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
"""The wires are thrown by half a link in a step: tensions are large, stretches are pulled back by blows, and it says so."""

LAWS = {"wire": lm.RigidWire(), "rod": lm.RigidRod(), "elastic": lm.ElasticWire(stiffness=1e5)}


class WithoutSlope(lm.RigidWire):
    """A wire of somebody's own that gives no slope, so that its links are visited one after another."""

    NAME = "wire-without-slope"
    slope = None


def taut(dimension: int, law: lm.Law, *, closed=False, held=False, heavy=10.0, solver=None) -> lm.Simulation:
    """A ring, or a wire between two supports, of light beads and heavy ones, crooked and thrown; seed 3."""
    rng = np.random.default_rng(3)
    scene = lm.Scene(dimension=dimension, gravity=(0.0,) * (dimension - 1) + (-9.81,))
    make = lm.disk if dimension == 2 else lm.sphere
    count = 12
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False) if closed else np.linspace(0.3, 2.8, count)
    for i in range(count):
        at = np.zeros(dimension)
        at[[0, -1]] = 0.1 * np.cos(angle[i]), -0.1 * np.sin(angle[i])
        at += rng.normal(0.0, 1e-3, dimension)
        speed = 5.0 * at / 0.1 + rng.normal(0.0, 0.5, dimension)
        scene.add(make(radius=1e-3, position=at, mass=heavy if i in (0, count // 2) else 1e-3, velocity=speed))
    if not closed:
        scene.bodies[0].fix()
        scene.bodies[-1].fix()
    if held:  # inverse masses that differ by direction: local blocks of W that are full
        scene.bodies[3].impose_velocity(x=0.0)
    scene.chain(scene.bodies, law, closed=closed)
    solver = solver or lm.GaussSeidel(tolerance=1e-11)
    return lm.Simulation(scene, time_step=2e-3, solver=solver, on_unconverged="ignore")


def dense_velocities(problem: lm.Problem) -> np.ndarray:
    """u of ``0 <= -(u_n + C r_n) _|_ -r_n >= 0`` (rods: u_n + C r_n = 0) and ``r_t = -kappa u_t``, (m, d), by elimination
    of what is linear and Lawson and Hanson's active set."""
    d, count = problem.dimension, len(problem.mu)
    W, q = problem.W.toarray(), problem.q
    normal = np.arange(0, d * count, d)
    across = np.setdiff1d(np.arange(d * count), normal)
    kappa = np.repeat(problem.geometric, d - 1)
    across, kappa = across[kappa > 0.0], kappa[kappa > 0.0]
    B = W[np.ix_(across, across)] + np.diag(1.0 / kappa)
    X = np.linalg.solve(B, np.column_stack([W[np.ix_(across, normal)], q[across]]))
    A = W[np.ix_(normal, normal)] - W[np.ix_(normal, across)] @ X[:, :-1] + np.diag(problem.compliance)
    b = q[normal] - W[np.ix_(normal, across)] @ X[:, -1]
    if "rod" in problem.laws[0]:
        r_n = -np.linalg.solve(A, b)
    else:
        L = np.linalg.cholesky(A)
        r_n = -nnls(L.T, np.linalg.solve(L, b), maxiter=100 * count)[0]
    r = np.zeros(d * count)
    r[normal] = r_n
    r[across] = -(X[:, :-1] @ r_n + X[:, -1])
    return (W @ r + q).reshape(-1, d)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_stiffened_wire_is_solved_to_round_off(dimension, law, closed, held):
    sim = taut(dimension, LAWS[law], closed=closed, held=held)
    stiffened = 0
    for _ in range(6):
        sim.step()
        problem = sim.problem()
        if not problem.geometric.any():
            continue
        stiffened += 1
        found = problem.velocities(sim.interactions.impulse)
        # masses of 1e-3 to 10, velocities of 5 m/s: round-off of W r, 1e-16 times some 1e4, in parts of the velocities
        assert np.abs(found - dense_velocities(problem)).max() <= 1e-8 * np.abs(problem.q).max()
    assert stiffened >= 2


@pytest.mark.parametrize(
    "solver",
    [
        lm.AcceleratedGaussSeidel(tolerance=1e-11),
        lm.Newton(tolerance=1e-11),
        lm.Auto(tolerance=1e-11, wire_blocks=False),
    ],
    ids=lambda solver: f"{type(solver).__name__}, {'blocks' if solver.wire_blocks else 'links'}",
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_all_solvers_find_the_same_velocities(dimension, solver):
    sim, other = taut(dimension, lm.RigidWire()), taut(dimension, lm.RigidWire(), solver=solver)
    for _ in range(2):
        sim.step()
        other.step()
    assert other.report.solved
    # 1e-11 of e(0), times the condition of a wire of 11 links with masses of 1e-3 and 10
    np.testing.assert_allclose(other.velocities, sim.velocities, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("law", [lm.RigidWire(), WithoutSlope()], ids=lambda law: law.NAME)
@pytest.mark.parametrize("dimension", [2, 3])
def test_links_one_after_another_get_it_too(dimension, law):
    """As other codes do it, and for laws without a slope; with masses that are near enough to each other for it."""
    sweeps = lm.GaussSeidel(tolerance=1e-10, max_iterations=100_000, wire_blocks=False)
    sim, other = taut(dimension, lm.RigidWire(), heavy=0.05), taut(dimension, law, heavy=0.05, solver=sweeps)
    for _ in range(2):
        sim.step()
        other.step()
    assert other.report.solved
    assert other.report.iterations > 20
    assert np.abs(other.interactions.impulse[:, 1:]).max() > 0.0
    np.testing.assert_allclose(other.velocities, sim.velocities, rtol=0.0, atol=1e-5)  # 1e-10 e(0), n^2 sweeps a digit


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.Auto, lm.Newton])
def test_a_problem_of_its_own_keeps_the_stiffness(dimension, solver, tmp_path):
    sim = taut(dimension, lm.RigidWire())
    sim.step()
    problem = sim.problem()
    lm.io.fclib.write(problem, tmp_path / "problem.h5")
    again = lm.io.fclib.read(tmp_path / "problem.h5")
    np.testing.assert_array_equal(again.geometric, problem.geometric)
    solution = lm.solve(again, solver=solver(tolerance=1e-12), guess=np.zeros_like(again.guess))
    assert solution.status in ("converged", "round-off")
    assert lm.residual(again, solution.impulses) <= 1e-11
    np.testing.assert_allclose(solution.velocities, dense_velocities(problem), atol=1e-7)
    assert lm.residual(again, sim.interactions.impulse) <= 1e-11
