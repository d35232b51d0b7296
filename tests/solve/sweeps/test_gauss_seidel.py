"""How the solver ends: converged, out of budget, stagnated, not finite; its options; what it reports."""

from __future__ import annotations

import numpy as np
import pytest
from dense import dense_step, state_velocities, wire_impulses
from scipy import sparse

import lmgcpy as lm


def column(count=12, solver=None, load=None):
    """Disks stacked on a floor."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(count):
        body = scene.add(lm.disk(radius=0.05, position=(0.0, 0.05 + 0.1 * i), mass=1.0 + 0.1 * i))
    if load is not None:
        body.impose_force(y=load)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-9])
def test_converged_means_within_tolerance(tolerance):
    report = column(solver=lm.GaussSeidel(tolerance=tolerance)).step()
    assert report.status == "converged"
    assert 0.0 < report.residual <= tolerance
    assert report.iterations > 1


def test_a_tighter_tolerance_takes_more_sweeps():
    sweeps = [column(solver=lm.GaussSeidel(tolerance=10.0**-k)).step().iterations for k in (2, 4, 6, 8)]
    assert sweeps == sorted(sweeps)
    # linear convergence: as many sweeps for every two decades
    assert sweeps[3] - sweeps[2] == pytest.approx(sweeps[2] - sweeps[1], rel=0.3)


@pytest.mark.parametrize("budget", [1, 2, 7, 30])
def test_a_spent_budget_is_told_with_the_worst_interaction(budget):
    sim = column(solver=lm.GaussSeidel(tolerance=1e-9, max_iterations=budget))
    report = sim.step()
    assert report.status == "budget spent"
    assert report.iterations == budget
    assert report.residual > 1e-9
    assert report.worst.law == "coulomb"
    assert report.worst.error > 0.0
    pairs = zip(sim.interactions.candidate, sim.interactions.antagonist, strict=True)
    assert (report.worst.candidate, report.worst.antagonist) in set(pairs)
    assert f"budget spent after {budget} sweeps" in str(report)
    assert f"worst: coulomb between bodies {report.worst.candidate} and {report.worst.antagonist}" in str(report)


@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Newton, lm.Auto])
def test_a_tolerance_below_round_off_ends_there(solver):
    """At 1e-18 nothing can converge: every solver ends where only round-off is left, in the sweeps that it takes to get
    there, and it is solved. (Plain sweeps take the most: the slowest mode of a column of twelve falls by the factor
    cos(pi/25)^2 a sweep, so that 15 decades take 2200. After some 500 they end where gaps are rounded, eps |x|/h = 5e-14
    m/s of g h = 1e-2.)"""
    sim = column(solver=solver(tolerance=1e-18, max_iterations=100_000))
    report = sim.step()
    assert report.status == "round-off"
    assert report.solved
    assert sim.unconverged_steps == 0
    assert report.residual < 5e-12
    assert report.iterations < 4000


def test_what_gains_nothing_stagnates():
    """Link by link a wire of a hundred beads under a heavy tip goes on for ever: tensions are wrong all over."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(100):
        scene.add(lm.disk(radius=0.002, position=(0.0, -0.01 * i), mass=1e6 if i == 99 else 1.0))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidWire())
    solver = lm.GaussSeidel(tolerance=1e-10, wire_blocks=False)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    report = sim.step()
    assert report.status == "stagnated"
    assert not report.solved
    assert report.residual > 0.1
    assert 1000 <= report.iterations < 10_000


