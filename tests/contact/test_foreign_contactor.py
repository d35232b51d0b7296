"""A contactor from outside the package, with levers in every direction: analytic impacts, rolling."""

from __future__ import annotations

import math

import numpy as np
import pytest
from segment import Segment

import lmgcpy as lm

M, HALF, THICK = 3.0, 0.8, 0.05
"""Mass [kg], half length and radius [m] of the segment."""
INERTIA = M * HALF**2 / 3.0


def segment(color="BAR", **start):
    return lm.RigidBody([Segment(HALF, THICK)], mass=M, inertia=INERTIA, color=color, **start)


def impact(law, *, reach, velocity, candidate="DISK", order=("disk", "bar")):
    """One step of a disk of 2 kg that touches a resting free bar ``reach`` from its middle, without gravity."""
    scene = lm.Scene(dimension=2)
    bodies = {
        "disk": lm.disk(radius=0.2, position=(reach, THICK + 0.2), mass=2.0, color="DISK", velocity=velocity),
        "bar": segment(position=(0.0, 0.0)),
    }
    for name in order:
        scene.add(bodies[name])
    scene.see(candidate, "BAR" if candidate == "DISK" else "DISK", law)
    sim = lm.Simulation(scene, time_step=1e-3, theta=1.0, solver=lm.GaussSeidel(tolerance=1e-12))
    sim.step()
    return sim, bodies["disk"], bodies["bar"]


@pytest.mark.parametrize("reach", [0.0, 0.5, -0.8])
@pytest.mark.parametrize("candidate", ["DISK", "BAR"])
@pytest.mark.parametrize("order", [("disk", "bar"), ("bar", "disk")])
def test_a_blow_on_a_free_bar_matches_the_analytic_impulse(reach, candidate, order):
    """Inelastic and without friction, at 3 m/s: p = v / (1/m + 1/M + x^2/I), x the lever from the bar's middle.

    The bar starts with V = -p/M and spins at -x p/I; the point of contact then moves with the disk.
    """
    sim, disk, bar = impact(lm.Signorini(), reach=reach, velocity=(0.0, -3.0), candidate=candidate, order=order)
    p = 3.0 / (1.0 / 2.0 + 1.0 / M + reach**2 / INERTIA)
    assert sim.interactions.impulse[0] == pytest.approx([p, 0.0], rel=1e-13)
    assert disk.velocity == pytest.approx([0.0, -3.0 + p / 2.0], abs=1e-14)
    assert bar.velocity == pytest.approx([0.0, -p / M], abs=1e-14)
    assert bar.spin == pytest.approx(-reach * p / INERTIA, abs=1e-14)
    assert disk.spin == 0.0
    assert disk.velocity[1] == pytest.approx(bar.velocity[1] + reach * bar.spin, abs=1e-14)


@pytest.mark.parametrize("candidate", ["DISK", "BAR"])
def test_an_oblique_blow_with_friction_matches_the_two_by_two_system(candidate):
    """Stick, from (2, -3) m/s: the local W couples n and t through the bar's lever (x, THICK), written out here.

    W_nn = 1/m + 1/M + x^2/I, W_tt = 1/m + R^2/J + 1/M + THICK^2/I, W_nt = -x THICK/I times the turn of the frame.
    """
    x, R, J = 0.6, 0.2, 0.5 * 2.0 * 0.2**2
    sim, disk, bar = impact(lm.Coulomb(friction=10.0), reach=x, velocity=(2.0, -3.0), candidate=candidate)
    W = np.array(
        [
            [1 / 2.0 + 1 / M + x**2 / INERTIA, -x * THICK / INERTIA],
            [-x * THICK / INERTIA, 1 / 2.0 + R**2 / J + 1 / M + THICK**2 / INERTIA],
        ]
    )
    p_y, p_x = np.linalg.solve(W, [3.0, -2.0])  # along y and x, on the disk
    n = 1.0 if candidate == "DISK" else -1.0
    # t is n turned to the left: -x for n = +y. The impulse on the bar is the opposite, its frame turned too
    assert sim.interactions.normal[0].tolist() == [0.0, n]
    assert sim.interactions.impulse[0] == pytest.approx([p_y, -p_x], rel=1e-12)
    assert disk.velocity == pytest.approx([2.0 + p_x / 2.0, -3.0 + p_y / 2.0], abs=1e-13)
    assert bar.velocity == pytest.approx([-p_x / M, -p_y / M], abs=1e-13)
    assert bar.spin == pytest.approx((-x * p_y + THICK * p_x) / INERTIA, abs=1e-13)


