"""Spheres that fill meshes, and the mass of what meshes enclose."""

import math
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lmgcpy.scene.mesh_clump import clump_from_mesh, mesh_solid
from lmgcpy.scene.solid import ball_union

pyvista = pytest.importorskip("pyvista")


def prism(outline, height):
    """A prism over a polygon, with outward triangles."""
    base = pyvista.PolyData(np.column_stack([outline, np.zeros(len(outline))]), faces=[len(outline), *range(len(outline))])
    solid = base.triangulate().extrude((0.0, 0.0, height), capping=True).triangulate().clean()
    return solid.compute_normals(auto_orient_normals=True)


def box(a, b, c):
    return prism([(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)], c)


def tetrahedron(corners):
    return pyvista.PolyData.from_regular_faces(np.array(corners), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@pytest.fixture
def coarse(monkeypatch):
    """A coarse grid, for tests of what does not depend on it."""
    monkeypatch.setattr("lmgcpy.scene.mesh_clump.POINTS", 2_000)


def fill(mesh, **options):
    return clump_from_mesh(mesh, density=2000.0, **options)


def centres(clump):
    """In the coordinates of the mesh."""
    return clump.centre + clump.axes.apply(clump.offsets)


L_SHAPE = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]
CORNERS = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.2, 0.3, 3.0)]


def solid_of(mesh):
    return mesh_solid(np.array(mesh.points, dtype=float), mesh.regular_faces)


def test_mass_of_a_box_and_of_a_turned_one():
    """abc, and abc (b^2 + c^2)/12 about x."""
    mesh = box(2.0, 3.0, 0.5)
    turn, shift = Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix(), np.array([10.0, -20.0, 5.0])
    inertia = 3.0 / 12.0 * np.diag([9.25, 4.25, 13.0])
    for q, origin in ((np.eye(3), np.zeros(3)), (turn, shift)):
        solid = mesh_solid(np.asarray(mesh.points, dtype=float) @ q.T + origin, mesh.regular_faces)
        assert solid.volume == pytest.approx(3.0, rel=1e-13)
        np.testing.assert_allclose(solid.centre, q @ [1.0, 1.5, 0.25] + origin, rtol=1e-13)
        np.testing.assert_allclose(solid.inertia, q @ inertia @ q.T, atol=1e-12)


def test_mass_of_a_tetrahedron_and_of_an_l():
    """A tetrahedron has the second moments V/20 (sum of x x^T of the corners + 16 m m^T) about the origin, m its centre.
    The L is two boxes."""
    corners = np.array(CORNERS)
    solid = solid_of(tetrahedron(CORNERS))
    m = corners.mean(axis=0)
    second = (corners.T @ corners + 16.0 * np.outer(m, m)) / 20.0 - np.outer(m, m)  # volume 1
    assert solid.volume == pytest.approx(1.0, rel=1e-13)
    np.testing.assert_allclose(solid.centre, m, rtol=1e-13)
    np.testing.assert_allclose(solid.inertia, np.trace(second) * np.eye(3) - second, atol=1e-13)
    solid = solid_of(prism(L_SHAPE, 0.5))
    low, high = np.array([1.0, 0.5, 0.25]), np.array([0.5, 2.0, 0.25])
    centre = 0.5 * (low + high)  # each has the volume 1
    np.testing.assert_allclose(solid.centre, centre, rtol=1e-13)
    inertia = np.diag([1 + 0.25, 4 + 0.25, 4 + 1]) / 12 + np.diag([4 + 0.25, 1 + 0.25, 1 + 4]) / 12
    for lever in (low - centre, high - centre):
        inertia += lever @ lever * np.eye(3) - np.outer(lever, lever)
    np.testing.assert_allclose(solid.inertia, inertia, atol=1e-13)


