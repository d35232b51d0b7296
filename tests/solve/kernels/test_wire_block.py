"""A whole wire in one block against dense solutions: bent, cut by fixed beads, crossing itself, heavy and light.

A wire of rigid links is a linear complementarity problem, which ``dense.wire_impulses`` solves by the active set of
Lawson and Hanson in the dense factor of W. The chains here fold back sharply, where the tridiagonal W is no M-matrix.
"""

from __future__ import annotations

import numpy as np
import pytest
from dense import dense_step, state_velocities, wire_impulses

import lmgcpy as lm

R = 0.01


def bent_chain(seed, links, law, *, mass_decades=3.0, slack=0.5, wire_blocks=True, fixed=(), tolerance=1e-10):
    """A chain that turns by any angle at each bead, thrown at random, some links slack; theta = 1.

    Masses spread over ``mass_decades`` decades; a share ``slack`` of the links is up to 10 % longer than built.
    """
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.uniform(-np.pi, np.pi, links))
    lengths = rng.uniform(0.5, 2.0, links)
    steps = lengths[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])
    scene = lm.Scene(dimension=2)
    beads = []
    for i, place in enumerate(places):
        mass = 10.0 ** rng.uniform(-0.5 * mass_decades, 0.5 * mass_decades)
        velocity = rng.normal(0.0, 1.0, 2)
        beads.append(scene.add(lm.disk(radius=R, position=place, mass=mass, velocity=velocity)))
        if i in fixed:
            beads[-1].fix()
    slacks = np.where(rng.random(links) < slack, rng.uniform(0.0, 0.1, links), 0.0) * lengths
    scene.chain(beads, law, reference_gap=lengths - 2 * R + slacks)
    solver = lm.GaussSeidel(tolerance=tolerance, wire_blocks=wire_blocks, max_iterations=1_000_000)
    # the dense problem has the normal rows alone; with geometric stiffness: test_stiffened_wire_block.py
    return lm.Simulation(scene, time_step=0.05, theta=1.0, solver=solver, geometric_stiffness=False), slacks


def biased_free_velocity(sim, before, slacks):
    """(W, q + (g - g_ref)/h) of the links' normals; theta = 1 detects where the step begins."""
    W, free = dense_step(sim, before).normal()
    return W, free - slacks / sim.time_step


@pytest.mark.default_parameters(seed=(0, 1))
@pytest.mark.parametrize("links", [1, 2, 5, 30, 100])
@pytest.mark.parametrize("seed", range(8))
def test_rigid_wires_of_any_shape(seed, links):
    """Against the dense active set, in one sweep. W's condition is up to 1e3 (masses) times n^2: 1e7 for 100 links, and
    a residual of 1e-10 times sqrt of that; the impulses are compared through W, as velocities: 1e-8 of the largest.
    """
    sim, slacks = bent_chain(seed, links, lm.RigidWire())
    before = state_velocities(sim)
    report = sim.step()
    assert report.status == "converged"
    assert report.iterations <= 1
    W, q = biased_free_velocity(sim, before, slacks)
    found, expected = sim.interactions.impulse[:, 0], wire_impulses(W, q)
    assert (found <= 0.0).all()
    assert np.abs(W @ (found - expected)).max() < 1e-8 * np.abs(q).max()
    if links >= 30:
        assert (expected < 0.0).any()
        assert (expected == 0.0).any()


