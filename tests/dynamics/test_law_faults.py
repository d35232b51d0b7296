"""A law that raises, returns what is not finite, or cannot be compiled: the run stops and says which, where, when."""

import math

import numpy as np
import pytest

import lmgcpy as lm

STEPS = 40
"""Enough for the ball to fall through its 2 cm: 64 steps of 1 ms without contact, it is thrown down at 1 m/s."""


class Contact(lm.Law):
    """Signorini, whose functions the tests below spoil one at a time."""

    NAME = "test-spoilt"
    APPLIES_TO = "contact"
    PREPARED = ("bias",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


class Wire(lm.Law):
    NAME = "test-spoilt-wire"
    APPLIES_TO = "link"
    PREPARED = ("bias",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (min(0.0, -(u[0] + prepared[0]) / W[0][0]),)

    @staticmethod
    def slope(W, u, prepared):
        return ((-1.0 / W[0][0] if u[0] + prepared[0] > 0.0 else 0.0,),)


def ball(**functions):
    """A ball (body 1) and one far off (body 0), both thrown at the floor (body 2); the contact law has these functions."""
    law = type("Spoilt", (Contact,), {name: staticmethod(function) for name, function in functions.items()})
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(5.0, 1.0), mass=1.0, velocity=(0.0, -1.0)))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.12), mass=1.0, velocity=(0.0, -1.0)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", law(), alert=10.0)
    return lm.Simulation(scene, time_step=1e-3)


def chain(**functions):
    law = type("SpoiltWire", (Wire,), {name: staticmethod(function) for name, function in functions.items()})
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    beads = [scene.add(lm.disk(radius=0.1, position=(0.0, -0.3 * i), mass=1.0)) for i in range(4)]
    beads[0].fix()
    scene.chain(beads, law())
    return lm.Simulation(scene, time_step=1e-3)


def react_raising(W, u, prepared):
    if u[0] + prepared[0] < -0.5:
        raise ValueError("closed too fast")
    return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


def helper(u):
    if not u > -0.5:
        raise AssertionError("in a helper")
    return u


def react_asserting(W, u, prepared):
    return (max(0.0, -helper(u[0] + prepared[0]) / W[0][0]),)


