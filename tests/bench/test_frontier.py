"""References, runs and profiles of the frontier."""

import importlib

import numpy as np
import pytest
import scipy.sparse as sparse
import suites

import lmgcpy as lm
import lmgcpy.bench.reference
from lmgcpy.bench.cases import Case, chains, in_space
from lmgcpy.bench.frontier import OVERHEAD, TOLERANCES, Judged, SolverRun, judge, profile
from lmgcpy.bench.reference import APART, ENOUGH, MARGIN, Reference, make_reference
from lmgcpy.bench.report import write_report
from lmgcpy.solve.solvers import SOLVERS


def stacked(count=30, mass=10.0, friction=0.3):
    """A column of disks of alternating masses that falls on its foot, leaning."""
    scene = lm.Scene(dimension=2, gravity=(1.0, -9.81))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    for i in range(count):
        scene.add(lm.disk(radius=0.01, position=(0.0, 0.01 + 0.02 * i), mass=1.0 + mass * (i % 2)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore").run(steps=1).problem()


@pytest.fixture(scope="module")
def case():
    return Case("column", "test", stacked(suites.size(12, long=30)))


@pytest.fixture(scope="module")
def judged(case):
    return judge(case)


def test_references_agree_and_are_of_different_ways(case):
    reference = make_reference(case)
    assert reference.methods[0] != reference.methods[1]
    assert max(reference.residuals) <= ENOUGH
    assert reference.distance < 1e-6
    assert reference.error(case.problem.q.reshape(-1, 2)) == pytest.approx(1.0, rel=1e-12)  # of doing nothing


def test_results_that_are_the_same_to_the_last_bit_are_no_two_references(case, monkeypatch):
    """As if Newton's method had ended before its first step, in the sweeps; from another start it finds its own way."""
    original = lmgcpy.bench.reference.descent
    swept = lmgcpy.bench.reference.by_sweeps(case.problem)
    others = []

    def descent(problem, solver, start):
        others.append(start)
        return swept.copy() if len(others) == 1 else original(problem, solver, start)

    monkeypatch.setattr(lmgcpy.bench.reference, "descent", descent)
    reference = make_reference(case)
    assert len(others) == 4
    assert set(reference.methods) != {"sweeps", "Newton"}
    assert 0.0 < reference.distance < 1e-6


def test_extended_precision_stands_before_all():
    made = next(chains((10,), (1.0,)))
    reference = make_reference(made)
    assert reference.methods[0] == "extended precision"
    np.testing.assert_array_equal(reference.solutions[0], made.problem.velocities(made.exact))
    assert reference.distance < 1e-12


@pytest.mark.long
def test_a_large_problem_in_space_is_left_to_sweeps(monkeypatch, tmp_path):
    def refuse(*given):
        raise AssertionError("a Newton step was made")

    monkeypatch.setattr(lmgcpy.bench.reference, "LARGE", 5)
    monkeypatch.setattr(importlib.import_module("lmgcpy.solve.newton.alternating"), "proximal_newton", refuse)
    result = judge(next(in_space(20, 0)))
    assert set(result.reference.methods) == {"sweeps", "plain sweeps"}
    assert result.reference.distance < 1e-3  # plain sweeps stagnate at a residual of 1e-5
    assert all(run.newton_steps == 0 for run in result.runs)
    assert {run.solver for run in result.runs} == set(SOLVERS) - {"newton"}
    page = write_report([result], [], tuple(SOLVERS), tmp_path, "0")[-1]
    assert "| box-sand-step-2 | " in page.read_text(encoding="utf-8")


def test_a_problem_in_which_nothing_acts_has_no_error():
    parted = lm.Problem(
        sparse.csr_array(np.eye(2)), np.array([1.0, 0.2]), np.array([0.3]), 2, ("coulomb",), np.zeros(1), np.zeros((1, 2))
    )
    assert make_reference(Case("parted", "test", parted)) is None
    assert judge(Case("parted", "test", parted)) is None


def test_of_several_solutions_the_nearest_counts():
    one, other, near = np.zeros((1, 2)), np.ones((1, 2)), np.full((1, 2), 1e-6)
    alone = Reference((one,), 2.0, ("a", "b"), (1e-12, 1e-11), 1e-9)
    assert alone.error(other) == pytest.approx(2.0**0.5 / 2.0)
    assert alone.floor == MARGIN * 1e-9
    several = alone.with_solutions([near, other, other + 1e-6])  # what is near one that is known is the same
    assert len(several.solutions) == 2
    assert several.error(np.array([[1.0, 1.5]])) == 0.25
    assert several.floor == MARGIN * APART


def test_what_is_no_solution_has_no_others():
    """A reference found badly is not one of several solutions: what is far from it may be right."""
    one, other = np.zeros((1, 2)), np.ones((1, 2))
    bad = Reference((one,), 1.0, ("a", "b"), (1e-6, 1e-5), 1e-2).with_solutions([other])
    assert len(bad.solutions) == 1
    assert bad.floor == MARGIN * 1e-2


@pytest.mark.long
@pytest.mark.long
def test_runs_are_what_they_say(case, judged):
    """Every run of the fastest way there, made again: residual, sweeps, error by another formula."""
    exact = lm.solve(case.problem, solver=lm.Newton(tolerance=1e-11)).velocities
    q = case.problem.q.reshape(-1, 2)
    for run in judged.runs:
        assert run.updates == run.sweeps * case.interactions
        assert run.status == "converged" or run.tolerance == min(r.tolerance for r in judged.runs if r.solver == run.solver)
        if run.status == "converged":
            assert run.residual <= 1.01 * run.tolerance
    for solver in SOLVERS:
        run = next(r for r in judged.runs if r.solver == solver and r.tolerance == TOLERANCES[2])
        again = lm.solve(case.problem, solver=SOLVERS[solver](tolerance=run.tolerance, max_iterations=50_000))
        error = np.linalg.norm(again.velocities - exact) / np.linalg.norm(q - exact)
        assert run.sweeps == again.iterations
        assert run.error == pytest.approx(error, rel=1e-3)


@pytest.mark.long
def test_error_falls_with_the_tolerance(judged):
    """By seven digits from 1e-1 to 1e-9, for the solver that gets there."""
    errors = [run.error for run in judged.runs if run.solver == "newton" and run.status == "converged"]
    assert errors[-1] < 1e-7 * errors[0]


def problem_of(name, seconds, floor=0.0, interactions=100):
    """A judged problem in which each solver has one run: (seconds, error)."""
    reference = Reference((np.zeros((1, 2)),), 1.0, ("a", "b"), (0.0, 1e-6), 0.1 * floor)
    runs = tuple(
        SolverRun(name, solver, 1e-3, "converged", 0.0, error, 1, 0, 1, time, 1)
        for solver, (time, error) in seconds.items()
    )
    return Judged(name, "test", 2, interactions, reference, runs)


def test_profile_by_hand():
    ok, bad = 1e-5, 1e-1
    judged = [
        problem_of("one", {"auto": (1.0, ok), "newton": (4.0, ok)}),
        problem_of("two", {"auto": (3.0, ok), "newton": (1.0, bad)}),
        problem_of("three", {"auto": (2.0, ok), "newton": (1.0, ok)}),
        problem_of("overhead", {"auto": (0.01 * OVERHEAD, ok), "newton": (0.9 * OVERHEAD, ok)}),
        problem_of("not told", {"auto": (1.0, ok), "newton": (1.0, ok)}, floor=1e-2),
        problem_of("small", {"auto": (1.0, ok), "newton": (1.0, ok)}, interactions=3),
        problem_of("by none", {"auto": (1.0, bad), "newton": (1.0, bad)}),
    ]
    found = profile(judged, ("auto", "newton"), 1e-3)
    assert (found.problems, found.unsolved) == (4, 1)
    np.testing.assert_array_equal(found.ratios["auto"], [1.0, 1.0, 1.0, 2.0])
    np.testing.assert_array_equal(found.ratios["newton"], [1.0, 1.0, 4.0, np.inf])
    assert found.failures("auto") == 0
    assert found.failures("newton") == 1
    assert found.share("newton", 3.0) == 0.5
    assert found.share("newton", 4.0) == 0.75
