"""Copies of a periodic cell that yields, one for each task: no momentum is lost, and no sweep raises the energy."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.compiled.kernel import kernel
from lmgcpy.contact.slabs import partition_from
from lmgcpy.solve.problems.report import SPENT
from lmgcpy.solve.sweeps.sweep import begin, sweep_groups
from lmgcpy.solve.sweeps.team import Team

BOUNDS = 1e-12, 1.0, 1.0
FREE = {"slip": 1e9, "force": 1e9}
INERTIA = [1e2, 1.0, 1e-2, 1e-4, 1e-6]
"""Inertia of the cell in parts of what its grains give it."""


@kernel
def only_sweeps(team: Team, count):
    """Sweeps without what follows them: velocities are those that the sweeps leave."""
    begin(team, False)
    for _ in range(count):
        sweep_groups(team)
    return count, SPENT


def squeezed(dimension, inertia, friction=0.0, *, slabs=True):
    """A step of touching grains in a cell that yields to a pressure, in slabs."""
    sides = {2: (14, 14), 3: (13, 5, 5)}[dimension]
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=dimension)
    for index in np.ndindex(*sides):
        place, velocity = np.array(index) + 0.5, rng.normal(0.0, 0.1, dimension)
        make = lm.disk if dimension == 2 else lm.sphere
        scene.add(make(radius=0.5 * rng.uniform(1.0, 1.02), position=place, mass=1.0, velocity=velocity))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    axes = "xyz"[:dimension]
    given = inertia * np.prod(sides) * np.mean(sides) ** 2 / 12.0
    cell = scene.periodic(**dict(zip(axes, map(float, sides), strict=True)), inertia=given)
    cell.impose_stress(**{a + b: -100.0 * (a == b) for a in axes for b in axes})
    with partition_from(20 if slabs else 10_000):
        sim = lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore", overlap="ignore")
    sim.solver = lm.GaussSeidel(tolerance=1e-3, max_iterations=3)
    return sim.run(steps=1).last_step.problem


@pytest.mark.default_parameters(dimension=[2])
@pytest.mark.parametrize("inertia", INERTIA)
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_sweep_raises_the_energy_and_velocities_are_those_of_the_impulses(dimension, inertia):
    """Without friction a step is ``min 1/2 r.W r + q.r`` over impulses r >= 0, with the whole W. Sweep by sweep this does
    not grow, to round-off, and ``v = v_free + M^-1 H r``, though each task has but a part of the cell's inertia."""
    step = squeezed(dimension, inertia)
    problem, acting = step.conic()
    W, q = problem.W, problem.q.ravel()
    assert np.diff(step.groups.phase).max() >= 3  # tasks side by side
    energies = []
    for count in range(9):
        step.starting_from(np.zeros_like(step.guess)).led(only_sweeps, BOUNDS, count)
        r, given = step.system.impulse[acting].ravel(), step.momentum()
        energies.append(0.5 * r @ (W @ r) + q @ r)
        expected = step.free_velocity + step.inverse_mass * given
        assert step.system.velocity == pytest.approx(expected, abs=1e-12 * np.abs(step.free_velocity).max())
    assert (np.diff(energies) <= 1e-12 * abs(energies[-1])).all()
    assert energies[1] < 0.0


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("inertia", INERTIA)
def test_a_cell_of_any_inertia_takes_about_as_many_sweeps_as_by_ids(inertia, friction):
    """To the residual of a hundred sweeps by ids. It is measured after an eighth more sweeps each time. (If local blocks
    have the cell's own inertia and not a T-th of it, the sweeps diverge at 1e-4 and 1e-6.)"""
    by_ids, by_slabs = (squeezed(2, inertia, friction, slabs=slabs) for slabs in (False, True))
    reached = lm.GaussSeidel(tolerance=1e-12, max_iterations=100, **FREE).solve(by_ids).residual
    outcome = lm.GaussSeidel(tolerance=reached, max_iterations=1000, **FREE).solve(by_slabs)
    assert outcome.residual <= reached
    assert outcome.iterations <= 160  # 94 to 154 were measured
