"""Moves that are far for one step: contacts are seen in time where that costs little, and the run says it."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.watch.displacements import rounded_down

R = 0.01
H = 1e-3
LAW = lm.Signorini()


def sentences(sim, steps):
    """What the simulation says in so many steps."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sim.run(steps=steps)
    return [str(warning.message) for warning in told]


def layer_below(lid, *, count=4, dimension=2):
    """Free grains of 1 kg side by side, not touching, under a wall with its normal down; gravity does not act."""
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    for i in range(count):
        place = np.zeros(dimension)
        place[0] = 2.5 * R * i
        scene.add(make(radius=R, position=place, mass=1.0))
    scene.add(lid)
    scene.see("GRAIN", "WALL", LAW)
    return scene


def lid_at(height, *, dimension=2, **wall):
    up = np.eye(dimension)[-1]
    return lm.wall(point=height * up, normal=-up, **wall)


def depth(scene):
    """How far the highest grain is in the wall, in radii."""
    grains = [body.position[-1] for body in scene.bodies[:-1]]
    return (max(grains) + R - scene.bodies[-1].position[-1]) / R


# ------------------------------------------------------------------------------------------------------------- walls


@pytest.mark.default_parameters(speed=(10.1, 300.0), height=(0.3,))
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("height", [0.3, 1.5, 2.0, 7.3, 20.0])
@pytest.mark.parametrize("speed", [1.0, 4.9, 9.9, 10.1, 30.0, 100.0, 300.0])
def test_a_driven_wall_never_enters_what_it_sees(dimension, height, speed):
    """From rest to up to 30 radii a step. A plane's gap is linear in the velocities, so that the step in which it meets the
    grains is exact. Where the alert distance had the same bound for walls and grains, it ran 5.6 radii into grains.

    It is told from 10 m/s on, a radius in a step, and said once; the grains, which it takes along, from half of that on.
    """
    axis = "xyz"[dimension - 1]
    lid = lid_at((1.0 + height) * R, dimension=dimension)
    lid.impose_velocity(**{axis: lambda time: -speed if time > 0.0 else 0.0})
    scene = layer_below(lid, dimension=dimension)
    sim = lm.Simulation(scene, time_step=H)
    told = sentences(sim, 3 + math.ceil(25.0 * R / (speed * H)))
    assert depth(scene) == pytest.approx(0.0, abs=1e-6)  # the tolerance of the step, 1e-4 of what it closes or less
    walls = [sentence for sentence in told if " wall " in sentence]
    assert len(walls) == (speed * H > R)
    assert len(told) == len(walls) + (speed * H > 0.5 * R)
    if walls:
        assert f"wall 4 moves by {speed * H:.3g} m" in walls[0]
        assert f"the smallest radius it meets, {R:.3g} m" in walls[0]
        assert f"At this speed a time step of {rounded_down(R / speed)} s would do. (Said once.)" in walls[0]


@pytest.mark.default_parameters(force=(1e2, 1e4, 1e6), drop=(0.1, 10.0))
@pytest.mark.parametrize("drop", [0.1, 0.5, 2.0, 10.0])
@pytest.mark.parametrize("force", [1e2, 1e3, 1e4, 1e5, 1e6])
def test_a_light_piston_gets_its_speed_within_the_step_and_stops_on_the_grains(force, drop):
    """A lid of 1 kg under a load falls onto grains that are held: at 1e6 N it would move by 100 radii in its first
    step, and ran that far through the grains, unsaid."""
    lid = lid_at((1.0 + drop) * R, mass=1.0)
    lid.impose_force(y=-force)
    scene = layer_below(lid)
    for body in scene.bodies[:-1]:
        body.fix("x", "y")
    sim = lm.Simulation(scene, time_step=H, on_unconverged="stop")
    told = sentences(sim, 40)
    assert depth(scene) < 1e-6
    moved = drop * R if force * H**2 > drop * R else None
    if moved is not None:  # it lands in its first step
        assert len(told) == (moved > R)


def test_a_piston_that_is_held_up_is_not_told_and_sees_no_more_than_it_did():
    """Its load would move it by 100 radii in a step, but the grains below hold it: nothing moves, nothing is far."""
    lid = lid_at(R, mass=1.0)
    lid.impose_force(y=-1e6)
    scene = layer_below(lid)
    for grain in scene.bodies[:3]:
        grain.fix()
    below = scene.bodies[3]
    below.fix("x")
    below.position[1] = -5.0 * R
    sim = lm.Simulation(scene, time_step=H)
    assert sentences(sim, 20) == []
    assert sim.interactions.candidate.tolist() == [0, 1, 2]
    assert abs(depth(scene)) < 1e-9


