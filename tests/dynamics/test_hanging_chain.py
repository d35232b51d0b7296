"""Hanging chains: every tension is the weight below it, at any length and tip mass, in one sweep.

What limits the tensions in doubles. A position of size L is rounded by e_i, up to L 1.1e-16 in each coordinate, and the
gap of link i by e_i - e_{i-1}; over h that is a bias of the link, beside the g h that weight gives in a step. The
inverse of the chain's W turns biases into impulses, r_i = m sum_j min(n - i, n - j) b_j, whence, summed by parts,
r_i = m sum_{j >= i} e_j / h: relative to the weight (n - i) m g h below it no tension is off by more than

    max |e| / (g h^2) = 1.1e-16 L / (g h^2),

with h = 1e-2 s and 0.02 m between beads 2e-14 for 10 beads, 7e-13 for 300 and 2e-11 for 10 000. (The solver itself
may leave its tolerance, 1e-10 times sqrt(n) or so.)
"""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

G, H, SPACING, R = 9.81, 1e-2, 0.02, 0.004


DOWN = np.array([0.0, -1.0])
OBLIQUE = np.array([0.6, -0.8])
"""A direction of gravity in which positions, lengths and normals are all rounded."""


def hang(count, law, *, tip=1.0, tolerance=1e-10, h=H, mass=1e-3, down=DOWN, **solver):
    """A chain of ``count`` links along gravity from a held bead, the last bead ``tip`` times as heavy."""
    scene = lm.Scene(dimension=2, gravity=G * down)
    beads = [
        scene.add(lm.disk(radius=R, position=i * SPACING * down, mass=mass * (tip if i == count else 1.0)))
        for i in range(count + 1)
    ]
    beads[0].fix()
    scene.chain(beads, law, reference_gap=SPACING - 2.0 * R)
    solver = lm.GaussSeidel(tolerance=tolerance, **solver)
    return lm.Simulation(scene, time_step=h, solver=solver)


def weights_below(count, tip, mass=1e-3):
    """Weight under each link from the top [N]."""
    return mass * G * (np.arange(count - 1, -1, -1) + tip)


LAWS = pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod()], ids=["wire", "rod"])


def reachable(count, tip):
    """Residual that doubles can reach, times ten.

    The impulses are up to (n + tip) m g h and rounded at 1.1e-16 of that, so that velocities cannot be better than this
    fraction of g h, at each of n links, where the error of doing nothing is g h at one link.
    """
    return 10.0 * np.sqrt(count) * (count + tip) * 1.1e-16


LENGTHS = pytest.mark.parametrize(("count", "accuracy"), [(10, 1e-9), (300, 1e-9), (10_000, 1e-6)])
TIPS = pytest.mark.parametrize("tip", [1.0, 1e6])


@pytest.mark.default_parameters(
    "10-1e-09-1.0-wire", "10-1e-09-1000000.0-rod", "300-1e-09-1000000.0-wire", "300-1e-09-1.0-rod"
)
@LAWS
@TIPS
@LENGTHS
def test_one_sweep_gives_every_tension(law, tip, count, accuracy):
    """Ten steps from rest, one sweep each, and no more: the whole wire is one block.

    Only a wire of 10 000 beads is given ten, as in its very first step, where the rounding of the positions decides which
    links begin as slack, its active set takes more rounds than the 30 that one sweep has.
    """
    sim = hang(count, law, tip=tip, tolerance=1e-16, max_iterations=10 if count == 10_000 else 1)
    for _ in range(10):
        assert sim.step().residual < reachable(count, tip)
    tensions = -sim.interactions.force[:, 0]
    assert tensions == pytest.approx(weights_below(count, tip), rel=accuracy)
    along = SPACING * np.arange(count + 1)
    assert np.abs(sim.positions - along[:, None] * DOWN).max() < 1e-11


@pytest.mark.default_parameters("10-1e-09-1.0-wire", "10-1e-09-1000000.0-rod", "300-1e-09-1000000.0-wire")
@LAWS
@TIPS
@LENGTHS
def test_the_solver_knows_that_one_sweep_was_enough(law, tip, count, accuracy):
    """At a tolerance that can be reached it stops after one sweep. The first step may be solved twice: the tensions that it
    finds call for geometric stiffness, which later steps start with."""
    sim = hang(count, law, tip=tip, tolerance=max(1e-10, reachable(count, tip)))
    for step in range(5):
        report = sim.step()
        assert report.status == "converged"
        assert report.solves <= (2 if step == 0 else 1)
        assert report.iterations <= (10 if count == 10_000 and step == 0 else report.solves)


