"""Bodies that are driven into each other: no impulse keeps them apart, and a run says so."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import lmgcpy as lm

R, SPEED, H = 0.1, 1.0, 1e-3
TOUCH = 0.01
"""Gap at the start [m]."""


def two(kind, *, held=("x", "y"), target="held", speed=SPEED, see=True):
    """A round body over a wall or another body, driven down; ``held``: components of it that are driven besides."""
    dimension = 3 if kind == "sphere" else 2
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension)
    body = lm.sphere if dimension == 3 else lm.disk
    if kind == "wall":
        scene.add(lm.wall(point=0.0 * up, normal=up))
        distance = R
    else:
        other = scene.add(body(radius=R, position=0.0 * up, mass=1.0))
        if target == "held":
            other.fix()
        elif target == "driven":
            other.impose_velocity(**{"xyz"[dimension - 1]: 0.0})
        distance = 2.0 * R
    falling = scene.add(body(radius=R, position=(distance + TOUCH) * up, mass=1.0, color="TOOL"))
    falling.impose_velocity(**dict.fromkeys(held, 0.0) | {"xyz"[dimension - 1]: -speed})
    if see:
        scene.see("TOOL", "WALL" if kind == "wall" else "GRAIN", lm.Coulomb(friction=0.3))
    return scene


@pytest.mark.default_parameters(octaves=(0,))
@pytest.mark.parametrize("kind", ["wall", "disk", "sphere"])
@pytest.mark.parametrize("held", [(), ("x",)], ids=str)
@pytest.mark.parametrize("octaves", [-2, 0, 2])
def test_a_body_that_is_driven_into_a_held_one_is_told(kind, held, octaves):
    """Once, with the bodies, the time and the depth, when it is a hundredth of the radius, at any time step."""
    h = H * 2.0**octaves
    sim = lm.Simulation(two(kind, held=held), time_step=h)
    when = (TOUCH + 0.01 * R) / SPEED
    with pytest.warns(RuntimeWarning, match=r"body 1 \('TOOL'\) .*overlap by 0.00.* no impulse keeps them apart") as told:
        sim.run(duration=2.0 * when)
    assert len(told) == 1
    words = str(told[0].message)
    time = float(words.split("t = ")[1].split(" s")[0])
    assert when - 1e-9 <= time <= when + 1.01 * h
    depth = float(words.split("overlap by ")[1].split(" m")[0])
    assert depth == pytest.approx(SPEED * time - TOUCH, rel=1e-2)  # three digits are told


@pytest.mark.parametrize("target", ["driven", "free"])
def test_only_a_pair_that_nothing_keeps_apart_is_told(target):
    """A disk that is held along the normal alone does not yield; one that is free does, and is pushed on."""
    sim = lm.Simulation(two("disk", target=target), time_step=H)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sim.run(steps=20)
    assert len(told) == (target == "driven")


@pytest.mark.default_parameters("0-1000000.0")
@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e4, 1e6])
@pytest.mark.parametrize("heavy", [0, 1])
def test_free_bodies_of_any_mass_are_pushed_on_and_not_told(heavy, ratio):
    """A driven disk pushes two free ones, one of them ``ratio`` times as heavy as the other: nothing overlaps by a
    hundredth of a radius, both go at the speed of the drive, and nothing is said."""
    mass = [1.0, 1.0]
    mass[heavy] = ratio
    scene = lm.Scene(dimension=2)
    tool = scene.add(lm.disk(radius=R, position=(-2.0 * R - TOUCH, 0.0), mass=1.0, color="TOOL"))
    tool.impose_velocity(x=SPEED, y=0.0)
    for k in range(2):
        scene.add(lm.disk(radius=R, position=(k * (2.0 * R + TOUCH), 0.0), mass=mass[k]))
    scene.see("TOOL", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=H)
    for _ in range(60):
        sim.step()
        assert sim.interactions.gap.min(initial=0.0) > -0.01 * R
    np.testing.assert_allclose(sim.velocities[:, 0], SPEED, rtol=1e-4)


def test_silent_scenes():
    """Colours that do not see each other, bodies side by side that are driven alike, and what overlapped at the start."""
    pieces = two("wall", speed=0.0)
    wall = [lm.disk(radius=R, position=(0.15 * k, 1.0), mass=1.0, color="PIECE") for k in range(4)]
    for piece in wall:
        pieces.add(piece).fix().impose_velocity(y=-SPEED, x=0.3)
    pieces.see("PIECE", "PIECE", lm.Coulomb(friction=0.3))
    for scene in (two("wall", see=False), pieces):
        lm.Simulation(scene, time_step=H).run(steps=40)


def test_pieces_of_a_driven_wall_are_told_where_they_are_driven_into_each_other():
    """Of several pairs of the same colours the first is told, and no other."""
    scene = lm.Scene(dimension=2)
    for k in range(4):
        piece = scene.add(lm.disk(radius=R, position=(2.1 * R * k, 1.0), mass=1.0, color="PIECE"))
        piece.fix().impose_velocity(x=-SPEED * k)
    scene.see("PIECE", "PIECE", lm.Coulomb(friction=0.3))
    with pytest.warns(RuntimeWarning, match="no impulse keeps them apart") as told:
        lm.Simulation(scene, time_step=H).run(steps=40)
    assert len(told) == 1


def test_a_drive_that_is_stated_in_every_step_is_watched():
    """What overlaps when a statement is made is not forgotten by it; a body that is shown on another was not driven."""
    scene = two("disk", speed=0.0)
    tool = scene.bodies[1]
    ghost = scene.add(lm.disk(radius=R, position=(0.0, 0.05), mass=1.0, color="TOOL")).fix().hide()
    sim = lm.Simulation(scene, time_step=H)
    sim.run(steps=2)
    ghost.show()
    sim.run(steps=2)
    with pytest.warns(RuntimeWarning, match=r"body 1 \('TOOL'\)") as told:
        sim.run(steps=40, on_step=lambda sim: tool.impose_velocity(y=-SPEED * (1.0 + 0.1 * (sim.steps % 2))))
    assert len(told) == 1


def test_held_bodies_of_a_cell_that_shrinks_are_told():
    """They go with the cell: at a distance of (1 - e t) d they overlap by e t d - gap."""
    scene = lm.Scene(dimension=2)
    for x in (0.2, 0.45):
        scene.add(lm.disk(radius=R, position=(x, 0.5), mass=1.0)).fix()
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.periodic(x=1.0, y=1.0).impose_rate(xx=-1.0)
    sim = lm.Simulation(scene, time_step=H)
    when = np.log(0.25 / (0.2 - 0.01 * R))
    sim.run(duration=when - 2.0 * H)
    with pytest.warns(RuntimeWarning, match="no impulse keeps them apart"):
        sim.run(steps=5)


def test_a_scene_without_driven_bodies_makes_no_detector():
    """It pays nothing for the watch; nor does one whose driven walls see no held body."""
    for scene in (two("wall", speed=0.0), two("wall", see=False)):
        assert lm.Simulation(scene, time_step=H)._driven_overlaps._detector is None


@pytest.mark.parametrize("law", [lm.RigidWire(), lm.RigidRod()])
@pytest.mark.parametrize("beads", [2, 4])
def test_a_chain_whose_ends_are_driven_apart_is_told(law, beads):
    """A link without a free body is named; a longer chain is locked, which is said when it happens."""
    scene = lm.Scene(dimension=2)
    chain = [scene.add(lm.disk(radius=0.01, position=(0.1 * k, 0.0), mass=1.0)) for k in range(beads)]
    chain[0].fix()
    chain[-1].fix().impose_velocity(x=SPEED)
    scene.chain(chain, law)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        lm.Simulation(scene, time_step=H, solver=lm.Auto(max_iterations=500)).run(steps=4)
    said = [str(w.message) for w in told if "Said once" in str(w.message)]
    assert len(said) == 1
    words = "link between bodies 1 and 0 .* no impulse keeps its length", "no solution: no motion of body 3"
    assert re.search(words[beads > 2], said[0])


@pytest.mark.parametrize("law", [lm.ElasticWire(stiffness=1e3), lm.VoigtRod(stiffness=1e3, viscosity=3.0)])
def test_a_spring_between_bodies_that_are_driven_bears_its_force(law):
    """``k (g+ - g_ref) + c u`` with both ends driven. The drives bring up what it stores and dissipates: nothing is made.
    (Before, solvers that have nothing to move left it without force.)"""
    scene = lm.Scene(dimension=2)
    ends = [scene.add(lm.disk(radius=0.01, position=(0.1 * k, 0.0), mass=1.0)).fix() for k in range(2)]
    ends[1].impose_velocity(x=SPEED)
    scene.chain(ends, law)
    sim = lm.Simulation(scene, time_step=H)
    sim.run(steps=40)
    length = SPEED * 40 * H + 0.5 * H * SPEED  # at the next detection
    viscosity = law.values.get("viscosity") or 0.0
    assert sim.interactions.force[0, 0] == pytest.approx(-1e3 * length - viscosity * SPEED, rel=1e-9)
    assert sim.energy.made == 0.0
    assert sim.energy.drives == pytest.approx(1e3 * length * SPEED * H + viscosity * SPEED**2 * H, rel=1e-9)
    assert abs(sim.energy.defect) < 1e-12
