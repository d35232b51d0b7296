"""Clumps and capsules in pictures, checks and files for ParaView: each part where its body has turned it to."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from seen import like, pixels
from test_vtk import arrays, read

import lmgcpy as lm
from lmgcpy.contact.segments import segment_distances
from lmgcpy.view.compose import compose
from lmgcpy.view.snapshot import acting_lines, snapshot
from lmgcpy.view.style import OPTIONS, style_of

OFFSETS = np.array([(0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1)])
RADII = np.array([0.2, 0.15, 0.12, 0.15])
TURN = Rotation.from_euler("zyx", [0.4, -0.9, 2.0])
AXIS = np.array([2.0, -1.0, 2.0]) / 3.0


def clump_and_capsule(cell=False):
    """A clump at (1, 0, 0) that was turned as it was given, and a capsule at the origin."""
    scene = lm.Scene(dimension=3)
    if cell:
        scene.periodic(x=4.0, y=4.0, z=4.0)
    shape = lm.clump(RADII, OFFSETS, density=1000.0)
    scene.add(shape.at((1.0, 0.0, 0.0), rotation=TURN, spin=(1.0, 2.0, 3.0), color="CLUMP"))
    scene.add(lm.capsule(radius=0.1, length=0.6, position=(0.0, 0.0, 0.0), axis=AXIS, mass=1.0, velocity=(0.0, 0.0, 2.0)))
    return scene, np.array([1.0, 0.0, 0.0]) + TURN.apply(OFFSETS - shape.centre)


def drawing(source, **options):
    return compose(snapshot(source), style_of({**dict.fromkeys(OPTIONS), **options}, dimension=3, is_scene=False))


def test_a_clump_is_its_spheres_and_a_capsule_a_tube_between_two():
    scene, centres = clump_and_capsule()
    found = drawing(scene, grains="plain")
    (balls,), (tubes,) = found.balls, found.tubes
    np.testing.assert_allclose(balls.centres[:4], centres, atol=1e-14)
    np.testing.assert_allclose(balls.centres[4:], [0.3 * AXIS, -0.3 * AXIS], atol=1e-14)
    assert balls.radii.tolist() == [*RADII, 0.1, 0.1]
    np.testing.assert_allclose([tubes.starts[0], tubes.ends[0]], [-0.3 * AXIS, 0.3 * AXIS], atol=1e-14)
    assert tubes.radii.tolist() == [0.1]


@pytest.mark.parametrize(
    ("grains", "of_clump", "of_capsule"), [("speed", 0.0, 2.0), ("spin", math.sqrt(14.0), 0.0), ("radius", None, 0.4)]
)
def test_all_parts_of_a_body_have_its_colour(grains, of_clump, of_capsule):
    scene, _ = clump_and_capsule()
    found = drawing(scene, grains=grains)
    values = found.balls[0].paint.values
    if of_clump is not None:
        assert values[:4] == pytest.approx(of_clump)
    assert len(set(values[:4])) == 1
    assert values[4:] == pytest.approx(of_capsule)
    assert found.tubes[0].paint.values == pytest.approx(of_capsule)


def test_a_picture_of_a_capsule_has_its_area(tmp_path):
    """From the side 2 r l + pi r^2; the scale is that of its length."""
    scene = lm.Scene(dimension=3)
    scene.add(lm.capsule(radius=0.1, length=0.6, position=(0, 0, 0), axis=(1, 0, 0), mass=1.0))
    lm.view.render(scene, tmp_path / "a.png", camera="y", size=(300, 150), title="")
    filled = ~like(pixels(tmp_path / "a.png"), "#ffffff", 12)
    scale = np.ptp(np.flatnonzero(filled.any(axis=0))) / 0.8
    assert scale > 200.0
    assert filled.sum() / scale**2 == pytest.approx(0.2 * 0.6 + math.pi * 0.01, rel=0.03)  # half a pixel at the edges


def test_the_outline_of_a_shape_of_a_plug_in_turns_in_space():
    class Arrow(lm.Contactor):
        KIND, shape, bounding_radius, area, second_moment = "test-arrow", (1.0,), 1.0, 0.0, 0.0
        outline = (np.array([(0.0, 0.0, 0.0), (0.6, 0.0, 0.8)]),)

    scene = lm.Scene(dimension=3)
    start = {"position": (1.0, 2.0, 3.0), "rotation": TURN}
    scene.add(lm.RigidBody([(Arrow(), (0.0, 0.5, 0.0))], mass=1.0, inertia=(1.0, 2.0, 3.0), color="GRAIN", **start))
    ((_, line),) = snapshot(scene).outlines
    np.testing.assert_allclose(line, np.add((1.0, 2.0, 3.0), TURN.apply([(0.0, 0.5, 0.0), (0.6, 0.5, 0.8)])), atol=1e-14)


def test_a_cell_and_a_clip_take_bodies_whole():
    scene, centres = clump_and_capsule(cell=True)
    found = drawing(scene, grains="plain")
    # the capsule at the corner of the cell sticks out on all sides
    np.testing.assert_allclose(found.balls[0].centres[4:], [0.3 * AXIS, -0.3 * AXIS], atol=1e-14)
    low, high = centres[:, 0].min(), centres[:, 0].max()
    assert low < 1.0 < high
    for at, count in ((0.9, 2), (1.1, 6)):  # looking along y, what is on the positive side is left out
        assert len(drawing(scene, grains="plain", clip=("x", at), camera="y").balls[0].radii) == count


def test_a_section_through_a_capsule_is_an_ellipse():
    """A plane across the axis at an angle cuts a cylinder in an ellipse of the area pi r^2 / cos(angle)."""
    scene = lm.Scene(dimension=3)
    angle, r = 1.0, 0.1
    axis = (math.sin(angle), 0.0, math.cos(angle))
    scene.add(lm.capsule(radius=r, length=2.0, position=(0, 0, 0), axis=axis, mass=1.0))
    found = drawing(scene, grains="plain", section=("z", 0.0))
    assert not any(len(tube.radii) for tube in found.tubes)
    centres, radii = (np.concatenate([getattr(balls, name) for balls in found.balls]) for name in ("centres", "radii"))
    grid = np.linspace(-0.3, 0.3, 601)
    points = np.stack(np.meshgrid(grid, grid, [0.0], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    inside = [(np.linalg.norm(part - centres, axis=2) < radii).any(axis=1).sum() for part in np.array_split(points, 50)]
    assert sum(inside) * 1e-6 == pytest.approx(math.pi * r**2 / math.cos(angle), rel=0.02)


def pressed(*bodies):
    """Bodies of two colours, each pressed against the next along its imposed force, after a step."""
    scene = lm.Scene(dimension=3)
    for body in bodies:
        scene.add(body)
    scene.see("GRAIN", "OTHER", lm.Coulomb(friction=0.3), alert=0.01)
    return lm.Simulation(scene, time_step=1e-3).run(steps=1)


def test_a_line_goes_to_the_sphere_or_to_the_axis_that_touches():
    """Above the middle of a rod, above its end, and above one sphere of a clump of two."""
    for x, axis_at in ((0.1, 0.1), (0.3, 0.3)):
        rod = lm.capsule(radius=0.1, length=0.6, position=(0, 0, 0), axis=(1, 0, 0), mass=1.0, color="OTHER").fix()
        ball = lm.sphere(radius=0.1, position=(x, 0.0, 0.2), mass=1.0).impose_force(z=-1.0)
        (start,), (end,) = acting_lines(snapshot(pressed(ball, rod)))
        np.testing.assert_allclose([start, end], [(axis_at, 0, 0), (x, 0, 0.2)], atol=1e-6)  # a step's motion
    pair = lm.clump([0.1, 0.1], [(-0.05, 0, 0), (0.05, 0, 0)], density=1.0)
    clump = pair.at((0, 0, 0), rotation=Rotation.from_euler("z", 90, degrees=True), color="OTHER").fix()
    ball = lm.sphere(radius=0.1, position=(0.0, 0.05, 0.2), mass=1.0).impose_force(z=-1.0)
    (start,), (end,) = acting_lines(snapshot(pressed(ball, clump)))
    np.testing.assert_allclose([start, end], [(0, 0.05, 0), (0, 0.05, 0.2)], atol=1e-6)


def test_distances_of_segments():
    """Against minimisation, parallel and crossed ones and points among them."""
    random = np.random.default_rng(0)
    a, b, half_a, half_b = random.normal(size=(4, 15, 3))
    half_b[:5] = half_a[:5] * random.uniform(0.3, 2.0, 5)[:, None]
    half_a[5:8] = 0.0
    found = segment_distances(a, half_a, b, half_b)
    for k, distance in enumerate(found):

        def square(at, k=k):
            return float(((a[k] + at[0] * half_a[k] - b[k] - at[1] * half_b[k]) ** 2).sum())

        starts = itertools.product((-1.0, 0.0, 1.0), repeat=2)
        least = min(minimize(square, start, bounds=[(-1, 1)] * 2, tol=1e-14).fun for start in starts)
        assert distance == pytest.approx(math.sqrt(least), abs=1e-6)  # of the minimisation


@pytest.mark.parametrize("apart", [0.199, 0.19])
def test_a_check_finds_crossed_capsules_and_no_others(apart):
    """Axes that cross 0.19 apart: an overlap of 0.01, a tenth of the radius. The spheres that hold them overlap far."""
    scene = lm.Scene(dimension=3)
    for z, axis in ((0.0, (1, 0, 0)), (apart, (0, 1, 0)), (apart + 0.3, (1, 1, 0))):
        scene.add(lm.capsule(radius=0.1, length=1.0, position=(0, 0, z), axis=axis, mass=1.0))
    found = lm.view.check(scene, overlap=0.05).overlaps
    expected = [(1, 0, 0.01, 0.1)] if apart < 0.195 else []
    assert [row.tolist() for row in found] == [pytest.approx(row, rel=1e-9) for row in expected]


def test_files_for_paraview(tmp_path):
    """A sphere a point, a rod a line, and the orientation as VTK reads quaternions, by its own class."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonMath import vtkQuaternion

    scene, centres = clump_and_capsule()
    scene.add(lm.sphere(radius=0.1, position=(3.0, 0.0, 0.0), mass=1.0))
    lm.Simulation(scene, time_step=1e-3).run(steps=10, record=tmp_path / "a.h5", every=10)
    with lm.io.open_run(tmp_path / "a.h5") as run:
        series = lm.view.export_vtk(run, tmp_path / "vtk")
        turns, spins = Rotation.from_quat(run.rotations[-1]), run.spins[-1]
    assert [path.stem for path in series] == ["bodies", "forces", "wires", "walls", "rods", "turning"]
    points = vtk_to_numpy(read(tmp_path / "vtk" / "bodies-00000.vtp").GetPoints().GetData())
    np.testing.assert_allclose(points[:4], centres, atol=1e-14)
    rods, turning = (read(tmp_path / "vtk" / f"{part}-00001.vtp") for part in ("rods", "turning"))
    way = np.add(turns[1].apply((0.0, 0.0, 0.3)), (0.0, 0.0, 0.02))
    np.testing.assert_allclose(vtk_to_numpy(rods.GetPoints().GetData())[1], way, atol=1e-12)
    assert arrays(rods.GetPointData())["radius"].tolist() == [0.1, 0.1]
    assert arrays(rods.GetCellData())["body"].tolist() == [1]
    found = arrays(turning.GetPointData())
    assert found["body"].tolist() == [0, 1]
    np.testing.assert_array_equal(found["spin"], spins[:2])
    for given, turn in zip(found["orientation"], turns, strict=False):
        matrix = [[0.0] * 3 for _ in range(3)]
        vtkQuaternion["float64"](*given).ToMatrix3x3(matrix)
        np.testing.assert_allclose(matrix, turn.as_matrix(), atol=1e-14)