@pytest.mark.default_parameters("long-wire")
@LAWS
@pytest.mark.parametrize(("h", "down"), [(1e-2, DOWN), (1e-3, DOWN), (1e-3, OBLIQUE)], ids=["long", "short", "oblique"])
def test_rounding_of_positions_is_all_that_limits_it(law, h, down):
    """The bound at the head of this file, doubled for what the steps add and the second coordinate, holds.

    That the error reaches a twentieth of it says that the bound is what it is for.

    Not at 1e-2 s askew: sideways the beads swing at up to w = 2 sqrt(T/(m l)), here 767/s, with normals that are those
    of the detection, so explicitly, and h w > 2 is unstable. Straight down nothing is rounded sideways.
    """
    count = 300
    sim = hang(count, law, h=h, tolerance=1e-12, down=down)
    worst = 0.0
    for _ in range(20):
        sim.step()
        worst = max(worst, np.abs(-sim.interactions.force[:, 0] / weights_below(count, 1.0) - 1.0).max())
    bound = 2.0 * 1.1e-16 * count * SPACING / (G * h**2)
    assert 0.05 * bound < worst < bound


@pytest.mark.parametrize("count", [3, 20])
def test_links_one_at_a_time_give_the_same(count):
    """Without the wire block Gauss-Seidel needs some n^2 sweeps for a decade; the answer is the same.

    A residual of 1e-10, times the condition of the chain's W, (2 n/pi)^2 = 160 for 20 beads.
    """
    sim = hang(count, lm.RigidWire(), tolerance=1e-10, wire_blocks=False)
    sim.step()
    assert sim.report.status == "converged"
    assert sim.report.iterations > count
    assert -sim.interactions.force[:, 0] == pytest.approx(weights_below(count, 1.0), rel=3e-8)


@pytest.mark.long
def test_a_taut_chain_is_stable_sideways_below_the_limit():
    """A chain of 20 beads, plucked by 1 % of a link in zigzag, its stiffest mode: w = 2 sqrt(T/(m l)) with T = 20 m g at
    the top, h w = 0.63 at h = 1.6e-3 s. For 5000 steps, 500 swings of that mode, it stays within what it was given.

    The energy of the swing, which theta = 1/2 conserves in the mean, bounds every amplitude by sqrt(20) of it: the top
    link's mode has up to twenty times the stiffness of the lowest link's.
    """
    scene = lm.Scene(dimension=2, gravity=G * DOWN)
    side = 0.01 * SPACING
    beads = [
        scene.add(lm.disk(radius=R, position=((-1) ** i * side * (i > 0), -i * SPACING), mass=1e-3)) for i in range(21)
    ]
    beads[0].fix()
    scene.chain(beads, lm.RigidRod())
    sim = lm.Simulation(scene, time_step=1.6e-3, solver=lm.GaussSeidel(tolerance=1e-10))
    for _ in range(10):
        sim.run(steps=500)
        assert np.abs(np.diff(sim.positions[:, 0])).max() < 2.0 * side * np.sqrt(20.0)


@pytest.mark.long
def test_an_elastic_chain_hangs_at_its_static_elongation():
    """Each link is longer by the weight below over k. Backward Euler's damping, 1/sqrt(1 + (h w)^2) a step, with
    h^2 k/m = 40 and h^2 k/(4 n^2 m) > 1e-1 for the slowest of ten beads, brings it to rest in 1500 steps.
    """
    k = 400.0
    sim = hang(10, lm.ElasticWire(stiffness=k), tolerance=1e-12).run(steps=1500)
    lengths = np.diff(sim.positions @ DOWN)
    assert lengths - SPACING == pytest.approx(weights_below(10, 1.0) / k, rel=1e-8)
    assert -sim.interactions.force[:, 0] == pytest.approx(weights_below(10, 1.0), rel=1e-8)


@pytest.mark.long
def test_a_bead_does_not_change_what_a_wire_carries():
    """axial_rigidity: a wire of EA = 50 N and 1 m stretches by F L/EA under 5 N, cut into 5 links or into 40."""
    stretch = []
    for links in (5, 40):
        scene = lm.Scene(dimension=2)
        beads = [scene.add(lm.disk(radius=1e-3, position=(i / links, 0.0), mass=1e-3)) for i in range(links + 1)]
        beads[0].fix()
        beads[-1].impose_force(x=5.0)
        scene.chain(beads, lm.ElasticWire(axial_rigidity=50.0))
        sim = lm.Simulation(scene, time_step=0.05, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=1500)
        stretch.append(sim.positions[-1, 0] - 1.0)
    assert stretch == pytest.approx([0.1, 0.1], rel=1e-8)