@pytest.mark.parametrize("law", [lm.Signorini(), lm.Coulomb(friction=0.4)])
def test_momentum_through_a_glancing_collision(law):
    """A disk strikes the round end of a spinning bar; 200 steps, all of them keep both momenta to round-off."""
    scene = lm.Scene(dimension=2)
    disk = scene.add(lm.disk(radius=0.2, position=(0.95, 0.4), mass=2.0, color="DISK", velocity=(-0.5, -3.0), spin=4.0))
    bar = scene.add(segment(position=(0.0, 0.0), spin=1.0, rotation=0.1))
    scene.see("DISK", "BAR", law)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))

    def momenta():
        mass, (x, y), (v_x, v_y) = np.array([2.0, M]), sim.positions.T, sim.velocities.T
        angular = mass @ (x * v_y - y * v_x) + 0.04 * disk.spin + INERTIA * bar.spin
        return [mass @ v_x, mass @ v_y, angular]

    before = momenta()
    struck = False
    for _ in range(200):
        sim.step()
        struck |= bool((sim.interactions.impulse[:, 0] > 0.1).any())
        assert momenta() == pytest.approx(before, abs=1e-12)
    assert struck


@pytest.mark.parametrize(("friction", "rolls"), [(0.25, True), (0.15, False)])
def test_a_disk_rolls_or_slips_down_a_fixed_bar(friction, rolls):
    """Along a bar tilted by alpha, tan(alpha) = 0.6: rolling needs mu >= tan(alpha)/3 = 0.2 and gains 2/3 g sin(alpha);
    slipping gains g (sin - mu cos). Exact in every step, as all forces are constant; from the bar's frame to x and y
    and back takes some ten roundings, of numbers below 10 m/s.
    """
    alpha, h, steps, g = math.atan(0.6), 1e-3, 200, 9.81
    s, c = math.sin(alpha), math.cos(alpha)
    scene = lm.Scene(dimension=2, gravity=(0.0, -g))
    scene.add(segment(position=(0.0, 0.0), rotation=-alpha).fix())
    start = np.array([-0.5 * c, 0.5 * s]) + (THICK + 0.2) * np.array([s, c])
    disk = scene.add(lm.disk(radius=0.2, position=start, mass=2.0, color="DISK"))
    scene.see("BAR", "DISK", lm.Coulomb(friction=friction))
    sim = lm.Simulation(scene, time_step=h, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=steps)
    gain = 2.0 / 3.0 * g * s if rolls else g * (s - friction * c)
    turn = -gain / 0.2 if rolls else -2.0 * friction * g * c / 0.2
    t = steps * h
    assert disk.velocity @ [c, -s] == pytest.approx(gain * t, rel=1e-10)
    assert disk.velocity @ [s, c] == pytest.approx(0.0, abs=1e-10)
    assert disk.spin == pytest.approx(turn * t, rel=1e-10)
    assert sim.positions[1] - start == pytest.approx(0.5 * gain * t**2 * np.array([c, -s]), abs=1e-10)


def test_a_contactor_is_abstract():
    class Shapeless(lm.Contactor):
        KIND = "test-shapeless"

    with pytest.raises(TypeError, match="abstract"):
        Shapeless()


def test_two_contactors_that_nobody_has_introduced_are_named():
    scene = lm.Scene(dimension=2)
    scene.add(segment(position=(0.0, 0.0)))
    scene.add(segment(position=(0.0, 0.1)))
    scene.see("BAR", "BAR", lm.Signorini())
    with pytest.raises(LookupError, match="how contactors 'test-segment' and 'test-segment' meet"):
        lm.Simulation(scene, time_step=1e-3)
