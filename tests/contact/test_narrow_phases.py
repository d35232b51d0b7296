"""The shapes that come with lmgcpy: gap, normal from the antagonist to the candidate, point in the middle of the gap."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.contactor_pairs import disk_disk, disk_wall, find_pair


@pytest.mark.parametrize("angle", np.linspace(0.0, 2.0 * math.pi, 9))
@pytest.mark.parametrize("gap", [-0.05, 0.0, 0.2])
def test_disk_on_disk(angle, gap):
    n = np.array([math.cos(angle), math.sin(angle)])
    antagonist = np.array([0.3, -0.2])
    candidate = antagonist + (0.5 + 0.2 + gap) * n
    found, normal, point = disk_disk((*candidate, 1.0), (0.5,), (*antagonist, 2.0), (0.2,))
    assert found == pytest.approx(gap, abs=1e-15)
    assert normal == pytest.approx(n, abs=1e-15)
    assert point == pytest.approx(antagonist + (0.2 + 0.5 * gap) * n, abs=1e-15)
    # the same seen from the other side
    back, opposite, same_point = disk_disk((*antagonist, 2.0), (0.2,), (*candidate, 1.0), (0.5,))
    assert back == pytest.approx(found, abs=1e-15)
    assert opposite == pytest.approx(-n, abs=1e-15)
    assert same_point == pytest.approx(point, abs=1e-15)


def test_concentric_disks_have_a_normal_all_the_same():
    gap, normal, point = disk_disk((1.0, 2.0, 0.0), (0.5,), (1.0, 2.0, 0.0), (0.25,))
    assert gap == -0.75
    assert normal == (0.0, 1.0)
    assert point == (1.0, 2.0 + 0.25 - 0.375)


@pytest.mark.parametrize("gap", [-0.05, 0.0, 0.2])
def test_disk_on_wall(gap):
    """Wherever along the wall: the wall's point says where its line is, not where it ends."""
    n, t = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    wall = np.array([0.1, -0.3])
    centre = wall + (0.5 + gap) * n + 12.0 * t
    found, normal, point = disk_wall((*centre, 0.0), (0.5,), (*wall, 0.0), tuple(n))
    assert found == pytest.approx(gap, abs=2e-15)
    assert normal == tuple(n)
    assert point == pytest.approx(wall + 12.0 * t + 0.5 * gap * n, abs=4e-15)


def test_the_reverse_order_is_known_and_flipped():
    assert find_pair("disk", "wall").flipped is False
    assert find_pair("wall", "disk").flipped is True
    assert find_pair("wall", "disk").narrow is disk_wall


def test_an_unknown_pair_gets_a_sentence():
    sentence = r"how contactors 'disk' and 'wal' meet; did you mean 'disk-wall'\?.*lmgcpy\.contact\.register_pair"
    with pytest.raises(LookupError, match=sentence):
        find_pair("disk", "wal")


def test_a_narrow_phase_with_other_arguments_is_refused():
    def narrow(a, b):
        return 0.0

    with pytest.raises(TypeError, match=r"takes \(position_c, shape_c, position_a, shape_a\), .*narrow takes \(a, b\)"):
        lm.contact.register_pair("test-a", "test-b", narrow)