def test_mass_of_round_meshes_tends_to_that_of_the_ellipsoid():
    """Inscribed triangles leave errors of the square of their size: a quarter if it is halved."""
    errors = []
    for count in (15, 29, 57):
        mesh = pyvista.Sphere(radius=1.0, theta_resolution=count - 1, phi_resolution=count)
        solid = mesh_solid(np.asarray(mesh.points, dtype=float) * [1.0, 0.7, 0.4], mesh.regular_faces)
        volume = 4 / 3 * math.pi * 0.28
        inertia = volume / 5 * np.diag([0.65, 1.16, 1.49])
        errors.append([1.0 - solid.volume / volume, np.abs(solid.inertia - inertia).max() / inertia.max()])
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 4.0, atol=0.2)
    assert np.max(errors[-1]) < 0.01


@pytest.mark.default_parameters("L", "sphere")
@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        # the inscribed sphere exactly, if it is known; then bounds of what 5 and 20 spheres leave, measured and rounded up
        (box(1.0, 1.0, 1.0), (1 - math.pi / 6, 0.38, 0.21)),
        (box(2.0, 1.0, 1.0), (1 - math.pi / 12, 0.38, 0.24)),
        (prism(L_SHAPE, 0.5), (None, 0.85, 0.43)),
        (tetrahedron(CORNERS), (None, 0.67, 0.46)),
        (pyvista.Sphere(theta_resolution=16, phi_resolution=16), (None, 0.04, 0.04)),
        (pyvista.Sphere(theta_resolution=16, phi_resolution=16).scale([1.0, 0.7, 0.4]), (None, 0.45, 0.16)),
    ],
    ids=["cube", "box", "L", "tetrahedron", "sphere", "ellipsoid"],
)
def test_volume_falls_short_by_less_with_more_spheres(shape, expected):
    """All spheres lie within; each adds volume, and inertia comes nearer to the mesh's."""
    clump, solid = fill(shape, spheres=20), solid_of(shape)
    depth = -pyvista.PolyData(centres(clump)).compute_implicit_distance(shape)["implicit_distance"]
    np.testing.assert_allclose(depth, clump.radii, rtol=1e-6)  # some points are of single precision
    unions = [ball_union(centres(clump)[:k], clump.radii[:k]) for k in (1, 5, 20)]
    short = [1.0 - union.volume / solid.volume for union in unions]
    off = [np.linalg.norm(union.inertia - solid.inertia, 2) for union in unions]
    assert short == sorted(short, reverse=True)
    assert off == sorted(off, reverse=True)
    assert all(a < b for a, b in zip(short[1:], expected[1:], strict=True))
    if expected[0] is not None:
        assert short[0] == pytest.approx(expected[0], rel=1e-5)
    assert clump.volume_error == pytest.approx(-short[-1], rel=1e-9)
    assert clump.inertia_error == pytest.approx(off[-1] / np.linalg.norm(solid.inertia, 2), rel=1e-9)


def test_the_body_has_the_mass_of_the_mesh_or_of_the_spheres(coarse):
    """The spheres are in the same places; centre, mass and inertia are those of the one or of the other."""
    mesh = tetrahedron(CORNERS)
    given, own = fill(mesh, spheres=6), fill(mesh, spheres=6, mass_of="spheres")
    np.testing.assert_allclose(centres(own), centres(given), atol=1e-12)
    for clump, solid in ((given, solid_of(mesh)), (own, ball_union(centres(given), given.radii))):
        assert clump.mass == pytest.approx(2000.0 * solid.volume, rel=1e-9)
        np.testing.assert_allclose(clump.centre, solid.centre, atol=1e-9)
        q = clump.axes.as_matrix()
        np.testing.assert_allclose(q @ np.diag(clump.inertia) @ q.T, 2000.0 * solid.inertia, atol=1e-6)
    assert own.mass == pytest.approx(given.mass * (1.0 + given.volume_error), rel=1e-9)
    assert given.at((1.0, 2.0, 3.0), scale=0.01).mass == pytest.approx(2e-3, rel=1e-9)


def test_fewer_spheres_are_the_first_ones(coarse):
    mesh = tetrahedron(CORNERS)
    many, few = fill(mesh, spheres=12), fill(mesh, spheres=5)
    np.testing.assert_array_equal(few.radii, many.radii[:5])
    np.testing.assert_array_equal(few.offsets, many.offsets[:5])


