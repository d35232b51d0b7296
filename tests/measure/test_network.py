"""Coordination, rattlers and fabric of packings that are known."""

import numpy as np
import pytest

import lmgcpy as lm


def column(count, extra=()):
    """Spheres on top of each other on a floor, and others."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
    for k in range(count):
        scene.add(lm.sphere(radius=0.1, position=(0.0, 0.0, 0.1 + 0.2 * k), mass=1.0))
    for place in extra:
        scene.add(lm.sphere(radius=0.1, position=place, mass=1.0))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3).run(steps=1)


def test_a_column_under_its_own_weight_is_all_rattlers_from_the_top_down():
    """The top one has one contact only; without it the next has one; none carries a force on to something else."""
    found = lm.measure.network(column(4))
    assert found.rattlers.tolist() == [0, 1, 2, 3]
    assert found.coordination == 0.0
    assert np.array_equal(found.fabric, np.zeros((3, 3)))


def box(law_between=None):
    """A square lattice of 5 x 5 disks pressed by two walls against two others, and a loose disk in a hole of it."""
    scene = lm.Scene(dimension=2)
    disks = [
        scene.add(lm.disk(radius=0.1, position=(0.1 + 0.2 * i, 0.1 + 0.2 * j), mass=1.0))
        for j in range(5)
        for i in range(5)
    ]
    scene.add(lm.disk(radius=0.02, position=(0.2, 0.2), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(1, 0), normal=(-1, 0), mass=1.0)).impose_force(x=-10.0)
    scene.add(lm.wall(point=(0, 1), normal=(0, -1), mass=1.0, color="LID")).impose_force(y=-10.0)
    for color in ("WALL", "LID"):
        scene.see("GRAIN", color, lm.Signorini())
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    if law_between is not None:
        scene.chain(disks[:3], law_between)
    return lm.Simulation(scene, time_step=1e-3).run(steps=1)


@pytest.mark.parametrize("links", [None, lm.RigidRod()])
def test_a_square_lattice_has_four_contacts_each(links):
    """25 disks with 4 contacts each, walls included: 40 among themselves and 20 at walls; half of the normals along each
    axis. Links that push are no contacts: two of the contacts may lose their force to them."""
    found = lm.measure.network(box(links))
    assert found.rattlers.tolist() == [25]
    lost = 0 if links is None else 60 - len(found.pairs)
    assert 0 <= lost <= 2
    assert len(found.pairs) == 60 - lost
    assert found.coordination == pytest.approx((100 - 2 * lost) / 25)
    assert np.trace(found.fabric) == pytest.approx(1.0)
    if links is None:
        assert found.fabric == pytest.approx(0.5 * np.eye(2), abs=1e-12)


def test_what_is_no_simulation_is_refused():
    with pytest.raises(TypeError, match="network takes a simulation"):
        lm.measure.network(3)


def test_coordination_with_rattlers_counts_all_bodies_and_contacts():
    """A column of four has 2, 2, 2 and 1 contacts, one with the floor. The lattice: 100 ends of contacts on 26 disks."""
    assert lm.measure.network(column(4)).coordination_with_rattlers == pytest.approx(7 / 4)
    assert lm.measure.network(column(4, extra=[(1.0, 0.0, 5.0)])).coordination_with_rattlers == pytest.approx(7 / 5)
    assert lm.measure.network(box()).coordination_with_rattlers == pytest.approx(100 / 26)


def test_nodes_of_a_membrane_are_no_bodies_of_the_network(tmp_path):
    """Four balls in a square on a floor, pressed by a plate, and a membrane under them instead of the floor: the nodes have
    no shape, so that none is a rattler, and each ball has two contacts, with plate and membrane."""
    scene = lm.Scene(dimension=3)
    cells, places = [], [(x, y, 0.0) for x in range(3) for y in range(3)]
    for k in (0, 1, 3, 4):
        cells += [(k, k + 3, k + 4), (k, k + 4, k + 1)]
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)) for place in places]
    for node in nodes:
        node.fix()
    scene.membrane(nodes, cells, lm.ElasticWire(stiffness=1e3), radius=0.01, color="WALL")
    for x, y in ((0.6, 0.7), (1.4, 0.7), (1.4, 1.3), (0.6, 1.3)):
        scene.add(lm.sphere(radius=0.1, position=(x, y, 0.11), mass=1.0))
    scene.add(lm.wall(point=(0, 0, 0.21), normal=(0, 0, -1), mass=1.0)).impose_force(z=-10.0)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=2, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for source in (sim, run):
            found = lm.measure.network(source)
            assert found.rattlers.tolist() == []
            assert (found.coordination, found.coordination_with_rattlers) == (2.0, 2.0)
