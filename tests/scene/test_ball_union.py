"""Volume, centre and inertia of unions of disks and spheres against closed forms, samples and invariances."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lmgcpy.measure.density import disk_union
from lmgcpy.scene.solid import ball_union, checked_balls

CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
SPHERE = 4.0 / 3.0 * math.pi


def of_revolution(at, radii):
    """Volume, centre and (axial, transverse) inertia of spheres at the places ``at`` of an axis, of which only successive
    ones overlap: integrals of pi rho^2 and of its moments between the planes where spheres meet, polynomials in the place.
    """
    walls = [(b**2 - a**2 + r**2 - s**2) / (2 * (b - a)) for (a, b), (r, s) in zip(pairs(at), pairs(radii), strict=True)]
    joined = [b - a < r + s for (a, b), (r, s) in zip(pairs(at), pairs(radii), strict=True)]
    moments = np.zeros(4)
    for i, (centre, r) in enumerate(zip(at, radii, strict=True)):
        low = walls[i - 1] - centre if i > 0 and joined[i - 1] else -r
        high = walls[i] - centre if i < len(walls) and joined[i] else r
        rho2, place = np.polynomial.Polynomial([r**2, 0.0, -1.0]), np.polynomial.Polynomial([centre, 1.0])
        integrands = [rho2, rho2 * place, rho2 * place**2, rho2**2]
        moments += math.pi * np.array([g.integ()(high) - g.integ()(low) for g in integrands])
    volume, first, second, fourth = moments
    axial = 0.5 * fourth
    return volume, first / volume, axial, 0.5 * axial + second - first**2 / volume


def pairs(items):
    return list(itertools.pairwise(items))


def sample(x, r, count, seed):
    """Volume, centre and inertia by ``count`` random points in the bounding box, with their standard errors."""
    rng = np.random.default_rng(seed)
    low, high = (x - r[:, None]).min(axis=0), (x + r[:, None]).max(axis=0)
    points = rng.uniform(low, high, size=(count, x.shape[1]))
    inside = np.zeros(count, dtype=bool)
    for centre, radius in zip(x, r, strict=True):
        inside |= ((points - centre) ** 2).sum(axis=1) < radius**2
    box = np.prod(high - low)
    about = points - x.mean(axis=0)
    powers = [np.ones(count), *about.T, *(a * b for a, b in itertools.combinations_with_replacement(about.T, 2))]
    values = np.array([inside * power for power in powers])
    return box * values.mean(axis=1), box * values.std(axis=1) / math.sqrt(count)


def moments(solid, about):
    """1, x ... and xx, xy ... about a point, from volume, centre and inertia: the parallel axis theorem backwards."""
    d = len(solid.centre)
    shift = solid.centre - about
    second = 0.5 * np.trace(solid.inertia) * np.eye(3) - solid.inertia if d == 3 else None
    out = [solid.volume, *(solid.volume * shift)]
    if d == 3:
        second += solid.volume * np.outer(shift, shift)
        out += [second[a, b] for a, b in itertools.combinations_with_replacement(range(3), 2)]
    return np.array(out)


@pytest.mark.parametrize("ratio", [1.0, 0.6, 0.05])
@pytest.mark.parametrize("overlap", [1.0, 0.5, 1e-2, 1e-6, 1e-12, 0.0, -1.0])
def test_two_spheres(overlap, ratio):
    """Two caps, in a direction that is no axis. Radii 1 and ``ratio``; the overlap is a part of what makes the smaller one
    nested, 2 ``ratio``; 1: nested, 0: touching, -1: apart."""
    distance = 1.0 + ratio - 2.0 * ratio * overlap
    way = np.array([0.48, -0.6, 0.64])
    solid = ball_union(np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0] + distance * way]), np.array([1.0, ratio]))
    if overlap == 1.0:
        volume, centre, axial, across = SPHERE, 0.0, 0.4 * SPHERE, 0.4 * SPHERE
    else:
        volume, centre, axial, across = of_revolution([0.0, distance], [1.0, ratio])
    # rounding only: the tolerance of the quadrature is above what its finer rule leaves
    assert solid.volume == pytest.approx(volume, rel=1e-13)
    np.testing.assert_allclose(solid.centre, np.array([1.0, 2.0, 3.0]) + centre * way, atol=1e-13)
    expected = across * np.eye(3) + (axial - across) * np.outer(way, way)
    np.testing.assert_allclose(solid.inertia, expected, atol=1e-13 * across)
    assert solid.error < 1e-10


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (2 / 3, -1 / 3, 2 / 3)])
def test_a_chain_of_spheres(axis):
    """Fifty spheres of three sizes in a row. The axial moment is 1/3000 of the others, and loses as many digits."""
    at = np.arange(50) * 1.5
    radii = np.array([1.0, 0.9, 1.1] * 17)[:50]
    volume, centre, axial, across = of_revolution(at, radii)
    solid = ball_union(np.outer(at, axis), radii)
    assert solid.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(solid.centre, centre * np.array(axis), atol=1e-11)
    np.testing.assert_allclose(axis @ solid.inertia @ axis, axial, rtol=1e-10)
    np.testing.assert_allclose(np.trace(solid.inertia), axial + 2 * across, rtol=1e-12)
    assert solid.error < 1e-8


def test_spheres_that_share_a_circle_and_spheres_within_others():
    """The middle one of three spheres through one circle adds nothing, neither do spheres inside, copies and twins."""
    at = np.array([-1.0, 2.0])
    volume, _, axial, across = of_revolution(at, np.sqrt(1.0 + at**2))
    at = np.array([-1.0, 0.5, 2.0, 2.0, 2.0 + 1e-14, 2.5])
    radii = np.array([*np.sqrt(1.0 + at[:4] ** 2), math.sqrt(5.0), 0.3])
    for way in np.vstack([np.eye(3), [[0.6, 0.0, 0.8]]]):
        solid = ball_union(np.outer(at, way), radii)
        assert solid.volume == pytest.approx(volume, rel=1e-13)
        assert way @ solid.inertia @ way == pytest.approx(axial, rel=1e-12)
        assert np.trace(solid.inertia) == pytest.approx(axial + 2 * across, rel=1e-12)


def test_four_spheres_leave_the_reuleaux_tetrahedron():
    """Unit spheres around the corners of a tetrahedron of edge 1: by inclusion and exclusion what all four share is
    (3 sqrt 2 - 49 pi + 162 arctan sqrt 2) / 12 (Weisstein, MathWorld, Reuleaux Tetrahedron)."""
    x = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / math.sqrt(8.0)

    def union(count):
        return ball_union(x[:count], np.ones(count)).volume

    two = 2 * SPHERE - union(2)
    three = union(3) - 3 * SPHERE + 3 * two
    four = 4 * SPHERE - 6 * two + 4 * three - union(4)
    assert two == pytest.approx(5.0 / 12.0 * math.pi, rel=1e-13)
    assert four == pytest.approx((3 * math.sqrt(2) - 49 * math.pi + 162 * math.atan(math.sqrt(2))) / 12, rel=1e-12)


@pytest.mark.parametrize("radius", [1.0, 1.3, math.sqrt(2.0), 1.6, math.sqrt(3.0)])
def test_eight_spheres_of_a_cube(radius):
    """Touching; overlapping; many circles meet in the middles of faces, and all spheres in the centre: the places where
    decisions by rounding could go wrong. The cubic symmetry makes the inertia a number; a sample gives it."""
    solid = ball_union(CUBE, np.full(8, radius))
    np.testing.assert_allclose(solid.centre, 0.0, atol=1e-14)
    np.testing.assert_allclose(solid.inertia, solid.inertia[0, 0] * np.eye(3), atol=1e-13 * solid.inertia[0, 0])
    mean, sigma = sample(CUBE, np.full(8, radius), 20_000, seed=1)
    assert (np.abs(moments(solid, np.zeros(3)) - mean) < 4.0 * sigma).all()
    if radius == 1.0:
        assert solid.volume == pytest.approx(8 * SPHERE, rel=1e-13)
        assert solid.inertia[0, 0] == pytest.approx(8 * SPHERE * (0.4 + 2.0), rel=1e-13)


@pytest.mark.parametrize(("count", "spread"), [(3, 0.4), (8, 0.6), (20, 0.9), (20, 0.3), (50, 1.2)])
def test_random_spheres_against_a_sample(count, spread):
    """Ten moments lie within four standard errors of 20 000 random points (once in a thousand draws one does not)."""
    rng = np.random.default_rng(count)
    x, r = rng.normal(size=(count, 3)) * spread + 1.0, rng.uniform(0.3, 1.0, count)
    solid = ball_union(x, r)
    mean, sigma = sample(x, r, 20_000, seed=2)
    assert (np.abs(moments(solid, x.mean(axis=0)) - mean) < 4.0 * sigma).all()
    assert solid.error < 1e-8


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e3])
def test_invariances_in_space(seed, scale):
    """Rotated, moved, scaled and permuted spheres have the same moments, and other break points: a check of the error."""
    rng = np.random.default_rng(seed)
    count = (3, 8, 15, 30)[seed]
    x, r = rng.normal(size=(count, 3)) * 0.7, rng.uniform(0.3, 1.0, count)
    solid = ball_union(x, r)
    turn, order, shift = Rotation.random(random_state=seed).as_matrix(), rng.permutation(count), rng.normal(size=3)
    other = ball_union(scale * (x @ turn.T + shift)[order], scale * r[order])
    assert other.volume == pytest.approx(scale**3 * solid.volume, rel=1e-12)
    assert abs(other.volume / (scale**3 * solid.volume) - 1.0) < solid.error + other.error
    np.testing.assert_allclose(other.centre, scale * (turn @ solid.centre + shift), atol=1e-12 * scale)
    expected = scale**5 * turn @ solid.inertia @ turn.T
    np.testing.assert_allclose(other.inertia, expected, atol=1e-12 * expected.max())


def test_parts_add_up_by_the_parallel_axis_theorem():
    rng = np.random.default_rng(5)
    x, r = rng.normal(size=(12, 3)) * 0.5, rng.uniform(0.3, 1.0, 12)
    x[6:] += [4.0, -5.0, 3.0]
    whole, parts = ball_union(x, r), [ball_union(x[:6], r[:6]), ball_union(x[6:], r[6:])]
    inertia = np.zeros((3, 3))
    for part in parts:
        lever = part.centre - whole.centre
        inertia += part.inertia + part.volume * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    assert whole.volume == pytest.approx(sum(part.volume for part in parts), rel=1e-12)
    np.testing.assert_allclose(whole.inertia, inertia, atol=1e-12 * inertia.max())


def lens(distance):
    """Area and polar moment about its centre of two unit disks: two segments from the chord on, by a quadrature of their
    own (200 Gauss points in the angle of the circle)."""
    if distance >= 2.0:
        return 2 * math.pi, 2 * (0.5 * math.pi + math.pi * distance**2 / 4)
    low = -0.5 * distance
    node, weight = np.polynomial.legendre.leggauss(200)
    first = math.asin(low)
    angle = first + 0.5 * (node + 1.0) * (0.5 * math.pi - first)
    weight = weight * 0.5 * (0.5 * math.pi - first) * np.cos(angle)
    along, half = np.sin(angle) + 0.5 * distance, np.cos(angle)
    return 2 * (weight * 2 * half).sum(), 2 * (weight * (2 * half * along**2 + 2 * half**3 / 3)).sum()


@pytest.mark.parametrize("distance", [1e-9, 0.3, 1.0, 1.9, 2.0 - 1e-12, 2.0, 3.0])
def test_two_disks(distance):
    area, polar = lens(distance)
    way = np.array([-0.6, 0.8])
    solid = ball_union(np.array([[1.0, 2.0], [1.0, 2.0] + distance * way]), np.ones(2))
    assert solid.volume == pytest.approx(area, rel=1e-13)
    assert solid.inertia == pytest.approx(polar, rel=1e-12)
    np.testing.assert_allclose(solid.centre, [1.0, 2.0] + 0.5 * distance * way, rtol=1e-13)


def test_random_disks():
    """Their area is that of ``measure``; centre and polar moment against a sample; turned, moved, scaled and permuted."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        x, r = rng.normal(size=(10, 2)), rng.uniform(0.2, 0.7, 10)
        solid = ball_union(x, r)
        assert solid.volume == pytest.approx(disk_union(x, r), rel=1e-13)
        mean, sigma = sample(x, r, 20_000, seed=3)
        about = x.mean(axis=0)
        assert (np.abs(moments(solid, about) - mean[:3]) < 4.0 * sigma[:3]).all()
        polar = solid.inertia + solid.volume * ((solid.centre - about) ** 2).sum()
        assert abs(polar - mean[3] - mean[5]) < 4.0 * (sigma[3] + sigma[5])
        c, s = math.cos(seed), math.sin(seed)
        order = rng.permutation(10)
        other = ball_union(0.01 * (x @ np.array([[c, s], [-s, c]]) + 3.0)[order], 0.01 * r[order])
        assert other.volume == pytest.approx(1e-4 * solid.volume, rel=1e-12)
        assert other.inertia == pytest.approx(1e-8 * solid.inertia, rel=1e-11)


