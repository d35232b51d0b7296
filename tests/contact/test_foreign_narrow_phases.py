"""Narrow phases of strangers that return what they must not: the run stops with a sentence that names them."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from segment import Segment

import lmgcpy as lm
from lmgcpy.contact.contactor_pairs import _pairs, disk_disk, disk_wall, known_pairs
from lmgcpy.contact.foreign_pairs import check_narrow_phase
from lmgcpy.contact.neighbours import KindPair

NEAR = 0.0005


def sound(position_c, shape_c, position_a, shape_a):
    """A disk on a disk of radius 1 m."""
    x, y = position_c[0] - position_a[0], position_c[1] - position_a[1]
    d = math.sqrt(x * x + y * y)
    return d - shape_c[0] - shape_a[0], (x / d, y / d), (position_a[0] + x / d, position_a[1] + y / d)


def off_centre(change):
    """The same, with what is changed in its answer (gap, n_x, n_y, p_x, p_y)."""

    def narrow(position_c, shape_c, position_a, shape_a):
        gap, n, p = sound(position_c, shape_c, position_a, shape_a)
        gap, n_x, n_y, p_x, p_y = change(gap, n[0], n[1], p[0], p[1])
        return gap, (n_x, n_y), (p_x, p_y)

    return narrow


def returning(answer):
    def narrow(position_c, shape_c, position_a, shape_a):
        return answer

    return narrow


def raising(position_c, shape_c, position_a, shape_a):
    """Sound, but for a branch near the surface."""
    gap, n, p = disk_disk(position_c, shape_c, position_a, shape_a)
    if gap < NEAR:
        raise ValueError("boo")
    return gap, n, p


def out_of_range(position_c, shape_c, position_a, shape_a):
    return shape_c[5], (0.0, 1.0), (0.0, 1.0)


def not_compiled(position_c, shape_c, position_a, shape_a):
    return float(f"{position_c[1] - 1.1:.6f}"), (0.0, 1.0), (position_a[0], position_a[1] + 1.0)


FAULTS = (
    "normal of length two",
    "normal of no length",
    "normal that is no number",
    "gap that is no number near",
    "gap inf",
    "gap -inf",
    "point far away",
    "point a little off",
    "point that is no number",
)


def faulty(position_c, shape_c, position_a, shape_a):
    """All faults in one function, which is compiled once; the antagonist's second number says which."""
    gap, (n_x, n_y), (p_x, p_y) = sound(position_c, shape_c, position_a, shape_a)
    fault = int(shape_a[1])
    if fault == 0:
        n_x, n_y = 2.0 * n_x, 2.0 * n_y
    elif fault == 1:
        n_x, n_y = 0.0, 0.0
    elif fault == 2:
        n_x = math.nan
    elif fault == 3 and gap <= NEAR:
        gap = math.nan
    elif fault == 4:
        gap = math.inf
    elif fault == 5:
        gap = -math.inf
    elif fault == 6:
        p_x, p_y = 1e9, 1e9
    elif fault == 7:
        p_y += 0.11
    elif fault == 8:
        p_x = math.nan
    return gap, (n_x, n_y), (p_x, p_y)


SENTENCE = {
    "normal of length two": (faulty, "length one"),
    "normal of no length": (faulty, "length one"),
    "normal that is no number": (faulty, "length one"),
    "gap that is no number near": (faulty, "gap of nan"),
    "gap inf": (faulty, "gap of inf"),
    "gap -inf": (faulty, "gap of -inf"),
    "point far away": (faulty, "contact point 1.41421e\\+09 m"),
    "point a little off": (faulty, "contact point .* farther than"),
    "point that is no number": (faulty, "contact point nan m"),
    "raises": (raising, r"raised ValueError\('boo'\)"),
}
AT_ONCE = {
    "of three": (returning((0.0, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0))), r"expected \(gap, \(n_x, n_y\), \(p_x, p_y\)\)"),
    "without a point": (returning((0.0, (0.0, 1.0))), "expected"),
    "of nothing": (returning(None), "returned None, expected"),
    "of words": (returning(("0", (0.0, 1.0), (0.0, 1.0))), "expected"),
    "of a list": (returning((0.0, [0.0, 1.0], [0.0, 1.0])), "expected"),
    "out of range": (out_of_range, "raised IndexError"),
    "not compiled": (not_compiled, "cannot be compiled"),
}


def inward(sign):
    """The normal of :func:`off_centre`, by the sign of the gap."""
    return off_centre(lambda g, x, y, p, q: (g, sign(g) * x, sign(g) * y, p, q))


def scene(narrow, monkeypatch, flipped=False, fault=-1):
    """A disk of 1 kg a millimetre above something round of radius 1 m that meets it so."""
    kind = "test-odd"
    pair = (kind, "disk") if flipped else ("disk", kind)
    monkeypatch.setitem(_pairs, pair, None)
    if flipped:

        def other_way(position_c, shape_c, position_a, shape_a):
            return narrow(position_c, shape_c, position_a, shape_a)

        lm.contact.register_pair(*pair, other_way)
    else:
        lm.contact.register_pair(*pair, narrow)
    odd = type(
        "Odd",
        (lm.Contactor,),
        {"KIND": kind, "shape": (1.0, fault), "bounding_radius": 1.0, "area": 3.0, "second_moment": 1.0},
    )
    made = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    made.add(lm.disk(radius=0.1, position=(0.0, 1.101), mass=1.0))
    made.add(lm.RigidBody([odd()], mass=1.0, inertia=1.0, position=(0, 0), color="ODD")).fix()
    made.see("GRAIN", "ODD", lm.Coulomb(friction=0.3))
    return made


