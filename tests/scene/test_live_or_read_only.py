"""Arrays that a scene and a simulation give out: live views of the state, which may be written, or arrays to read."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def scene_of_all(dimension):
    """A scene with a body, a contactor and a chain of each kind."""
    d = dimension
    up = np.eye(d)[-1]
    scene = lm.Scene(dimension=d, gravity=-9.81 * up)
    scene.add(lm.wall(point=(0.0,) * d, normal=up, mass=3.0))
    ball, across = lm.disk if d == 2 else lm.sphere, np.eye(d)[0]
    balls = [scene.add(ball(radius=0.05, position=0.2 * i * across + 0.5 * up, mass=0.1)) for i in range(4)]
    scene.chain(balls, lm.RigidWire())
    points = [scene.add(lm.point_mass(position=0.1 * i * across + 2.0 * up, mass=0.01)) for i in range(4)]
    law = lm.ElasticWire(stiffness=100.0)
    parameters = {"stiffness": [100.0, 200.0, 300.0]}
    scene.chain(points, law, surface=lm.Thread(radius=0.01, color="T"), parameters=parameters)
    scene.chain([balls[0], points[0]], law, reference_gap=lambda time: 1.5)
    scene.add(lm.clump([0.05, 0.04], [(0.0,) * d, 0.06 * across], density=1000.0).at(0.6 * up - 0.5 * across))
    if d == 2:
        scene.add(lm.wall_segment((1.0, 1.0), (2.0, 1.0), radius=0.01))
    else:
        scene.add(lm.cylinder_wall(point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), radius=3.0))
        scene.add(lm.capsule(radius=0.05, length=0.1, axis=(1.0, 0.0, 0.0), position=(1.0, 0.0, 1.0), mass=0.2))
        corners = [(1.0, 1.0, 0.0), (2.0, 1.0, 0.0), (2.0, 2.0, 0.0), (1.0, 2.0, 0.0)]
        scene.add(lm.plate(corners, radius=0.01, mass=1.0, inertia=(1.0, 1.0, 1.5)))
    return scene


def arrays(thing):
    """Names of the public attributes of an object that are arrays of numbers."""
    names = [name for name in dir(type(thing)) + list(getattr(thing, "__dict__", ())) if not name.startswith("_")]
    return [name for name in sorted(set(names)) if isinstance(getattr(thing, name, None), np.ndarray)]


ANSWERS = {"path", "colliding", "apart", "reference_gap"}
"""A chain finds the first three at each call from its bodies. A copy of the last may be changed and set."""
TURNED = {"spin", "spins", "velocities_in_space"}
"""Copies along the axes of space of bodies that keep a rotation: scipy turns no array that is read-only."""


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_array_takes_what_changes_nothing(dimension, compiled):
    """Each array is part of the state, so that what is written acts, or numpy raises."""
    scene = scene_of_all(dimension)
    things = [scene, *scene.bodies, *scene.chains, *scene.skins]
    things += [contactor for body in scene.bodies for contactor, _ in body.contactors]
    if compiled:
        sim = lm.Simulation(scene, time_step=1e-4).run(steps=1)
        things.append(sim)
        state = [sim.state.positions, sim.state.velocities]
    else:
        state = [body._block for body in scene.bodies]
    looked_at = set()
    for thing in things:
        for name in set(arrays(thing)) - ANSWERS:
            array = getattr(thing, name)
            turned = compiled and dimension == 3 and name in TURNED and getattr(thing, "turns", True)
            if turned:
                continue
            live = array.flags.writeable and any(np.shares_memory(array, part) for part in state)
            assert live or not array.flags.writeable, (type(thing).__name__, name)
            looked_at.add((name, live))
    assert {("gravity", False), ("normal", False), ("start_gaps", False)} <= looked_at
    assert {("position", True), ("velocity", True), ("cells", False)} <= looked_at
    for chain in scene.chains:
        for values in chain.parameters.values():
            assert not values.flags.writeable
    if dimension == 3:
        assert {("inertia", False), ("axis", False), ("half", False), ("spin", True)} <= looked_at
    if compiled:
        assert {("positions", True), ("velocities", True)} <= looked_at
        assert (("spins", True) in looked_at) == (dimension == 2)


def test_a_winch_sets_its_gaps_or_changes_a_copy_of_them():
    """``-=`` sets what it has changed."""
    scene = scene_of_all(2)
    chain = scene.chains[1]
    lm.Simulation(scene, time_step=1e-4).run(steps=1)
    before = chain.reference_gap
    chain.reference_gap -= 1e-3
    assert chain.reference_gap.tolist() == (before - 1e-3).tolist()
    gaps = chain.reference_gap
    gaps[0] += 1e-3
    chain.reference_gap = gaps
    assert chain.reference_gap.tolist() == gaps.tolist()
