"""Stretch that links get as they turn: it is taken back without a blow, and where it is resolved it is left alone."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.turning_stretch import TurningStretch, nets, strands_of

G = 9.81


@pytest.fixture
def taken(monkeypatch):
    """Times at which a step was solved anew."""
    times = []
    take_back = TurningStretch.take_back

    def listed(self, given, *arguments):
        result = take_back(self, given, *arguments)
        if result[1] is not None:
            times.append(given.data.time)
        return result

    monkeypatch.setattr(TurningStretch, "take_back", listed)
    return times


def jumper(law, time_step, *, mass=10.0, dimension=2, options=None, beads=1e-5):
    """A mass under nine light beads and ten folded links of 0.1 m, which it pulls taut as it has fallen 0.5 m."""
    make = lm.disk if dimension == 2 else lm.sphere
    scene = lm.Scene(dimension=dimension, gravity=(0.0, -G) if dimension == 2 else (0.0, 0.0, -G))
    for i in range(11):
        x, y = 0.1 * math.sqrt(0.75) * (i % 2), -0.05 * i
        position = (x, y) if dimension == 2 else (x, 0.0, y)
        scene.add(make(radius=0.01, position=position, mass=mass if i == 10 else beads))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, law, reference_gap=0.08)
    return lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-8), **(options or {}))


LAWS = {
    "rigid-wire": lm.RigidWire(),
    "rigid-rod": lm.RigidRod(),
    "stiff": lm.ElasticWire(axial_rigidity=1e12),
    "elastic": lm.ElasticWire(axial_rigidity=1e6),
    "voigt": lm.VoigtWire(axial_rigidity=1e6, axial_viscosity=1e2),
}


@pytest.mark.long
@pytest.mark.default_parameters("rigid-wire-0.004", "rigid-wire-0.001", "rigid-rod-0.004", "stiff-0.004", "voigt-0.004")
@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("time_step", [4e-3, 1e-3, 2.5e-4])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_wire_does_not_throw_back_what_pulls_it_taut(law, time_step):
    """Energy conserved, or lost, is the theory: 49 J of the fall. A chain may make a hundredth of what its bodies have in a
    step, and lifts the mass by what it was too long, at the coarsest step two ways of the mass, 0.025 m of 0.5 m: 0.05.
    Left alone it made up to five times the energy.
    """
    sim = jumper(law, time_step)
    least = rise = 0.0
    while sim.time < 0.5:
        sim.step()
        made = sum(sim.energy.total_interactions.values()) + sum(sim.energy.stored.values())
        least = min(least, made)
        rise = max(rise, made - least)
        speed = float(np.linalg.norm(sim.velocities[-1]))
        assert speed <= 1.05 * math.sqrt(2.0 * G * 0.55)
    assert rise <= 0.05 * 0.5 * G * 10.0


@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.parametrize("dimension", [2, 3])
def test_positions_take_back_what_velocities_do_not(taken, dimension):
    """Where the step is solved anew the wire is as long as it should be one step later, to what its links turn in it, and
    the mass hangs where it can."""
    sim = jumper(lm.RigidWire(), 1e-3, dimension=dimension)
    while not taken:
        before = float(np.linalg.norm(sim.positions[-1]))
        sim.step()
    assert before > 1.002, "the mass went past the end of the wire, else there was nothing to take back"
    sim.run(steps=3)
    assert np.linalg.norm(sim.positions[-1]) < 1.0 + 1e-3 * (before - 1.0) + 2e-4
    assert np.linalg.norm(sim.velocities[-1]) < 0.2  # inelastic: 3.1 m/s before


@pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
def test_left_alone_it_is_thrown_back(monkeypatch):
    """What the tests above would not see otherwise: at 4 ms the mass arrives at 3.2 m/s and leaves at twice that."""
    monkeypatch.setattr(TurningStretch, "take_back", lambda self, given, solved, *_: (solved, None))
    sim = jumper(lm.RigidWire(), 4e-3)
    fastest = 0.0
    while sim.time < 0.4:
        sim.step()
        fastest = max(fastest, sim.velocities[-1, 1])
    assert fastest > 5.0


@pytest.mark.filterwarnings("ignore:In the step")
def test_the_balance_of_energy_and_the_work_of_gravity_close(taken):
    """In every step kinetic energy changes by the works; and with theta = 1/2 gravity has worked m g times the way that
    bodies went, ways without a velocity too. Both to round-off of 49 J."""
    sim = jumper(lm.ElasticWire(axial_rigidity=1e12), 2e-3)
    mass = np.array([0.0, *[1e-5] * 9, 10.0])
    start = sim.positions.copy()
    while sim.time < 0.4:
        sim.step()
        assert abs(sim.energy.defect) <= 1e-11
    assert taken
    fallen = float(mass @ (start - sim.positions)[:, 1])
    assert sim.energy.total_loads == pytest.approx(G * fallen, rel=1e-12)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")
def test_a_free_wire_keeps_its_momentum(taken):
    """Two masses thrown apart on folded light beads: velocities and ways are due to pairs of impulses, so that linear
    momentum and the centre of mass are kept to round-off. Angular momentum: positions move on
    without velocity by two steps' way of 6 m/s, and the links of a whip turn by much in a step; measured 0.2 % to 2 % of
    the 15 kg m^2/s at steps from 2 ms to 0.125 ms (1 to 4 % if the stretch is pulled back, which makes up to five times
    the energy), so 2 % here."""
    scene = lm.Scene(dimension=2)
    mass = np.array([10.0, *[1e-5] * 9, 10.0])
    for i in range(11):
        speed = {0: (-1.0, -3.0), 10: (1.0, 3.0)}.get(i, (0.0, 0.0))
        scene.add(lm.disk(radius=0.01, position=(0.05 * i, 0.1 * math.sqrt(0.75) * (i % 2)), mass=mass[i], velocity=speed))
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.08)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8))
    centre = mass @ sim.positions / mass.sum()

    def angular():
        (x, y), (u, v) = sim.positions.T, sim.velocities.T
        return float(mass @ (x * v - y * u))

    begin = angular()
    for _ in range(400):
        sim.step()
        assert np.abs(mass @ sim.velocities).max() <= 1e-12 * 60.0
        assert abs(angular() - begin) <= 0.02 * abs(begin)
    assert taken
    np.testing.assert_allclose(mass @ sim.positions / mass.sum(), centre, rtol=0.0, atol=1e-13)


@pytest.mark.default_parameters(turn=(0.1,))
@pytest.mark.parametrize("turn", [0.02, 0.1])
@pytest.mark.parametrize(
    "law", [lm.RigidRod(), lm.RigidWire(), lm.ElasticRod(axial_rigidity=1e12)], ids=lambda law: law.NAME
)
def test_motion_that_the_step_resolves_is_left_alone(taken, law, turn):
    """A pendulum of 1 m that swings with 3 m/s and turns by at most so many radians in a step: a wire too stays taut. It
    keeps its energy of 4.5 J, the velocity being that of half a step before or after: a part ``h omega / 2`` of it."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=1.0)).fix()
    scene.add(lm.disk(radius=0.01, position=(0.0, -1.0), mass=1.0, velocity=(3.0, 0.0)))
    scene.chain(scene.bodies, law)
    sim = lm.Simulation(scene, time_step=turn / 3.0).run(duration=5.0)
    assert not taken
    energy = 0.5 * float(sim.velocities[1] @ sim.velocities[1]) + G * (sim.positions[1, 1] + 1.0)
    assert energy == pytest.approx(4.5, rel=0.5 * turn)


@pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
def test_it_is_off_with_geometric_stiffness(taken):
    sim = jumper(lm.RigidWire(), 4e-3, options={"geometric_stiffness": False}).run(duration=0.4)
    assert not taken
    assert sim.steps == 100


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")
def test_a_run_goes_on_to_the_last_bit_in_the_midst_of_it(taken, tmp_path):
    """From a checkpoint and from a file, one step before a step is solved anew: what links predicted is in both."""
    whole = jumper(lm.RigidWire(), 1e-3)
    while not taken:
        kept = whole.checkpoint()
        whole.step()
    again = jumper(lm.RigidWire(), 1e-3)
    again.restore(kept)
    taken.clear()
    again.step()
    assert taken
    np.testing.assert_array_equal(again.velocities, whole.velocities)
    recorded = jumper(lm.RigidWire(), 1e-3)
    recorded.run(steps=kept.steps, record=tmp_path / "run.h5")
    resumed = lm.resume(tmp_path / "run.h5").run(steps=whole.steps - kept.steps)
    np.testing.assert_array_equal(resumed.positions, whole.positions)
    np.testing.assert_array_equal(resumed.velocities, whole.velocities)


def test_what_a_later_step_predicted_is_forgotten_with_an_older_checkpoint():
    """One of a file from before predicted gaps were kept: nothing is known of them, as in a simulation made anew."""
    sim = jumper(lm.RigidWire(), 1e-3)
    start = dataclasses.replace(sim.checkpoint(), predicted=np.zeros(0))
    sim.run(steps=5)
    assert np.isfinite(sim.checkpoint().predicted).all()
    sim.restore(start)
    assert np.isnan(sim.checkpoint().predicted).all()


@pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
def test_a_law_that_promises_nothing_is_left_alone(taken):
    """A law that drives its link may make energy."""

    class Winch(lm.RigidWire):
        NAME = "test-winch"
        TRAITS = frozenset({"pull"})

    jumper(Winch(), 4e-3).run(duration=0.4)
    assert not taken


@pytest.mark.filterwarnings("ignore:In the step")
def test_a_report_counts_both_solves(taken):
    sim = jumper(lm.RigidWire(), 1e-3)
    while not taken:
        report = sim.step()
    assert report.solves >= 2
    assert report.solved


@pytest.mark.parametrize(
    ("laws", "held", "expected"),
    [
        ((lm.RigidRod, lm.RigidRod, lm.RigidRod), False, [0, 0, 1]),
        ((lm.RigidWire, lm.RigidRod, lm.RigidRod), False, [0, 0, 1]),
        ((lm.RigidWire, lm.RigidWire, lm.RigidRod), False, [0, 1, 2]),
        ((lm.ElasticRod, lm.RigidRod, lm.RigidRod), False, [0, 1, 2]),
        ((lm.RigidRod, lm.RigidRod, lm.RigidRod), True, [0, 1, 2]),
    ],
)
def test_rods_and_rigid_chains_that_cross_them_are_one_net(laws, held, expected):
    """Two chains that cross in a body, and a third one on its own: a body that is held joins nothing, wires do not join
    wires, and what yields has a solution beside anything."""
    scene = lm.Scene(dimension=2)
    places = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (5, 0), (6, 0)]
    b = [scene.add(lm.disk(radius=0.1, position=place, mass=1.0)) for place in places]
    if held:
        b[0].fix()
    for law, bodies in zip(laws, ((b[1], b[0], b[2]), (b[3], b[0], b[4]), (b[5], b[6])), strict=True):
        scene.chain(bodies, law(axial_rigidity=1.0) if law is lm.ElasticRod else law())
    model = scene.compile()
    assert nets(strands_of(model), model.inverse_mass[:, 0] > 0.0).tolist() == expected


@pytest.mark.parametrize("d", [2, 3])
def test_two_pendulums_on_joints_of_one_law_are_two_nets(d):
    """Two rods each on a post of its own: joints that share a rod are one net, however the joints are listed. A third
    joint, at the same post as the first rod, is a net of its own, as a post that is held joins nothing."""
    scene = lm.Scene(dimension=d)
    rods, posts = [], []
    for x in (0.0, 5.0):
        make = lm.disk if d == 2 else lm.sphere
        posts.append(scene.add(make(radius=0.1, position=(x, 0.0, 0.0)[:d], mass=1.0, color="POST")).fix())
    for x, y in ((0.0, 1.0), (5.0, 1.0), (0.0, 3.0), (5.0, 3.0), (0.0, -1.0)):
        ball = lm.DiskContactor(0.1) if d == 2 else lm.SphereContactor(0.1)
        ends = [(ball, (0.0, side, 0.0)[:d]) for side in (-1.0, 1.0)]
        inertia = {"inertia": 1.0} if d == 2 else {"inertia": (1.0, 0.6, 1.0)}
        rods.append(scene.add(lm.RigidBody(ends, mass=1.0, position=(x, y, 0.0)[:d], color="ROD", **inertia)))
    low, high = (0.0, -1.0, 0.0)[:d], (0.0, 1.0, 0.0)[:d]
    scene.link(posts[0], rods[0], lm.BallJoint(), at=(None, low))
    scene.link(posts[1], rods[1], lm.BallJoint(), at=(None, low))
    scene.link(rods[0], rods[2], lm.BallJoint(), at=(high, low))
    scene.link(rods[1], rods[3], lm.BallJoint(), at=(high, low))
    scene.link(posts[0], rods[4], lm.BallJoint(), at=(None, high))
    model = scene.compile()
    found = nets(strands_of(model), model.inverse_mass.max(axis=1) > 0.0).tolist()
    assert found[0] == found[2] != found[1] == found[3]
    assert found[4] not in found[:4]


