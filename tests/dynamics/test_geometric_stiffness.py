"""Geometric stiffness of taut links: where it is, that it is stable at any step, and what it leaves alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

DIMENSIONS = pytest.mark.parametrize("dimension", [2, 3])


def vector(dimension: int, x: float, y: float) -> tuple[float, ...]:
    """A vector in the plane of x and of what points upward."""
    return (x, y) if dimension == 2 else (x, 0.0, y)


def ball(dimension: int, radius: float, x: float, y: float, mass: float, speed=(0.0, 0.0)):
    """A disk or a sphere."""
    make = lm.disk if dimension == 2 else lm.sphere
    return make(radius=radius, position=vector(dimension, x, y), mass=mass, velocity=vector(dimension, *speed))


def jerked(dimension: int, load: float, time_step: float, **options) -> lm.Simulation:
    """Twenty links of 0.0101 m over 0.2 m, beads of 1 g and a load in the middle, which falls until they are taut."""
    scene = lm.Scene(dimension=dimension, gravity=vector(dimension, 0.0, -9.81))
    for i in range(21):
        scene.add(ball(dimension, 0.002, 0.01 * i, 0.0, load if i == 10 else 1e-3))
    scene.bodies[0].fix()
    scene.bodies[-1].fix()
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.0101 - 0.004)
    return lm.Simulation(scene, time_step=time_step, **options)


def wire_length(sim: lm.Simulation) -> float:
    return float(np.linalg.norm(np.diff(sim.positions, axis=0), axis=1).sum())


# ------------------------------------------------------------------------------------------------- a jerked wire


@pytest.mark.default_parameters("0.002-0.001", "0.002-1000.0")
@pytest.mark.filterwarnings("ignore:Until t")  # up to 11 % of the energy, which a run tells
@pytest.mark.filterwarnings("ignore:In the step.*jerk without rebound")
@pytest.mark.parametrize("load", [1e-3, 1.0, 100.0, 1e3])
@pytest.mark.parametrize("time_step", [2e-3, 1e-3, 5e-4, 2.5e-4])
def test_a_jerked_wire_stays_as_long_as_it_is(load, time_step):
    """Mass ratios of 1 to 1e6. Geometry: half the wire of 0.202 m over 0.1 m lets the load fall to 14.2 mm.

    What links turn in a step stretches them by Pythagoras, ``(h u_t)^2 / (2 l)``. The load falls at sqrt(2 g 0.0142) =
    0.53 m/s, and beads that are thrown taut move twice as fast: 5.5e-5 m of a link of 0.0101 m at 1 ms, in the few links
    that turn. A thousandth of the wire at 1 ms, 2e-4 m, and in proportion to h, is allowed; the load hangs no lower
    than this length lets it. A wire makes at most a hundredth of its bodies' energy in a step
    (turning_stretch.py), for three steps.
    """
    sim = jerked(2, load, time_step)
    lowest, longest, made, least = 0.0, 0.0, 0.0, 0.0
    for _ in range(round(0.3 / time_step)):
        assert sim.step().status == "converged"
        lowest, longest = min(lowest, sim.positions[10, -1]), max(longest, wire_length(sim))
        work = sum(sim.energy.total_interactions.values())
        least = min(least, work)
        made = max(made, work - least)
    assert longest <= 0.202 * (1.0 + time_step)
    assert -lowest <= math.sqrt((0.5 * longest) ** 2 - 0.1**2) * (1.0 + 1e-9)
    depth = math.sqrt(0.101**2 - 0.1**2)
    assert made <= 0.03 * (load + 19e-3) * 9.81 * depth  # without the term 9 times all of it


@pytest.mark.filterwarnings("ignore:In the step", "ignore:Until t")
def test_without_it_the_wire_stretches():
    """The motion is chaotic: loads that differ by 1e-12 give 0.32 to 0.36 m.

    The warnings of the run are tested in test_stretch_and_energy_watch.py.
    """
    sim = jerked(2, 1.0, 1e-3, geometric_stiffness=False)
    longest = 0.0
    for _ in range(300):
        sim.step()
        longest = max(longest, wire_length(sim))
    assert longest > 0.25
    assert not np.any(sim.interactions.impulse[:, 1:])


@pytest.mark.filterwarnings("ignore:In the step.*jerk without rebound")
@pytest.mark.long
def test_a_wire_in_space_does_as_in_the_plane():
    """The same bits are not asked for: sums over three components round otherwise, and a jerk forgets nothing."""
    plane, space = (jerked(dimension, 1.0, 1e-3) for dimension in (2, 3))
    plane.run(steps=65)
    space.run(steps=65)
    np.testing.assert_allclose(space.positions[:, [0, 2]], plane.positions, rtol=0.0, atol=1e-9)
    assert not space.positions[:, 1].any()


# ----------------------------------------------------------------------------------------------------- stability


@pytest.mark.default_parameters("0.5-2", "3.9-2")
@DIMENSIONS
@pytest.mark.parametrize("s", [0.5, 1.9, 2.1, 3.9, 4.1, 10.0, 1e3, 1e6])
def test_small_motion_across_a_taut_wire_never_grows(dimension, s):
    """A straight wire of beads under a tension T with s = 4 h^2 T / (m l), beads thrown at random; 400 steps.

    Where s <= 2 it is the leapfrog that it was, which swings for ever; from s = 4 on the leapfrog grows by the step. The
    largest displacement of a leapfrog in its range is that of the motion times 1/sqrt(1 - s/4): 1.4 at s = 2. What the
    solver leaves, 1e-12 of the velocity h T / m that the tension would give, is an error of a step's displacement.
    """
    count, length, h, mass = 10, 0.1, 1e-2, 1e-3
    tension = s * mass * length / (4.0 * h**2)
    rng = np.random.default_rng(5)
    scene = lm.Scene(dimension=dimension)
    for i in range(count + 1):
        scene.add(ball(dimension, 0.01, length * i, 0.0, mass, (0.0, 1e-6 * rng.standard_normal())))
    scene.bodies[0].fix()
    end = scene.bodies[-1]
    end.impose_velocity(**{("y" if dimension == 2 else "z"): 0.0})
    end.impose_force(x=tension)
    scene.chain(scene.bodies, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=h, solver=lm.GaussSeidel(tolerance=1e-12), on_unconverged="ignore")
    largest = 0.0
    for _ in range(400):
        sim.step()
        largest = max(largest, float(np.abs(sim.positions[:, -1]).max()))
    slowest = 2.0 * math.sqrt(tension / (mass * length)) * math.sin(0.5 * math.pi / count)
    free = 3e-6 * min(1.0 / slowest, 400 * h)  # thrown at three sigma, and never more at once than that
    assert 0.0 < largest <= 10.0 * (free + h * 1e-12 * h * tension / mass)
    stiffened = bool(np.any(sim.interactions.impulse[:, 1:]))
    assert stiffened == (s > 2.0 * 1.01)


@pytest.mark.filterwarnings("ignore:Until t = .* waves of the wire")  # steps of the string's period and more
@pytest.mark.default_parameters("blocks-0.05-2", "single-0.01-2")
@DIMENSIONS
@pytest.mark.parametrize("time_step", [0.05, 0.01, 1e-3])
@pytest.mark.parametrize("blocks", [True, False], ids=["blocks", "single"])
def test_beads_held_along_a_string_move_across_it_as_free_ones(dimension, time_step, blocks):
    """Along the links nothing can move, so that W_nn = 0; the tension is the one of the springs from the first step on.
    (With the rows across left out, or the tension known only after the step, the first step was locked, and places
    were off by a sixth to nine tenths at 10 and 50 ms.) Single updates of free beads are solved to the tolerance only."""

    def places(held: bool, solver: object) -> np.ndarray:
        scene = lm.Scene(dimension=dimension, gravity=(0.0,) * dimension)
        for i in range(13):
            speed = (0.0, 1e-3) if i == 4 else (0.0, 0.0)
            bead = scene.add(ball(dimension, 0.005, i / 12, 0.0, 0.01, speed))
            if i in (0, 12):
                bead.fix()
            elif held:
                bead.fix("x")
        scene.chain(scene.bodies, lm.ElasticWire(stiffness=1e4), reference_gap=1 / 12 - 0.01 - 1e-3)
        sim = lm.Simulation(scene, time_step=time_step, solver=solver)
        found = []
        for _ in range(min(40, round(0.2 / time_step))):  # steps of 50 ms leave 1e-10 of the motion after six
            sim.step()
            assert sim.report.solved
            found.append(sim.positions[:, -1 if dimension == 3 else 1].copy())
        return np.array(found)

    free = places(False, lm.GaussSeidel())
    held = places(True, lm.GaussSeidel(wire_blocks=blocks))
    assert np.abs(held - free).max() < (1e-3 if blocks else 0.05) * np.abs(free).max()


def test_it_is_off_where_a_link_is_pressed():
    """A rod under compression buckles, and nothing across it is damped."""
    scene = lm.Scene(dimension=2)
    for i in range(5):
        scene.add(lm.disk(radius=0.01, position=(0.1 * i, 1e-6 * (i % 2)), mass=1e-3))
    scene.bodies[0].fix()
    scene.bodies[-1].impose_force(x=-1e3)
    scene.chain(scene.bodies, lm.RigidRod())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-9))
    for _ in range(2):
        sim.step()
        impulse = sim.interactions.impulse
        assert (impulse[:, 0] > 0.0).any()
        assert not impulse[impulse[:, 0] >= 0.0, 1].any()


@pytest.mark.filterwarnings("ignore:Until t")  # up to 11 % of the energy, which a run tells
@pytest.mark.filterwarnings("ignore:In the step.*jerk without rebound")
@pytest.mark.long
@pytest.mark.default_parameters("2")
@DIMENSIONS
def test_a_net_of_wires_under_a_load_holds(dimension):
    """Nodes of two wires, four links each: the share of a node's mass is a quarter. Thrown at random, it comes to rest.

    Number: the load hangs on a straight wire of four links and two crossed ones; it may not leave its geometry.
    """
    count, length = 9, 0.02
    scene = lm.Scene(dimension=dimension, gravity=vector(dimension, 0.0, -9.81))
    rng = np.random.default_rng(2)
    row = [scene.add(ball(dimension, 0.004, length * i, 0.0, 1e-4)) for i in range(count)]
    middle = row[count // 2]
    column = [scene.add(ball(dimension, 0.004, middle.position[0], -length * k, 1e-4)) for k in range(1, 4)]
    load = scene.add(ball(dimension, 0.004, middle.position[0], -4.0 * length, 10.0, (0.3 * rng.standard_normal(), 0.0)))
    row[0].fix()
    row[-1].fix()
    scene.chain(row, lm.RigidWire(), reference_gap=1.02 * length - 0.008)
    scene.chain([middle, *column, load], lm.RigidWire(), reference_gap=length - 0.008)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8)).run(steps=600)
    half = 0.5 * (count - 1) * length
    sag = half * math.sqrt(1.02**2 - 1.0)
    assert sim.unconverged_steps == 0
    assert -sim.positions[-1, -1] <= (sag + 4.0 * length) * 1.01  # a jerk's stretch of second order
    lengths = np.linalg.norm(np.diff(sim.positions[:count], axis=0), axis=1)
    assert lengths.max() <= 1.02 * length * 1.01


# ------------------------------------------------------------------------------------------- what it leaves alone


def turning_string(time_step: float, dimension: int) -> tuple[lm.Simulation, float]:
    """Two bodies of 1 kg on a wire of beads of 0.1 g, which turn about each other at 10 rad/s; and the turn's momentum."""
    omega, length = 10.0, 0.02
    scene = lm.Scene(dimension=dimension)
    for i in range(11):
        x = length * (i - 5)
        scene.add(ball(dimension, 0.004, x, 0.0, 1.0 if i in (0, 10) else 1e-4, (0.0, omega * x)))
    scene.chain(scene.bodies, lm.RigidWire())
    return lm.Simulation(scene, time_step=time_step), angular_momentum(scene)


