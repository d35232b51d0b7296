"""Reference gaps that are functions of time, and parameters of laws that are set between steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.measure import wire_links

MASS, G, LENGTH = 5.0, 9.81, 1.0
SWING, OMEGA = 0.05, 6.0
H = 2e-3


def gap(time):
    """Of a rope that is drawn in and let out again, at rest at the start [m]."""
    return LENGTH - 0.06 - SWING * (1.0 - math.cos(OMEGA * time))


def speed(time):
    return -SWING * OMEGA * math.sin(OMEGA * time)


def rope(law, reference_gap, *, time_step=H, theta=0.5, dimension=2, solver=None):
    """A load on a rope of one link under a hook."""
    up = np.eye(dimension)[-1]
    body = lm.disk if dimension == 2 else lm.sphere
    scene = lm.Scene(dimension=dimension, gravity=-G * up)
    hook = scene.add(body(radius=0.01, position=0.0 * up, mass=0.1)).fix()
    load = scene.add(body(radius=0.05, position=-LENGTH * up, mass=MASS))
    chain = scene.chain([hook, load], law, reference_gap=reference_gap)
    solver = lm.Auto(tolerance=1e-12) if solver is None else solver
    return lm.Simulation(scene, time_step=time_step, theta=theta, solver=solver), chain, load


# -------------------------------------------------------------------------------------------------- functions of time


@pytest.mark.default_parameters("2-law0-0.5", "2-law1-1.0", "3-law0-0.7")
@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire()])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_link_has_the_gap_of_the_function_at_every_detection(law, theta, dimension):
    """Up to what the solver leaves: a step from t drives the gap of the detection at ``t + (2 - theta) h``. The load moves
    slower than it falls, so that the wire stays taut."""
    sim, _, _ = rope(law, gap, theta=theta, dimension=dimension)
    for _ in range(40):
        start = sim.time
        sim.step()
        if start:
            assert sim.interactions.gap[0] == pytest.approx(gap(start + (1.0 - theta) * H), abs=1e-12)


@pytest.mark.default_parameters("law0")
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.ElasticRod(stiffness=1e11)])
def test_position_and_velocity_follow_with_the_square_of_the_step(law):
    """Of four octaves of the step; a stiff rod is what a rigid one is, but for its stretch of m g/k = 5e-10 m."""
    errors = []
    for h in (8e-3, 4e-3, 2e-3, 1e-3):
        sim, _, load = rope(law, gap, time_step=h)
        sim.run(duration=0.4)
        position, velocity = -load.position[1] - 0.06, -load.velocity[1]
        errors.append([abs(position - gap(0.4)), abs(velocity - speed(0.4))])
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 1.8).all(), errors
    assert errors[-1][0] < 1e-6  # SWING (OMEGA h)^2 / 8 = 2e-7
    assert errors[-1][1] < 1e-5


@pytest.mark.default_parameters(h=(8e-3,))
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.ElasticRod(stiffness=1e4), lm.ElasticRod(axial_rigidity=1e4)])
@pytest.mark.parametrize("h", [5e-4, 2e-3, 8e-3])
def test_a_function_gives_the_energy_that_its_rope_does(law, h):
    """The load's energy changes by the work of gravity and by what is given by hand, less what an implicit spring damps.
    That is what each step stretches at once, k (f' h)^2/2, and its swing. Nothing is made out of nothing."""
    sim, _, _ = rope(law, gap, time_step=h)
    sim.run(steps=1)
    start = sim.energy.mechanical - sim.energy.total_loads - sim.energy.total_by_hand
    defects = []
    for _ in range(round(0.5 / h)):
        sim.step()
        defects.append(abs(sim.energy.defect))
    lost = start + sim.energy.total_loads + sim.energy.total_by_hand - sim.energy.mechanical
    assert max(defects) < 1e-12
    # at omega h = 0.36 the work at the mean of two velocities is off by as much
    assert sim.energy.made <= (2e-3 if h > 2e-3 else 1e-9) * sim.energy.turned
    if law.NAME == "rigid-rod":
        assert abs(lost) <= 1e-9 * sim.energy.turned
    else:
        swing = 0.5 * (MASS * G) ** 2 / 1e4
        at_once = 0.5 * 2e4 * (SWING * OMEGA) ** 2 * h * 0.5  # k of the shortest rope is less than twice 1e4
        assert 0.0 <= lost <= swing + at_once


def test_a_function_is_what_is_stated_step_by_step():
    """To the last bit, with the gap of the next detection stated before each step."""
    driven, _, _ = rope(lm.RigidWire(), gap)
    stated, chain, _ = rope(lm.RigidWire(), gap(0.0))
    for k in range(50):
        chain.reference_gap = gap(stated.time + 0.5 * H + H)
        stated.step()
        driven.step()
        np.testing.assert_array_equal(stated.state.positions, driven.state.positions)
        if k:  # the first statement draws from the gap of the start, the function from that of the first detection
            assert stated.energy.by_hand == pytest.approx(driven.energy.by_hand, rel=1e-9)


def test_a_run_with_a_function_goes_on_bit_for_bit(tmp_path):
    """With the function given again; its gaps at the frames are in the file."""
    whole, _, _ = rope(lm.ElasticWire(axial_rigidity=1e5), gap)
    whole.run(steps=70)
    sim, _, _ = rope(lm.ElasticWire(axial_rigidity=1e5), gap)
    sim.run(steps=33, record=tmp_path / "run.h5", every=10)
    with pytest.raises(ValueError, match=r'the reference_gap of chain 0.* functions=\{\("chain", 0\): f\}'):
        lm.resume(tmp_path / "run.h5")
    with pytest.raises(TypeError, match=r"functions\['chain', 0\] must be a function of time"):
        lm.resume(tmp_path / "run.h5", functions={("chain", 0): 0.3})
    again = lm.resume(tmp_path / "run.h5", functions={("chain", 0): gap})
    again.run(steps=37)
    np.testing.assert_array_equal(again.state.positions, whole.state.positions)
    np.testing.assert_array_equal(again.state.velocities, whole.state.velocities)
    assert again.energy == whole.energy
    with lm.io.open_run(tmp_path / "run.h5") as run:
        lengths = [wire_links(run, frame=k).reference_length[0] for k in range(run.frame_count)]
        np.testing.assert_allclose(lengths, [gap(t) + 0.06 for t in run.times], rtol=1e-12)
    scene = lm.Scene.from_run(tmp_path / "run.h5", 20, functions={("chain", 0): gap})
    assert scene.chains[0].reference_gap[0] == gap(0.0)  # functions begin at time 0 again


def test_a_number_between_steps_ends_the_function(tmp_path):
    """For good, in the file as well; a restore brings it back."""
    sim, chain, _ = rope(lm.RigidWire(), gap)
    sim.run(steps=20)
    before = sim.checkpoint()
    there = chain.reference_gap
    chain.reference_gap = there
    sim.run(steps=3)
    assert sim.model.chains[0].function is None
    np.testing.assert_array_equal(sim.model.chains[0].reference_gap, there)
    sim.restore(before)
    sim.run(steps=3)
    assert sim.interactions.gap[0] == pytest.approx(gap(22 * H + 0.5 * H), abs=1e-12)


def test_each_link_has_its_own_function_and_what_is_wrong_is_refused():
    wrong = (
        (lambda time: -1.0, "no length"),
        (lambda time: [0.1, 0.2], "one number a link|1 numbers"),
        (lambda time: math.nan, "finite"),
        (lambda time: "far", "number"),
        (lambda time: 1.0 / 0.0, "ZeroDivisionError"),
    )
    for function, words in wrong:
        with pytest.raises(RuntimeError if "Division" in words else (TypeError, ValueError), match=words):
            rope(lm.RigidWire(), function)
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.01, position=(0.1 * k, 0.0), mass=1.0)) for k in range(3)]
    with pytest.raises(ValueError, match="relaxes"):
        scene.chain(beads, lm.RigidWire(), reference_gap=lambda time: 0.08, relaxation=1.0)
    chain = scene.chain(beads, lm.RigidRod())
    chain.reference_gap = lambda time: np.array([0.08 + 0.01 * time, 0.08 - 0.02 * time])
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=20)
    np.testing.assert_allclose(np.diff(sim.positions[:, 0]), [0.1 + 2e-4, 0.1 - 4e-4], atol=1e-9)
    with pytest.raises(RuntimeError, match="between steps takes numbers"):
        chain.reference_gap = gap


