"""Linked neighbours collide where their link leaves them room, or where they are asked to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from segment import Segment

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from

R = 0.01
LAW = lm.Coulomb(friction=0.3)


def row_of(count, *, gap=0.0, link=None, radius=R, law=LAW, **chain):
    """Beads side by side that see each other, linked as built: the scene, not compiled, and its chain."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    places = [(i * (2.0 * radius + gap), 0.0) for i in range(count)]
    beads = [scene.add(lm.disk(radius=radius, position=place, mass=0.1)) for place in places]
    scene.see("GRAIN", "GRAIN", law)
    return scene, scene.chain(beads, link or lm.RigidWire(), **chain)


def contacts(scene, **options):
    """Pairs of bodies that are contacts in the first step, the lower id first."""
    view = lm.Simulation(scene, time_step=1e-4, overlap="ignore", **options).run(steps=1).interactions
    pairs = np.sort(np.column_stack([view.candidate, view.antagonist]), axis=1)
    return {tuple(pair) for pair in pairs[view.law == LAW.NAME].tolist()}


def links(*chains):
    return {tuple(sorted(pair)) for chain in chains for pair in zip(chain.path[:-1], chain.path[1:], strict=True)}


# ----------------------------------------------------------------------------------------------- what goes wrong without


def over_three_pegs(time_step, link, **chain):
    """120 touching beads of steel, R = 4 mm, dropped 0.1 mm onto three pegs of 30 mm, 200 mm apart; 2 s later.

    Returns the greatest force in a link over the last 0.1 s, and the weight of the chain [N/m].
    """
    radius, steel = 0.004, lm.Material("steel", density=7800.0)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    places = [(2.0 * radius * (i - 59.5), 0.0) for i in range(120)]
    beads = [scene.add(lm.disk(radius=radius, position=place, material=steel, color="BEAD")) for place in places]
    for x in (-0.2, 0.0, 0.2):
        scene.add(lm.disk(radius=0.03, position=(x, -0.0301 - radius), mass=1.0, color="PEG")).fix()
    scene.see("BEAD", "PEG", LAW)
    scene.see("BEAD", "BEAD", LAW)
    scene.chain(beads, link, block_spin=True, **chain)
    sim = lm.Simulation(scene, time_step=time_step, on_unconverged="ignore").run(duration=1.9)
    greatest = 0.0
    for _ in range(round(0.1 / time_step)):
        sim.step()
        greatest = max(greatest, float(np.abs(sim.interactions.force[:119, 0]).max()))
    return greatest, 9.81 * sum(bead.mass for bead in beads)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")  # at 1 ms the ends that swing move by their radius, and turn links
@pytest.mark.parametrize("time_step", [1e-3, 4e-4])
def test_a_chain_of_touching_beads_over_pegs_pulls_with_no_more_than_its_weight(time_step):
    """A chain at rest is held by no tension above its weight, 461 N/m, which all three pegs together carry.

    What still swings adds some: 234 to 431 N/m were measured with steps from 0.2 to 1 ms. With contacts between the
    neighbours link and contact of each pair pull and push each other, with 850 to 3650 N/m.
    """
    greatest, weight = over_three_pegs(time_step, lm.RigidWire())
    assert weight == pytest.approx(461.5, rel=1e-3)
    assert 0.05 * weight < greatest < 1.5 * weight


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step to")
def test_neighbours_that_are_asked_to_collide_prestress_each_other():
    """The same chain with ``neighbours_collide=True``: 2550 N/m were measured, five times its weight."""
    greatest, weight = over_three_pegs(4e-4, lm.RigidWire(), neighbours_collide=True)
    assert greatest > 2.0 * weight


# ------------------------------------------------------------------------------------------------------ who meets whom


@pytest.mark.default_parameters("link0")
@pytest.mark.parametrize("link", [lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e5)])
def test_neighbours_that_touch_do_not_collide_unless_asked(link):
    for asked, met in ((None, set()), (False, set()), (True, {(0, 1), (1, 2), (2, 3)})):
        scene, _ = row_of(4, link=link, neighbours_collide=asked)
        assert contacts(scene) == met


