"""Light bodies between rigid links that straighten or buckle: links keep their length, and a jerk is told."""

from __future__ import annotations

import math
import re
import warnings

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics import turning_stretch
from lmgcpy.dynamics.whipping_links import (
    Arms,
    WhippingLinks,
    components,
    excess,
    project,
    rotations_by,
    spread,
    turning_ways,
)

G = 9.81


@pytest.fixture
def projected(monkeypatch):
    """Times at which the displacements of a step were projected."""
    times = []
    put_back = WhippingLinks.put_back

    def listed(self, solved, *arguments):
        result = put_back(self, solved, *arguments)
        if result[1] is not None:
            times.append(solved.data.time)
        return result

    monkeypatch.setattr(WhippingLinks, "put_back", listed)
    return times


@pytest.fixture
def rebounding(monkeypatch):
    """The second solve of jerks, which stops the elbow of the double pendulum before it whips, is off."""
    monkeypatch.setattr(turning_stretch, "JERK", np.inf)


def double_pendulum(law, ratio, time_step, dimension=2):
    """Two links of 1 m from a fixed post, let go at 1 and 0.3 rad; a tip of 1 kg, an elbow ``ratio`` times as light."""
    scene = lm.Scene(dimension=dimension, gravity=(0.0, -G) if dimension == 2 else (0.0, -G, 0.0))
    make = lm.disk if dimension == 2 else lm.sphere
    x, y = math.sin(1.0), -math.cos(1.0)
    for (px, py), mass in (((0.0, 0.0), 1.0), ((x, y), 1.0 / ratio), ((x + math.sin(0.3), y - math.cos(0.3)), 1.0)):
        scene.add(make(radius=0.01, position=(px, py, 0.0)[:dimension], mass=mass))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, law, reference_gap=0.98)
    return lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-12))


def lengths(sim):
    """Of the links of one chain, at the next detection [m]."""
    ahead = sim.positions + 0.5 * sim.time_step * sim.velocities
    return np.linalg.norm(np.diff(ahead, axis=0), axis=1)


def told(sim, duration):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim.run(duration=duration)
    return [str(warning.message) for warning in caught]


# ------------------------------------------------------------------------------------------------------ the lengths


