"""Surfaces in the detection: lists hold the pairs that touch; surfaces in measures and hints."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

G = 9.81


def sheet(n, side):
    """Corners and triangles of a sheet of n x n squares around the origin."""
    x, y = (along.ravel() * side for along in np.meshgrid(*[np.arange(n + 1) - 0.5 * n] * 2, indexing="ij"))
    at = [(n + 1) * i + j for i in range(n) for j in range(n)]
    triangles = [t for a in at for t in ((a, a + n + 1, a + n + 2), (a, a + n + 2, a + 1))]
    return np.column_stack([x, y, 0.0 * x]), np.array(triangles)


def world(ball, *walls, law=None):
    scene = lm.Scene(dimension=ball.dimension, gravity=(0.0,) * (ball.dimension - 1) + (-G,))
    scene.add(ball)
    for wall in walls:
        scene.add(wall)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3) if law is None else law)
    return scene


@pytest.mark.filterwarnings("ignore:In the step from")  # balls begin in the solid
@pytest.mark.parametrize("sides", ["both", "outside", "inside"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
def test_lists_hold_what_touches_while_a_mesh_turns_and_moves(sides, seed):
    """Balls of sizes 1 to 30 around a mesh that turns, with the lists of neighbours of a run and with lists made anew from
    all pairs: the same interactions in each of 40 steps."""
    from scipy.spatial import ConvexHull

    rng = np.random.default_rng(seed)
    points = rng.normal(size=(20, 3)) * (1.0, 0.6, 0.3)
    hull = ConvexHull(points)
    triangles = np.array(
        [t if np.linalg.det(points[t] - points.mean(axis=0)) > 0.0 else t[::-1] for t in hull.simplices]
    )
    scene = lm.Scene(dimension=3)
    radius = 10.0 ** rng.uniform(-2.0, -0.5, 200)
    scene.add_spheres(radius, rng.uniform(-1.5, 1.5, (200, 3)), masses=1.0, velocities=rng.normal(size=(200, 3)))
    used, cells = np.unique(triangles, return_inverse=True)
    mesh = lm.mesh(points[used], cells.reshape(-1, 3), sides=sides, rotation=(0, 0, 0, 1))
    scene.add(mesh).impose_velocity(spin_x=3.0, spin_y=1.0, x=1.0)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=5e-4, overlap="ignore")
    fresh = sim._detector.grown(
        (sim.model.contactors, sim.model.rows, []),
        sim.model.inverse_mass,
        sim.model.hidden,
        sim.model.apart,
        sim.state.positions,
    )
    rebuilds = 0
    for _ in range(40):
        sim.step()
        listed = sim._detector.detect(sim.state.positions, 0.002)
        mine = sorted(zip(listed.candidate, listed.antagonist, listed.gap.tolist(), strict=True))
        fresh._listed_at = None
        again = fresh.detect(sim.state.positions, 0.002)
        assert mine == sorted(zip(again.candidate, again.antagonist, again.gap.tolist(), strict=True))
        rebuilds += 1
    assert sim._detector.rebuilds < 0.8 * rebuilds
    assert len(mine) > 10


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_stress_is_what_a_wall_without_ends_gives(dimension):
    """The branch vector ends at the contact point, as at a wall."""
    d = dimension
    make = lm.disk if d == 2 else lm.sphere
    stresses = []
    endless = lm.wall(point=(0.0,) * d, normal=(0.0,) * (d - 1) + (1.0,))
    for wall in (endless, lm.wall_segment((-1.0, 0.0), (1.0, 0.0)) if d == 2 else lm.mesh(*sheet(2, 1.0))):
        ball = make(radius=0.1, position=(0.03,) + (0.01,) * (d - 2) + (0.1,), mass=1.0)
        sim = lm.Simulation(world(ball, wall), time_step=1e-3).run(steps=5)
        stresses.append(lm.measure.stress(sim, volume=1.0)["total"])
    assert stresses[1] == pytest.approx(stresses[0], rel=1e-9)
    assert stresses[0][-1, -1] == pytest.approx(-0.1 * G)


def test_measures_leave_out_walls_that_turn():
    """A plate that turns has no inertia, and is no body of the sample."""
    ball = lm.capsule(radius=0.1, length=0.2, position=(0.0, 0.0, 0.2), mass=1.0, spin=(1.0, 0.0, 0.0))
    sim = lm.Simulation(world(ball, lm.mesh(*sheet(2, 1.0)).impose_velocity(spin_z=1.0)), time_step=1e-3).run(steps=2)
    assert np.isfinite(lm.measure.angular_momentum(sim)).all()
    assert lm.measure.long_axes(sim).body.tolist() == [0]


def test_a_ball_in_a_solid_is_found_at_the_start():
    ball = lm.disk(radius=0.1, position=(0.5, 0.95), mass=1.0)
    block = lm.wall_segment((0, 0), (1, 0), (1, 1), (0, 1), closed=True, sides="outside")
    with pytest.raises(ValueError, match="1 pair of bodies overlaps at the start"):
        lm.Simulation(world(ball, block), time_step=1e-3, overlap="stop")


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_a_surface_in_other_units_is_named(scale):
    ball = lm.sphere(radius=0.01, position=(0.0, 0.0, 10.0), mass=1.0)
    scene = world(ball, lm.mesh(sheet(2, 1.0)[0] * scale, sheet(2, 1.0)[1]))
    if scale == 1.0:
        lm.Simulation(scene, time_step=1e-3)
        return
    with pytest.warns(RuntimeWarning, match=r"body 1 \('WALL'\) reaches .* scale="):
        lm.Simulation(scene, time_step=1e-3)


def test_a_large_floor_makes_neighbours_of_what_lies_on_it():
    """A column of 400 balls on two large triangles: pairs with the lowest alone."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    places = [(0.3, 0.2, 0.05 + 0.1 * k) for k in range(400)]
    scene.add_spheres(0.05, places, masses=1.0)
    scene.add(lm.plate([(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)]))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-4).run(steps=1)
    assert sum(len(group.pairs) for group in sim._detector.groups) <= 2