@pytest.mark.parametrize("seed", range(4))
def test_rigid_rods_of_any_shape(seed):
    """W r = -(q + bias): no inequality, a dense linear solve."""
    sim, _ = bent_chain(seed, 60, lm.RigidRod(), slack=0.0)
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = biased_free_velocity(sim, before, 0.0)
    assert sim.interactions.impulse[:, 0] == pytest.approx(-np.linalg.solve(W, q), rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_elastic_wires_of_any_shape(seed):
    """A compliance C adds to the diagonal: the dense active set of W + C I. Stiffness around 1/(h^2 W)."""
    k = 300.0
    sim, slacks = bent_chain(seed, 60, lm.ElasticWire(stiffness=k))
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = biased_free_velocity(sim, before, slacks)
    W = W + np.eye(60) / (sim.time_step**2 * k)
    assert sim.interactions.impulse[:, 0] == pytest.approx(wire_impulses(W, q), abs=1e-9)


@pytest.mark.default_parameters("0")
@pytest.mark.parametrize("seed", range(4))
def test_voigt_wires_of_any_shape(seed):
    """The answer is not that of a linear problem with a diagonal; the law's own fixed point, interpreted, tells.

    e = w (r - react(w, u - w r)) with u from the dense W: relative to that of r = 0, below the tolerance of 1e-10 times
    ten for the rounding of u.
    """
    law = lm.VoigtWire(stiffness=300.0, viscosity=30.0)
    sim, slacks = bent_chain(seed, 60, law, mass_decades=1.0)
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, free = dense_step(sim, before).normal()
    errors = []
    for r in (sim.interactions.impulse[:, 0], np.zeros(60)):
        u = free + W @ r
        for i, w in enumerate(np.diag(W)):
            prepared = law.prepare(-slacks[i], 0.0, (0.0,), sim.time_step, (300.0, 30.0), ())
            errors.append(w * (r[i] - law.react(((w,),), (u[i] - w * r[i],), prepared)[0]))
    errors = np.array(errors).reshape(2, 60)
    assert np.linalg.norm(errors[0]) < 1e-9 * np.linalg.norm(errors[1])


class Hardening(lm.Law):
    """A user's law, smooth and not linear: r_n = -h (k e + k_3 e^3), e = g + h u_n - g_ref the predicted elongation.

    ``react`` finds e in e + a e + b e^3 = e_free by Newton's method, which is monotone from the larger side.
    """

    NAME = "test-hardening"
    APPLIES_TO = "link"
    PREPARED = ("elongation", "time_step", "k", "k_3")

    k = lm.Parameter("N/m", minimum=0.0)
    k_3 = lm.Parameter("N/m^3", minimum=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (gap - reference_gap, time_step, parameters[0], parameters[1])

    @staticmethod
    def react(W, u, prepared):
        g, h, k, k_3 = prepared
        e = elongation(W[0][0], u[0], g, h, k, k_3)
        return (-h * (k * e + k_3 * e**3),)

    @staticmethod
    def slope(W, u, prepared):
        g, h, k, k_3 = prepared
        e = elongation(W[0][0], u[0], g, h, k, k_3)
        stiffness = k + 3.0 * k_3 * e**2
        return ((-h * h * stiffness / (1.0 + h * h * W[0][0] * stiffness),),)


def elongation(w, u, g, h, k, k_3):
    e = g + h * u
    for _ in range(100):
        value = e - g - h * u + h * h * w * (k * e + k_3 * e**3)
        step = value / (1.0 + h * h * w * (k + 3.0 * k_3 * e**2))
        e -= step
        if abs(step) <= 1e-15 * abs(e):
            break
    return e


class HardeningWithoutSlope(Hardening):
    """The same for the single updates."""

    slope = None


@pytest.mark.default_parameters("0")
@pytest.mark.parametrize("seed", range(3))
def test_a_link_of_ones_own_is_solved_in_the_block(seed):
    """Smooth, so Newton's method converges quadratically within the one visit; without ``slope`` the links are updated
    one at a time. The law itself is the reference: r = -h (k e + k_3 e^3) with e from the dense u = q + W r.
    """
    k, k_3 = 100.0, 1e4
    results = []
    for law in (Hardening(k=k, k_3=k_3), HardeningWithoutSlope(k=k, k_3=k_3)):
        sim, slacks = bent_chain(seed, 25, law, mass_decades=1.0, tolerance=1e-12)
        before = state_velocities(sim)
        report = sim.step()
        assert report.status == "converged"
        r = sim.interactions.impulse[:, 0]
        W, q = dense_step(sim, before).normal()
        e = sim.time_step * (q + W @ r) - slacks
        assert r == pytest.approx(-sim.time_step * (k * e + k_3 * e**3), abs=1e-9)
        results.append((r, report.iterations))
    assert results[0][1] <= 2  # one for the residual; where beads are flung far in a step the slip may ask for another
    assert results[1][1] > 10
    assert results[1][0] == pytest.approx(results[0][0], abs=1e-9)


def test_a_hairpin():
    """Links that fold right back on themselves: neighbours in W of cosine -1, the sharpest bend there is."""
    scene = lm.Scene(dimension=2)
    beads = [
        scene.add(lm.disk(radius=R, position=(float(i % 2), 0.001 * i), mass=1.0, velocity=((-1.0) ** (i + 1) * i, 0.0)))
        for i in range(12)
    ]
    scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=0.05, theta=1.0, solver=lm.GaussSeidel(tolerance=1e-12))
    before = state_velocities(sim)
    assert sim.step().iterations <= 1
    W, q = dense_step(sim, before).normal()
    assert (np.diag(W, 1) > 0.9).all()  # W_{i,i+1} = -n_i . n_{i+1}/m: no M-matrix
    assert sim.interactions.impulse[:, 0] == pytest.approx(wire_impulses(W, q), abs=1e-9)


def test_links_one_at_a_time_agree_with_the_block():
    """wire_blocks=False, on eight links of like masses, where Gauss-Seidel converges to 1e-12."""
    sweeps = []
    for seed in range(6):
        block, single = (
            bent_chain(seed, 8, lm.RigidWire(), mass_decades=0.5, slack=0.2, wire_blocks=blocks, tolerance=1e-12)[0]
            for blocks in (True, False)
        )
        assert block.step().status == single.step().status == "converged"
        assert single.interactions.impulse[:, 0] == pytest.approx(block.interactions.impulse[:, 0], abs=1e-9)
        sweeps.append(single.report.iterations)
    assert max(sweeps) > 20


@pytest.mark.parametrize("fixed", [(7,), (0, 7, 15), (6, 7), (0, 15)])
def test_a_wire_held_at_some_beads(fixed):
    """A held bead cuts the wire in two: W falls into blocks, and a link between two held beads is left out of W.

    Such a link has no free component and W_nn = 0; here it exists for (6, 7) only.
    """
    sim, slacks = bent_chain(5, 15, lm.RigidWire(), fixed=fixed)
    before = state_velocities(sim)
    report = sim.step()
    assert report.status == "converged"
    assert report.iterations <= 1
    W, q = biased_free_velocity(sim, before, slacks)
    free = np.diag(W) > 0.0
    assert free.sum() == (14 if fixed == (6, 7) else 15)
    found = sim.interactions.impulse[:, 0]
    expected = wire_impulses(W[np.ix_(free, free)], q[free])
    assert np.abs(W[np.ix_(free, free)] @ (found[free] - expected)).max() < 1e-9 * np.abs(q).max()
    assert np.isfinite(found).all()


@pytest.mark.parametrize("wire_blocks", [True, False])
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire(), lm.ElasticRod(stiffness=100.0)], ids=lambda law: law.NAME)
def test_a_link_between_held_beads_is_left_alone(law, wire_blocks):
    """No impulse changes anything there: W_nn = 0, and r = 0. The links on both sides do not notice."""
    sim, _ = bent_chain(5, 15, law, slack=0.0, fixed=(6, 7), wire_blocks=wire_blocks)
    before = state_velocities(sim)
    assert sim.step().status == "converged"
    impulse = sim.interactions.impulse[:, 0]
    assert impulse[6] == 0.0
    assert (np.delete(impulse, 6) != 0.0).any()
    if law == lm.RigidRod():
        W, q = dense_step(sim, before).normal()
        free = np.arange(15) != 6
        assert impulse[free] == pytest.approx(-np.linalg.solve(W[np.ix_(free, free)], q[free]), abs=1e-8)


