"""Wires that go on across the faces of a periodic cell: each link joins the nearest images of its two bodies."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

COUNT, SIDE, RADIUS, STIFFNESS = 20, 0.2, 0.002, 1e4


def endless(dimension, way, law, **chain):
    """A straight wire along x through a cell, and its cell; the last bead is linked to the first across the face."""
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    drift = [0.0] * (dimension - 1) + [0.01]
    places = [[(i + 0.5) * SIDE / COUNT] + [0.5 * SIDE] * (dimension - 1) for i in range(COUNT)]
    beads = [scene.add(make(radius=RADIUS, position=x, velocity=drift, mass=1e-3, color="BEAD")) for x in places]
    edges = dict.fromkeys("xyz"[:dimension], SIDE)
    if way == "cell last":
        scene.chain(beads, law, closed=True, **chain)
    cell = scene.periodic(**edges)
    if way == "closed":
        scene.chain(beads, law, closed=True, **chain)
    elif way == "second chain":
        scene.chain(beads, law, **chain)
        scene.chain([beads[-1], beads[0]], law, **chain)
    return scene, cell


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("way", ["closed", "second chain", "cell last"])
def test_every_link_of_a_strained_endless_wire_bears_the_same(dimension, way):
    """Strained by e along itself each link has k l e, and the cell the stress T over its side; momentum is kept and no bead
    leaves its place in the flow."""
    scene, cell = endless(dimension, way, lm.ElasticWire(stiffness=STIFFNESS))
    cell.impose_rate(xx=0.5)
    sim = lm.Simulation(scene, time_step=1e-4, solver=lm.Auto(tolerance=1e-10)).run(duration=0.02)
    length = cell.edges[0, 0]
    tension = -sim.interactions.force[:, 0]
    # a step of h ends with the force at the gap of its middle, moved on by h: that of half a step later
    strain = np.exp(0.5 * (0.02 + 0.5e-4)) - 1.0
    np.testing.assert_allclose(tension, STIFFNESS * SIDE / COUNT * strain, rtol=1e-4)
    section = cell.volume / length
    stress = lm.measure.stress(sim)["total"][0, 0]
    assert stress == pytest.approx(tension.mean() / section, rel=1e-3)
    np.testing.assert_allclose(sim.positions[:COUNT, 0], (np.arange(COUNT) + 0.5) * length / COUNT, rtol=1e-6)
    assert abs(sim.velocities[:COUNT, 0].sum()) < 1e-9
    links = lm.measure.wire_links(sim)
    np.testing.assert_allclose(links.length, length / COUNT, rtol=1e-6)
    np.testing.assert_allclose(np.abs(links.direction[:, 0]), 1.0)


@pytest.mark.default_parameters("law0")
@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod()])
def test_a_rigid_endless_wire_bears_the_stress_of_its_cell(law):
    """A cell that yields to a stress along x is held by the wire alone: T = sigma times the side, at any tension of y."""
    scene, cell = endless(2, "closed", law)
    cell.impose_stress(xx=50.0)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-4)).run(steps=50)
    np.testing.assert_allclose(-sim.interactions.force[:, 0], 50.0 * SIDE, rtol=1e-3)
    assert cell.edges[0, 0] == pytest.approx(SIDE, rel=1e-5)  # drift of 50 steps to 1e-4


@pytest.mark.long
def test_it_stays_linked_where_the_cell_takes_other_edges():
    """Sheared by 3 the cell has been straightened three times; the wire goes with the shear, unstretched."""
    scene, cell = endless(2, "closed", lm.ElasticWire(stiffness=STIFFNESS))
    cell.impose_rate(xy=10.0)
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.3)
    assert abs(cell.edges[1, 0]) < 0.61 * SIDE
    links = lm.measure.wire_links(sim)
    np.testing.assert_allclose(links.length, SIDE / COUNT, rtol=1e-9)
    assert np.abs(sim.interactions.force[:, 0]).max() < 1e-6


@pytest.mark.long
def test_a_wire_that_swings_across_a_face_is_drawn_and_written_as_short_links(tmp_path):
    """Pictures, VTK files and what goes on from a file know the images."""
    scene, cell = endless(2, "closed", lm.ElasticWire(stiffness=STIFFNESS))
    cell.impose_rate(xx=0.5)
    lm.Simulation(scene, time_step=1e-4).run(steps=20, record=tmp_path / "run.h5", every=5)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_allclose(lm.measure.wire_links(run).length, cell.edges[0, 0] / COUNT, rtol=1e-6)
        lm.view.export_vtk(run, tmp_path / "paraview")
        scene_again = lm.Scene.from_run(tmp_path / "run.h5")
    np.testing.assert_allclose(scene_again.chains[0].lengths(), cell.edges[0, 0] / COUNT, rtol=1e-6)
    import pyvista as pv

    lines = pv.read(sorted((tmp_path / "paraview").glob("wires-*"))[-1])
    ends = lines.points[lines.lines.reshape(-1, 3)[:, 1:]]
    assert np.linalg.norm(np.diff(ends, axis=1), axis=2).max() < 1.1 * SIDE / COUNT
    lm.resume(tmp_path / "run.h5").run(steps=20)
    whole, its_cell = endless(2, "closed", lm.ElasticWire(stiffness=STIFFNESS))
    its_cell.impose_rate(xx=0.5)
    sim = lm.Simulation(whole, time_step=1e-4).run(steps=40)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_array_equal(run.positions[-1], sim.positions)


def test_a_link_longer_than_half_the_cell_is_refused():
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.002, position=(x, 0.1), mass=1e-3)) for x in (0.0, 0.11)]
    scene.chain(beads, lm.ElasticWire(stiffness=1.0), reference_gap=0.11)
    scene.periodic(x=0.2, y=0.2)
    with pytest.raises(ValueError, match=r"Link 0 of the chain, .* must be shorter than half the width .* 0\.1 m"):
        lm.Simulation(scene, time_step=1e-3)


def test_a_link_is_not_let_out_beyond_half_the_cell():
    scene, _ = endless(2, "closed", lm.ElasticWire(stiffness=STIFFNESS))
    sim, chain = lm.Simulation(scene, time_step=1e-3), scene.chains[0]
    before = chain.reference_gap
    with pytest.raises(ValueError, match="shorter than half the width"):
        chain.reference_gap = 0.1
    np.testing.assert_array_equal(chain.reference_gap, before)
    assert sim.state.changes == []


def test_a_gap_that_was_set_stays_where_the_cell_comes_last():
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.002, position=(0.01 + 0.09 * k, 0.1), mass=1e-3)) for k in range(3)]
    chain = scene.chain(beads, lm.ElasticWire(stiffness=1.0), closed=True)
    chain.reference_gap = 0.03
    scene.periodic(x=0.2, y=0.2)
    np.testing.assert_array_equal(chain.reference_gap, 0.03)
    np.testing.assert_allclose(chain.lengths(), [0.09, 0.09, 0.02])  # the last one across the face
