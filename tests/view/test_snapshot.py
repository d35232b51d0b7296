"""A moment is the same from a simulation and from its run file, and its parts are where and what they must be."""

import numpy as np
import pytest
from mixed_scene import mixed_scene
from seen import hanging

import lmgcpy as lm
from lmgcpy.view.quantities import GRAINS, WIRES
from lmgcpy.view.snapshot import acting_lines, snapshot


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The mixed scene after 40 steps, and the run file of these."""
    path = tmp_path_factory.mktemp("run") / "mixed.h5"
    sim = lm.Simulation(mixed_scene(), time_step=1e-3)
    sim.run(steps=40, record=path, every=20)
    with lm.io.open_run(path) as run:
        yield sim, run


def test_a_run_shows_what_the_simulation_showed(both):
    of_sim, of_run = (snapshot(source) for source in both)
    assert of_sim.time == of_run.time
    for name in ("positions", "rotations", "velocities", "spins", "start"):
        np.testing.assert_array_equal(getattr(of_sim, name), getattr(of_run, name))
    for name in (*GRAINS, *WIRES):
        table = GRAINS if name in GRAINS else WIRES
        np.testing.assert_array_equal(table[name](of_sim)[1], table[name](of_run)[1])
    np.testing.assert_array_equal(of_sim.colors, of_run.colors)
    # levers are kept to round-off: the file holds points
    np.testing.assert_allclose(acting_lines(of_sim), acting_lines(of_run), atol=1e-12)


def test_clusters_turn_with_their_body(both):
    snap = snapshot(both[0])
    for body in both[0].scene.bodies[40:44]:
        c, s = np.cos(body.rotation), np.sin(body.rotation)
        turned = [body.position + np.array([c * x - s * y, s * x + c * y]) for _, (x, y) in body.contactors]
        np.testing.assert_allclose(snap.rounds.position[snap.rounds.body == body.id], turned, atol=1e-15)


def test_tension_is_that_of_each_link(both):
    """Chains come first among the interactions, link by link; a closed one has a link more."""
    sim, _ = both
    snap, net = snapshot(sim), sim.interactions
    joined = [pair for chain in snap.chains for pair in zip(chain.path[1:], chain.path[:-1], strict=True)]
    first = slice(0, snap.link_count)
    assert joined == list(zip(net.candidate[first], net.antagonist[first], strict=True))
    assert [len(chain.reference) for chain in snap.chains] == [7, 2, 5, 4]
    np.testing.assert_array_equal(WIRES["tension"](snap)[1], np.maximum(-net.force[first, 0], 0.0))


@pytest.mark.parametrize("dimension", [2, 3])
def test_tension_of_a_hanging_chain(dimension):
    """Link i bears the beads below it, 1 N each."""
    quantity, tension = WIRES["tension"](snapshot(hanging(3, dimension)))
    np.testing.assert_allclose(tension, [3.0, 2.0, 1.0], rtol=1e-9)
    assert quantity.label == ("tension [N/m]" if dimension == 2 else "tension [N]")


def test_arc_length_goes_on_along_each_chain():
    _, length = WIRES["length"](snapshot(hanging(3)))
    np.testing.assert_allclose(length, [0.5, 1.5, 2.5], atol=1e-4)  # the chain has fallen by (h^2 g)


def test_a_load_on_a_wire_is_no_bead():
    """In space beads are hidden in their wire; a ball that hangs from it is not."""
    scene = lm.Scene(dimension=3)
    line = [scene.add(lm.sphere(radius=0.02 if i < 4 else 0.1, position=(0.3 * i, 0.0, 0.0), mass=1.0)) for i in range(5)]
    scene.add(lm.sphere(radius=0.02, position=(0.0, 1.0, 0.0), mass=1.0))
    scene.chain(line, lm.RigidWire())
    assert snapshot(scene).beads.tolist() == [True] * 4 + [False] * 2


def test_a_scene_is_a_moment_without_forces():
    scene = mixed_scene()
    snap = snapshot(scene)
    assert snap.time is None
    assert snap.forces is None
    np.testing.assert_array_equal(snap.positions, snap.start)
    with pytest.raises(ValueError, match="run a Simulation of the scene first"):
        GRAINS["coordination"](snap)


def test_before_the_first_step_nothing_acts(both):
    snap = snapshot(both[1], 0)
    assert (snap.forces.link == 0.0).all()
    assert len(snap.forces.link) == snap.link_count
    assert (GRAINS["coordination"](snap)[1] == 0.0).all()


def test_frames_there_are_not_and_sources_that_are_none(both):
    sim, run = both
    with pytest.raises(ValueError, match=r"has 3 frames, 0 to 2, got frame 3\."):
        snapshot(run, 3)
    assert snapshot(run, -3).time == 0.0
    with pytest.raises(TypeError, match="frame is for run files"):
        snapshot(sim, 0)
    with pytest.raises(TypeError, match=r"a Scene, a Simulation, or a run .* got 'run.h5' as source\."):
        snapshot("run.h5")
