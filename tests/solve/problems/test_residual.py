"""The number by which the solver stops, once more in numpy with the interpreted laws: |e(r)| / |e(0)|."""

from __future__ import annotations

import numpy as np
import pytest
from dense import dense_step, state_velocities
from mixed_scene import LAWS, mixed_scene

import lmgcpy as lm


def parts(scene, sim):
    """(law, reference gap, parameters) of every interaction, in canonical order; of contacts the gap that the step before
    predicted, as the step has it."""
    view, known = sim.interactions, sim.last_step[0].data.reference_gap
    found = []
    for chain in scene.chains:
        table = chain.law.table(chain.radius_sums + chain.reference_gap)
        found += [(chain.law, g, tuple(row)) for g, row in zip(chain.reference_gap, table, strict=True)]
    for name, reference_gap in zip(view.law[len(found) :], known[len(found) :], strict=True):
        found.append((LAWS[name], reference_gap, tuple(LAWS[name].table(np.zeros(1))[0])))
    return found


def errors(scene, sim, problem, r):
    """e of every interaction as a vector [m/s], for impulses r (m, 2)."""
    view = sim.interactions
    u = (problem.free + problem.W @ r.ravel()).reshape(-1, 2)
    before = problem.before.reshape(-1, 2)
    found = []
    for i, (law, reference_gap, parameters) in enumerate(parts(scene, sim)):
        rows = law.rows(2)
        block = problem.W[2 * i : 2 * i + rows, 2 * i : 2 * i + rows]
        w = np.trace(block) / rows
        prepared = law.prepare(view.gap[i], reference_gap, tuple(before[i, :rows]), sim.time_step, parameters, ())
        W = tuple(tuple(row) for row in w * np.eye(rows))
        new = law.react(W, tuple(u[i, :rows] - w * r[i, :rows]), prepared)
        found.append(w * (r[i, :rows] - np.array(new)))
    return found


def norm(found):
    return np.sqrt(sum(float(e @ e) for e in found))


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("wire_blocks", [True, False])
@pytest.mark.parametrize("seed", range(2))
def test_the_residual_is_what_it_is_said_to_be(seed, wire_blocks):
    """In a scene of everything, at steps with and without collisions, at a loose tolerance, so that it is a number.

    Full H and W from frames and levers, the laws interpreted, the norm over all interactions. The kernels come from
    velocities that they update sweep by sweep; what that leaves, 1e-15 of |u|, is small beside errors of 1e-4.
    """
    scene = mixed_scene(seed)
    solver = lm.GaussSeidel(tolerance=1e-3, max_iterations=40, wire_blocks=wire_blocks)
    sim = lm.Simulation(scene, time_step=2e-3, theta=0.7, solver=solver, on_unconverged="ignore")
    seen = set()
    for step in range(120):
        before = state_velocities(sim)
        sim.step()
        if step % 10:
            continue
        problem = dense_step(sim, before)
        r = sim.interactions.impulse
        done, nothing = errors(scene, sim, problem, r), errors(scene, sim, problem, np.zeros_like(r))
        assert sim.report.residual == pytest.approx(norm(done) / norm(nothing), rel=1e-6, abs=1e-12)
        # the worst interaction, by what its error moves it in parts of its smaller body, and its error
        sizes = np.array([np.linalg.norm(e) for e in done])
        view, report = sim.interactions, sim.report.worst
        radius = np.minimum(sim.model.extent[view.candidate], sim.model.extent[view.antagonist])
        shares = sim.time_step * sizes / radius
        worst = int(np.argmax(shares))
        assert sim.report.slip == pytest.approx(shares[worst], rel=1e-6, abs=1e-12)
        if sizes[worst] > 1e-12:
            who = view.law[worst], view.candidate[worst], view.antagonist[worst]
            assert (report.law, report.candidate, report.antagonist) == who
            assert report.error == pytest.approx(sizes[worst], rel=1e-6)
        assert sim.report.interactions == len(view)
        seen |= set(view.law[np.abs(r[:, 0]) > 0.0])
    assert seen == set(LAWS)


def test_the_velocities_are_those_of_the_impulses():
    """v = v_free + M^-1 H r to round-off, however many sweeps updated them: they are made anew at the end."""
    sim = lm.Simulation(mixed_scene(1), time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-6))
    sim.run(steps=60)
    before = state_velocities(sim)
    sim.step()
    problem = dense_step(sim, before)
    assert len(sim.interactions) > 30
    relative = problem.H.T @ state_velocities(sim).ravel()
    expected = problem.free + problem.W @ sim.interactions.impulse.ravel()
    # driven bodies do not get H r: their part of W is zero
    assert relative == pytest.approx(expected, abs=1e-12)


def test_local_blocks_are_those_of_the_dense_operator():
    """W_nn, W_tt and W_nt of every interaction, and the coupling of consecutive links."""
    sim = lm.Simulation(mixed_scene(0), time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-6))
    sim.run(steps=60)
    before = state_velocities(sim)
    sim.step()
    problem = dense_step(sim, before)
    system = sim.last_step[0].system
    links = 7 + 2 + 5 + 4
    diagonal = np.diag(problem.W).reshape(-1, 2)
    assert system.delassus[:, 0] == pytest.approx(diagonal[:, 0], rel=1e-12)
    assert system.delassus[links:, 1] == pytest.approx(diagonal[links:, 1], rel=1e-12)
    off = np.diag(problem.W, 1)[::2]
    assert system.coupling[links:] == pytest.approx(off[links:], abs=1e-13)
    normal = problem.W[::2, ::2]
    assert system.coupling[:6] == pytest.approx(np.diag(normal, 1)[:6], rel=1e-12)
    assert system.coupling[6] == 0.0  # the wire ends
    ring = normal[14:18, 14:18]
    assert system.coupling[14:18] == pytest.approx([ring[0, 1], ring[1, 2], ring[2, 3], ring[3, 0]], rel=1e-12)
    assert np.abs(off[links:]).max() > 1e-3
