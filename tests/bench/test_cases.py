"""Chains and their solutions in extended precision, against the weight below a link, and another algorithm altogether."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.bench.cases import BEAD_MASS, FALL, chain_problem, chains, extended_solution


@pytest.mark.parametrize("tip", [1.0, 1e3, 1e6])
def test_tension_is_the_momentum_of_what_hangs_below(tip):
    """As the beads must stop, each link takes the momentum that gravity gave to all below it.

    W is the problem's, in double precision: 1/m + 1/M of a tip of a million masses has lost six digits of 1/M.
    """
    mass = np.full(50, BEAD_MASS)
    mass[-1] *= tip
    r = extended_solution(chain_problem(mass, np.full(50, FALL)))
    below = np.cumsum(mass[::-1])[::-1] * FALL
    np.testing.assert_allclose(r[:, 0], -below, rtol=1e-15 * 50 * tip)
    assert not r[:, 1].any()


def pooled(velocity, mass):
    """Velocities nearest to those given, in the norm of kinetic energy, that nowhere increase and are at most 0: what a
    chain below a fixed point does, by pooling neighbours."""
    blocks = []
    for v, m in zip(velocity, mass, strict=True):
        blocks.append([v, m, 1])
        while len(blocks) > 1 and blocks[-2][0] < blocks[-1][0]:
            v_b, m_b, n_b = blocks.pop()
            v_a, m_a, n_a = blocks.pop()
            blocks.append([(v_a * m_a + v_b * m_b) / (m_a + m_b), m_a + m_b, n_a + n_b])
    return np.minimum(np.concatenate([np.full(n, v) for v, _, n in blocks]), 0.0)


@pytest.mark.parametrize("seed", range(5))
def test_loose_chain_against_pooling(seed):
    """Which links are taut and what they pull: the projection of the free velocities, computed without W."""
    rng = np.random.default_rng(seed)
    count = 200
    mass = BEAD_MASS * rng.uniform(0.5, 2.0, count)
    velocity = np.cumsum(rng.normal(-0.2, 1.0, count))
    problem = chain_problem(mass, velocity)
    r = extended_solution(problem)
    expected = np.diff(pooled(velocity, mass), prepend=0.0)
    u = problem.velocities(r)[:, 0]
    np.testing.assert_allclose(u, expected, atol=1e-12 * np.abs(velocity).max())
    assert 0.1 < np.mean(r[:, 0] == 0.0) < 0.9


def test_chain_is_that_of_a_scene():
    """W and q of the first step of a chain of disks under gravity, assembled by a simulation."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    beads = [scene.add(lm.disk(radius=0.01, position=(0.0, -0.03 * i), mass=BEAD_MASS)) for i in range(6)]
    beads[0].fix()
    scene.chain(beads, lm.RigidWire(), block_spin=True)
    problem = lm.Simulation(scene, time_step=1e-3).run(steps=1).problem()
    mine = chain_problem(np.full(5, BEAD_MASS), np.full(5, FALL))
    np.testing.assert_allclose(mine.W.toarray(), problem.W.toarray(), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(mine.q, problem.q, atol=1e-15)


@pytest.mark.long
def test_auto_has_all_digits_of_chains():
    """Equal beads: 1e-10 of the extended precision is the goal, cond eps of 1000 links is 4e-10; measured 1e-14."""
    for case in chains((10, 1000), (1.0,)):
        solution = lm.solve(case.problem, solver=lm.Auto(tolerance=1e-8))
        error = np.abs(solution.impulses - case.exact).max() / np.abs(case.exact).max()
        assert error < 1e-12
