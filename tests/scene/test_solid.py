"""Principal moments and axes."""

import itertools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lmgcpy.scene.solid import ball_union, principal_axes


@pytest.mark.parametrize("moments", [(1.0, 2.0, 3.0), (3.0, 1.0, 2.0), (2.0, 2.0, 1.0), (1.0, 2.0, 2.0), (1.0, 1.0, 1.0)])
def test_a_diagonal_tensor_keeps_its_axes_exactly(moments):
    """Products of inertia of 1e-10 are rounding."""
    inertia = np.diag(moments)
    inertia[0, 1] = inertia[1, 0] = 1e-10
    found, rotation = principal_axes(inertia)
    np.testing.assert_array_equal(rotation.as_matrix(), np.eye(3))
    np.testing.assert_array_equal(found, moments)


@pytest.mark.parametrize("moments", [(1, 2, 2.9), (2, 2, 1), (1.5, 1.5, 2.9), (1, 1, 1), (1, 1.0001, 1.5)])
def test_axes_of_random_tensors(moments):
    """Right-handed, they make the tensor diagonal, and none of the other sets of axes is at a smaller angle."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
        inertia = turn @ np.diag(moments) @ turn.T
        inertia = 0.5 * (inertia + inertia.T)
        found, rotation = principal_axes(inertia)
        axes = rotation.as_matrix()
        np.testing.assert_allclose(axes @ np.diag(found) @ axes.T, inertia, atol=1e-9)
        np.testing.assert_allclose(sorted(found), sorted(moments), rtol=1e-9)
        assert len(set(found)) == len(set(moments))  # equal moments are the same number
        for signs in itertools.product((1.0, -1.0), repeat=3):
            for order in itertools.permutations(range(3)):
                other = axes[:, order] * signs
                if np.linalg.det(other) > 0.0:
                    assert Rotation.from_matrix(other).magnitude() >= rotation.magnitude() - 1e-7


def test_two_equal_moments_turn_the_shortest_way():
    """The axis of the third moment is 0.3 rad from y: so is the rotation, and not about the axis itself."""
    for axis in ((0.0, math.cos(0.3), math.sin(0.3)), (0.0, -math.cos(0.3), -math.sin(0.3))):
        found, rotation = principal_axes(2.0 * np.eye(3) - np.outer(axis, axis))
        np.testing.assert_allclose(rotation.as_rotvec(), [0.3, 0.0, 0.0], atol=1e-12)
        np.testing.assert_allclose(found, [2.0, 1.0, 2.0], rtol=1e-12)


def test_small_turns_come_back():
    """Axes that are turned by less than 45 degrees are found with their order and their signs."""
    for seed in range(10):
        vector = np.random.default_rng(seed).normal(size=3)
        turn = Rotation.from_rotvec(0.7 * vector / np.linalg.norm(vector))
        found, rotation = principal_axes(turn.as_matrix() @ np.diag([2.0, 1.0, 2.5]) @ turn.as_matrix().T)
        assert (rotation * turn.inv()).magnitude() < 1e-12
        np.testing.assert_allclose(found, [2.0, 1.0, 2.5], rtol=1e-12)


def test_equal_angles_do_not_depend_on_rounding():
    """An axis along the diagonal of a cube is as near to x as to y and z: it is x, whatever the last digits."""
    axis = np.ones(3) / math.sqrt(3.0)
    tensor = 2.0 * np.eye(3) - np.outer(axis, axis)
    expected = principal_axes(tensor)[1].as_matrix()
    np.testing.assert_allclose(expected[:, 0], axis, rtol=1e-12)
    for seed in range(20):
        noise = 1e-15 * np.random.default_rng(seed).normal(size=(3, 3))
        np.testing.assert_allclose(principal_axes(tensor + noise + noise.T)[1].as_matrix(), expected, atol=1e-12)


def test_symmetric_clumps():
    """Four spheres of a tetrahedron turned in any way have three equal moments; three spheres in a triangle two."""
    tetrahedron = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    triangle = np.array([[1.0, 0, 0], [-0.5, math.sqrt(0.75), 0], [-0.5, -math.sqrt(0.75), 0]])
    turn = Rotation.from_rotvec([0.1, 0.5, -0.2]).as_matrix()
    moments, rotation = principal_axes(ball_union(tetrahedron @ turn.T, np.full(4, 1.5)).inertia)
    assert rotation.magnitude() == 0.0
    assert len(set(moments)) == 1
    moments, rotation = principal_axes(ball_union(triangle @ turn.T, np.ones(3)).inertia)
    np.testing.assert_allclose(rotation.as_matrix()[:, 2], turn[:, 2], atol=1e-10)
    assert moments[0] == moments[1] < moments[2]