def star(arms, links, law):
    """Wires that all begin at one bead, thrown apart."""
    rng = np.random.default_rng(1)
    scene = lm.Scene(dimension=2)
    centre = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=0.3))
    for a in range(arms):
        direction = np.array([np.cos(2 * np.pi * a / arms), np.sin(2 * np.pi * a / arms)])
        beads = [centre]
        for i in range(1, links + 1):
            place = i * direction + rng.normal(0.0, 0.1, 2)
            beads.append(scene.add(lm.disk(radius=R, position=place, mass=1.0, velocity=rng.normal(0.0, 1.0, 2))))
        scene.chain(beads, law)
    solver = lm.GaussSeidel(tolerance=1e-11, max_iterations=100_000)
    return lm.Simulation(scene, time_step=0.05, theta=1.0, solver=solver, geometric_stiffness=False)


@pytest.mark.parametrize("arms", [3, 5, 7])
def test_wires_that_share_a_bead(arms):
    """Each wire is a block; Gauss-Seidel goes between the blocks. Against the dense problem of all of them."""
    sim = star(arms, 5, lm.RigidWire())
    before = state_velocities(sim)
    assert sim.step().status == "converged"
    assert sim.report.iterations > 1
    W, q = dense_step(sim, before).normal()
    expected = wire_impulses(W, q)
    assert (expected < 0.0).sum() > arms
    assert sim.interactions.impulse[:, 0] == pytest.approx(expected, abs=1e-8)


def test_no_bead_is_too_heavy_nor_too_light():
    """Masses over twelve decades: the elimination needs no pivoting, as the matrix is a scaled positive definite one.

    u = W r + q of taut links must vanish relative to the terms of W r, whose round-off is all there is.
    """
    for seed in range(4):
        sim, slacks = bent_chain(seed, 20, lm.RigidWire(), mass_decades=12.0, tolerance=1e-6)
        before = state_velocities(sim)
        assert sim.step().status == "converged"
        W, q = biased_free_velocity(sim, before, slacks)
        r = sim.interactions.impulse[:, 0]
        terms = np.abs(q) + np.abs(W) @ np.abs(r)
        assert (np.abs(np.where(r < 0.0, W @ r + q, np.maximum(W @ r + q, 0.0))) <= 1e-12 * terms).all()
