"""``lmgcpy laws`` and ``lmgcpy plugin new``: what they say, and that a new plug-in passes its own tests."""

import re
import subprocess
import sys

import pytest
from click.testing import CliRunner
from distribution import environment, install

import lmgcpy as lm
from lmgcpy.cli import main


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def child(*arguments, folders):
    command = [sys.executable, "-m", "lmgcpy.cli", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, env=environment(*folders), timeout=120)


def test_every_law_is_listed_with_parameters_units_pairs_and_distribution():
    lines = {line.split()[0]: line for line in run("laws").output.splitlines()}
    assert set(lm.laws.names()) <= set(lines)
    assert "friction [-], restitution [-]" in lines["restitution"]
    for pair in ("disk-disk", "disk-wall", "sphere-cylinder", "sphere-plane", "sphere-sphere"):
        assert pair in lines["coulomb"]
    assert f"lmgcpy {lm.__version__}" in lines["coulomb"]


def test_a_law_tells_all_about_itself():
    told = run("laws", "voigt-wire").output
    for words in ("stiffness [N/m], above 0, may be left out:", "slope, energy", "pull", "two bodies"):
        assert words in told
    assert "predicted gap exceeds the reference" in told  # of its docstring


def test_an_unknown_law_or_parameter_gets_the_closest_name():
    for arguments, words in (
        (("laws", "colomb"), "coulomb"),
        (("laws", "coulomb", "--check", "--set", "fricton=1"), "friction"),
        (("laws", "coulomb", "--check", "--set", "friction=much"), "PARAMETER=VALUE"),
        (("laws", "--check"), "name it"),
    ):
        done = run(*arguments)
        assert done.exit_code != 0
        assert words in done.output
        assert "Traceback" not in done.output


BROKEN = "import a_module_that_is_nowhere\n"
RIVAL = """
import lmgcpy as lm

class Rival(lm.Coulomb):
    NAME = "coulomb"

@lm.laws.hook
def lmgcpy_laws(register):
    register(Rival)
"""
LATE = """
import lmgcpy as lm

class Late(lm.Coulomb):
    NAME = "late"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state, pair, temperature):
        return (0.0,)

@lm.laws.hook
def lmgcpy_laws(register):
    register(Late)
"""


FAILED = pytest.mark.parametrize(
    ("text", "words"),
    [
        pytest.param(BROKEN, ["ModuleNotFoundError: No module named 'a_module_that_is_nowhere'"], id="broken"),
        pytest.param(
            RIVAL,
            ["Law 'coulomb' is there twice", "from lmgcpy (Coulomb)", "from lmgcpy-law-test 1.2 (Rival)"],
            id="rival",
        ),
        pytest.param(
            LATE, ["Law class Late: prepare must take (gap, ", "state, pair), but it takes (gap, "], id="late"
        ),
    ],
)


@FAILED
@pytest.mark.default_parameters("late")
def test_plug_ins_that_failed_to_load_are_listed_with_the_reason(tmp_path, text, words):
    folder = install(tmp_path / "site", "lmgcpy-law-test", "lmgcpy_law_test", text)
    told = child("laws", folders=[folder])
    assert told.returncode == 0, told.stderr
    assert "Plug-in lmgcpy-law-test 1.2 (lmgcpy-law-test) failed to load:" in told.stdout
    for word in words:
        assert word in told.stdout


@pytest.mark.long
@FAILED
def test_an_unknown_law_may_be_that_of_a_plug_in_that_failed_to_load(tmp_path, text, words):
    asked = child("laws", "late", folders=[install(tmp_path / "site", "lmgcpy-law-test", "lmgcpy_law_test", text)])
    assert asked.returncode != 0
    assert "There is no law 'late'" in asked.stderr
    assert words[0].split(":")[0] in asked.stderr


@pytest.mark.long
@pytest.mark.parametrize("kind", ["contact", "link"])
def test_a_new_plug_in_passes_its_own_tests(tmp_path, kind):
    done = run("plugin", "new", "sticky-tape", "--kind", kind, "--into", tmp_path)
    assert done.exit_code == 0, done.output
    target = tmp_path / "lmgcpy-law-sticky-tape"
    # as pip would: its source on the path, its entry point in the metadata
    site = install(tmp_path / "site", "lmgcpy-law-sticky-tape", "lmgcpy_law_sticky_tape", version="0.1.0")
    folders = [target / "src", site]
    listed = child("laws", folders=folders)
    assert re.search(r"^sticky-tape +" + kind + ".*lmgcpy-law-sticky-tape 0.1.0$", listed.stdout, re.MULTILINE)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(target)]
    tests = subprocess.run(command, capture_output=True, text=True, env=environment(*folders), cwd=target, timeout=300)
    assert tests.returncode == 0, tests.stdout + tests.stderr
    block = re.search(r"```python\n(.*?)```", (target / "README.md").read_text(), re.DOTALL)
    assert block is not None
    script = subprocess.run([sys.executable, "-c", block[1]], capture_output=True, text=True, env=environment(*folders))
    assert script.returncode == 0, script.stderr
    again = run("plugin", "new", "sticky-tape", "--into", tmp_path)
    assert again.exit_code != 0
    assert "exists" in again.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("Sticky",), "small letters"),
        (("sticky_tape",), "joined by hyphens"),
        (("class",), "small letters"),
        (("coulomb",), "There is a law 'coulomb' already, from lmgcpy"),
        (("tape", "--kind", "glue"), "contact or link"),
        (("tape", "--into", "nowhere"), "There is no folder 'nowhere'"),
    ],
)
def test_a_name_that_cannot_be_is_refused(arguments, words):
    done = run("plugin", "new", *arguments)
    assert done.exit_code != 0
    assert words in done.output
    assert "Traceback" not in done.output
