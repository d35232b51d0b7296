"""Checkpoints with wrong content are refused with a sentence, and the simulation stays as it was."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

import lmgcpy as lm


def simulation(steps=3):
    """Three disks in a chain on a floor."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(3):
        scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.0), mass=1.0))
    scene.add(lm.wall(point=(0.0, -0.1), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.chain(scene.bodies[:3], lm.RigidWire())
    return lm.Simulation(scene, time_step=1e-3).run(steps=steps)


def wrong(value):
    """Values that cannot stand in the place of one."""
    if isinstance(value, np.ndarray):
        bad = [value[:, None], value.astype(object), value.astype(np.float32)]
        if value.dtype.kind == "f":
            bad.append(np.full_like(value, np.inf))
        return [7, *bad] if value.size else [7]
    if isinstance(value, bool):
        return [1, np.zeros(2)]
    return ["much", np.zeros(2), -1.5, np.nan] if isinstance(value, (int, float)) else ["much", 7, np.zeros(2)]


def wrong_checkpoints(point):
    """Copies of a checkpoint with one wrong entry each, and the name of that entry."""
    for name in (field.name for field in fields(point)):
        for bad in [None, *wrong(getattr(point, name))]:
            yield name, replace(point, **{name: bad})
    for name in (field.name for field in fields(point.memory)):
        for bad in [None, *wrong(getattr(point.memory, name))]:
            yield name, replace(point, memory=replace(point.memory, **{name: bad}))


def test_wrong_content_is_refused_with_a_sentence():
    sim = simulation()
    before = sim.checkpoint()
    checkpoints = list(wrong_checkpoints(before))
    assert len(checkpoints) > 60
    for name, checkpoint in checkpoints:
        with pytest.raises((TypeError, ValueError), match=r"^The checkpoint's .*" + name):
            sim.restore(checkpoint)
        np.testing.assert_array_equal(sim.positions, before.positions[:, :2])
        assert sim.time == before.time
        sim.step()
        sim.restore(before)


def test_memory_of_another_scene_is_refused_before_anything_is_restored():
    other = simulation(5)
    point = simulation().checkpoint()
    identity = point.memory.identity.copy()
    identity[:, 0] = 99
    with pytest.raises(ValueError, match="the memory is of another scene"):
        other.restore(replace(point, memory=replace(point.memory, identity=identity)))
    assert other.steps == 5
    other.step()


def test_a_good_one_is_taken():
    """And one from before links' predicted gaps were kept."""
    sim = simulation()
    point = sim.checkpoint()
    sim.restore(replace(point, predicted=np.zeros(0), worst_residual=np.inf))
    sim.restore(point)
    assert sim.steps == 3


def test_the_id_and_the_material_of_a_body_cannot_be_written():
    body = lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)
    with pytest.raises(AttributeError, match="property 'id' of 'Disk' object has no setter"):
        body.id = 7
    with pytest.raises(AttributeError, match="property 'material' of 'Disk' object has no setter"):
        body.material = "sand"


def test_links_that_turn_into_a_direction_in_which_their_bodies_yield():
    """Beads that are held along their wire and fall across it: in the first step no bead yields along a link, later they
    do. A run goes on from between the two with the same bits, the impulses of the links too."""

    def rope():
        scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
        at = 0.1 * np.arange(8) + 0.003 * np.arange(8) ** 2
        beads = [scene.add(lm.disk(radius=0.01, position=(x, 0.0), mass=0.1)).fix("x") for x in at]
        beads[0].fix("y")
        beads[-1].fix("y")
        scene.chain(beads, lm.ElasticWire(stiffness=3e3), reference_gap=0.05)
        return lm.Simulation(scene, time_step=1e-3)

    whole, again = rope().run(steps=5), rope()
    again.restore(whole.checkpoint())
    for _ in range(5):
        whole.step()
        again.step()
        assert np.array_equal(again.interactions.impulse, whole.interactions.impulse)
        assert again.energy.interactions == whole.energy.interactions