def test_a_wall_that_slides_in_itself_moves_nothing():
    """A belt at 300 m/s under resting grains: no word, and no grain far from it becomes an interaction.

    The grain 20 radii above is beyond the alert distance, which is at most the largest radius.
    """
    scene = lm.Scene(dimension=2)
    for height in (R, 20 * R):
        scene.add(lm.disk(radius=R, position=(0.0, height), mass=1.0)).fix("x")
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(x=300.0)
    scene.see("GRAIN", "WALL", LAW)
    sim = lm.Simulation(scene, time_step=H)
    assert sentences(sim, 5) == []
    assert sim.interactions.candidate.tolist() == [0]


@pytest.mark.long
def test_a_cylinder_counts_across_its_axis():
    for axis, count in ((0, 1), (2, 0)):
        scene = lm.Scene(dimension=3)
        scene.add(lm.sphere(radius=R, position=(0.0, 0.0, 0.0), mass=1.0))
        drum = scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=30 * R))
        drum.impose_velocity(**{"xyz"[axis]: 100.0})
        scene.see("GRAIN", "WALL", LAW)
        assert len(sentences(lm.Simulation(scene, time_step=H), 2)) == count


def test_a_run_with_a_fast_wall_goes_on_bit_for_bit():
    """The list that holds all that a wall sees is made again from a checkpoint."""

    def fast():
        lid = lid_at(20.0 * R).impose_velocity(y=-30.0)
        return lm.Simulation(layer_below(lid), time_step=H, solver=lm.GaussSeidel())

    whole, other, again = fast(), fast(), fast()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole.run(steps=12)
        other.run(steps=5)
        again.restore(other.checkpoint())
        again.run(steps=7)
    assert whole.positions.tobytes() == again.positions.tobytes()
    assert whole.velocities.tobytes() == again.velocities.tobytes()
    assert whole.interactions.impulse.tobytes() == again.interactions.impulse.tobytes()


# ------------------------------------------------------------------------------------------------ bodies that spin


@pytest.mark.default_parameters("0.0-60.0-1.0")
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("spin", [10.0, 30.0, 60.0, 80.0, 100.0, 150.0])
@pytest.mark.parametrize("outside", [0.0, 1.0, 1.5, 1.8])
def test_contactors_off_the_centre_of_a_spinning_body_are_seen_in_time(spin, outside, theta):
    """A dumbbell, 0.2 m to each disk, swings its disks by up to 3 radii a step at 20 resting ones on and beside the track.

    The track of the disk curves: within a step of angle a the disk is off the straight line by arm a^2/2 at most, 0.0023 m
    at 150 rad/s, across its way. With alert distances that took no account of the spin up to 12 of the 20 were missed and
    contacts began 1.9 radii deep.
    """
    arm, deepest = 0.2, 0.0
    for k in range(20):
        scene = lm.Scene(dimension=2)
        ends = [(lm.DiskContactor(R), (x, 0.0)) for x in (-arm, arm)]
        scene.add(lm.RigidBody(ends, mass=1.0, inertia=1.0, position=(0, 0), spin=spin, color="ARM")).fix("x", "y")
        angle, distance = 0.5 + k / 20 * spin * H, arm + outside * R
        place = (distance * math.cos(angle), distance * math.sin(angle))
        resting = scene.add(lm.disk(radius=R, position=place, mass=0.01, color="REST"))
        scene.see("ARM", "REST", LAW)
        sim = lm.Simulation(scene, time_step=H, theta=theta)
        told = sentences(sim, 1)
        assert bool(told) == (spin * arm * H > 0.5 * R)
        if told:
            assert f"a contactor of body 0 moves by {spin * arm * H:.3g} m, more than half its radius of 0.01 m" in told[0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(math.ceil(0.7 / (spin * H))):
                sim.step()
                acting = sim.interactions.impulse[:, 0] > 0.0
                deepest = max(deepest, *(-sim.interactions.gap[acting]), 0.0)
        assert np.abs(resting.velocity).max() > 0.0, f"target {k} was missed"
    assert deepest < 0.5 * arm * (spin * H) ** 2


def test_a_body_that_does_not_turn_has_the_alert_distances_of_before():
    """Spin of a disk about its own centre moves no surface towards anything."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0, spin=1e4))
    scene.add(lm.disk(radius=R, position=(0.0, 2.5 * R), mass=1.0))
    scene.see("GRAIN", "GRAIN", LAW)
    sim = lm.Simulation(scene, time_step=H)
    assert sentences(sim, 2) == []
    assert len(sim.interactions) == 0


# ---------------------------------------------------------------------------------------------- bodies among others


@pytest.mark.parametrize(("speed", "told"), [(1.9, False), (2.1, True)])
def test_the_smaller_radius_counts(speed, told):
    """A ball of 0.1 m meets grains of 2 mm: from 2 m/s on it moves by theirs in a step of 1 ms."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.2), mass=1.0, color="BALL", velocity=(0.0, -speed)))
    scene.add(lm.disk(radius=0.002, position=(0.0, 0.0), mass=1.0))
    scene.see("BALL", "GRAIN", LAW)
    said = sentences(lm.Simulation(scene, time_step=H), 3)
    assert len(said) == told
    if told:
        assert "body 0 moves by 0.0021 m, more than the smallest radius it meets, 0.002 m" in said[0]


def test_nobody_is_told_of_who_meets_nobody():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0, color="GHOST", velocity=(1e3, 0.0)))
    scene.add(lm.disk(radius=R, position=(0.0, 1.0), mass=1.0))
    scene.add(lm.wall(point=(0.0, -1.0), normal=(0, 1), color="GHOST"))
    scene.see("GRAIN", "GRAIN", LAW)
    assert sentences(lm.Simulation(scene, time_step=H), 3) == []


