"""The geometric deposit: nothing overlaps, everything is stable and lowest, and it is dense."""

import time

import numpy as np
import pytest
import suites

from lmgcpy.measure.density import density
from lmgcpy.sample import deposit, grading, wire_2d
from lmgcpy.sample.bed_2d import blocker, enter, tangent_radii
from lmgcpy.sample.deposit_2d import empty_bed, lowest_rest, new_pockets, open_pocket, rest

OVERLAP = 1e-9  # of the radius: the tolerance asked for; built are 1e-10 of the finest radius and round-off


def overlap(positions, radii, width):
    """Largest overlap of two bodies, or of a grain and a wall or the floor, relative to the finest radius."""
    x, y = positions.T
    worst = max((radii - x).max(), (x + radii - width).max(), (radii - y).max())
    for n in range(1, len(radii)):
        distance = np.hypot(*(positions[:n] - positions[n]).T)
        worst = max(worst, (radii[:n] + radii[n] - distance).max())
    return worst / radii.min()


def unstable(positions, radii, width, count):
    """How many of the first ``count`` bodies do not rest: the vertical is in the cone of two contact normals.

    Grains carry nothing but themselves here, so that contacts with later grains do not count against stability.
    """
    number = 0
    for n in range(count):
        distance = np.hypot(*(positions - positions[n]).T)
        distance[n] = np.inf
        touching = distance - radii - radii[n] < 1e-7 * radii[n]
        normals = (positions[n] - positions[touching]) / distance[touching, None]
        if positions[n, 1] - radii[n] < 1e-7 * radii[n]:
            continue
        if positions[n, 0] - radii[n] < 1e-7 * radii[n]:
            normals = np.vstack((normals, (1.0, 0.0)))
        if width - positions[n, 0] - radii[n] < 1e-7 * radii[n]:
            normals = np.vstack((normals, (-1.0, 0.0)))
        left, right = normals[normals[:, 0] >= -1e-7], normals[normals[:, 0] <= 1e-7]
        # on a left and a right normal: a n_left + b n_right = vertical with a, b >= 0
        cross = left[:, None, 0] * right[None, :, 1] - left[:, None, 1] * right[None, :, 0]
        number += not (cross > -1e-7).any()
    return number


def inner_density(positions, radii, width, grains=None):
    """Solid fraction one coarsest diameter away from walls, floor and top."""
    grains = slice(None) if grains is None else grains
    edge = 2.0 * radii[grains].max()
    top = (positions[grains, 1] + radii[grains]).max()
    return density(positions, radii, ((edge, edge), (width - edge, top - edge)))


@pytest.mark.scaled
@pytest.mark.parametrize(("grain_count", "seeds"), [(1700, 4), (2000, 2)])
def test_dense_sand(grain_count, seeds):
    """Solid fraction 0.81 is asked for ratio 2; over 20 seeds 0.825 is the least that was measured."""
    for seed in range(suites.size(1, long=seeds)):
        radii = grading(grain_count, minimum=0.005, maximum=0.010, by="diameter", seed=seed)
        positions = deposit(radii, box=(0.67, None), seed=seed)
        assert positions.shape == (grain_count, 2)
        assert overlap(positions, radii, 0.67) < OVERLAP
        assert unstable(positions, radii, 0.67, grain_count) == 0
        assert inner_density(positions, radii, 0.67) > 0.82
        # no segregation: 0.1 is four standard deviations of 1700 independent draws
        assert abs(np.corrcoef(radii, positions[:, 1])[0, 1]) < 0.1


@pytest.mark.long
@pytest.mark.default_parameters("0")
@pytest.mark.parametrize("seed", range(2))
def test_texsol(seed):
    """The paper's sample: 1700 grains around 300 beads. Measured: 0.782 to 0.790, beads included, over 20 seeds."""
    radii = grading(1700, minimum=0.005, maximum=0.010, by="diameter", seed=seed)
    wire = wire_2d(box=(0.67, 0.67), bead_radius=0.0075, interstice=0.021, bead_count=300, seed=seed)
    grains = deposit(radii, box=(0.67, None), obstacles=(wire.positions, wire.radii), seed=seed)
    positions, sizes = np.vstack((grains, wire.positions)), np.concatenate((radii, wire.radii))
    assert overlap(positions, sizes, 0.67) < OVERLAP
    assert unstable(positions, sizes, 0.67, 1700) == 0
    assert inner_density(positions, sizes, 0.67, slice(1700)) > 0.775
    assert holes(positions, sizes, 0.67, 0.62, finest=0.005) == 0


