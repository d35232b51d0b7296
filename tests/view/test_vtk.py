"""Files for ParaView, read again by VTK: what they hold is what the run holds."""

import sys
import xml.etree.ElementTree as tree

import numpy as np
import pytest
from mixed_scene import mixed_scene
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

import lmgcpy as lm


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """A run of 40 steps and its export: (run, folder)."""
    folder = tmp_path_factory.mktemp("vtk")
    lm.Simulation(mixed_scene(), time_step=2e-3).run(steps=300, record=folder / "a.h5", every=150)
    with lm.io.open_run(folder / "a.h5") as run:
        written = lm.view.export_vtk(run, folder / "out")
        assert [path.name for path in written] == ["bodies.pvd", "forces.pvd", "wires.pvd", "walls.pvd"]
        yield run, folder / "out"


def series(folder, part):
    """Times and data of a part."""
    rows = tree.parse(folder / f"{part}.pvd").getroot().findall("Collection/DataSet")
    return [float(row.get("timestep")) for row in rows], [read(folder / row.get("file")) for row in rows]


def read(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


def arrays(attributes):
    return {attributes.GetArrayName(i): vtk_to_numpy(attributes.GetArray(i)) for i in range(attributes.GetNumberOfArrays())}


def words(data, name):
    array = data.GetFieldData().GetAbstractArray(name)
    return [array.GetValue(i) for i in range(array.GetNumberOfValues())]


def ends(data):
    """Of its lines, (c, 2, 3)."""
    members = vtk_to_numpy(data.GetLines().GetConnectivityArray()).reshape(-1, 2)
    return vtk_to_numpy(data.GetPoints().GetData())[members]


def test_a_frame_a_time(exported):
    run, folder = exported
    for part in ("bodies", "forces", "wires", "walls"):
        times, data = series(folder, part)
        assert times == run.times.tolist()
        assert len(data) == run.frame_count


def test_bodies(exported):
    run, folder = exported
    _, (_, _, last) = series(folder, "bodies")
    found = arrays(last.GetPointData())
    centre = found["body"] < 40  # disks that are bodies of their own
    points = vtk_to_numpy(last.GetPoints().GetData())
    np.testing.assert_array_equal(points[centre, :2], run.positions[-1][:40])
    assert (points[:, 2] == 0.0).all()
    np.testing.assert_array_equal(found["velocity"][centre, :2], run.velocities[-1][:40])
    np.testing.assert_array_equal(found["spin"][centre, 2], run.spins[-1][:40])
    np.testing.assert_array_equal(found["radius"][centre], run.extent[:40])
    assert (np.bincount(found["body"])[40:44] == 2).all()  # clusters have a point a disk
    net = run.interactions(-1)
    links = len(net.gap[net.law == "rigid-wire"]) + 2 + 5 + 4
    pushing = np.flatnonzero(net.force[:, 0] > 0.0)
    pairs = [(net.candidate[i], net.antagonist[i]) for i in pushing if i >= links]
    for body in range(40):
        assert found["coordination"][found["body"] == body] == sum(body in pair for pair in pairs)
    assert words(last, "color_names")[found["color"][0]] == "GRAIN"


def test_forces_are_the_interactions_that_act(exported):
    run, folder = exported
    for frame, data in enumerate(series(folder, "forces")[1]):
        net, found = run.interactions(frame), arrays(data.GetCellData())
        acting = net.force.any(axis=1)
        assert data.GetNumberOfCells() == acting.sum()
        in_space = np.einsum("mk,mkd->md", net.force, net.frame)[acting]
        np.testing.assert_array_equal(found["force"][:, :2], in_space)
        np.testing.assert_array_equal(found["normal_force"], net.force[acting, 0])
        link = np.isin(net.law[acting], ["rigid-wire", "rigid-rod", "elastic-wire", "voigt-rod"])
        np.testing.assert_array_equal(found["tension"], np.where(link, np.maximum(-net.force[acting, 0], 0.0), 0.0))
        names = words(data, "law_names")
        assert [names[code] for code in found["law"]] == net.law[acting].tolist()
    assert acting.sum() > 20
    assert found["tension"].max() > 0.0
    # lines run between the bodies' centres, and where one is a wall from the contact point, along the normal
    line = ends(data)[:, 1, :2] - ends(data)[:, 0, :2]
    both = (found["candidate"] < 40) & (found["antagonist"] < 40)
    apart = run.positions[-1][found["candidate"]] - run.positions[-1][found["antagonist"]]
    np.testing.assert_allclose(line[both], apart[both], atol=1e-14)


def test_wires_bear_their_tension(exported):
    run, folder = exported
    _, data = series(folder, "wires")
    found = arrays(data[-1].GetCellData())
    net = run.interactions(-1)
    np.testing.assert_array_equal(found["tension"], np.maximum(-net.force[: len(found["tension"]), 0], 0.0))
    assert found["chain"].tolist() == [0] * 7 + [1] * 2 + [2] * 5 + [3] * 4
    assert found["link"].tolist() == [*range(7), *range(2), *range(5), *range(4)]
    names = words(data[-1], "law_names")
    assert [names[code] for code in found["law"][[0, 7, 9, 14]]] == ["rigid-wire", "rigid-rod", "elastic-wire", "voigt-rod"]
    start = arrays(data[0].GetCellData())
    np.testing.assert_allclose(start["excess"], 0.0, atol=1e-12)
    assert found["excess"].max() > 1e-3  # elastic ones were pulled
    points = arrays(data[0].GetPointData())
    np.testing.assert_allclose(points["length"][:8], 0.3 * np.arange(8), atol=1e-12)
    assert points["length"][8] == 0.0


def test_walls_are_lines_and_in_space_polygons(exported, tmp_path):
    _, folder = exported
    _, data = series(folder, "walls")
    assert [part.GetNumberOfLines() for part in data] == [3, 3, 3]
    scene = lm.Scene(dimension=3)
    beads = [scene.add(lm.sphere(radius=0.1, position=(0.3 * i, 0.0, 0.1), mass=1.0)) for i in range(2)]
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=1.0))
    scene.chain(beads, lm.RigidWire())
    lm.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "a.h5", every=1)
    with lm.io.open_run(tmp_path / "a.h5") as run:
        lm.view.export_vtk(run, tmp_path / "out")
    _, data = series(tmp_path / "out", "walls")
    assert data[-1].GetNumberOfPolys() == 1 + 72
    assert set(arrays(data[-1].GetCellData())["body"]) == {2, 3}
    assert arrays(series(tmp_path / "out", "bodies")[1][-1].GetPointData())["spin"].shape == (2, 3)


