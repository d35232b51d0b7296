"""Where a tolerance lies below what arithmetic can tell, a step ends at round-off, soon, and is solved."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

G = 9.81


def hanging(masses, solver, dimension=2):
    """A straight chain under its weight; the simulation and the tensions that it must have [N]."""
    down = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=-G * down)
    make = lm.disk if dimension == 2 else lm.sphere
    for i, mass in enumerate(masses):
        scene.add(make(radius=0.002, position=-0.01 * i * down, mass=mass))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    return sim, G * np.cumsum(np.asarray(masses)[::-1])[::-1][1:]


@pytest.mark.default_parameters(tip=(1.0, 1e9), tolerance=(1e-15,))
@pytest.mark.parametrize("tolerance", [1e-10, 1e-15])
@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Newton, lm.Auto])
@pytest.mark.parametrize("tip", [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("dimension", [2, 3])
def test_hanging_chains(dimension, tip, solver, tolerance):
    """300 beads and a tip of so many beads' mass. e(0) is g h at the first link, and the terms of each velocity are
    tip g h: a residual below about eps tip is noise. The wire's block solves the step in a sweep or two all the same, to
    1e-11 (measured: 1e-15 to 1e-12)."""
    masses = np.full(301, 1e-3)
    masses[-1] = 1e-3 * tip
    sim, tension = hanging(masses, solver(tolerance=tolerance), dimension)
    for _ in range(5):
        report = sim.step()
        assert report.solved
        assert report.iterations <= 3
        assert -sim.interactions.force[:, 0] == pytest.approx(tension, rel=1e-11)
    assert sim.unconverged_steps == 0
    if tip >= 1e6:
        assert report.status == "round-off"


@pytest.mark.parametrize("ratio", [1e-3, 1e-6, 1e-9])
def test_masses_that_alternate(ratio):
    """1 and ``ratio`` by turns: a light bead between heavy ones is pulled by 1/ratio of its weight. Tensions are right to
    1e-10 (measured: 7e-16 to 3e-11)."""
    masses = np.ones(100)
    masses[1::2] = ratio
    sim, tension = hanging(masses, lm.Auto(tolerance=1e-10))
    for _ in range(5):
        report = sim.step()
        assert report.solved
        assert report.iterations <= 5
    assert -sim.interactions.force[:, 0] == pytest.approx(tension, rel=1e-10)


@pytest.mark.default_parameters(tip=(1.0, 1e9))
@pytest.mark.parametrize("tolerance", [1e-6, 1e-10, 1e-15])
@pytest.mark.parametrize("tip", [1.0, 1e3, 1e6, 1e9])
@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel])
def test_what_is_not_solved_is_not_called_round_off(solver, tip, tolerance):
    """Link by link: tensions are wrong by tenths after thousands of sweeps, and the status says so at every step."""
    masses = np.full(150, 1e-3)
    masses[-1] = 1e-3 * tip
    sim, tension = hanging(masses, solver(tolerance=tolerance, wire_blocks=False, max_iterations=1500))
    for _ in range(3):
        report = sim.step()
        off = np.abs(-sim.interactions.force[:, 0] / tension - 1.0).max()
        assert off > 1e-3 or report.solved
        assert (off < 1e-3) >= report.solved
    assert off > 1e-3 or tip == 1.0


def test_a_problem_from_a_matrix_ends_at_round_off_as_well():
    masses = np.full(101, 1e-3)
    masses[-1] = 1e3
    sim, tension = hanging(masses, lm.Auto(tolerance=1e-6))
    sim.step()
    solution = lm.solve(sim.problem(), solver=lm.GaussSeidel(tolerance=1e-14), guess=np.zeros((100, 2)))
    assert solution.status == "round-off"
    assert solution.iterations <= 3
    assert -solution.impulses[:, 0] / 1e-3 == pytest.approx(tension, rel=1e-8)


def test_a_step_that_is_solved_to_round_off_is_no_failure():
    """Neither for ``run`` nor for who stops at failures."""
    masses = np.full(50, 1e-3)
    masses[-1] = 1e4
    sim, _ = hanging(masses, lm.Auto(tolerance=1e-12))
    sim.on_unconverged = "stop"
    sim.run(steps=5)
    assert sim.report.status == "round-off"
    assert sim.report.solved
    assert sim.unconverged_steps == 0