def test_spheres_turn_move_and_grow_with_the_mesh(coarse):
    """The tetrahedron has no symmetry, so that no choice is a matter of rounding."""
    clump = fill(tetrahedron(CORNERS), spheres=8)
    turn = Rotation.from_rotvec([0.2, 0.3, -0.2]).as_matrix()
    other = fill(tetrahedron(0.01 * (np.array(CORNERS) @ turn.T + [3.0, 2.0, 1.0])), spheres=8)
    np.testing.assert_allclose(other.radii, 0.01 * clump.radii, rtol=1e-6)
    np.testing.assert_allclose(centres(other), 0.01 * (centres(clump) @ turn.T + [3.0, 2.0, 1.0]), atol=1e-8)
    assert other.volume_error == pytest.approx(clump.volume_error, rel=1e-5)


def test_a_file_with_points_that_occur_in_each_triangle(tmp_path, coarse):
    """STL keeps three points a triangle, in single precision."""
    path = tmp_path / "grain.stl"
    mesh = tetrahedron(CORNERS)
    mesh.save(path)
    read, given = fill(path, spheres=3), fill(mesh, spheres=3)
    np.testing.assert_allclose(read.radii, given.radii, rtol=1e-5)
    assert read.volume == pytest.approx(1.0, rel=1e-6)
    assert repr(read).startswith("<Clump of 3 spheres: mass 2000 kg, ")
    assert repr(read).endswith(", volume -76.6% and inertia 94.6% off the mesh's>")


def test_refused_meshes(tmp_path):
    cube = box(1.0, 1.0, 1.0)
    faces = cube.regular_faces.copy()

    def of(triangles, points=cube.points):
        return pyvista.PolyData.from_regular_faces(np.asarray(points), triangles)

    some = faces.copy()
    some[0] = some[0, ::-1]
    nowhere = np.array(cube.points)
    nowhere[0, 0] = math.nan
    for mesh, message in [
        (of(faces[1:]), r"The mesh is open: 3 of its 18 edges, one of them at \("),
        (of(faces[:, ::-1]), "is inside out"),
        (of(some), "has triangles that face inward beside others"),
        (of(np.vstack([faces[:1], faces[:1, ::-1]])), "is flat"),
        (box(1.0, 1.0, 1e-3), "is too thin: spheres inside have a radius of 0.0005 m at the most"),
        (of(faces, nowhere), "points that are not finite"),
        (pyvista.PolyData(), "has no triangles"),
    ]:
        with pytest.raises(ValueError, match=message):
            fill(mesh)
    with pytest.raises(TypeError, match=r"must be a surface, .* got 'UnstructuredGrid'; mesh.extract_surface\(\)"):
        fill(cube.cast_to_unstructured_grid())
    with pytest.raises(TypeError, match="spheres must be a whole number"):
        fill(cube, spheres=2.5)
    with pytest.raises(ValueError, match="density of a clump must be above 0 kg/m\\^3"):
        clump_from_mesh(cube, density=0.0)
    with pytest.raises(ValueError, match="mass_of cannot be 'sphere'; did you mean 'spheres'"):
        fill(cube, mass_of="sphere")
    with pytest.raises(FileNotFoundError, match=r"The mesh '.*grain.stl' does not exist"):
        fill(tmp_path / "grain.stl")
    (tmp_path / "words.xyz").write_text("no surface")
    with pytest.raises(OSError, match=r"words.xyz' cannot be read: .* Files of .stl, .ply, .obj and .vtp have surfaces."):
        fill(tmp_path / "words.xyz")
    (tmp_path / "words.stl").write_text("no surface")
    with pytest.raises(ValueError, match=r"words\.stl' has no triangles: it is empty, or VTK cannot read its file"):
        fill(tmp_path / "words.stl")


def test_without_pyvista_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match=r'pip install "lmgcpy\[view\]"'):
        fill("grain.stl")