@pytest.mark.long
@pytest.mark.default_parameters("2-law0-0.008-1000000.0", "2-law0-0.004-10000000.0", "3-law0-0.016-10000000.0")
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("ratio", [1e3, 1e5, 1e6, 1e7])
@pytest.mark.parametrize("time_step", [16e-3, 8e-3, 4e-3, 2e-3])
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire()])
@pytest.mark.parametrize("dimension", [2, 3])
def test_links_round_a_light_elbow_keep_their_length(dimension, law, time_step, ratio):
    """Rods of 1 m were up to 15.7 m long. Now the elbow is put back from a tenth on, so that no detection finds more; the
    interactions make no energy (0.005 of what is turned over: less than the hundredth that chains may make in a step)."""
    sim = double_pendulum(law, ratio, time_step, dimension)
    for _ in range(round(0.8 / time_step)):
        sim.step()
        off = lengths(sim) - 1.0
        assert (off if "pull" in law.TRAITS else np.abs(off)).max() <= 0.1
    assert sim.energy.made <= 5e-3 * sim.energy.turned


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("held", ["driven", "fixed"])
@pytest.mark.parametrize("time_step", [8e-3, 2e-3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_closed_ring_of_rods_keeps_its_length(projected, dimension, time_step, held):
    """Eight rods, every second body 1e-6 kg, hung at one body that is fixed or shaken: rods were up to 7 times too long."""
    scene = lm.Scene(dimension=dimension, gravity=(0.0, -G, 0.0)[:dimension])
    make = lm.disk if dimension == 2 else lm.sphere
    for i in range(8):
        place = math.cos(0.25 * math.pi * i), math.sin(0.25 * math.pi * i), 0.0
        scene.add(make(radius=0.01, position=place[:dimension], mass=1e-6 if i % 2 else 1.0 + i))
    scene.bodies[2].fix()
    if held == "driven":
        scene.bodies[2].impose_velocity(x=lambda time: 2.0 * math.cos(10.0 * time))
    scene.chain(scene.bodies, lm.RigidRod(), closed=True)
    sim = lm.Simulation(scene, time_step=time_step)
    while sim.time < 1.2:
        sim.step()
        ring = sim.positions + 0.5 * time_step * sim.velocities
        length = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
        assert np.abs(length / (2.0 * math.sin(math.pi / 8.0)) - 1.0).max() <= 0.1
        assert abs(sim.energy.defect) <= 1e-12 * sim.energy.turned
    assert projected


@pytest.mark.filterwarnings("ignore:In the step")
def test_where_it_acts_the_links_have_their_length_to_round_off(projected, rebounding):
    """That is the theory of the projection: the elbow is where two circles meet. The tip has moved by no more than a mass
    of 1e-6 times the elbow's way lets it."""
    sim = double_pendulum(lm.RigidRod(), 1e6, 8e-3)
    while not projected:
        sim.step()
    assert np.abs(lengths(sim) - 1.0).max() <= 1e-9


@pytest.mark.filterwarnings("ignore:In the step")
def test_left_alone_rods_are_twice_as_long(monkeypatch, rebounding):
    """What the tests above would not see otherwise."""
    monkeypatch.setattr(WhippingLinks, "put_back", lambda self, *step: (None, None))
    sim = double_pendulum(lm.RigidRod(), 1e6, 8e-3)
    longest = 0.0
    for _ in range(30):
        sim.step()
        longest = max(longest, lengths(sim).max())
    assert longest > 2.0


@pytest.mark.default_parameters("2")
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_balance_of_energy_and_the_work_of_gravity_close(projected, rebounding, dimension):
    """In every step kinetic energy changes by the works; and gravity has worked m g times the way that bodies went, those
    without velocity included. To round-off of what is turned over, 3 J, with velocities of the elbow up to 500 m/s."""
    sim = double_pendulum(lm.RigidRod(), 1e6, 4e-3, dimension)
    start = sim.positions.copy()
    for _ in range(100):
        sim.step()
        assert abs(sim.energy.defect) <= 1e-12
    assert projected
    fallen = float(np.array([0.0, 1e-6, 1.0]) @ (start - sim.positions)[:, 1])
    assert sim.energy.total_loads == pytest.approx(G * fallen, rel=1e-12)


@pytest.mark.default_parameters("RigidWire()")
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire()], ids=repr)
def test_a_pendulum_thrown_straight_loses_the_same_at_any_step(law):
    """An elbow of 1e-4 of the tip: links without rebound take the energy of the speed along the straight line, once: from
    -14.67 J to -15.67 J. (Links that gave a part back and took it later ended at -15.76 to -15.79 J, if wires.)"""
    for time_step in (8e-3, 4e-3, 2e-3):
        sim = double_pendulum(law, 1e4, time_step)
        while sim.time < 0.4:
            sim.step()
        energy = sim.energy.kinetic + G * float(sim.model.mass[1:, 0] @ sim.positions[1:, 1])
        assert energy == pytest.approx(-15.67, abs=0.01)


def stretching(time_step, floor):
    """Free bodies of 1 and 2 kg that part at 1 m/s, from 0.1 m on, round an elbow of 1e-7 kg on rods of 0.5 m, which it
    does not tear; a ``floor`` that sees the elbow, which goes through the line at 0.9 s."""
    scene, y = lm.Scene(dimension=2), math.sqrt(0.2475)
    moving = (0.0, 0.0, 1.0, (0.0, 0.0)), (0.05, y, 1e-7, (0.5, -0.025 / y)), (0.1, 0.0, 2.0, (1.0, 0.0))
    for x, height, mass, velocity in moving:
        color = "ELBOW" if height else "END"
        scene.add(lm.disk(radius=0.01, position=(x, height), mass=mass, velocity=velocity, color=color))
    scene.chain(scene.bodies, lm.RigidRod(), reference_gap=0.48)
    scene.add(lm.wall(point=(0.0, floor), normal=(0, 1), color="FLOOR"))
    scene.see("ELBOW", "FLOOR", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-12))


@pytest.mark.default_parameters(time_step=(8e-3,))
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("time_step", [8e-3, 4e-3, 2e-3])
def test_a_free_chain_keeps_its_momentum(projected, rebounding, time_step):
    """Ways are due to pairs of impulses: the centre of mass goes on, to round-off of the elbow's velocities, 1e3 m/s."""
    sim = stretching(time_step, floor=-10.0)
    mass = np.array([1.0, 1e-7, 2.0])
    momentum, centre = mass @ sim.velocities[:3], mass @ sim.positions[:3]
    while sim.time < 1.1:
        sim.step()
        assert np.abs(lengths(sim)[:2] / 0.5 - 1.0).max() <= 0.1
        np.testing.assert_allclose(mass @ sim.velocities[:3], momentum, atol=1e-12)
    assert projected
    np.testing.assert_allclose(mass @ sim.positions[:3], centre + sim.time * momentum, atol=1e-12)