@pytest.mark.default_parameters(overlap=("ignore",))
@pytest.mark.parametrize("overlap", ["warn", "ignore"])
@pytest.mark.parametrize("what", SENTENCE)
def test_a_wrong_answer_is_named_with_pair_and_step(what, overlap, monkeypatch):
    """The step in which it comes is not made. At the start the look at overlaps finds it, if there is one."""
    narrow, words = SENTENCE[what]
    made = scene(narrow, monkeypatch, fault=FAULTS.index(what) if what in FAULTS else -1)
    where = r"(At the start|In the step from t = [0-9.]+ s) the narrow phase disk-test-odd \(.*\) between bodies 0 and 1 .*"
    with pytest.raises(RuntimeError, match=where + words) as told:
        lm.Simulation(made, time_step=1e-3, overlap=overlap).run(steps=100)
    if what == "raises":
        assert "t = 0.01 s" in str(told.value)  # 9.81/2 t^2 = 0.5 mm after 10 steps of 1 ms
        assert isinstance(told.value.__cause__, ValueError)


@pytest.mark.parametrize("what", AT_ONCE)
def test_an_answer_of_a_wrong_shape_is_named_before_it_is_compiled(what, monkeypatch):
    narrow, words = AT_ONCE[what]
    with pytest.raises(TypeError, match=r"The narrow phase disk-test-odd \(.*\) .*" + words):
        lm.Simulation(scene(narrow, monkeypatch), time_step=1e-3).step()


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize(
    ("sign", "where"),
    [
        (lambda g: -1.0, "are apart"),
        (lambda g: math.copysign(1.0, g), "overlap"),
        (lambda g: -1.0 if 0.0 < g < NEAR else 1.0, "have a gap of 0.00011 m"),
        (lambda g: -1.0 if -1e-6 < g < 0.0 else 1.0, "have a gap of -1.1e-07 m"),
    ],
    ids=["always", "of overlaps", "close to touching", "of least overlaps"],
)
def test_a_normal_that_points_inward_is_named_before_it_is_compiled(sign, where, flipped, monkeypatch):
    """Of length one, so that nothing else finds it: bodies would be held together. n = d / gap does so in overlaps. A
    branch near the surface is found from a millionth of the size on."""
    words = rf"The narrow phase .* returned a normal that points inward for contactors that {where}: .* turn its sign"
    with pytest.raises(ValueError, match=words):
        lm.Simulation(scene(inward(sign), monkeypatch, flipped), time_step=1e-3).step()


@pytest.mark.default_parameters(seed=range(3))
@pytest.mark.parametrize("seed", range(20))
def test_no_pair_of_lmgcpys_own_is_taken_for_inward(seed):
    """Nor a capsule: shapes by chance, sizes over six octaves, either order."""
    random = np.random.default_rng(seed)

    def direction(size):
        given = random.normal(size=size)
        return tuple(given / np.linalg.norm(given))

    radius = lambda: (2.0 ** random.uniform(-3.0, 3.0),)  # noqa: E731
    shapes = {
        "disk": radius,
        "sphere": radius,
        "wall": lambda: direction(2),
        "plane": lambda: direction(3),
        "cylinder": lambda: (*direction(3), *radius()),
        Segment.KIND: lambda: (*radius(), *radius()),
    }
    flat = ("disk", "wall", Segment.KIND)
    own = [pair for pair in known_pairs() if pair[0] in shapes and pair[1] in shapes]
    assert len(own) >= 6
    for pair in own:
        for kinds in (pair, pair[::-1]):
            given = [shapes[kind]() for kind in kinds]
            table = SimpleNamespace(
                shape=np.array([[*shape, *[0.0] * (4 - len(shape))] for shape in given]),
                bounding_radius=np.array([sum(s) if k in ("disk", "sphere", Segment.KIND) else math.inf
                                          for k, s in zip(kinds, given, strict=True)]),
            )  # fmt: skip
            first = np.array([True, False])
            asked = KindPair(*kinds, first, ~first, (len(given[0]), len(given[1])))
            check_narrow_phase(asked, table, 2 if kinds[0] in flat else 3)


def test_a_sound_one_carries_the_disk(monkeypatch):
    """Its weight, 9.81 N in a step of 1 ms, and it stands on top at 1.1 m."""
    sim = lm.Simulation(scene(sound, monkeypatch), time_step=1e-3)
    sim.run(steps=100)
    assert sim.interactions.impulse[0, 0] == pytest.approx(9.81e-3, rel=1e-9)
    assert sim.positions[0, 1] == pytest.approx(1.1, abs=1e-9)


@pytest.mark.parametrize("pair", [("disk", "disk"), ("disk", "wall"), ("wall", "disk"), ("plane", "sphere")])
def test_what_lmgcpy_knows_is_not_replaced(pair):
    def narrow(position_c, shape_c, position_a, shape_a):
        return 1.0, (0.0, 1.0), (0.0, 0.0)

    before = dict(_pairs)
    with pytest.raises(ValueError, match="is lmgcpy's own"):
        lm.contact.register_pair(*pair, narrow)
    assert before == _pairs
    lm.contact.register_pair("disk", "wall", disk_wall, central=True)  # what it is already
    assert np.array_equal(list(before), list(_pairs))