@pytest.mark.parametrize(("share", "room"), [(-1e-3, False), (0.0, False), (0.9e-3, False), (1.1e-3, True), (0.1, True)])
def test_room_is_a_thousandth_of_the_smaller_radius(share, room):
    scene, chain = row_of(3, gap=share * R)
    assert chain.colliding.tolist() == [room, room]
    assert contacts(scene) == ({(0, 1), (1, 2)} if room else set())
    # a wire that starts slack has the room of its reference
    scene, chain = row_of(3, reference_gap=max(share, 0.0) * R)
    assert chain.colliding.tolist() == [room, room]


def test_each_link_is_judged_by_itself():
    scene, chain = row_of(4, link=lm.RigidWire(), reference_gap=[0.0, 0.2 * R, 1e-5 * R])
    assert chain.colliding.tolist() == [False, True, False]
    assert contacts(scene) == {(1, 2)}


def test_a_relaxation_is_judged_by_its_least_room():
    """Beads laid touching and drawn to 0.2 R by rods have no room at first; laid apart and drawn together, at the end."""
    _, opened = row_of(3, link=lm.RigidRod(), reference_gap=0.2 * R, relaxation=0.1)
    assert opened.colliding.tolist() == [False, False]
    _, closed = row_of(3, gap=0.2 * R, link=lm.RigidRod(), reference_gap=0.0, relaxation=0.1)
    assert closed.colliding.tolist() == [False, False]
    _, roomy = row_of(3, gap=0.2 * R, link=lm.RigidRod(), reference_gap=0.1 * R, relaxation=0.1)
    assert roomy.colliding.tolist() == [True, True]


def test_in_a_closed_loop_the_last_and_the_first_do_not_collide_either():
    """Twelve touching beads on a circle; a second loop around it, 0.1 R away, meets it."""
    scene = lm.Scene(dimension=2)
    loops = []
    for apart in (0.0, 2.1 * R):
        around = R / math.sin(math.pi / 12) + apart
        places = [(around * math.cos(k * math.pi / 6), around * math.sin(k * math.pi / 6)) for k in range(12)]
        beads = [scene.add(lm.disk(radius=R, position=place, mass=1.0)) for place in places]
        loops.append(scene.chain(beads, lm.RigidWire(), closed=True))
    scene.see("GRAIN", "GRAIN", LAW, alert=0.2 * R)
    assert loops[0].apart.tolist() == [[k, k + 1] for k in range(11)] + [[0, 11]]
    assert not loops[0].colliding.any()
    assert loops[1].colliding.all()
    assert contacts(scene) == {(k, k + 12) for k in range(12)}


def test_in_a_net_no_node_collides_with_what_it_is_linked_to():
    """Four rows and four columns of touching beads share their nodes; a bead on a node meets it and no other."""
    scene = lm.Scene(dimension=3)
    places = [[(2 * R * i, 2 * R * j, 0.0) for j in range(4)] for i in range(4)]
    nodes = [[scene.add(lm.sphere(radius=R, position=place, mass=1.0)) for place in row] for row in places]
    chains = [scene.chain(row, lm.RigidWire()) for row in nodes]
    chains += [scene.chain([row[j] for row in nodes], lm.RigidWire()) for j in range(4)]
    above = scene.add(lm.sphere(radius=R, position=(2 * R, 2 * R, 2 * R), mass=1.0))
    scene.see("GRAIN", "GRAIN", LAW)
    assert len(links(*chains)) == 24
    assert contacts(scene) == {(nodes[1][1].id, above.id)}


def test_who_is_linked_twice_stays_apart_if_one_chain_leaves_no_room():
    scene, chain = row_of(3)
    scene.chain(chain.bodies[1:], lm.ElasticRod(stiffness=1.0), neighbours_collide=True)
    assert contacts(scene) == set()


