"""Reactions against the balance of momentum, statics, and themselves: of one body and of many, in runs and in cells."""

import itertools

import numpy as np
import pytest

import lmgcpy as lm

GRAVITY, STEP = 10.0, 1e-3


def heap(dimension, law):
    """Bodies that fall into a box with a rod of two balls and a chain tied to its end, and a ball that rolls."""
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=-GRAVITY * up)
    ball = lm.disk if dimension == 2 else lm.sphere
    rng = np.random.default_rng(3)
    for place in itertools.product((0.15, 0.37, 0.59), repeat=dimension):
        scene.add(ball(radius=0.1, mass=1.0, position=np.array(place) + 0.01 * rng.random(dimension)))
    scene.bodies[0].impose_force(x=3.0)
    scene.add(lm.wall(point=np.zeros(dimension), normal=up))
    for k in range(dimension - 1):
        scene.add(lm.wall(point=np.zeros(dimension), normal=np.eye(dimension)[k]))
        scene.add(lm.wall(point=0.75 * np.eye(dimension)[k], normal=-np.eye(dimension)[k]))
    scene.link(scene.bodies[0], scene.bodies[1], lm.ElasticWire(stiffness=1e4))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, law)
    return scene


@pytest.mark.parametrize("law", [lm.Coulomb(friction=0.4), lm.RollingCoulomb(friction=0.4, rolling_friction=0.1)], ids=repr)
@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_move_as_weight_and_reactions_say(dimension, law):
    """m dv = h (m g + F + R) and I d omega = h M about the centre, in a step with contacts, links, friction and rolling."""
    scene = heap(dimension, law)
    sim = lm.Simulation(scene, time_step=STEP, solver=lm.Auto(tolerance=1e-6)).run(steps=200)
    before = sim.velocities_in_space.copy()
    sim.step()
    given = (sim.velocities_in_space - before) / STEP
    grains = [body for body in scene.bodies if body.color == "GRAIN"]
    scale = 10.0 * max(np.abs(body.reaction.force).max() for body in grains)
    assert scale > 100.0
    for body in grains:
        found = body.reaction
        force = given[body.id, :dimension] * body.mass + body.mass * GRAVITY * np.eye(dimension)[-1]
        force[0] -= 3.0 * (body.id == 0)
        inertia = (0.5 if dimension == 2 else 0.4) * body.mass * 0.1**2
        np.testing.assert_allclose(found.force, force, atol=1e-9 * scale)
        np.testing.assert_allclose(found.moment, inertia * given[body.id, dimension:], atol=1e-9 * scale)


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_between_the_bodies_of_a_set_cancel(dimension):
    """The set bears the sum of its bodies, about one point; laws add up; a colour and a list of ids name the same."""
    scene = heap(dimension, lm.RollingCoulomb(friction=0.4, rolling_friction=0.1))
    sim = lm.Simulation(scene, time_step=STEP).run(steps=200)
    about = 0.3 * np.ones(dimension)
    grains = [body for body in scene.bodies if body.color == "GRAIN"]
    together = lm.measure.reaction(sim, grains, about=about)
    each = [lm.measure.reaction(sim, body, about=about) for body in grains]
    walls = lm.measure.reaction(sim, "WALL", about=about)
    for sum_of in (lambda of: sum(of(one) for one in each), lambda of: -of(walls)):
        np.testing.assert_allclose(together.force, sum_of(lambda one: one.force), atol=1e-8)
        np.testing.assert_allclose(together.moment, sum_of(lambda one: one.moment), atol=1e-8)
    by_law = [sum(parts) for parts in zip(*walls.by_law.values(), strict=True)]
    np.testing.assert_allclose(by_law[0], walls.force, atol=1e-9)
    np.testing.assert_allclose(by_law[1], walls.moment, atol=1e-9)
    assert set(walls.by_law) == {"elastic-wire", "rolling-coulomb"}
    same = lm.measure.reaction(sim, [body.id for body in scene.bodies if body.color == "WALL"], about=about)
    np.testing.assert_array_equal(same.moment, walls.moment)


