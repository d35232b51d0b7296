"""Slow waves of a taut wire that the step damps, and the run that says so."""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest

import lmgcpy as lm

COUNT, LENGTH, MASS, TENSION, RADIUS, AMPLITUDE = 31, 0.05, 0.01, 20.0, 0.002, 1e-5
"""Beads that swing, length of a link [m], mass of a bead [kg], tension [N], radius and amplitude [m]."""


def wire(h, mode=1, *, dimension=2, law=None, amplitude=AMPLITUDE, **options):
    """A taut wire in a mode, between two held beads; (simulation, period [s], amplitude now)."""
    scene = lm.Scene(dimension=dimension)
    body = lm.disk if dimension == 2 else lm.sphere
    shape = np.sin(mode * np.pi * np.arange(COUNT + 2) / (COUNT + 1))
    places = np.zeros((COUNT + 2, dimension))
    places[:, 0], places[:, -1] = LENGTH * np.arange(COUNT + 2), amplitude * shape
    beads = [scene.add(body(radius=RADIUS, position=x, mass=MASS)) for x in places]
    beads[0].fix()
    beads[-1].fix()
    k = 2e4
    scene.chain(beads, lm.ElasticWire(stiffness=k), reference_gap=LENGTH - TENSION / k - 2.0 * RADIUS)
    sim = lm.Simulation(scene, time_step=h, solver=lm.Auto(tolerance=1e-12), **options)
    frequency = 2.0 * math.sqrt(TENSION / (MASS * LENGTH)) * math.sin(mode * math.pi / (2 * (COUNT + 1)))
    return sim, 2.0 * math.pi / frequency, lambda: 2.0 / (COUNT + 1) * float(sim.positions[:, -1] @ shape) / amplitude


@pytest.mark.default_parameters("0.008-1-2", "0.006-3-3")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("h", "mode"), [(8e-3, 1), (8e-3, 2), (6e-3, 3), (4e-3, 1), (4e-3, 3)])
def test_a_wave_that_is_damped_is_told_with_what_it_loses(h, mode, dimension):
    """Once, within two periods, and to a tenth what the wave does lose; with the step that is told it loses nothing."""
    sim, period, amplitude = wire(h, mode, dimension=dimension)
    with pytest.warns(RuntimeWarning, match="wave of the wire from body 0 to body 32") as told:
        sim.run(duration=2.0 * period)
    assert len(told) == 1
    words = str(told[0].message)
    lost = 0.01 * float(re.search(r"loses ([\d.]+) %", words)[1])
    assert amplitude() == pytest.approx((1.0 - lost) ** 2, abs=0.2 * lost)
    assert float(re.search(r"period of ([\d.]+) s", words)[1]) == pytest.approx(period, rel=0.03)
    step = float(re.search(r"time step of ([\d.]+) s", words)[1])
    assert step == pytest.approx(math.sqrt(2.0 * MASS * LENGTH / (4.0 * TENSION)), rel=0.02)
    again, _, amplitude = wire(step, mode, dimension=dimension)
    again.run(steps=round(period / step))
    lost_again = 1.0 - amplitude()
    # steps miss the end of a period by half of one, and the leapfrog its frequency by (h w)^2/24
    angle = 0.5 * 2.0 * math.pi * step / period + 2.0 * math.pi * (2.0 * math.pi * step / period) ** 2 / 24.0
    assert lost_again <= 1.0 - math.cos(angle) + 1e-4


@pytest.mark.default_parameters("0.00353-3-options1", "0.003-1-options3")
@pytest.mark.parametrize(
    ("h", "mode", "options"),
    [
        (2e-3, 1, {}),  # s = 0.64
        (3.53e-3, 3, {}),  # s = 1.99
        (3.6e-3, 1, {}),  # s = 2.07: 0.7 % a period
        (3e-3, 1, {"geometric_stiffness": False}),
        (4e-3, 1, {"amplitude": 1e-8}),  # of rounding or the solver's tolerance, for all that one can see
    ],
)
def test_nothing_is_said_of_what_is_hardly_damped(h, mode, options):
    sim, period, _ = wire(h, mode, **options)
    sim.run(duration=3.0 * period)


@pytest.mark.parametrize("seed", range(4))
def test_a_wire_that_trembles_is_no_wave(seed):
    """Velocities at random, most of which the step does not resolve: what is damped is no standing wave."""
    sim, period, _ = wire(8e-3, amplitude=1e-9)
    sim.velocities[1:-1, 1] = np.random.default_rng(seed).normal(size=COUNT) * 1e-3
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sim.run(duration=0.4 * period)
    assert not told


@pytest.mark.long
def test_a_pendulum_on_light_beads_is_no_wave():
    """It turns as a whole, which nothing damps."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    beads = [scene.add(lm.disk(radius=0.002, position=(0.05 * k, 0.0), mass=3e-5)) for k in range(8)]
    beads[0].fix()
    beads.append(scene.add(lm.disk(radius=0.02, position=(0.4, 0.0), mass=1.0)))
    scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=5e-3)
    sim.run(duration=3.0)
    assert sim._links.resolution(sim._last[0].system.impulse, sim._last[0].data.gap, 5e-3).max() > 2.0
