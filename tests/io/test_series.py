"""Measures over time, and the history of a run as a table of pandas."""

import numpy as np
import pytest

import lmgcpy as lm


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Three balls of 10 N fall on a floor, which bears them in the end."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    for k in range(3):
        scene.add(lm.disk(radius=0.1, mass=1.0, position=(0.3 * k, 0.1 + 0.01 * k)))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    path = tmp_path_factory.mktemp("series") / "run.h5"
    observe = {"height": lambda sim: sim.positions[2, 1], "force": lambda sim: sim.interactions.force.sum(axis=0)}
    lm.Simulation(scene, time_step=1e-3).run(steps=100, record=path, every=20, observe=observe)
    return path


def test_a_measure_has_a_row_for_each_frame(file):
    with lm.io.open_run(file) as run:
        found = run.series(lm.measure.reaction, "WALL")
        assert found["frame"].tolist() == [0, 1, 2, 3, 4, 5]
        np.testing.assert_allclose(found["time"], 0.02 * np.arange(6))
        np.testing.assert_allclose(found["force"][[1, 5], 1], [-10.0, -30.0], rtol=1e-6)
        np.testing.assert_array_equal(found["force"], found["by_law.coulomb.0"])
        for k in range(6):
            np.testing.assert_array_equal(found["force"][k], lm.measure.reaction(run, "WALL", frame=k).force)


def test_functions_of_your_own_and_some_frames(file):
    with lm.io.open_run(file) as run:
        found = run.series(lambda run, frame: run.positions[frame][2, 1], frames=[-1, 0])
        np.testing.assert_allclose(found["value"], [0.1, 0.12], atol=1e-9)
        assert found["frame"].tolist() == [5, 0]
        stress = run.series(lm.measure.stress, volume=1.0)
        assert set(stress) == {"frame", "time", "total", "coulomb", "kinetic"}
        assert stress["total"].shape == (6, 2, 2)


def test_what_is_no_series_gets_a_sentence(file):
    with lm.io.open_run(file) as run:
        with pytest.raises(ValueError, match="'gap' has not the same shape in all frames"):
            run.series(lambda run, frame: {"gap": run.interactions(frame).gap})
        with pytest.raises(TypeError, match="series takes a function"):
            run.series("stress")


def test_history_and_observations_are_a_table(file):
    pandas = pytest.importorskip("pandas")
    with lm.io.open_run(file) as run:
        table = run.to_dataframe()
        assert isinstance(table, pandas.DataFrame)
        assert len(table) == 100
        np.testing.assert_array_equal(table["kinetic [J]"], run.history["kinetic"])
        np.testing.assert_array_equal(table["force[1]"], run.observed["force"][:, 1])
        assert set(table["status"]) <= {"converged", "round-off"}
        assert {"time [s]", "work:coulomb [J]", "height"} <= set(table.columns)
