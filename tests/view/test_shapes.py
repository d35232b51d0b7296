"""Clusters, walls and shapes of plug-ins: where their forces go, and how they are drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest
from segment import Segment
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

import lmgcpy as lm
from lmgcpy.view.compose import compose
from lmgcpy.view.snapshot import acting_lines, snapshot
from lmgcpy.view.style import OPTIONS, style_of

DRUM = 1.0


class Drum(lm.Contactor):
    """The inside of a hollow cylinder around the centre of the body, by its outline alone."""

    KIND = "test-drum"
    area = 0.0
    second_moment = 1.0
    shape = (DRUM,)
    bounding_radius = DRUM

    @property
    def outline(self):
        angle = np.linspace(0.0, 2.0 * math.pi, 37)
        return [DRUM * np.column_stack([np.cos(angle), np.sin(angle)])]


class LongSegment(Segment):
    """A capsule with an axis that is drawn."""

    @property
    def outline(self):
        return [np.array([[-self.half, 0.0], [self.half, 0.0]])]


def inside(position_c, shape_c, position_a, shape_a):
    """A disk in the drum."""
    x, y = position_a[0] - position_c[0], position_a[1] - position_c[1]
    distance = math.sqrt(x * x + y * y)
    n = (x / distance, y / distance) if distance > 0.0 else (0.0, 1.0)
    gap = shape_a[0] - distance - shape_c[0]
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1])


lm.contact.register_pair("disk", "test-drum", inside)


def pressed(*bodies):
    """Bodies of two colours, each pressed against the next along its imposed force, after a step."""
    scene = lm.Scene(dimension=2)
    for body in bodies:
        scene.add(body)
    scene.see("GRAIN", "OTHER", lm.Coulomb(friction=0.3), alert=0.01)
    return lm.Simulation(scene, time_step=1e-3).run(steps=1)


def lines(sim):
    """Start and end of the only line."""
    start, end = acting_lines(snapshot(sim))
    assert len(start) == 1
    return start[0], end[0]


def test_a_line_goes_to_the_disk_of_a_cluster_that_touches():
    """The body lies 0.3 m to the left of that disk."""
    two = [(lm.DiskContactor(0.1), (-0.3, 0.0)), (lm.DiskContactor(0.1), (0.3, 0.0))]
    cluster = lm.RigidBody(two, mass=1.0, inertia=1.0, position=(0.0, 0.0), color="OTHER").fix()
    disk = lm.disk(radius=0.1, position=(0.3, 0.2), mass=1.0).impose_force(y=-1.0)
    start, end = lines(pressed(disk, cluster))
    assert start == pytest.approx([0.3, 0.0], abs=1e-12)
    assert end == pytest.approx([0.3, 0.2], abs=1e-6)


def test_a_line_ends_at_the_contact_point_of_a_foreign_shape(tmp_path):
    """From a recorded run, too, as is its outline, which turns with the body."""
    bar = lm.RigidBody(
        [LongSegment(0.8, 0.05)], mass=1.0, inertia=1.0, position=(0.0, 0.0), color="OTHER", rotation=0.5 * math.pi
    )
    bar.fix()
    disk = lm.disk(radius=0.1, position=(-0.15, 0.5), mass=1.0).impose_force(x=1.0)
    sim = pressed(disk, bar)
    start, end = lines(sim)
    assert start == pytest.approx([-0.05, 0.5], abs=1e-6)
    assert end == pytest.approx([-0.15, 0.5], abs=1e-6)
    sim.run(steps=1, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        of_run, of_sim = snapshot(run), snapshot(sim)
        for snap in (of_run, of_sim):
            [(body, line)] = snap.outlines
            assert body == 1
            assert np.allclose(line, [[0.0, -0.8], [0.0, 0.8]], atol=1e-12)
        assert np.array_equal(acting_lines(of_run), acting_lines(of_sim))
        lm.view.export_vtk(run, tmp_path / "vtk")
    [(body, line)] = snapshot(lm.resume(tmp_path / "run.h5")).outlines
    assert np.allclose(line, of_sim.outlines[0][1])
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(sorted((tmp_path / "vtk").glob("outlines-*.vtp"))[-1]))
    reader.Update()
    seen = reader.GetOutput()
    assert seen.GetNumberOfLines() == 1
    assert np.allclose(vtk_to_numpy(seen.GetPoints().GetData())[:, :2], line)
    assert vtk_to_numpy(seen.GetCellData().GetArray("body")).tolist() == [1]


def test_a_hollow_shape_is_its_outline_and_its_force_no_ray():
    drum = lm.RigidBody([Drum()], mass=1.0, inertia=1.0, position=(0.0, 0.0), color="OTHER").fix()
    disk = lm.disk(radius=0.1, position=(0.0, -0.9), mass=1.0).impose_force(y=-1.0)
    sim = pressed(disk, drum)
    start, end = lines(sim)
    assert start == pytest.approx([0.0, -1.0], abs=1e-6)
    assert end == pytest.approx([0.0, -0.9], abs=1e-6)
    drawing = compose(snapshot(sim), style_of({**dict.fromkeys(OPTIONS), "what": "forces"}, dimension=2, is_scene=False))
    assert sum(len(balls.radii) for balls in drawing.balls) == 1  # the drum is no disk
    ring = drawing.lines[np.isclose(np.linalg.norm(drawing.lines[:, 0], axis=1), DRUM)]
    assert len(ring) == 36
    assert drawing.bounds()[:, :2].max() == pytest.approx(DRUM)


@pytest.mark.long
def test_between_two_foreign_shapes_a_line_is_a_piece_of_the_normal():
    bars = [
        lm.RigidBody([Segment(0.8, 0.05)], mass=1.0, inertia=1.0, position=(0.0, y), color=color)
        for y, color in ((0.0, "OTHER"), (0.1, "GRAIN"))
    ]
    lm.contact.register_pair("test-segment", "test-segment", parallel)
    bars[0].fix()
    bars[1].impose_force(y=-1.0)
    start, end = lines(pressed(bars[1], bars[0]))
    assert end - start == pytest.approx([0.0, 0.5 * 0.85], abs=1e-6)
    assert 0.5 * (start + end) == pytest.approx([0.0, 0.05], abs=1e-6)


def parallel(position_c, shape_c, position_a, shape_a):
    """Two level capsules, one above the other."""
    gap = position_c[1] - position_a[1] - shape_c[1] - shape_a[1]
    return gap, (0.0, 1.0), (position_c[0], position_c[1] - shape_c[1] - 0.5 * gap)


def test_thicknesses_of_a_scene_of_outlines_alone_follow_their_size():
    """The mean grain is the circle around a shape where no shape is round."""
    scene = lm.Scene(dimension=2)
    for x in (0.0, 1.0):
        scene.add(lm.RigidBody([LongSegment(0.03, 0.01)], mass=1.0, inertia=1.0, position=(x, 0.0), color="BAR"))
    drawing = compose(snapshot(scene), style_of(dict.fromkeys(OPTIONS), dimension=2, is_scene=True))
    assert drawing.grain == pytest.approx(0.04)


def test_an_outline_in_space_is_drawn_at_the_body():
    class Frame(Drum):
        outline = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 2.0, 3.0]]])

    class Foreign(lm.Body):
        dimension = 3
        mass = inertia = link_radius = extent = 1.0
        contactors = ((Frame(), (0.0, 0.0, 0.0)),)

    scene = lm.Scene(dimension=3)
    scene.add(Foreign(position=(10.0, 0.0, 0.5), color="FRAME"))
    drawing = compose(snapshot(scene), style_of(dict.fromkeys(OPTIONS), dimension=3, is_scene=True))
    assert np.allclose(drawing.lines, [[[10, 0, 0.5], [11, 0, 0.5]], [[11, 0, 0.5], [11, 2, 3.5]]])


@pytest.mark.parametrize("outline", [[np.zeros((3, 3))], [np.zeros(4)], [[[0.0, np.nan]]], np.zeros((4, 2)), 3, ["ab"]])
def test_an_outline_that_is_none_gets_a_sentence(outline):
    class Wrong(Drum):
        pass

    Wrong.outline = outline
    scene = lm.Scene(dimension=2)
    scene.add(lm.RigidBody([Wrong()], mass=1.0, inertia=1.0, position=(0.0, 0.0), color="DRUM"))
    with pytest.raises(ValueError, match=r"outline of <Wrong 'test-drum' .*> must be polylines of shape \(v, 2\)"):
        snapshot(scene)


def test_a_hidden_body_is_in_no_picture(tmp_path):
    """Neither of a simulation nor of a frame of its run; before it was hidden it is there."""
    scene = lm.Scene(dimension=2)
    for x in (0.0, 1.0):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0))
    gate = scene.add(lm.wall(point=(0.0, -1.0), normal=(0.0, 1.0)))
    drum = scene.add(lm.RigidBody([Drum()], mass=1.0, inertia=1.0, position=(0.0, 0.0), color="DRUM"))

    def hide(sim):
        for body in (scene.bodies[1], gate, drum):
            if sim.steps == 2:
                body.hide()

    sim = lm.Simulation(scene, time_step=1e-3).run(steps=4, on_step=hide, record=tmp_path / "run.h5", every=1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        found = [snapshot(run, frame=k) for k in range(5)]
    found.append(snapshot(sim))
    assert [len(snap.rounds.body) for snap in found] == [2, 2, 1, 1, 1, 1]
    assert [len(snap.walls.body) for snap in found] == [1, 1, 0, 0, 0, 0]
    assert [len(snap.outlines) for snap in found] == [1, 1, 0, 0, 0, 0]
