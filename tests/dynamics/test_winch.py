"""Reference gaps that are set between steps: ropes that are drawn in and let out."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

MASS, G, LENGTH, SPEED, H = 5.0, 9.81, 1.0, 0.2, 1e-3


def simulation(law, links=1):
    """A load on a rope of some links under a hook, the rope, and the load."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    places = np.linspace(0.0, -LENGTH, links + 1)
    bodies = [scene.add(lm.disk(radius=0.01, position=(0.0, y), mass=0.1)) for y in places[:-1]]
    bodies[0].fix()
    bodies.append(scene.add(lm.disk(radius=0.05, position=(0.0, -LENGTH), mass=MASS)))
    chain = scene.chain(bodies, law)
    return lm.Simulation(scene, time_step=H, solver=lm.Auto(tolerance=1e-10)), chain, bodies[-1]


def winding(chain, speed=SPEED):
    """What ``on_step`` draws in of the first link."""

    def wind(sim):
        gaps = chain.reference_gap.copy()
        gaps[0] -= speed * H
        chain.reference_gap = gaps

    return wind


@pytest.mark.default_parameters("1-law0")
@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e5)])
@pytest.mark.parametrize("links", [1, 4])
def test_a_load_rises_as_its_rope_is_drawn_in(law, links):
    """At the winch's speed, under a pull of m g once it moves; rigid links follow at once, to the length of two steps.
    Nothing is said to have been made out of nothing: the winch does the work."""
    sim, chain, load = simulation(law, links)
    sim.run(duration=0.2)
    start = load.position[1]
    sim.run(duration=0.5, on_step=winding(chain))
    stretch = 0.0 if law.NAME.startswith("rigid") else 2.0 * MASS * G / 1e5 * links
    assert load.position[1] - start == pytest.approx(SPEED * 0.5, abs=2.0 * SPEED * H + stretch)
    if law.NAME.startswith("rigid"):
        assert load.velocity[1] == pytest.approx(SPEED, rel=1e-6)
        weight = (MASS + 0.1 * (links - 1)) * G
        np.testing.assert_allclose(-sim.interactions.force[0, 0], weight, rtol=1e-6)
    assert sim.energy.made <= 1e-9 * sim.energy.turned
    mass = MASS + 0.1 * (links - 1)  # all below the first link rises
    given = mass * G * SPEED * 0.5 + 0.5 * mass * SPEED**2
    if law.NAME.startswith("rigid"):
        assert sim.energy.total_by_hand == pytest.approx(given, rel=4e-3)  # two steps of 500
    else:  # beside what each step stretches at once, k s^2/2, which the scheme damps, it swings
        assert sim.energy.total_by_hand - 500 * 0.5 * 1e5 * (SPEED * H) ** 2 == pytest.approx(given, rel=0.1)


@pytest.mark.long
def test_a_run_goes_on_with_what_was_drawn_in(tmp_path):
    sim, chain, _ = simulation(lm.RigidWire(), 3)
    sim.run(steps=40, record=tmp_path / "run.h5", every=10, on_step=winding(chain))
    resumed = lm.resume(tmp_path / "run.h5")
    resumed.run(steps=30, on_step=winding(resumed.scene.chains[0]))
    whole, of_whole, _ = simulation(lm.RigidWire(), 3)
    whole.run(steps=70, on_step=winding(of_whole))
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_array_equal(run.positions[-1], whole.positions)
        first, last = (lm.measure.wire_links(run, frame=k).reference_length for k in (0, -1))
        assert first[0] - last[0] == pytest.approx(70 * SPEED * H, rel=1e-9)
        assert first[1] == last[1]
    again = lm.Scene.from_run(tmp_path / "run.h5", 40)
    assert again.chains[0].reference_gap[0] == pytest.approx(LENGTH / 3 - 0.02 - 40 * SPEED * H, rel=1e-9)


