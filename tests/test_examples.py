"""Every example runs as it stands, and its numbers agree with what is known beforehand."""

import ast
import re
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from forks import forked
from PIL import Image

from lmgcpy.cli import main
from lmgcpy.examples import EXAMPLES, GROUPS

ROOT = Path(__file__).parent.parent
PAGE = "".join((ROOT / "docs" / f"{page}.md").read_text("utf-8") for page in ("geotechnical_tests", "cookbook"))


def oedometer(found, rowe):
    """Statics of smooth disks, to the four digits that are printed; the solver has a tolerance of 1e-8."""
    assert found == pytest.approx(rowe, abs=1e-4)


def direct_shear(*numbers):
    """Statics of a row that climbs, at four ways; 1e-3 is left of its motion, and half of that with half the step."""
    assert numbers[::3] == (0.05, 0.1, 0.15, 0.2)
    assert numbers[1::3] == pytest.approx(numbers[2::3], abs=2e-3)


def simple_shear(_inertial, found, known):
    """da Cruz sheared between rough walls. Without walls tau / P is larger, by 0.01 to 0.05 for three seeds, and grows with
    I as theirs: at I = 0.02, 0.05 and 0.1 the means were 0.303, 0.335 and 0.390."""
    assert known == pytest.approx(0.305)
    assert 0.01 < found - known < 0.06


def pull_out(pull, _factor, known):
    """All grains at the strip slide, and the lids give their force: exact, to the tolerance of 1e-3."""
    assert pull == pytest.approx(known, rel=2e-3)


def triaxial(*numbers):
    """While the membrane takes up its pressure the packing lags behind by 1 %, then it agrees."""
    ratios, known, lateral = numbers[::3], numbers[1::3], numbers[2::3]
    assert ratios == pytest.approx(known, rel=0.015)
    assert ratios[-1] == pytest.approx(known[-1], rel=5e-3)
    assert lateral[1:] == pytest.approx([1.0, 1.0], abs=0.06)


def repose(found, known):
    """As in simple shear the layer has more friction than da Cruz found: by 2.1, 2.3 and 3.1 degrees for three seeds."""
    assert 0.0 < found - known < 4.0


def janssen(K, borne, known):
    """Four seeds: -0.1 to 4 % more than Janssen, K from 0.94 to 0.98."""
    assert 0.9 < K < 1.02
    assert borne == pytest.approx(known, rel=0.06)
    assert borne < 0.6


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


def thread(pull, friction, _pairs, expected):
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


def hourglass(early, _time, first, second):
    """The rate of an hourglass: counts of about 125 grains scatter by 11, and water would run slower by a third."""
    assert early > 20
    assert min(first, second) > 80
    assert second == pytest.approx(first, rel=0.2)


def pressure(xx, yy, xy):
    """Walls without friction: a mean stress of what is imposed [Pa], to the tolerance 1e-4 and the walls' last motion."""
    assert [xx, yy] == pytest.approx([-1e4, -1e4], rel=2e-3)
    assert abs(xy) < 1000.0


def cell(drive, work):
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


CHECKS = {
    **{"oedometer": oedometer, "direct-shear": direct_shear, "simple-shear": simple_shear, "pull-out": pull_out},
    **{"triaxial": triaxial, "biaxial": biaxial, "latex": latex, "angle-of-repose": repose, "silo": janssen},
    **{"drum": drum, "blades": blades, "hopper": hopper, "hourglass": hourglass},
    **{"thread": thread, "geogrid": geogrid, "capstan": capstan, "helix": helix, "sag": sag, "net": net},
    **{"rockfall": rockfall, "membrane": membrane, "pressure": pressure, "cell": cell, "clusters": clusters},
    **{"again": again, "sweep": sweep, "plank": plank, "weakening": weakening, "controller": controller},
}


def numbers(text):
    return [float(x) for x in re.findall(r"(?<![\w^])-?\d+\.?\d*(?:e[+-]?\d+)?", text)]


def test_every_example_has_its_check():
    assert CHECKS.keys() == EXAMPLES.keys()
    scripts = {path.name for path in (ROOT / "lmgcpy" / "examples").glob("[!_]*.py")}
    assert scripts == {example.file for example in EXAMPLES.values()}


def test_every_example_is_on_its_page_with_its_command():
    places = [PAGE.index(f"\n`lmgcpy example {name}`") for name in EXAMPLES]
    assert places == sorted(places)
    for example in EXAMPLES.values():
        assert f"```{{literalinclude}} ../lmgcpy/examples/{example.file}\n:language: python\n```" in PAGE
        assert (example.picture is None) != (f"(images/examples/{example.file[:-3]}.png)" in PAGE)


def test_a_geotechnical_test_has_at_most_fifty_lines_and_names_its_source():
    for example in GROUPS["Geotechnical tests"]:
        assert len(example.script.splitlines()) <= 50, example.name


def test_an_example_needs_the_public_face_alone():
    for example in EXAMPLES.values():
        nodes = [node for node in ast.walk(ast.parse(example.script)) if isinstance(node, ast.Import | ast.ImportFrom)]
        imports = {ast.unparse(node) for node in nodes}
        assert imports <= {"import math", "import numpy as np", "import lmgcpy as lm"}, example.name


@pytest.mark.default_parameters("oedometer", "direct-shear", "plank")
@pytest.mark.parametrize("name", EXAMPLES)
def test_example_runs_and_is_right(name, tmp_path):
    text = forked(EXAMPLES[name].script, folder=tmp_path).stdout
    CHECKS[name](*numbers(text))


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", ["simple-shear", "pull-out", "silo", "angle-of-repose"])
def test_what_is_random_is_right_for_other_seeds(name, seed, tmp_path):
    script = re.sub(r"^(seed\b.*?= )0,", rf"\g<1>{seed},", EXAMPLES[name].script, count=1, flags=re.M)
    assert script != EXAMPLES[name].script
    CHECKS[name](*numbers(forked(script, folder=tmp_path).stdout))


def test_the_list_has_a_line_for_each():
    lines = told().splitlines()
    for example in EXAMPLES.values():
        assert [line for line in lines if line.split() == [example.name, *example.line.split()]], example.name
        assert len(example.line) <= 85


def told(*arguments):
    done = CliRunner().invoke(main, ["example", *map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done.output


def test_an_example_leaves_its_script_and_its_picture(tmp_path):
    output = told("plank", "--out", tmp_path)
    speed, rolling = numbers(output.splitlines()[1])
    assert speed == pytest.approx(rolling, abs=1e-4)
    assert (tmp_path / "plank" / "plank.py").read_text("utf-8") == EXAMPLES["plank"].script
    with Image.open(tmp_path / "plank" / "plank.png") as picture:
        assert 100 < picture.width < 600
    done = CliRunner().invoke(main, ["example", "plank", "--out", str(tmp_path)])
    assert done.exit_code == 1
    assert "exists: remove it, or name another folder by --out." in done.output


def test_without_pyvista_an_example_runs_and_says_that_there_is_no_picture(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    output = told("plank", "--out", tmp_path)
    assert "rolling: 1.1184" in output
    assert "No picture was drawn: " in output
    assert [path.name for path in (tmp_path / "plank").iterdir()] == ["plank.py"]
