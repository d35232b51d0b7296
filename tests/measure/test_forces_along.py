"""Forces along threads and wires: Euler's drum, pull-out, beads, rings, nets, and run files."""

import numpy as np
import pytest
from drum import over_a_drum

import lmgcpy as lm

MU = 0.3


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_on_a_drum_the_tension_changes_by_the_friction(d):
    """All contacts slide, each gives mu N against the motion. Moment about the axis of the drum, radius R = 50 r: the
    friction acts at R and the tension at R + r, so that dT/ds = mu n R / (R + r), and the ratio of the tensions is
    exp(mu phi R / (R + r)). A polygon of segments that turn by dphi changes a component along it by dphi^2 / 2 at most."""
    defects, on_axis = [], 50.0 / 51.0
    for count in (12, 24):
        sim = over_a_drum(d, count, friction=MU, mass=1e-5, tolerance=1e-9).run(steps=60)
        found, links = lm.measure.forces_along(sim), lm.measure.wire_links(sim)
        assert len(found) == count
        # 1e-6: nodes have masses, and the solver a tolerance of 1e-9
        assert found.friction_along == pytest.approx(-MU * found.normal, rel=1e-6)
        assert found.tangential == pytest.approx(MU * found.normal, rel=1e-6)
        assert found.force_along == pytest.approx(found.friction_along, rel=1e-9)
        assert (found.other == sim.scene.bodies[-1].id).all()
        length = links.length[0]
        assert np.diff(found.along) == pytest.approx(np.full(count - 1, length), rel=0.01)
        assert found.along.min() == pytest.approx(4.5 * length, rel=0.02)  # the thread has moved by 1.2 mm
        first, last = links.tension[[0, -1]]
        assert first == pytest.approx(1.0, rel=1e-3)
        assert last == pytest.approx(np.exp(MU * np.pi * on_axis), rel=(np.pi / count) ** 2)
        # the tension of each link: half of the friction on the link itself is beyond its middle
        friction = np.bincount(found.link, weights=found.friction_along, minlength=len(links))
        beyond = np.cumsum(friction[::-1])[::-1] - 0.5 * friction
        assert links.tension == pytest.approx(last + on_axis * beyond, abs=last * (np.pi / count) ** 2)
        defects.append(abs(last - first + on_axis * found.friction_along.sum()) / last)
    assert defects[0] < 0.5 * (np.pi / 12) ** 2
    assert defects[1] < 0.35 * defects[0]  # second order: a quarter