@pytest.mark.long
@pytest.mark.parametrize("other", [lm.RigidRod, lm.RigidWire])
def test_crossing_rods_are_taken_back_together(other, taken):
    """A bead between two rods and two rods or wires across, straight to held bodies. The excess of both chains is the same,
    ``d^2 / 2 l``; if the gaps of one chain alone were taken back the rods would ask for two motions of the bead at once.
    """
    h, length, mass = 1e-3, 0.02, 0.01
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    places = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)]
    b = [scene.add(lm.sphere(radius=0.004, position=(length * x, length * y, 0.0), mass=mass)) for x, y in places]
    for post in b[1:]:
        post.fix()
    scene.chain([b[1], b[0], b[2]], lm.RigidRod())
    scene.chain([b[3], b[0], b[4]], other())
    sim = lm.Simulation(scene, time_step=h)
    for _ in range(10):
        sim.step()
        assert sim.report.solved
        assert sim.report.factorisations == 0
        assert np.abs(sim.velocities).max() <= 2.0 * G * h
    assert taken


def crossing(scene, mesh, at=0.0, held=0):
    """Two wires across two others that share beads, between posts, with 2 % of slack; a ball of 100 kg falls on them.
    ``held``: further beads at each end, which are held as the posts are."""
    whole = range(-held, 7 + held)
    places = [[(i, row) for i in whole] for row in (2, 4)]
    places += [[(row, j) for j in whole] for row in (2, 4)]
    beads = {}
    for i, j in sorted({place for path in places for place in path}):
        x, y = (0.5 * mesh * (k - 3) for k in (i, j))
        beads[i, j] = scene.add(lm.sphere(radius=0.1 * mesh, position=(at + x, y, 0.0), mass=1e-4, color="NET"))
        if min(i, j) <= 0 or max(i, j) >= 6:
            beads[i, j].fix()
    for path in places:
        scene.chain([beads[place] for place in path], lm.RigidWire(), reference_gap=0.31 * mesh)
    ball = {"radius": 1.2 * mesh, "mass": 100.0, "velocity": (0.0, 0.0, -1.0), "color": "BALL"}
    return scene.add(lm.sphere(position=(at + 0.06 * mesh, 0.02 * mesh, 1.31 * mesh), **ball))


@pytest.mark.parametrize("held", [0, 1])
@pytest.mark.filterwarnings("ignore:In the step")
def test_wires_that_catch_one_ball_are_judged_together(held):
    """Wires of light beads share out the momentum of the ball that they catch: as the gaps of one of them are taken back,
    it may take 0.2 % less energy, and another one 21 J less. If each is judged by itself, the step goes back to the
    detected gaps, and throws the ball back with 0.3 of its 50 J. No step makes 1 %."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    ball = crossing(scene, 0.05, held=held)
    scene.see("BALL", "NET", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1.25e-4, solver=lm.Newton(tolerance=1e-8))
    for _ in range(155):
        sim.step()
        assert sim.energy.interactions["rigid-wire"] < 0.01 * 50.0
    assert sim.energy.kinetic < 0.2 * 50.0  # it was caught
    assert ball.velocity[2] < 0.0
    assert sim.unconverged_steps == 0


def test_nets_that_a_ball_joins_are_together():
    """Four wires on posts that share beads, and contacts with one ball; and four wires elsewhere, on the same floor."""
    scene = lm.Scene(dimension=3)
    for at in (0.0, 1.0):
        crossing(scene, 0.05, at)
    floor = scene.add(lm.sphere(radius=0.01, position=(0.5, 0.0, 0.0), mass=1.0, color="FLOOR")).fix()
    ends = [scene.add(lm.sphere(radius=0.01, position=(0.5, 0.0, z), mass=1.0, color="END")) for z in (0.1, -0.1)]
    for end in ends:
        scene.chain([end, floor], lm.RigidWire())
    scene.see("BALL", "NET", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=5)
    together = sim._turning_stretch._together(sim.last_step[0])
    groups = [np.unique(part).tolist() for part in (together[:4], together[4:8], together[8:9], together[9:])]
    assert [len(group) for group in groups] == [1, 1, 1, 1]
    assert len(np.unique(together)) == 4
