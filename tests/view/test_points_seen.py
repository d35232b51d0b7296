"""Links at points and joints in measures, pictures and files for ParaView: lines end at points, joints are not drawn."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.view.snapshot import acting_lines, snapshot


def hung(d: int) -> tuple[lm.Simulation, lm.Body, np.ndarray]:
    """A plate on two wires, each with a bead half-way, and a rod on a joint below it; the points of the plate in space."""
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-10.0,))
    up, right = np.eye(d)[-1], np.eye(d)[0]
    ball = lm.DiskContactor if d == 2 else lm.SphereContactor
    make = lm.disk if d == 2 else lm.sphere
    inertia = 0.1 if d == 2 else (0.1, 0.2, 0.15)
    points = np.array([-0.3 * right + 0.1 * up, 0.3 * right + 0.1 * up])
    start = {"position": np.zeros(d), "color": "PLATE"}
    plate = scene.add(lm.RigidBody([(ball(0.05), np.zeros(d))], mass=2.0, inertia=inertia, **start))
    for p in points:
        bead = scene.add(make(radius=0.01, position=p + 0.2 * up, mass=0.1, color="BEAD"))
        hook = scene.add(make(radius=0.01, position=p + 0.4 * up, mass=0.1, color="BEAD")).fix()
        scene.chain([hook, bead, (plate, p)], lm.RigidRod())
    start = {"position": -0.3 * up, "color": "ROD"}
    rod = scene.add(lm.RigidBody([(ball(0.02), np.zeros(d))], mass=1.0, inertia=inertia, **start))
    scene.link(plate, rod, lm.BallJoint(), at=(-0.1 * up, 0.2 * up))
    scene.see("PLATE", "ROD", lm.Signorini())
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Newton(tolerance=1e-12)).run(steps=5), plate, points


@pytest.mark.parametrize("d", [2, 3])
def test_measures_know_where_links_act(d):
    sim, plate, points = hung(d)
    links = lm.measure.wire_links(sim)
    np.testing.assert_allclose(links.length, 0.2, atol=1e-9)
    np.testing.assert_allclose(links.slack, 0.0, atol=1e-9)
    np.testing.assert_allclose(links.tension, [16.0, 15.0, 16.0, 15.0], rtol=1e-9)
    np.testing.assert_allclose(links.position[[1, 3]], points + 0.1 * np.eye(d)[-1], atol=1e-9)
    assert len(lm.measure.contact_forces(sim)) == 0  # joints are no contacts
    # sum of force (x) lever: two links of 15 N, which count up to their middles, and the rod of 10 N at its point
    up = np.eye(d)[-1]
    expected = sum(np.outer(15.0 * up, p + 0.1 * up) for p in points) + np.outer(-10.0 * up, -0.1 * up)
    of_bodies = lm.measure.particle_stress(sim)
    np.testing.assert_allclose(of_bodies.moment[of_bodies.body == plate.id][0], expected, atol=1e-8)


@pytest.mark.parametrize("d", [2, 3])
def test_lines_end_at_points_and_joints_are_left_out(d, tmp_path):
    sim, _, points = hung(d)
    snap = snapshot(sim)
    for course, p in zip(snap.courses, points, strict=True):
        np.testing.assert_allclose(course[-1], p, atol=1e-9)
    start, end = acting_lines(snap)
    assert len(start) == 4  # the links of the wires alone
    np.testing.assert_allclose(end[[1, 3]], points, atol=1e-9)
    assert snap.beads.sum() == 4  # the plate is none
    assert not len(lm.view.check(sim.scene).links)
    path = tmp_path / "run.h5"
    sim.run(steps=2, record=path)
    with lm.io.open_run(path) as run:
        np.testing.assert_allclose(lm.measure.wire_links(run).length, 0.2, atol=1e-9)
        np.testing.assert_allclose(snapshot(run, -1).courses[1][-1], points[1], atol=1e-9)
        pytest.importorskip("vtkmodules")
        lm.view.export_vtk(run, tmp_path / "vtk")
    assert (tmp_path / "vtk" / "wires.pvd").exists()
