"""What is drawn, as numbers: walls cut to the sample, force lines, sections, projections."""

import numpy as np
import pytest
from mixed_scene import mixed_scene
from seen import SIDE, hanging, pile, wire_in_a_box

import lmgcpy as lm
from lmgcpy.view.boundary import cut, cylinder_polygons, wall_polygons
from lmgcpy.view.compose import AMONG_WIRES, compose, force_tubes, panels_of
from lmgcpy.view.drawing import BEAD, CONTACT, WIRE, WRONG, rgb
from lmgcpy.view.snapshot import snapshot
from lmgcpy.view.style import OPTIONS, Camera, View, style_of


def drawn(source, **options):
    snap = snapshot(source)
    words = {**dict.fromkeys(OPTIONS), **options}
    return compose(snap, style_of(words, dimension=snap.dimension, is_scene=snap.time is None))


def area(polygon):
    return 0.5 * np.linalg.norm(sum(np.cross(a, b) for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True)))


# -------------------------------------------------------------------------------------------------------------- walls


def test_six_walls_are_the_faces_of_the_box():
    """Each cut by the others to its own square, whatever the sample inside."""
    faces = wall_polygons(snapshot(wire_in_a_box()))
    assert [len(face) for face in faces] == [4] * 6
    np.testing.assert_allclose([area(face) for face in faces], SIDE**2, rtol=1e-12)
    corners = np.concatenate(faces)
    assert corners.min() == pytest.approx(0.0, abs=1e-12)
    assert corners.max() == pytest.approx(SIDE, abs=1e-12)


def test_a_tilted_wall_in_a_corner():
    """A plane at 45 degrees cuts the edge of a cube: its face is a rectangle of the side times sqrt(2)."""
    scene = wire_in_a_box()
    scene.add(lm.wall(point=(0.0, 0.0, 0.2), normal=np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0)))
    face = wall_polygons(snapshot(scene))[-1]
    assert area(face) == pytest.approx(0.8 * np.sqrt(2.0) * SIDE, rel=1e-12)


def test_an_open_box_ends_a_little_beyond_the_sample():
    snap = snapshot(mixed_scene())
    pieces = wall_polygons(snap)
    assert [len(piece) for piece in pieces] == [2, 2, 2]
    floor, left, right = pieces
    np.testing.assert_allclose(floor[:, 1], 0.0, atol=1e-12)
    assert floor[:, 0].min() == pytest.approx(0.0, abs=1e-12)  # where the left wall stands
    top = (snap.rounds.position[:, 1] + snap.rounds.shape[:, 0]).max()
    assert top < left[:, 1].max() < 1.2 * top
    normal = snap.walls.shape[2]
    np.testing.assert_allclose((right[:, :2] - snap.walls.position[2]) @ normal, 0.0, atol=1e-12)


def test_a_far_wall_does_not_shrink_the_picture():
    scene = wire_in_a_box()
    scene.add(lm.wall(point=(0.0, 0.0, -1000.0), normal=(0, 0, 1)))
    assert len(wall_polygons(snapshot(scene))[-1]) == 0


def test_cylinders_stand_on_the_floor():
    scene = lm.Scene(dimension=3)
    scene.add(lm.sphere(radius=0.1, position=(0.0, 0.0, 0.3), mass=1.0))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=0.5))
    points = np.concatenate(cylinder_polygons(snapshot(scene)))
    np.testing.assert_allclose(np.linalg.norm(points[:, :2], axis=1), 0.5, rtol=1e-12)
    assert points[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert 0.4 < points[:, 2].max() < 0.5


def test_cutting_a_line_and_a_square():
    line = np.array([[0.0, 0.0], [2.0, 0.0]])
    np.testing.assert_allclose(cut(line, np.array([-1.0, 0.0]), np.array([0.5, 0.0])), [[0.0, 0.0], [0.5, 0.0]])
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    corner = cut(square, np.array([-1.0, -1.0, 0.0]), np.array([0.5, 0.0, 0.0]))
    assert area(corner) == pytest.approx(0.125)
    assert len(cut(square, np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))) == 0


