"""Pictures and files of coarse-grained fields."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main


@pytest.fixture(scope="module", params=[2, 3])
def run_file(request, tmp_path_factory):
    """A row of grains that fly at different speeds along x, one of them on a floor."""
    d = request.param
    scene = lm.Scene(dimension=d, gravity=[*[0.0] * (d - 1), -10.0])
    make = lm.disk if d == 2 else lm.sphere
    for k in range(4):
        velocity = [1.0 + k, *[0.0] * (d - 1)]
        scene.add(make(radius=0.1, position=[0.3 * k, *[0.02] * (d - 2), 0.1 + 0.2 * k], mass=1.0, velocity=velocity))
    scene.add(lm.wall(point=[0.0] * d, normal=[*[0.0] * (d - 1), 1.0]))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    path = tmp_path_factory.mktemp("fields") / "run.h5"
    lm.Simulation(scene, time_step=1e-3).run(steps=4, record=path, every=2)
    return path


@pytest.fixture
def fields(run_file):
    with lm.io.open_run(run_file) as run:
        return lm.measure.coarse_fields(run, width=0.1, spacing=0.07)


def image_of(path):
    """Pixels of a PNG file, (rows, columns, channels)."""
    from matplotlib.image import imread

    return imread(path)


@pytest.mark.default_parameters("2-velocity", "3-pressure")
@pytest.mark.parametrize("what", ["density", "solid-fraction", "velocity", "pressure", "shear"])
def test_every_field_has_its_picture(fields, what, tmp_path):
    path = lm.view.draw_fields(fields, tmp_path / "field.png", what=what)
    assert path == tmp_path / "field.png"
    pixels = image_of(path)[..., :3]
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 100  # shades, not one colour


def test_a_section_is_the_nearest_plane(fields, tmp_path):
    if len(fields.axes) == 2:
        with pytest.raises(ValueError, match="cut is for fields in 3D"):
            lm.view.draw_fields(fields, tmp_path / "a.png", cut="x")
        return
    pictures = []
    for cut in ("y", ("y", 0.02), ("x", 0.0), "z"):
        pictures.append(image_of(lm.view.draw_fields(fields, tmp_path / "a.png", cut=cut)))
    assert np.array_equal(pictures[0], pictures[1])
    assert pictures[1].shape != pictures[2].shape or not np.array_equal(pictures[1], pictures[2])
    with pytest.raises(ValueError, match=r"the coordinate of cut must be at most"):
        lm.view.draw_fields(fields, tmp_path / "a.png", cut=("y", 9.0))
    with pytest.raises(TypeError, match="cut must be an axis"):
        lm.view.draw_fields(fields, tmp_path / "a.png", cut=3)


def test_paraview_reads_the_values_at_their_points(fields, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    path = lm.view.export_fields(fields, tmp_path / "fields.vti")
    image = pyvista.read(path)
    d = len(fields.axes)
    place = tuple(np.unravel_index(int(np.argmax(fields.density)), fields.density.shape))
    row = int(np.argmin(np.linalg.norm(image.points[:, :d] - fields.points[place], axis=1)))
    assert image.points[row, :d] == pytest.approx(fields.points[place], abs=1e-6)
    assert image["density"][row] == fields.density[place]
    assert image["velocity"][row] == pytest.approx([*fields.velocity[place], *[0.0] * (3 - d)])
    stress = np.zeros((3, 3))
    stress[:d, :d] = fields.stress[place]
    assert image["stress"][row].reshape(3, 3) == pytest.approx(stress)
    with pytest.raises(FileExistsError, match="exists"):
        lm.view.export_fields(fields, path)
    with pytest.raises(ValueError, match=r"must end in \.vti"):
        lm.view.export_fields(fields, tmp_path / "fields.vtp", force=True)


def lmgcpy(*arguments):
    """The command, in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_the_command_writes_what_the_name_of_the_file_says(run_file, fields, tmp_path):
    chosen = "fields", run_file, "--width", "0.1", "--spacing", "0.07"
    for name in ("a.png", "a.npz", "a.vti"):
        done = lmgcpy(*chosen, "--out", tmp_path / name)
        assert done.exit_code == 0, done.output
        assert done.output.strip() == str(tmp_path / name)
    with np.load(tmp_path / "a.npz") as arrays:
        assert (arrays["density"] == fields.density).all()
        assert (arrays["points"] == fields.points).all()
        assert arrays["contact_stress"].shape == fields.contact_stress.shape
    told = lmgcpy(*chosen, "--out", tmp_path / "a.npz")
    assert told.exit_code == 1
    assert "--force to replace it" in told.output
    told = lmgcpy(*chosen, "--what", "shear", "--out", tmp_path / "b.npz")
    assert "--what is for pictures: a .npz file holds all fields." in told.output
    told = lmgcpy(*chosen, "--out", tmp_path / "b.txt")
    assert "--out must end in .png, .svg, .pdf, .vti or .npz" in told.output