def angular_momentum(scene: lm.Scene) -> float:
    """About the origin, in the plane of x and of what points upward [kg m^2/s]."""
    return sum(
        (1.0 if body.id in (0, len(scene.bodies) - 1) else 1e-4)
        * (body.position[0] * body.velocity[-1] - body.position[-1] * body.velocity[0])
        for body in scene.bodies
    )


# a free net


def thrown_apart(dimension: int, seed: int, ratio: float) -> lm.Simulation:
    """A free chain in the plane, a free membrane in space, of 16 nodes that part at 4 m/s: each jerk turns it."""
    rng = np.random.default_rng(seed)
    scene, length = lm.Scene(dimension=dimension), 0.02
    masses = 0.01 * ratio ** rng.uniform(0.0, 1.0, 16)
    for k, mass in enumerate(masses.tolist()):
        place = (length * k, 0.0) if dimension == 2 else (length * (k % 4), length * (k // 4), 0.0)
        make = lm.disk if dimension == 2 else lm.sphere
        scene.add(make(radius=1e-3, position=place, mass=mass, velocity=rng.normal(0.0, 4.0, dimension)))
    if dimension == 2:
        scene.chain(scene.bodies, lm.RigidWire())
    else:
        corners = [(a, a + 1, a + 5) for a in range(12) if a % 4 < 3] + [(a, a + 5, a + 4) for a in range(12) if a % 4 < 3]
        scene.membrane(scene.bodies, corners, lm.RigidWire(), radius=1e-3)
    return lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9), overlap="ignore")


