"""What laws know of their pair, and what they tell of their dissipation."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm
import lmgcpy.testing
from lmgcpy.laws.pair import effective, pair_of


class Lubricated(lm.Law):
    """Spheres in a viscous liquid: Reynolds' force ``6 pi eta R^2 u / g`` up to ``reach``, on hard contact."""

    NAME = "test-lubricated"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "drag")

    viscosity = lm.Parameter("Pa s", above=0.0)
    roughness = lm.Parameter("m", "gap below which the film is no thinner", above=0.0)
    reach = lm.Parameter("m", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state, pair):
        viscosity, roughness, reach = parameters
        drag = 6.0 * math.pi * viscosity * pair.radius**2 / max(gap, roughness) if gap <= reach else 0.0
        return (max(gap, 0.0) / time_step, time_step * drag)

    @staticmethod
    def react(W, u, prepared):
        bias, drag = prepared
        return (max(-drag * u[0] / (1.0 + drag * W[0][0]), -(u[0] + bias) / W[0][0]),)

    @staticmethod
    def dissipation(gap, reference_gap, velocity, impulse, time_step, parameters, state, pair):
        return -impulse[0] * velocity[0]


@lm.laws.register
class Known(lm.RigidRod):
    """A rod that keeps what it was told last."""

    NAME = "test-known"

    radius = lm.State("m")
    mass = lm.State("kg")
    first_radius = lm.State("m")
    second_inverse_mass = lm.State("1/kg")
    time = lm.State("s")

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state, pair):
        return ((gap - reference_gap) / time_step,)

    @staticmethod
    def initial(gap, reference_gap, time, parameters, pair):
        return (pair.radius, pair.mass, pair.radii[0], 1.0 / pair.masses[1], pair.time)

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state, pair):
        return (state[0], state[1], pair.radii[0], 1.0 / pair.masses[1], pair.time)


class KnownContact(Known):
    """The same on contact."""

    NAME = "test-known-contact"
    APPLIES_TO = "contact"
    TRAITS = frozenset()
    conic = None
    slope = None

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state, pair):
        return (0.0,)

    @staticmethod
    def react(W, u, prepared):
        return (0.0,)


def states(sim):
    """States of the interactions by pair (candidate, antagonist), in the order of their declaration."""
    net = sim.interactions
    values = np.column_stack(list(net.state.values())).tolist()
    return dict(zip(zip(net.candidate.tolist(), net.antagonist.tolist(), strict=True), values, strict=True))


def test_effective_values():
    assert effective(2.0, 2.0) == 1.0
    assert effective(3.0, math.inf) == effective(math.inf, 3.0) == 3.0
    assert effective(0.0, 1.0) == effective(0.0, 0.0) == 0.0
    assert effective(math.inf, math.inf) == math.inf or math.isnan(effective(math.inf, math.inf))
    assert pair_of((1.0, 3.0), (2.0, math.inf), 5.0) == (0.75, 2.0, (1.0, 3.0), (2.0, math.inf), 5.0)


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("dimension", [2, 3])
def test_contacts_know_radii_masses_and_the_time(dimension):
    """Candidate is the lower id, or the first colour; walls and held bodies have infinite mass."""
    scene = lm.Scene(dimension=dimension)
    make, flat = (lm.disk, (0.0,)) if dimension == 2 else (lm.sphere, (0.0, 0.0))
    scene.add(make(radius=0.1, mass=1.0, position=(0.1, *flat)))
    scene.add(make(radius=0.3, mass=4.0, position=(0.5, *flat)))
    scene.add(make(radius=0.6, mass=2.0, position=(1.4, *flat))).fix()
    scene.add(lm.wall(point=(0.0, *flat), normal=(1.0, *flat)))
    for antagonist in ("GRAIN", "WALL"):
        scene.see("GRAIN", antagonist, KnownContact(), alert=0.01)
    sim = lm.Simulation(scene, time_step=0.25).run(steps=3)
    got = states(sim)
    assert got[0, 1] == [pytest.approx(0.075), pytest.approx(0.8), 0.1, 0.25, 0.5]
    assert got[1, 2] == [pytest.approx(0.2), 4.0, 0.3, 0.0, 0.5]
    assert got[0, 3] == [0.1, 1.0, 0.1, 0.0, 0.5]
    assert len(got) == 3