@pytest.mark.default_parameters("True")
@pytest.mark.parametrize("asked", [None, True])
def test_where_there_is_room_nothing_changes(asked):
    """A wire with gaps of 0.1 R, pushed together on a floor: the same bits by default and with neighbours that collide."""
    ends = []
    for said in (asked, True):
        scene, chain = row_of(12, gap=0.1 * R, neighbours_collide=said)
        chain.bodies[0].impose_velocity(x=1.0)
        scene.add(lm.wall(point=(0.0, -2.0 * R), normal=(0, 1)))
        scene.see("GRAIN", "WALL", LAW)
        sim = lm.Simulation(scene, time_step=1e-3).run(steps=150)
        ends.append((sim.positions.tobytes(), sim.velocities.tobytes(), sim.interactions.impulse.tobytes()))
        if said:
            neighbours = (sim.interactions.law == LAW.NAME) & (sim.interactions.impulse[:, 0] > 0.0)
            assert neighbours.any()
    assert ends[0] == ends[1]


@pytest.mark.long
def test_a_partitioned_scene_keeps_them_apart():
    plain = contacts(row_of(40)[0])
    with partition_from(2):
        assert contacts(row_of(40)[0]) == plain == set()
        assert len(contacts(row_of(40, neighbours_collide=True)[0])) == 39


# ------------------------------------------------------------------------------------------------------- other bodies


def test_the_disk_at_the_centre_of_a_rigid_body_counts():
    """A link measures a rigid body from its centre; what its disk fills around there is what leaves no room.

    The centre of the second disk is 0.4 R from the body's, so that it fills a circle of 0.6 R.
    """
    for offset, distance, room in ((0.0, 2.0, False), (0.0, 2.1, True), (0.4, 1.6, False), (0.4, 1.7, True)):
        scene = lm.Scene(dimension=2)
        parts = [(lm.DiskContactor(R), (offset * R, 0.0))]
        clump = lm.RigidBody(parts, mass=1.0, inertia=1.0, position=(0, 0), color="CLUMP")
        bead = lm.disk(radius=R, position=(-distance * R, 0.0), mass=1.0)
        chain = scene.chain([scene.add(clump), scene.add(bead)], lm.RigidWire())
        assert chain.colliding.tolist() == [room]


def test_shapes_from_elsewhere_and_walls_are_kept_apart_where_asked():
    """Nothing is known of what a foreign shape fills, so that it collides by default."""
    for asked, met in ((None, {(0, 1), (1, 2)}), (False, set()), (True, {(0, 1), (1, 2)})):
        scene = lm.Scene(dimension=2)
        bar = lm.RigidBody([Segment(5 * R, 0.5 * R)], mass=1.0, inertia=1.0, position=(0, 0.5 * R), color="BAR")
        bead = lm.disk(radius=R, position=(0.0, 2.0 * R), mass=1.0)
        lid = lm.wall(point=(0.0, 3.0 * R), normal=(0, -1))
        bodies = [scene.add(body) for body in (bar, bead, lid)]
        scene.see("GRAIN", "BAR", LAW)
        scene.see("WALL", "GRAIN", LAW)
        scene.chain(bodies[:2], lm.RigidRod(), neighbours_collide=asked)
        scene.chain(bodies[1:], lm.RigidRod(), reference_gap=None, neighbours_collide=True if asked is None else asked)
        assert contacts(scene) == met


def test_overlaps_of_neighbours_that_do_not_collide_are_not_told():
    scene, _ = row_of(3, gap=-0.5 * R)
    lm.Simulation(scene, time_step=1e-3, overlap="stop")
    scene, _ = row_of(3, gap=-0.5 * R, neighbours_collide=True)
    with pytest.raises(ValueError, match="2 pairs of bodies overlap at the start"):
        lm.Simulation(scene, time_step=1e-3, overlap="stop")
