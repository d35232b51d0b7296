"""Many bodies in one call are those that many calls make."""

import time

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.scene.description import build, describe

SAND = lm.Material("sand", density=2600.0)
COUNT = 40


def drawn(dimension):
    """Radii, positions, velocities and spins of some bodies, seed 0."""
    generator = np.random.default_rng(0)
    turning = (COUNT,) if dimension == 2 else (COUNT, 3)
    shapes = (COUNT,), (COUNT, dimension), (COUNT, dimension), turning
    return [generator.uniform(0.1, 1.0, shape) for shape in shapes]


def one_by_one(dimension, **given):
    """The scene of ``drawn``, by as many calls."""
    scene, make = lm.Scene(dimension=dimension), lm.disk if dimension == 2 else lm.sphere
    for radius, position, velocity, spin in zip(*drawn(dimension), strict=True):
        scene.add(make(radius=radius, position=position, velocity=velocity, spin=spin, **given))
    return scene


def at_once(dimension, **given):
    """The same in one call."""
    scene = lm.Scene(dimension=dimension)
    radii, positions, velocities, spins = drawn(dimension)
    add = scene.add_disks if dimension == 2 else scene.add_spheres
    add(radii, positions, velocities=velocities, spins=spins, **given)
    return scene


def flat(tree):
    """The numbers and words of a description."""
    if isinstance(tree, dict):
        return {f"{key}.{inner}": value for key, item in tree.items() for inner, value in flat(item).items()}
    return {"": tree.tolist() if isinstance(tree, np.ndarray) else tree}


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("one", "many"), [({}, {}), ({"mass": 2.5}, {"masses": 2.5}), ({"inertia": 0.3}, {"inertias": 0.3})]
)
def test_they_are_the_same_to_the_last_bit(dimension, one, many):
    alone, together = one_by_one(dimension, material=SAND, **one), at_once(dimension, material=SAND, **many)
    assert flat(describe(together)) == flat(describe(alone))
    of_alone, of_together = alone.compile(), together.compile()
    for name in ("mass", "inverse_mass", "radius", "extent", "heavy"):
        assert np.array_equal(getattr(of_together, name), getattr(of_alone, name)), name
    for name in ("body", "offset", "shape", "bounding_radius"):
        assert np.array_equal(getattr(of_together.contactors, name), getattr(of_alone.contactors, name)), name
    assert of_together.contactors.kind == of_alone.contactors.kind
    # and a scene from a file has them again
    assert flat(describe(build(describe(together)))) == flat(describe(alone))


def test_they_are_bodies_among_others():
    """Each can be fixed, chained, coloured; ids go on after those that were there."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    beads = scene.add_disks(0.1, [(0.0, 2.0), (0.3, 2.0), (0.6, 2.0)], masses=[1.0, 2.0, 3.0], velocities=(0.0, -1.0))
    cluster = scene.add(lm.RigidBody([lm.DiskContactor(0.1)] * 2, mass=1.0, inertia=0.1, position=(5.0, 1.0), color="ODD"))
    last = scene.add_disks([0.2], [(9.0, 1.0)], material=SAND)
    assert [body.id for body in (floor, *beads, cluster, *last)] == list(range(6))
    assert [body.mass for body in beads] == [1.0, 2.0, 3.0]
    assert beads[1].material is None
    assert last[0].material is SAND
    beads[0].fix()
    beads[2].color = "TIP"
    scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.run(steps=1)
    assert sim.positions[1:4, 1] == pytest.approx([2.0, 2.0 - 1e-3 - 9.81e-6 / 2, 2.0 - 1e-3 - 9.81e-6 / 2], abs=1e-4)
    assert beads[0].position.tolist() == [0.0, 2.0]
    assert sim.model.contactors.body.tolist() == [0, 1, 2, 3, 4, 4, 5]
    assert sim.model.contactors.color == ["WALL", "GRAIN", "GRAIN", "TIP", "ODD", "ODD", "GRAIN"]


def test_a_class_derived_from_a_disk_speaks_for_itself():
    class Hollow(lm.Disk):
        @property
        def inertia(self):
            return 2.0 * super().inertia

    scene = lm.Scene(dimension=2)
    scene.add(Hollow(radius=0.1, position=(0, 0), mass=1.0, color="GRAIN"))
    assert scene.compile().mass[0].tolist() == [1.0, 1.0, 0.01]


def test_none_is_none():
    scene = lm.Scene(dimension=3)
    assert scene.add_spheres(0.1, np.zeros((0, 3)), masses=1.0) == []
    assert scene.bodies == []


@pytest.mark.parametrize(
    ("error", "words", "change"),
    [
        (ValueError, "radii of add_disks: number 1 must be above 0 m, got -1 m", {"radii": [1.0, -1.0]}),
        (
            ValueError,
            r"radii of add_disks must be of shape \(2,\) \[m\], or one number for all, got \(3,\)",
            {"radii": [1.0] * 3},
        ),
        (TypeError, "radii of add_disks must be an array", {"radii": ["a", "b"]}),
        (ValueError, r"positions of add_disks must be of shape \(n, 2\) \[m\], got \(2,\)", {"positions": [0.0, 1.0]}),
        (ValueError, "positions of add_disks must be finite", {"positions": [(0.0, 1.0), (0.0, np.nan)]}),
        (ValueError, "velocities of add_disks must be of shape", {"velocities": [1.0, 2.0, 3.0]}),
        (ValueError, "spins of add_disks must be of shape", {"spins": [1.0]}),
        (ValueError, "masses of add_disks: number 0 must be above 0 kg, got 0 kg", {"masses": [0.0, 1.0]}),
        (ValueError, "inertias of add_disks: number 1 must be above 0", {"inertias": [1.0, -1.0]}),
        (TypeError, r"add_disks needs a material= or masses= \[kg\]", {"material": None}),
        (TypeError, "material of add_disks must be a lmgcpy.Material, got 'sand'", {"material": "sand"}),
        (TypeError, "color of add_disks must be a word such as 'GRAIN', got 3", {"color": 3}),
        (TypeError, "add_disks has no argument 'colour'; did you mean 'color'", {"colour": "GRAIN"}),
    ],
)
def test_wrong_arguments_get_a_sentence_and_leave_the_scene_as_it_was(error, words, change):
    scene = lm.Scene(dimension=2)
    given = {"radii": [0.1, 0.1], "positions": [(0.0, 0.0), (1.0, 0.0)], "material": SAND, **change}
    with pytest.raises(error, match=words):
        scene.add_disks(given.pop("radii"), given.pop("positions"), **given)
    assert scene.bodies == []


def test_the_scene_must_have_their_dimension():
    with pytest.raises(ValueError, match="A sphere is of dimension 3, this scene of dimension 2"):
        lm.Scene(dimension=2).add_spheres(0.1, [(0, 0, 0)], masses=1.0)


def test_ten_thousand_take_milliseconds():
    """Half a second for 1e5 is the goal; one body at a time takes some 50 us. The bound leaves a busy machine a factor of
    five; the least of three, as the collector of garbage may come in between."""
    positions = np.column_stack([np.arange(10_000.0), np.zeros(10_000)])
    seconds = []
    for _ in range(3):
        scene = lm.Scene(dimension=2)
        begin = time.process_time()
        scene.add_disks(0.1, positions, material=SAND)
        scene.compile()
        seconds.append(time.process_time() - begin)
    assert min(seconds) < 0.25
