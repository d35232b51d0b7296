"""What a scene is made of before it is compiled."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.scene.description import build, describe

SAND = lm.Material("sand", density=2600.0)


def row_of_beads(count=4):
    scene = lm.Scene(dimension=2)
    return scene, [scene.add(lm.disk(radius=0.01, position=(0.03 * i, 0.0), material=SAND)) for i in range(count)]


def test_a_disk_has_the_mass_of_its_material_per_metre_of_depth():
    disk = lm.disk(radius=0.1, position=(0, 0), material=SAND)
    assert disk.mass == pytest.approx(2600.0 * math.pi * 0.01)
    assert disk.inertia == pytest.approx(0.5 * disk.mass * 0.01)


def test_mass_and_inertia_override_the_material():
    assert lm.disk(radius=0.1, position=(0, 0), material=SAND, mass=2.0).mass == 2.0
    assert lm.disk(radius=0.1, position=(0, 0), material=SAND, mass=2.0).inertia == pytest.approx(0.01)
    assert lm.disk(radius=0.1, position=(0, 0), mass=2.0, inertia=7.0).inertia == 7.0


def test_a_wall_has_a_unit_normal():
    assert lm.wall(point=(0, 0), normal=(3, 4)).normal == pytest.approx([0.6, 0.8])


def test_ids_are_rows_in_the_order_of_adding():
    scene = lm.Scene(dimension=2)
    bodies = [lm.disk(radius=0.1, position=(i, 2 * i), mass=1.0) for i in range(3)]
    assert [body.id for body in bodies] == [-1, -1, -1]
    assert [scene.add(body) for body in reversed(bodies)] == bodies[::-1]
    assert [body.id for body in bodies] == [2, 1, 0]
    assert lm.Simulation(scene, time_step=1.0).positions.tolist() == [[2, 4], [1, 2], [0, 0]]


def test_reference_gaps_of_a_chain():
    """A number, one a link, or as built: surface gaps."""
    scene, beads = row_of_beads()
    assert scene.chain(beads, lm.RigidWire()).reference_gap == pytest.approx([0.01] * 3)
    assert scene.chain(beads, lm.RigidWire(), reference_gap=0.02).reference_gap.tolist() == [0.02] * 3
    gaps = np.array([0.01, 0.02, 0.03])
    assert scene.chain(beads, lm.RigidWire(), reference_gap=gaps).reference_gap.tolist() == gaps.tolist()
    chain = scene.chain(beads, lm.RigidWire(), closed=True)
    assert chain.reference_gap == pytest.approx([0.01] * 3 + [0.07])
    assert chain.path.tolist() == [0, 1, 2, 3, 0]


def test_what_is_no_blow_is_not_refused():
    """A slack wire, an elastic link that is stretched, a rigid one that is drawn in, a rounding of the gap."""
    scene, beads = row_of_beads()
    scene.chain(beads, lm.RigidWire(), reference_gap=0.02)
    scene.chain(beads, lm.ElasticRod(stiffness=1.0), reference_gap=0.005)
    scene.chain(beads, lm.RigidRod(), reference_gap=0.005, relaxation=1.0)
    scene.chain(beads, lm.RigidRod(), reference_gap=0.01 - 1e-9)
    assert len(scene.chains) == 4


def test_a_link_to_what_is_no_disk_ends_at_its_centre():
    scene, beads = row_of_beads(1)
    hook = scene.add(lm.wall(point=(0.0, 0.5), normal=(0, -1)))
    chain = scene.chain([hook, beads[0]], lm.RigidWire())
    assert chain.reference_gap == pytest.approx([0.49])


def test_bodies_and_scenes_say_what_they_are():
    scene, beads = row_of_beads(2)
    chain = scene.chain(beads, lm.RigidWire())
    assert repr(beads[1]) == "<Disk 'GRAIN', body 1, at (0.03, 0) m>"
    assert repr(lm.wall(point=(1, 2), normal=(0, 1))) == "<Wall 'WALL', body not yet in a scene, at (1, 2) m>"
    assert repr(chain) == "<Chain of 2 bodies, RigidWire()>"
    assert repr(scene) == "<Scene in 2D: 2 bodies, 0 rows of the visibility table, 1 chains>"


def test_a_start_is_copied():
    """Arrays that a user goes on using are not the body's."""
    place = np.zeros(2)
    body = lm.disk(radius=0.1, position=place, mass=1.0)
    place[0] = 5.0
    assert body.position.tolist() == [0.0, 0.0]


def test_one_material_may_make_many():
    material = lm.Material("sand", density=2600.0)
    assert material == SAND
    with pytest.raises(AttributeError):
        material.density = 1.0


def test_a_file_of_a_former_version_may_have_two_rows_of_the_same_colours():
    """Since then `see` refuses them."""
    scene, _ = row_of_beads()
    for law in (lm.Coulomb(friction=0.3), lm.Signorini()):
        scene._rows.append((scene.bodies[0].color, scene.bodies[0].color, law, None))
    assert [repr(law) for _, _, law, _ in build(describe(scene)).rows] == ["Coulomb(friction=0.3)", "Signorini()"]


def test_the_visibility_table_may_be_set_to_rows_that_see_would_take():
    """A sample under another law; what is refused leaves the table as it was."""
    scene, _ = row_of_beads()
    scene.add(lm.wall(point=(0, -1), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3), alert=0.01)
    scene.rows = [(c, a, lm.Signorini(), alert) for c, a, _, alert in scene.rows]
    before = scene.rows
    assert before == (("GRAIN", "WALL", lm.Signorini(), 0.01),)
    law = lm.Coulomb(friction=0.5)
    for rows, error, words in [
        ([("GRAIN", "WALL", law, None), ("WALL", "GRAIN", law, None)], ValueError, "would act on the same pairs"),
        ([("GRAIN", "WALL", lm.RigidWire(), None)], TypeError, "is for a link"),
        ([("GRAIN", "WALL", law)], TypeError, r"A row of the visibility table is \(candidate, .*, got"),
        (law, TypeError, "rows must be a list of"),
        (["GRAIN"], TypeError, "A row of the visibility table is"),
    ]:
        with pytest.raises(error, match=words):
            scene.rows = rows
        assert scene.rows == before
    with pytest.raises(AttributeError, match="no attribute 'append'"):
        scene.rows.append(before[0])
    lm.Simulation(scene, time_step=1e-3)
    with pytest.raises(RuntimeError, match="Cannot set the visibility table: a Simulation has compiled this scene"):
        scene.rows = []