def test_a_light_body_under_a_load_is_stopped_by_what_it_would_have_passed():
    """From rest, 1e5 N move 1 kg by 0.1 m in the first step, through a held disk half a radius away, which nobody saw."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=R, position=(0.0, 2.5 * R), mass=1.0)).impose_force(y=-1e5)
    scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    scene.see("GRAIN", "GRAIN", LAW)
    sim = lm.Simulation(scene, time_step=H)
    assert sentences(sim, 10) == []
    assert sim.positions[0, 1] == pytest.approx(2.0 * R, abs=1e-9)


# ---------------------------------------------------------------------------------------------------- bodies in links


def pendulum(speed, law):
    """A bob that nobody sees on a link of 0.1 m."""
    scene = lm.Scene(dimension=2)
    hook = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    bob = scene.add(lm.disk(radius=R, position=(0.0, -0.1), mass=1.0, velocity=(speed, 0.0)))
    scene.chain([hook, bob], law)
    return lm.Simulation(scene, time_step=H)


@pytest.mark.default_parameters("law0", "law1")
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire(), lm.ElasticRod(stiffness=1e6)])
def test_a_link_that_turns_too_far_in_a_step_is_told(law):
    """Twice its length in a step of 1 ms are 200 m/s; its bodies' radius of 10 mm, which 10 m/s are, does not matter."""
    # that an elastic link ends longer than its law predicts is told as well
    slower, said = ([told for told in sentences(pendulum(v, law), 1) if "move by" in told] for v in (190.0, 210.0))
    assert slower == []
    assert len(said) == 1
    assert "bodies 0 and 1 move by 0.21 m relative to each other" in said[0]
    assert "more than twice the length of their link, 0.1 m" in said[0]
    assert "At this speed a time step of 0.00023 s would do" in said[0]


def test_a_wire_that_flies_as_one_is_not_told():
    scene = lm.Scene(dimension=2)
    places = [(0.03 * i, 0.0) for i in range(5)]
    beads = [scene.add(lm.disk(radius=R, position=place, mass=1.0, velocity=(0.0, 1e3))) for place in places]
    scene.chain(beads, lm.RigidWire())
    assert sentences(lm.Simulation(scene, time_step=H), 3) == []


def test_what_would_do_does():
    """Two digits are rounded down: at a step of 1 ms no step of 1 ms is advised."""
    found = [rounded_down(x) for x in (0.000999, 0.001, 1.999e-5, 0.5, 123.0)]
    assert found == ["0.00099", "0.001", "1.9e-05", "0.5", "1.2e+02"]