def test_a_disk_in_a_hole_of_disks():
    """Six disks around one that touches none of them: the ring has a hole, and the area adds."""
    angle = np.arange(6) * math.pi / 3
    ring = 2.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    around = ball_union(ring, np.full(6, 1.1))
    whole = ball_union(np.vstack([ring, [[0.0, 0.0]]]), np.array([1.1] * 6 + [0.5]))
    assert whole.volume == pytest.approx(around.volume + 0.25 * math.pi, rel=1e-13)
    assert whole.inertia == pytest.approx(around.inertia + 0.5 * math.pi * 0.5**4, rel=1e-13)


def test_refused_balls():
    good = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    for radii, offsets, message in [
        ([], np.zeros((0, 3)), "at least one number"),
        (1.0, good, "at least one number"),
        ([1.0, 1.0], good[:1], r"shape \(2, 3\)"),
        ([1.0, 1.0], [0.0, 1.0], r"shape \(2, 3\)"),
        ([1.0, 0.0], good, "above 0 m, got 0 m for ball 1"),
        ([1.0, -2.0], good, "above 0 m, got -2 m for ball 1"),
        ([1.0, math.nan], good, "radii of a clump must be finite"),
        ([1.0, 1.0], [[0, 0, 0], [math.inf, 0, 0]], "offsets of a clump must be finite"),
        ([0.3, 0.3, 0.3], [[0, 0, 0], [2, 0, 0], [0.5, 0, 0]], r"balls 2 and 1 are 0.9 m apart, .* separate=True"),
    ]:
        with pytest.raises(ValueError, match=message):
            checked_balls(radii, offsets)
    with pytest.raises(TypeError, match="radii of a clump must be an array of numbers"):
        checked_balls("round", good)
    with pytest.raises(TypeError, match="separate must be True or False"):
        checked_balls([1.0, 1.0], good, separate=1)


def test_accepted_balls():
    """Touching ones whose offsets are rounded, a chain that joins its ends only, and separate ones if asked."""
    checked_balls([1.0, 1.0], [[0, 0, 0], [2.0000001, 0, 0]])
    checked_balls([1.0, 1.0, 1.0], [[0, 0], [4, 0], [2, 0]])
    radii, offsets = checked_balls([1, 1], [[0, 0, 0], [5, 0, 0]], separate=True)
    assert ball_union(offsets, radii).volume == pytest.approx(2 * SPHERE, rel=1e-13)