@pytest.mark.filterwarnings("ignore:In the step")  # bodies that move by half a radius, jerks
@DIMENSIONS
@pytest.mark.parametrize(("seed", "ratio"), [(1, 1.0), pytest.param(1, 1e3, marks=pytest.mark.long)])
def test_a_free_net_that_is_jerked_keeps_its_angular_momentum(dimension, seed, ratio):
    """The couple of the impulses across links is at most 1e-4 of tensions times lengths. With the rotation from before the
    jerk the first step alone changes the momentum of these nets by 1 to 10 %. In a later jerk stretch is taken back by
    displacements w beside the mean velocities, which change it by ``sum m w x v``: lmgcpy/dynamics/turning_stretch.py."""
    sim = thrown_apart(dimension, seed, ratio)
    mass = np.array([body.mass for body in sim.scene.bodies])[:, None]
    energies = []
    for k in range(5):
        start, speed = sim.positions.copy(), sim.velocities.copy()
        before = momentum_about(start, speed, mass)
        sim.step()
        moved = sim.positions - start - 0.5 * sim.time_step * (speed + sim.velocities)
        pushed = momentum_about(start + moved, sim.velocities, mass) - momentum_about(start, sim.velocities, mass)
        after = momentum_about(sim.positions, sim.velocities, mass) - (pushed if k else 0.0)
        found = sim.interactions
        tensions = float((np.abs(found.impulse[:, 0]) * (found.gap + 2e-3)).sum())
        assert np.linalg.norm(after - before) <= 1e-4 * tensions + 1e-12 * np.linalg.norm(before)
        energies.append(float((mass * sim.velocities**2).sum()))
    # links that turn give back what they took, up to a hundredth: lmgcpy/dynamics/turning_stretch.py
    assert np.all(np.diff(energies) <= 0.01 * energies[0])


