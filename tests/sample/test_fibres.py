"""Fibres among grains: no overlap, content to the last fibre, and the distributions of directions."""

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.segments import segment_distances
from lmgcpy.sample.fibres import _directions
from lmgcpy.scene.body_3d import capsule_volume

RADII = lm.sample.grading(150, minimum=4e-4, maximum=6e-4, by="diameter", dimension=3, seed=0)
SOLID = 4.0 / 3.0 * math.pi * float((RADII**3).sum())
BOX = (9e-3, 8e-3, 7e-3)
FIBRE = {"radius": 1e-4, "length": 3e-3}


def lay(**more):
    return lm.sample.fibres(RADII, **{"content": 0.03, "box": BOX, "seed": 0, **FIBRE, **more})


def segment_distance(x, t, y, u, half):
    """Least distance of two segments, by a fine grid and then the grid's best point refined four times: independent of
    formulas, and exact to 1e-6 of their length."""
    middle, width = np.zeros(2), half
    for _ in range(6):
        s = np.clip(middle[0] + width * np.linspace(-1, 1, 41), -half, half)[:, None, None]
        r = np.clip(middle[1] + width * np.linspace(-1, 1, 41), -half, half)[None, :, None]
        apart = np.linalg.norm(x + s * t - y - r * u, axis=2)
        at = np.unravel_index(apart.argmin(), apart.shape)
        middle, width = np.array([s[at[0], 0, 0], r[0, at[1], 0]]), 0.1 * width
    return apart.min()


@pytest.mark.default_parameters("random")
@pytest.mark.parametrize("orientation", ["random", "horizontal", (1.0, 2.0, -1.0)])
def test_nothing_overlaps_and_all_lie_in_the_box(orientation):
    laid = lay(orientation=orientation)
    half, radius = 0.5 * laid.length, laid.radius
    ends = np.concatenate([laid.positions + sign * half * laid.axes for sign in (-1, 1)])
    slack = 1e-12  # of lengths of 1e-3 in doubles
    assert (ends - radius >= -slack).all()
    assert (ends + radius <= np.array(BOX) + slack).all()
    assert (laid.grains - RADII[:, None] >= -slack).all()
    assert (laid.grains + RADII[:, None] <= np.array(BOX) + slack).all()
    apart = np.linalg.norm(laid.grains[:, None] - laid.grains, axis=2) + 1e3 * np.eye(len(RADII))
    assert (apart >= np.add.outer(RADII, RADII) - slack).all()
    t, x = laid.axes, laid.positions
    along = np.clip(np.einsum("gmd,md->gm", laid.grains[:, None] - x, t), -half, half)
    to_fibres = np.linalg.norm(laid.grains[:, None] - x - along[:, :, None] * t, axis=2)
    assert (to_fibres >= RADII[:, None] + radius - slack).all()
    for k in range(len(x)):
        for j in range(k):
            assert segment_distance(x[k], t[k], x[j], t[j], half) >= 2.0 * radius - 1e-6 * laid.length


def test_the_detector_sees_no_overlap_either():
    """The narrow phases of spheres and rods in a scene, which know nothing of the sample."""
    laid, stone = lay(), lm.Material("stone", 2600.0)
    scene = lm.Scene(dimension=3)
    scene.add_spheres(RADII, laid.grains, material=stone)
    for body in laid.capsules(stone):
        scene.add(body)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3), alert=2e-4)
    sim = lm.Simulation(scene, time_step=1e-9, overlap="stop")
    sim.step()
    assert len(sim.interactions.gap) > 20
    assert sim.interactions.gap.min() > -1e-12


def test_distance_of_segments_at_random():
    """In all positions, crossing and parallel ones among them, against a search."""
    rng = np.random.default_rng(5)
    for count in range(60):
        x, y = rng.normal(size=(2, 3))
        t, u = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        u = t if count % 6 == 0 else u
        half = rng.uniform(0.2, 2.0)
        one, other = (x[None], half * t[None]), (y[None], half * u[None])
        exact = float(segment_distances(*one, *other)[0])
        assert exact == pytest.approx(segment_distance(x, t, y, u, half), abs=1e-6 * half + 1e-9)
        assert exact == pytest.approx(float(segment_distances(*other, *one)[0]), abs=1e-12)


