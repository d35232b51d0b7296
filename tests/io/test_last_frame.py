"""The last frame of a run is where the run ended."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import lmgcpy as lm


def scene():
    made = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    made.add(lm.disk(radius=0.1, position=(0.0, 0.5), mass=1.0))
    made.add(lm.disk(radius=0.1, position=(0.3, 0.1), mass=1.0))
    made.chain(made.bodies[:2], lm.RigidWire())
    made.add(lm.wall(point=(0, 0), normal=(0, 1)))
    made.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return made


@pytest.mark.default_parameters(how=("steps", "resumed"), every=(7,))
@pytest.mark.parametrize("every", [1, 7, 10, 100])
@pytest.mark.parametrize("how", ["steps", "until", "resumed", "nothing"])
def test_the_last_frame_is_where_the_run_ended(every, how, tmp_path):
    """``Scene.from_run`` gives the state that the script sees when ``run`` returns. No step has two frames."""
    path = tmp_path / "run.h5"
    sim = lm.Simulation(scene(), time_step=1e-3)
    if how == "nothing":
        sim.run(steps=0, record=path, every=every)
    else:
        sim.run(steps=40 if how == "until" else 29, until=lambda sim: sim.steps == 29, record=path, every=every)
    if how == "resumed":
        sim = lm.resume(path).run(steps=12)
    with lm.io.open_run(path) as run:
        assert run.steps[-1] == sim.steps
        assert run.times[-1] == sim.time
        assert np.array_equal(run.positions[-1], sim.positions)
        assert np.array_equal(run.velocities[-1], sim.velocities)
        frames = np.asarray(run.steps).tolist()
        assert frames == sorted({sim.steps} | set(range(0, sim.steps + 1, every)))  # none of step 29 where it went on
    again = lm.Scene.from_run(path)
    assert np.array_equal(again.bodies[0].position, sim.positions[0])
    assert np.array_equal(again.bodies[1].velocity, sim.velocities[1])


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda scene: pickle.loads(pickle.dumps(scene))], ids=["copy", "pickle"])
def test_a_copy_of_a_scene_is_a_scene_of_its_own(copied):
    """To the bits of its steps; what is said of one is not said of the other."""
    original = scene()
    original.bodies[1].impose_force(x=1.0)
    other = copied(original)
    other.bodies[1].free("x")
    other.bodies[0].fix()
    runs = [
        lm.Simulation(made, time_step=1e-3).run(steps=50).state.positions for made in (copied(original), original, other)
    ]
    assert np.array_equal(runs[0], runs[1])
    assert other.chains[0].bodies[0] is other.bodies[0]
    assert runs[2][0, 1] == 0.5 != runs[1][0, 1]