@pytest.mark.long
def test_the_stiffness_of_a_rope_is_that_of_its_length_now():
    """EA/l: drawn in to a half it stretches by half as much."""
    sim, chain, load = simulation(lm.ElasticWire(axial_rigidity=1e5))
    sim.run(duration=0.1)
    sim.run(duration=0.5, on_step=winding(chain, speed=1.0))
    for _ in range(40):  # at rest
        sim.run(steps=50)
        sim.state.velocities *= 0.3
    assert chain.reference_gap[0] == pytest.approx(0.5 - 0.06, rel=1e-9)
    assert -load.position[1] - 0.5 == pytest.approx(MASS * G * 0.5 / 1e5, rel=1e-3)


LAWS = [lm.RigidWire(), lm.RigidRod()]


@pytest.mark.parametrize("law", LAWS)
def test_a_rigid_link_does_not_begin_off_its_length(law):
    """Refused as it is where the chain is made; a wire may be let out, and is slack then."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.01, position=(0.03 * i, 0.0), mass=0.1)) for i in range(3)]
    chain = scene.chain(beads, law)
    with pytest.raises(ValueError, match=r"Link 1 of the chain, .* a rigid link would pull it right with a blow"):
        chain.reference_gap = [0.01, 0.0099]
    np.testing.assert_allclose(chain.reference_gap, 0.01, rtol=1e-12)
    if law is LAWS[0]:
        chain.reference_gap = 0.02
    else:
        with pytest.raises(ValueError, match="with a blow"):
            chain.reference_gap = 0.02
    beads[2].position[0] = 0.1
    with pytest.raises(ValueError, match="with a blow"):
        lm.Simulation(scene, time_step=H)


@pytest.mark.parametrize("steps", [0, 3])
@pytest.mark.parametrize("law", LAWS)
def test_a_blow_between_steps_is_told_with_its_speed(law, steps, recwarn):
    """s/h: 200 m/s for 0.2 m in a step of 1 ms. It is said from a tenth of the length on; the energy is work of what draws,
    not made."""
    sim, chain, _ = simulation(law)
    sim.scene.gravity = (0.0, 0.0)
    sim.run(steps=steps)
    chain.reference_gap = chain.reference_gap - 0.09 * LENGTH
    sim.step()
    assert not recwarn.list
    chain.reference_gap = chain.reference_gap - 0.2 * LENGTH
    words = r"off by 0\.2\d* m, 2\d\.?\d* % of it: a blow, in which its ends meet it at 2\d\d m/s"
    with pytest.warns(RuntimeWarning, match=words):
        sim.step()
    assert sim.energy.made == 0.0


def test_a_gap_that_is_set_beside_a_body_that_is_added_makes_no_energy():
    """As beside none: the work of the winch is no energy out of nothing. Before, it was so for this step."""
    sim, chain, load = simulation(lm.RigidWire())
    sim.run(steps=3)
    chain.reference_gap = chain.reference_gap - 1e-3
    sim.scene.add(lm.disk(radius=0.01, position=(5.0, 0.0), mass=1.0))
    sim.step()
    assert load.velocity[1] == pytest.approx(1e-3 / H, rel=0.1)
    assert sim.energy.made == 0.0
    assert sum(sim.energy.made_by_law.values()) == 0.0


def between(law, sag=0.0):
    """Three links from one held disk to another, 1 m apart, ``sag`` [m] below their line; the simulation and the chain."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    places = [(-0.5, 0.0), (-0.5 / 3, -sag), (0.5 / 3, -sag), (0.5, 0.0)]
    disks = [scene.add(lm.disk(radius=0.02, position=place, mass=0.06)) for place in places]
    disks[0].fix()
    disks[-1].fix()
    chain = scene.chain(disks, law)
    return lm.Simulation(scene, time_step=2e-3, on_unconverged="ignore"), chain


def told(recwarn, words="no motion gives the links their length"):
    return [str(w.message) for w in recwarn if words in str(w.message)]


