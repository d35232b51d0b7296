"""Nature knows neither the order in which bodies were added, nor directions, nor units.

Scenes with a unique solution: no friction and one layer of contacts, or links and contacts that are not redundant;
solved to 1e-12, so that after 60 steps, in which differences grow in a chaotic heap by a decade at most, they agree
to 1e-8.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm


def build(*, order=None, angle=0.0, mass=1.0, length=1.0, time=1.0, laws=None):
    """A wire of nine beads that falls over three fixed disks onto a tilted floor, with two loose disks on it.

    ``order``: in which the bodies are added; ``angle``: all positions and directions turned; units as given.
    """
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    speed, acceleration, force = length / time, length / time**2, mass * length / time**2
    law = laws or lm.Coulomb(friction=0.25)
    rng = np.random.default_rng(7)

    def at(x, y):
        return length * (turn @ [x, y])

    scene = lm.Scene(dimension=2, gravity=acceleration * (turn @ [0.5, -9.81]))
    beads = [
        lm.disk(
            radius=0.03 * length,
            position=at(0.1 * i - 0.4, 0.5 + 0.02 * (-1) ** i),
            mass=(0.5 + rng.random()) * mass,
            velocity=speed * (turn @ rng.normal(0.0, 0.5, 2)),
            spin=rng.normal() / time,
            color="BEAD",
        )
        for i in range(9)
    ]
    pegs = [lm.disk(radius=0.05 * length, position=at(x, 0.38), mass=mass, color="PEG").fix() for x in (-0.33, 0.02, 0.29)]
    loose = [lm.disk(radius=0.06 * length, position=at(x, 0.65), mass=0.8 * mass, color="LOOSE") for x in (-0.2, 0.18)]
    loose[0].impose_force(spin=0.01 * force * length)
    wall = lm.wall(point=at(0.0, 0.0), normal=turn @ [0.2, 1.0], color="WALL")
    bodies = [*beads, *pegs, *loose, wall]
    for i in order if order is not None else range(len(bodies)):
        scene.add(bodies[i])
    for one, other in [("BEAD", "PEG"), ("LOOSE", "BEAD"), ("BEAD", "WALL"), ("LOOSE", "WALL"), ("LOOSE", "PEG")]:
        scene.see(one, other, law)
    scene.chain(beads, lm.ElasticWire(stiffness=2e3 * force / length))
    sim = lm.Simulation(scene, time_step=2e-3 * time, solver=lm.GaussSeidel(tolerance=1e-12, max_iterations=100_000))
    return sim, bodies


def states(bodies):
    return np.array([[*body.position, *body.velocity, body.rotation, body.spin] for body in bodies])


STEPS = 60


@pytest.fixture(scope="module")
def plain():
    sim, bodies = build()
    touched = set()
    for _ in range(STEPS):
        assert sim.step().status == "converged"
        view = sim.interactions
        touched |= set(view.law[np.abs(view.impulse[:, 0]) > 0.0])
    assert touched == {"coulomb", "elastic-wire"}
    return states(bodies), float(np.abs(view.impulse).sum())


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_the_bodies_does_not_matter(plain, seed):
    sim, bodies = build(order=np.random.default_rng(seed).permutation(15))
    sim.run(steps=STEPS)
    assert states(bodies) == pytest.approx(plain[0], abs=1e-8)


@pytest.mark.parametrize("angle", [0.3, math.pi / 2, -2.0])
def test_directions_do_not_matter(plain, angle):
    sim, bodies = build(angle=angle)
    sim.run(steps=STEPS)
    turned = states(bodies)
    c, s = math.cos(angle), math.sin(angle)
    back = np.array([[c, s], [-s, c]])
    for columns in ([0, 1], [2, 3]):
        turned[:, columns] = turned[:, columns] @ back.T
    assert turned == pytest.approx(plain[0], abs=1e-8)


@pytest.mark.default_parameters("powers1", "powers3")
@pytest.mark.parametrize("powers", [(10, 0, 0), (0, -8, 0), (0, 0, 6), (-20, 5, -3)])
def test_units_do_not_matter(plain, powers):
    """Mass, length and time by powers of two: every intermediate number is scaled exactly, so every bit is the same.

    It would not be, were there a length, a time or a stiffness hidden anywhere in the method.
    """
    mass, length, time = (2.0**power for power in powers)
    sim, bodies = build(mass=mass, length=length, time=time)
    sim.run(steps=STEPS)
    scaled = states(bodies) / [length, length, length / time, length / time, 1.0, 1.0 / time]
    assert np.array_equal(scaled, plain[0])
    assert np.abs(sim.interactions.impulse).sum() == plain[1] * mass * length / time


def test_mirrored_scenes_move_as_mirror_images():
    """x to -x, spins turned round: two disks that meet obliquely with friction."""
    results = []
    for sign in (1.0, -1.0):
        scene = lm.Scene(dimension=2, gravity=(sign * 1.0, -9.81))
        scene.add(lm.disk(radius=0.1, position=(-sign * 0.3, 0.3), mass=1.0, velocity=(sign * 2.0, 0.0), spin=sign * 5.0))
        scene.add(lm.disk(radius=0.15, position=(sign * 0.1, 0.2), mass=2.0))
        scene.add(lm.wall(point=(0, 0), normal=(sign * 0.1, 1.0)))
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
        sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=300)
        results.append(np.column_stack([sim.positions, sim.velocities, sim.spins]) * [sign, 1.0, sign, 1.0, sign])
    assert results[1] == pytest.approx(results[0], abs=1e-9)
    assert np.abs(results[0][:2, 4]).min() > 0.1


def test_a_moving_frame_does_not_matter():
    """Galilei: everything, floor included, at a constant velocity."""
    results = []
    for drift in (np.zeros(2), np.array([3.0, -1.5])):
        scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
        scene.add(lm.disk(radius=0.1, position=(0.0, 0.3), mass=1.0, velocity=(1.0 + drift[0], drift[1]), spin=20.0))
        scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(x=drift[0], y=drift[1])
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
        sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=400)
        results.append([*(sim.positions[0] - sim.positions[1]), *(sim.velocities[0] - drift), sim.spins[0]])
    assert results[1] == pytest.approx(results[0], abs=1e-9)