def test_facets_of_walls_and_membranes_have_forces_and_pressure(tmp_path):
    """A ball of 10 N on a plate of two triangles beside a plane, and one of 20 N on a membrane of one triangle."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -10.0))
    scene.add(lm.wall(point=(0, 0, -1), normal=(0, 0, 1)))
    scene.add(lm.plate([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]))
    nodes = [scene.add(lm.point_mass(position=at, mass=1.0)).fix() for at in [(2, 0, 0), (3, 0, 0), (2, 1, 0)]]
    scene.membrane(nodes, [(0, 1, 2)], lm.ElasticWire(stiffness=1.0), radius=0.01, color="WALL")
    scene.add(lm.sphere(radius=0.1, position=(0.7, 0.3, 0.1), mass=1.0))
    scene.add(lm.sphere(radius=0.1, position=(2.3, 0.3, 0.11), mass=2.0))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    lm.Simulation(scene, time_step=1e-3).run(steps=2, record=tmp_path / "a.h5", every=2)
    with lm.io.open_run(tmp_path / "a.h5") as run:
        written = lm.view.export_vtk(run, tmp_path / "out")
    assert [path.stem for path in written] == ["bodies", "forces", "wires", "walls", "membranes"]
    first, last = (arrays(part.GetCellData()) for part in series(tmp_path / "out", "walls")[1])
    assert first["pressure"][1:].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(last["pressure"], [np.nan, 20.0, 0.0], rtol=1e-6)
    np.testing.assert_allclose(last["force"][1], [0.0, 0.0, -10.0], atol=1e-6)
    _, data = series(tmp_path / "out", "membranes")
    assert data[-1].GetNumberOfPolys() == 1
    np.testing.assert_allclose(arrays(data[-1].GetCellData())["pressure"], [40.0], rtol=1e-6)


def test_a_folder_that_holds_something_is_kept(exported):
    run, folder = exported
    with pytest.raises(FileExistsError, match="is not empty"):
        lm.view.export_vtk(run, folder)
    assert len(lm.view.export_vtk(run, folder, force=True)) == 4


def test_without_vtk_a_sentence(exported, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "vtkmodules.vtkIOXML", None)
    with pytest.raises(ImportError, match=r'pip install "lmgcpy\[view\]"\.'):
        lm.view.export_vtk(exported[0], tmp_path / "no")
    assert not (tmp_path / "no").exists()
