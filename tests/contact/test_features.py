"""Features of surfaces: together they are as far away as the surface, and a ball meets one, but in hollow corners more."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lmgcpy.contact.features import (
    IN_PLANE,
    IN_SPACE,
    Corners,
    corner_shapes,
    edge_shapes,
    facet_shapes,
    kept_corners,
    kept_edges,
    oriented,
    ridges_of,
    topology,
)

PLACE = (0.3, -0.2, 0.15)
TURN = tuple(Rotation.from_rotvec([0.3, -0.7, 0.5]).as_quat())


def grid(n, height=lambda x, y: 0.0 * x):
    """Corners and triangles of a sheet of n x n squares of side one."""
    x, y = (along.ravel().astype(float) for along in np.meshgrid(range(n + 1), range(n + 1), indexing="ij"))
    square = [(n + 1) * i + j for i, j in product(range(n), repeat=2)]
    triangles = [t for a in square for t in ((a, a + n + 1, a + n + 2), (a, a + n + 2, a + 1))]
    return np.column_stack([x, y, height(x, y)]), np.array(triangles)


def rough(seed, n=3):
    noise = np.random.default_rng(seed).normal(0.0, 0.5, (n + 1) ** 2)
    return grid(n, lambda x, y: noise)


def solid(points):
    """The convex hull of points, its triangles facing outward."""
    hull = ConvexHull(points)
    used, triangles = np.unique(hull.simplices, return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3)
    normal = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]], points[triangles[:, 2]] - points[triangles[:, 0]])
    inward = (normal * (points[triangles[:, 0]] - points.mean(axis=0))).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles


class Surface:
    """The features of a surface at a place, and what a ball meets of them."""

    def __init__(self, points, cells, radius=0.0, one_sided=False, place=(*PLACE, *TURN)):
        self.points, self.radius, self.place = points, radius, place
        d = self.d = points.shape[1]
        net = self.net = topology(cells, len(points), dimension=d)
        at = Corners(points, net)
        ridges = ridges_of(at)
        facets = facet_shapes(at, radius, one_sided=one_sided, ridges=ridges)
        corners = corner_shapes(at, radius)[kept_corners(at, one_sided=one_sided)]
        kinds = [("face" if d == 3 else "line", facets), ("corner" if d == 3 else "tip", corners)]
        if d == 3:
            kept = kept_edges(ridges, one_sided=one_sided)
            kinds.append(("edge", edge_shapes(at, radius, ridges=ridges)[kept]))
        self.shapes = [(kind, tuple(shape)) for kind, shapes in kinds for shape in shapes.tolist()]
        pairs, ball = (IN_PLANE, "disk") if d == 2 else (IN_SPACE, "sphere")
        self.meet = {kind: oriented(pairs[ball, kind], len(place)) for kind, _ in kinds}

    def in_space(self, point):
        """A point of the body in space."""
        if self.d == 2:
            c, s = math.cos(self.place[2]), math.sin(self.place[2])
            return np.array([[c, -s], [s, c]]) @ point + self.place[:2]
        turned = Rotation.from_quat(self.place[3:]).apply(point) if len(self.place) == 7 else np.array(point)
        return np.array(self.place[:3]) + turned

    def meetings(self, point, radius=0.1):
        """(kind, gap, normal, point) of each feature that a ball around a point of the body meets."""
        at = self.in_space(point)
        centre = (*at, 0.0) if self.d == 2 else (*at, *self.place[3:])
        found = [(kind, *self.meet[kind](tuple(centre), (radius,), self.place, shape)) for kind, shape in self.shapes]
        return [answer for answer in found if math.isfinite(answer[1])]

    def distance(self, point):
        """Distance of a point of the body from the surface, by its parts."""
        return min(triangle_distance(point, self.points[f]) for f in self.net.facets)


def triangle_distance(x, corners):
    """Distance of a point from the hull of two or three points, by the foot in each of its sides."""
    base, sides = corners[0], (corners[1:] - corners[0]).T
    part = np.linalg.lstsq(sides, x - base, rcond=None)[0]
    if (part >= 0.0).all() and part.sum() <= 1.0:
        return float(np.linalg.norm(x - base - sides @ part))
    if len(corners) == 2:
        return float(np.linalg.norm(x - corners, axis=1).min())
    return min(triangle_distance(x, np.delete(corners, k, axis=0)) for k in range(3))


def polyline(seed, count=7):
    points = np.column_stack([np.arange(count), np.random.default_rng(seed).normal(0.0, 0.6, count)]).astype(float)
    return points, np.column_stack([np.arange(count - 1), np.arange(1, count)])


SURFACES = {
    "rough": lambda seed: Surface(*rough(seed), radius=0.05),
    "flat": lambda seed: Surface(*grid(3)),
    "hull": lambda seed: Surface(*solid(np.random.default_rng(seed).normal(size=(12, 3)))),
    "line": lambda seed: Surface(*polyline(seed), radius=0.05, place=(0.3, -0.2, 0.7)),
}


@pytest.mark.default_parameters(seed=(0,))
@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_nearest_feature_is_as_far_as_the_surface(name, seed):
    """The distance by the features is the distance by minimising over the surface; the centre is off the middle of the gap
    along the normal; and the features that are met besides are at other feet, farther away."""
    surface, rng = SURFACES[name](seed), np.random.default_rng(seed)
    low, high = surface.points.min(axis=0) - 1.0, surface.points.max(axis=0) + 1.0
    for point in rng.uniform(low, high, (40, surface.d)):
        found = surface.meetings(point)
        gaps = sorted(gap for _, gap, _, _ in found)
        true = surface.distance(point)
        assert gaps[0] == pytest.approx(true - 0.1 - surface.radius, abs=1e-12)
        assert len(gaps) == 1 or gaps[1] > gaps[0] + 1e-9
        for _, gap, n, middle in found:
            assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-14)
            away = surface.in_space(point) - np.array(middle)
            assert away == pytest.approx((0.1 + 0.5 * gap) * np.array(n), abs=1e-13)


@pytest.mark.default_parameters("place1")
@pytest.mark.parametrize("place", [PLACE, (*PLACE, *TURN)])
def test_a_ball_on_a_flat_mesh_meets_one_feature(place):
    """Inside, over edges and corners exactly, beside them by less than a rounding, and on both sides of the boundary.
    Within 1e-12 of the size of a corner of the boundary up to three are met, with the same normal."""
    surface = Surface(*grid(4), place=place)
    rng = np.random.default_rng(0)
    points = [np.array([x, y]) for x, y in product(np.arange(0.0, 4.5, 0.5), repeat=2)]
    points += [point + rng.normal(size=2) * 10.0 ** rng.uniform(-18, -10) for point in points for _ in range(20)]
    for point in points:
        for z in (0.1, -0.07):
            found = surface.meetings((*point, z))
            corner = np.abs(point - point.round()).max() < 5e-12 and (point.round() % 4.0 == 0.0).any()
            assert 1 <= len(found) <= (3 if corner else 1), (point.tolist(), found)
            outside = max(*(np.maximum(-point, 0.0) + np.maximum(point - 4.0, 0.0)))  # at most 1e-9
            for _, gap, n, _ in found:
                assert gap == pytest.approx(abs(z) - 0.1, abs=1e-14 + outside)
                assert n == pytest.approx(found[0][2], abs=1e-10)


def test_a_ball_around_a_box_meets_one_feature_outside_and_one_face_inside():
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    box = Surface(*solid(corners), one_sided=True)
    assert {kind: sum(kind == of for of, _ in box.shapes) for kind in ("face", "edge", "corner")} == {
        "face": 12,
        "edge": 12,
        "corner": 8,
    }
    for point in np.random.default_rng(0).uniform(-1.5, 1.5, (300, 3)):
        found = box.meetings(point, radius=1.0)
        deepest = np.abs(point).max() - 1.0
        if deepest > 0.0:
            assert len(found) == 1
            assert found[0][1] == pytest.approx(np.linalg.norm(np.maximum(np.abs(point) - 1.0, 0.0)) - 1.0, abs=1e-13)
        else:
            ((kind, gap, normal, _),) = found
            assert kind == "face"
            assert gap == pytest.approx(deepest - 1.0, abs=1e-13)
            assert bool(box.meetings(point, radius=0.1)) == (deepest >= -0.1)
            outward = Rotation.from_quat(TURN).inv().apply(normal)
            assert outward[np.abs(point).argmax()] * np.sign(point[np.abs(point).argmax()]) == pytest.approx(1.0)


def test_hollow_corners_have_a_contact_with_each_wall():
    """Inside of a box whose triangles face inward, near a corner."""
    points, triangles = solid(np.array(list(product((-1.0, 1.0), repeat=3))))
    room = Surface(points, triangles[:, ::-1], one_sided=True)
    assert {kind for kind, _ in room.shapes} == {"face"}
    for near, count in ((0.05, 3), (0.5, 3)):
        found = [gap for _, gap, _, _ in room.meetings((1 - near, 1 - near, 1 - near), radius=0.1) if gap < near]
        assert len(found) == count
        assert found == pytest.approx([near - 0.1] * 3, abs=1e-13)


def hull_distance(one, other):
    """Distance of the hulls of two sets of points, by non-negative least squares; heavy rows for the sums of weights."""
    heavy = 1e4
    A = np.block(
        [
            [one.T, -other.T],
            [heavy * np.ones(len(one)), np.zeros(len(other))],
            [np.zeros(len(one)), heavy * np.ones(len(other))],
        ]
    )
    weights = nnls(A, np.array([0.0, 0.0, 0.0, heavy, heavy]))[0]
    w, v = weights[: len(one)], weights[len(one) :]
    return float(np.linalg.norm(one.T @ (w / w.sum()) - other.T @ (v / v.sum())))


def turned(rng, points):
    """Points turned at random, and their place in space."""
    turn = Rotation.random(random_state=rng)
    position = rng.normal(size=3) * 1.5
    return (*position, *turn.as_quat()), turn.apply(points) + position


@pytest.mark.parametrize("seed", range(12))
def test_two_solids_are_as_far_as_their_nearest_features(seed):
    """Two hulls apart: the least gap of corners, edges and faces is their distance, and no pair of features is nearer."""
    rng = np.random.default_rng(seed)
    bodies = []
    for _ in range(2):
        points, triangles = solid(rng.normal(size=(8, 3)) * 0.4)
        place, there = turned(rng, points)
        bodies.append((Surface(points, triangles, radius=0.05, place=place), there))
    (one, points), (other, others) = bodies
    true = hull_distance(points, others)
    if true < 0.01:
        pytest.skip("they overlap")
    gaps = []
    for (kind, shape), (its_kind, its_shape) in product(one.shapes, other.shapes):
        if (kind, its_kind) in IN_SPACE:
            meet = oriented(IN_SPACE[kind, its_kind], 7)
            gaps.append(meet(one.place, shape, other.place, its_shape)[0])
        elif (its_kind, kind) in IN_SPACE:
            gaps.append(oriented(IN_SPACE[its_kind, kind], 7)(other.place, its_shape, one.place, shape)[0])
    assert min(gaps) == pytest.approx(true - 0.1, abs=1e-6)


@pytest.mark.parametrize("seed", range(12))
def test_a_capsule_is_as_far_as_its_nearest_parts(seed):
    """The two balls and the rod of a capsule beside a solid."""
    rng = np.random.default_rng(seed)
    points, triangles = solid(rng.normal(size=(10, 3)) * 0.5)
    place, there = turned(rng, points)
    surface = Surface(points, triangles, one_sided=True, place=place)
    half = np.array([0.0, 0.0, 0.6])
    at, ends = turned(rng, np.array([half, -half]))
    true = hull_distance(ends, there)
    if true < 0.01:
        pytest.skip("they overlap")
    gaps = []
    for kind, shape in surface.shapes:
        gaps += [surface.meet[kind]((*end, *at[3:]), (0.1,), place, shape)[0] for end in ends]
        if kind != "face":
            gaps.append(oriented(IN_SPACE["rod", kind], 7)(at, (0.1, *half), place, shape)[0])
    assert min(gaps) == pytest.approx(true - 0.1, abs=1e-6)
