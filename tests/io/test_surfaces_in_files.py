"""Scenes with surfaces in run files: the same bits after resume, the same scene again, and pictures of the facets."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.scene.description import describe, from_description


def in_space():
    points = np.array(list(product((-0.1, 0.1), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
    for k in range(4):
        scene.add(lm.sphere(radius=0.05, position=(0.1 * k - 0.15, 0.02 * k, 0.1), mass=1.0))
    oak = lm.Material("oak", 700.0)
    scene.add(lm.mesh(points - (0.0, 0.0, -0.35), triangles, material=oak, sides="outside", color="GRAIN"))
    corners = [(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)]
    scene.add(lm.plate(corners, radius=0.01)).impose_velocity(spin_z=1.0)
    return scene


def in_plane():
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for k in range(4):
        scene.add(lm.disk(radius=0.05, position=(0.12 * k - 0.18, 0.065), mass=1.0))
    block = [(-0.1, 0.2), (0.1, 0.2), (0.1, 0.4), (-0.1, 0.4)]
    oak = lm.Material("oak", 700.0)
    scene.add(lm.wall_segment(*block, closed=True, sides="outside", material=oak, color="GRAIN"))
    scene.add(lm.wall_segment((-0.5, 0.1), (-0.3, 0.0), (0.3, 0.0), (0.5, 0.1), radius=0.01)).impose_velocity(spin=0.1)
    return scene


SCENES = {"in space": in_space, "in the plane": in_plane}


def simulated(make):
    scene = make()
    for color in ("GRAIN", "WALL"):
        scene.see("GRAIN", color, lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3)


@pytest.mark.default_parameters("in space")
@pytest.mark.parametrize("name", SCENES)
def test_a_run_goes_on_with_the_same_bits_and_its_scene_comes_back(name, tmp_path):
    path = tmp_path / "run.h5"
    whole = simulated(SCENES[name]).run(steps=60)
    simulated(SCENES[name]).run(steps=40, record=path, every=10)
    resumed = lm.resume(path).run(steps=20)
    for part in ("positions", "velocities", "spins"):
        assert np.array_equal(getattr(resumed, part), getattr(whole, part))
    assert len(whole.interactions) > 2
    before, again = SCENES[name](), lm.Scene.from_run(path, 40)
    for one, other in zip(before.bodies[-2:], again.bodies[-2:], strict=True):
        assert isinstance(other, lm.Surface)
        assert other.facet_count == one.facet_count
        assert other.mass == one.mass
        assert other.held_by_default == one.held_by_default
        for mine, its in zip(one.features, other.features, strict=True):
            assert (mine.kind, mine.size) == (its.kind, its.size)
            for part in ("places", "middles", "radii", "half_boxes"):
                assert np.array_equal(getattr(its, part), getattr(mine, part)), part
            assert np.array_equal(its.shapes[:, : mine.shapes.shape[1]], mine.shapes)
            assert not its.shapes[:, mine.shapes.shape[1] :].any()
    lm.Simulation(again, time_step=1e-3).run(steps=2)


WRONG = {
    "no sizes": lambda table: table.pop("size"),
    "fewer sizes": lambda table: table.update(size=table["size"][:3]),
    "sizes that are none": lambda table: table["size"].fill(np.nan),
    "no outlines": lambda table: table.pop("outlines"),
    "middles that are none": lambda table: table["middle"].fill(np.nan),
    "shapes that are none": lambda table: table["shape"].__setitem__((5, 3), np.nan),
    "radii below zero": lambda table: table["bounding_radius"].fill(-1.0),
    "short shapes": lambda table: table["shape_size"].fill(1),
    "one kind": lambda table: table["kind"].fill(0),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("name", SCENES)
def test_a_description_that_does_not_fit_is_refused(name, wrong):
    """With the errors that readers of files turn into a sentence, and before anything is compiled."""
    description = describe(SCENES[name]())
    WRONG[wrong](description["contactors"])
    with pytest.raises((KeyError, IndexError, ValueError)):
        from_description(description).compile()


@pytest.mark.parametrize("name", SCENES)
def test_facets_are_drawn_where_they_are(name):
    from lmgcpy.view.snapshot import snapshot

    sim = simulated(SCENES[name]).run(steps=20)
    snap = snapshot(sim)
    flat = snap.dimension == 2
    assert len(snap.facets) == (4 + 3 if flat else 12 + 2)
    assert not snap.outlines
    assert len(snap.sharp_edges) == (0 if flat else 12 + 4)
    surface = sim.scene.bodies[-1]
    middle = np.mean([corners.mean(axis=0) for body, corners in snap.facets if body == surface.id], axis=0)
    assert middle[0] == pytest.approx(surface.position[0], abs=0.05)


@pytest.mark.parametrize("name", SCENES)
def test_the_check_of_a_layout_finds_balls_in_surfaces(name):
    """A ball that is lowered by a fifth of its radius into the plate or polyline of thickness 0.01."""
    scene = SCENES[name]()
    ball = scene.bodies[1]
    ball.position[-1] = 0.04 + 0.01
    found = lm.view.check(scene).overlaps
    assert (found["antagonist"][0], found["candidate"][0]) == (1, len(scene.bodies) - 1)
    assert found["depth"][0] == pytest.approx(0.01)
    assert len(found) == 1
