"""A law that a scene meets for the first time is asked in plain Python: faults are told before anything is compiled."""

from __future__ import annotations

import pytest

import lmgcpy as lm
from lmgcpy.laws.first_calls import check_answers


class Sound(lm.Law):
    """A frictionless contact."""

    NAME = "test-first-calls"
    APPLIES_TO = "contact"
    PREPARED = ("bias",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


def too_many(gap, reference_gap, velocity, time_step, parameters, state):
    return (max(gap, 0.0) / time_step, 1.0)


def none_on_a_branch(W, u, prepared):
    if u[0] < 0.0:
        return (-u[0] / W[0][0],)
    return None


def a_list(W, u, prepared):
    return [max(0.0, -u[0] / W[0][0])]


def words(W, u, prepared):
    return ("push",)


def unknown_name(W, u, prepared):
    return (max(0.0, -u[0] - bias),)  # noqa: F821


def no_matrix(W, u, prepared):
    return (max(0.0, -u[0] / W[1][1]),)


def of_2d(W, u, prepared):
    (w_nn, _), (_, _) = W
    return (max(0.0, -u[0] / w_nn), 0.0)


def slope_of_one_number(W, u, prepared):
    return (-1.0 / W[0][0],)


def slope_of_words(W, u, prepared):
    return (("steep",),)


def with_function(name, function):
    return type("Faulty", (Sound,), {name: staticmethod(function)})()


def scene_with(law, dimension=2):
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    scene.add(make(radius=0.1, position=(0.0,) * (dimension - 1) + (0.5,), mass=1.0))
    scene.add(lm.wall(point=(0.0,) * dimension, normal=(0.0,) * (dimension - 1) + (1.0,)))
    scene.see("GRAIN", "WALL", law)
    return scene


FAULTS = [
    (
        "prepare",
        too_many,
        r"prepare\(.*\) returned \(.*, 1.0\), expected a tuple of 1 numbers, one for each name in PREPARED",
    ),
    ("react", none_on_a_branch, r"react\(.*\) returned None, expected a tuple of 1 numbers, one for each row of the law"),
    ("react", a_list, r"returned \[.*\], expected a tuple of 1 numbers"),
    ("react", words, r"returned \('push',\), expected a tuple of 1 numbers"),
    ("react", unknown_name, "raised NameError: name 'bias' is not defined"),
    ("react", no_matrix, "raised IndexError"),
    ("slope", slope_of_one_number, r"slope\(.*\) returned \(-1.0,\), expected a tuple of 1 rows, each a tuple of 1"),
    ("slope", slope_of_words, "slope.* returned 'steep' in a row, expected a number"),
    ("energy", lambda gap, reference_gap, parameters, state: None, "returned None, expected a number"),
]


@pytest.mark.parametrize(("name", "function", "words"), FAULTS, ids=[f"{n}-{f.__name__}" for n, f, _ in FAULTS])
def test_a_faulty_law_is_refused_where_a_scene_is_compiled(name, function, words):
    """No step is made, though the one body is far from the wall."""
    with pytest.raises(TypeError, match=rf"Law 'test-first-calls' \(.*Faulty\): .*{words}"):
        lm.Simulation(scene_with(with_function(name, function)), time_step=1e-3)


def test_a_law_of_two_components_is_refused_in_3d_only():
    law = type("Planar", (Sound,), {"react": staticmethod(of_2d), "rows": lambda self, dimension: dimension})()
    lm.Simulation(scene_with(law), time_step=1e-3)
    with pytest.raises(TypeError, match="too many values to unpack"):
        lm.Simulation(scene_with(law, 3), time_step=1e-3)


def test_a_law_may_say_that_it_is_for_2d():
    planar = type("Planar", (Sound,), {"DIMENSIONS": (2,)})()
    scene_with(planar)
    with pytest.raises(ValueError, match="Law 'test-first-calls' is for scenes in 2D, this one is in 3D"):
        scene_with(planar, 3)


def test_a_law_that_only_great_numbers_trouble_is_left_to_the_run():
    """A division by zero is told where it happens, with the bodies: a law need not expect what no scene has."""
    check_answers(with_function("prepare", lambda gap, reference_gap, velocity, *rest: (1.0 / velocity[0],)), 2)


def test_a_law_is_asked_once(monkeypatch):
    calls = []

    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        calls.append(gap)
        return (0.0,)

    law = with_function("prepare", prepare)
    for _ in range(2):
        check_answers(law, 2)
        asked = len(calls)
    assert len(calls) == asked > 50
    law = type(law)()
    check_answers(law, 2)
    assert len(calls) == asked