def drawn(d, friction, beads=False, record=None):
    """A straight thread between three pairs of grains that press it, drawn at its last node along x."""
    scene, radius, spacing = lm.Scene(dimension=d), 0.002, 0.02
    shape, nodes = lm.disk if d == 2 else lm.sphere, []
    for k in range(12):
        at = np.zeros(d)
        at[0] = spacing * k
        if beads:
            nodes.append(scene.add(shape(radius=radius, position=at, mass=1e-4, color="THREAD")))
        else:
            nodes.append(scene.add(lm.point_mass(position=at, mass=1e-4)))
    scene.chain(nodes, lm.RigidWire(), surface=None if beads else lm.Thread(radius))
    held = ("x", "spin") if d == 2 else ("x", "y", "spin_x", "spin_y", "spin_z")
    for x in (0.04, 0.1, 0.16) if beads else (0.04, 0.11, 0.167):
        for side in (1.0, -1.0):
            at = np.zeros(d)
            at[0], at[-1] = x, side * (0.005 + radius)
            ball = scene.add(shape(radius=0.005, position=at, mass=1e-4)).fix(*held)
            ball.impose_force(**{"xyz"[d - 1]: -side})
    for node in nodes:
        node.fix("xyz"[d - 1])
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=friction))
    nodes[0].impose_force(x=-0.1)
    nodes[-1].impose_velocity(x=0.01)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10))
    return sim.run(steps=30, record=record, every=15)


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_friction_along_a_thread_that_is_drawn_out_is_the_pull(d, tmp_path):
    """Pull less the load at the other end is the integral of the friction, 2 mu N for each of three pairs, and the feet are
    at the grains. The same from the file."""
    path = tmp_path / "drawn.h5"
    sim = drawn(d, MU, record=path)
    moved = 0.01 * 30e-3
    with lm.io.open_run(path) as run:
        for source in (sim, run):
            found, links = lm.measure.forces_along(source), lm.measure.wire_links(source)
            assert len(found) == 6
            pull = links.tension[-1] - 0.1
            assert -found.friction_along.sum() == pytest.approx(pull, rel=1e-7)
            assert pull == pytest.approx(6.0 * MU, rel=1e-6)
            expected = np.repeat([0.04, 0.11, 0.167], 2) - moved
            assert found.along == pytest.approx(expected, abs=2e-5)  # the thread moves by 1e-5 in a step
            assert found.link.tolist() == (expected // 0.02).astype(int).tolist()
        assert lm.measure.forces_along(run, frame=0).columns()["normal"].shape == (0,)
        again = lm.measure.forces_along(run)
    for name, column in lm.measure.forces_along(sim).columns().items():
        assert again.columns()[name] == pytest.approx(column, rel=1e-9, abs=1e-15), name


def test_contacts_of_beads_are_at_their_centres():
    """One measure for both: the sums of a wire of beads are those of :func:`wire_contacts`, bead by bead."""
    sim = drawn(2, MU, beads=True)
    found, beads = lm.measure.forces_along(sim), lm.measure.wire_contacts(sim)
    assert len(found)
    assert found.along == pytest.approx(beads.along[found.body], abs=1e-15)
    for name in ("normal", "force_along", "friction_along"):
        sums = np.bincount(found.body, weights=getattr(found, name), minlength=12)
        assert sums == pytest.approx(getattr(beads, name), abs=1e-12)


def test_a_ring_counts_the_contacts_at_its_first_node_once():
    """Eight nodes of a ring, held, and a ball in each corner and on the middle of each side."""
    scene, angle = lm.Scene(dimension=2), np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)).fix() for place in ring]
    scene.chain(nodes, lm.ElasticWire(stiffness=1.0), closed=True, surface=lm.Thread(0.01))
    middles = 0.5 * (ring + np.roll(ring, -1, axis=0))
    for place in np.stack([ring, middles], axis=1).reshape(-1, 2):
        out = place / np.linalg.norm(place)
        scene.add(lm.disk(radius=0.05, position=place + 0.06 * out, mass=1.0)).impose_force(x=-out[0], y=-out[1])
    scene.see("GRAIN", "THREAD", lm.Signorini())
    found = lm.measure.forces_along(lm.Simulation(scene, time_step=1e-4).run(steps=2))
    side = 2.0 * np.sin(np.pi / 8)
    expected = 0.5 * side * np.arange(16)
    assert len(found) == 16
    assert np.sort(found.along % (8.0 * side)) == pytest.approx(expected, abs=1e-6)
    assert found.normal == pytest.approx(np.ones(16), rel=1e-2)
    assert found.force_along == pytest.approx(np.zeros(16), abs=1e-6)


def test_a_contact_on_a_net_is_on_the_edge_that_has_its_foot():
    """Two edges cross at a node, in chains of their own; a ball lies on each of their four arms."""
    scene = lm.Scene(dimension=3)
    places = [(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)).fix() for place in places]
    edges = [(0, k) for k in range(1, 5)]
    net = scene.net(nodes, edges, lm.ElasticWire(stiffness=1.0), surface=lm.Thread(0.01))
    for _, k in edges:
        at = 0.3 * np.array(places[k]) + (0.0, 0.0, 0.06)
        scene.add(lm.sphere(radius=0.05, position=at, mass=1.0)).impose_force(z=-1.0)
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=MU))
    found = lm.measure.forces_along(lm.Simulation(scene, time_step=1e-4).run(steps=1))
    assert len(found) == 4
    for row in range(4):
        chain = net.chains[found.chain[row]]
        ids = [body.id for body in chain.bodies]
        ends = set(ids[found.link[row] : found.link[row] + 2])
        assert found.other[row] - 5 + 1 in ends
        from_end = found.along[row] - found.link[row]
        assert from_end == pytest.approx(0.3 if ids[found.link[row]] == 0 else 0.7, abs=1e-6)


def test_scenes_without_chains_and_membranes_have_no_rows():
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=at, mass=1.0)).fix() for at in [(0, 0, 0), (1, 0, 0), (0, 1, 0)]]
    scene.membrane(nodes, [(0, 1, 2)], lm.ElasticWire(stiffness=1.0), radius=0.01, color="WALL")
    scene.add(lm.sphere(radius=0.1, position=(0.3, 0.3, 0.11), mass=1.0)).impose_force(z=-1.0)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=MU))
    sim = lm.Simulation(scene, time_step=1e-4).run(steps=1)
    assert len(lm.measure.contact_forces(sim)) == 1
    assert len(lm.measure.forces_along(sim)) == 0
    bare = lm.Simulation(lm.Scene(dimension=2), time_step=1e-3).run(steps=1)
    assert len(lm.measure.forces_along(bare)) == 0