@pytest.mark.long
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("law", LAWS)
def test_a_rope_between_held_bodies_that_is_drawn_too_short_is_told(law, recwarn):
    """Drawn from 1.0018 m to 1.0006 m it bears, and nothing is said. At 0.9966 m no motion gives its links their length.
    Steps seem solved, as disks nearly in line move across by what linearised lengths ask for. Before, only a jerk was told,
    of a rope of 0.1 mm too little with the words that a step of 1e-13 s would do."""
    sim, chain = between(law, sag=0.0245)
    assert sum(chain.lengths()) == pytest.approx(1.0018, abs=1e-4)
    for _ in range(60):
        chain.reference_gap = chain.reference_gap - 1.2e-3 / 180
        sim.step()
    assert not recwarn.list
    chain.reference_gap = chain.reference_gap - 4e-3 / 3
    sim.run(steps=20)
    (sentence,) = told(recwarn)
    assert "the links from body 0 to body 3 are 0.996598 m long" in sentence
    assert " 1 m apart" in sentence
    assert not told(recwarn, "jerk")


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("law", LAWS)
def test_a_rope_whose_ends_are_driven_apart_is_told(law, recwarn):
    """As soon as it is too short. Before, a run said that rigid links took 3.8e12 J, and that a step of 2.6e-16 s would
    do."""
    sim, chain = between(law, sag=0.05)
    slack = sum(chain.lengths()) - 1.0
    sim.scene.bodies[3].impose_velocity(x=0.5)
    sim.run(duration=0.8 * slack / 0.5)
    assert not told(recwarn)
    sim.run(duration=(5e-3 + 0.2 * slack) / 0.5)
    assert len(told(recwarn)) == 1
    assert not told(recwarn, "jerk")


def test_wrong_gaps_change_nothing():
    sim, chain, _ = simulation(lm.RigidWire(), 3)
    sim.run(steps=1)
    before = chain.reference_gap
    wrong = (-1.0, "no length"), ([0.1, 0.2], "3 numbers"), (np.nan, "finite"), ([0.1, 0.1, -2.0], "no length")
    for gaps, words in wrong:
        with pytest.raises(ValueError, match=words):
            chain.reference_gap = gaps
    np.testing.assert_array_equal(chain.reference_gap, before)
    assert sim.state.changes == []


@pytest.mark.default_parameters("False-0.07-0.1-law0", "True-0.07-0.05-law1")
@pytest.mark.filterwarnings("ignore:In the step")  # at 0.2, whose string ends at 0.8 rad a step
@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e6)])
@pytest.mark.parametrize("turn", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("speed", [0.03, 0.07, 0.15, 0.3])
@pytest.mark.parametrize("by_hand", [False, True])
def test_a_ball_whose_string_is_drawn_in_keeps_its_angular_momentum(by_hand, speed, turn, law):
    """A string of 1 m with a ball of 1 kg at 1 m/s, which turns by ``turn`` in a step, is drawn in to a half: its pull is
    central, so that ``v = 1/l``. The length is right to what the string turns out in the last step, ``l turn^2/(2 l^4)``.

    The work of the winch was taken for energy that the turning made: steps were solved again, and down to 0.35 of the
    angular momentum was left."""
    scene = lm.Scene(dimension=2)
    start = (0, 0), (-speed, 1.0)
    bodies = [lm.disk(radius=0.01, position=(k, 0), mass=1.0, velocity=v) for k, v in enumerate(start)]
    bodies[0].fix()
    gap = lambda time: 0.98 - speed * time  # noqa: E731
    chain = scene.chain([scene.add(body) for body in bodies], law, reference_gap=None if by_hand else gap)
    sim = lm.Simulation(scene, time_step=turn, solver=lm.Auto(tolerance=1e-12))

    def wind(sim):
        chain.reference_gap = gap(sim.time + 1.5 * turn)

    steps = int(0.5 / (speed * turn))
    if by_hand:
        wind(sim)
    sim.run(steps=steps, on_step=wind if by_hand else None)
    (x, y), (u, v) = bodies[1].position, bodies[1].velocity
    assert x * v - y * u == pytest.approx(1.0, abs=1e-9)
    aim = 1.0 - speed * steps * turn
    assert aim - 1e-9 <= math.hypot(x, y) <= aim + 0.5 * turn**2 / aim**3
    assert sim.energy.made == 0.0
