"""Where a tolerance lies below what arithmetic can tell, a step ends at round-off, soon, and is solved."""

from __future__ import annotations

from dataclasses import dataclass

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


@pytest.mark.default_parameters("2-1.0-GaussSeidel-1e-15", "3-1.0-Newton-1e-15")
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


@pytest.mark.long
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


@pytest.mark.default_parameters(tip=(1e9,))
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


@pytest.mark.long
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


# ---------------------------------------------------------------------------------- what counts as solved, and what not


@dataclass(frozen=True)
class Stretched(lm.Solver):
    """Solves contacts, and gives links a tension ``force`` [N] that is constant but for its last digits."""

    force: float = 0.0

    def solve(self, step):
        lm.GaussSeidel(tolerance=1e-14).solve(step)
        impulses = step.system.impulse.copy()
        noise = np.random.default_rng(0).uniform(-1.0, 1.0, 20)
        impulses[:20, 0] = -1e-3 * self.force * (1.0 + 2.0**-52 * noise)
        return self.finish(step, impulses, iterations=1)


def stretched(dimension, tension, zigzag=0.0):
    """How a step is solved: a line between posts at a tension in weights of its beads, these ``zigzag`` [m] up and down;
    beside it a ball lies on the ground."""
    up = np.eye(dimension)[-1]
    along = np.eye(dimension)[0]
    scene = lm.Scene(dimension=dimension, gravity=-G * up)
    make = lm.disk if dimension == 2 else lm.sphere
    places = [0.01 * i * along + (-1) ** i * zigzag * up for i in range(21)]
    beads = [scene.add(make(radius=0.002, position=place, mass=0.01)) for place in places]
    beads[0].fix()
    beads[-1].fix()
    scene.chain(beads, lm.RigidWire())
    scene.add(make(radius=0.01, position=0.01 * up - 0.1 * along, mass=0.01, color="BALL"))
    scene.add(lm.wall(point=(0,) * dimension, normal=tuple(up), color="GROUND"))
    scene.see("BALL", "GROUND", lm.Coulomb(friction=0.3))
    solver = Stretched(tolerance=1e-15, force=tension * 0.01 * G)
    options = {"solver": solver, "on_unconverged": "ignore", "geometric_stiffness": False}
    return lm.Simulation(scene, time_step=1e-3, **options).step()


EXPLODING = pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
"""Runs say themselves that a body moves too far, or that energy is made."""


@EXPLODING
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("tension", "solved"), [(1.0, True), (1e6, True), (1e12, True), (1e15, False), (1e20, False)])
def test_round_off_is_no_excuse_for_errors_that_are_large(dimension, tension, solved):
    """A straight line bears any constant tension, T times the weight of a bead, and is never off by more than the round-off
    of that, eps T g h. Up to T = 1e12 these are 4e-4 of what does nothing, g h; from 1e15 on they are as large."""
    report = stretched(dimension, tension)
    assert report.status == ("round-off" if solved else "budget spent")
    assert (report.residual <= 1e-2) == solved


@EXPLODING
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("tension", "solved"), [(1e7, True), (1e8, True), (1e10, False), (1e11, False)])
def test_round_off_is_no_excuse_for_energy(dimension, tension, solved):
    """Beads 5e-11 m up and down, angles of 1e-8 between links and chord: a tension of T weights of a bead throws them at
    2e-8 T g h across, with (2e-8 T)^2 of the kinetic energy that gravity gives, of which a hundred is allowed. Links see
    1e-8 of that velocity, for two beads 4e-16 T g h, less than the round-off of T. (Below 1e7 it would be more.)"""
    report = stretched(dimension, tension, zigzag=5e-11)
    assert report.status == ("round-off" if solved else "budget spent")
    assert report.residual <= 1e-3


@pytest.mark.default_parameters("1e-08-100")
@pytest.mark.parametrize(("tolerance", "sweeps"), [(1e-8, 100), (1e-9, 3000), (1e-12, 3000)])
def test_gaps_are_rounded_as_well(tolerance, sweeps):
    """A face-centred cell of 108 spheres of 1 cm and 1 g under 1 Pa. Its gaps are rounded by 1e-18 m, which over 0.1 ms is
    1e-14 m/s, 3e-9 of what the load gives in a step: which contacts bear is decided below that, and takes for ever.
    """
    size = 0.01 * np.sqrt(2.0)
    scene = lm.Scene(dimension=3)
    for i in np.ndindex(3, 3, 3):
        for offset in ((0, 0, 0), (0.5, 0.5, 0), (0.5, 0, 0.5), (0, 0.5, 0.5)):
            scene.add(lm.sphere(radius=0.005, position=size * (np.array(i) + offset), mass=1e-3))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    cell = scene.periodic(x=3 * size, y=3 * size, z=3 * size)
    cell.impose_stress(xx=-1.0, yy=-1.0, zz=-1.0)
    report = lm.Simulation(scene, time_step=1e-4, solver=lm.Auto(tolerance=tolerance)).step()
    assert report.status == ("converged" if tolerance == 1e-8 else "round-off")
    assert report.iterations <= sweeps
    assert report.residual <= 1e-8
