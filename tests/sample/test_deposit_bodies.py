"""Deposits of clumps, capsules and spheres: at rest in the box, on each other, from a seed."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.sample import deposit_bodies
from lmgcpy.scene.body_3d import body_volume, placed

BOX = (0.05, 0.06, None)
TETRAPOD = lm.clump([6e-3] * 4, 4e-3 * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]), density=2650.0)
STONE = lm.Material("stone", 2650.0)


def given():
    clumps = [TETRAPOD.at((0, 0, 0), scale=s, color="TETRAPOD") for s in (0.8, 1.0, 1.2) * 2]
    fibres = [lm.capsule(radius=2e-3, length=0.015, position=(0, 0, 0), material=STONE) for _ in range(2)]
    return [*clumps, *fibres, lm.sphere(radius=5e-3, position=(1, 1, 1), material=STONE)]


@pytest.fixture(scope="module")
def laid():
    return deposit_bodies(given(), box=BOX, seed=2)


def as_scene(bodies, friction=0.3):
    """The bodies in their box under gravity."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, -9.81))
    for body in bodies:
        scene.add(placed(body, body.position.copy())).color = "GRAIN"
    for axis in range(3):
        scene.add(lm.wall(point=(0, 0, 0), normal=np.eye(3)[axis]))
        if axis < 2:
            scene.add(lm.wall(point=BOX[axis] * np.eye(3)[axis], normal=-np.eye(3)[axis]))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return scene


def test_bodies_are_those_given_in_new_places(laid):
    for body, before in zip(laid, given(), strict=True):
        assert type(body) is type(before)
        assert (body.color, body.mass, body.id) == (before.color, before.mass, -1)
        np.testing.assert_array_equal(body.inertia, before.inertia)
        assert body_volume(body) == body_volume(before)
        assert not body.velocity.any()


def test_they_bear_their_weight_where_they_lie(laid):
    """Released there, without the drag of the fall, they stay: over 0.05 s, in which a free body falls by 12 mm, none moves
    by a tenth of the finest radius, the floor bears the weight to 2 %, and nothing is in anything."""
    sim = lm.Simulation(as_scene(laid), time_step=5e-4, solver=lm.AcceleratedGaussSeidel(tolerance=1e-4))
    before, pushed, count = sim.positions.copy(), 0.0, len(laid)
    for _ in range(100):
        sim.step()
        net = sim.interactions
        down = net.antagonist >= count
        pushed += np.einsum("mk,mk->", net.impulse[down], net.frame[down, :, 2])
    weight = 9.81 * sum(body.mass for body in laid)
    assert np.abs(sim.positions - before).max() < 2e-4
    assert pushed / sim.time == pytest.approx(weight, rel=0.02)
    assert sim.interactions.gap.min() > -0.05 * 2e-3


@pytest.mark.long
def test_less_friction_makes_a_denser_deposit(laid):
    def centre(bodies):
        mass = [body.mass for body in bodies]
        return np.average([body.position[2] for body in bodies], weights=mass)

    assert centre(deposit_bodies(given(), box=BOX, friction=0.0, seed=2)) < centre(laid)


def test_seeds():
    def places(seed):
        return [body.position for body in deposit_bodies([TETRAPOD.at((0, 0, 0))] * 2, box=(0.03, 0.03, None), seed=seed)]

    first, same, other = places(2), places(2), places(3)
    np.testing.assert_array_equal(first, same)
    assert not np.array_equal(first, other)


def test_a_low_lid_is_refused():
    with pytest.raises(ValueError, match=r"rest up to 0\.0\d+ m, above the top of the box at 0\.005 m"):
        deposit_bodies([TETRAPOD.at((0, 0, 0))], box=(0.05, 0.05, 0.005))


def test_volumes_are_those_of_the_measure(laid):
    """``body_volume`` of a body and ``particle_stress(...).volume`` of a scene read the same shapes in two ways."""
    sim = lm.Simulation(as_scene(laid), time_step=1e-6).run(steps=1)
    volumes = [body_volume(body) for body in laid]
    np.testing.assert_allclose(lm.measure.particle_stress(sim).volume, volumes, rtol=1e-9)


def test_a_twin_of_a_body_in_a_simulation_stands_where_it_is_now():
    scene = lm.Scene(dimension=3)
    body = scene.add(TETRAPOD.at((0, 0, 0), spin=(0, 0, 3.0), velocity=(1, 0, 0)))
    lm.Simulation(scene, time_step=0.01).run(steps=10)
    twin = placed(body, body.position + 1.0)
    np.testing.assert_allclose(twin.position, [1.1, 1.0, 1.0])
    np.testing.assert_allclose(twin.rotation.as_matrix(), body.rotation.as_matrix(), atol=1e-14)
    assert twin.id == -1
    assert not twin.velocity.any()
    assert not twin.spin.any()
    assert body.velocity[0] == 1.0