def react_nan(W, u, prepared):
    return (math.sqrt(u[0] + prepared[0] + 0.5) * 0.0 + max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


def prepare_nan(gap, reference_gap, velocity, time_step, parameters, state):
    return (gap / time_step if gap > 0.01 else math.nan,)


def prepare_raising(gap, reference_gap, velocity, time_step, parameters, state):
    if gap < 0.0:
        raise ValueError("overlap")
    return (gap / time_step,)


def slope_nan(W, u, prepared):
    return ((math.inf * u[0] - math.inf * u[0],),)


def slope_raising(W, u, prepared):
    if u[0] > 0.02:
        raise ZeroDivisionError("stretched")
    return ((-1.0 / W[0][0] if u[0] + prepared[0] > 0.0 else 0.0,),)


def energy_raising(gap, reference_gap, parameters, state):
    if gap < 0.1:
        raise ValueError("no energy here")
    return 0.0


STOPPED = [
    (ball, {"react": react_raising}, RuntimeError, r"react of law '\S+' between bodies 1 and 2 raised ValueError\('closed"),
    (ball, {"react": react_asserting}, RuntimeError, r"react of law '\S+' between bodies 1 and 2 raised AssertionError"),
    (ball, {"react": react_nan}, (FloatingPointError, RuntimeError), r"law '\S+' between bodies 1 and 2"),
    (ball, {"prepare": prepare_nan}, FloatingPointError, r"prepare of law '\S+' between bodies 1 and 2 returned .*: nan"),
    (ball, {"prepare": prepare_raising, "react": lambda W, u, prepared: (0.0,)}, RuntimeError,
     r"prepare of law '\S+' between bodies 1 and 2 raised ValueError\('overlap'\)"),
    (ball, {"energy": energy_raising}, RuntimeError, r"energy of law '\S+' between bodies 1 and 2 raised ValueError"),
    (chain, {"slope": slope_nan}, FloatingPointError, r"law '\S+' between bodies 1 and 0: .*slope returned \(\(nan,\),\)"),
    (chain, {"slope": slope_raising}, RuntimeError, r"slope of law '\S+' between bodies \d and \d raised ZeroDivision"),
]  # fmt: skip


@pytest.mark.default_parameters("-react--0-plain", "-prepare---plain")
@pytest.mark.parametrize("solver", [lm.GaussSeidel(), lm.AcceleratedGaussSeidel()], ids=["plain", "accelerated"])
@pytest.mark.parametrize(
    ("make", "functions", "kind", "words"), STOPPED, ids=lambda value: "-".join(value) if isinstance(value, dict) else ""
)
def test_a_faulty_law_stops_the_run(make, functions, kind, words, solver, capfd):
    sim = make(**functions)
    sim.solver = solver
    with pytest.raises(kind, match=r"^In the step from t = \S+ s .*" + words) as caught:
        sim.run(steps=STEPS)
    assert np.isfinite(sim.velocities).all()
    if kind is RuntimeError:
        assert isinstance(caught.value.__cause__, (ValueError, AssertionError, ZeroDivisionError))
    assert capfd.readouterr().err == "", "numba printed an exception that it could not hand on"


def react_none(W, u, prepared):
    """None only where the ball arrives: the first calls of a law in plain Python do not meet it."""
    if -1.1 < u[0] < -0.9:
        return None
    return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


def none_or_number(u):
    if -1.1 < u < -0.9:
        return None
    return u


def react_none_of_helper(W, u, prepared):
    return (max(0.0, -(none_or_number(u[0]) + prepared[0]) / W[0][0]),)


def react_testing_helper(W, u, prepared):
    reached = none_or_number(u[0])
    if reached is None:
        reached = u[0]
    return (max(0.0, -(reached + prepared[0]) / W[0][0]),)


def react_importing(W, u, prepared):
    import math

    return (math.fabs(u[0]),)


def prepare_none(gap, reference_gap, velocity, time_step, parameters, state):
    if 0.003 < gap < 0.005:
        return None
    return (max(gap, 0.0) / time_step,)


@pytest.mark.parametrize("name", ["react", "prepare"])
def test_a_law_that_returns_none_in_a_rare_case_is_refused(name, capfd):
    sim = ball(**{name: react_none if name == "react" else prepare_none})
    words = rf"cannot be compiled: {name}_none returns None in some cases: each way .* \(test_law_faults.py, line \d+\)"
    with pytest.raises(TypeError, match=words):
        sim.run(steps=STEPS)
    assert capfd.readouterr().err == ""


@pytest.mark.long
def test_a_helper_may_return_none_if_the_law_asks_for_it(capfd):
    """As it is used as a number, the run stops; where the law tests for None, it goes on as any other."""
    with pytest.raises(RuntimeError, match=r"react of law .\S+. between bodies 0 and 2 raised TypeError"):
        ball(react=react_none_of_helper).run(steps=STEPS)
    tested, plain = ball(react=react_testing_helper).run(steps=STEPS), ball().run(steps=STEPS)
    assert np.array_equal(tested.velocities, plain.velocities)
    assert capfd.readouterr().err == ""


def test_a_law_that_imports_in_a_function_is_named():
    with pytest.raises(TypeError, match="cannot be compiled: numba has no instruction IMPORT_NAME; imports stand at the"):
        ball(react=react_importing).run(steps=1)


def test_a_law_that_numba_refuses_is_named():
    sim = ball(react=lambda W, u, prepared: (max(u, key=str),))
    words = (
        r"Law 'test-spoilt' \(.*Spoilt\) cannot be compiled: No implementation of function .*max.* \(test_law_faults.py, "
    )
    with pytest.raises(TypeError, match=words + r"line \d+\)\. Its functions may use"):
        sim.run(steps=1)


def test_a_law_is_kept_to_its_pairs_of_contactors():
    class ForWalls(Contact):
        PAIRS = frozenset({("wall", "disk")})

    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.12), mass=1.0))
    scene.add(lm.disk(radius=0.1, position=(0.3, 0.12), mass=1.0, color="OTHER"))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", ForWalls())
    scene.see("WALL", "OTHER", ForWalls())
    scene.see("GRAIN", "OTHER", ForWalls())
    with pytest.raises(ValueError, match="is for contacts wall-disk, but 'GRAIN' sees 'OTHER' with a disk and a disk"):
        lm.Simulation(scene, time_step=1e-3)


def infinite(W, u, prepared):
    return (max(0.0, -(u[0] + prepared[0]) / W[0][0]) if u[0] > -0.51 else math.inf,)


def huge(W, u, prepared):
    return (max(0.0, -(u[0] + prepared[0]) / W[0][0]) if u[0] > -0.51 else 1e200,)


def raising(W, u, prepared):
    if u[0] <= -0.51:
        raise ValueError("too fast")
    return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


SOLVERS = [lm.GaussSeidel(), lm.AcceleratedGaussSeidel(), lm.Newton(), lm.Auto()]


@pytest.mark.long
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: type(solver).__name__)
@pytest.mark.parametrize("first", [True, False], ids=["first", "last"])
@pytest.mark.parametrize(
    ("react", "kind"), [(infinite, FloatingPointError), (huge, FloatingPointError), (raising, RuntimeError)]
)
def test_the_law_that_failed_is_named_and_not_one_that_was_asked_after_it(solver, first, react, kind):
    """Four balls side by side fall on a floor, one of them faster, and that one is beyond what the law of the floor bears.
    Before, the sentence named Coulomb's law between the balls, which returned zeros. A number whose square overflows is
    seen first in the velocities of the balls beside: it, too, is the fault of the law that returned it."""
    law = type("Spoilt", (Contact,), {"react": staticmethod(react)})
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(4):
        start = {"position": (0.19 * i, 0.0999), "velocity": (0.1, -0.52 if i == 1 else -0.49)}
        scene.add(lm.disk(radius=0.1, mass=1.0, **start))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    rows = [("GRAIN", "WALL", law()), ("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))]
    for row in rows if first else rows[::-1]:
        scene.see(*row)
    with pytest.raises(kind, match=r"In the step from t = 0 s .*'test-spoilt' between bodies 1 and 4") as told:
        lm.Simulation(scene, time_step=1e-3, solver=solver, overlap="ignore").step()
    words = {raising: "too fast", infinite: "react returned (inf,)", huge: "react returned (1e+200,)"}
    assert words[react] in str(told.value)
