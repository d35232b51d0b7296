"""Every sentence that scene, bodies, chains, materials and the simulation have for a mistake: kind and words."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

import lmgcpy as lm

SAND = lm.Material("sand", density=2600.0)


def disk(**more):
    return lm.disk(**{"radius": 0.01, "position": (0.0, 0.0), "material": SAND, **more})


def wall(**more):
    return lm.wall(**{"point": (0, 0), "normal": (0, 1), **more})


class Shear(lm.RigidRod):
    """A link that would resist sideways motion too."""

    NAME = "test-shear"

    def rows(self, dimension):
        return dimension


@pytest.fixture
def world():
    """A scene with beads in a row, a wall, and a compiled scene beside it."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(disk(position=(0.03 * i, 0.0), color="BEAD")) for i in range(4)]
    held = scene.add(wall())
    done = lm.Scene(dimension=2)
    old = done.add(disk())
    simulation = lm.Simulation(done, time_step=1e-3)
    return SimpleNamespace(scene=scene, beads=beads, wall=held, done=done, old=old, simulation=simulation)


MISTAKES = {
    # materials
    "material without name": (
        lambda w: lm.Material("", density=1.0),
        TypeError,
        "name of a material must be a word, got ''",
    ),
    "material named by a number": (lambda w: lm.Material(3, density=1.0), TypeError, "must be a word, got 3"),
    "density zero": (
        lambda w: lm.Material("air", density=0.0),
        ValueError,
        r"density of material 'air' must be above 0 kg/m\^3, got 0 kg/m\^3",
    ),
    "density in words": (
        lambda w: lm.Material("air", density="light"),
        TypeError,
        "density of material 'air' must be a number",
    ),
    # bodies
    "radius negative": (lambda w: disk(radius=-1.0), ValueError, "radius of a disk must be above 0 m, got -1 m"),
    "radius not finite": (lambda w: disk(radius=math.inf), ValueError, "radius of a disk must be finite, got inf"),
    "neither mass nor material": (lambda w: disk(material=None), TypeError, r"A disk needs a material= or a mass= \[kg\]"),
    "material as a word": (lambda w: disk(material="sand"), TypeError, "must be a lmgcpy.Material, got 'sand'"),
    "mass zero": (lambda w: disk(mass=0.0), ValueError, "mass of a disk must be above 0 kg"),
    "inertia negative": (lambda w: disk(inertia=-1.0), ValueError, "inertia of a disk must be above 0, got -1"),
    "three coordinates": (
        lambda w: disk(position=(0.0, 0.0, 0.0)),
        ValueError,
        "position of a Disk must be 2 numbers in dimension 2, got 3 numbers",
    ),
    "position in words": (lambda w: disk(position="here"), TypeError, "position of a Disk must be 2 numbers, got 'here'"),
    "position not finite": (lambda w: disk(position=(0.0, math.nan)), ValueError, "position of a Disk must be finite"),
    "velocity as a table": (
        lambda w: disk(velocity=[[0.0, 1.0]]),
        ValueError,
        r"velocity of a Disk must be 2 numbers in dimension 2, got an array of shape \(1, 2\)",
    ),
    "spin in words": (lambda w: disk(spin="fast"), TypeError, "spin must be a number, got 'fast'"),
    "no colour": (lambda w: disk(color=""), TypeError, "color of a Disk must be a word such as 'GRAIN', got ''"),
    "normal zero": (lambda w: wall(normal=(0, 0)), ValueError, "normal of a wall must not be zero"),
    "mass of a wall": (lambda w: wall(mass=-2.0), ValueError, "mass of a wall must be above 0 kg, got -2 kg"),
    "cluster of nothing": (
        lambda w: lm.RigidBody([], mass=1.0, inertia=1.0, position=(0, 0), color="GRAIN"),
        ValueError,
        "needs at least one contactor",
    ),
    "cluster of bodies": (
        lambda w: lm.RigidBody([disk()], mass=1.0, inertia=1.0, position=(0, 0), color="GRAIN"),
        TypeError,
        r"must be Contactor objects or pairs \(contactor, offset\), got <Disk",
    ),
    "offset of three": (
        lambda w: lm.RigidBody([(lm.DiskContactor(1.0), (0, 0, 0))], mass=1.0, inertia=1.0, position=(0, 0), color="GRAIN"),
        ValueError,
        "offset of a contactor must be 2 numbers",
    ),
    # conditions
    "unknown component": (
        lambda w: w.beads[0].fix("z"),
        ValueError,
        "fix: a body in 2D has no component 'z'. Known: spin, x, y",
    ),
    "misspelt component": (
        lambda w: w.beads[0].impose_velocity(spinn=1.0),
        ValueError,
        r"impose_velocity: a body in 2D has no component 'spinn'; did you mean 'spin'\?",
    ),
    "no component": (
        lambda w: w.beads[0].impose_force(),
        TypeError,
        r"impose_force needs a component, for example impose_force",
    ),
    "velocity in words": (
        lambda w: w.beads[0].impose_velocity(x="slow"),
        TypeError,
        r"impose_velocity\(x=\.\.\.\) must be a number, got 'slow'",
    ),
    "force not finite": (
        lambda w: w.beads[0].impose_force(x=math.inf),
        ValueError,
        r"impose_force\(x=\.\.\.\) must be finite",
    ),
    "driven, then loaded": (
        lambda w: w.beads[0].fix("x").impose_force(x=1.0),
        ValueError,
        "Component x of <Disk 'BEAD', body 0, .* is driven by impose_velocity or fix already and cannot be loaded as well",
    ),
    "loaded, then driven": (
        lambda w: w.beads[0].impose_force(spin=1.0).fix(),
        ValueError,
        "Component spin of <Disk 'BEAD', body 0, .* is loaded by impose_force already and cannot be driven as well",
    ),
    "load on a wall without mass": (
        lambda w: w.wall.impose_force(y=1.0),
        ValueError,
        "<Wall 'WALL', body 4, .*> has no mass: give it one where it is made, so that a load on y can move it",
    ),
    "spin of a wall": (lambda w: w.wall.impose_velocity(spin=1.0), ValueError, "A wall does not turn"),
    "moment on a wall": (lambda w: w.wall.impose_force(spin=1.0), ValueError, "A wall does not turn"),
    # the scene
    "dimension": (lambda w: lm.Scene(dimension=4), ValueError, "dimension must be 2 or 3, got 4"),
    "gravity": (
        lambda w: lm.Scene(dimension=2, gravity=9.81),
        ValueError,
        r"gravity must be 2 numbers in dimension 2, got an array of shape \(\)",
    ),
    "add no body": (
        lambda w: w.scene.add("disk"),
        TypeError,
        r"Scene.add takes a body such as lmgcpy.disk\(...\), got 'disk'",
    ),
    "add twice": (lambda w: w.scene.add(w.beads[1]), ValueError, "<Disk 'BEAD', body 1, .*> is in this scene already"),
    "add another scene's": (lambda w: w.scene.add(w.old), ValueError, "is in another scene already: make a new body"),
    "colour no word": (
        lambda w: w.scene.see("BEAD", 3, lm.Signorini()),
        TypeError,
        "A colour is a word such as 'GRAIN', got 3",
    ),
    "no law": (
        lambda w: w.scene.see("BEAD", "WALL", "coulomb"),
        TypeError,
        "Scene.see takes a law such as .*, got 'coulomb'",
    ),
    "law class": (
        lambda w: w.scene.see("BEAD", "WALL", lm.Signorini),
        TypeError,
        "Scene.see takes a law such as .*Signorini",
    ),
    "link law for a contact": (
        lambda w: w.scene.see("BEAD", "WALL", lm.RigidRod()),
        TypeError,
        "Law 'rigid-rod' is for a link: give it to Scene.chain, not Scene.see",
    ),
    "contact law for a chain": (
        lambda w: w.scene.chain(w.beads, lm.Signorini()),
        TypeError,
        "Law 'signorini' is for a contact: give it to Scene.see, not Scene.chain",
    ),
    "link law of two components": (
        lambda w: w.scene.chain(w.beads, Shear()),
        TypeError,
        "Law 'test-shear' has 2 components: a link acts along its line only",
    ),
    "alert negative": (
        lambda w: w.scene.see("BEAD", "WALL", lm.Signorini(), alert=-1.0),
        ValueError,
        "alert between 'BEAD' and 'WALL' must be at least 0 m, got -1 m",
    ),
    # chains
    "chain of one": (lambda w: w.scene.chain(w.beads[:1], lm.RigidRod()), ValueError, "A chain needs at least 2 bodies"),
    "ring of two": (
        lambda w: w.scene.chain(w.beads[:2], lm.RigidRod(), closed=True),
        ValueError,
        "A closed chain needs at least 3 bodies",
    ),
    "chain of numbers": (
        lambda w: w.scene.chain([0, 1], lm.RigidRod()),
        TypeError,
        "A chain links bodies of the scene, got 0",
    ),
    "chain of a stranger": (
        lambda w: w.scene.chain([w.beads[0], disk()], lm.RigidRod()),
        ValueError,
        "body not yet in a scene.* is not in this scene: add it before it is chained",
    ),
    "chain of another scene's": (
        lambda w: w.scene.chain([w.beads[1], w.old], lm.RigidRod()),
        ValueError,
        "is not in this scene",
    ),
    "a bead twice": (
        lambda w: w.scene.chain([*w.beads, w.beads[0]], lm.RigidRod()),
        ValueError,
        "body 0, .*> is in the chain twice; closed=True links the last body to the first",
    ),
    "gaps of another number": (
        lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=[0.01, 0.01]),
        ValueError,
        r"reference_gap must be a number \[m\], 3 numbers \(one a link\) or None, got \[0.01, 0.01\]",
    ),
    "gap in words": (
        lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap="wide"),
        ValueError,
        "reference_gap must be a number .* got 'wide'",
    ),
    "gap not finite": (
        lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=math.nan),
        ValueError,
        "reference_gap must be finite",
    ),
    "negative length": (
        lambda w: w.scene.chain(w.beads, lm.ElasticWire(stiffness=1.0), reference_gap=-0.03),
        ValueError,
        "reference_gap -0.03 m gives a link a negative length between centres",
    ),
    "a wire that is too short": (
        lambda w: w.scene.chain(w.beads, lm.RigidWire(), reference_gap=0.009),
        ValueError,
        "Link 0 of the chain, between .*body 0.* and .*body 1.*, has a gap of 0.01 m where its reference is 0.009 m.*blow",
    ),
    "a rod that is too long": (
        lambda w: w.scene.chain(w.beads, lm.RigidRod(), reference_gap=[0.01, 0.011, 0.01]),
        ValueError,
        "Link 1 of the chain",
    ),
    "relaxation negative": (
        lambda w: w.scene.chain(w.beads, lm.RigidRod(), relaxation=-1.0),
        ValueError,
        "relaxation of a chain must be at least 0 s",
    ),
    # editing what is compiled
    "add after": (
        lambda w: w.done.add(disk()),
        RuntimeError,
        "Cannot add a body: a Simulation has compiled this scene. Make a new scene",
    ),
    "see after": (
        lambda w: w.done.see("GRAIN", "GRAIN", lm.Signorini()),
        RuntimeError,
        "Cannot extend the visibility table",
    ),
    "chain after": (lambda w: w.done.chain([w.old], lm.RigidRod()), RuntimeError, "Cannot add a chain"),
    "compile twice": (lambda w: lm.Simulation(w.done, time_step=1e-3), RuntimeError, "Cannot compile the scene again"),
    "fix after": (
        lambda w: w.old.fix(),
        RuntimeError,
        "<Disk 'GRAIN', body 0, .* is in a compiled scene, which cannot be edited: call fix before Simulation",
    ),
    "drive after": (lambda w: w.old.impose_velocity(x=1.0), RuntimeError, "call impose_velocity before Simulation"),
    "load after": (lambda w: w.old.impose_force(x=1.0), RuntimeError, "call impose_force before Simulation"),
    # the simulation
    "time step zero": (lambda w: lm.Simulation(w.scene, time_step=0.0), ValueError, "time_step must be above 0 s, got 0 s"),
    "theta": (
        lambda w: lm.Simulation(w.scene, time_step=1.0, theta=0.4),
        ValueError,
        "theta must be at least 0.5, got 0.4",
    ),
    "theta above": (
        lambda w: lm.Simulation(w.scene, time_step=1.0, theta=1.1),
        ValueError,
        "theta must be at most 1, got 1.1",
    ),
    "solver": (
        lambda w: lm.Simulation(w.scene, time_step=1.0, solver="gauss-seidel"),
        TypeError,
        "solver must be a solver such as lmgcpy.GaussSeidel.*, got 'gauss-seidel'",
    ),
    "run of nothing": (
        lambda w: w.simulation.run(),
        TypeError,
        r"run takes either steps or duration \[s\], one of the two",
    ),
    "run of both": (lambda w: w.simulation.run(steps=1, duration=1.0), TypeError, "run takes either steps or duration"),
    "half a step": (lambda w: w.simulation.run(steps=0.5), TypeError, "steps must be a whole number, got 0.5"),
    "steps negative": (lambda w: w.simulation.run(steps=-1), ValueError, "steps must be at least 0, got -1"),
    "duration negative": (lambda w: w.simulation.run(duration=-1.0), ValueError, "duration must be at least 0 s, got -1 s"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_gets_a_sentence(mistake, world):
    make, kind, sentence = MISTAKES[mistake]
    with pytest.raises(kind, match=sentence):
        make(world)


def test_a_colour_that_nobody_has_is_named(world):
    world.scene.see("BEED", "WALL", lm.Signorini())
    sentence = r"No body has the colour 'BEED' that the visibility table names; did you mean 'BEAD'\? Known: BEAD, WALL"
    with pytest.raises(LookupError, match=sentence):
        lm.Simulation(world.scene, time_step=1e-3)


def test_a_refused_option_does_not_use_the_scene_up(world):
    """The scene is compiled only once all is well."""
    with pytest.raises(ValueError, match="theta"):
        lm.Simulation(world.scene, time_step=1e-3, theta=2.0)
    lm.Simulation(world.scene, time_step=1e-3).run(steps=1)


def test_a_refused_chain_leaves_the_scene_as_it_was(world):
    with pytest.raises(ValueError, match="blow"):
        world.scene.chain(world.beads, lm.RigidRod(), reference_gap=0.02, block_spin=True)
    assert world.scene.chains == []
    world.beads[0].impose_force(spin=1.0)  # so the spin was not fixed
