"""Rings: the tridiagonal system of a wire with its two corners."""

from __future__ import annotations

import numpy as np
import pytest
from dense import dense_step, state_velocities, wire_impulses

import lmgcpy as lm

M, RADIUS = 0.5, 1.0


def ring(count, law, *, radial_speed=0.0, spin=0.0, noise=0.0, fixed=(), force=0.0, theta=1.0, h=1e-2, **solver):
    """Beads on a circle, linked all round, moving outward and round, with a force outward on each."""
    rng = np.random.default_rng(count)
    scene = lm.Scene(dimension=2)
    beads = []
    for i in range(count):
        angle = 2.0 * np.pi * i / count
        out, round_ = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        velocity = radial_speed * out + spin * RADIUS * round_ + rng.normal(0.0, 1.0, 2) * noise
        mass = M * (1.0 + noise * rng.uniform(-0.5, 0.5))
        bead = lm.disk(radius=1e-3, position=RADIUS * out, mass=mass, velocity=velocity)
        if force:
            bead.impose_force(x=force * out[0], y=force * out[1])
        if i in fixed:
            bead.fix()
        beads.append(scene.add(bead))
    scene.chain(beads, law, closed=True)
    # of the normal rows alone there are formulas; with geometric stiffness: test_stiffened_wire_block.py
    solver = lm.GaussSeidel(**{"tolerance": 1e-12, **solver})
    return lm.Simulation(scene, time_step=h, theta=theta, solver=solver, geometric_stiffness=False)


LAWS = pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod()], ids=["wire", "rod"])


@LAWS
@pytest.mark.parametrize("count", [3, 4, 5, 50, 301])
@pytest.mark.filterwarnings("ignore:In the step from")  # without the term a ring of 301 would zigzag in the next step
def test_the_hoop_tension_of_a_loaded_ring(law, count):
    """A force F outward on each of n beads: T = F / (2 sin(pi/n)), in the first step from rest, in one sweep.

    For n = 301, T = 48 F; the ring is as well conditioned as a chain of n/2 links: 1e-12 * n^2 = 1e-7.
    """
    sim = ring(count, law, force=7.0, tolerance=1e-11)
    assert sim.step().iterations <= 1
    assert sim.report.status == "converged"
    assert -sim.interactions.force[:, 0] == pytest.approx(np.full(count, 3.5 / np.sin(np.pi / count)), rel=1e-7)


@LAWS
def test_the_tension_of_a_turning_ring(law):
    """m omega^2 R / (2 sin(pi/n)), up to the step: per step the beads run off their circle by (omega h)^2/2.

    Two steps from the start the bias has taken over; at omega h = 1e-3 what is left is of order omega h, 1e-3.
    """
    count, omega = 12, 1.0
    sim = ring(count, law, spin=omega, h=1e-3, theta=0.5).run(steps=50)
    expected = M * omega**2 * RADIUS / (2.0 * np.sin(np.pi / count))
    assert -sim.interactions.force[:, 0] == pytest.approx(np.full(count, expected), rel=2e-3)


@pytest.mark.parametrize("count", [3, 4, 9, 40])
def test_random_rods_against_a_dense_solve(count):
    """W r = -u_free, cyclic. In a triangle every bead moves with both others; the corners are plain off-diagonals."""
    sim = ring(count, lm.RigidRod(), noise=0.8)
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = dense_step(sim, before).normal()
    assert count == 3 or (W[0, -1] != 0.0 and W[0, 2] == 0.0)
    assert sim.interactions.impulse[:, 0] == pytest.approx(-np.linalg.solve(W, q), rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("count", [3, 4, 9, 40])
def test_random_wires_against_the_dense_active_set(count):
    sim = ring(count, lm.RigidWire(), noise=0.8, radial_speed=0.3)
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = dense_step(sim, before).normal()
    expected = wire_impulses(W, q)
    assert (expected < 0.0).any()
    assert sim.interactions.impulse[:, 0] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("fixed", [(0,), (4,), (8,), (0, 4)])
def test_a_ring_held_at_beads_is_open_there(fixed):
    """At the first bead, in the middle, at the last: the corner vanishes where bead 0 is held."""
    sim = ring(9, lm.RigidWire(), noise=0.8, radial_speed=0.3, fixed=fixed)
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = dense_step(sim, before).normal()
    assert sim.interactions.impulse[:, 0] == pytest.approx(wire_impulses(W, q), abs=1e-10)


def test_a_ring_keeps_its_momenta():
    """A noisy ring flung into space: linear and angular momentum to round-off over 300 steps (terms below 50)."""
    sim = ring(15, lm.RigidWire(), noise=0.8, spin=3.0, theta=0.5, h=1e-3)
    mass = sim.model.mass[:, 0]

    def momenta():
        (x, y), (v_x, v_y) = sim.positions.T, sim.velocities.T
        return [mass @ v_x, mass @ v_y, mass @ (x * v_y - y * v_x)]

    before = momenta()
    sim.run(steps=300)
    assert momenta() == pytest.approx(before, abs=1e-11)


def test_links_of_a_ring_one_at_a_time_agree():
    blocks, singles = (ring(6, lm.RigidWire(), noise=0.5, radial_speed=0.5, wire_blocks=b) for b in (True, False))
    blocks.step()
    singles.step()
    assert singles.report.status == "converged"
    assert singles.interactions.impulse[:, 0] == pytest.approx(blocks.interactions.impulse[:, 0], abs=1e-9)