@pytest.mark.default_parameters("0.44")
@pytest.mark.parametrize("turn", [0.1, 0.44, 0.6])
def test_what_turns_heavily_is_left_alone(projected, turn):
    """Two bodies about each other, which fly along together much faster: their energy is that of the turning. They keep
    it, 0.5 J, as ``e' = e`` in steady turning (docs/nscd.md)."""
    scene = lm.Scene(dimension=2)
    for y in (0.5, -0.5):
        scene.add(lm.disk(radius=0.01, position=(0.0, y), mass=1.0, velocity=(100.0 - y, 0.0)))
    scene.chain(scene.bodies, lm.RigidRod())
    sim = lm.Simulation(scene, time_step=turn)
    told(sim, 50.0 * turn)
    assert not projected
    relative = np.diff(sim.velocities, axis=0)[0]
    assert 0.25 * float(relative @ relative) == pytest.approx(0.25, rel=turn)


def test_ways_that_close_a_contact_or_change_another_link_are_not_gone():
    """An elbow on a floor: it may go up and along, not down; with an elastic link to a third body it may not go at all."""
    sim = stretching(1e-3, floor=math.sqrt(0.2475) - 0.01)
    sim.step()
    problem, links = sim.last_step[0], WhippingLinks(sim.model)
    for way, may in (((0.0, 1e-3), True), ((1e-3, 0.0), True), ((0.0, -1e-3), False)):
        added = np.zeros((4, 2))
        added[1] = way
        met = links._met(problem, added, np.array([0, 1]), np.arange(4))
        assert (1 not in met) is may
        assert 1 in links._met(problem, added, np.array([0]), np.arange(4))


@pytest.mark.long
def test_runs_without_whips_have_the_same_bits(monkeypatch):
    """A hanging chain of ten rods that swings."""

    def run():
        scene = lm.Scene(dimension=2, gravity=(0.0, -G))
        beads = [scene.add(lm.disk(radius=0.01, position=(0.1 * i, 0.0), mass=1.0)) for i in range(11)]
        beads[0].fix()
        scene.chain(beads, lm.RigidRod())
        return lm.Simulation(scene, time_step=1e-3).run(duration=0.5).positions.copy()

    with_it = run()
    monkeypatch.setattr(WhippingLinks, "put_back", lambda self, *step: (None, None))
    np.testing.assert_array_equal(run(), with_it)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")
def test_elastic_rods_are_left_alone(projected):
    double_pendulum(lm.ElasticRod(stiffness=1e9), 1e6, 8e-3).run(duration=0.4)
    assert not projected


# -------------------------------------------------------------------------------------------------- the projection


def placed(start, c, a, aim, held, inverse):
    """Vectors of the links after the projection."""
    push, _ = project(start, c, a, aim, held, inverse)
    way = np.zeros_like(inverse)
    np.add.at(way, c, inverse[c] * push)
    np.add.at(way, a, -inverse[a] * push)
    return start + way[c] - way[a], way


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("far", [1.001, 1.5, 15.0, 1e4, 1e-3])
def test_one_link_ends_on_its_circle(dimension, far):
    """The nearest point of a circle is that along its radius, however far it is."""
    direction = np.array([0.6, 0.8, 0.0])[:dimension]
    inverse = np.array([np.zeros(dimension), np.ones(dimension)])
    one = np.array([1]), np.array([0]), np.array([2.0]), np.array([True])
    arrow, _ = placed(2.0 * far * direction[None], *one, inverse)
    np.testing.assert_allclose(arrow[0], 2.0 * direction, atol=1e-9)


@pytest.mark.parametrize("beyond", [1e-9, 1e-5, 1e-3])
@pytest.mark.parametrize("ratio", [1e3, 1e5, 1e7])
def test_a_chain_beyond_its_length_ends_stretched_out(ratio, beyond):
    """A post, a light bead 0.3 beside the line, and a heavy one at 2 + beyond. Two links of 1 whose elbow is y beside the
    line are 2 - y^2 long, so that ``m (0.3 - y)^2 + (beyond + y^2)^2`` is least, ``m (0.3 - y) = 2 y (beyond + y^2)``, to
    second order in y, which is 0.055 at the most. Newton steps without the stiffness of the pull do not find it at 1e7."""
    inverse = np.array([[0.0, 0.0], [ratio, ratio], [1.0, 1.0]])
    start = np.array([[1.0, 0.3], [1.0 + beyond, -0.3]])
    links = np.array([1, 2]), np.array([0, 1]), np.ones(2), np.ones(2, dtype=bool)
    arrow, way = placed(start, *links, inverse)
    assert np.abs(excess(arrow, np.ones(2))).max() <= 1e-9
    roots = np.roots([2.0, 0.0, 2.0 * beyond + 1.0 / ratio, -0.3 / ratio])
    y = float(roots[np.abs(roots.imag) < 1e-12].real.max())
    assert arrow[0, 1] == pytest.approx(y, rel=0.01)
    assert -way[2, 0] == pytest.approx(beyond + y * y, rel=0.02)


