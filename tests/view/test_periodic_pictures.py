"""Pictures and exports of a periodic scene: images in the cell, lines across its faces, its outline."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.view.compose import compose
from lmgcpy.view.snapshot import snapshot
from lmgcpy.view.style import OPTIONS, style_of


def pair(dimension):
    """Two grains pressed together across the face x = 1, one laid two cells away, and a wire across that face."""
    make, more = (lm.disk, ()) if dimension == 2 else (lm.sphere, (0.5,))
    scene = lm.Scene(dimension=dimension)
    scene.add(make(radius=0.1, position=(0.95, 0.5, *more), mass=1.0, velocity=(1.0, 0.0, *(0.0,) * len(more))))
    scene.add(make(radius=0.1, position=(2.149, 0.5, *more), mass=1.0))
    beads = [scene.add(make(radius=0.02, position=(0.9 + 0.15 * k, 0.2, *more), mass=1.0, color="BEAD")) for k in range(2)]
    scene.chain(beads, lm.RigidWire())
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.periodic(x=1.0, y=1.0, **({"z": 1.0} if dimension == 3 else {}))
    return lm.Simulation(scene, time_step=0.01)


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_drawn_lies_in_the_cell(dimension):
    sim = pair(dimension).run(steps=1)
    drawing = compose(
        snapshot(sim), style_of({**dict.fromkeys(OPTIONS), "what": "forces"}, dimension=dimension, is_scene=False)
    )
    for balls in drawing.balls:
        assert ((balls.centres[:, :dimension] >= 0.0) & (balls.centres[:, :dimension] < 1.0)).all()
    tubes = next(tubes for tubes in drawing.tubes if tubes.by_force)
    lengths = np.linalg.norm(tubes.ends - tubes.starts, axis=1)
    assert lengths == pytest.approx(0.2, abs=0.02)  # from centre to centre, the one an image
    middle = 0.5 * (tubes.starts + tubes.ends)[:, :dimension]
    assert ((middle >= 0.0) & (middle < 1.0)).all()
    assert len(drawing.lines) == {2: 4, 3: 12}[dimension]  # the edges of the cell


def test_an_export_has_the_cell(tmp_path):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    def read(name):
        reader = vtkXMLPolyDataReader()
        reader.SetFileName(str(tmp_path / "vtk" / name))
        reader.Update()
        return reader.GetOutput()

    pair(2).run(steps=2, record=tmp_path / "run.h5", every=1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        series = lm.view.export_vtk(run, tmp_path / "vtk")
    assert "cell.pvd" in {path.name for path in series}
    assert read("cell-00001.vtp").GetNumberOfLines() == 4
    bodies = vtk_to_numpy(read("bodies-00001.vtp").GetPoints().GetData())
    assert len(bodies) == 4  # the edges of the cell, bodies in the arrays, are not drawn
    assert ((bodies[:, :2] >= 0.0) & (bodies[:, :2] < 1.0)).all()
