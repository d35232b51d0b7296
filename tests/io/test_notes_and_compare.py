"""Notes of the user in a run, the table of several files, and what a comparison says first."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main


def fall(friction=0.3, time_step=1e-3, gravity=-9.81, radius=0.1, stiffness=None, **options):
    """A disk that slides on a floor."""
    scene = lm.Scene(dimension=2, gravity=(0.0, gravity))
    bodies = [scene.add(lm.disk(radius=radius, position=(x, 0.1), mass=1.0, velocity=(1.0, 0.0))) for x in (0.0, 1.0)]
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    if stiffness is not None:
        scene.chain(bodies, lm.ElasticWire(stiffness=1.0), parameters={"stiffness": [stiffness]})
    return lm.Simulation(scene, time_step=time_step, **options)


def recorded(path, notes=None, **options):
    fall(**options).run(steps=5, record=path, every=1, notes=notes)
    return path


NOTES = {
    "sample": "loose",
    "batch": 3,
    "radii": np.array([0.5, 1.0]),
    "nested": {"a": [1, None, True]},
    "x": np.float64(0.5),
}


def test_notes_come_back_and_are_shown(tmp_path):
    path = recorded(tmp_path / "run.h5", notes=NOTES)
    with lm.io.open_run(path) as run:
        assert run.notes == {**NOTES, "radii": [0.5, 1.0], "x": 0.5}
    lm.resume(path).run(steps=2)
    with lm.io.open_run(path) as run:
        assert run.notes["batch"] == 3
    shown = CliRunner().invoke(main, ["info", str(path)])
    assert "batch: 3" in shown.output
    assert "sample: loose" in shown.output


@pytest.mark.parametrize(
    ("notes", "error", "words"),
    [
        ("loose", TypeError, "notes are words and numbers by name"),
        ({3: "x"}, TypeError, "notes are words and numbers by name"),
        ({"f": print}, ValueError, "notes must be words, numbers, and lists or dictionaries of these"),
        ({"x": float("nan")}, ValueError, "notes must be words, numbers"),
        ({"x": "y" * 200_000}, ValueError, "at most 100000 are kept"),
    ],
)
def test_notes_that_no_file_can_hold_get_a_sentence(tmp_path, notes, error, words):
    with pytest.raises(error, match=words):
        recorded(tmp_path / "run.h5", notes=notes)
    assert not list(tmp_path.iterdir())


def test_notes_without_a_file_get_a_sentence():
    with pytest.raises(TypeError, match="notes are kept in the run file that record= begins"):
        fall().run(steps=1, notes={"a": 1})


def test_several_files_are_a_table(tmp_path):
    paths = [recorded(tmp_path / f"{name}.h5", notes={"name": name}) for name in ("one", "two")]
    shown = CliRunner().invoke(main, ["info", *map(str, paths)])
    assert shown.exit_code == 0, shown.output
    head, *rows = shown.output.splitlines()
    assert head.split()[:4] == ["file", "state", "bodies", "steps"]
    assert len(rows) == 2
    for row, path, name in zip(rows, paths, ("one", "two"), strict=True):
        assert row.startswith(str(path))
        assert "closed" in row
        assert "coulomb(friction=0.3)" in row
        assert row.endswith(f"name: {name}")


@pytest.mark.default_parameters("one1-other1-'options time_step' is 0.001 in the first and 0.002 in the second")
@pytest.mark.parametrize(
    ("one", "other", "words"),
    [
        ({}, {"friction": 0.4}, "'laws 0 parameters friction' is 0.3 in the first and 0.4 in the second"),
        ({}, {"time_step": 2e-3}, "'options time_step' is 0.001 in the first and 0.002 in the second"),
        ({}, {"gravity": -9.0}, "'gravity' is -9.81 in the first and -9.0 in the second, in row 1"),
        ({}, {"radius": 0.09}, "'bodies extent' is 0.1 in the first and 0.09 in the second, in row 0"),
        (
            {"stiffness": 5.0},
            {"stiffness": 6.0},
            "'chains parameters 0 stiffness' is 5.0 in the first and 6.0 in the second",
        ),
    ],
)
def test_a_comparison_names_what_was_given_differently(tmp_path, one, other, words):
    paths = [recorded(tmp_path / f"{k}.h5", **given) for k, given in enumerate((one, other))]
    with lm.io.open_run(paths[0]) as a, lm.io.open_run(paths[1]) as b:
        found = lm.io.compare(a, b)
    assert found is not None
    assert words in found.parameter
    assert str(found).startswith(f"Their {found.parameter}. They differ in ")


def test_equal_runs_with_other_parameters_are_equal(tmp_path):
    """A law that never acted: nothing differs, and nothing is said."""
    paths = [recorded(tmp_path / f"{k}.h5", gravity=0.0, friction=mu) for k, mu in enumerate((0.3, 0.4))]
    with lm.io.open_run(paths[0]) as a, lm.io.open_run(paths[1]) as b:
        assert lm.io.compare(a, b) is None
