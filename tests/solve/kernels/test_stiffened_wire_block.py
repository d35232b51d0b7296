"""Wires with geometric stiffness: every solver and every way to visit the links against one dense solution.
What a visit keeps for the next one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

import lmgcpy as lm
from lmgcpy.compiled.kernel import Kernel, row_reader
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.solve.kernels import wire_block
from lmgcpy.solve.kernels.forms.form import FORMS
from lmgcpy.solve.kernels.law_kernels import stiffened_kernels

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


@pytest.mark.default_parameters("2-wire-False-False", "2-wire-True-True", "2-elastic-False-False", "3-wire-True-True")
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_stiffened_wire_is_solved_to_round_off(dimension, law, closed, held):
    sim = taut(dimension, LAWS[law], closed=closed, held=held)
    stiffened = 0
    for _ in range(12):  # the heavy beads of a ring draw it taut in the seventh
        sim.step()
        problem = sim.problem()
        if not problem.geometric.any():
            continue
        stiffened += 1
        found = problem.velocities(sim.interactions.impulse)
        # masses of 1e-3 to 10, velocities of 5 m/s: round-off of W r, 1e-16 times some 1e4, in parts of the velocities
        assert np.abs(found - dense_velocities(problem)).max() <= 1e-8 * np.abs(problem.q).max()
    assert stiffened >= 2


@pytest.mark.default_parameters("2-Newton, blocks", "2-AcceleratedGaussSeidel, blocks")
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


@pytest.mark.default_parameters("2-rigid-wire")
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


@pytest.mark.long
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


def counted(start, count, s):
    """Count the Newton steps where nothing else stands until an error is measured."""
    s.measured[3] += 1.0
    return newton_step(start, count, s)


def newton_step(start, count, s):
    """Given by the specialisation."""
    return True


def visiting(problem: StepProblem, stiffened: bool) -> Kernel:
    """``(start, stop, offset, s)``: one visit of the wire of a step, which counts its Newton steps."""
    d, law = problem.dimension, type(problem.by_law[0].law)
    count = len(law.PREPARED)
    constants = {"react": law.react, "read": row_reader(count), "PREPARED": count}
    if stiffened:
        visit = stiffened_kernels(constants, FORMS[d, "central"], law.slope)[0]
    else:
        visit = Kernel(wire_block.sweep, {**FORMS[d, "central"].slots({**constants, "ROWS": 1}), "slope": law.slope})
    step = visit.names.get("newton_step", Kernel(wire_block.newton_step, visit.names))
    return Kernel(visit.function, {**visit.names, "newton_step": Kernel(counted, {"newton_step": step})})


def stiffened_step(sim: lm.Simulation) -> StepProblem:
    """The first step of a simulation in which links have geometric stiffness, solved."""
    for _ in range(10):
        sim.step()
        problem = sim.last_step[0]
        if problem.system.geometric.any():
            return problem
    raise AssertionError("no link is stiffened")


@pytest.mark.long
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_eliminated_is_kept_only_while_it_holds(dimension, closed):
    """Visits with what the visits before have left against visits with an empty scratch, of one disturbed wire.

    The disturbances change which links are slack, or none; seed 0. Velocities of 0.01 to 100 m/s beside those of the step,
    some 5 m/s, and masses of 1e-3 to 10: round-off, 1e-16, times some 1e4 and the number of links.
    """
    problem = stiffened_step(taut(dimension, lm.RigidWire(), closed=closed))
    s, links = problem.system, len(problem.system.geometric)
    visit, rng = visiting(problem, stiffened=True), np.random.default_rng(0)
    impulse, velocity = s.impulse.copy(), s.velocity.copy()
    slack = set()
    for size in (0.0, 0.01, 1.0, 10.0, 100.0, 0.01, 100.0, 1.0, 1.0):
        free = velocity + size * rng.standard_normal(velocity.shape) * (s.inverse_mass > 0.0)
        found, steps = [], []
        for scratch in (s.scratch, np.zeros_like(s.scratch)):
            s.impulse[:], s.velocity[:], s.measured[3] = impulse, free, 0.0
            visit(0, links, 0, s._replace(scratch=scratch))
            found.append(s.velocity.copy())
            steps.append(s.measured[3])
        assert steps[0] <= steps[1] + 1  # one more or less for round-off; a wrong matrix takes many
        assert np.abs(found[0] - found[1]).max() <= 1e-10 * np.abs(free).max()
        slack.add(tuple(s.impulse[:, 0] == 0.0))
    assert len(slack) >= 3


@pytest.mark.long
@pytest.mark.parametrize("stiffened", [False, True])
def test_a_taut_wire_that_contacts_have_moved_takes_few_newton_steps(stiffened):
    """No link goes slack, so that one Newton step is exact and a second one mends its round-off.

    With the light weights of the block from the start on, half of the links look slack at first: four steps here, and of
    1000 links all of the 30.
    """
    problem = stiffened_step(taut(2, lm.RigidWire(), heavy=1e-3))
    s, links = problem.system, len(problem.system.geometric)
    s.impulse[:, 0] -= 10.0  # taut by more than what moves it
    visit = visiting(problem, stiffened)
    s.velocity[1:-1] += 0.1 * np.sin(np.arange(s.velocity[1:-1].size)).reshape(s.velocity[1:-1].shape)
    for _ in range(2):
        s.measured[3] = 0.0
        visit(0, links, 0, s)
        assert s.measured[3] <= 2
        assert (s.impulse[:, 0] < 0.0).all()
