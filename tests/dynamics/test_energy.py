"""The energy identity of a step: T+ - T- = work of loads + of drives + of impulses, all at the mean velocity."""

from __future__ import annotations

import numpy as np
import pytest
from dense import dense_step, state_velocities
from mixed_scene import LAWS, mixed_scene

import lmgcpy as lm


@pytest.mark.default_parameters("0.5-0.5")
@pytest.mark.parametrize("theta", [0.5, 0.8])
@pytest.mark.parametrize("tolerance", [1e-8, 0.5])
def test_the_identity_closes_at_every_step(theta, tolerance):
    """In a scene of everything, for 200 steps, converged or hardly solved at all: it is algebra, not physics.

    v = v_free + M^-1 H r holds to round-off of v, some 1e-15 of numbers up to 10, so the defect is that share of M v^2;
    a hundred components add up at random. 1e-14 of all the works that may cancel.
    """
    sim = lm.Simulation(mixed_scene(), time_step=2e-3, theta=theta, solver=lm.GaussSeidel(tolerance=tolerance))
    mass = np.where(sim.model.inverse_mass > 0.0, sim.model.mass, 0.0)
    seen, largest = set(), 0.0
    for _ in range(200):
        before = state_velocities(sim)
        kinetic = sim.energy.kinetic
        sim.step()
        energy, after = sim.energy, state_velocities(sim)
        impulse = sim.interactions.impulse
        works = sum(energy.interactions.values())
        scale = np.vdot(mass * np.abs(before), np.abs(before)) + np.vdot(mass * np.abs(after), np.abs(after))
        scale += abs(energy.loads) + abs(energy.drives) + np.abs(impulse).sum() * np.abs(after).max()
        assert abs(energy.defect) <= 1e-14 * scale
        # and the plain difference of the kinetic energies
        assert energy.kinetic - kinetic == pytest.approx(energy.loads + energy.drives + works, abs=1e-13 * scale)
        assert energy.kinetic == pytest.approx(0.5 * np.vdot(mass * after, after), rel=1e-12)
        seen |= {name for name, work in energy.interactions.items() if work != 0.0}
        largest = max(largest, abs(works), abs(energy.drives))
    assert seen == set(LAWS)
    assert largest > 1.0


def test_every_term_is_what_it_is_said_to_be():
    """Against numpy: loads from the forces at the middle of the step, works from H, drives from what driven bodies got."""
    sim = lm.Simulation(mixed_scene(1), time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-6))
    model, totals = sim.model, {}
    loads = drives = 0.0
    for _ in range(100):
        before = state_velocities(sim)
        sim.step()
        mean = 0.5 * (before + state_velocities(sim))
        view = sim.interactions
        problem = dense_step(sim, before)
        work = (problem.H.T @ mean.ravel()).reshape(-1, 2) * view.impulse
        expected = {}
        for name, value in zip(view.law, work.sum(axis=1), strict=True):
            expected[str(name)] = expected.get(str(name), 0.0) + value
        assert sim.energy.interactions == pytest.approx(expected, rel=1e-9, abs=1e-12)
        force = model.weight.copy()
        for load in model.forces:
            force[load.body, load.component] += load.at(sim.time - 1e-3)
        assert sim.energy.loads == pytest.approx(2e-3 * np.vdot(force, mean), rel=1e-12, abs=1e-14)
        received = (problem.H @ view.impulse.ravel()).reshape(-1, 3)
        held = model.inverse_mass == 0.0
        assert sim.energy.drives == pytest.approx(-(received * mean)[held].sum(), rel=1e-9, abs=1e-12)
        loads, drives = loads + sim.energy.loads, drives + sim.energy.drives
        for name, value in sim.energy.interactions.items():
            totals[name] = totals.get(name, 0.0) + value
    assert sim.energy.total_loads == pytest.approx(loads, rel=1e-12)
    assert sim.energy.total_drives == pytest.approx(drives, rel=1e-12)
    assert sim.energy.total_interactions == pytest.approx(totals, rel=1e-12)


