"""Imposed velocities and forces, walls that are held, freed, and told to move; bodies as live views; a compiled scene."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm


def alone(body, gravity=(0.0, 0.0), time_step=1e-2, theta=0.5):
    scene = lm.Scene(dimension=2, gravity=gravity)
    scene.add(body)
    return lm.Simulation(scene, time_step=time_step, theta=theta)


def disk(**more):
    return lm.disk(**{"radius": 0.1, "position": (0.0, 0.0), "mass": 2.0, **more})


@pytest.mark.parametrize("component", ["x", "y", "spin"])
def test_an_imposed_velocity_is_that_of_the_end_of_the_step(component):
    """Exactly f(t + h), and f(0) at the start; the other components stay free."""
    sim = alone(disk().impose_velocity(**{component: lambda t: 0.5 + math.sin(3.0 * t)}), gravity=(1.0, 1.0))
    k = ("x", "y", "spin").index(component)
    assert sim.state.velocities[0, k] == 0.5
    for n in range(1, 6):
        sim.step()
        assert sim.state.velocities[0, k] == 0.5 + math.sin(3.0 * sim.time)
        assert sim.time == pytest.approx(1e-2 * n)
        free = [v for i, v in enumerate(sim.state.velocities[0, :2]) if i != k]
        assert free == pytest.approx([1e-2 * n] * len(free))


@pytest.mark.parametrize(("theta", "factor"), [(0.5, 0.5), (1.0, 1.0)])
def test_a_driven_position_follows_by_the_theta_rule(theta, factor):
    """q + h ((1 - theta) f(t) + theta f(t + h)): with f = t^2 after one step theta h^3."""
    sim = alone(disk().impose_velocity(x=lambda t: t**2), theta=theta)
    sim.step()
    assert sim.positions[0, 0] == pytest.approx(factor * 1e-6, rel=1e-12)


@pytest.mark.parametrize(("component", "inertia"), [("x", 2.0), ("y", 2.0), ("spin", 0.5 * 2.0 * 0.1**2)])
def test_an_imposed_force_is_that_of_the_middle_of_the_step(component, inertia):
    """v = h f(t + h/2)/m, exactly, on top of gravity."""
    sim = alone(disk().impose_force(**{component: lambda t: math.cos(40.0 * t)}))
    sim.step()
    k = ("x", "y", "spin").index(component)
    assert sim.state.velocities[0, k] == pytest.approx(1e-2 * math.cos(40.0 * 5e-3) / inertia, rel=1e-14)
    others = [v for i, v in enumerate(sim.state.velocities[0]) if i != k]
    assert others == [0.0, 0.0]


def test_fix_holds_what_it_names():
    sim = alone(disk(velocity=(3.0, 4.0), spin=5.0).fix("x", "spin"), gravity=(1.0, -2.0))
    sim.run(steps=10)
    assert sim.state.velocities[0] == pytest.approx([0.0, 4.0 - 0.2, 0.0])
    assert sim.positions[0, 0] == 0.0
    sim = alone(disk(velocity=(3.0, 4.0), spin=5.0).fix(), gravity=(1.0, -2.0))
    sim.run(steps=10)
    assert (sim.state.velocities[0] == 0.0).all()
    assert (sim.state.positions[0] == 0.0).all()


def test_the_last_word_on_a_component_counts():
    sim = alone(disk().fix().impose_velocity(x=2.0))
    sim.step()
    assert sim.state.velocities[0].tolist() == [2.0, 0.0, 0.0]


def test_a_wall_is_held_and_gravity_does_not_act_on_it():
    sim = alone(lm.wall(point=(1.0, 2.0), normal=(0, 1), mass=5.0), gravity=(3.0, -9.81))
    sim.run(steps=10)
    assert sim.positions[0].tolist() == [1.0, 2.0]


def test_a_loaded_wall_is_freed_in_that_component_alone():
    """It accelerates with F/m along y, gravity leaves it alone, x stays held."""
    wall = lm.wall(point=(0, 0), normal=(0, 1), mass=5.0).impose_force(y=-2.0)
    sim = alone(wall, gravity=(3.0, -9.81))
    sim.run(steps=10)
    assert sim.velocities[0] == pytest.approx([0.0, -2.0 / 5.0 * 0.1], rel=1e-12)
    assert wall.spin == 0.0


def test_a_loaded_wall_presses_with_its_load():
    """A plate of 5 kg pushed with 30 N onto a disk on a floor: the disk carries 30 N above and 30 N and m g below.

    Gaps are right to 1e-16 m, over h 1e-13 m/s, beside h F/m = 6e-3 m/s.
    """
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(disk(position=(0.0, 0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    scene.add(lm.wall(point=(0, 0.2), normal=(0, -1), color="PLATE", mass=5.0)).impose_force(y=-30.0)
    scene.see("GRAIN", "FLOOR", lm.Signorini())
    scene.see("GRAIN", "PLATE", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=30)
    assert sim.interactions.force[:, 0] == pytest.approx([30.0 + 2.0 * 9.81, 30.0], rel=1e-9)
    assert np.abs(sim.velocities).max() < 1e-11


def test_a_moving_wall_pushes_what_it_meets():
    """A wall at 0.3 m/s takes a resting disk along."""
    scene = lm.Scene(dimension=2)
    scene.add(disk(position=(0.15, 0.0)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0))).impose_velocity(x=0.3)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=300)
    assert sim.velocities[0] == pytest.approx([0.3, 0.0], rel=1e-12)
    assert sim.positions[0, 0] - sim.positions[1, 0] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize(("belt", "expected"), [(0.0, 0.0), (0.4, 0.3), (-0.4, -0.3)])
def test_friction_on_a_body_held_along_the_tangent(belt, expected):
    """W_tt = 0: on a resting floor there is nothing to rub against, on a belt the friction is mu N along its motion."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(disk(position=(0.0, 0.1))).fix("x", "spin")
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(x=belt)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=20)
    weight = 2.0 * 9.81
    # the tangent of an upward normal points to -x
    assert sim.interactions.force[0] == pytest.approx([weight, -expected * weight], rel=1e-9, abs=1e-9)