def momentum_about(positions: np.ndarray, velocities: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Angular momentum about the centre of mass [kg m^2/s]."""
    arm = positions - (mass * positions).sum(axis=0) / mass.sum()
    momentum = mass * velocities
    if positions.shape[1] == 2:
        return np.array([float((arm[:, 0] * momentum[:, 1] - arm[:, 1] * momentum[:, 0]).sum())])
    result: np.ndarray = np.cross(arm, momentum).sum(axis=0)
    return result


@pytest.mark.long
@DIMENSIONS
def test_a_spinning_wire_keeps_its_momentum(dimension):
    """kappa l^2 is an inertia that comes and goes with the tension: of the moment of inertia it is (h omega)^2 at most,
    here 1.6e-3 to 1e-4. The dashpot that takes u_t as it is would lose h omega^2 a second, a tenth of it at 1 ms. With the
    rotation at the end a small part of the couple is left (measured: 1e-6, 2e-7 and 2e-7)."""
    for h in (4e-3, 2e-3, 1e-3):
        sim, start = turning_string(h, dimension)
        sim.run(duration=1.0)
        assert np.any(sim.interactions.impulse[:, 1:])
        assert abs(angular_momentum(sim.scene) / start - 1.0) <= 2e-6


@pytest.mark.long
def test_the_momentum_of_a_spinning_wire_does_not_drift():
    """1e5 steps, 160 turns: the bound of the test above, from beginning to end."""
    sim, start = turning_string(1e-3, 2)
    for _ in range(100):
        sim.run(steps=1000)
        assert abs(angular_momentum(sim.scene) / start - 1.0) <= 1e-6


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:Until t = .* waves of the wire")  # at the first pull s = 4 h^2 T/(m l) is 3.8
@pytest.mark.default_parameters("2")
@DIMENSIONS
def test_a_pendulum_on_a_light_wire_keeps_its_energy(dimension):
    """1 kg on ten links with beads of 0.1 g, five seconds at 1 ms: (h Omega)^2 = 1e-5 is its bound, Omega^2 = g/L."""
    scene = lm.Scene(dimension=dimension, gravity=vector(dimension, 0.0, -9.81))
    for i in range(11):
        scene.add(ball(dimension, 0.01, 0.1 * i * math.sin(0.3), -0.1 * i * math.cos(0.3), 1.0 if i == 10 else 1e-4))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=5.0)
    assert np.any(sim.interactions.impulse[:, 1:])
    made = sum(sim.energy.total_interactions.values())
    assert abs(made) <= 1e-5 * 9.81 * (1.0 - math.cos(0.3)) * 1.001


@pytest.mark.filterwarnings("ignore:In the step.*jerk without rebound")
def test_the_energy_identity_closes_with_it():
    sim = jerked(2, 100.0, 1e-3)
    turned = 0.0
    for _ in range(150):
        sim.step()
        energy = sim.energy
        turned = max(turned, energy.kinetic, abs(energy.loads), abs(sum(energy.interactions.values())))
        assert abs(energy.defect) <= 1e-12 * turned  # round-off of impulses of 1e2 N s on 1e-3 kg


@pytest.mark.filterwarnings("ignore:In the step.*jerk without rebound")
def test_a_recorded_run_is_resumed_to_the_last_bit(tmp_path):
    """kappa comes from the impulses that are remembered."""
    whole = jerked(2, 1.0, 1e-3).run(steps=80)
    jerked(2, 1.0, 1e-3).run(steps=60, record=tmp_path / "run.h5")
    sim = lm.resume(tmp_path / "run.h5").run(steps=20)
    np.testing.assert_array_equal(sim.positions, whole.positions)
    np.testing.assert_array_equal(sim.velocities, whole.velocities)


def test_it_is_said_to_be_on_or_off():
    with pytest.raises(TypeError, match="geometric_stiffness must be True or False"):
        jerked(2, 1.0, 1e-3, geometric_stiffness=1)


@pytest.mark.parametrize("tension", [1e6, 1e12, 1e15])
def test_self_stresses_do_not_stiffen_beyond_the_rounding(tension):
    """The kappa that a tension calls for, h T/l - 2/P of impulses T, up to 1e10/P: tensions of an unsolved step may
    be anything, and with kappa P beyond 1/eps the velocities of the next turn were lost to round-off."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.01, position=(0.1 * i, 0.0), mass=0.05)) for i in range(3)]
    scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    links = sim._links
    impulse = np.array([[-tension, 0.0], [-tension, 0.0]])
    kappa = links.stiffness(impulse, sim.interactions.gap, 1e-3)
    asked = 1e-3 * tension * links.share / 0.1 - 2.0
    assert kappa * links.share == pytest.approx(np.minimum(asked, 1e10), rel=1e-6)
