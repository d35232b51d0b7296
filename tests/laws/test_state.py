"""Laws that keep numbers for each interaction: when these begin, change, end, and come back from a checkpoint."""

import numpy as np
import pytest
from stateful import Brittle, Touched

import lmgcpy as lm


@pytest.fixture(autouse=True)
def registered():
    lm.laws.register(Brittle)
    lm.laws.register(Touched)
    yield
    for law in (Brittle, Touched):
        lm.laws.registry._laws.pop(law.NAME)


def hanging(strength=55.0, loads=(5.0, 10.0, 20.0, 30.0)):
    """Four beads below a fixed one, each with a load: the link i carries the loads from i down."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(0.0, -0.3 * i), mass=0.1)) for i in range(5)]
    beads[0].fix()
    for bead, load in zip(beads[1:], loads, strict=True):
        bead.impose_force(y=-load)
    scene.chain(beads, Brittle(strength=strength))
    return lm.Simulation(scene, time_step=1e-3)


def test_a_wire_breaks_where_its_tension_passes_the_strength_and_stays_broken():
    """Tensions 65, 60, 50, 30 N against 55 N: two links break in the first step and the rest falls freely."""
    sim = hanging()
    sim.run(steps=1)
    assert sim.interactions.state["greatest"] == pytest.approx([65.0, 60.0, 50.0, 30.0], rel=1e-9)
    assert list(sim.interactions.state["broken"]) == [1, 1, 0, 0]
    sim.run(steps=99)
    assert list(sim.interactions.state["broken"]) == [1, 1, 0, 0]
    assert list(sim.interactions.force[:2, 0]) == [0.0, 0.0]
    assert sim.velocities[1, 1] == pytest.approx(-5.0 / 0.1 * 0.099, rel=1e-9)  # alone with its load since the break
    assert sim.velocities[2, 1] == pytest.approx(-60.0 / 0.3 * 0.099, rel=1e-9)  # with the two below


def billiards(seed=5):
    """Disks in a closed box, fast enough to meet, part and meet again, and to make the neighbour lists anew."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2)
    for i in range(16):
        place = (0.25 * (i % 4) + 0.13, 0.25 * (i // 4) + 0.13)
        scene.add(lm.disk(radius=0.08, position=place, velocity=rng.normal(0.0, 2.0, 2), mass=1.0))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((1, 0), (-1, 0)), ((0, 1), (0, -1))):
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", Touched(friction=0.3), alert=0.03)
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=1.0, friction=0.2), alert=0.05)
    return lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))


def test_a_state_lives_as_long_as_its_contact_is_within_alert():
    """Followed from outside, by pair: born when the contact appears, counted on at each step, new after a parting."""
    sim = billiards()
    alive: dict = {}
    partings = 0
    for step in range(400):
        time = sim.time
        sim.step()
        net = sim.interactions
        touched = net.law == "test-touched"
        assert np.isnan(net.state["steps"][~touched]).all()
        seen = {}
        for i in np.flatnonzero(touched):
            pair = int(net.candidate[i]), int(net.antagonist[i])
            born, steps = alive.get(pair, (time, 0))
            seen[pair] = born, steps + 1
            assert (net.state["born"][i], net.state["steps"][i]) == seen[pair], (step, pair)
        partings += len(set(alive) - set(seen))
        alive = seen
    assert partings >= 10
    assert sim._detector.rebuilds > 5


def test_commit_is_given_the_gap_the_velocity_and_the_impulse_of_the_step():
    sim = billiards()
    acted = 0
    for _ in range(200):
        sim.step()
        net = sim.interactions
        touched = net.law == "test-touched"
        v = sim.velocities[net.candidate] - sim.velocities[net.antagonist]
        normal_velocity = np.einsum("md,md->m", v, net.normal)  # disks: spin does not move the contact along n
        predicted = net.gap + sim.time_step * normal_velocity
        # round-off of velocities of some m/s, times the step, and of the gap itself
        assert net.state["predicted"][touched] == pytest.approx(predicted[touched], abs=1e-15)
        assert np.array_equal(net.state["pushed"][touched], net.force[touched, 0])
        assert np.array_equal(net.state["sheared"][touched], net.force[touched, 1])
        acted += int((net.force[touched, 0] > 0.0).sum())
    assert acted > 5


@pytest.mark.default_parameters("hanging")
@pytest.mark.parametrize("make", [hanging, billiards])
def test_a_run_from_a_checkpoint_has_the_same_states(make):
    whole, half, rest = make(), make(), make()
    whole.run(steps=150)
    half.run(steps=70)
    rest.restore(half.checkpoint())
    rest.run(steps=80)
    assert np.array_equal(whole.positions, rest.positions)
    for name, column in whole.interactions.state.items():
        assert np.array_equal(column, rest.interactions.state[name], equal_nan=True)


@pytest.mark.default_parameters("billiards")
@pytest.mark.parametrize("make", [hanging, billiards])
def test_a_run_from_a_file_has_the_same_states(make, tmp_path):
    whole = make()
    whole.run(steps=150)
    make().run(steps=70, record=tmp_path / "run.h5", every=20)
    rest = lm.resume(tmp_path / "run.h5").run(steps=80)
    assert np.array_equal(whole.positions, rest.positions)
    for name, column in whole.interactions.state.items():
        assert np.array_equal(column, rest.interactions.state[name], equal_nan=True)


def test_a_state_that_is_not_finite_stops_the_run():
    class Faulty(Brittle):
        NAME = "test-faulty"

        @staticmethod
        def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
            return (state[0] / impulse[0], 0.0)

    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.0), mass=1.0)) for i in range(3)]
    scene.chain(beads, Faulty(strength=1.0))
    with pytest.raises(FloatingPointError, match=r"commit of law 'test-faulty' between bodies 1 and 0 .* not finite"):
        lm.Simulation(scene, time_step=1e-3).run(steps=1)


def test_a_scene_without_states_keeps_the_predicted_gap_only():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=2)
    assert sim._detector.give_memory().state.tolist() == [[0.0]]
    assert sim.interactions.state == {}


def test_the_state_of_a_contact_goes_on_from_feature_to_feature_of_a_surface():
    """A disk slides over the joints of a polyline: its law, which counts its steps, does not begin anew."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.disk(radius=0.1, position=(0.02, 0.1), velocity=(2.0, 0.0), mass=1.0))
    scene.add(lm.wall_segment(*[(0.05 * k, 0.0) for k in range(21)]))
    scene.see("GRAIN", "WALL", Touched(friction=0.1))
    sim = lm.Simulation(scene, time_step=1e-3)
    features = set()
    for step in range(1, 300):
        sim.step()
        memory = sim._detector.give_memory()
        (touching,) = np.flatnonzero(memory.impulse[:, 0] > 0.0)
        assert memory.state[touching, 1] == step
        features.add(tuple(memory.identity[touching].tolist()))
    assert len(features) > 8
