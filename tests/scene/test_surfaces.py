"""Surfaces as bodies: masses, sides, cleaning, files of meshes, and sentences for what is none."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import lmgcpy as lm

OAK = lm.Material("oak", 700.0)
POINTS = np.array(list(product((-0.5, 0.5), repeat=3)))
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = np.array([t for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))])
TWICE, BOTH = np.concatenate([POINTS, POINTS]), np.concatenate([CUBE, CUBE + 8])
SECOND = np.repeat([0.0, 1.0], 8)[:, None]
SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
EIGHT = [(0, 0), (1, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1), (0, 1)]


def kinds(surface):
    return {of.kind: len(of.radii) for of in surface.features}


def test_features_are_those_that_a_ball_can_meet():
    """Of a cube: diagonals of its faces have no contactor; from inside neither have edges and corners, which are kept as
    corners that nothing meets."""
    assert kinds(lm.mesh(POINTS, CUBE)) == {"face": 12, "edge": 12, "corner": 8}
    assert kinds(lm.mesh(POINTS, CUBE, sides="outside")) == {"face": 12, "edge": 12, "corner": 8}
    assert kinds(lm.mesh(POINTS, CUBE, sides="inside")) == {"face": 12, "edge": 0, "corner": 8}
    assert kinds(lm.plate([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)])) == {"face": 2, "edge": 4, "corner": 4}
    assert kinds(lm.wall_segment(*SQUARE)) == {"line": 3, "tip": 4}
    assert kinds(lm.wall_segment((0, 0), (1, 0), (2, 0))) == {"line": 2, "tip": 2}


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("sides", ["outside", "inside"])
def test_the_side_does_not_depend_on_the_order_of_corners(flipped, sides):
    triangles = CUBE[:, ::-1] if flipped else CUBE
    faces = lm.mesh(POINTS, triangles, sides=sides).features[0]
    outward = (faces.shapes[:, 3:6] * faces.middles).sum(axis=1)
    assert ((outward > 0.0) == (sides == "outside")).all()
    lines = lm.wall_segment(*(SQUARE[::-1] if flipped else SQUARE), closed=True, sides=sides).features[0]
    outward = (lines.shapes[:, 3:5] * lines.middles).sum(axis=1)
    assert ((outward > 0.0) == (sides == "outside")).all()


def test_a_face_reaches_half_way_through_the_solid():
    flat = lm.mesh(POINTS * (1.0, 1.0, 0.2), CUBE, sides="outside").features[0]
    upward = np.abs(flat.shapes[:, 5]) > 0.5
    assert flat.shapes[upward, 2] == pytest.approx(0.1)
    assert flat.shapes[~upward, 2] == pytest.approx(0.5)
    square = lm.wall_segment(*SQUARE, closed=True, sides="outside").features[0]
    assert sorted(square.shapes[:, 2]) == pytest.approx([0.5, 0.5, 1.0, 1.0])


@pytest.mark.parametrize("far", [1e4, 1e6, 1e8])
def test_a_thin_solid_far_from_the_origin_or_from_its_centre_is_met_to_its_middle(far):
    """A thousandth of its size thick; coordinates of 1e8 m are rounded to 1.5e-8 m."""
    place, thin = far * np.array([0.3, 0.1, 0.7]), POINTS * (1.0, 1.0, 1e-3)
    for solid in (lm.mesh(thin + place, CUBE, sides="outside"), lm.mesh(thin, CUBE, sides="outside", centre=place)):
        flat = solid.features[0].shapes
        assert flat[np.abs(flat[:, 5]) > 0.5, 2] == pytest.approx(5e-4, abs=2e-8)
    strip = np.array(SQUARE) * (0.5, 1e-3)
    for centre, shift in ((None, place[:2]), (place[:2], 0.0)):
        lines = lm.wall_segment(strip + shift, closed=True, sides="outside", centre=centre).features[0].shapes
        assert sorted(lines[:, 2])[:2] == pytest.approx([5e-4, 5e-4], abs=2e-8)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_body_of_a_material_has_the_mass_of_its_volume(flipped):
    box = lm.mesh(POINTS * (1.0, 2.0, 3.0) + 5.0, CUBE[:, ::-1] if flipped else CUBE, material=OAK)
    assert box.mass == pytest.approx(4200.0)
    assert box.inertia == pytest.approx(350.0 * np.array([13.0, 10.0, 5.0]))
    assert box.position == pytest.approx([5.0] * 3)
    assert not box.held_by_default
    assert box.turns
    rectangle = lm.wall_segment(*(SQUARE[::-1] if flipped else SQUARE), closed=True, material=OAK)
    assert rectangle.mass == pytest.approx(1400.0)
    assert rectangle.inertia == pytest.approx(1400.0 * 5.0 / 12.0)
    assert rectangle.position == pytest.approx([1.0, 0.5])


def test_what_holds_a_surface():
    """Nothing given: a wall; a mass: a wall that may be loaded; a mass and an inertia, or a material: free."""
    wall, loaded = lm.plate(np.eye(3)), lm.plate(np.eye(3), mass=2.0)
    free = lm.plate(np.eye(3), mass=2.0, inertia=1.0)
    assert [body.held_by_default for body in (wall, loaded, free)] == [True, True, False]
    assert [body.gravity_acts for body in (wall, loaded, free)] == [False, False, True]
    assert [np.isfinite(body.extent) for body in (wall, loaded, free)] == [False, False, True]
    assert not wall.turns
    assert lm.plate(np.eye(3)).impose_velocity(spin_x=1.0).turns
    assert lm.plate(np.eye(3), rotation=(0, 0, 0, 1)).turns
    with pytest.raises(ValueError, match="has no mass"):
        wall.impose_force(z=1.0)


def test_a_wall_that_began_unturned_cannot_turn_later():
    scene = lm.Scene(dimension=3)
    wall = scene.add(lm.plate(np.eye(3)))
    scene.add(lm.sphere(radius=0.1, position=(3, 3, 3), mass=1.0))
    lm.Simulation(scene, time_step=1e-3).run(steps=1)
    wall.impose_velocity(x=1.0)
    with pytest.raises(ValueError, match=r"keeps no rotation.*rotation="):
        wall.impose_velocity(spin_x=1.0)


def test_equal_points_are_one():
    apart = POINTS[CUBE].reshape(-1, 3) + 1e-12
    surface = lm.mesh(apart, np.arange(36).reshape(-1, 3), sides="outside")
    assert kinds(surface) == {"face": 12, "edge": 12, "corner": 8}


WRONG = {
    "open": (lambda: lm.mesh(POINTS, CUBE[1:], sides="outside"), "is open"),
    "facing in and out": (lambda: lm.mesh(POINTS, [*CUBE[1:], CUBE[0][::-1]], sides="inside"), "face inward beside"),
    "flat": (lambda: lm.mesh(np.eye(3), [(0, 1, 2), (0, 2, 1)], sides="outside"), "is flat"),
    "a line": (lambda: lm.mesh([*POINTS, (0.5, 0.5, 0.0)], [*CUBE, (7, 8, 6)]), r"Triangle 12 .* is a line"),
    "three at an edge": (lambda: lm.mesh([*POINTS, (3, 3, 3)], [*CUBE, (0, 1, 8)]), r"3 triangles .* 12, meet"),
    "the same twice": (lambda: lm.mesh(POINTS, [*CUBE, CUBE[3]]), "triangles of the mesh"),
    "a T-joint": (
        lambda: lm.mesh([(0, 0, 0), (2, 0, 0), (0, 1, 0), (1, 0, 0), (0, -1, 0)], [(0, 1, 2), (0, 4, 3)]),
        r"at \(1, 0, 0\) m, lies inside an edge of its triangle 0",
    ),
    "a million": (lambda: lm.mesh(POINTS, np.tile(CUBE, (100_000, 1))), "1200000 triangles"),
    "material of an open one": (lambda: lm.wall_segment(*SQUARE, material=OAK), "is open"),
    "side of an open one": (lambda: lm.wall_segment(*SQUARE, sides="outside"), "no solid behind"),
    "crossing": (
        lambda: lm.mesh(TWICE + (0.5, 0.5, 0.5) * SECOND, BOTH, sides="outside"),
        r"Triangles 6 and 12 of the mesh cross each other, at \(0, 0.5, 0.5\) m: make a surface of each solid",
    ),
    "one in the other, with flush sides": (
        lambda: lm.mesh(TWICE + (0.5, 0.0, 0.0) * SECOND, BOTH, material=OAK),
        "Triangle 2 of the mesh, at .*, lies within the solid of others: make a surface of each solid",
    ),
    "one in the other": (lambda: lm.mesh(TWICE * (1.0 - 0.5 * SECOND), BOTH, sides="inside"), "lies within the solid"),
    "one inside out": (
        lambda: lm.mesh(TWICE * (1.0 - 0.5 * SECOND) + 3.0 * SECOND, [*CUBE, *CUBE[:, ::-1] + 8], sides="outside"),
        "Triangle 12 of the mesh, at .*, faces inward, and others outward",
    ),
    "a polyline that crosses itself": (
        lambda: lm.wall_segment((0, 0), (1, 1), (1, 0), (0, 1), closed=True, sides="inside"),
        r"Segments 0 and 2 of wall_segment cross each other, at \(0.5, 0.5\) m: make a closed polyline of each part",
    ),
    "a flat polyline": (
        lambda: lm.wall_segment((0, 0), (2, 0), (1, 0), closed=True, sides="outside"),
        "wall_segment is flat: it encloses no area",
    ),
    "a spike": (
        lambda: lm.wall_segment((0, 0), (1, 0), (1, 1), (1, 2), (1, 1), (0, 1), closed=True, sides="outside"),
        r"Segment 2 of wall_segment, at \(1, 1.5\) m, has nothing behind it: it lies on a spike",
    ),
    "a sheet of a polyline": (
        lambda: lm.wall_segment((0, 0), (1, 0), (1, 1e-7), (0, 1e-7), closed=True, sides="outside"),
        "Segment 0 .* has nothing behind it: it lies on a spike, or on a part thinner than 1e-06 of the size",
    ),
    "a sheet": (
        lambda: lm.mesh(POINTS * (1.0, 1.0, 1e-7), CUBE, sides="outside"),
        "Triangle 8 of the mesh, at .*, has nothing behind it",
    ),
    "a polyline that crosses itself at a point": (
        lambda: lm.wall_segment(*EIGHT, closed=True, sides="outside"),
        r"Segment 2 .* faces inward, and others outward: wall_segment crosses itself at a point: make a closed polyline",
    ),
    "equal cubes, one inside out": (
        lambda: lm.mesh(TWICE + 3.0 * SECOND, [*CUBE, *CUBE[:, ::-1] + 8], sides="outside"),
        "Triangle .* faces inward, and others outward",
    ),
    "points on planes": (lambda: see_each_other(0.0), "give one of them a radius"),
}


SOLIDS = {
    "beside each other": (TWICE + (2.0, 0.3, 0.0) * SECOND, BOTH, 2.0),
    "that touch by their sides": (TWICE + (1.0, 0.3, 0.0) * SECOND, BOTH, 2.0),
    "that cross by the digits of a file": (TWICE + (1.0 - 3e-7, 0.3, 0.2) * SECOND, BOTH, 2.0),
    "that touch by their corners": (TWICE + SECOND, BOTH, 2.0),
    "with a cavity": (TWICE * (1.0 - 0.5 * SECOND), np.concatenate([CUBE, CUBE[:, ::-1] + 8]), 1.0 - 0.125),
}


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("name", SOLIDS)
def test_solids_that_do_not_cross_are_one_mesh(name, flipped):
    points, triangles, volume = SOLIDS[name]
    order = triangles[:, ::-1] if flipped else triangles
    for turn in (np.eye(3), np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]):
        solid = lm.mesh(points @ turn, order, material=OAK, sides="outside")
        assert solid.mass == pytest.approx(700.0 * volume)


def see_each_other(radius):
    scene = lm.Scene(dimension=3)
    scene.add(lm.mesh(POINTS + 3.0, CUBE, material=OAK, color="A", radius=radius))
    scene.add(lm.plate(np.eye(3)))
    scene.see("A", "WALL", lm.Coulomb(friction=0.3))
    lm.Simulation(scene, time_step=1e-3)


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_surface_gets_a_sentence(name):
    call, words = WRONG[name]
    with pytest.raises(ValueError, match=words) as caught:
        call()
    assert str(caught.value).endswith(".")


def test_surfaces_see_each_other_with_a_radius():
    see_each_other(0.01)


def test_files_of_meshes(tmp_path):
    """An STL file has each corner of each triangle, in single precision; lengths are scaled."""
    pyvista = pytest.importorskip("pyvista")
    for name in ("cube.stl", "cube.ply", "cube.obj", "cube.vtp"):
        pyvista.PolyData.from_regular_faces(1000.0 * POINTS, CUBE).save(tmp_path / name)
        cube = lm.read_mesh(tmp_path / name, scale=1e-3, sides="outside", material=OAK)
        assert kinds(cube) == {"face": 12, "edge": 12, "corner": 8}
        assert cube.mass == pytest.approx(700.0)
    for text, error in (("nothing", OSError), (None, FileNotFoundError)):
        path = tmp_path / "other.stl"
        if text is not None:
            path.write_text(text)
        with pytest.raises((error, ValueError), match=r"other\.stl"):
            lm.read_mesh(path)
        path.unlink(missing_ok=True)
    with pytest.raises(ValueError, match="scale"):
        lm.read_mesh(tmp_path / "cube.stl", scale=0.0)


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_a_turned_scene_with_its_triangles_in_another_order_does_the_same(seed):
    """A ball on a rough sheet: turned about the vertical, its triangles permuted and their corners rolled. To the tolerance
    of the solver and to rounding, 1e-9 of the way."""
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    x, y = (along.ravel().astype(float) for along in np.meshgrid(range(7), range(7), indexing="ij"))
    square = [7 * i + j for i, j in product(range(6), repeat=2)]
    triangles = np.array([t for a in square for t in ((a, a + 7, a + 8), (a, a + 8, a + 1))])
    points = np.column_stack([x, y, 0.1 * rng.normal(size=49)])
    ends = []
    for turn, order in ((Rotation.identity(), np.arange(72)), (Rotation.from_rotvec([0, 0, 0.7]), rng.permutation(72))):
        scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
        start, velocity = turn.apply((2.3, 3.1, 0.6)), turn.apply((0.7, -0.4, 0.0))
        ball = scene.add(lm.sphere(radius=0.3, position=start, velocity=velocity, mass=1.0))
        scene.add(lm.mesh(turn.apply(points), np.roll(triangles[order], int(order[0]) % 3, axis=1), radius=0.02))
        scene.see("GRAIN", "WALL", lm.Signorini())
        lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=500)
        ends.append(turn.inv().apply(ball.position))
    assert ends[1] == pytest.approx(ends[0], abs=1e-9)