def test_a_function_that_fails_in_a_step_leaves_the_simulation_as_it_was():
    broken = []

    def function(time):
        if broken and time > 0.03:
            raise OSError("no signal")
        return gap(time)

    sim, _, _ = rope(lm.RigidWire(), function)
    whole, _, _ = rope(lm.RigidWire(), gap)
    whole.run(steps=40)
    broken.append(True)
    with pytest.raises(RuntimeError, match=r"reference_gap of .* failed with OSError"):
        sim.run(steps=40)
    assert 0 < sim.steps < 40
    broken.clear()
    sim.run(steps=40 - sim.steps)
    np.testing.assert_array_equal(sim.state.positions, whole.state.positions)
    assert sim.energy == whole.energy


# ---------------------------------------------------------------------------------------------------- laws of contacts


def slope(friction, *, dimension=2, law=lm.Coulomb, **others):
    """A disk that does not turn on a floor, under gravity tilted by 0.4."""
    up = np.eye(dimension)[-1]
    body = lm.disk if dimension == 2 else lm.sphere
    spins = ("spin",) if dimension == 2 else ("spin_x", "spin_y", "spin_z")
    scene = lm.Scene(dimension=dimension, gravity=10.0 * (0.4 * np.eye(dimension)[0] - up))
    block = scene.add(body(radius=0.1, position=0.1 * up, mass=1.0)).fix(*spins)
    scene.add(lm.wall(point=0.0 * up, normal=up))
    scene.see("GRAIN", "WALL", law(friction=friction, **others))
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-12)), block