# ------------------------------------------------------------------------------------------------------------- forces


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_of_a_pile(dimension):
    """From centre to centre, at the floor from the contact point; 3, 2 and 1 times the weight of a ball."""
    drawing = drawn(pile(3, dimension), what="forces")
    (tubes,) = [tubes for tubes in drawing.tubes if tubes.by_force]
    order = np.argsort(-tubes.radii)
    np.testing.assert_allclose(tubes.radii[order], [3.0, 2.0, 1.0], rtol=1e-6)
    up = dimension - 1
    ends = np.sort(np.stack([tubes.starts[:, up], tubes.ends[:, up]], axis=1), axis=1)[order]
    np.testing.assert_allclose(ends, [[0.0, 0.5], [0.5, 1.5], [1.5, 2.5]], atol=1e-4)
    np.testing.assert_allclose(np.delete(np.stack([tubes.starts, tubes.ends]), up, axis=2), 0.0, atol=1e-12)
    assert tubes.paint.color == CONTACT
    assert drawing.legend == [("contact reaction", CONTACT)]


def test_tension_has_its_colour_and_size():
    drawing = drawn(hanging(3), what="forces")
    (tubes,) = [tubes for tubes in drawing.tubes if tubes.by_force]
    np.testing.assert_allclose(tubes.radii, [3.0, 2.0, 1.0], rtol=1e-9)
    assert tubes.paint.color == WIRE


def test_what_is_wrong_is_red():
    drawing = drawn(wire_in_a_box(overlap=0.3, stretch=1.25))
    (red,) = [balls for balls in drawing.balls if balls.paint.color == WRONG]
    np.testing.assert_allclose(red.centres, [[0.3, 0.5, 0.7], [0.47, 0.5, 0.7]])
    (long,) = [tubes for tubes in drawing.tubes if tubes.paint.color == WRONG]
    assert len(long.radii) == 4
    labels = [label for label, _ in drawing.legend]
    assert labels == ["overlaps by more than 1 %", "longer than its reference"]


# --------------------------------------------------------------------------------------------------- clip and section


def test_clip_leaves_out_the_near_side():
    """Seen from x, the eye is at large x: what lies before the plane goes."""
    scene = wire_in_a_box()
    near = drawn(scene, camera="x", clip=("x", 0.35))
    assert len(near.balls[0].radii) == 1
    far = drawn(scene, camera=(-1.0, 0.0, 0.0), clip=("x", 0.35))
    assert len(far.balls[0].radii) == 1
    assert near.balls[0].centres[0, 0] < 0.35 < far.balls[0].centres[0, 0]
    assert len(near.walls) == 6


def test_section_cuts_disks_out_of_spheres():
    """At half a radius from the centre a sphere's section has radius sqrt(3)/2; the box's is a square."""
    flat = drawn(wire_in_a_box(), section=("y", 0.55))
    assert flat.flat
    (grains,) = flat.balls
    np.testing.assert_allclose(grains.radii, np.sqrt(0.75) * 0.1, rtol=1e-12)
    np.testing.assert_allclose(grains.centres, [[0.3, 0.7, 0.0], [0.5, 0.7, 0.0]], atol=1e-12)
    assert sum(np.linalg.norm(line[1] - line[0]) for line in flat.lines) == pytest.approx(4.0 * SIDE)
    assert len(flat.tubes[0].radii) == 4  # the wire is at y = 0.5, within a mean radius
    assert len(drawn(wire_in_a_box(), section=("y", 0.61)).tubes[0].radii) == 0


def test_hidden_grains_and_wires():
    scene = wire_in_a_box()
    assert drawn(scene, grains="hidden").balls == []
    assert drawn(scene, wires="hidden").tubes == []
    assert drawn(scene, opacity=0.5).balls[0].opacity == 0.5
    assert drawn(scene, wires="hidden").balls[0].opacity == 1.0
    assert drawn(scene).balls[0].opacity < 1.0


def test_colours_of_the_visibility_table():
    drawing = drawn(mixed_scene(), grains="color")
    assert [label for label, _ in drawing.legend] == ["GRAIN"]


def test_a_colour_is_the_same_in_every_panel():
    scenes = []
    for words in (("SAND", "FIBRE", "FIBRE"), ("FIBRE", "STONE")):
        scenes.append(lm.Scene(dimension=2))
        for k, word in enumerate(words):
            scenes[-1].add(lm.disk(radius=1.0, position=(3.0 * k, 0.0), mass=1.0, color=word))
    panels = panels_of(scenes, None, {**dict.fromkeys(OPTIONS), "grains": "color"}, moving=False)
    one, other = (dict(panel.drawings[0]().legend) for panel in panels)
    assert (list(one), list(other)) == (["SAND", "FIBRE"], ["FIBRE", "STONE"])
    assert one["FIBRE"] == other["FIBRE"]
    assert len({*one.values(), *other.values()}) == 3


