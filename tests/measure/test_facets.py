"""Forces on facets: weights on plates, depths of columns, edges and corners, turning drums, membranes, run files."""

import math

import numpy as np
import pytest

import lmgcpy as lm

G = 10.0


def grid(count, size=1.0):
    """Points and triangles of a square of count^2 squares, from (0, 0, 0), all normals up."""
    side = np.linspace(0.0, size, count + 1)
    points = np.array([(x, y, 0.0) for x in side for y in side])
    k = np.array([i * (count + 1) + j for i in range(count) for j in range(count)])
    one = np.column_stack([k, k + count + 1, k + count + 2])
    return points, np.stack([one, np.column_stack([k, k + count + 2, k + 1])], axis=1).reshape(-1, 3)


def test_the_weight_of_a_heap_is_the_sum_over_the_facets_of_its_floor(tmp_path):
    """Balls that roll on a wavy mesh between walls without friction: the sum is the force on the body, and their weight and
    what their vertical momentum gains in the step, to round-off. The file has the same forces, facet by facet."""
    points, triangles = grid(6)
    points[:, 2] = 0.05 * np.sin(7.0 * points[:, 0]) * np.cos(9.0 * points[:, 1])
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    floor = scene.add(lm.mesh(points, triangles, radius=0.01))
    for at, normal in (((0, 0, 0), (1, 0, 0)), ((1, 0, 0), (-1, 0, 0)), ((0, 0, 0), (0, 1, 0)), ((0, 1, 0), (0, -1, 0))):
        scene.add(lm.wall(point=at, normal=normal, color="SIDE"))
    places = [(x, y, z) for z in (0.2, 0.4) for x in (0.2, 0.5, 0.8) for y in (0.23, 0.5, 0.77)]
    scene.add_spheres(0.09, places, masses=1.0)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
    scene.see("GRAIN", "SIDE", lm.Signorini())
    path = tmp_path / "heap.h5"
    sim = lm.Simulation(scene, time_step=2e-3, solver=lm.Auto(tolerance=1e-6))
    sim.run(steps=100, record=path, every=20)
    before = sim.velocities[:, 2].copy()
    with lm.io.open_run(path) as run:
        for frame in range(1, run.frame_count):
            found, net = lm.measure.facets(run, frame=frame), run.interactions(frame)
            force = np.einsum("mk,mkd->md", net.force, net.frame)
            expected = force[net.candidate == floor.id].sum(axis=0) - force[net.antagonist == floor.id].sum(axis=0)
            assert found.force.sum(axis=0) == pytest.approx(expected, abs=1e-9)
        last = lm.measure.facets(run)
    found = lm.measure.facets(sim)
    for name, column in found.columns().items():
        assert last.columns()[name] == pytest.approx(column, abs=1e-9), name
    sim.step()
    gained = (sim.velocities[:, 2] - before)[5:].sum() / 2e-3
    assert lm.measure.facets(sim).force[:, 2].sum() == pytest.approx(-18.0 * G - gained, rel=1e-9)
    assert 6 < (found.pressure > 0.0).sum() < 50
    assert found.traction == pytest.approx(found.force / found.area[:, None])
    assert found.facet.tolist() == list(range(72))
    assert found.position == pytest.approx(points[triangles].mean(axis=1))


