"""The same input gives the same bits."""

from __future__ import annotations

import numpy as np
from mixed_scene import mixed_scene

import lmgcpy as lm


def run(steps, pieces=1):
    sim = lm.Simulation(mixed_scene(), time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-3))
    for _ in range(pieces):
        sim.run(steps=steps // pieces)
    return sim


def test_a_run_repeats_itself_to_the_bit():
    first, second = run(150), run(150)
    assert np.array_equal(first.state.positions, second.state.positions)
    assert np.array_equal(first.state.velocities, second.state.velocities)
    assert np.array_equal(first.interactions.impulse, second.interactions.impulse)
    assert first.energy == second.energy
    assert first.report.residual == second.report.residual


def test_a_run_in_pieces_is_the_whole_run():
    whole, pieces = run(150), run(150, pieces=10)
    assert np.array_equal(whole.state.positions, pieces.state.positions)
    assert whole.energy == pieces.energy


def test_looking_does_not_disturb():
    """Interactions, problem, energy and printing between the steps change nothing."""
    quiet, watched = run(60), run(0)
    for _ in range(60):
        watched.step()
        _ = (watched.energy.mechanical, repr(watched), str(watched.report), repr(watched.interactions))
    assert np.array_equal(quiet.state.positions, watched.state.positions)


def test_two_simulations_side_by_side_do_not_mix():
    """Kernels are shared, their arrays are not."""
    alone = run(60)
    one, other = run(0), lm.Simulation(mixed_scene(5), time_step=1e-3)
    for _ in range(60):
        one.step()
        other.step()
    assert np.array_equal(alone.state.positions, one.state.positions)
