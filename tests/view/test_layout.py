"""The check of a layout finds what overlaps and what is too long, no more, with its size."""

import numpy as np
import pytest
from seen import wire_in_a_box

import lmgcpy as lm
from lmgcpy.dynamics.watch.start_overlaps import overlaps_at_start
from lmgcpy.view.layout import near_pairs


def test_a_sound_layout():
    found = lm.view.check(wire_in_a_box())
    assert found.sound
    assert str(found) == "overlaps: 0; links longer than their reference: 0"


def test_an_overlap_and_its_size():
    """Two grains of radius 0.1 m overlap by 0.3 of it."""
    found = lm.view.check(wire_in_a_box(overlap=0.3))
    (row,) = found.overlaps
    assert (row["antagonist"], row["candidate"]) == (5, 6)
    assert row["depth"] == pytest.approx(0.03, abs=1e-12)
    assert row["share"] == pytest.approx(0.3, abs=1e-12)
    assert "5         6               0.03   30 %" in str(found)


def test_long_links_and_their_excess():
    """Each of the four links is 1.25 times its reference."""
    found = lm.view.check(wire_in_a_box(stretch=1.25))
    np.testing.assert_array_equal(np.sort(found.links["link"]), [0, 1, 2, 3])
    np.testing.assert_allclose(found.links["excess"], 0.25, atol=1e-12)
    np.testing.assert_allclose(found.links["length"], 0.2, atol=1e-12)
    assert not found.sound
    assert lm.view.check(wire_in_a_box(stretch=1.25), excess=0.26).sound


def test_only_what_sees_each_other_overlaps():
    scene = lm.Scene(dimension=2)
    for color, x in (("A", 0.0), ("A", 0.1), ("B", 0.15), ("B", 0.3)):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, color=color))
    assert len(lm.view.check(scene).overlaps) == 4  # without a table all, but not 0 with 3
    scene.see("A", "B", lm.Signorini())
    pairs = {(int(row["antagonist"]), int(row["candidate"])) for row in lm.view.check(scene).overlaps}
    assert pairs == {(0, 2), (1, 2)}


def test_walls_and_cylinders_from_inside():
    scene = lm.Scene(dimension=3)
    scene.add(lm.sphere(radius=0.1, position=(0.46, 0.0, 0.05), mass=1.0))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=0.5))
    found = lm.view.check(scene).overlaps
    assert found["candidate"].tolist() == [2, 1]
    np.testing.assert_allclose(found["depth"], [0.06, 0.05], atol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_pairs_are_all_pairs(dimension):
    """Against every pair looked at one by one, for radii over two decades."""
    rng = np.random.default_rng(dimension)
    radius = 10.0 ** rng.uniform(-2.0, 0.0, 300)
    positions = rng.uniform(0.0, 6.0, (300, dimension))
    a, b, gap = near_pairs(positions, radius)
    i, j = np.triu_indices(300, 1)
    true = np.linalg.norm(positions[i] - positions[j], axis=1) - radius[i] - radius[j]
    assert len(a) == (true <= 0.0).sum() > 50
    assert {tuple(sorted(pair)) for pair in zip(a, b, strict=True)} == set(zip(i[true <= 0], j[true <= 0], strict=True))
    np.testing.assert_allclose(gap, np.linalg.norm(positions[a] - positions[b], axis=1) - radius[a] - radius[b], atol=1e-12)


def test_it_agrees_with_what_a_simulation_tells():
    """Detection counts the same pairs beyond its own threshold of 5 %."""
    rng = np.random.default_rng(3)
    scene = lm.Scene(dimension=2)
    for position in rng.uniform(0.0, 3.0, (150, 2)):
        scene.add(lm.disk(radius=rng.uniform(0.05, 0.15), position=position, mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Signorini())
    scene.see("GRAIN", "WALL", lm.Signorini())
    found = lm.view.check(scene, overlap=0.05).overlaps
    (told,), _ = overlaps_at_start(scene.compile())
    assert told.startswith(f"{len(found)} pairs of bodies overlap")
    assert f"{100.0 * found['share'][0]:.3g} % of" in told


def test_a_long_table_is_cut():
    scene = lm.Scene(dimension=2)
    for i in range(30):
        scene.add(lm.disk(radius=0.1, position=(0.15 * i, 0.0), mass=1.0))
    lines = str(lm.view.check(scene)).splitlines()
    assert lines[0].startswith("overlaps: 29;")
    assert lines[-1] == "  and 19 more"
    assert len(lines) == 13