# ------------------------------------------------------------------------------------------------------------- camera


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.6, -0.48, 0.64)])
def test_the_camera_is_a_right_handed_frame(direction):
    camera = Camera.looking(direction)
    frame = np.array([camera.right, camera.up, camera.towards])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_allclose(camera.towards, direction)


def test_axes_on_screen():
    """Along x one sees y to the right, along y x, along z x with y up: as in drawings."""
    for axis, direction, right, up in (
        ("x", (1, 0, 0), [0, 1, 0], [0, 0, 1]),
        ("y", (0, -1, 0), [1, 0, 0], [0, 0, 1]),
        ("z", (0, 0, 1), [1, 0, 0], [0, 1, 0]),
    ):
        camera = Camera.looking(direction)
        np.testing.assert_allclose(camera.right, right, err_msg=axis)
        np.testing.assert_allclose(camera.up, up, err_msg=axis)


def test_a_view_holds_its_points_and_keeps_lengths():
    points = np.random.default_rng(0).normal(size=(50, 3))
    view = View.of(Camera.looking((0.6, -0.48, 0.64)), points)
    width, height = view.image_size(100.0)
    at = view.pixels(points, 100.0)
    assert (at > 0.0).all()
    assert (at < [width, height]).all()
    across = points[0] + np.stack([np.zeros(3), view.camera.right])
    assert np.linalg.norm(np.diff(view.pixels(across, 100.0), axis=0)) == pytest.approx(100.0)
    np.testing.assert_allclose(view.pixels(view.centre[None], 100.0)[0], [0.5 * width, 0.5 * height], atol=1.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_tension_is_seen_among_contact_forces(dimension):
    """A wire of which one half is taut, and two balls on each other: the taut half is drawn by its force alone, the slack
    one pale, and in space contact forces are translucent."""
    scene = lm.Scene(dimension=dimension, gravity=(*(0.0,) * (dimension - 1), -10.0))
    make, zero = (lm.disk if dimension == 2 else lm.sphere), (0.0,) * (dimension - 1)
    hook, bead, heap = (scene.add(make(radius=0.1, position=(*zero, z), mass=1.0)) for z in (0.0, -1.0, -1.5))
    hook.fix()
    heap.fix()
    scene.chain([hook, bead, heap], lm.RigidWire(), reference_gap=[0.8, 5.0])
    for z, held in ((-5.0, True), (-4.8, False)):
        ball = scene.add(make(radius=0.1, position=(*zero, z), mass=30.0))
        if held:
            ball.fix()
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    drawing = drawn(sim, what="forces")
    course = drawing.tubes[0]
    assert course.starts[:, dimension - 1] == pytest.approx([-1.0])  # the slack link begins at the bead
    assert course.paint.rgb(1, {}).tolist() == [rgb(BEAD).tolist()]
    assert ("wire without force", BEAD) in drawing.legend
    by_force = {round(float(tubes.radii[0])): tubes for tubes in drawing.tubes if tubes.by_force}
    assert by_force[300].opacity == AMONG_WIRES  # a flat drawing takes no notice
    assert by_force[10].opacity == 1.0
    assert by_force[10].paint.color == WIRE
    coloured = drawn(sim, what="forces", wires="tension")
    assert len(coloured.tubes[0].starts) == 2
    assert ("course of the wire: not as thick as its force", "") in coloured.legend


@pytest.mark.parametrize(("pull", "opacity"), [(-0.5, AMONG_WIRES), (-1e-3, 1.0), (0.5, 1.0)])
def test_contact_forces_give_way_only_to_tensions_that_are_drawn(pull, opacity):
    """A contact of 1 N beside a link that pulls, pulls by too little to be drawn, or pushes."""
    ends = np.zeros((2, 3)), np.ones((2, 3))
    tubes = force_tubes(*ends, np.array([pull, 1.0]), np.array([True, False]), [])
    assert {float(piece.radii[0]): piece.opacity for piece in tubes} == {1.0: opacity} | (
        {0.5: 1.0} if abs(pull) == 0.5 else {}
    )
