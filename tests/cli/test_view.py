"""The commands that show runs. What pictures and curves show is tested in tests/view."""

import sys

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import lmgcpy as lm
from lmgcpy.cli import main


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Two spheres that overlap by a fifth of their radius, one of them falling, in 3 frames."""
    path = tmp_path_factory.mktemp("run") / "falls.h5"
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -10.0))
    scene.add(lm.sphere(radius=0.1, position=(0.0, 0.0, 0.1), mass=1.0))
    scene.add(lm.sphere(radius=0.1, position=(0.18, 0.0, 0.1), mass=1.0)).fix()
    scene.add(lm.wall(point=(0, 0, -1), normal=(0, 0, 1)))
    lm.Simulation(scene, time_step=1e-3).run(steps=20, record=path, every=10)
    return path


def run(*arguments):
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == 0, done.output
    return done.output


def width_and_height(path):
    with Image.open(path) as image:
        return image.size


def test_render_names_its_file(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("render", file, "--size", "80,80") == "falls-grains.png\n"
    assert max(width_and_height("falls-grains.png")) >= 80


@pytest.mark.long
def test_several_frames_and_cameras_stand_side_by_side(file, tmp_path):
    """Three frames of a panel of one size make a plate three times as wide."""
    one, three, both = (tmp_path / f"{name}.png" for name in ("one", "three", "both"))
    options = ("--grains", "plain", "--size", "80,200", "--title", "")
    run("render", file, *options, "--out", one, "--camera", "y", "--frame", "0")
    frames = [word for k in (0, 0, 0) for word in ("--frame", str(k))]
    run("render", file, *options, "--out", three, "--camera", "y", *frames)
    run("render", file, *options, "--out", both, "--camera", "x", "--camera", "1,-2,0.5", "--frame", "0", "--frame", "2")
    assert width_and_height(three) == (3 * width_and_height(one)[0], width_and_height(one)[1])
    assert width_and_height(both)[0] > width_and_height(one)[0]


def test_a_layout_comes_with_its_table(file, tmp_path):
    """The free ball has fallen by half of g t^2, 2 mm; at the start they overlapped by 0.2 of the radius."""
    told = run("render", file, "--what", "layout", "--frame", "0", "--size", "80,80", "--out", tmp_path / "a.png")
    assert "overlaps: 1; links longer than their reference: 0" in told
    assert "20 %" in told
    assert told.endswith("a.png\n")


@pytest.mark.long
def test_a_moving_picture(file, tmp_path):
    run("render", file, "--size", "60,60", "--fps", "10", "--clip", "y=0.5", "--out", tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as image:
        assert (image.n_frames, image.info["duration"]) == (3, 100)


def test_a_section_and_its_scale(file, tmp_path):
    options = ("--section", "y=0.0", "--grains", "radius", "--limits", "0,0.2", "--size", "100,100")
    run("render", file, *options, "--out", tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    from lmgcpy.view.quantities import RADIUS

    (half,) = RADIUS.colors(np.array([0.1]), (0.0, 0.2))
    assert (np.abs(pixels.astype(int) - half).max(axis=1) <= 3).sum() > 100


@pytest.mark.default_parameters("energy")
@pytest.mark.parametrize("what", ["reaction", "energy", "solver"])
def test_plot(what, file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("plot", file, file, "--what", what) == f"{what}.png\n"
    assert width_and_height(f"{what}.png")[0] > 900


def test_export_in_both_ways(file, tmp_path):
    told = run("export", file, "--csv", tmp_path / "csv", "--vtk", tmp_path / "vtk").splitlines()
    assert [line.rpartition("/")[2] for line in told[-4:]] == ["bodies.pvd", "forces.pvd", "wires.pvd", "walls.pvd"]
    assert any(line.endswith("bodies.csv") for line in told)


def test_without_pyvista_the_commands_say_what_to_install(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "vtkmodules.vtkIOXML", None)
    for command in (("render", file), ("view", file), ("export", file, "--vtk", "out")):
        done = CliRunner().invoke(main, [str(word) for word in command])
        assert done.exit_code == 1
        assert done.output.endswith('is not installed: pip install "lmgcpy[view]".\n'), done.output
    assert not list(tmp_path.iterdir())
    run("plot", file)


@pytest.mark.default_parameters("command1")
@pytest.mark.parametrize("command", [["render"], ["plot", "--what", "solver"]])
def test_a_picture_replaces_no_file_without_force(command, file, tmp_path):
    """As everywhere else; before, what lay there was gone."""
    target = tmp_path / "thesis.png"
    target.write_text("mine")
    name, *options = command
    refused = CliRunner().invoke(main, [name, str(file), *options, "--out", str(target)])
    assert refused.exit_code != 0
    assert "exists: give another name by --out, or --force to replace it" in refused.output
    assert target.read_text() == "mine"
    written = CliRunner().invoke(main, [name, str(file), *options, "--out", str(target), "--force"])
    assert written.exit_code == 0, written.output
    assert target.read_bytes().startswith(b"\x89PNG")
