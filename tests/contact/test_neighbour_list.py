"""The list of neighbours is an economy that no result may show: neither its rebuilding, nor the memory of impulses."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.memory import LastStep


def stack_and_flyer(flyer_first):
    """Eight disks at rest on a floor, each on the next, and one that flies by at a distance and changes the list.

    With the flyer first all ids, and so all places in the arrays, shift when it comes near.
    """
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    stack = [lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0) for i in range(8)]
    # it keeps its height: a free disk of a colour that sees the stack, held in y
    flyer = lm.disk(radius=0.1, position=(-3.0, 0.9), mass=1.0, velocity=(4.0, 0.0), color="FLYER").fix("y", "spin")
    for body in [flyer, *stack] if flyer_first else [*stack, flyer]:
        scene.add(body)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.see("FLYER", "GRAIN", lm.Coulomb(friction=0.3), alert=0.02)
    return lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-8))


@pytest.mark.default_parameters("True")
@pytest.mark.parametrize("flyer_first", [False, True])
def test_impulses_are_kept_through_a_rebuild(flyer_first):
    """After the first step, of dozens of sweeps, the warm start of a stack at rest is the solution, whatever the list
    does: a few sweeps now and then, where the gaps that the first tolerance has left open close.

    The flyer moves 4 mm a step, through half the skin of 20 mm every few steps, and is looked at short of the stack.
    """
    sim = stack_and_flyer(flyer_first)
    sim.step()
    assert sim.report.iterations > 50
    rebuilds = sim._detector.rebuilds
    for _ in range(650):  # to x = -0.4 m
        sim.step()
        assert sim.report.iterations <= 4
    assert sim._detector.rebuilds > rebuilds + 20
    assert len(sim._detector.groups) == 2  # it is not listed yet
    sim.run(steps=43)  # to x = -0.224 m
    assert len(sim._detector.groups) == 3
    assert len(sim.interactions) == 8
    assert sim.report.iterations <= 4


def heap(seed=3):
    """Forty disks of different size thrown into a box, with a wire of six among them and clusters."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(40):
        position = (0.3 * (i % 8) + 0.15, 0.3 * (i // 8) + 0.3)
        radius = rng.uniform(0.06, 0.12)
        velocity = rng.normal(0.0, 1.0, 2)
        scene.add(lm.disk(radius=radius, position=position, mass=radius**2, velocity=velocity, spin=rng.normal()))
    for point, normal in [((0, 0), (0, 1)), ((0, 0), (1, 0)), ((2.4, 0), (-1, 0))]:
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.chain(scene.bodies[0:6], lm.RigidWire())
    return lm.Simulation(scene, time_step=5e-4, solver=lm.GaussSeidel(tolerance=1e-4, max_iterations=100))


@pytest.mark.long
def test_the_motion_does_not_depend_on_when_the_list_was_made():
    """To the bit, though the solver stops early and starts from the impulses that it remembers.

    One of the two is made to list its neighbours anew in every step.
    """
    usual, eager = heap(), heap()
    for _ in range(400):
        usual.step()
        eager._detector._listed_at = None
        eager.step()
    assert eager._detector.rebuilds == 400
    assert 2 < usual._detector.rebuilds < 200
    assert len(usual.interactions) > 25
    assert np.array_equal(usual.positions, eager.positions)
    assert np.array_equal(usual.velocities, eager.velocities)
    assert np.array_equal(usual.interactions.impulse, eager.interactions.impulse)


def test_every_contact_within_alert_is_found():
    """Against all pairs, at steps in between: the skin is wide enough."""
    sim = heap()
    radii = sim.model.radius
    for _ in range(100):
        start, before = sim.positions.copy(), sim.velocities.copy()
        sim.step()
        q = start + 0.5 * sim.time_step * before
        i, j = np.triu_indices(40, 1)
        gap = np.hypot(*(q[i] - q[j]).T) - radii[i] - radii[j]
        near = {(a, b) for a, b, g in zip(i, j, gap, strict=True) if g <= 0.2 * radii[:40].min()}
        view = sim.interactions
        listed = (view.law == "coulomb") & (view.antagonist < 40)
        found = set(zip(view.candidate[listed].tolist(), view.antagonist[listed].tolist(), strict=True))
        assert near <= found


def test_a_new_contact_starts_from_nothing_and_a_lost_one_is_forgotten():
    """A disk that leaves the floor and comes back: its impulse of the last stay must not be its first guess."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0).impose_force(y=lambda t: 40.0 if 0.01 < t < 0.1 else 0.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=5)
    assert sim._detector.give_memory().impulse[0, 0] == pytest.approx(10.0 * 1e-3, rel=1e-12)
    sim.run(steps=60)
    assert len(sim.interactions) == 0
    assert len(sim._detector.give_memory().impulse) == 0


def test_impulses_are_replaced_and_states_stay():
    """Of interactions that were seen now and then, only now, and only then, in slots 4, 7 and 2."""
    memory = LastStep(components=2, width=1)
    memory.remember(np.array([2, 4], np.int32), np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[5.0], [6.0]]))
    memory.replace_impulses(np.array([4, 7], np.int32), np.array([[7.0, 8.0], [9.0, 10.0]]))
    impulse, state = np.empty((4, 2)), np.empty((4, 1))
    memory.recall(np.array([2, 3, 4, 7], np.int32), impulse, state)
    np.testing.assert_array_equal(impulse, [[1.0, 2.0], [0.0, 0.0], [7.0, 8.0], [9.0, 10.0]])
    np.testing.assert_array_equal(state, [[5.0], [np.nan], [6.0], [np.nan]])
