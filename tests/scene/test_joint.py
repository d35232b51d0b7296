"""Points of bodies in scenes: what is refused, what files keep, and which bodies collide."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lmgcpy as lm
from lmgcpy.scene.description import describe, from_description


def two(d: int, apart: float = 0.3) -> tuple[lm.Scene, lm.Body, lm.Body]:
    """A scene of two bodies with axes, side by side."""
    scene = lm.Scene(dimension=d)
    made = []
    for x in (0.0, apart):
        place = np.array([x] + [0.0] * (d - 1))
        if d == 2:
            made.append(scene.add(lm.disk(radius=0.1, position=place, mass=1.0)))
        else:
            made.append(scene.add(lm.capsule(radius=0.1, length=0.1, position=place, mass=1.0)))
    return scene, made[0], made[1]


@pytest.mark.parametrize(
    ("at", "words"),
    [
        (((0.0, 0.1, 0.0, 0.0), None), "must be 3 numbers"),
        (((0.0, np.inf, 0.0), None), "must be finite"),
        ("text", "at must be two points"),
        (((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "is open by 0.3 m"),
        (((0.1, 0.0, 0.0), (0.1, 0.0, 0.0)), "is open by 0.3 m"),
    ],
)
def test_points_that_are_none_are_refused(at, words):
    scene, a, b = two(3)
    with pytest.raises((TypeError, ValueError), match=words):
        scene.link(a, b, lm.BallJoint(), at=at)
    assert not scene.joints


def test_what_no_joint_can_be_is_refused():
    scene, a, b = two(2)
    with pytest.raises(ValueError, match="cannot be tied to itself"):
        scene.link(a, a, lm.BallJoint())
    with pytest.raises(ValueError, match="no reference_gap"):
        scene.link(a, b, lm.BallJoint(), at=((0.15, 0.0), (-0.15, 0.0)), reference_gap=0.1)
    with pytest.raises(TypeError, match=r"give it to Scene\.link"):
        scene.chain([a, b], lm.BallJoint())
    with pytest.raises(TypeError, match=r"give it to Scene\.link"):
        scene.see("GRAIN", "GRAIN", lm.BallJoint())
    with pytest.raises(ValueError, match="in the chain twice"):
        scene.chain([a, b, (a, (0.1, 0.0))], lm.RigidWire())
    with pytest.raises(ValueError, match="not in this scene"):
        scene.link(a, lm.disk(radius=0.1, position=(0, 0), mass=1.0), lm.RigidWire())
    assert not scene.joints
    assert not scene.chains


def test_a_sphere_has_no_point_off_its_centre():
    scene = lm.Scene(dimension=3)
    a, b = (scene.add(lm.sphere(radius=0.1, position=(x, 0, 0), mass=1.0)) for x in (0.0, 0.3))
    with pytest.raises(ValueError, match="make it a clump of one sphere"):
        scene.link(a, b, lm.RigidWire(), at=((0.1, 0.0, 0.0), None))
    link = scene.link(a, b, lm.RigidWire(), at=((0.0, 0.0, 0.0), None))  # a centre needs no axes
    assert link.reference_gap == pytest.approx([0.2])


@pytest.mark.parametrize("d", [2, 3])
def test_a_link_ends_at_its_point(d):
    """Its gap is measured from there, not from the surface; between centres nothing changes."""
    scene, a, b = two(d)
    point = np.eye(d)[1] * 0.05
    link = scene.link(a, b, lm.RigidWire(), at=(point, None))
    assert link.lengths() == pytest.approx([np.hypot(0.3, 0.05)])
    assert link.reference_gap == pytest.approx(link.lengths() - b.link_radius)


def test_a_point_of_a_clump_is_where_its_shape_has_it():
    shape = lm.clump([0.1, 0.06, 0.05], [(0, 0, 0), (0.12, 0.03, 0), (0, 0.1, 0.05)], density=1000.0)
    turn = Rotation.random(random_state=3)
    body = shape.at((1.0, 2.0, 3.0), rotation=turn, scale=2.0)
    where = body.position + body.rotation.apply(shape.point((0.12, 0.03, 0.0), scale=2.0))
    ball = body.position + body.rotation.apply(np.array(body.contactors[1][1]))
    np.testing.assert_allclose(where, ball, atol=1e-14)
    flat = lm.clump([0.1, 0.05], [(0, 0), (0.1, 0.05)], density=1000.0)
    np.testing.assert_allclose(flat.point((0.1, 0.05)), flat.offsets[1], atol=1e-15)


@pytest.mark.parametrize("d", [2, 3])
def test_a_description_keeps_points_and_joints(d):
    scene, a, b = two(d)
    post = scene.add(lm.wall(point=-np.eye(d)[0], normal=np.eye(d)[0]))
    half = np.eye(d)[0] * 0.15
    scene.link(a, b, lm.BallJoint(), at=(half, -half), neighbours_collide=True)
    scene.chain([(post, 0.2 * np.eye(d)[1]), a], lm.RigidWire())
    scene.chain([a, b], lm.RigidRod())
    again = from_description(describe(scene))
    for one, other in zip(scene.chains, again.chains, strict=True):
        np.testing.assert_array_equal(one.lengths(), other.lengths())
        assert [node.point is None for node in one.nodes] == [node.point is None for node in other.nodes]
    (joint,) = again.joints
    assert [body.id for body in joint.bodies] == [a.id, b.id]
    np.testing.assert_array_equal(joint.nodes[0].point, half)
    assert joint.collide
    damaged = describe(scene)
    damaged["joints"] = {**damaged["joints"], "point": damaged["joints"]["point"][:, :, :1]}
    with pytest.raises(ValueError, match="points at which links act do not fit"):
        from_description(damaged)


@pytest.mark.parametrize("d", [2, 3])
def test_tied_bodies_do_not_collide_unless_they_are_to(d):
    for collide, count in ((None, 0), (True, 1)):
        scene, a, b = two(d, 0.15)  # they overlap
        half = np.eye(d)[0] * 0.075
        scene.link(a, b, lm.BallJoint(), at=(half, -half), neighbours_collide=collide)
        scene.see("GRAIN", "GRAIN", lm.Signorini())
        sim = lm.Simulation(scene, time_step=1e-3, overlap="ignore", on_unconverged="ignore").run(steps=1)
        contacts = sim.interactions.law == "signorini"
        assert bool(contacts.any()) == bool(count)
        assert len(lm.view.check(scene).overlaps) == count


def test_a_tied_body_cannot_be_hidden():
    scene, a, b = two(2)
    scene.link(a, b, lm.BallJoint(), at=((0.15, 0.0), (-0.15, 0.0)))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    with pytest.raises(ValueError, match="chain"):
        a.hide()
    assert "Joint" in repr(scene.joints[0])
    sim.run(steps=1)