def holes(positions, radii, width, height, finest):
    """Points of a fine grid below a height at which a finest grain would fit."""
    step = 0.002
    points = np.stack(
        np.meshgrid(np.arange(finest, width - finest, step), np.arange(finest, height, step)), axis=-1
    ).reshape(-1, 2)
    free = np.ones(len(points), dtype=bool)
    for centre, radius in zip(positions, radii, strict=True):
        free[free] = np.hypot(*(points[free] - centre).T) >= radius + finest
    return int(free.sum())


def test_fast():
    """2000 particles in under 5 s is asked; 0.03 s are measured, and 1 s leaves room for a busy machine."""
    radii = grading(1700, minimum=0.005, maximum=0.010, seed=0)
    wire = wire_2d(box=(0.67, 0.67), bead_radius=0.0075, interstice=0.021, bead_count=300, seed=0)
    deposit(radii[:10], box=(0.67, None), obstacles=(wire.positions, wire.radii))
    start = time.perf_counter()
    deposit(radii, box=(0.67, None), obstacles=(wire.positions, wire.radii))
    assert time.perf_counter() - start < 1.0


def lowest_pocket(positions, radii, r, width):
    """Height of the lowest stable pocket for a radius, by trying every pair of supports."""
    close = 1e-9 * r
    found = [np.array([[r, r], [width - r, r]])]
    x, y = positions.T
    with np.errstate(invalid="ignore"):
        for side in (-1.0, 1.0):
            found.append(np.column_stack((x + side * np.sqrt((radii + r) ** 2 - (y - r) ** 2), np.full_like(x, r))))
        for wall, inside in ((r, x >= r - close), (width - r, x <= width - r + close)):
            high = y + np.sqrt((radii + r) ** 2 - (x - wall) ** 2)
            found.append(np.column_stack((np.full_like(x, wall), np.where(inside, high, np.nan))))
        i, j = (~np.eye(len(radii), dtype=bool)).nonzero()
        i, j = i[x[i] < x[j]], j[x[i] < x[j]]
        link = positions[j] - positions[i]
        distance = np.hypot(*link.T)
        cosine = (distance**2 + (radii[i] + r) ** 2 - (radii[j] + r) ** 2) / (2.0 * distance * (radii[i] + r))
        angle = np.arctan2(link[:, 1], link[:, 0]) + np.arccos(cosine)
        pocket = positions[i] + (radii[i] + r)[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
        between = (pocket[:, 0] >= x[i] - close) & (pocket[:, 0] <= x[j] + close)
        found.append(pocket[between])
        places = np.vstack(found)
        free = (places[:, 0] >= r - close) & (places[:, 0] <= width - r + close) & (places[:, 1] >= r - close)
        places = places[free]
        gaps = np.hypot(*(places[:, None] - positions[None]).transpose(2, 0, 1)) - radii - r
    return places[(gaps > -close).all(axis=1), 1].min() if len(radii) else r


def sizes(kind, rng, count):
    return {
        "ratio 2": rng.uniform(1.0, 2.0, count),
        "ratio 10": rng.uniform(1.0, 10.0, count),
        "ratio 10 by mass": 1.0 / (1.0 - 0.9 * rng.uniform(size=count)),
        "three sizes": rng.choice([1.0, 2.0, 5.0], count),
        "equal": np.ones(count),
    }[kind]


@pytest.mark.default_parameters(kind=("ratio 10 by mass", "equal"))
@pytest.mark.parametrize("kind", ["ratio 2", "ratio 10", "ratio 10 by mass", "three sizes", "equal"])
def test_lowest_pocket(kind):
    """Every grain lies as low as the lowest of all pockets, tried one by one, also among odd obstacles.

    So no pocket is closed that could still have taken a grain. The obstacles may overlap each other and the walls.
    """
    count = 50
    for seed in range(6):
        rng = np.random.default_rng(seed)
        radii = sizes(kind, rng, count)
        width = 2.0 * radii.max() * rng.uniform(1.0, 6.0)
        obstacle_count = rng.integers(0, 25)
        obstacles = np.column_stack(
            (rng.uniform(-1.0, width + 1.0, obstacle_count), rng.uniform(-1.0, 40.0, obstacle_count))
        )
        thickness = rng.uniform(0.3, 4.0, obstacle_count)
        grains = deposit(radii, box=(width, None), obstacles=(obstacles, thickness), order="given")
        for n in range(count):
            positions = np.vstack((obstacles, grains[:n]))
            lowest = lowest_pocket(positions, np.concatenate((thickness, radii[:n])), radii[n], width)
            # tangent places are known to some 1e-8 of a radius where the two supports are almost in line
            assert grains[n, 1] == pytest.approx(lowest, abs=1e-6)


def test_free_between():
    """A pocket on a tiny disk may be blocked by a third one for fine and for coarse grains, and be free in between.

    Coarse grains reach over the tiny disk. An attempt that fails with 7.7 must not take 4.18 with it, though 1.984
    fails for the same reason; the functions run here as plain Python.
    """
    obstacles = np.array([[45.735, 7.6114], [53.8645, 4.4384], [41.4796, 4.7861]])
    bed = empty_bed(np.ones(1), 78.0, obstacles, np.array([0.3217, 4.4384, 4.7861]))
    for disk in range(3):
        enter(disk, bed)
    pockets, count = open_pocket(0, 1, 1.984, 9.6, bed, new_pockets(4), 0)
    assert count == 1
    blockers = []
    for r in (1.984, 7.7):
        _, x, y = rest(0, 1, r, bed)
        blockers.append(blocker(x, y, r, bed))
        assert np.isinf(lowest_rest(r, bed, pockets, 1)[1])
    assert blockers == [2, 2]
    _, y, count = lowest_rest(4.18, bed, pockets, 1)
    assert y == pytest.approx(11.17, abs=0.01)
    fine, coarse = tangent_radii(0, 1, 2, bed)
    for r in (fine, coarse):
        _, x, y = rest(0, 1, r, bed)
        assert np.hypot(x - obstacles[2, 0], y - obstacles[2, 1]) == pytest.approx(r + 4.7861)


@pytest.mark.parametrize("width", [0.015, 0.0151, 0.028, 0.60, 0.67])
def test_equal_radii(width):
    """Degenerate ties everywhere, a box as wide as one grain, and one as wide as forty."""
    radii = np.full(300, 0.0075)
    positions = deposit(radii, box=(width, None), seed=1)
    assert overlap(positions, radii, width) < OVERLAP
    assert unstable(positions, radii, width, 300) == 0
    if width == 0.015:
        np.testing.assert_allclose(np.sort(positions[:, 1]), 0.0075 + 0.015 * np.arange(300), rtol=1e-12)
    if width == 0.60:
        # a triangular lattice has 0.907
        assert inner_density(positions, radii, width) > 0.88


def test_ratio_ten():
    radii = grading(3000, minimum=0.001, maximum=0.010, by="mass", seed=2)
    positions = deposit(radii, box=(0.15, None), seed=2)
    assert overlap(positions, radii, 0.15) < OVERLAP
    assert inner_density(positions, radii, 0.15) > 0.86


def test_one_grain():
    np.testing.assert_array_equal(deposit([0.01], box=(0.02, 0.02)), [[0.01, 0.01]])


def test_order_and_seed():
    """The result is in the order of the radii: the first of a given order lies in a corner."""
    radii = np.array([0.02, 0.01, 0.03])
    assert deposit(radii, box=(1.0, None), order="given")[0] == pytest.approx((0.02, 0.02))
    many = grading(100, minimum=0.005, maximum=0.010)
    first, same, other = (deposit(many, box=(0.1, None), seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, same)
    assert (first != other).any()


def test_similar():
    """Lengths a thousand times larger give the same sample a thousand times larger."""
    radii = grading(200, minimum=0.005, maximum=0.010)
    small, large = deposit(radii, box=(0.2, None)), deposit(1000.0 * radii, box=(200.0, None))
    np.testing.assert_allclose(large, 1000.0 * small, rtol=1e-9)


def test_finite_height():
    """Whole rows of equal grains: the floor of a box of 10 x 1 diameters takes ten."""
    assert len(deposit(np.full(10, 0.005), box=(0.1, 0.01))) == 10