def test_nothing_to_do_takes_no_sweep():
    """Open contacts are satisfied by r = 0: e(0) = 0, residual 0, no worst interaction."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.5, position=(0.0, 0.0), mass=1.0))
    scene.add(lm.disk(radius=0.5, position=(1.05, 0.0), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    report = lm.Simulation(scene, time_step=1e-3).step()
    assert (report.status, report.iterations, report.residual, report.worst) == ("converged", 0, 0.0, None)
    assert report.interactions == 1


def test_an_open_contact_does_not_dilute_the_residual():
    """Two hundred open contacts beside one that is hit change nothing in the residual of a given impulse."""
    reports = []
    for spectators in (0, 200):
        scene = lm.Scene(dimension=2)
        scene.add(lm.disk(radius=0.5, position=(0.0, 0.0), mass=1.0, velocity=(0.0, 1.0), color="HIT"))
        scene.add(lm.disk(radius=0.5, position=(0.0, 1.0), mass=1.0, color="HIT"))
        scene.add(lm.disk(radius=0.5, position=(0.0, 2.0), mass=1.0, color="HIT"))
        for i in range(spectators):
            scene.add(lm.disk(radius=0.5, position=(3.0 + 1.05 * i, 0.0), mass=1.0, color="FAR"))
        scene.see("HIT", "HIT", lm.Signorini())
        if spectators:
            scene.see("FAR", "FAR", lm.Signorini())
        solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=3)
        sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
        reports.append(sim.step())
    assert reports[1].interactions == reports[0].interactions + 199
    assert 1e-12 < reports[0].residual < 1.0
    assert reports[1].residual == pytest.approx(reports[0].residual, rel=1e-12)


def test_the_solver_is_a_frozen_value():
    solver = lm.GaussSeidel(tolerance=1e-6)
    assert solver == lm.GaussSeidel(tolerance=1e-6)
    with pytest.raises(AttributeError):
        solver.tolerance = 1.0


def test_many_contacts_at_one_body_agree_with_a_dense_active_set():
    """A heavy disk that lies on nine small fixed ones without friction: the dense problem, solved by NNLS as for a wire,
    min 1/2 r.W r + q.r over r >= 0. Its impulses are not unique, so the velocities are compared.
    """
    scene = lm.Scene(dimension=2, gravity=(0.3, -9.81))
    heavy = scene.add(lm.disk(radius=1.0, position=(0.0, 0.0), mass=50.0, velocity=(0.2, -1.0)))
    for angle in np.linspace(-2.5, -0.6, 9):
        place = 1.1 * np.array([np.cos(angle), np.sin(angle)])
        scene.add(lm.disk(radius=0.1, position=place, mass=0.5, velocity=(0.0, 0.5)))
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, theta=1.0, solver=lm.GaussSeidel(tolerance=1e-13))
    before = state_velocities(sim)
    assert sim.step().status == "converged"
    W, q = dense_step(sim, before).normal()
    q = q + np.maximum(sim.interactions.gap, 0.0) / 1e-3
    expected = -wire_impulses(W, -q)
    assert W @ sim.interactions.impulse[:, 0] == pytest.approx(W @ expected, abs=1e-10)
    assert (expected > 0.0).sum() >= 2
    assert heavy.velocity[1] > -1.0


def test_sweeps_that_grow_without_bound_end():
    """Three rods whose W has an eigenvalue of -0.8: each sweep makes the impulses larger. They ended in numbers that are
    not finite; now `Auto` ends its sweeps in time and goes on with Newton steps, which find the one answer."""
    w = np.array([[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]])
    W = np.kron(w, np.diag([1.0, 0.0])) + np.kron(np.eye(3), np.diag([0.0, 1.0]))
    q = np.array([1.0, -1.0, 0.3])
    rods = {"laws": ("rigid-rod",) * 3, "compliance": np.zeros(3), "guess": np.zeros((3, 2)), "mu": np.zeros(3)}
    problem = lm.Problem(W=sparse.csr_array(W), q=np.kron(q, [1.0, 0.0]), dimension=2, **rods)
    solution = lm.solve(problem, solver=lm.Auto(tolerance=1e-10))
    assert solution.iterations < 100
    np.testing.assert_allclose(solution.impulses[:, 0], np.linalg.solve(w, -q), rtol=1e-8)