def test_links_know_radii_and_masses(tmp_path):
    """Link i: candidate bodies[i + 1], antagonist bodies[i]. A resumed run knows the same."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=r, mass=m, position=(x, 0.0))) for r, m, x in ((0.1, 1, 0), (0.2, 3, 1), (0.2, 2, 2))]
    scene.chain(beads, Known())
    sim = lm.Simulation(scene, time_step=0.25).run(steps=3, record=tmp_path / "run.h5")
    expected = {(1, 0): [1 / 15, 0.75, 0.2, 1.0, 0.5], (2, 1): [0.1, 1.2, 0.2, 1 / 3, 0.5]}
    for pair, values in states(sim).items():
        assert values == pytest.approx(expected[pair], rel=1e-14)
    again = lm.resume(tmp_path / "run.h5").run(steps=1)
    assert {values[-1] for values in states(again).values()} == {0.75}
    assert [values[:4] for values in states(again).values()] == [values[:4] for values in states(sim).values()]


@pytest.mark.parametrize("radii", [(0.01, None), (0.01, 0.03), (0.04, 0.04)])
def test_a_sphere_sinks_through_a_film_as_reynolds_says(radii):
    """A force F drives a light sphere at another, or at a wall, through the liquid: ``g' = -F g/(6 pi eta R^2)``, so
    that ``g = g_0 exp(-t/tau)``, R the effective radius. Each step takes the film of its start: first order in h/tau."""
    film, viscosity, force = 1e-3, 1.0, 1e-3
    effective_radius = radii[0] if radii[1] is None else radii[0] * radii[1] / (radii[0] + radii[1])
    tau = 6.0 * math.pi * viscosity * effective_radius**2 / force
    gaps = []
    for count in (50, 100):
        scene = lm.Scene(dimension=3)
        sphere = scene.add(lm.sphere(radius=radii[0], mass=1e-9, position=(0.0, 0.0, radii[0] + film)))
        sphere.impose_force(z=-force)
        if radii[1] is None:
            scene.add(lm.wall(point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)))
        else:
            scene.add(lm.sphere(radius=radii[1], mass=1.0, position=(0.0, 0.0, -radii[1]), color="WALL")).fix()
        scene.see("GRAIN", "WALL", Lubricated(viscosity=viscosity, roughness=1e-6, reach=2e-3))
        sim = lm.Simulation(scene, time_step=tau / count)
        sim.step()  # gets its speed
        start = sphere.position[2]
        sim.run(steps=count)
        gaps.append((sphere.position[2] - radii[0]) / (start - radii[0]))
        assert sim.energy.dissipated["test-lubricated"] == pytest.approx(
            -sim.energy.interactions["test-lubricated"], rel=1e-12
        )
        assert sim.energy.total_dissipated["test-lubricated"] == pytest.approx(sim.energy.total_loads, rel=1e-6)
    errors = [gap / math.exp(-1.0) - 1.0 for gap in gaps]
    assert abs(errors[0]) < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


class Sliding(lm.Coulomb):
    """Coulomb friction that tells what sliding dissipates."""

    NAME = "test-sliding"

    @staticmethod
    def dissipation(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return -impulse[1] * velocity[1]


@pytest.mark.default_parameters(time_step=(7e-3,))
@pytest.mark.parametrize("time_step", [1e-3, 7e-3])
def test_what_friction_dissipates_is_the_kinetic_energy_that_is_lost(time_step, tmp_path):
    """A disk that does not turn slides to rest from 1 m/s: half its mass. A run that is resumed on the way goes on with the
    sum."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    disk = scene.add(lm.disk(radius=0.1, mass=2.0, position=(0.0, 0.1), velocity=(1.0, 0.0))).fix("spin")
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", Sliding(friction=0.3))
    with lmgcpy.testing.runs.registered(Sliding(friction=0.3)):
        sim = lm.Simulation(scene, time_step=time_step).run(duration=0.2, record=tmp_path / "run.h5")
        assert 0.1 < disk.velocity[0] < 0.9
        for run in (sim, lm.resume(tmp_path / "run.h5")):
            run.run(duration=0.4)
            assert abs(run.velocities[0, 0]) < 1e-9
            assert run.energy.total_dissipated == {"test-sliding": pytest.approx(1.0, rel=1e-9)}