def test_pressure_is_proportional_to_the_depth_of_columns():
    """Columns of k balls, k from 1 to 4, each on facets of its own: k m g on their area, hydrostatic step by step."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    points, triangles = grid(4, 4.0)
    plate = scene.add(lm.mesh(points, triangles))
    for i in range(4):
        for k in range(i + 1):
            scene.add(lm.sphere(radius=0.2, position=(i + 0.7, 1.3, 0.2 + 0.4 * k), mass=0.1)).fix("x", "y")
    scene.see("GRAIN", "WALL", lm.Signorini())
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    found = lm.measure.facets(lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9)).run(steps=5))
    assert (found.body == plate.id).all()
    assert found.area == pytest.approx(np.full(32, 0.5))
    loaded = found.pressure > 0.0
    assert np.argwhere(loaded).ravel().tolist() == [2, 10, 18, 26]
    assert found.pressure[loaded] == pytest.approx(np.arange(1, 5) * 0.1 * G / 0.5, rel=1e-6)


def test_a_force_at_an_edge_is_shared_by_two_facets_and_at_a_corner_by_all():
    """A roof of two squares: a ball on its ridge gives half to each side, as does a flat edge; the middle of a pyramid of
    six triangles is shared by six."""
    scene = lm.Scene(dimension=3)
    roof = scene.add(lm.mesh([(0, 0, 0), (1, 0, 0), (0, 1, -1), (0, -1, -1)], [(0, 1, 2), (1, 0, 3)]))
    ball = scene.add(lm.sphere(radius=0.1, position=(0.4, 0.0, 0.1), mass=1.0)).impose_force(z=-3.0)
    ball.fix("x", "y")
    angle = np.pi / 3.0 * np.arange(6)
    rim = np.column_stack([5.0 + np.cos(angle), np.sin(angle), np.full(6, -0.5)])
    fan = [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)]
    pyramid = scene.add(lm.mesh(np.vstack([[5.0, 0.0, 0.0], rim]), fan))
    scene.add(lm.sphere(radius=0.1, position=(5.0, 0.0, 0.1), mass=1.0)).impose_force(z=-6.0).fix("x", "y")
    scene.see("GRAIN", "WALL", lm.Signorini())
    found = lm.measure.facets(lm.Simulation(scene, time_step=1e-3).run(steps=2))
    on_roof, on_pyramid = found.body == roof.id, found.body == pyramid.id
    assert found.force[on_roof, 2] == pytest.approx([-1.5, -1.5])
    assert found.force[on_pyramid, 2] == pytest.approx(np.full(6, -1.0))
    assert found.surface.tolist() == [0, 0, *[1] * 6]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_sign_of_the_pressure_says_from_which_side_a_wall_is_pressed(way):
    """In the plane, of a metre of depth, normals to the left of the segments."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.wall_segment((0.0, 0.0), (1.0, 0.0), (3.0, 0.0), radius=0.05))
    scene.add(lm.disk(radius=0.1, position=(1.6, 0.15 * way), mass=1.0)).impose_force(y=-3.0 * way)
    scene.see("GRAIN", "WALL", lm.Signorini())
    found = lm.measure.facets(lm.Simulation(scene, time_step=1e-3).run(steps=2))
    assert found.area.tolist() == [1.0, 2.0]
    assert found.normal == pytest.approx(np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert found.pressure == pytest.approx([0.0, 1.5 * way])


@pytest.mark.default_parameters("2-40.0", "3-40.0")
@pytest.mark.parametrize("spin", [0.0, 40.0])
@pytest.mark.parametrize("d", [2, 3])
def test_a_drum_that_turns_takes_forces_to_the_facet_that_was_met(d, spin, tmp_path):
    """A ball is pressed onto the ridge of a wheel with four corners that turns by a degree in a step: half of the force on
    each facet beside the ridge in the step in which the ridge is under the ball, as the contact was found there."""
    h, theta = 1e-3, 0.5
    start = -spin * h * (1.0 - theta)  # the detection of the first step sees it upright
    angle = start + 0.5 * np.pi * np.arange(4) + 0.5 * np.pi
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    scene = lm.Scene(dimension=d)
    if d == 2:
        wheel = lm.wall_segment(*ring, closed=True, centre=(0.0, 0.0))
    else:
        k, j = np.arange(4), (np.arange(4) + 1) % 4
        points = np.concatenate([np.insert(ring, 1, y, axis=1) for y in (-1.0, 1.0)])
        wheel = lm.mesh(points, [*zip(k, j, j + 4, strict=True), *zip(k, j + 4, k + 4, strict=True)], centre=(0, 0, 0))
    scene.add(wheel).impose_velocity(**({"spin": spin} if d == 2 else {"spin_y": -spin}))
    at = np.zeros(d)
    at[-1] = 1.1
    ball = (lm.disk if d == 2 else lm.sphere)(radius=0.1, position=at, mass=1.0)
    scene.add(ball).impose_force(**{"xyz"[d - 1]: -8.0}).fix("x")
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=h).run(steps=1, record=tmp_path / "wheel.h5")
    with lm.io.open_run(tmp_path / "wheel.h5") as run:
        for source in (sim, run):
            found = lm.measure.facets(source)
            assert found.force.sum(axis=0)[-1] == pytest.approx(-8.0, rel=0.1)
            loaded = found.force[found.force[:, -1] < 0.0, -1]
            assert loaded == pytest.approx(np.full(2, 0.5 * loaded.sum()))
            turned = found.position[0] if d == 2 else found.position[[0, 4]].mean(axis=0)
            away = start + spin * h + 0.75 * np.pi
            assert math.atan2(turned[-1], turned[0]) == pytest.approx(away, abs=1e-6)