@pytest.mark.default_parameters(first=(0.0, 0.2), then=(0.0, 0.5))
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("first", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("then", [0.0, 0.1, 0.5, 0.8])
def test_friction_that_is_set_acts_from_the_next_step_on(first, then, dimension):
    """``a = g (tan - mu)`` while it slides; what stands goes on standing where mu is above the slope, 0.4."""
    sim, block = slope(first, dimension=dimension)
    sim.run(steps=50)
    before = block.velocity[0]
    assert before == pytest.approx(10.0 * max(0.4 - first, 0.0) * 0.05, abs=1e-9)
    sim.scene.set_law("WALL", "GRAIN", lm.Coulomb(friction=then))
    sim.run(steps=20)
    expected = max(before + 10.0 * (0.4 - then) * 0.02, 0.0)
    assert block.velocity[0] == pytest.approx(expected, abs=1e-9)
    assert sim.scene.rows[0][2] == lm.Coulomb(friction=then)
    assert abs(sim.energy.defect) < 1e-12


def bumps(friction=0.3):
    """Grains that fall on a floor, on which friction and restitution change, and a wire whose stiffness does."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    rng = np.random.default_rng(1)
    for i in range(12):
        position = 0.12 * (i % 4), 0.06 + 0.12 * (i // 4)
        scene.add(lm.disk(radius=0.05, mass=1.0, position=position, velocity=rng.normal(size=2)))
    beads = [scene.add(lm.disk(radius=0.02, mass=0.1, position=(0.1 * k, 0.6), color="BEAD")) for k in range(4)]
    scene.chain(beads, lm.ElasticWire(stiffness=1e3))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=0.2, friction=friction))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "BEAD", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=2e-3, on_unconverged="ignore")


def changing(sim):
    """Statements in some steps."""
    scene, k = sim.scene, sim.steps
    if k == 15:
        scene.set_law("GRAIN", "GRAIN", lm.Coulomb(friction=0.0))
        scene.chains[0].law = lm.ElasticWire(axial_rigidity=500.0)
    if k == 20:
        scene.set_law("WALL", "GRAIN", lm.Restitution(restitution=0.8, friction=0.1))
    if k % 10 == 1:
        scene.chains[0].law = lm.ElasticWire(stiffness=1e3 + k)
    if k == 41:
        scene.set_law("GRAIN", "GRAIN", lm.Coulomb(friction=0.9))
        scene.chains[0].reference_gap = 0.05


@pytest.mark.long
@pytest.mark.parametrize("first", [15, 20, 30, 41])
def test_a_run_goes_on_with_the_laws_that_were_set(tmp_path, first):
    """Bit for bit, also from the step in which they were set; a scene of an earlier frame has those of then."""
    whole = bumps().run(steps=60, on_step=changing)
    bumps().run(steps=first, record=tmp_path / "run.h5", every=5, on_step=changing)
    again = lm.resume(tmp_path / "run.h5").run(steps=60 - first, on_step=changing)
    np.testing.assert_array_equal(again.state.positions, whole.state.positions)
    np.testing.assert_array_equal(again.state.velocities, whole.state.velocities)
    assert again.energy == whole.energy
    assert again.scene.rows == whole.scene.rows
    assert again.scene.chains[0].law == lm.ElasticWire(stiffness=1e3 + 51)
    early = lm.Scene.from_run(tmp_path / "run.h5", 10)
    assert early.rows[1][2] == lm.Coulomb(friction=0.3)
    assert early.chains[0].law == lm.ElasticWire(stiffness=1e3 + 1)
    late = lm.Scene.from_run(tmp_path / "run.h5", 60)
    assert late.rows[0][2] == lm.Restitution(restitution=0.8, friction=0.1)
    assert late.rows[1][2] == lm.Coulomb(friction=0.9)


def test_a_restore_goes_back_to_the_laws_of_its_checkpoint():
    sim = bumps()
    sim.run(steps=18, on_step=changing)
    checkpoint = sim.checkpoint()
    sim.run(steps=30, on_step=changing)
    positions, energy = sim.positions.copy(), repr(vars(sim.energy))
    sim.restore(checkpoint)
    assert sim.scene.rows[0][2] == lm.Restitution(restitution=0.2, friction=0.3)
    sim.run(steps=30, on_step=changing)
    np.testing.assert_array_equal(sim.positions, positions)
    assert repr(vars(sim.energy)) == energy


def test_what_is_refused_changes_nothing():
    sim = bumps()
    sim.run(steps=2)
    scene, chain = sim.scene, sim.scene.chains[0]
    rows, law = scene.rows, chain.law
    rolling = lm.Coulomb
    wrong = [
        (lambda: scene.set_law("GRAIN", "GRAIN", lm.Restitution(restitution=0.2, friction=0.1)), TypeError, "same class"),
        (lambda: scene.set_law("GRAIN", "GRAIN", 0.3), TypeError, "takes a law"),
        (lambda: scene.set_law("GRAIN", "GRAIN", lm.ElasticWire(stiffness=1.0)), TypeError, "is for a link"),
        (lambda: scene.set_law("BEAD", "WALL", rolling(friction=0.1)), LookupError, "does not see"),
        (lambda: setattr(chain, "law", lm.RigidWire()), TypeError, "same class"),
        (lambda: setattr(chain, "law", None), TypeError, "same class"),
    ]
    for statement, error, words in wrong:
        with pytest.raises(error, match=words):
            statement()
    assert scene.rows == rows
    assert chain.law is law
    assert sim.state.changes == []
    assert not sim.state.stale


def test_rolling_components_neither_come_nor_go_between_steps():
    class Sometimes(lm.RollingCoulomb):
        NAME = "rolls-sometimes"

        def rows(self, dimension):
            return super().rows(dimension) if self.rolling_friction > 0.0 else dimension

    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(1.0, 0.0), spin=-10.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", Sometimes(friction=0.5, rolling_friction=0.01))
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=5)
    with pytest.raises(ValueError, match="another number of rolling components"):
        scene.set_law("GRAIN", "WALL", Sometimes(friction=0.5, rolling_friction=0.0))
    before = sim.velocities[0, 0]
    scene.set_law("GRAIN", "WALL", Sometimes(friction=0.5, rolling_friction=0.02))
    sim.run(steps=5)
    # deceleration of rolling: g e / (1 + I / m R^2), twice the coefficient, twice as much
    assert before - sim.velocities[0, 0] == pytest.approx(2.0 * (1.0 - before), rel=1e-6)


# ------------------------------------------------------------------------------------------------------- laws of links


@pytest.mark.long
@pytest.mark.parametrize("law", [lm.ElasticRod, lm.ElasticWire])
def test_a_spring_that_is_made_stiffer_is_given_energy(law):
    """``(k' - k) s^2 / 2`` at the stretch s, and swings with its new frequency from then on, where it is not thrown up;
    nothing is made out of nothing."""
    h = 2e-4
    sim, chain, load = rope(law(stiffness=1e4), LENGTH - 0.06, time_step=h)
    sim.run(duration=0.05)
    stretch = -load.position[1] - LENGTH
    chain.law = law(stiffness=4e4)
    sim.step()
    assert sim.energy.by_hand == pytest.approx(0.5 * 3e4 * stretch**2, rel=0.02)  # s is that of the next detection
    places = []
    for _ in range(800):
        sim.step()
        places.append(load.position[1])
    assert sim.energy.made <= 1e-9 * sim.energy.turned
    if law is lm.ElasticRod:
        highest = np.flatnonzero(np.diff(np.sign(np.diff(places))) < 0)
        assert highest[1] - highest[0] == pytest.approx(2.0 * math.pi * math.sqrt(MASS / 4e4) / h, abs=1.0)


def test_links_keep_parameters_of_their_own():
    """What ``parameters`` gave each link stays; those that all share are set."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.01, position=(0.1 * k, 0.0), mass=1.0)).fix() for k in range(3)]
    beads[2].impose_velocity(x=0.1)
    beads[1].impose_velocity(x=0.05)
    chain = scene.chain(beads, lm.VoigtRod(stiffness=1e3, viscosity=1.0), parameters={"viscosity": [1.0, 2.0]})
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=10)
    chain.law = lm.VoigtRod(stiffness=2e3, viscosity=5.0)
    sim.run(steps=10)
    stretch = 0.05 * 20.5e-3
    np.testing.assert_allclose(-sim.interactions.force[:, 0], 2e3 * stretch + 0.05 * np.array([1.0, 2.0]), rtol=1e-9)
