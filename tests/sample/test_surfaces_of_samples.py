"""Nodes and cells of nets and membranes."""

import numpy as np
import pytest

import lmgcpy as lm


def area_vectors(cells):
    a, b, c = cells.positions[cells.cells].transpose(1, 0, 2)
    return 0.5 * np.cross(b - a, c - a)


@pytest.mark.parametrize("pieces", [1, 3])
def test_a_net_has_the_lines_of_its_meshes(pieces):
    net = lm.sample.net(size=(0.6, 0.4), mesh=(0.2, 0.1), nodes=pieces)
    ways = np.diff(net.positions[net.cells], axis=1)[:, 0]
    lengths = np.linalg.norm(ways, axis=1)
    # 5 lines of 0.6 m along x, 4 of 0.4 m along y
    assert lengths.sum() == pytest.approx(5 * 0.6 + 4 * 0.4)
    np.testing.assert_allclose(sorted(set(lengths.round(9))), sorted({0.2 / pieces, 0.1 / pieces}), atol=1e-9)
    assert len(np.unique(net.positions.round(9), axis=0)) == len(net.positions)
    assert len(np.unique(np.sort(net.cells, axis=1), axis=0)) == len(net.cells)
    on_rim = (net.positions[:, :2] == 0.0) | np.isclose(net.positions[:, :2], (0.6, 0.4))
    np.testing.assert_array_equal(net.rim, on_rim.any(axis=1))


def test_a_membrane_around_a_cylinder_is_the_wall_of_its_polygon():
    cells = lm.sample.membrane_around(radius=0.05, height=0.2, spacing=0.02)
    vectors = area_vectors(cells)
    n = 16
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(2 * n * 0.05 * np.sin(np.pi / n) * 0.2)
    middles = cells.positions[cells.cells].mean(axis=1)
    assert ((vectors * middles)[:, :2].sum(axis=1) > 0.0).all()  # outward
    sides = np.linalg.norm(cells.positions[cells.cells] - np.roll(cells.positions[cells.cells], 1, axis=1), axis=2)
    assert sides.max() <= np.sqrt(2.0) * 0.02
    assert cells.rim.sum() == 2 * n


def test_a_membrane_around_a_box_bounds_it():
    cells = lm.sample.membrane_around(box=(0.1, 0.2), height=0.3, spacing=0.025)
    vectors, middles = area_vectors(cells), cells.positions[cells.cells].mean(axis=1)
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(2 * (0.1 + 0.2) * 0.3)
    # the divergence of (x, y, 0) is 2: its flux through the walls is twice the volume
    assert (vectors * middles)[:, :2].sum() == pytest.approx(2 * 0.1 * 0.2 * 0.3)


@pytest.mark.long
def test_a_membrane_under_pressure_holds_a_sample():
    """At rest the virial of all forces on the nodes vanishes: ``-p`` times twice the volume, contacts, and links."""
    cells = lm.sample.membrane_around(radius=0.05, height=0.1, spacing=0.025)
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=p, mass=1e-3)) for p in cells.positions]
    latex = scene.membrane(nodes, cells.cells, lm.ElasticWire(stiffness=10.0), radius=1e-3)
    latex.impose_pressure(1000.0)
    for node, held in zip(nodes, cells.rim, strict=True):
        node.fix("z") if held else None
    for k in range(4):
        scene.add(lm.sphere(radius=0.04, position=(0.0, 0.0, 0.0125 + 0.025 * k), mass=1.0, color="CORE")).fix()
    scene.see("CORE", "MEMBRANE", lm.Signorini())
    scene.drag(linear=0.5, bodies=nodes)
    sim = lm.Simulation(scene, time_step=2e-4).run(duration=0.2)
    x, n = sim.positions[:, :2], len(nodes)
    stress = lm.measure.stress(sim, volume=1.0)
    corners = sim.positions[:n][cells.cells]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    pressure = -1000.0 * (area * corners.mean(axis=1))[:, :2].sum()
    links, contacts = (np.trace(stress[name][:2, :2]) for name in ("elastic-wire", "signorini"))
    # sum f . x of the links is -T L each, and of the contacts -f . (foot - centre), as the balls are on the axis
    assert np.abs(x[n:]).max() == 0.0
    assert contacts < 0.0 < links
    assert pressure == pytest.approx(links + contacts, rel=1e-2)  # triangles at work: the sag between nodes


BAD = {
    "meshes that do not fit": (lambda: lm.sample.net(size=(1.0, 1.0), mesh=0.3), "whole meshes"),
    "three lengths": (lambda: lm.sample.net(size=(1.0, 1.0, 1.0), mesh=0.5), "two lengths"),
    "no mesh": (lambda: lm.sample.net(size=(1.0, 1.0), mesh=0.0), "one or two widths above 0"),
    "both shapes": (lambda: lm.sample.membrane_around(height=1.0, spacing=0.1, radius=1.0, box=(1, 1)), "or around a box"),
    "neither": (lambda: lm.sample.membrane_around(height=1.0, spacing=0.1), "or around a box"),
    "a flat box": (lambda: lm.sample.membrane_around(height=1.0, spacing=0.1, box=(1.0, 0.0)), "two lengths above 0"),
}


@pytest.mark.parametrize("case", BAD)
def test_wrong_surfaces_get_a_sentence(case):
    make, words = BAD[case]
    with pytest.raises((TypeError, ValueError), match=words):
        make()