def test_a_dissipation_that_is_not_finite_stops_the_run():
    law = type("Worse", (Sliding,), {"dissipation": staticmethod(lambda *given: math.nan)})
    with pytest.raises(TypeError, match="dissipation must take"):
        lm.Scene(dimension=2).see("GRAIN", "WALL", law(friction=0.3))

    class Infinite(Sliding):
        @staticmethod
        def dissipation(gap, reference_gap, velocity, impulse, time_step, parameters, state):
            return math.inf if impulse[0] > 0.0 else 0.0

    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    scene.add(lm.disk(radius=0.1, mass=2.0, position=(0.0, 0.1)))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", Infinite(friction=0.3))
    with pytest.raises(FloatingPointError, match="dissipation of law 'test-sliding' returned an energy that is not finite"):
        lm.Simulation(scene, time_step=1e-3).run(steps=1)


@pytest.mark.default_parameters("test-lubricated-units")
@lmgcpy.testing.conformance(Lubricated(viscosity=1.0, roughness=1e-6, reach=1e-2))
def test_a_law_that_knows_its_pair_conforms(check):
    check()


@pytest.mark.long
def test_each_function_takes_the_pair_or_not():
    """As its signature says: a rod that breaks at a strain knows the radii as it commits, and nowhere else."""

    class Brittle(lm.RigidRod):
        NAME = "test-brittle"
        broken = lm.State("-")

        @staticmethod
        def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state, pair):
            return (pair.radius,)

    scene = lm.Scene(dimension=2)
    scene.chain([scene.add(lm.disk(radius=r, mass=1.0, position=(r, 0.0))) for r in (0.25, 0.5)], Brittle())
    assert states(lm.Simulation(scene, time_step=1e-3).run(steps=1)) == {(1, 0): [pytest.approx(1 / 6)]}
    others = [name for name in lmgcpy.testing.PROPERTIES if name not in ("interface", "compiled")]
    assert not lmgcpy.testing.report(Brittle(), skip=others).broken


def test_pair_is_the_last_argument_of_functions_that_may_take_it():
    class PairFirst(Lubricated):
        @staticmethod
        def prepare(pair, gap, reference_gap, velocity, time_step, parameters, state):
            return (0.0, 0.0)

    class PairInReact(Lubricated):
        @staticmethod
        def react(W, u, prepared, pair):
            return (0.0,)

    class TakesTwo(Lubricated):
        @staticmethod
        def dissipation(gap, velocity):
            return 0.0

    for law, sentence in (
        (PairFirst, r"prepare must take \(gap, .*state, pair\), but it takes \(pair, gap, .*state\)\.$"),
        (PairInReact, r"react must take \(W, u, prepared\), but it takes \(W, u, prepared, pair\)\.$"),
        (TakesTwo, r"dissipation must take \(gap, .*state\), with or without pair, but it takes \(gap, velocity\)\.$"),
    ):
        with pytest.raises(TypeError, match=sentence):
            lm.Scene(dimension=2).see("GRAIN", "WALL", law(viscosity=1.0, roughness=1e-6, reach=1e-2))