@pytest.mark.parametrize("periodic", [False, True])
def test_forces_on_a_membrane_of_bodies(periodic):
    """A held membrane bears the forces of balls that lie on it; in a periodic cell it goes on across the faces, and a ball
    lies there."""
    scene, (points, triangles) = lm.Scene(dimension=3), grid(4)
    if periodic:
        scene.periodic(x=1.0, y=1.0)
        inner = [k for k in range(25) if k // 5 < 4 and k % 5 < 4]
        same = {k: inner.index((k // 5) % 4 * 5 + (k % 5) % 4) for k in range(25)}
        points, triangles = points[inner], np.array([[same[k] for k in cell] for cell in triangles.tolist()])
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)).fix() for place in points]
    scene.membrane(nodes, triangles, lm.ElasticWire(stiffness=1.0), radius=0.02, color="WALL")
    places = np.array([(0.4, 0.3), (0.9, 0.8), (0.15, 0.6)])
    for x, y in places:
        scene.add(lm.sphere(radius=0.05, position=(x, y, 0.07), mass=1.0)).impose_force(z=-2.0).fix("x", "y")
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    found = lm.measure.facets(lm.Simulation(scene, time_step=1e-3).run(steps=3))
    assert (found.body == -1).all()
    assert len(found) == 32
    assert found.force.sum(axis=0) == pytest.approx([0.0, 0.0, -6.0], abs=1e-6)
    loaded = np.flatnonzero(found.pressure > 0.0)
    assert len(loaded) == 3
    assert found.pressure[loaded] == pytest.approx(np.full(3, 2.0 * 32.0))
    middle = found.position[loaded][:, :2] % 1.0 if periodic else found.position[loaded][:, :2]
    apart = np.linalg.norm(middle[:, None] - places[None], axis=2)
    assert apart.min(axis=0).max() < 0.15


def test_of_a_node_with_a_shape_the_shape_is_not_the_membrane():
    """In the plane: nodes are disks thicker than the thread. A disk on the thread is on its facet, one on a node is not."""
    scene = lm.Scene(dimension=2)
    nodes = [scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, color="NODE")).fix() for x in (0.0, 1.0, 2.0)]
    scene.chain(nodes, lm.ElasticWire(stiffness=1.0), surface=lm.Thread(0.05))
    for x, y in ((0.5, 0.15), (1.0, 0.2)):
        scene.add(lm.disk(radius=0.1, position=(x, y), mass=1.0)).impose_force(y=-1.0)
    scene.see("GRAIN", "THREAD", lm.Signorini())
    scene.see("GRAIN", "NODE", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=2)
    assert (lm.measure.contact_forces(sim).normal > 0.5).sum() == 2
    assert lm.measure.facets(sim).pressure == pytest.approx([1.0, 0.0])


def test_scenes_without_facets_and_steps_have_none():
    assert len(lm.measure.facets(lm.Simulation(lm.Scene(dimension=3), time_step=1e-3))) == 0
    scene = lm.Scene(dimension=3)
    scene.add(lm.plate([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]))
    found = lm.measure.facets(lm.Simulation(scene, time_step=1e-3))
    assert found.pressure.tolist() == [0.0, 0.0]