def test_a_lift_works_with_force_times_velocity():
    """A floor that rises at 0.4 m/s under 3 kg: the drive gives m g v h a step, all of which the weight takes back."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=3.0, velocity=(0.0, 0.4)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(y=0.4)
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=100)
    # the gap is right to 1e-16 m, so the force to 1e-13 m/s over g h: 1e-11
    assert sim.energy.drives == pytest.approx(3.0 * 9.81 * 0.4 * 1e-3, rel=1e-9)
    assert sim.energy.loads == pytest.approx(-3.0 * 9.81 * 0.4 * 1e-3, rel=1e-9)
    assert sim.energy.total_drives == pytest.approx(3.0 * 9.81 * 0.4 * 0.1, rel=1e-9)
    # the contact moves with both bodies: its work is what one gives and the other takes
    assert sim.energy.total_interactions["signorini"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.long
def test_a_crank_works_against_a_spring():
    """A bead drawn at 0.2 m/s pulls another behind it on a spring: once both go alike, the drive has given the second
    its kinetic energy, and the damping of the scheme has taken as much (as with a rope: work M v^2, half of it kept).
    """
    scene = lm.Scene(dimension=2)
    follower = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.5))
    driven = scene.add(lm.disk(radius=0.01, position=(1.0, 0.0), mass=1.0)).impose_velocity(x=0.2, y=0.0)
    scene.chain([follower, driven], lm.ElasticRod(stiffness=50.0))
    # in the end the error of doing nothing is itself round-off; the block is solved directly at any tolerance
    sim = lm.Simulation(scene, time_step=2e-2, solver=lm.GaussSeidel(tolerance=1e-3)).run(steps=4000)
    assert follower.velocity[0] == pytest.approx(0.2, rel=1e-9)
    assert sim.energy.total_drives == pytest.approx(1.5 * 0.2**2, rel=1e-9)
    assert sim.energy.total_interactions["elastic-rod"] == pytest.approx(-0.5 * 1.5 * 0.2**2, rel=1e-9)
    assert sim.energy.stored["elastic-rod"] == pytest.approx(0.0, abs=1e-12)


def test_dissipative_laws_take_energy():
    """Friction and inelastic shocks in a closed box without loads: the kinetic energy only falls.

    Not so to the last digit: the bias of a gap that closes in part of a step does work (h r u with u = -g/h < 0 takes,
    it never gives), so every contact's work is at most the round-off above zero.
    """
    rng = np.random.default_rng(4)
    scene = lm.Scene(dimension=2)
    for i in range(25):
        place = (0.25 * (i % 5) + 0.15, 0.25 * (i // 5) + 0.15)
        scene.add(lm.disk(radius=0.1, position=place, mass=1.0, velocity=rng.normal(0, 2, 2), spin=rng.normal(0, 10)))
    for point, normal in [((0, 0), (0, 1)), ((0, 0), (1, 0)), ((1.3, 1.3), (-1, 0)), ((1.3, 1.3), (0, -1))]:
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.4))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))
    start = sim.energy.kinetic
    for _ in range(300):
        sim.step()
        assert sim.energy.interactions.get("coulomb", 0.0) <= 1e-9 * start
    assert sim.energy.kinetic < 0.5 * start


def pressed_while_it_opens(h, m, wire, force=0.0):
    """A ball of 1 kg that falls at 1 m/s, on its line a bead of mass m that runs away from it at 0.5 m/s; at the detection
    of the first step they touch, and a wire of 1 m that holds the bead is taut."""
    scene = lm.Scene(dimension=2)
    ball, bead = (
        scene.add(lm.disk(radius=0.1, position=(0.0, y - 0.5 * h * v), mass=mass, velocity=(0.0, v), color=color))
        for y, mass, v, color in ((0.2, 1.0, -1.0, "BALL"), (0.0, m, -1.5, "BEAD"))
    )
    if wire:
        post = scene.add(lm.disk(radius=0.1, position=(0.0, 1.0), mass=1.0, color="POST")).fix()
        scene.chain([post, bead], lm.RigidWire(), reference_gap=0.8)
    ball.impose_force(y=-force)
    scene.see("BALL", "BEAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=h, solver=lm.Newton(tolerance=1e-12))
    sim.step()
    return sim


@pytest.mark.parametrize("h", [1e-2, 1e-5])
@pytest.mark.parametrize("m", [1.0, 1e-6])
def test_work_that_a_contact_transmits_is_not_made(h, m):
    """A taut wire stops a bead and the ball on it: r = M V in the contact, which opened at u- and ends closed. At the mean
    velocity its work is M V u-/2, and the wire takes this and all kinetic energy. Nothing is made."""
    sim = pressed_while_it_opens(h, m, wire=True)
    energy = sim.energy
    assert np.abs(sim.velocities).max() < 1e-9
    assert energy.interactions["signorini"] == pytest.approx(0.25, rel=1e-9)
    assert energy.interactions["rigid-wire"] == pytest.approx(-0.25 - 0.5 - 0.5 * m * 1.5**2, rel=1e-9)
    assert energy.made_by_law == {"rigid-wire": 0.0, "signorini": pytest.approx(0.0, abs=1e-12)}
    assert energy.made == 0.0


def test_work_that_no_other_law_takes_is_counted():
    """No wire: a force brings the ball to 2 m/s, the bead of the same mass runs at 1.5 m/s. They end at 1.75 m/s, with
    r = 0.25 N s and the work r u-/2 of the contact."""
    sim = pressed_while_it_opens(1e-2, 1.0, wire=False, force=100.0)
    assert sim.velocities[:, 1] == pytest.approx(-1.75, rel=1e-9)
    assert sim.energy.made_by_law["signorini"] == pytest.approx(0.25 * 0.5 / 2.0, rel=1e-9)