# --------------------------------------------------------------------------------------------------------- live views


def test_bodies_are_live_views_of_the_state():
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    body = scene.add(disk(velocity=(1.0, 2.0), spin=3.0))
    wall = scene.add(lm.wall(point=(0, -5.0), normal=(0, 1)))
    assert (body.id, wall.id) == (0, 1)
    assert body.position.tolist() == [0.0, 0.0]
    sim = lm.Simulation(scene, time_step=1e-2)
    position, velocity = body.position, body.velocity
    assert np.shares_memory(position, sim.positions)
    sim.run(steps=3)
    assert position.tolist() == sim.positions[0].tolist() != [0.0, 0.0]
    assert velocity.tolist() == sim.velocities[0].tolist()
    assert (body.spin, body.rotation) == (sim.spins[0], sim.rotations[0])
    assert body.rotation == pytest.approx(0.09)
    assert wall.position.tolist() == [0.0, -5.0]


def test_shapes_of_what_a_simulation_shows():
    scene = lm.Scene(dimension=2)
    for _ in range(3):
        scene.add(disk())
    sim = lm.Simulation(scene, time_step=1e-2)
    assert sim.positions.shape == sim.velocities.shape == (3, 2)
    assert sim.spins.shape == sim.rotations.shape == (3,)
    assert "3 bodies" in repr(sim)


def test_interactions_are_copies():
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(disk(position=(0.0, 0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    view = sim.interactions
    kept = view.impulse.copy()
    view.impulse[:] = 7.0
    assert np.array_equal(sim.interactions.impulse, kept)
    view = sim.interactions
    sim.run(steps=2)
    assert np.array_equal(view.impulse, kept)
    assert view.force == pytest.approx(kept / 1e-3)
    assert repr(view) == "<1 interactions: 1 signorini>"


def test_an_empty_scene_runs():
    sim = lm.Simulation(lm.Scene(dimension=2), time_step=1e-3).run(steps=3)
    assert sim.positions.shape == (0, 2)
    assert sim.report.status == "converged"
    assert sim.energy.kinetic == 0.0