@pytest.mark.parametrize("content", [0.01, 0.02, 0.037])
def test_content_to_the_last_fibre(content):
    """As many whole fibres as come nearest: half the volume of a fibre may be missing or too much."""
    laid, one = lay(content=content), capsule_volume(FIBRE["radius"], FIBRE["length"])
    assert abs(len(laid.positions) * one - content * SOLID) <= 0.5 * one
    assert laid.content == pytest.approx(len(laid.positions) * one / SOLID, rel=1e-12)
    bodies = laid.capsules(lm.Material("steel", 7800.0))
    assert sum(body.mass for body in bodies) == pytest.approx(laid.content * SOLID * 7800.0, rel=1e-12)
    of_clumps = lay(content=content, grain_volume=2.0 * SOLID)
    assert len(of_clumps.positions) == round(2.0 * content * SOLID / one)


def test_bodies_stand_as_the_fibres_were_laid():
    laid = lay()
    for body, x, t in zip(laid.capsules(lm.Material("steel", 7800.0)), laid.positions, laid.axes, strict=True):
        np.testing.assert_allclose(body.position, x, rtol=1e-15)
        np.testing.assert_allclose(body.rotation.apply([0.0, 0.0, 1.0]), t, atol=1e-14)


SPREAD = 0.6
COSINE, SINE = math.cos(SPREAD), math.sin(SPREAD)


@pytest.mark.parametrize(
    ("orientation", "spread", "axis", "along"),
    [
        ("random", None, (0, 0, 1), 1.0 / 3.0),
        ("horizontal", None, (0, 0, 1), 0.0),
        ("horizontal", SPREAD, (0, 0, 1), SINE**2 / 3.0),
        ("horizontal", 0.5 * math.pi, (0, 0, 1), 1.0 / 3.0),
        ((2.0, -1.0, 0.5), None, (2.0, -1.0, 0.5), 1.0),
        ((2.0, -1.0, 0.5), SPREAD, (2.0, -1.0, 0.5), (1.0 + COSINE + COSINE**2) / 3.0),
        ((0.0, 0.0, -1.0), 0.5 * math.pi, (0, 0, 1), 1.0 / 3.0),
    ],
)
def test_mean_of_t_t_is_that_of_its_distribution(orientation, spread, axis, along):
    """The distributions are symmetric about the axis a: <t (x) t> = along a (x) a + (1 - along)/2 (I - a (x) a).

    A component of t (x) t lies between -1 and 1, so that its standard deviation is at most 1, in fact below 0.36; five
    errors of the mean of 40 000 directions are below 0.009.
    """
    count = 40_000
    t = _directions(count, orientation, spread, np.random.default_rng(3))
    np.testing.assert_allclose(np.linalg.norm(t, axis=1), 1.0, rtol=1e-14)
    a = np.array(axis) / np.linalg.norm(axis)
    expected = along * np.outer(a, a) + 0.5 * (1.0 - along) * (np.eye(3) - np.outer(a, a))
    np.testing.assert_allclose(t.T @ t / count, expected, atol=5.0 * 0.36 / math.sqrt(count))
    if spread is not None and not isinstance(orientation, str):
        assert (t @ a * np.sign(np.dot(orientation, a))).min() >= math.cos(spread) - 1e-12


def test_a_full_box_turns_no_fibre():
    """A fibre keeps its direction until a place is found: however crowded the box, the directions are those drawn first.

    42 fibres in a cube hardly wider than one."""
    alone = {"radii": [], "content": 0.05, "grain_volume": SOLID, "seed": 1, **FIBRE}
    wide, tight = lm.sample.fibres(box=(9e-3,) * 3, **alone), lm.sample.fibres(box=(4e-3,) * 3, **alone)
    assert len(wide.axes) == 42
    np.testing.assert_array_equal(wide.axes, tight.axes)


def test_seeds():
    first, same, other = lay(seed=4), lay(seed=4), lay(seed=5)
    for name in ("positions", "axes", "grains"):
        np.testing.assert_array_equal(getattr(first, name), getattr(same, name))
        assert (getattr(first, name) != getattr(other, name)).any()


def test_fibres_alone_and_grains_alone():
    assert lm.sample.fibres([], content=0.01, grain_volume=SOLID, box=BOX, **FIBRE).grains.shape == (0, 3)
    sand = lay(content=0.0)
    assert sand.positions.shape == (0, 3)
    assert sand.content == 0.0
    assert sand.capsules(lm.Material("steel", 7800.0)) == []
