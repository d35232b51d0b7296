"""Every entry of the cookbook runs as it stands, and its numbers agree with what is known beforehand."""

import re
from pathlib import Path

import pytest
from forks import forked

PAGE = Path(__file__).parent.parent / "docs" / "cookbook.md"
ENTRIES = dict(re.findall(r"^## (.*?)\n.*?```python\n(.*?)```", PAGE.read_text("utf-8"), re.S | re.M))


def drum(torque, weight_and_lever):
    """Angular momentum: what the drum does is the moment of the weight, less what the grains keep, some percent in 1 s."""
    assert torque == pytest.approx(weight_and_lever, rel=0.05)
    assert torque > 1.0  # the grains are carried to one side


def blades(torque, weight_and_lever):
    """As above; 50 grains fall from blades, and their momentum is some percent of the moment in 0.6 s."""
    assert torque == pytest.approx(weight_and_lever, rel=0.05)
    assert torque > 0.05


def hopper(left, borne, weight):
    """At rest, to what is left of the motion of 84 grains."""
    assert left == 0
    assert borne == pytest.approx(weight, rel=0.02)


def drawn(pull, friction, _pairs, expected):
    """Statics, to the four digits that are printed; the solver has a tolerance of 1e-8."""
    assert [pull, friction] == pytest.approx([expected, expected], abs=2e-4)


def geogrid(pull, push):
    """Equilibrium of the grains, to their inertia. Five samples, at 0.2 and 0.4 ms, had a pull of 0.31 to 0.44."""
    assert pull == pytest.approx(push, rel=0.03)
    assert 0.2 < pull < 0.6


def capstan(ratio, euler):
    """48 segments: an error of (pi/48)^2, 0.4 %."""
    assert ratio == pytest.approx(euler, rel=4e-3)
    assert euler > 2.5


def helix(ratio, euler):
    """48 segments: an error of 0.5 %, of second order; the radius of the thread takes 0.2 % off."""
    assert ratio == pytest.approx(euler, rel=0.01)
    assert euler > 5.0


def sag(found, string):
    """To the waves that the drag has left. The ball is at a node: the polygon has the sag of the string there."""
    assert found == pytest.approx(string, rel=5e-3)


def net(depth, given, stored):
    """Links alone hold the ball at its lowest point; impacts of nodes took 4 %, and 6 % with twice the step."""
    assert depth > 0.2
    assert 0.94 * given < stored < given


def rockfall(slow, kept, thrown, back, fast, broken, through, expected):
    """A step of 0.5 ms loses 1 % of the speed, and links break at most a step late."""
    assert (slow, kept, fast, broken) == (1.8, 0.0, 3.0, 4.0)
    assert (thrown, back) == (pytest.approx(back, rel=0.015), slow)
    assert through == pytest.approx(expected, rel=0.015)
    assert expected < -2.0


def membrane(tension, laplace, top, arc):
    """An arc of 24 segments, (0.5 angle / 24)^2 off a circle, and what is left of its motion."""
    assert tension == pytest.approx(laplace, rel=3e-3)
    assert top == pytest.approx(arc, rel=2e-3)


def latex(lateral, pressure):
    """The virial of the pressure on the triangles, to the parts of the tube at its rims and what is left of its motion."""
    assert lateral == pytest.approx(pressure, rel=0.025)


def biaxial(lateral, axial):
    """The virial of the pressure, to the motion of the grains: 0.97 to 1.05 for four seeds and steps of 0.25 and 0.5 ms.
    Their axial stress was 1.5 to 2.0, and 1.2 without friction."""
    assert lateral == pytest.approx(1.0, abs=0.08)
    assert 1.3 < axial < 2.4


def silo(early, _time, first, second):
    """The rate of an hourglass: counts of about 125 grains scatter by 11, and water would run slower by a third."""
    assert early > 20
    assert min(first, second) > 80
    assert second == pytest.approx(first, rel=0.2)


def pressure(xx, yy, xy):
    """Walls without friction: a mean stress of what is imposed [Pa], to the tolerance 1e-4 and the walls' last motion."""
    assert [xx, yy] == pytest.approx([-1e4, -1e4], rel=2e-3)
    assert abs(xy) < 1000.0


def shear(drive, work):
    """The work of the cell, to the change of the volume in half a step and to what the grains' inertia takes."""
    assert drive == pytest.approx(work, rel=0.01)
    assert work > 20.0


def clusters(share):
    """At rest, to what is left of their motion."""
    assert share == pytest.approx(1.0, abs=2e-3)


def plank(speed, rolling):
    """2/3 g sin(slope) t, to the four digits that are printed."""
    assert speed == pytest.approx(rolling, abs=1e-4)


def again(level, still, tilted, moved):
    """What was at rest stays there: a hundredth of a radius, 4 to 6 mm. Tilted beyond the angle of friction it flows."""
    assert (level, tilted) == (0.0, 40.0)
    assert still < 0.04
    assert moved > 1.0


def sweep(*numbers):
    """Sliding, then rolling."""
    assert len(numbers) == 18
    assert numbers[1::3] == pytest.approx(numbers[2::3], abs=1e-4)
    assert len(set(numbers[1::3])) == 5


def controller(height, lift, weight):
    """What the controller has found out is the weight."""
    assert height == pytest.approx(0.5, abs=1e-3)
    assert lift == pytest.approx(weight, abs=2e-2)


def weakening(rest, pushed, start, expected):
    """Held by the static coefficient; with the sliding one it gains (tan - mu) g cos t."""
    assert rest == pytest.approx(0.0, abs=1e-4)
    assert pushed == pytest.approx(expected, abs=2e-4)
    assert pushed > start + 0.4


CHECKS = (
    *(drum, blades, hopper, drawn, geogrid, capstan, helix, sag, net, rockfall, membrane, latex, biaxial, silo, pressure),
    *(shear, clusters, plank, again, sweep, controller, weakening),
)


def test_every_entry_has_its_check():
    assert len(ENTRIES) == len(CHECKS) == PAGE.read_text("utf-8").count("```python")


@pytest.mark.default_parameters("plank")
@pytest.mark.parametrize("number", [pytest.param(k, id=check.__name__) for k, check in enumerate(CHECKS)])
def test_entry_runs_and_is_right(number, tmp_path):
    text = forked(list(ENTRIES.values())[number], folder=tmp_path).stdout
    CHECKS[number](*(float(x) for x in re.findall(r"(?<![\w^])-?\d+\.?\d*(?:e[+-]?\d+)?", text)))