def test_a_run_tells_what_the_simulation_told(tmp_path):
    scene = heap(2, lm.Coulomb(friction=0.4))
    sim = lm.Simulation(scene, time_step=STEP).run(steps=200, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for body in (0, 4, "WALL", [1, 2]):
            one, other = lm.measure.reaction(sim, body), lm.measure.reaction(run, body)
            np.testing.assert_allclose(one.force, other.force, atol=1e-12)
            np.testing.assert_allclose(one.moment, other.moment, atol=1e-12)


def test_a_step_stays_what_it_was_when_the_next_one_is_set(tmp_path):
    """Another time step and theta, and velocities that are written, are of the next step: forces, moments, points and
    facets of the last one stay, also in the first frame of a file that begins then."""
    scene = lm.Scene(dimension=2, gravity=(1.0, -GRAVITY))
    scene.add(lm.disk(radius=0.1, mass=1.0, position=(0.965, 0.1), velocity=(2.0, -0.1)))
    scene.add(lm.wall_segment((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))).impose_velocity(x=1.0, y=0.1)
    scene.see("GRAIN", "WALL", lm.RollingCoulomb(friction=0.4, rolling_friction=0.2))
    sim = lm.Simulation(scene, time_step=0.02, overlap="ignore").run(steps=2)

    def measured(source):
        found = lm.measure.reaction(source, 0), lm.measure.reaction(source, 1, about=(0.0, 0.0))
        facets, net = lm.measure.facets(source), source.interactions(0) if source is not sim else source.interactions
        return [*(part for of in found for part in (of.force, of.moment)), facets.force, net.lever[:, 0], net.force]

    before, point = measured(sim), sim.interactions.point
    assert before[0][1] > 1.0
    assert abs(before[1][0]) > 0.01
    for time_step, theta in ((0.01, 0.5), (0.02, 1.0), (0.005, 0.75)):
        sim.time_step, sim.theta = time_step, theta
        sim.velocities[0] = 0.0
        np.testing.assert_array_equal(sim.interactions.point, point)
        for one, other in zip(measured(sim), before, strict=True):
            np.testing.assert_array_equal(one, other)
    sim.run(steps=1, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_allclose(run.interactions(0).lever[:, 0], before[-2], atol=1e-15)
        np.testing.assert_allclose(lm.measure.reaction(run, 0, frame=0).moment, before[1], rtol=1e-12)
        np.testing.assert_allclose(lm.measure.reaction(run, 0, frame=0).force, before[0], rtol=1e-12)


def test_a_body_on_a_thread_and_the_thread():
    """A ball hangs in a thread between two held nodes: the thread bears its weight, and the nodes at the ends bear that."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -GRAVITY))
    nodes = [scene.add(lm.point_mass(position=(0.1 * i, 0.0, 0.0), mass=1e-3)) for i in range(5)]
    for end in (nodes[0], nodes[-1]):
        end.fix()
    scene.chain(nodes, lm.ElasticWire(stiffness=1e4), surface=lm.Thread(radius=0.002))
    ball = scene.add(lm.sphere(radius=0.03, mass=0.5, position=(0.21, 0.0, 0.032)))
    ball.fix("x", "y")
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.0))
    scene.drag([*nodes[1:-1], ball], rate=30.0)
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=1.0)
    assert ball.reaction.force[2] == pytest.approx(5.0, rel=5e-3)  # to the tolerance, and nearly at rest
    ends = lm.measure.reaction(sim, [nodes[0], nodes[-1]], about=(0.0, 0.0, 0.0))
    weight = 5.0 + 3 * 1e-3 * GRAVITY
    assert ends.force[2] == pytest.approx(-weight, rel=5e-3)
    assert ends.moment[1] == pytest.approx(5.0 * 0.21 + 0.03 * 0.2, rel=5e-3)
    assert lm.measure.reaction(sim, nodes).force[2] == pytest.approx(-ball.reaction.force[2], rel=1e-9)


def test_wrong_bodies_get_a_sentence(tmp_path):
    scene = heap(2, lm.Coulomb(friction=0.4))
    with pytest.raises(AttributeError, match="is in no simulation yet"):
        _ = scene.bodies[0].reaction
    sim = lm.Simulation(scene, time_step=STEP)
    assert not sim.scene.bodies[0].reaction.force.any()
    for bodies, words in (("SAND", "no colour of this scene, which has GRAIN, WALL"), (99, "99 is none"), ([], "no body")):
        with pytest.raises(ValueError, match=words):
            lm.measure.reaction(sim, bodies)