def test_wires_may_be_shorter():
    """Two slack wires round a bead stay as they are; of a long and a short one only the long one acts."""
    inverse = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]])
    links = np.array([1, 2]), np.array([0, 1])
    start = np.array([[0.5, 0.0], [0.5, 0.0]])
    assert not project(start, *links, np.ones(2), np.zeros(2, dtype=bool), inverse)[0].any()
    arrow, _ = placed(np.array([[2.0, 0.0], [-1.5, 0.0]]), *links, np.array([1.5, 5.0]), np.zeros(2, dtype=bool), inverse)
    np.testing.assert_allclose(arrow, [[1.5, 0.0], [-1.0, 0.0]], atol=1e-9)


def test_a_closed_polygon_of_rods():
    """A triangle of free bodies, one of which was flung away: the centre of mass stays."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]])
    a, c = np.array([0, 1, 2]), np.array([1, 2, 0])
    aim = np.linalg.norm(corners[c] - corners[a], axis=1)
    corners[2] += (0.4, 0.3)
    mass = np.array([1.0, 2.0, 1e-6])
    arrow, way = placed(corners[c] - corners[a], c, a, aim, np.ones(3, dtype=bool), np.column_stack([1.0 / mass] * 2))
    assert np.abs(excess(arrow, aim)).max() <= 1e-9
    np.testing.assert_allclose(mass @ way, 0.0, atol=1e-15)


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_rods_of_a_chain_that_was_torn_apart_are_joined(d):
    """A rod on a hinge, and another one at its end, flung by some lengths and radians: both joints are closed, and ways are
    pairs of impulses. Moments of those impulses give the slope of the ways of turning."""
    rng, k = np.random.default_rng(0), {2: 3, 3: 6}[d]
    half, inverse = 0.5 * np.eye(d)[-1], np.zeros((3, k))
    inverse[1:, :d], inverse[1:, d:] = 1.0, [12.0] if d == 2 else [12.0, 12.0, 1e3]
    points = np.repeat([[-half, 0.0 * half], [-half, half]], d, axis=0)
    c, a, axis = np.repeat([1, 2], d), np.repeat([0, 1], d), np.tile(range(d), 2)
    for _ in range(4):
        turn = rng.normal(size=(3, k - d)) * 2.0
        turn[0] = 0.0
        arms = Arms(points, np.stack([c, a], axis=1), rotations_by(turn))
        place = np.array([0.0 * half, half, 3.0 * half]) + rng.normal(size=(3, d))
        place[0] = 0.0
        start = place[c] - place[a] + arms.apart()
        push, turned = project(start, c, a, np.ones(2 * d), np.ones(2 * d, dtype=bool), inverse, arms, axis)
        way = np.zeros((3, d))
        np.add.at(way, c, push)
        np.add.at(way, a, -push)
        way[0] = 0.0
        there = arms.turned(turned)
        ends = place[c] + way[c] - place[a] - way[a] + there.apart()
        np.testing.assert_allclose(ends, 0.0, atol=1e-9)
        moment = np.zeros((3, k - d))
        for end, sign in ((0, 1.0), (1, -1.0)):
            np.add.at(moment, there.ends[:, end], sign * np.einsum("rdk,rd->rk", there.slopes()[:, end], push))
        slope, _ = turning_ways(spread(inverse[:, d:]), rotations_by(turned))
        np.testing.assert_allclose(moment[1:], slope[1:], atol=1e-6)  # Newton steps approach it slowly


@pytest.mark.parametrize("d", [2, 3])
def test_the_ways_of_turning_have_the_slopes_that_are_said(d):
    """``tr(E) - tr(E Q)`` by differences, along the axes after Q; at rest the second slope is the inertia."""
    rng, width = np.random.default_rng(1), {2: 1, 3: 3}[d]
    inverse = 1.0 / np.array([[2.0] if d == 2 else [1.0, 1.5, 2.0]])
    E, turned, step = spread(inverse), rotations_by(rng.normal(size=(1, width))), 1e-4

    def ways(turn: np.ndarray) -> float:
        return float(E.sum() - np.einsum("ni,nii->n", E, turned @ rotations_by(turn))[0])

    slope, second = turning_ways(E, turned)
    for i, e in enumerate(step * np.eye(width)):
        assert slope[0, i] == pytest.approx((ways(e[None]) - ways(-e[None])) / (2.0 * step), rel=1e-6)
        for j, f in enumerate(step * np.eye(width)):
            four = ways((e + f)[None]) - ways((e - f)[None]) - ways((f - e)[None]) + ways((-e - f)[None])
            assert second[0, i, j] == pytest.approx(four / (4.0 * step**2), abs=1e-6)
    at_rest = turning_ways(E, np.eye(d)[None])[1][0]
    np.testing.assert_allclose(at_rest, np.diag(1.0 / inverse[0]), atol=1e-15)


def test_components_are_joined_by_free_bodies():
    """Two links that share a fixed body are two components."""
    label, of_link = components(np.array([1, 3, 2]), np.array([0, 1, 0]), np.array([False, True, True, True]))
    assert label[1] == label[3] == of_link[0] == of_link[1]
    assert label[2] == of_link[2] != label[1]


# --------------------------------------------------------------------------------------------------- what is told


@pytest.mark.default_parameters("rod-0.016-1000000.0", "rod-0.004-100.0", "wire-0.002-1000.0", "wire-0.002-100.0")
@pytest.mark.parametrize("ratio", [1.0, 10.0, 1e2, 1e3, 1e6])
@pytest.mark.parametrize("time_step", [16e-3, 8e-3, 4e-3, 2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire()], ids=["rod", "wire"])
def test_a_straightening_that_loses_energy_is_told(law, time_step, ratio):
    """Ideal links take no energy. Runs that lost more than 0.05 of it say so; in a step up to m l/(10 r), that is
    0.1 s over the ratio at 1 m/s, they lose less than 0.02 and say nothing."""
    sim = double_pendulum(law, ratio, time_step)
    sentences = [sentence for sentence in told(sim, 0.32) if "took" in sentence]
    lost = (sim.energy.total_loads - sim.energy.kinetic) / sim.energy.turned
    assert len(sentences) == (lost > 0.05)
    if time_step <= 0.1 / ratio:
        assert lost <= 0.02


@pytest.mark.long
def test_the_step_that_is_named_does():
    """At 1e3 and 2 ms it names the step m l/(10 r) of 0.5 kg m/s or more: 4e-5 s. With it less than 0.02 is lost, and
    nothing is said. Mass ratios scale it."""
    steps = {}
    for ratio in (1e2, 1e3, 1e6):
        (sentence,) = (text for text in told(double_pendulum(lm.RigidRod(), ratio, 4e-3), 0.3) if "took" in text)
        assert "between bodies" in sentence
        steps[ratio] = float(re.search(r"time step of ([\d.e-]+) s", sentence).group(1))
    assert steps[1e6] == pytest.approx(1e-3 * steps[1e3], rel=0.2)
    sim = double_pendulum(lm.RigidRod(), 1e2, steps[1e2])
    assert not told(sim, 0.3)
    assert sim.energy.total_loads - sim.energy.kinetic <= 0.02 * sim.energy.turned


@pytest.mark.parametrize("time_step", [4e-3, 1e-3])
def test_a_slack_wire_that_is_thrown_taut_says_nothing(time_step):
    """The law takes the energy: 1 kg that falls 0.2 m on a wire, of which nothing is left."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    scene.add(lm.disk(radius=0.01, position=(0.0, -0.8), mass=1.0))
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.98)
    sim = lm.Simulation(scene, time_step=time_step)
    assert not told(sim, 0.4)
    assert sim.energy.kinetic <= 1e-3 * sim.energy.turned


def test_what_the_start_loses_is_not_told():
    """Two rods of which one end was given a velocity along them: the first step takes half of the energy."""
    scene = lm.Scene(dimension=2)
    for i, speed in enumerate((0.0, 0.0, 1.0)):
        scene.add(lm.disk(radius=0.01, position=(0.1 * i, 0.0), mass=1e-3 if i == 1 else 1.0, velocity=(speed, 0.0)))
    scene.chain(scene.bodies, lm.RigidRod())
    assert not told(lm.Simulation(scene, time_step=1e-3), 1e-3)


def test_a_stretch_of_a_quarter_is_told_at_once():
    """Two bodies of 1 kg that turn about each other by 0.9 rad in a step: too heavy to be put back."""
    scene = lm.Scene(dimension=2)
    for y in (0.5, -0.5):
        scene.add(lm.disk(radius=0.01, position=(0.0, y), mass=1.0, velocity=(-y, 0.0)))
    scene.chain(scene.bodies, lm.RigidRod())
    sentences = told(lm.Simulation(scene, time_step=0.9), 1.8)
    assert any("is off its reference length" in sentence for sentence in sentences)
