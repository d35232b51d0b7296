"""A disk on a plane tilted by alpha: it rolls below tan(alpha) = 3 mu and slips above, with the right accelerations.

All forces are constant, so Moreau-Jean's velocities are exact in every step: rolling a = 2/3 g sin(alpha), slipping
a = g (sin(alpha) - mu cos(alpha)) with a spin of 2 mu g cos(alpha)/R. The gap is a difference of numbers near 1 m and
right to 1e-16 m; over h = 1e-3 s that is 1e-13 m/s a step, beside a g h of 1e-2 m/s: tolerance 1e-9.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

R, G, H, STEPS = 0.1, 9.81, 1e-3, 300
ALPHA = math.atan(0.9)


def roll(friction, alpha, tilt, *, mass=1.5, spin_held=False):
    """(simulation, downhill unit vector): a plane tilted under an upright gravity, or the gravity tilted."""
    s, c = math.sin(alpha), math.cos(alpha)
    if tilt == "plane":
        gravity, normal, downhill = (0.0, -G), np.array([s, c]), np.array([c, -s])
    else:
        gravity, normal, downhill = (G * s, -G * c), np.array([0.0, 1.0]), np.array([1.0, 0.0])
    scene = lm.Scene(dimension=2, gravity=gravity)
    disk = scene.add(lm.disk(radius=R, position=R * normal, mass=mass))
    if spin_held:
        disk.fix("spin")
    scene.add(lm.wall(point=(0, 0), normal=normal))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    sim = lm.Simulation(scene, time_step=H, solver=lm.GaussSeidel(tolerance=1e-13)).run(steps=STEPS)
    return sim, downhill


def check(sim, downhill, acceleration, spin_rate):
    t = STEPS * H
    normal = np.array([-downhill[1], downhill[0]])
    assert sim.velocities[0] @ downhill == pytest.approx(acceleration * t, rel=1e-9, abs=1e-11)
    assert sim.velocities[0] @ normal == pytest.approx(0.0, abs=1e-11)
    assert sim.spins[0] == pytest.approx(-spin_rate * t, rel=1e-9, abs=1e-10)  # clockwise, downhill being to the right
    assert sim.positions[0] @ downhill == pytest.approx(0.5 * acceleration * t**2, rel=1e-9, abs=1e-11)


@pytest.mark.default_parameters("1e-06-plane", "0.5-gravity")
@pytest.mark.parametrize("tilt", ["plane", "gravity"])
@pytest.mark.parametrize("excess", [1e-6, 0.5])
def test_it_rolls_where_friction_suffices(tilt, excess):
    """mu just above tan(alpha)/3, by a millionth, and well above."""
    sim, downhill = roll(math.tan(ALPHA) / 3.0 * (1.0 + excess), ALPHA, tilt)
    a = 2.0 / 3.0 * G * math.sin(ALPHA)
    check(sim, downhill, a, a / R)
    # the friction that rolling takes: a third of m g sin(alpha), uphill
    weight = 1.5 * G
    assert sim.interactions.force[0] == pytest.approx([weight * math.cos(ALPHA), weight * math.sin(ALPHA) / 3.0], rel=1e-9)


@pytest.mark.default_parameters("1e-06-gravity", "0.5-plane")
@pytest.mark.parametrize("tilt", ["plane", "gravity"])
@pytest.mark.parametrize("lack", [1e-6, 0.5])
def test_it_slips_where_friction_does_not_suffice(tilt, lack):
    """mu just below tan(alpha)/3, by a millionth, and well below."""
    mu = math.tan(ALPHA) / 3.0 * (1.0 - lack)
    sim, downhill = roll(mu, ALPHA, tilt)
    a = G * (math.sin(ALPHA) - mu * math.cos(ALPHA))
    spin_rate = 2.0 * mu * G * math.cos(ALPHA) / R
    check(sim, downhill, a, spin_rate)
    assert a * (1.0 + 1e-7) > spin_rate * R  # it slips forward


def test_the_two_regimes_are_different():
    """So that the two tests above tell something: at half the friction the disk is faster and spins less."""
    rolling, downhill = roll(0.6, ALPHA, "plane")
    slipping, _ = roll(0.15, ALPHA, "plane")
    assert slipping.velocities[0] @ downhill > 1.1 * (rolling.velocities[0] @ downhill)
    assert abs(slipping.spins[0]) < 0.8 * abs(rolling.spins[0])


@pytest.mark.parametrize(("factor", "sticks"), [(1.0 + 1e-6, True), (1.0 - 1e-2, False)])
def test_a_disk_that_cannot_spin_is_a_block(factor, sticks):
    """It rests for mu >= tan(alpha), to round-off, and slides at g (sin - mu cos) below."""
    mu = factor * math.tan(ALPHA)
    sim, downhill = roll(mu, ALPHA, "plane", spin_held=True)
    check(sim, downhill, 0.0 if sticks else G * (math.sin(ALPHA) - mu * math.cos(ALPHA)), 0.0)


def test_neither_mass_nor_size_of_the_force_matters():
    """The accelerations do not know the mass."""
    light, _ = roll(0.2, ALPHA, "plane", mass=1e-6)
    heavy, _ = roll(0.2, ALPHA, "plane", mass=1e6)
    assert light.velocities[0] == pytest.approx(heavy.velocities[0], rel=1e-9)
